"""Draws the picture of the README: ``python docs/make_pictures.py pymeshfair_demo``.

Needs the `report` extra, and the folder that ``pymeshfair demo`` writes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pymeshlab

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from painting import paint, picture, read_mesh

PICTURES = Path(__file__).parent / "pictures"


def before_and_after(before: Path, after: Path, path: Path) -> None:
    """Two halves of one face: as scanned and as cleaned, whole and as a close-up."""
    whole, detail = (-76.0, 56.0, -100.0, 90.0), (-12.0, 44.0, -28.0, 52.6)
    scan, cleaned = read_mesh(before), read_mesh(after)

    def draw(axes: Any) -> None:
        for place, mesh, window, title in zip(
            axes[0], (scan, cleaned, scan, cleaned), (whole, whole, detail, detail), ("scan", "cleaned") * 2, strict=True
        ):
            paint(place, *mesh, window)
            place.set_title(title, fontsize=12)

    picture(path, draw, rows=1, columns=4, size=(12, 4.5))


if __name__ == "__main__":
    scan = Path(pymeshlab.__file__).parent / "tests/sample_meshes/rangemaps/face000.ply"
    before_and_after(scan, Path(sys.argv[1]) / "face_clean.ply", PICTURES / "demo.png")
