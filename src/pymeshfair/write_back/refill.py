"""Overwrites custom attributes, which MeshLab cannot do directly, by way of the vertex normals.

The vertices are laid out on a line, vertex i at (i, 0, 0). A helper cloud with its points in the same places then hands its
normals over point by point ("transfer attributes" takes the nearest point and copies its normal as it is), and MeshLab's
expressions copy normals to attributes. In the end coordinates and normals are put back. All of it is exact to the bit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Floats, Ints
from .workbench import Workbench, read_array

#: every helper attribute's name begins with this
PREFIX = "pymeshfair_helper_"
#: the helper attributes that hold normals while others are overwritten
SPARE = tuple(f"{PREFIX}{i}" for i in range(3))
_AXES = ("nx", "ny", "nz")


def refill_vertices(bench: Workbench, mesh: Any, names: Sequence[str], arrays: Sequence[Floats]) -> None:
    """Set the vertex attributes `names` of the current layer to the arrays; those of `SPARE` are used up on the way.

    Face normals become those of the geometry.
    """
    with _on_a_line(bench, mesh) as line:
        for first in range(0, len(arrays), 3):
            columns = np.zeros((line.length, 3))
            taken = arrays[first : first + 3]
            for column, values in enumerate(taken):
                columns[:, column] = values
            line.send(columns)
            for name, axis in zip(names[first : first + 3], _AXES, strict=False):
                bench.apply("compute_new_custom_scalar_attribute_per_vertex", name=name, expr=axis)


def refill_faces(bench: Workbench, mesh: Any, names: Sequence[str], arrays: Sequence[Floats]) -> None:
    """Set the face attributes `names` of the current layer to the arrays.

    A face finds its number at one of its corners: in every round each vertex carries the index and two numbers of one of its
    faces, until all have been served, after three rounds or so. Those of `SPARE` are used up on the way, of vertices and faces.
    """
    faces = read_array(mesh, "faces")
    targets = [*zip(names, arrays, strict=False)]
    with _on_a_line(bench, mesh) as line:
        if line.face_normals is not None:
            targets += zip(SPARE, line.face_normals.T, strict=True)
        for first in range(0, len(targets), 2):
            _fill_pair(bench, line, faces, targets[first : first + 2])
    if line.face_normals is not None:
        x, y, z = SPARE
        bench.apply("compute_normal_by_function_per_face", x=x, y=y, z=z)


def _fill_pair(bench: Workbench, line: _Line, faces: Ints, pair: Sequence[tuple[str, Floats]]) -> None:
    for name, _ in pair:
        bench.apply("compute_new_custom_scalar_attribute_per_face", name=name, expr="0")
    waiting: NDArray[np.intp] = np.arange(len(faces))
    while len(waiting):
        carried, waiting = _assign(faces, waiting, line.length)
        columns = np.full((line.length, 3), -1.0)
        columns[:, 0] = carried
        for column, (_, values) in enumerate(pair, 1):
            columns[:, column] = values[carried]
        line.send(columns)
        for (name, _), axis in zip(pair, ("ny", "nz"), strict=False):
            expression = f"nx0==fi?{axis}0:(nx1==fi?{axis}1:(nx2==fi?{axis}2:{name}))"
            bench.apply("compute_new_custom_scalar_attribute_per_face", name=name, expr=expression)


def move_points(bench: Workbench, mesh: Any, points: Floats) -> None:
    """Give the vertices of the current layer, which has no faces, new places and leave their normals alone."""
    with _on_a_line(bench, mesh) as line:
        line.points = points


def _assign(faces: Ints, waiting: NDArray[np.intp], vertices: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Which face each vertex carries, -1 for none, and the faces that are left for later rounds."""
    carried = np.full(vertices, -1, dtype=np.intp)
    for corner in range(3):
        at = faces[waiting, corner]
        free = carried[at] < 0
        carried[at[free]] = waiting[free]  # of several faces at one vertex the last stays
        waiting = waiting[carried[at] != waiting]
    return carried, waiting


@contextmanager
def _on_a_line(bench: Workbench, mesh: Any) -> Iterator[_Line]:
    """The vertices of the current layer on a line for as long as the context lasts, however it ends."""
    line = _Line(bench, mesh)
    try:
        bench.apply("compute_coord_by_function", x="vi", y="0", z="0")
        yield line
    finally:
        if np.array_equal(read_array(mesh, "vertices"), line.places[:-1]):
            line.put_back()


class _Line:
    """The vertices of a layer, to be laid out on a line and put back.

    Attributes:
        length: the number of vertices.
        places: (length + 1, 3) where vertex i goes, and one more.
        points: where they were, and where they will be put.
        face_normals: those of the faces if putting back loses them, because they do not follow from
            the geometry; else None.
    """

    def __init__(self, bench: Workbench, mesh: Any) -> None:
        self._bench = bench
        self._id = int(mesh.id())
        self.points, self._normals = read_array(mesh, "vertices"), read_array(mesh, "vertex_normals")
        self.length = len(self.points)
        self.face_normals: Floats | None = None
        if mesh.face_number():
            before = read_array(mesh, "face_normals")
            bench.apply("compute_coord_by_function", x="x", y="y", z="z")
            self.face_normals = None if np.array_equal(read_array(mesh, "face_normals"), before) else before
        # One place more than vertices: MeshLab's search would not end in the empty box around a single point.
        self.places = np.zeros((self.length + 1, 3))
        self.places[:, 0] = np.arange(self.length + 1)

    def send(self, columns: Floats) -> None:
        """Set the normals of the vertices to these three numbers each."""
        normals = np.vstack([columns, np.zeros((1, 3))])
        cloud = pymeshlab.Mesh(vertex_matrix=self.places, v_normals_matrix=normals)
        with self._bench.helper_layer(cloud) as helper:
            self._bench.apply(
                "transfer_attributes_per_vertex",
                sourcemesh=helper,
                targetmesh=self._id,
                geomtransfer=False,
                normaltransfer=True,
                colortransfer=False,
                qualitytransfer=False,
                selectiontransfer=False,
                upperbound=pymeshlab.PureValue(0.5),
            )

    def put_back(self) -> None:
        """Give the vertices their places and normals again."""
        self.send(self._normals)
        for name, axis in zip(SPARE, _AXES, strict=True):
            self._bench.apply("compute_new_custom_scalar_attribute_per_vertex", name=name, expr=axis)
        self.send(self.points)
        x, y, z = _AXES
        self._bench.apply("compute_coord_by_function", x=x, y=y, z=z)
        x, y, z = SPARE
        self._bench.apply("compute_normal_by_function_per_vertex", x=x, y=y, z=z)
