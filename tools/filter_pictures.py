"""Draws before and after of filters for the site: ``python tools/filter_pictures.py [FILTER ...]``.

On the scenes of tools/recipe_pictures.py. Filters that give numbers to vertices are shown by colours; those that count have no
picture.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from matplotlib import colormaps
from recipe_pictures import (
    CORNER,
    EAR,
    HAUNCH,
    TILTED,
    WHOLE,
    WIDTH,
    Scene,
    bunny,
    damaged,
    dirty_cloud,
    noisy_chest,
    rough,
    save,
    slightly_noisy_statue,
    slivers,
    spiky_bunny,
    statue,
    two_tubes,
)

from pymeshfair import MeshSet
from pymeshfair.looking.picture import Appearance

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from panels import Panel, draw_panels

PICTURES = Path(__file__).parents[1] / "docs/pictures/filters"
#: by filter: what it is shown on, the parameters that are not its defaults, and from where
SHOWN: dict[str, tuple[Callable[[], Scene], dict[str, Any], dict[str, Any]]] = {
    "apply_color_anisotropic_diffusion_per_vertex": (statue, {"iterations": 60}, {"show": "colors"}),
    "apply_coord_bilaplacian_smoothing": (slightly_noisy_statue, {}, EAR),
    "apply_coord_bilateral_fleishman": (noisy_chest, {}, CORNER),
    "apply_coord_bilateral_jones": (noisy_chest, {}, CORNER),
    "apply_coord_bilateral_projection_of_points": (lambda: points_of(rough(statue(), 0.4)), {}, EAR),
    "apply_coord_curve_smoothing": (lambda: rough(statue(), 0.3), {}, {"show": "section"}),
    "apply_coord_detail_enhancement": (statue, {}, EAR),
    "apply_coord_explicit_smoothing": (slightly_noisy_statue, {}, EAR),
    "apply_coord_implicit_fairing": (slightly_noisy_statue, {"detail_size": "6edge"}, EAR),
    "apply_coord_normal_filtering": (noisy_chest, {}, CORNER),
    "apply_coord_region_fairing": (bunny, {}, {"show": "selected"}),
    "apply_coord_spectral_filter": (slightly_noisy_statue, {}, EAR),
    "apply_coord_spike_removal": (lambda: spiky_bunny(0.0), {}, WHOLE),
    "apply_coord_tangential_smoothing": (slivers, {}, HAUNCH),
    "apply_coord_taubin_fairing": (slightly_noisy_statue, {}, EAR),
    "apply_scalar_anisotropic_diffusion_per_vertex": (statue, {"iterations": 60}, {"show": "noisy scalar"}),
    "compute_color_by_reflection_lines_per_vertex": (bunny, {}, {"show": "own colors"}),
    "compute_scalar_by_gaussian_curvature_per_vertex": (bunny, {}, {"show": "scalar"}),
    "compute_scalar_by_manifold_harmonic_per_vertex": (bunny, {}, {"show": "scalar"}),
    "compute_scalar_by_mean_curvature_per_vertex": (bunny, {}, {"show": "scalar"}),
    "compute_scalar_by_triangle_shape_per_face": (slivers, {}, {**HAUNCH, "show": "face scalar"}),
    "compute_selection_by_outlier_probability_per_vertex": (dirty_cloud, {}, {"show": "selection"}),
    "compute_selection_by_stray_points_per_vertex": (dirty_cloud, {}, {"show": "selection"}),
    "meshing_bridge_rims_by_fairing": (two_tubes, {}, TILTED),
    "meshing_close_holes_by_fairing": (bunny, {}, {"elevation": -70.0}),
}


def points_of(scene: Scene) -> Scene:
    """The vertices alone."""
    return scene[0], scene[1][:0]


def draw(name: str) -> None:
    """Write the picture of one filter."""
    make, parameters, view = SHOWN[name]
    show = view.get("show", "shape")
    vertices, faces = make()
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces) if len(faces) else pymeshlab.Mesh(vertices))
    before: dict[str, Any] = {}
    if not len(faces):
        meshes.compute_normal_for_point_clouds()
    if show == "section":
        meshes.generate_polyline_from_planar_section(planeaxis="Z Axis", relativeto="Bounding box center")
        before["edges"] = meshes.current_mesh().edge_matrix()
    elif show == "selected":
        moved, hit = damaged(vertices)
        meshes = MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(moved, faces, v_scalar_array=hit.astype(float)))
        meshes.compute_selection_by_condition_per_vertex(condselect="q > 0.5")
    elif show in ("colors", "noisy scalar"):
        height = np.sin(6.0 * vertices[:, 1]) + np.random.default_rng(4).normal(scale=0.3, size=len(vertices))
        values = np.sign(height) + 0.4 * height
        before["colors"] = colored(values)
        meshes = MeshSet()
        opaque = np.concatenate([before["colors"], np.ones((len(values), 1))], axis=1)
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces, v_color_matrix=opaque, v_scalar_array=values))
    elif show in ("own colors", "scalar", "face scalar", "selection"):
        before["colors"] = np.full((len(vertices), 3), 0.7)
    first = meshes.current_mesh()
    panels = [Panel("before", first.vertex_matrix(), _faces(first), **before)]
    meshes.apply_filter(name, **parameters)
    mesh = meshes.current_mesh()
    after: dict[str, Any] = {"edges": mesh.edge_matrix()} if mesh.edge_number() else {}
    points, triangles = mesh.vertex_matrix(), _faces(mesh)
    if show.endswith("colors"):
        after["colors"] = mesh.vertex_color_matrix()[:, :3]
    elif show in ("scalar", "noisy scalar"):
        after["colors"] = colored(mesh.vertex_scalar_array())
    elif show == "face scalar":
        sums, counts = (np.bincount(triangles.ravel(), w, len(points)) for w in (np.repeat(mesh.face_scalar_array(), 3), None))
        after["colors"] = colored(sums / np.maximum(counts, 1))
    elif show == "selection":
        after["colors"] = np.where(mesh.vertex_selection_array()[:, None], [0.85, 0.1, 0.1], [0.7, 0.7, 0.7])
    panels.append(Panel("after", points, triangles, **after))
    look = {key: value for key, value in view.items() if key != "show"}
    color = {"color": "own"} if "colors" in after else {}
    save(draw_panels(panels, Appearance(**{"width": WIDTH // 2, "height": 250, **color, **look})), PICTURES / f"{name}.png")


def _faces(mesh: pymeshlab.Mesh) -> np.ndarray[Any, np.dtype[np.int32]]:
    return np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def colored(values: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Colours of numbers, the middle 96 % of them spread over the map."""
    low, high = np.quantile(values, [0.02, 0.98])
    return np.asarray(colormaps["viridis"](np.clip((values - low) / max(high - low, 1e-300), 0.0, 1.0))[:, :3])


if __name__ == "__main__":
    for chosen in sys.argv[1:] or sorted(SHOWN):
        draw(chosen)
