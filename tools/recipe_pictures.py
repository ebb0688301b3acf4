"""Draws before and after of every recipe for docs/recipes.md: ``python tools/recipe_pictures.py [RECIPE ...]``.

From samples of the pymeshlab wheel and shapes made here, with faults added where they have none.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray
from PIL import Image

from pymeshfair import MeshSet, Recipe
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.looking.picture import Appearance

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from denoising_findings import chest
from panels import Panel, draw_panels
from pictures import FACE, SAMPLES, Floats, Ints, read, tube

PICTURES = Path(__file__).parents[1] / "docs/pictures/recipes"
#: pixels across of a whole picture, and the most bytes that it may have
WIDTH, MOST_BYTES = 480, 60_000

Scene = tuple[Floats, Ints]


def rough(mesh: Scene, level: float, seed: int = 0) -> Scene:
    """The mesh with noise of so many mean edges in all directions."""
    vertices, faces = mesh
    spread = level * mean_edge_length(vertices, faces) / np.sqrt(3.0)
    return vertices + np.random.default_rng(seed).normal(scale=spread, size=vertices.shape), faces


def bunny() -> Scene:
    """The bunny of 5,051 vertices with its five holes."""
    return read(SAMPLES / "bunny10k_textured.obj")


def spiky_bunny(noise: float = 0.3) -> Scene:
    """The same with noise, spikes and a piece that floats beside it."""
    vertices, faces = rough(bunny(), noise)
    tips = np.random.default_rng(1).choice(len(vertices), 25, replace=False)
    vertices[tips] += 2.5 * mean_edge_length(vertices, faces) * np.random.default_rng(2).choice([-1.0, 1.0], size=(25, 3))
    bit = vertices[faces[:40]].reshape(-1, 3) * 0.2 + [5.0, 12.0, 0.0]
    return np.concatenate([vertices, bit]), np.concatenate([faces, np.arange(120, dtype=np.int32).reshape(-1, 3) + len(vertices)])


def dirty_cloud() -> Scene:
    """The vertices of the bunny among strays."""
    vertices, _ = read(SAMPLES / "bunny.obj")
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    strays = np.random.default_rng(3).uniform(low - 0.1 * (high - low), high + 0.1 * (high - low), size=(300, 3))
    return np.concatenate([vertices, strays]), np.zeros((0, 3), dtype=np.int32)


def two_tubes() -> Scene:
    """Two open tubes, one above the other."""
    low, faces = tube(64, 20, radius=1.0, length=2.0)
    high, more = tube(44, 14, radius=0.6, length=1.5)
    high[:, 0] += 0.3
    high[:, 2] += 3.0
    return np.concatenate([low, high]), np.concatenate([faces, more + np.int32(len(low))])


def noisy_chest() -> Scene:
    """A chest of flat and rounded sides with noise."""
    shape = chest(24)
    return shape.noisy, shape.faces


def damaged(vertices: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """The bunny's vertices with a rough spot on its haunch, and which these are."""
    x, y, z = ((vertices - vertices.min(axis=0)) / np.ptp(vertices, axis=0)).T
    hit = (np.hypot(x - 0.6, y - 0.35) < 0.16) & (z > 0.5)
    return vertices + np.random.default_rng(5).normal(scale=0.25, size=vertices.shape) * hit[:, None], hit


def slivers() -> Scene:
    """The bunny, its vertices slid along the surface until triangles are thin."""
    vertices, faces = bunny()
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=3000, qualitythr=0.0, preservetopology=True)
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def statue() -> Scene:
    """The fine bunny as it was scanned."""
    return read(SAMPLES / "bunny.obj")


def noisy_statue() -> Scene:
    """The same with noise."""
    return rough(read(SAMPLES / "bunny.obj"), 0.35)


def slightly_noisy_statue() -> Scene:
    """The same with less."""
    return rough(read(SAMPLES / "bunny.obj"), 0.2)


EAR = {"centre": (0.25, 0.35, 0.2), "extent": 0.5}
HAUNCH = {"centre": (-1.0, 8.0, 4.0), "extent": 6.0}
WHOLE: dict[str, Any] = {}
FACE_VIEW = {"centre": (-10.0, -5.0, -800.0), "extent": 150.0}
TILTED = {"elevation": 20.0, "up": "z"}
CORNER = {"azimuth": -33.0, "elevation": 30.0, "up": "z"}
#: for each recipe what it is shown on, and from where; section and contours are curves, and are drawn with what they came from
SHOWN: dict[str, tuple[Callable[[], Scene], dict[str, Any]]] = {
    "blend_parts": (two_tubes, TILTED),
    "clean_photogrammetry": (spiky_bunny, WHOLE),
    "clean_point_cloud": (dirty_cloud, WHOLE),
    "clean_range_map": (lambda: read(FACE), FACE_VIEW),
    "cloud_to_mesh": (dirty_cloud, WHOLE),
    "denoise": (noisy_chest, CORNER),
    "denoise_meshlab_only": (noisy_chest, CORNER),
    "enhance_details": (statue, WHOLE),
    "fair_selection": (bunny, WHOLE),
    "fill_holes_smoothly": (bunny, {"elevation": -70.0}),
    "improve_triangles": (slivers, HAUNCH),
    "prepare_for_print": (lambda: spiky_bunny(0.0), {"elevation": -40.0}),
    "prepare_for_simulation": (slivers, HAUNCH),
    "register_ready": (lambda: read(FACE), FACE_VIEW),
    "remove_outliers": (dirty_cloud, WHOLE),
    "show_harmonics": (bunny, {"color": "own"}),
    "smooth_contours": (noisy_statue, WHOLE),
    "smooth_implicit": (slightly_noisy_statue, EAR),
    "smooth_section": (noisy_statue, WHOLE),
    "smooth_taubin": (slightly_noisy_statue, EAR),
    "spectral_low_pass": (slightly_noisy_statue, EAR),
    "wrap_for_print": (two_tubes, TILTED),
}


def draw(name: str) -> None:
    """Write the picture of one recipe."""
    make, view = SHOWN[name]
    vertices, faces = make()
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces) if len(faces) else pymeshlab.Mesh(vertices))
    more: dict[str, Any] = {}
    if name == "smooth_contours":
        meshes.generate_polyline_from_planar_section(planeaxis="Z Axis", relativeto="Bounding box center")
        cut = meshes.current_mesh()
        vertices, faces, more = cut.vertex_matrix(), faces[:0], {"edges": cut.edge_matrix()}
    if name == "fair_selection":
        vertices, hit = damaged(vertices)
        colors = np.where(hit[:, None], [1.0, 0.0, 0.0, 1.0], [0.7, 0.7, 0.7, 1.0])
        meshes = MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces, v_color_matrix=colors))
    Recipe.load(name).apply(meshes)
    mesh = meshes.current_mesh()
    after: dict[str, Any] = {"edges": mesh.edge_matrix()} if mesh.edge_number() else {}
    if view.get("color") == "own":
        more["colors"], after["colors"] = np.full((len(vertices), 3), 0.7), mesh.vertex_color_matrix()[:, :3]
    panels = [
        Panel("before", vertices, faces, **more),
        Panel(name, mesh.vertex_matrix(), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32), **after),
    ]
    appearance = Appearance(**{"width": WIDTH // 2, "height": 250, **view})
    save(draw_panels(panels, appearance), PICTURES / f"{name}.png")


def save(picture: Image.Image, path: Path) -> None:
    """Write with as many colours as keep it small."""
    path.parent.mkdir(exist_ok=True)
    for colors in (128, 64, 32, 16):
        written = io.BytesIO()
        picture.convert("RGB").quantize(colors, dither=Image.Dither.NONE).save(written, "PNG", optimize=True)
        if written.tell() < MOST_BYTES:
            break
    path.write_bytes(written.getvalue())
    print(f"{path}: {written.tell() / 1000:.0f} kB, {picture.width} x {picture.height}", flush=True)


if __name__ == "__main__":
    for chosen in sys.argv[1:] or sorted(SHOWN):
        draw(chosen)
