"""Adds vertices and faces to a mesh in place, by a sequence of MeshLab's filters.

Subdivision makes vertices and faces; merging coincident vertices joins the corners of faces. So one face, the seed, is cut out
and subdivided into enough faces, and these faces are cut apart. Each vertex that is to become vertex i moves to (i, 0, 0), and
coincident vertices are merged into the one of lowest index. Surplus vertices move to vertex 0, where their faces vanish.
The mesh keeps its id, the order of its elements, and all attributes but normals and those that `grow` names.
"""

from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Bools, Ints
from ..errors import MeshError
from ..filters.topology import non_manifold_edges
from .workbench import Workbench, check_taken, read_array


def check_growable(mesh: Any) -> None:
    """Raises `MeshError` if nothing can be added to the mesh without changing what is there."""
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
    """Adds vertices and faces to the current layer, which has no transformation matrix and has passed `check_growable`.

    Afterwards vertex i is at (i, 0, 0) and the selection of faces is lost; the caller sets positions and selection. Texture
    coordinates of the seed change; new faces have its texture. `vertices` is the number added; `may_seed` marks the possible
    seeds, at least one face. Returns the seed, and whether polygons were triangulated, because no triangle could be the seed.
    """
    old_faces, count = read_array(mesh, "faces"), mesh.vertex_number()
    bench.apply("compute_coord_by_function", x="vi", y="0", z="0")  # so that no edge is too short to be divided
    seed, triangulated = _seed(bench, mesh, may_seed)
    # MeshLab subdivides no mesh with an edge of more than two faces, so all faces of such a mesh are cut apart.
    _cut_out(bench, "fi+1" if len(non_manifold_edges(old_faces)) else f"fi=={seed}?1:0")
    old_index = np.arange(mesh.vertex_number())
    old_index[read_array(mesh, "faces")] = old_faces
    bench.apply("compute_selection_by_condition_per_face", condselect=f"fi=={seed}")
    how = {"iterations": _subdivisions(vertices, len(added_faces)), "threshold": pymeshlab.PureValue(0.0)}
    bench.apply("meshing_surface_subdivision_midpoint", **how, selected=True)
    first_cut = mesh.vertex_number()
    _cut_out(bench, f"fi>={len(old_faces)}?fi+1:(fi=={seed}?1:0)")
    faces = read_array(mesh, "faces")

    target: NDArray[np.intp] = np.zeros(mesh.vertex_number(), dtype=np.intp)
    target[: len(old_index)] = old_index
    target[faces[: len(old_faces)]] = old_faces
    # New vertices come from subdivision: those of the second cut have higher indices, and merging keeps the lowest index.
    divided = np.setdiff1d(np.arange(len(old_index), first_cut), faces[seed])
    # At most one vertex of each face is used: a surplus face with two used vertices would not vanish.
    owner: NDArray[np.intp] = np.zeros(mesh.vertex_number(), dtype=np.intp)
    owner[faces] = np.arange(len(faces))[:, None]
    divided = divided[np.sort(np.unique(owner[divided], return_index=True)[1])]
    target[divided[:vertices]] = np.arange(count, count + vertices)
    free = np.flatnonzero((faces >= first_cut).all(axis=1) & (np.arange(len(faces)) >= len(old_faces)))
    target[faces[free[: len(added_faces)]]] = added_faces
    bench.move_to(mesh, np.eye(1, 3) * target[:, None])
    bench.apply("meshing_remove_duplicate_vertices")
    check_taken(mesh, np.array(mesh.vertex_number()), np.array(count + vertices), "number of vertices")
    check_taken(mesh, read_array(mesh, "faces"), np.concatenate([old_faces, added_faces]), "new faces")
    return seed, triangulated


def shrink(bench: Workbench, mesh: Any, vertices: int, faces: Ints) -> None:
    """Restores the old number of `vertices` and the old `faces` after a complete or partial `grow`."""
    if mesh.face_number() > len(faces):
        bench.apply("compute_selection_by_condition_per_face", condselect=f"fi>={len(faces)}")
        bench.apply("meshing_remove_selected_faces")
    if mesh.vertex_number() > vertices:
        target: NDArray[np.intp] = np.zeros(mesh.vertex_number(), dtype=np.intp)
        target[read_array(mesh, "faces")] = faces
        target[:vertices] = np.arange(vertices)
        bench.move_to(mesh, np.eye(1, 3) * target[:, None])
        bench.apply("meshing_remove_duplicate_vertices")
    if mesh.vertex_number() != vertices or not np.array_equal(read_array(mesh, "faces"), faces):
        raise MeshError(f"the faces of {mesh.label()!r} could not be put back")


def _seed(bench: Workbench, mesh: Any, may_seed: Bools) -> tuple[int, bool]:
    """Returns the seed, if possible a triangle outside polygons, and whether polygons were triangulated."""
    # No edge has length 0 now, so these total lengths are equal only without polygons. Listing polygons takes far more memory.
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
    """Cuts the mesh between neighbouring faces with different values of the expression `mark`."""
    bench.apply("compute_normal_by_function_per_face", x=mark, y="0", z="0")
    bench.apply("meshing_vertex_attribute_seam", normalmode="Face", colormode="None", texcoordmode="None")


def _subdivisions(vertices: int, faces: int) -> int:
    """Returns how often to divide the seed: enough for `vertices` and for `faces` whose corners are all made by cutting."""
    times = 1
    while True:
        side = 2**times
        vertices_made = (side + 1) * (side + 2) // 2
        # Not used: the three corners of the seed, its three corners after subdivision, and two thirds of the other vertices.
        if vertices_made - 6 >= 3 * vertices and side * side - vertices_made > faces:
            return times
        times += 1
