"""Adds vertices and faces to a mesh in place, by several filters of MeshLab in turn, as no single one does it.

Subdivision makes vertices and faces in place, and merging vertices that coincide gives faces any vertices. So one face, the seed,
is cut out and subdivided until there are enough faces; these are cut apart; every vertex is sent to (i, 0, 0), where i is the
vertex that it is to be, and those at the same place become one, of which the first stays. Everything of the mesh stays: its id,
the order of its elements, attributes of every kind. What is left over is sent to vertex 0, and its faces vanish there.
"""

from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Bools, Ints
from ..errors import MeshError
from .workbench import Workbench, check_taken, read_array


def check_growable(mesh: Any) -> None:
    """Raise `MeshError` if nothing can be added to the mesh without changing what is there."""
    faces, edges = read_array(mesh, "faces"), np.sort(read_array(mesh, "edges"), axis=1)
    twice = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    if twice.any():
        raise MeshError(
            f"{int(twice.sum())} faces of {mesh.label()!r} have the same vertex twice, the first is face {twice.argmax()}; "
            "nothing can be added before they are removed (meshing_remove_null_faces)"
        )
    if not np.isfinite(read_array(mesh, "vertices")).all():
        raise MeshError(f"vertices of {mesh.label()!r} have coordinates that are not finite: nothing can be added to such a mesh")
    if len(edges) and (len(np.unique(edges, axis=0)) < len(edges) or (edges[:, 0] == edges[:, 1]).any()):
        raise MeshError(f"edges of {mesh.label()!r} occur twice or have no length: nothing can be added to such a mesh")


def grow(bench: Workbench, mesh: Any, vertices: int, added_faces: Ints, may_seed: Bools) -> tuple[int, bool]:
    """Add vertices and faces to the current layer, which has no matrix and has passed `check_growable`.

    Vertex i is at (i, 0, 0) afterwards, and the selection of faces is lost: both are for the caller to set. Texture
    coordinates of the seed change; new faces have its texture. `vertices` is how many to add, `may_seed` are the faces that may
    serve as the seed, at least one. Gives the seed, and whether the mesh, one of polygons alone, has become one of triangles.
    """
    old_faces, count = read_array(mesh, "faces"), mesh.vertex_number()
    bench.apply("compute_coord_by_function", x="vi", y="0", z="0")  # so that no edge is too short to be divided
    seed, triangulated = _seed(bench, mesh, may_seed)
    _cut_out(bench, f"fi=={seed}?1:0")
    meant = np.arange(mesh.vertex_number())
    meant[read_array(mesh, "faces")] = old_faces
    bench.apply("compute_selection_by_condition_per_face", condselect=f"fi=={seed}")
    how = {"iterations": _subdivisions(vertices, len(added_faces)), "threshold": pymeshlab.PureValue(0.0)}
    bench.apply("meshing_surface_subdivision_midpoint", **how, selected=True)
    first_cut = mesh.vertex_number()
    _cut_out(bench, f"fi>={len(old_faces)}?fi+1:(fi=={seed}?1:0)")
    faces = read_array(mesh, "faces")

    target: NDArray[np.intp] = np.zeros(mesh.vertex_number(), dtype=np.intp)
    target[: len(meant)] = meant
    target[faces[: len(old_faces)]] = old_faces
    # The vertices made by subdivision come before those made by cutting, so they are the ones that stay, in order.
    divided = np.setdiff1d(np.arange(len(meant), first_cut), faces[seed])
    # One of a face at most: with two of them a face that is left over would not vanish.
    owner: NDArray[np.intp] = np.zeros(mesh.vertex_number(), dtype=np.intp)
    owner[faces] = np.arange(len(faces))[:, None]
    divided = divided[np.sort(np.unique(owner[divided], return_index=True)[1])]
    target[divided[:vertices]] = np.arange(count, count + vertices)
    free = np.flatnonzero((faces >= first_cut).all(axis=1) & (np.arange(len(faces)) >= len(old_faces)))
    target[faces[free[: len(added_faces)]]] = added_faces
    _send(bench, mesh, target)
    bench.apply("meshing_remove_duplicate_vertices")
    check_taken(mesh, np.array(mesh.vertex_number()), np.array(count + vertices), "number of vertices")
    check_taken(mesh, read_array(mesh, "faces"), np.concatenate([old_faces, added_faces]), "new faces")
    return seed, triangulated


def shrink(bench: Workbench, mesh: Any, vertices: int, faces: Ints) -> None:
    """Undo `grow` on the current layer, however far it has come, but for what `grow` leaves to its caller."""
    if mesh.face_number() > len(faces):
        bench.apply("compute_selection_by_condition_per_face", condselect=f"fi>={len(faces)}")
        bench.apply("meshing_remove_selected_faces")
    if mesh.vertex_number() > vertices:
        target: NDArray[np.intp] = np.zeros(mesh.vertex_number(), dtype=np.intp)
        target[read_array(mesh, "faces")] = faces
        target[:vertices] = np.arange(vertices)
        _send(bench, mesh, target)
        bench.apply("meshing_remove_duplicate_vertices")
    if mesh.vertex_number() != vertices or not np.array_equal(read_array(mesh, "faces"), faces):
        raise MeshError(f"the faces of {mesh.label()!r} could not be put back")


def _seed(bench: Workbench, mesh: Any, may_seed: Bools) -> tuple[int, bool]:
    """A face that is a polygon by itself, preferably, and whether the mesh has lost its polygons because there is none."""
    # Every edge has a length now, so edges within polygons make a difference. A list of polygons takes far more memory.
    measures = bench.apply("get_geometric_measures")
    if measures["total_edge_inc_faux_length"] == measures["total_edge_length"]:
        return int(may_seed.argmax()), False
    triangles = {tuple(sorted(polygon.tolist())) for polygon in mesh.polygonal_face_list() if len(polygon) == 3}
    faces = np.sort(read_array(mesh, "faces"), axis=1)
    for face in np.flatnonzero(may_seed):
        if tuple(faces[face].tolist()) in triangles:
            return int(face), False
    bench.apply("meshing_poly_to_tri")
    return int(may_seed.argmax()), True


def _cut_out(bench: Workbench, mark: str) -> None:
    """Cut the mesh where the mark of a face, an expression, differs from that of its neighbour."""
    bench.apply("compute_normal_by_function_per_face", x=mark, y="0", z="0")
    bench.apply("meshing_vertex_attribute_seam", normalmode="Face", colormode="None", texcoordmode="None")


def _subdivisions(vertices: int, faces: int) -> int:
    """The number of subdivisions of a triangle that give so many vertices, and so many faces that keep none when cut apart."""
    times = 1
    while True:
        side = 2**times
        made = (side + 1) * (side + 2) // 2
        # Three vertices are corners of the seed, three more may stay with it; of the others each stays with one face, which may
        # keep three.
        if made - 6 >= 3 * vertices and side * side - made > faces:
            return times
        times += 1


def _send(bench: Workbench, mesh: Any, target: NDArray[np.intp]) -> None:
    """Move vertex i to (target[i], 0, 0)."""
    bench.move_to(mesh, np.eye(1, 3) * target[:, None].astype(np.float64))
