"""Draws meshes as shaded pictures, for the pages and the galleries. Needs matplotlib (the `report` extra)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import matplotlib as mpl
import numpy as np
import pymeshlab
from numpy.typing import NDArray

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.collections import PolyCollection
from PIL import Image

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Bools: TypeAlias = NDArray[np.bool_]
#: left, right, bottom, top, in mesh units
Window: TypeAlias = tuple[float, float, float, float]

SUPERSAMPLING = 4  # triangles are smaller than a pixel; without it they leave a moire pattern
LIGHT = np.array([0.35, 0.45, 0.82])
ORANGE = np.array([1.0, 0.55, 0.1])
#: seen from the right and from above, so that a box shows three sides
FROM_A_CORNER = np.array([[0.84, -0.54, 0.0], [0.23, 0.35, 0.91], [-0.49, -0.76, 0.42]])


def read_mesh(path: Path) -> tuple[Floats, Ints]:
    """Vertices and faces of any file that MeshLab reads."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    return np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def paint(axes: Any, vertices: Floats, faces: Ints, window: Window | None = None, marked: Bools | None = None) -> None:
    """Draw a mesh seen along -z, lit from the upper right, farthest triangles first; the window defaults to all of it.

    Triangles that are marked, (m,) bool, are tinted orange.
    """
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    left, right, bottom, top = window or whole(vertices)
    centre = corners.mean(axis=1)
    seen = (normals[:, 2] > 0) & (centre[:, 0] > left) & (centre[:, 0] < right) & (centre[:, 1] > bottom) & (centre[:, 1] < top)
    order = np.flatnonzero(seen)[np.argsort(centre[seen, 2])]
    colors = shade(normals[order])
    if marked is not None:
        tinted = marked[order]
        colors[tinted] = 0.4 * colors[tinted] + 0.6 * ORANGE * (0.3 + colors[tinted])
    axes.add_collection(
        PolyCollection(list(corners[order][:, :, :2]), facecolors=np.clip(colors, 0, 1), edgecolors="face", linewidths=0.2)
    )
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.axis("off")


def whole(vertices: Floats) -> Window:
    """The window that shows all vertices."""
    (left, bottom), (right, top) = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
    margin = 0.02 * max(right - left, top - bottom)
    return (left - margin, right + margin, bottom - margin, top + margin)


def shade(normals: Floats) -> Floats:
    """Diffuse and specular light: the highlights show noise that a diffuse picture hides."""
    diffuse = np.clip(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)[:, None]
    half = LIGHT / np.linalg.norm(LIGHT) + [0, 0, 1]
    specular = np.clip(normals @ (half / np.linalg.norm(half)), 0, 1)[:, None] ** 40
    color = np.array([0.62, 0.66, 0.72])
    return np.asarray(np.clip(0.12 + 0.75 * diffuse * color + 0.45 * specular, 0, 1))


def picture(path: Path, draw: Callable[[Any], None], *, rows: int, columns: int, size: tuple[float, float]) -> None:
    """Save what `draw` puts on rows x columns axes as a PNG of 100 pixels an inch of `size`."""
    figure, axes = plt.subplots(rows, columns, figsize=size, squeeze=False)
    draw(axes)
    figure.tight_layout(pad=0.4, h_pad=2.0)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=100 * SUPERSAMPLING)
    plt.close(figure)
    with Image.open(path) as drawn:
        drawn.convert("RGB").reduce(SUPERSAMPLING).quantize(256).save(path, optimize=True)


def gallery(path: Path, rows: Sequence[Sequence[tuple[str, Floats]]], faces: Sequence[Ints], *, side: float = 2.6) -> None:
    """Save a picture of rows of meshes with titles; each row has its own faces, and the window of its last mesh (the truth)."""

    def draw(axes: Any) -> None:
        for row, meshes, triangles in zip(axes, rows, faces, strict=True):
            window = whole(meshes[-1][1])
            for place in row:
                place.axis("off")
            for place, (title, vertices) in zip(row, meshes, strict=False):
                paint(place, vertices, triangles, window)
                place.set_title(title, fontsize=9)

    columns = max(map(len, rows))
    picture(path, draw, rows=len(rows), columns=columns, size=(side * columns, side * len(rows)))
