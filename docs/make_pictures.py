"""Draws the pictures of the documentation: ``python docs/make_pictures.py pymeshfair_demo``.

Needs the `report` extra, and the folder that ``pymeshfair demo`` writes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pymeshlab
from numpy.typing import NDArray

mpl.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.collections import PolyCollection
from PIL import Image

PICTURES = Path(__file__).parent / "pictures"
SUPERSAMPLING = 4  # triangles are smaller than a pixel; without it they leave a moire pattern
LIGHT = np.array([0.35, 0.45, 0.82])


def shaded(axes: plt.Axes, path: Path, window: tuple[float, float, float, float]) -> None:
    """Draw a mesh seen along -z, lit from the upper right, farthest triangles first."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    vertices, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    left, right, bottom, top = window
    centre = corners.mean(axis=1)
    seen = (normals[:, 2] > 0) & (centre[:, 0] > left) & (centre[:, 0] < right) & (centre[:, 1] > bottom) & (centre[:, 1] < top)
    order = np.flatnonzero(seen)[np.argsort(centre[seen, 2])]
    axes.add_collection(
        PolyCollection(corners[order][:, :, :2], facecolors=shade(normals[order]), edgecolors="face", linewidths=0.2)
    )
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    axes.axis("off")


def shade(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Diffuse and specular light: the highlights show noise that a diffuse picture hides."""
    diffuse = np.clip(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)[:, None]
    half = LIGHT / np.linalg.norm(LIGHT) + [0, 0, 1]
    specular = np.clip(normals @ (half / np.linalg.norm(half)), 0, 1)[:, None] ** 40
    color = np.array([0.62, 0.66, 0.72])
    return np.clip(0.12 + 0.75 * diffuse * color + 0.45 * specular, 0, 1)


def before_and_after(before: Path, after: Path, picture: Path) -> None:
    """Two halves of one face: as scanned and as cleaned, whole above and a close-up below."""
    figure, rows = plt.subplots(1, 4, figsize=(12, 4.5))
    whole, detail = (-76.0, 56.0, -100.0, 90.0), (-12.0, 44.0, -28.0, 52.6)
    for axes, path, window, title in zip(
        rows, (before, after, before, after), (whole, whole, detail, detail), ("scan", "cleaned", "scan", "cleaned"), strict=True
    ):
        shaded(axes, path, window)
        axes.set_title(title, fontsize=12)
    figure.tight_layout(pad=0.4)
    picture.parent.mkdir(exist_ok=True)
    figure.savefig(picture, dpi=100 * SUPERSAMPLING)
    with Image.open(picture) as drawn:
        drawn.convert("RGB").reduce(SUPERSAMPLING).save(picture, optimize=True)


if __name__ == "__main__":
    scan = Path(pymeshlab.__file__).parent / "tests/sample_meshes/rangemaps/face000.ply"
    before_and_after(scan, Path(sys.argv[1]) / "face_clean.ply", PICTURES / "demo.png")
