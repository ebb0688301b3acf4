"""Draws the pictures of the README and of the pages: ``python tools/pictures.py [pymeshfair_demo]``.

Those of the README and of docs/looking.md are drawn only if the folder is given that ``pymeshfair demo`` writes. The pictures of
docs/examples.md are drawn by the scripts in examples/, those of docs/recipes.md by tools/recipe_pictures.py.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from pymeshfair import MeshSet, run
from pymeshfair.filters.fairing import ENERGIES, blend_parts, fair_region
from pymeshfair.filters.holes import close_holes
from pymeshfair.filters.spectral import lowest_eigenpairs, spectral_problem
from pymeshfair.looking.picture import Appearance

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from denoising_findings import chest
from panels import Panel, draw_panels, save_picture

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
FACE = SAMPLES / "rangemaps/face000.ply"
PICTURES = Path(__file__).parents[1] / "docs/pictures"
#: seen a little from above, z upright
TILTED = Appearance(elevation=20.0, up="z", width=300, height=340)
#: seen from a corner and from above, so that a box shows three sides
CORNER = Appearance(azimuth=-33.0, elevation=25.0, up="z", width=300, height=300)


def read(path: Path) -> tuple[Floats, Ints]:
    """Vertices and faces of a sample."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    return np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def square(side: int, **more: Any) -> Appearance:
    """Panels of so many pixels each way."""
    return Appearance(**{"width": side, "height": side, **more})


def before_and_after(after: Path) -> None:
    """A face as scanned and as cleaned, whole and as a close-up; how far it moves with details of 10 edges smoothed."""
    shown = [Panel("scan", *read(FACE)), Panel("cleaned", *read(after))]
    whole = Appearance(centre=(-10.0, -5.0, -800.0), extent=150.0, width=300, height=380)
    detail = Appearance(centre=(16.0, 12.0, -800.0), extent=58.0, width=300, height=380)
    left, right = draw_panels(shown, whole), draw_panels(shown, detail)
    save_picture(PICTURES / "demo.png", left, right, across=True)
    smoother = run("clean_range_map", FACE, after.with_name("smoother.ply"), set=["detail_size=10edge"], overwrite=True).output
    moved = [shown[0], Panel("cleaned, detail_size=10edge", *read(smoother))]
    save_picture(PICTURES / "displacement.png", draw_panels(moved, square(360, color="distance")), full_color=True)


def rebuilt_from_modes(mesh: Path, counts: tuple[int, ...]) -> None:
    """One shape as the sum of its 5, 20, 100 ... lowest modes, and as it is."""
    vertices, faces = read(mesh)
    problem = spectral_problem(vertices, faces)
    _, modes = lowest_eigenpairs(problem, max(counts))
    coefficients = modes.T @ (problem.mass[:, None] * vertices[problem.vertices])
    shown = [Panel(f"{n} modes", problem.on_mesh(modes[:, :n] @ coefficients[:n]), faces) for n in counts]
    save_picture(
        PICTURES / "modes.png", draw_panels([*shown, Panel(f"all {len(vertices):,}", vertices, faces)], square(240, columns=5))
    )


def equaliser(mesh: Path) -> None:
    """One shape with its small waves removed, as it is, and with the middle ones made stronger."""
    vertices, faces = read(mesh)
    shown = []
    for title, parameters in (
        ("low_pass, 40edge", {"detail_size": "40edge"}),
        ("low_pass, 12edge", {"detail_size": "12edge"}),
        ("as scanned", None),
        ("enhance, 12edge to 48edge", {"response": "enhance", "detail_size": "12edge"}),
    ):
        shape = vertices if parameters is None else filtered(vertices, faces, "apply_coord_spectral_filter", **parameters)
        shown.append(Panel(title, shape, faces))
    save_picture(PICTURES / "equaliser.png", draw_panels(shown, square(300)))


def filtered(vertices: Floats, faces: Ints, name: str, **parameters: Any) -> Floats:
    """The vertices after a filter."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.apply_filter(name, **parameters)
    found: Floats = meshes.current_mesh().vertex_matrix()
    return found


def spectrum_before_and_after(mesh: Path) -> None:
    """The spectrum of a scan before and after a low pass."""
    from pymeshfair.commands.spectrum import draw_spectra

    meshes = MeshSet()
    meshes.load_new_mesh(str(mesh))
    before = meshes.apply_filter("get_surface_spectrum")
    meshes.apply_filter("apply_coord_spectral_filter", detail_size="12edge")
    spectra = {"before": before, "after": meshes.apply_filter("get_surface_spectrum")}
    (PICTURES / "spectrum.png").write_bytes(draw_spectra(spectra, "png"))


def regions(mesh: Path) -> None:
    """The haunch and the ears of a bunny, marked, and as the three energies continue what is around them."""
    vertices, faces = read(mesh)
    x, y, z = vertices.T
    ears = ((y > 0.445) & (x < 0.4)) | ((y > 0.39) & (0.9 * (x - 0.2) + y - 0.4 > 0))
    marked = ears | ((np.hypot(x - 0.375, y - 0.125) < 0.105) & (z > 0.36))
    inside = marked[faces].all(axis=1)
    shown = [Panel("marked", vertices, faces, marked=inside)]
    shown += [
        Panel(energy, fair_region(vertices, faces, marked, energy=energy).vertices, faces, marked=inside) for energy in ENERGIES
    ]
    save_picture(PICTURES / "regions.png", draw_panels(shown, square(300)))


def necks() -> None:
    """Two open tubes and the three necks between them."""
    c, s = np.cos(0.9), np.sin(0.9)
    low, faces = tube(64, 20, radius=1.0, length=2.0)
    high, more = tube(44, 14, radius=0.6, length=1.5)
    vertices = np.concatenate([low, high @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) + [0.7, 0.0, 3.2]])
    faces = np.concatenate([faces, more + np.int32(len(low))])
    shown = [Panel("two parts", vertices, faces)]
    for energy in ENERGIES:
        blend = blend_parts(vertices, faces, energy=energy)
        joined = np.concatenate([faces, blend.faces])
        added = np.arange(len(joined)) >= len(faces)
        shown.append(Panel(energy, np.concatenate([vertices, blend.vertices]), joined, marked=added))
    save_picture(PICTURES / "necks.png", draw_panels(shown, TILTED))


def holes() -> None:
    """A range map, and the same with the holes inside it closed."""
    vertices, faces = read(FACE)
    filling = close_holes(vertices, faces, max_edges=300)
    closed = np.concatenate([faces, filling.new_faces])
    added = np.arange(len(closed)) >= len(faces)
    shown = [
        Panel("scan", vertices, faces),
        Panel("holes of up to 300 edges closed", np.concatenate([vertices, filling.new_vertices]), closed, marked=added),
    ]
    window = Appearance(centre=(-10.0, -5.0, -800.0), extent=150.0, width=360, height=440)
    save_picture(PICTURES / "holes.png", draw_panels(shown, window))


def features() -> None:
    """A noisy chest with rounded and sharp edges, smoothed alike everywhere and with its ridges spared."""
    shape = chest(24)
    shown = [Panel("noise of 0.3 edges", shape.noisy, shape.faces)]
    choices: tuple[Literal["none", "curvature"], ...] = ("none", "curvature")
    for spared in choices:
        name, how = "apply_coord_bilaplacian_smoothing", {"detail_size": "8edge", "features": spared}
        shown.append(Panel(f"features {spared}", filtered(shape.noisy, shape.faces, name, **how), shape.faces))
    save_picture(PICTURES / "features.png", draw_panels([*shown, Panel("true", shape.truth, shape.faces)], CORNER))


def tube(around: int, along: int, *, radius: float, length: float) -> tuple[Floats, Ints]:
    """An open cylinder from z = 0 to `length`."""
    angle, z = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0, length, along + 1))
    vertices = np.column_stack([radius * np.cos(angle).ravel(), radius * np.sin(angle).ravel(), z.ravel()])
    i, j = (index.ravel() for index in np.meshgrid(np.arange(around), np.arange(along)))
    a, b = j * around + i, j * around + (i + 1) % around
    faces = np.concatenate([np.column_stack([a, b, b + around]), np.column_stack([a, b + around, a + around])])
    return vertices, faces.astype(np.int32)


#: how a section of the bunny with noise is smoothed, by its title
CURVES: dict[str, dict[str, Any]] = {
    "section with noise": {},
    "explicit, 200 iterations": {"method": "explicit", "weights": "uniform", "iterations": 200},
    "taubin, 200 iterations": {"method": "taubin", "weights": "uniform", "iterations": 200},
    "implicit, detail_size 30edge": {"detail_size": "30edge"},
}


def curves(mesh: Path) -> None:
    """A section with noise of half an edge, and what each method makes of it, in red; the clean section behind."""
    meshes = MeshSet()
    meshes.load_new_mesh(str(mesh))
    meshes.generate_polyline_from_planar_section(planeaxis="Z Axis", relativeto="Bounding box center")
    section = meshes.current_mesh()
    clean, edges = section.vertex_matrix(), section.edge_matrix()
    spread = 0.5 * np.linalg.norm(clean[edges[:, 1]] - clean[edges[:, 0]], axis=1).mean()
    noisy = clean + np.random.default_rng(0).normal(scale=spread, size=clean.shape) * [1, 1, 0]
    behind = clean - [0.0, 0.0, 0.1]
    colors = np.repeat([[0.55, 0.6, 0.65], [0.75, 0.1, 0.1]], len(clean), axis=0)
    shown = []
    for title, parameters in CURVES.items():
        shape = noisy
        if parameters:
            meshes = MeshSet()
            meshes.add_mesh(pymeshlab.Mesh(noisy, edge_matrix=edges))
            meshes.apply_filter("apply_coord_curve_smoothing", **parameters)
            shape = meshes.current_mesh().vertex_matrix()
        both = np.concatenate([behind, shape])
        shown.append(Panel(title, both, edges=np.concatenate([edges, edges + len(clean)]), colors=colors))
    ear = square(300, color="own", centre=(0.25, 0.43, 0.0), extent=0.18, titles=False)
    save_picture(PICTURES / "curves.png", draw_panels(shown, square(300, color="own")), draw_panels(shown, ear))


if __name__ == "__main__":
    bunny = SAMPLES / "bunny.obj"
    rebuilt_from_modes(bunny, (5, 20, 100, 500))
    equaliser(bunny)
    spectrum_before_and_after(bunny)
    regions(bunny)
    holes()
    features()
    necks()
    curves(bunny)
    if len(sys.argv) > 1:
        before_and_after(Path(sys.argv[1]) / "face_clean.ply")
