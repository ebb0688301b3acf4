"""Draws the pictures of the README and of the pages: ``python tools/pictures.py [pymeshfair_demo]``.

Needs the `report` extra. That of the README is drawn only if the folder is given that ``pymeshfair demo`` writes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
import pymeshlab

from pymeshfair import MeshSet
from pymeshfair.commands.spectrum_picture import draw_spectra
from pymeshfair.filters.fairing import ENERGIES, blend_parts, fair_region
from pymeshfair.filters.holes import close_holes
from pymeshfair.filters.spectral import low_pass, manifold_harmonics

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from denoising_findings import chest
from painting import FROM_A_CORNER, Bools, Floats, Ints, paint, picture, read_mesh, whole

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
PICTURES = Path(__file__).parents[1] / "docs/pictures"


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


#: a title, vertices, faces, and which faces are tinted
Panel: TypeAlias = tuple[str, Floats, Ints, Bools | None]


def panels(path: Path, shown: list[Panel], *, turn: Floats | None = None, height: float = 3.5) -> None:
    """Meshes side by side in one window, turned first."""
    turn = np.eye(3) if turn is None else turn
    window = whole(np.concatenate([vertices @ turn.T for _, vertices, _, _ in shown]))

    def draw(axes: Any) -> None:
        for place, (title, vertices, faces, marked) in zip(axes[0], shown, strict=True):
            paint(place, vertices @ turn.T, faces, window, marked)
            place.set_title(title, fontsize=11)

    picture(path, draw, rows=1, columns=len(shown), size=(12, height))


def tilted(angle: float) -> Floats:
    """The rotation that shows the z axis upwards, seen from `angle` above the horizon, in radians."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, s, c], [0, -c, s]])


def cap(path: Path) -> None:
    """A sphere whose top was cut off and filled flat, and what the three energies make of the filling."""
    vertices, faces = sphere(5)
    rim = 0.85
    top = (vertices[:, 2] > 0) & (np.hypot(vertices[:, 0], vertices[:, 1]) < rim)
    vertices[top, 2] = np.sqrt(1 - rim**2)
    marked: Bools = np.any(top[faces], axis=1, out=np.empty(len(faces), dtype=np.bool_))
    faired: list[Panel] = [
        (energy, fair_region(vertices, faces, top, energy=energy).vertices, faces, marked) for energy in ENERGIES
    ]
    panels(path, [("filled flat", vertices, faces, marked), *faired], turn=tilted(0.35))


def sphere(subdivisions: int) -> tuple[Floats, Ints]:
    """The unit sphere."""
    meshes = pymeshlab.MeshSet()
    meshes.create_sphere(radius=1.0, subdiv=subdivisions)
    mesh = meshes.current_mesh()
    return np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def regions(mesh: Path, path: Path) -> None:
    """The haunch and the ears of a bunny, marked, and as the three energies continue what is around them."""
    vertices, faces = read_mesh(mesh)
    x, y, z = vertices.T
    ears = ((y > 0.445) & (x < 0.4)) | ((y > 0.39) & (0.9 * (x - 0.2) + y - 0.4 > 0))
    marked = ears | ((np.hypot(x - 0.375, y - 0.125) < 0.105) & (z > 0.36))
    inside = marked[faces].all(axis=1)
    faired = [(energy, fair_region(vertices, faces, marked, energy=energy).vertices, faces, inside) for energy in ENERGIES]
    panels(path, [("marked", vertices, faces, inside), *faired])


def necks(path: Path) -> None:
    """Two open tubes and the three necks between them."""
    c, s = np.cos(0.9), np.sin(0.9)
    low, faces = tube(64, 20, radius=1.0, length=2.0)
    high, more = tube(44, 14, radius=0.6, length=1.5)
    vertices = np.concatenate([low, high @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) + [0.7, 0.0, 3.2]])
    faces = np.concatenate([faces, more + np.int32(len(low))])
    shown: list[Panel] = [("two parts", vertices, faces, None)]
    for energy in ENERGIES:
        blend = blend_parts(vertices, faces, energy=energy)
        joined = np.concatenate([faces, blend.faces])
        shown.append((energy, np.concatenate([vertices, blend.vertices]), joined, np.arange(len(joined)) >= len(faces)))
    panels(path, shown, turn=tilted(0.35), height=5.0)


def holes(scan: Path, path: Path) -> None:
    """A range map, and the same with the holes inside it closed."""
    vertices, faces = read_mesh(scan)
    filling = close_holes(vertices, faces, max_edges=300)
    closed = np.concatenate([faces, filling.new_faces])
    window = (-76.0, 56.0, -100.0, 90.0)

    def draw(axes: Any) -> None:
        paint(axes[0][0], vertices, faces, window)
        paint(axes[0][1], np.concatenate([vertices, filling.new_vertices]), closed, window, np.arange(len(closed)) >= len(faces))
        for place, title in zip(axes[0], ("scan", "holes of up to 300 edges closed"), strict=True):
            place.set_title(title, fontsize=11)

    picture(path, draw, rows=1, columns=2, size=(8, 6.2))


def features(path: Path) -> None:
    """A noisy chest with rounded and sharp edges, smoothed alike everywhere and with its ridges spared."""
    shape = chest(24)
    shown: list[Panel] = [("noise of 0.3 edges", shape.noisy, shape.faces, None)]
    choices: tuple[Literal["none", "curvature"], ...] = ("none", "curvature")
    for spared in choices:
        meshes = MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(shape.noisy, shape.faces))
        meshes.apply_coord_bilaplacian_smoothing(detail_size="8edge", features=spared)
        shown.append((f"features {spared}", meshes.current_mesh().vertex_matrix(), shape.faces, None))
    panels(path, [*shown, ("true", shape.truth, shape.faces, None)], turn=FROM_A_CORNER, height=4.0)


def tube(around: int, along: int, *, radius: float, length: float) -> tuple[Floats, Ints]:
    """An open cylinder from z = 0 to `length`."""
    angle, z = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0, length, along + 1))
    vertices = np.column_stack([radius * np.cos(angle).ravel(), radius * np.sin(angle).ravel(), z.ravel()])
    i, j = (index.ravel() for index in np.meshgrid(np.arange(around), np.arange(along)))
    a, b = j * around + i, j * around + (i + 1) % around
    faces = np.concatenate([np.column_stack([a, b, b + around]), np.column_stack([a, b + around, a + around])])
    return vertices, faces.astype(np.int32)


if __name__ == "__main__":
    bunny = SAMPLES / "bunny.obj"
    rebuilt_from_modes(bunny, (5, 20, 100, 500), PICTURES / "modes.png")
    equaliser(bunny, PICTURES / "equaliser.png")
    spectrum_before_and_after(bunny, PICTURES / "spectrum.png")
    cap(PICTURES / "energies.png")
    regions(bunny, PICTURES / "regions.png")
    holes(SAMPLES / "rangemaps/face000.ply", PICTURES / "holes.png")
    features(PICTURES / "features.png")
    necks(PICTURES / "necks.png")
    if len(sys.argv) > 1:
        before_and_after(SAMPLES / "rangemaps/face000.ply", Path(sys.argv[1]) / "face_clean.ply", PICTURES / "demo.png")
