"""Adds vertices and faces to a mesh in place, by several filters of MeshLab in turn, as no single one does it.

Subdivision makes vertices and faces in place, and merging vertices that coincide gives faces any vertices. So one face, the seed,
is cut out and subdivided until there are enough faces; these are cut apart; every vertex is sent to (i, 0, 0), where i is the
vertex that it is to be, and those at the same place become one, of which the first stays. Everything of the mesh stays: its id,
the order of its elements, attributes of every kind. What is left over is sent to vertex 0, and its faces vanish there.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Bools, Edit, Floats, Ints
from ..errors import MeshError
from ..mesh_data import MeshData
from ..mesh_data.apply_edit import faces_that_give, with_additions
from .workbench import ELEMENTS, Workbench, attributes_of, bring_in, check_names, check_taken, clear_beyond, read_array, wedges_of


def add_elements(bench: Workbench, mesh: Any, edit: Edit) -> tuple[Edit, tuple[str, ...]]:
    """Add the edit's vertices and faces to the current layer, which has faces and no matrix.

    Gives an edit of the larger mesh with what remains to be written, such as coordinates and selection, and notes.
    """
    _check_growable(mesh)
    check_names(bench, mesh)
    before = _as_data(mesh)
    n, faces, wedges = len(before.vertices), before.faces, before.face_attributes.get("wedge_texture_coordinates")
    may_give = _textured(bench, mesh, before, edit.added_faces)
    made = with_additions(before, edit, may_give)
    remaining: dict[str, Any] = {"vertices": made.vertices, "added_vertices": None, "added_faces": None}
    for element, attributes in zip(ELEMENTS, (made.vertex_attributes, made.face_attributes), strict=True):
        for name in ("selection", "scalars", "colors"):
            if name in attributes and getattr(edit, f"{element}_{name}") is None:
                remaining[f"{element}_{name}"] = attributes[name] / 255.0 if name == "colors" else attributes[name]

    seed, triangulated = _grow(bench, mesh, len(made.vertices) - n, made.faces[len(faces) :], may_give)
    clear_beyond(bench, mesh, "vertex", n)
    clear_beyond(bench, mesh, "face", len(faces))
    if wedges is not None:
        _write_wedge_uv(bench, mesh, wedges, made.face_attributes["wedge_texture_coordinates"][len(faces) :, 0], seed)
    if (uv := made.vertex_attributes.get("texture_coordinates")) is not None:
        _write_vertex_uv(bench, mesh, uv)
    notes = ("the mesh had polygons and no triangle; it has triangles alone now",) if triangulated else ()
    return replace(edit, **remaining), notes


def _as_data(mesh: Any) -> MeshData:
    """The attributes that are continued into added elements."""
    vertices, faces = read_array(mesh, "vertices"), read_array(mesh, "faces")
    of = {e: {"selection": read_array(mesh, f"{e}_selection"), **attributes_of(mesh, e)} for e in ("vertex", "face")}
    if (wedges := wedges_of(mesh)) is not None:
        of["face"]["wedge_texture_coordinates"] = wedges
        # MeshLab gives its vertices texture coordinates on the way.
        uv = of["vertex"]["texture_coordinates"] = np.zeros((len(vertices), 2))
        uv[faces.ravel()[::-1]] = wedges.reshape(-1, 2)[::-1]
    if mesh.has_vertex_tex_coord():
        of["vertex"]["texture_coordinates"] = mesh.vertex_tex_coord_matrix()
    return MeshData(vertices=vertices, faces=faces, vertex_attributes=of["vertex"], face_attributes=of["face"])


def _textured(bench: Workbench, mesh: Any, before: MeshData, added_faces: Ints | None) -> Bools:
    """(m,) the faces with the texture that most vertices of the rim have (`faces_that_give`)."""
    if mesh.texture_number() < 2 or "wedge_texture_coordinates" not in before.face_attributes:
        return faces_that_give(before, added_faces)
    numbers = np.full(len(before.faces), -1, np.int32)
    for index in range(mesh.texture_number()):
        bench.apply("compute_selection_by_condition_per_face", condselect=f"ti=={index}")
        numbers[read_array(mesh, "face_selection")] = index
    wedges = before.face_attributes["wedge_texture_coordinates"]
    wedges = np.where(numbers[:, None, None] < 0, np.nan, wedges)  # faces without an image give none
    return faces_that_give(before.with_attributes(face={"wedge_texture_coordinates": wedges, "texture": numbers}), added_faces)


def _write_vertex_uv(bench: Workbench, mesh: Any, uv: Floats) -> None:
    """Make the texture coordinates of the vertices these, (n, 2)."""
    if np.array_equal(mesh.vertex_tex_coord_matrix(), uv, equal_nan=True):
        return
    u, v = bring_in(bench, mesh, "vertex", list(uv.T))
    bench.apply("compute_texcoord_by_function_per_vertex", u=u, v=v, onselected=False)
    check_taken(mesh, mesh.vertex_tex_coord_matrix(), uv, "texture coordinates")


def _write_wedge_uv(bench: Workbench, mesh: Any, wedges: Floats, uv: Floats, seed: int) -> None:
    """Give added faces one place of the texture each, and the seed its own again."""
    old = len(wedges)
    columns = np.concatenate([np.zeros((old, 2)), uv])
    bench.apply("compute_selection_by_condition_per_face", condselect=f"fi>={old}||fi=={seed}")
    u, v = bring_in(bench, mesh, "face", list(columns.T))
    own = np.where(np.isfinite(wedges[seed]), wedges[seed], 0.0)
    expressions = {
        f"{axis}{corner}": f"fi=={seed}?{float(own[corner, column])!r}:{name}"
        for corner in range(3)
        for column, (axis, name) in enumerate((("u", u), ("v", v)))
    }
    bench.apply("compute_texcoord_by_function_per_wedge", **expressions, onselected=True)
    wanted = np.concatenate([wedges, np.repeat(uv[:, None], 3, axis=1)])
    check_taken(mesh, wedges_of(mesh), wanted, "texture coordinates")


def _check_growable(mesh: Any) -> None:
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


def _grow(bench: Workbench, mesh: Any, vertices: int, added_faces: Ints, may_seed: Bools) -> tuple[int, bool]:
    """Add vertices and faces to the current layer; the seed, and whether a mesh of polygons alone has become one of triangles.

    Vertex i is at (i, 0, 0) afterwards, and the selection of faces is lost. Texture coordinates of the seed change; new faces
    have its texture. `vertices` is how many to add, `may_seed` are the faces that may serve as the seed, at least one.
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
