"""The documentation says what is true today."""

import re
from pathlib import Path

import pytest
from pages import PAGES

PROJECT = Path(__file__).parents[1]
DOCS = PROJECT / "docs"


@pytest.mark.parametrize("name", ["filters.md", "recipes.md"])
def test_pages_are_current(name: str) -> None:
    """Each generated page is what its generator writes now; `python tools/generate.py pages` renews it."""
    assert (DOCS / name).read_text(encoding="utf-8") == PAGES[name]()


@pytest.mark.parametrize(
    "page",
    [
        "README.md",
        "CONTRIBUTING.md",
        "docs/filters.md",
        "docs/recipes.md",
        "docs/denoising.md",
        "docs/spectral.md",
        "docs/curves.md",
        "docs/fairing.md",
        "docs/robust.md",
        "docs/solvers.md",
    ],
)
def test_links_lead_somewhere(page: str) -> None:
    """Every relative link of a page names a file of the project, and its anchor exists."""
    text = (PROJECT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)]+)\)", text):
        path, _, anchor = target.partition("#")
        file = (PROJECT / page).parent / path if path else PROJECT / page
        assert file.exists(), target
        if anchor:
            assert f'id="{anchor}"' in file.read_text(encoding="utf-8"), target
