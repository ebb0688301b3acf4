"""Draws the pictures of the README and of the page on spectral filters: ``python docs/make_pictures.py [pymeshfair_demo]``.

Needs the `report` extra. That of the README is drawn only if the folder is given that ``pymeshfair demo`` writes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab

from pymeshfair import MeshSet
from pymeshfair.commands.spectrum_picture import draw_spectra
from pymeshfair.filters.spectral.harmonics import manifold_harmonics
from pymeshfair.filters.spectral.responses import low_pass

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from painting import Floats, Ints, paint, picture, read_mesh, whole

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
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


def rebuilt_from_modes(mesh: Path, counts: tuple[int, ...], path: Path) -> None:
    """One shape as the sum of its 5, 20, 100 ... lowest modes, and as it is."""
    vertices, faces = read_mesh(mesh)
    harmonics = manifold_harmonics(vertices, faces, count=max(counts))
    coefficients = harmonics.transform(vertices)
    shapes = [(f"{count} modes", harmonics.inverse(coefficients[:count])) for count in counts]
    row(path, [*shapes, (f"all {len(vertices):,}", vertices)], faces)


def equaliser(mesh: Path, path: Path) -> None:
    """One shape with its small waves removed, as it is, and with the middle ones made stronger."""
    shapes = []
    for title, parameters in (
        ("low_pass, 40edge", {"detail_size": "40edge"}),
        ("low_pass, 12edge", {"detail_size": "12edge"}),
        ("as scanned", None),
        ("enhance, 12edge to 48edge", {"response": "enhance", "detail_size": "12edge"}),
    ):
        meshes = MeshSet()
        meshes.load_new_mesh(str(mesh))
        if parameters is not None:
            meshes.apply_filter("apply_coord_spectral_filter", **parameters)
        shapes.append((title, meshes.current_mesh().vertex_matrix()))
    row(path, shapes, read_mesh(mesh)[1])


def row(path: Path, shapes: list[tuple[str, Floats]], faces: Ints) -> None:
    """Shapes of the same triangles side by side, in the window of the last one."""

    def draw(axes: Any) -> None:
        for place, (title, vertices) in zip(axes[0], shapes, strict=True):
            paint(place, vertices, faces, whole(np.concatenate([shape for _, shape in shapes])))
            place.set_title(title, fontsize=11, y=0.97)

    picture(path, draw, rows=1, columns=len(shapes), size=(12, 12 / len(shapes) + 0.5))


def spectrum_before_and_after(mesh: Path, path: Path) -> None:
    """The spectrum of a scan before and after the low pass whose response is drawn over both."""
    meshes = MeshSet()
    meshes.load_new_mesh(str(mesh))
    before = meshes.apply_filter("get_surface_spectrum")
    cutoff = meshes.apply_filter("apply_coord_spectral_filter", detail_size="12edge")["detail_size"]
    draw_spectra(path, {"before": before, "after": meshes.apply_filter("get_surface_spectrum")}, low_pass(cutoff))


if __name__ == "__main__":
    bunny = SAMPLES / "bunny.obj"
    rebuilt_from_modes(bunny, (5, 20, 100, 500), PICTURES / "modes.png")
    equaliser(bunny, PICTURES / "equaliser.png")
    spectrum_before_and_after(bunny, PICTURES / "spectrum.png")
    if len(sys.argv) > 1:
        before_and_after(SAMPLES / "rangemaps/face000.ply", Path(sys.argv[1]) / "face_clean.ply", PICTURES / "demo.png")
