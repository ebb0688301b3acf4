"""The meshes and points of the contests, made once a run and kept in a folder for the processes that measure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from diffusion import make_mesh
from fairing import middle, sheet
from outliers import scanned_torus

from pymeshfair.filters.geometry import mean_edge_length

from .contest import Order, Subject

#: A sheet has so many vertices for one that is free.
_SHEET = 10


def make_subject(kind: str, size: int, order: Order) -> Subject:
    """A subject of about that size.

    Args:
        kind: "mesh": the noisy subdivided bunny of benchmarks/diffusion.py, closed. "points": the torus of
            benchmarks/outliers.py. "sheet": that of benchmarks/fairing.py, ten times as large as the square of free vertices in
            its middle.
        size: of vertices; for a sheet of free ones.
        order: see `contest.ORDERS`.
    """
    if kind == "points":
        points = scanned_torus(size)
        if order == "random":
            points = np.random.default_rng(1).permutation(points)
        return Subject(points, np.empty((0, 3), dtype=np.int32), 0.0, np.ones(len(points), dtype=np.bool_))
    if kind == "sheet":
        vertices, faces = sheet(_SHEET * size)
        return Subject(vertices, faces, mean_edge_length(vertices, faces), middle(vertices, size))
    vertices, faces = make_mesh(size, "loop" if order == "scan" else order)
    return Subject(vertices, faces, mean_edge_length(vertices, faces), np.ones(len(vertices), dtype=np.bool_))


def kept_subject(folder: Path, kind: str, size: int, order: Order) -> Path:
    """The file of a subject, made if it is not there yet."""
    path = folder / f"{kind}_{size}_{order}.npz"
    if not path.exists():
        np.savez(path, **make_subject(kind, size, order)._asdict())
    return path


def loaded_subject(path: Path) -> Subject:
    """What `kept_subject` wrote."""
    with np.load(path) as saved:
        return Subject(saved["vertices"], saved["faces"], float(saved["edge"]), saved["free"])
