"""A small scan for every shipped recipe, of the kind that it is for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pymeshfair.declaration import Floats, Ints

#: vertices around and along; 5,041 together
SIDE = 71
#: by recipe, the scan that it is for, where that is not the ring
SCANS: Mapping[str, str] = {
    "blend_parts": "tubes",
    "clean_photogrammetry": "torn",
    "clean_point_cloud": "cloud",
    "clean_range_map": "sheet",
    "cloud_to_mesh": "cloud",
    "fair_selection": "painted",
    "fill_holes_smoothly": "torn",
    "prepare_for_print": "torn",
    "prepare_for_simulation": "torn",
    "register_ready": "sheet",
    "smooth_contours": "contours",
}


def write_scans(folder: Path) -> dict[str, Path]:
    """The scans in a folder, by name."""
    random = np.random.default_rng(71)
    ring, ring_faces = _rolled(SIDE, True, True)
    ring += random.normal(scale=0.01, size=ring.shape)
    sheet, sheet_faces = _rolled(SIDE, False, False)
    sheet[:, 2] += 0.2 * np.sin(3 * sheet[:, 0]) + random.normal(scale=0.005, size=len(sheet))
    tube, tube_faces = _rolled(SIDE, True, False)
    near = tube[np.unique(tube_faces)] * (1.0, 1.0, 0.5)
    tubes = np.concatenate([near, near + np.array([0.0, 0.0, 3.0])])
    strays = random.uniform(-4.0, 4.0, size=(50, 3))
    red = np.where(ring[:, :1] > 2.2, (255, 0, 0), (200, 200, 200))
    turn = np.linspace(0.0, 2 * np.pi, 5000, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1) + random.normal(scale=2e-4, size=(5000, 1))
    at = np.arange(5000)
    scans = {
        "ring": _ply(ring, ring_faces),
        "painted": _ply(ring, ring_faces, colors=red),
        "torn": _ply(ring, ring_faces[np.linalg.norm(ring[ring_faces[:, 0]] - ring[0], axis=1) > 0.4]),
        "sheet": _ply(sheet, sheet_faces),
        "tubes": _ply(tubes, np.concatenate([tube_faces, tube_faces + len(near)])),
        "cloud": _ply(np.concatenate([ring, strays])),
        "contours": _ply(circle, edges=np.stack([at, (at + 1) % 5000], axis=1)),
    }
    for name, text in scans.items():
        (folder / f"{name}.ply").write_text(text, encoding="ascii")
    return {name: folder / f"{name}.ply" for name in scans}


def scan_of(recipe: str) -> str:
    """The name of the scan that a recipe is measured on."""
    return SCANS.get(recipe, "ring")


def _rolled(side: int, around: bool, along: bool) -> tuple[Floats, Ints]:
    """A square grid: closed in both directions a torus, in one a tube about z, in none a sheet of side 4."""
    i, j = (index.ravel() for index in np.meshgrid(np.arange(side), np.arange(side), indexing="ij"))
    u, v = 2 * np.pi * i / side, 2 * np.pi * j / side
    if around and along:
        points = np.stack([(2 + 0.7 * np.cos(v)) * np.cos(u), (2 + 0.7 * np.cos(v)) * np.sin(u), 0.7 * np.sin(v)], axis=1)
    elif around:
        points = np.stack([np.cos(u), np.sin(u), v / np.pi], axis=1)
    else:
        points = np.stack([u / np.pi * 2, v / np.pi * 2, 0 * u], axis=1)
    inside = (around | (i < side - 1)) & (along | (j < side - 1))
    i, j = i[inside], j[inside]
    a, b, c, d = (((i + x) % side) * side + (j + y) % side for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return points, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]).astype(np.int32)


def _ply(
    vertices: Floats,
    faces: Ints | None = None,
    edges: NDArray[np.integer] | None = None,
    colors: NDArray[np.integer] | None = None,
) -> str:
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", *(f"property double {axis}" for axis in "xyz")]
    lines += [f"property uchar {name}" for name in ("red", "green", "blue") if colors is not None]
    if faces is not None:
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    if edges is not None:
        lines += [f"element edge {len(edges)}", "property int vertex1", "property int vertex2"]
    lines.append("end_header")
    painted = np.empty((len(vertices), 0), dtype=np.int64) if colors is None else colors
    lines += [" ".join(map(repr, (*p, *c))) for p, c in zip(vertices.tolist(), painted.tolist(), strict=True)]
    lines += [f"3 {a} {b} {c}" for a, b, c in (() if faces is None else faces.tolist())]
    lines += [f"{a} {b}" for a, b in (() if edges is None else edges.tolist())]
    return "\n".join(lines) + "\n"
