"""Writes PLY files of our own making, in double precision; meshes that MeshLab holds are written by MeshLab."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

_COLOR = ("red", "green", "blue", "alpha")


def write_ply(
    path: Path,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int32],
    *,
    vertex_scalars: NDArray[np.float64],
    vertex_colors: NDArray[np.uint8],
    face_scalars: NDArray[np.float64],
    face_colors: NDArray[np.uint8],
) -> None:
    """Write a new binary PLY file with the scalar ("quality") and colour of every element.

    Args:
        path: the file.
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        vertex_scalars: (n,).
        vertex_colors: (n, 4) from 0 to 255.
        face_scalars: (m,).
        face_colors: (m, 4) from 0 to 255.
    """
    vertex = np.empty(len(vertices), dtype=[*((axis, "<f8") for axis in "xyz"), ("quality", "<f8"), *((c, "u1") for c in _COLOR)])
    for k, axis in enumerate("xyz"):
        vertex[axis] = vertices[:, k]
    vertex["quality"] = vertex_scalars
    face = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3), ("quality", "<f8"), *((c, "u1") for c in _COLOR)])
    face["count"], face["corners"], face["quality"] = 3, faces, face_scalars
    for k, channel in enumerate(_COLOR):
        vertex[channel] = vertex_colors[:, k]
        face[channel] = face_colors[:, k]
    more = ["property double quality", *(f"property uchar {c}" for c in _COLOR)]
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property double {axis}" for axis in "xyz"),
        *more,
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        *more,
        "end_header",
        "",
    ]
    with path.open("xb") as file:
        file.write("\n".join(header).encode("ascii"))
        file.write(vertex.tobytes())
        file.write(face.tobytes())
