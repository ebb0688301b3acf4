"""The pictures of the pages are those that tools/pictures.py and the examples draw."""

from __future__ import annotations

import re
import runpy
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pictures
import pytest
import site_pages
from numpy.typing import NDArray
from PIL import Image

ROOT = Path(__file__).parent.parent
REFERENCES = ROOT / "docs/pictures"
BUNNY = pictures.SAMPLES / "bunny.obj"
DRAWN: dict[str, Callable[[], None]] = {
    "equaliser": lambda: pictures.equaliser(BUNNY),
    "regions": lambda: pictures.regions(BUNNY),
    "holes": pictures.holes,
    "features": pictures.features,
    "necks": pictures.necks,
    "curves": lambda: pictures.curves(BUNNY),
}
EXAMPLES = ("tangential_drift", "taubin_against_laplacian", "mesh_independence", "bending_energies", "orders_of_fairing")
#: pixels of a block whose mean is compared: noise and fonts may differ by a pixel, what is seen may not
BLOCK = 10


def blocks(path: Path) -> NDArray[np.float64]:
    """The mean grey of every block of a picture."""
    with Image.open(path) as picture:
        grey = np.asarray(picture.convert("L"), dtype=np.float64)
    height, width = (BLOCK * (size // BLOCK) for size in grey.shape)
    return np.asarray(grey[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK).mean(axis=(1, 3)))


def assert_same_structure(drawn: Path, reference: Path) -> None:
    """Both have the same size and, block by block, the same brightness."""
    found, expected = blocks(drawn), blocks(reference)
    assert found.shape == expected.shape
    assert expected.std() > 10
    assert np.abs(found - expected).mean() < 3.0
    assert np.abs(found - expected).max() < 60


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWN)
def test_pictures_of_the_pages(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawn again, each shows what it shows in docs/."""
    monkeypatch.setattr(pictures, "PICTURES", tmp_path)
    DRAWN[name]()
    assert_same_structure(tmp_path / f"{name}.png", REFERENCES / f"{name}.png")


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_pictures_of_the_examples(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The scripts are short, run as they are, and draw what docs/examples.md shows."""
    script = ROOT / f"examples/{name}.py"
    assert len(script.read_text("utf-8").splitlines()) < 40
    monkeypatch.setattr(sys, "argv", [str(script), str(tmp_path / "out.png")])
    runpy.run_path(str(script), run_name="__main__")
    assert_same_structure(tmp_path / "out.png", REFERENCES / f"{name}.png")


def test_every_picture_is_shown_and_small() -> None:
    """Each picture in docs/ stands on a page, with words for those who do not see it, and is below 300 kB."""
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    shown = {
        name for page in pages for name in re.findall(r"!\[[^\]]{20,}\]\((?:docs/)?pictures/([^)]+)\)", page.read_text("utf-8"))
    }
    of_filters = "".join(map(site_pages.filter_page, site_pages.own_filters()))
    shown |= set(re.findall(r"!\[[^\]]{20,}\]\(\.\./pictures/([^)]+)\)", of_filters))
    kept = {path.relative_to(REFERENCES).as_posix(): path for path in REFERENCES.rglob("*.*")}
    assert set(kept) == shown
    assert not [name for name, path in kept.items() if path.stat().st_size > 300_000]
