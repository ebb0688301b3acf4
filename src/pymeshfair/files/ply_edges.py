"""Adds the edges of a mesh to a PLY file that MeshLab has written: MeshLab reads edges from PLY files but does not write them."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .ply import PlyError, read_header

_END = b"end_header\n"


def append_edges(path: Path, edges: NDArray[np.int32], n_vertices: int) -> None:
    """Put an element ``edge`` with the properties ``vertex1`` and ``vertex2`` at the end of a binary PLY file.

    Args:
        path: the file, little-endian; it is replaced when its successor is whole.
        edges: (e, 2) indices of vertices.
        n_vertices: how many vertices it has.

    Raises:
        PlyError: an edge ends at no vertex.
        OSError: the file cannot be written.
    """
    if len(edges) and not (edges.min() >= 0 and edges.max() < n_vertices):
        raise PlyError(f"an edge ends at a vertex that is not one of the {n_vertices:,}")
    header = read_header(path)
    assert header.format == "binary_little_endian", header.format
    fresh = path.with_name(f"{path.name}.edges")
    with path.open("rb") as source, fresh.open("xb") as target:
        words = source.read(header.size)
        assert words.endswith(_END), words[-20:]
        declared = f"element edge {len(edges)}\nproperty int vertex1\nproperty int vertex2\n".encode("ascii")
        target.write(words.removesuffix(_END) + declared + _END)
        shutil.copyfileobj(source, target, 1 << 20)
        target.write(np.ascontiguousarray(edges, dtype="<i4").tobytes())
    fresh.replace(path)
