"""Measures of one mesh for a comparison with another one."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..declaration import Bools, Floats, Ints
from ..files.formats import ATTRIBUTES, attributes_of
from ..filters.denoising import estimate_noise
from ..filters.holes.rims import outer_borders
from ..filters.inspection import SharpEdges, sharp_edges
from ..filters.mesh import bounding_box
from ..filters.topology import boundary_loops
from ..mesh_data import MeshData
from ..running.read import ReadMesh

#: vertices of a mesh beyond which a quarter of it gives the same noise, in a quarter of the time and memory
MOST_OF_NOISE = 100_000
#: cells of that part along the longest side of the box
_CELLS = 8


@dataclass(frozen=True, eq=False)
class MeshState:
    """One mesh and its measures."""

    path: Path  # its file
    mesh: MeshData
    self_intersecting: Bools | None  # (m,) the faces that cut others; None if not looked for
    #: `pymeshfair.filters.inspection.surface_measures.SurfaceMeasures` by name, and ``border_loops``; ``holes``, the border loops
    #: that do not go round the outside of a sheet; ``self_intersecting_faces``, None if not looked for; ``noise``, the standard
    #: deviation along the normals in mesh units, None of a cloud, above `MOST_OF_NOISE` vertices that of about a quarter of them;
    #: ``sharp_edge_length``
    measures: dict[str, Any]
    sharp: SharpEdges  # the sharp edges

    @property
    def attributes(self) -> tuple[str, ...]:
        """The attributes of the mesh, in the words of `pymeshfair.files.formats.ATTRIBUTES`."""
        present = attributes_of(self.mesh)
        return tuple(a for a in ATTRIBUTES if a in present)

    @property
    def diagonal(self) -> float:
        """Of the bounding box, in mesh units."""
        return float(self.measures["diagonal"])

    @property
    def mean_edge(self) -> float:
        """In mesh units; of a cloud the mean distance to the nearest point."""
        return float(self.measures["mean_edge"] or self.measures["mean_spacing"] or 0.0)


def state_of(read: ReadMesh) -> MeshState:
    """Measure a mesh."""
    mesh = read.mesh
    # About the middle, as squares of coordinates are taken below.
    local = mesh.vertices - mesh.vertices.mean(axis=0)
    border = boundary_loops(local, mesh.faces)
    holes = [outer for outer in outer_borders(border.loops, local, mesh.faces) if outer == "no"]
    sharp = sharp_edges(mesh.vertices, mesh.faces)
    cuts = read.self_intersecting
    more = {
        "border_loops": len(border.loops) + len(border.broken),
        "holes": len(holes),
        "self_intersecting_faces": None if cuts is None else int(cuts.sum()),
        "noise": estimate_noise(*part_for_noise(mesh.vertices, mesh.faces)).length if len(mesh.faces) else None,
        "sharp_edge_length": math.fsum(sharp.lengths),
    }
    return MeshState(read.path, mesh, cuts, {**read.measures, **more}, sharp)


def part_for_noise(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """A mesh; of a large one the faces within about a quarter of the cells of a grid, spread over all of it."""
    low, high = bounding_box(vertices)
    size = float((high - low).max())
    if len(vertices) <= MOST_OF_NOISE or not size > 0.0:
        return vertices, faces
    i, j, k = ((vertices - low) * (_CELLS / size)).astype(np.int64).T
    chosen = (i * 73_856_093 ^ j * 19_349_663 ^ k * 83_492_791) % 7 < 2  # a hash, so that no plane of cells is all or nothing
    inside = chosen[faces].all(axis=1)
    if 8 * np.count_nonzero(inside) < len(faces):  # a vertex far away has made the cells too large
        return vertices, faces
    number = np.cumsum(chosen) - 1
    return vertices[chosen], number[faces[inside]].astype(faces.dtype)
