"""The documentation says what is true today."""

import re
from pathlib import Path

import pytest
from pages import PAGES
from PIL import Image

from pymeshfair.recipe import shipped_recipes

PROJECT = Path(__file__).parents[1]
DOCS = PROJECT / "docs"


@pytest.mark.parametrize("name", sorted(PAGES))
def test_pages_are_current(name: str) -> None:
    """Each generated page is what its generator writes now; `python tools/generate.py pages` renews it."""
    assert (DOCS / name).read_text(encoding="utf-8") == PAGES[name]()


@pytest.mark.parametrize(
    "page",
    [
        "README.md",
        "CONTRIBUTING.md",
        "docs/architecture.md",
        "docs/filters.md",
        "docs/recipes.md",
        "docs/old_scripts.md",
        "docs/denoising.md",
        "docs/spectral.md",
        "docs/curves.md",
        "docs/fairing.md",
        "docs/robust.md",
        "docs/batch.md",
        "docs/scale.md",
        "docs/looking.md",
        "docs/performance.md",
        "docs/solvers.md",
        "docs/trust.md",
        "docs/tutorials.md",
        "docs/command_line.md",
        "docs/documents.md",
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


def test_the_way_of_a_parameter_is_short_and_its_modules_exist() -> None:
    """The page on architecture names at most 11 modules between the command and the kernel, each of which is there."""
    way = re.findall(r"^\| \d+ \| `(\S+)` \|", (DOCS / "architecture.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert 8 <= len(way) <= 11
    assert not [module for module in way if not (PROJECT / module).is_file()]


def test_the_diagram_of_the_host_is_complete() -> None:
    """The diagram has every room of the host, and every room of the diagram is there."""
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    labels = " ".join(re.findall(r'\["([^":=]+):', text))
    drawn = set(re.findall(r"\w+", labels)) - {"plugins", "filters"}
    host = PROJECT / "src/pymeshfair"
    there = {p.stem for p in host.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()}
    assert drawn == there - {"__init__", "__main__", "filters", "plugins", "mlx_scripts", "__pycache__"}


@pytest.mark.parametrize("name", shipped_recipes())
def test_every_recipe_has_a_small_picture_of_before_and_after(name: str) -> None:
    """It is there, 480 pixels wide and smaller than 60 kB, and the page shows it."""
    path = DOCS / "pictures/recipes" / f"{name}.png"
    assert path.stat().st_size < 60_000
    with Image.open(path) as picture:
        assert picture.width == 480
    assert f"(pictures/recipes/{name}.png)" in (DOCS / "recipes.md").read_text(encoding="utf-8")
