"""Draws the picture of the page on curves: ``python tools/curve_pictures.py``. Needs the `report` extra."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from matplotlib.collections import LineCollection

from pymeshfair import MeshSet

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from painting import picture

BUNNY = Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny.obj"
PICTURES = Path(__file__).parents[1] / "docs/pictures"
SHOWN: tuple[tuple[str, dict[str, Any]], ...] = (
    ("section with noise", {}),
    ("explicit, 200 iterations", {"method": "explicit", "weights": "uniform", "iterations": 200}),
    ("taubin, 200 iterations", {"method": "taubin", "weights": "uniform", "iterations": 200}),
    ("implicit, detail_size 30edge", {"detail_size": "30edge"}),
)


def section(path: Path) -> None:
    """A section of the bunny with noise of half an edge, and what each method makes of it; the clean section behind."""
    meshes = MeshSet()
    meshes.load_new_mesh(str(BUNNY))
    meshes.generate_polyline_from_planar_section(planeaxis="Z Axis", relativeto="Bounding box center")
    mesh = meshes.current_mesh()
    clean, edges = mesh.vertex_matrix(), mesh.edge_matrix()
    spread = 0.5 * np.linalg.norm(clean[edges[:, 1]] - clean[edges[:, 0]], axis=1).mean()
    noisy = clean + np.random.default_rng(0).normal(scale=spread, size=clean.shape) * [1, 1, 0]

    def draw(axes: Any) -> None:
        for k, (title, parameters) in enumerate(SHOWN):
            shape = smoothed(noisy, edges, parameters) if parameters else noisy
            for place, window in zip(axes[:, k], (None, (0.16, 0.34, 0.34, 0.52)), strict=True):
                curve(place, clean, edges, "0.75", 2.5)
                curve(place, shape, edges, "#c0392b", 0.9)
                if window is None:
                    place.autoscale_view()
                    place.set_title(title, fontsize=11, y=0.95)
                else:
                    place.set(xlim=window[:2], ylim=window[2:])
                place.set_aspect("equal")
                place.axis("off")

    picture(path, draw, rows=2, columns=len(SHOWN), size=(12, 6.2))


def smoothed(vertices: Any, edges: Any, parameters: dict[str, Any]) -> Any:
    """The vertices after Curve Smoothing."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, edge_matrix=edges))
    meshes.apply_filter("apply_coord_curve_smoothing", **parameters)
    return meshes.current_mesh().vertex_matrix()


def curve(axes: Any, vertices: Any, edges: Any, color: str, width: float) -> None:
    """Draw the edges, seen along -z."""
    axes.add_collection(LineCollection(list(vertices[edges][:, :, :2]), colors=color, linewidths=width))


if __name__ == "__main__":
    section(PICTURES / "curves.png")
