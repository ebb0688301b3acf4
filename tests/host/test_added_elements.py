"""Vertices and faces that a filter adds come last on the same layer, and everything that was there stays to the bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
from matplotlib.image import imsave

from pymeshfair.declaration import Edit
from pymeshfair.errors import MeshError
from pymeshfair.mesh_data import MeshData, apply_edit
from pymeshfair.meshset import MeshSet
from pymeshfair.write_back import Workbench, attributes, write_edit, writing
from tests.host.snapshots import PER_FACE, PER_VERTEX, add_attributes, differences, everything, give_back, same, sample, wild
from tests.host.test_write_back import as_read, coloured_ply, textured_obj
from tests.meshes import icosphere

MESHES = [textured_obj, coloured_ply]
#: what MeshLab derives of the coordinates
DERIVED = {"vertex_normals", "face_normals"}
#: what MeshLab gives a mesh that has texture coordinates at the corners of its faces alone
MADE = {"vertex_uv"}


def additions(meshes: MeshSet, a: int, b: int, seed: int = 3) -> dict[str, Any]:
    """`a` vertices and `b` faces that use old and added vertices in any order."""
    random = np.random.default_rng(seed)
    n = meshes.current_mesh().vertex_number()
    faces = np.stack([random.permutation(n + a)[:3] for _ in range(b)]) if b else np.empty((0, 3), dtype=np.int32)
    if a and b:
        faces[:, 2] = n + np.arange(b)[::-1] % a  # the last of the added vertices comes first
        faces[:, :2] = np.where(faces[:, :2] == faces[:, 2:], [0, 1], faces[:, :2])
        faces[faces[:, 0] == faces[:, 1], 1] = 2
    return {"added_vertices": wild(random, a, 3), "added_faces": faces.astype(np.int32)}


def old_part(state: dict[str, Any], n: int, m: int) -> dict[str, Any]:
    """What `everything` holds of the first n vertices and m faces."""
    cut = dict.fromkeys(PER_VERTEX, n) | dict.fromkeys(PER_FACE, m)
    return {name: value[: cut[name]] if name in cut else value for name, value in state.items()}


@pytest.mark.parametrize(("a", "b"), [(0, 1), (1, 0), (1, 1), (3, 8), (40, 7), (30, 300)])
@pytest.mark.parametrize("make", MESHES, ids=lambda f: f.__name__)
def test_everything_that_was_there_stays(make: Any, a: int, b: int) -> None:
    """Old elements keep every property and their order, the layer its id, label, matrix, textures; the added ones come last."""
    meshes = make()
    handle, before = meshes.current_mesh(), everything(meshes)
    others = [(m.id(), m.label(), m.vertex_matrix()) for m in meshes if m.id() != meshes.current_mesh_id()]
    n, m = handle.vertex_number(), handle.face_number()
    added = additions(meshes, a, b)
    meshes.apply_step(give_back(Edit(**added)))
    after = everything(meshes)
    assert differences(before, old_part(after, n, m), but=DERIVED | (MADE - before.keys())) == []
    assert same(after["vertices"], np.concatenate([before["vertices"], added["added_vertices"]]))
    assert same(after["faces"], np.concatenate([before["faces"], added["added_faces"]]))
    assert same(handle.vertex_matrix(), after["vertices"])
    assert same([m.id() for m in meshes if m.id() != handle.id()], [number for number, *_ in others])
    assert all(meshes.mesh(i).label() == label and same(meshes.mesh(i).vertex_matrix(), v) for i, label, v in others)
    assert not after["vertex_selection"][n:].any()
    assert not after["face_selection"][m:].any()
    assert not any(after[name][n if name[0] == "v" else m :].any() for name in ("va_s", "va_p", "fa_s", "fa_p"))


@pytest.mark.parametrize("make", MESHES, ids=lambda f: f.__name__)
def test_what_the_edit_says_of_all_elements_is_written(make: Any) -> None:
    """Coordinates, colours, scalars, selections and normals given beside the additions are there to the bit."""
    meshes, random = make(), np.random.default_rng(4)
    meshes.set_matrix_identity()
    before = everything(meshes)
    added = additions(meshes, 12, 20)
    n, m = len(before["vertices"]) + 12, len(before["faces"]) + 20
    said: dict[str, Any] = {
        "vertex_scalars": wild(random, n),
        "face_scalars": wild(random, m),
        "vertex_colors": random.integers(0, 256, (n, 4)) / 255.0,
        "face_colors": random.integers(0, 256, (m, 4)) / 255.0,
        "vertex_selection": random.random(n) < 0.5,
        "face_selection": np.arange(m) >= m - 20,
        "face_normals": wild(random, m, 3),
    }
    moved = wild(random, n - 12, 3)
    meshes.apply_step(give_back(Edit(vertices=moved, **added, **said)))
    expected = before | {name: as_read(name, value) for name, value in said.items()}
    expected["vertices"] = np.concatenate([moved, added["added_vertices"]])
    after = everything(meshes)
    kept = {name for name in PER_VERTEX + PER_FACE if name not in said and name != "vertices"} | MADE
    assert differences(expected, after, but=kept | DERIVED - said.keys()) == []
    assert differences(before, old_part(after, n - 12, m - 20), but=DERIVED | MADE | said.keys() | {"vertices"}) == []


def test_normals_are_those_of_the_geometry() -> None:
    """After an addition the normals and the bounding box are those that MeshLab gives a new mesh of the same arrays."""
    meshes = textured_obj()
    meshes.apply_step(give_back(Edit(**additions(meshes, 5, 9))))
    mesh = meshes.current_mesh()
    fresh = pymeshlab.MeshSet()
    fresh.add_mesh(pymeshlab.Mesh(mesh.vertex_matrix(), mesh.face_matrix()))
    fresh.apply_coord_taubin_smoothing(stepsmoothnum=0)
    assert same(mesh.vertex_normal_matrix(), fresh.current_mesh().vertex_normal_matrix())
    assert same(mesh.face_normal_matrix(), fresh.current_mesh().face_normal_matrix())
    assert same(mesh.bounding_box().max(), fresh.current_mesh().bounding_box().max())


def test_added_elements_take_after_their_neighbours() -> None:
    """A vertex has the scalar and texture of the nearest corner, a face the middle of its texture, and colours are blended."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(square, np.array([[0, 1, 2], [0, 2, 3]])))
    meshes.compute_texcoord_by_function_per_vertex(u="x/4", v="y/4")
    meshes.compute_texcoord_transfer_vertex_to_wedge()
    meshes.compute_scalar_by_function_per_vertex(q="vi")
    meshes.compute_scalar_by_function_per_face(q="10+fi")
    meshes.compute_color_by_function_per_vertex(x="14*vi", y="0", z="0", a="255")
    meshes.compute_color_by_function_per_face(r="10+20*fi", g="0", b="0", a="255")
    added = Edit(
        added_vertices=np.array([[1.1, -0.5, 0.0], [1.2, 0.9, 0.0]]),
        added_faces=np.array([[1, 4, 5], [5, 2, 1], [3, 2, 5]], dtype=np.int32),
    )
    meshes.apply_step(give_back(added))
    mesh = meshes.current_mesh()
    assert mesh.vertex_scalar_array()[4:].tolist() == [1, 2]
    # x4 is the mean of corner 1 and x5, x5 that of corners 1, 2, 3 and x4: 10/7 and 13/7.
    assert np.rint(mesh.vertex_color_matrix()[4:, 0] * 255).tolist() == [20, 26]
    assert mesh.vertex_tex_coord_matrix()[4:].tolist() == [[0.25, 0], [0.25, 0.25]]
    assert mesh.face_scalar_array()[2:].tolist() == [10, 10, 10]
    red = np.rint(mesh.face_color_matrix()[2:, 0] * 255)
    assert ((red > 10) & (red < 30)).all()
    corners = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2)
    middle = corners[0].mean(axis=0).astype(np.float32)
    assert (corners[2:] == middle).all()


def test_a_filling_shows_texels_of_faces_and_never_what_lies_beside_their_charts(tmp_path: Path) -> None:
    """The filling of a sheet, red on the left and blue on the right on an atlas that is black elsewhere, is red and blue."""
    pixels = np.zeros((64, 64, 3), dtype=np.uint8)
    pixels[16:48, 16:32], pixels[16:48, 32:48] = (255, 0, 0), (0, 0, 255)
    imsave(tmp_path / "atlas.png", pixels)
    (tmp_path / "sheet.mtl").write_text("newmtl m\nmap_Kd atlas.png\n")
    grid = [(x, y) for y in range(6) for x in range(6)]
    lines = ["mtllib sheet.mtl", *(f"v {x} {y} 0" for x, y in grid)]
    lines += [f"vt {0.25 + x / 10:.6f} {0.25 + y / 10:.6f}" for x, y in grid] + ["usemtl m"]
    for y in range(5):
        for x in range(5):
            if not (0 < x < 4 and 0 < y < 4):
                a, b, c, d = (6 * (y + j) + x + i + 1 for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
                lines += [f"f {a}/{a} {b}/{b} {c}/{c}", f"f {a}/{a} {c}/{c} {d}/{d}"]
    (tmp_path / "sheet.obj").write_text("\n".join(lines))
    meshes = MeshSet()
    meshes.load_new_mesh(str(tmp_path / "sheet.obj"))
    old = meshes.current_mesh().face_number()
    meshes.meshing_close_holes_by_fairing()
    mesh = meshes.current_mesh()
    uv = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2)[old:]
    assert len(uv) > 10
    assert (uv == uv[:, :1]).all()
    seen = pixels[((1 - uv[:, 0, 1]) * 64).astype(int), (uv[:, 0, 0] * 64).astype(int)]
    middles = mesh.vertex_matrix()[mesh.face_matrix()[old:]].mean(axis=1)
    left, right = middles[:, 0] < 1.7, middles[:, 0] > 3.3
    assert left.any()
    assert right.any()
    assert (seen[left] == (255, 0, 0)).all()
    assert (seen[right] == (0, 0, 255)).all()
    assert (seen.sum(axis=1) == 255).all()


def test_a_mesh_without_colours_gets_none(tmp_path: Path) -> None:
    """Closing a hole brings no colours of vertices or faces to a mesh that was read without."""
    vertices, faces = icosphere(1)
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces[1:] + 1]
    (tmp_path / "open.obj").write_text("\n".join(lines))
    meshes = MeshSet()
    meshes.load_new_mesh(str(tmp_path / "open.obj"))
    told = meshes.meshing_close_holes_by_fairing()
    assert told is not None
    assert told["closed_holes"] == 1
    assert not meshes.current_mesh().has_vertex_color()
    assert not meshes.current_mesh().has_face_color()


def test_an_island_of_new_vertices_takes_after_the_nearest_old_one() -> None:
    """A face without any old vertex has the scalar of the old vertex nearest to its own."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]])))
    meshes.compute_scalar_by_function_per_vertex(q="vi")
    edit = Edit(added_vertices=np.eye(3)[::-1] + 0.1, added_faces=np.array([[3, 4, 5]], dtype=np.int32))
    meshes.apply_step(give_back(edit))
    assert meshes.current_mesh().vertex_scalar_array().tolist() == [0, 1, 2, 2, 1, 0]


def two_strips(folder: Path) -> MeshSet:
    """Three rows of four vertices; the strip between the first two rows has the texture 0, the other one the texture 1."""
    lines = ["mtllib two.mtl"]
    lines += [f"v {x} {y} 0" for y in range(3) for x in range(4)]
    lines += ["vt 0.25 0.25", "vt 0.5 0.25", "vt 0.5 0.5"]
    for strip in range(2):
        lines.append(f"usemtl m{strip}")
        for x in range(3):
            corner = 4 * strip + x + 1
            lines += [f"f {corner}/1 {corner + 1}/2 {corner + 5}/3", f"f {corner}/1 {corner + 5}/2 {corner + 4}/3"]
    (folder / "two.obj").write_text("\n".join(lines))
    (folder / "two.mtl").write_text("newmtl m0\nmap_Kd a.png\nnewmtl m1\nmap_Kd b.png\n")
    image = MeshSet()
    image.load_new_mesh(sample("bunny10k_textured.obj"))
    for name in ("a.png", "b.png"):
        next(iter(image.current_mesh().textures().values())).save(str(folder / name))
    meshes = MeshSet()
    meshes.load_new_mesh(str(folder / "two.obj"))
    assert meshes.current_mesh().texture_number() == 2
    return meshes


@pytest.mark.parametrize("wide", [1, 2])
def test_of_several_textures_new_faces_take_the_one_that_most_of_the_rim_has(wide: int, tmp_path: Path) -> None:
    """Of two strips of unlike texture side by side, the one where more vertices of the new faces lie gives its own."""
    meshes = two_strips(tmp_path)
    top = [8, 9, 10, 11]
    added_faces = np.array([[0, 1, 8], [2, 3, 1]] if wide == 1 else [[*top[:3]], [9, 11, 1]], dtype=np.int32)
    meshes.apply_step(give_back(Edit(added_faces=added_faces)))
    meshes.compute_scalar_by_function_per_face(q="ti")
    assert meshes.current_mesh().face_scalar_array().tolist() == [0] * 6 + [1] * 6 + [wide - 1] * 2


def test_each_connected_part_of_new_faces_takes_texture_and_scalars_from_its_own_rim(tmp_path: Path) -> None:
    """Of two strips of unlike texture, each gives its own to the faces that touch it, even where the other strip is nearer."""
    meshes = two_strips(tmp_path)
    meshes.compute_scalar_by_function_per_vertex(q="y")
    meshes.compute_scalar_by_function_per_face(q="ti")
    added = Edit(
        added_vertices=np.array([[1.0, 3.0, 1.0], [1.0, -1.0, 1.0]]),  # beyond the other strip
        added_faces=np.array([[0, 1, 12], [8, 9, 13], [1, 2, 12]], dtype=np.int32),
        face_selection=np.arange(15) == 13,
    )
    meshes.apply_step(give_back(added))
    mesh = meshes.current_mesh()
    assert mesh.face_matrix()[12:].tolist() == [[0, 1, 12], [1, 2, 12], [8, 9, 13]], "faces of one texture come together"
    assert mesh.face_selection_array()[12:].tolist() == [False, False, True]
    assert mesh.face_scalar_array()[12:].tolist() == [0, 0, 1]
    assert mesh.vertex_scalar_array()[12:].tolist() == [0, 2]
    meshes.compute_scalar_by_function_per_face(q="ti")
    assert mesh.face_scalar_array()[12:].tolist() == [0, 0, 1]
    of_faces = {
        "texture": np.repeat([0, 1], 6),
        "wedge_texture_coordinates": mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2)[:12],
    }
    edited = apply_edit(
        MeshData(vertices=mesh.vertex_matrix()[:12], faces=mesh.face_matrix()[:12], face_attributes=of_faces), added
    )
    assert edited.face_attributes["texture"][12:].tolist() == [0, 1, 0]


def test_polygons_stay_where_there_is_a_triangle(tmp_path: Path) -> None:
    """Quadrilaterals stay what they are beside a triangle, on edges of three faces too; alone they become triangles, which is
    said.
    """
    lines = [f"v {x} {y} 0" for x, y in ((0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1), (3, 0))]
    quads = ["f 1 2 3 4", "f 2 5 6 3"]
    for name, faces in (("mixed", [*quads, "f 5 7 6"]), ("three", [*quads, "f 2 3 7 1", "f 5 7 6"]), ("quads", quads)):
        (tmp_path / "mesh.obj").write_text("\n".join(lines + faces))
        notes: list[str] = []
        meshes = MeshSet()
        meshes.on_note = notes.append
        meshes.load_new_mesh(str(tmp_path / "mesh.obj"))
        old = meshes.current_mesh().face_matrix()
        meshes.apply_step(give_back(Edit(added_faces=np.array([[0, 3, 5]], dtype=np.int32), notes=("own",))))
        assert same(meshes.current_mesh().face_matrix(), np.vstack([old, [[0, 3, 5]]]).astype(np.int32))
        polygons = sorted(map(len, meshes.current_mesh().polygonal_face_list()))
        assert polygons == {"mixed": [3, 3, 4, 4], "three": [3, 3, 4, 4, 4], "quads": [3] * 5}[name]
        assert notes[1:] == [] if name != "quads" else "polygons" in notes[1]


@pytest.mark.parametrize(
    ("vertices", "faces"),
    [
        (np.random.default_rng(1).random((8, 3)), [[0, 1, 2], [1, 0, 3], [0, 1, 4], [5, 6, 7], [0, 6, 7]]),  # not manifold
        (np.random.default_rng(1).random((8, 3)), [[5, 6, 7], [0, 1, 2], [1, 0, 3], [0, 1, 4], [0, 1, 4]]),  # not where it grows
        (np.random.default_rng(1).random((9, 3)), [[2, 4, 6]]),  # vertices without faces
        (np.zeros((4, 3)), [[0, 1, 2], [1, 0, 3]]),  # all in one place
        (np.random.default_rng(1).random((4, 3)), [[0, 1, 2], [0, 1, 2], [2, 1, 0]]),  # a face three times
        (np.random.default_rng(1).random((4, 3)) * 1e-200 + 1e9, [[0, 1, 2], [1, 2, 3]]),  # too small for its place
    ],
)
def test_any_mesh_can_be_added_to(vertices: np.ndarray[Any, Any], faces: list[list[int]]) -> None:
    """What is wrong with a mesh stays wrong, and its elements stay in order."""
    meshes = MeshSet()
    old = np.array(faces, dtype=np.int32)
    meshes.add_mesh(pymeshlab.Mesh(vertices, old))
    add_attributes(meshes.current_mesh())
    before = everything(meshes)
    added = additions(meshes, 4, 6)
    meshes.apply_step(give_back(Edit(**added)))
    assert differences(before, old_part(everything(meshes), len(vertices), len(old)), but=DERIVED) == []
    assert same(meshes.current_mesh().face_matrix(), np.vstack([old, added["added_faces"]]))


def test_any_number_of_vertices_and_faces_can_be_added() -> None:
    """From none to seventy vertices, with no face, few faces and many, all come out in order on a mesh of one triangle."""
    for a in range(0, 71, 5):
        for b in (0, 1, 9, 150):
            meshes = MeshSet()
            meshes.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]])))
            added = additions(meshes, a, b, seed=a + b)
            meshes.apply_step(give_back(Edit(**added)))
            assert same(meshes.current_mesh().vertex_matrix(), np.vstack([np.eye(3), added["added_vertices"]]))
            assert same(meshes.current_mesh().face_matrix(), np.vstack([[[0, 1, 2]], added["added_faces"]]).astype(np.int32))


def test_additions_and_deletions_together() -> None:
    """Deletions count old and added elements, and the added faces of a deleted vertex go with it."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 2, 3]])))
    edit = Edit(
        added_vertices=np.ones((1, 3)),
        added_faces=np.array([[0, 1, 4], [1, 2, 4]], dtype=np.int32),
        delete_vertices=np.array([True, False, False, False, False]),
    )
    meshes.apply_step(give_back(edit))
    assert meshes.current_mesh().face_matrix().tolist() == [[0, 1, 3]]
    assert same(meshes.current_mesh().vertex_matrix(), np.vstack([np.eye(4, 3)[1:], np.ones((1, 3))]))


def test_consecutive_filters_see_additions() -> None:
    """Of three filters the second adds elements: the third sees the larger mesh, and what the first did is kept."""
    meshes = textured_obj()
    before = everything(meshes)
    added = additions(meshes, 6, 10)
    n = len(before["vertices"])
    meshes.apply_step(give_back(Edit(vertices=before["vertices"] + 1.0, vertex_scalars=np.arange(n, dtype=float))))
    meshes.apply_step(give_back(Edit(**added)))
    layer = meshes._bench.current()
    assert len(layer.vertices) == n + 6
    assert len(layer.faces) == len(before["faces"]) + 10
    meshes.apply_step(give_back(Edit(vertices=layer.vertices * 2.0)))
    mesh = meshes.current_mesh()
    assert same(mesh.vertex_matrix()[:n], (before["vertices"] + 1.0) * 2.0)
    assert same(mesh.vertex_matrix()[n:], added["added_vertices"] * 2.0)
    assert same(mesh.vertex_scalar_array()[:n], np.arange(n, dtype=float))


def test_ids_of_layers_in_scripts_are_those_without_additions() -> None:
    """A layer made after an addition has in scripts the number that it would have without; additions leave few traces."""
    meshes = textured_obj()
    for _ in range(4):
        meshes.apply_step(give_back(Edit(**additions(meshes, 3, 2))))
    assert meshes.current_mesh_id() == 1
    assert len(meshes) == 3
    meshes.load_new_mesh(sample("cube.obj"))
    assert meshes._bench.without_helpers(meshes.current_mesh_id()) == 3
    meshes.set_current_mesh(1)
    offered = pymeshlab.MeshSet.filter_parameter_values(meshes, "ply")
    assert all(sum(attributes.PREFIX in k and kind in k for k in offered) <= attributes.MOST for kind in ("_vs_", "_fs_"))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        ({"added_faces": np.array([[0, 1, 4]])}, r"1 added_faces .* indices from 0 to 3, first in row 0: \[0, 1, 4\]"),
        ({"added_faces": np.array([[0, 1, 2], [0, -1, 2]])}, r"from 0 to 3, first in row 1: \[0, -1, 2\]"),
        ({"added_faces": np.array([[0, 1, 1]])}, r"1 added_faces .* three different .*, first in row 0: \[0, 1, 1\]"),
        ({"added_faces": np.array([[0.0, 1.0, 2.0]])}, r"shape \(1, 3\) and type float64; they must be \(b, 3\) whole numbers"),
        ({"added_faces": np.array([0, 1, 2])}, r"added_faces of shape \(3,\)"),
        ({"added_vertices": np.zeros((2, 2))}, r"added_vertices of shape \(2, 2\); this mesh needs \(2, 3\)"),
        ({"added_vertices": np.array([[0.0, np.nan, 0.0]])}, "added_vertices with NaN or infinity in 1 of 1 rows"),
        ({"added_vertices": np.zeros((2, 3)), "vertices": np.zeros((6, 3))}, r"vertices of shape \(6, 3\); .* needs \(4, 3\)"),
        ({"added_vertices": np.zeros((2, 3)), "vertex_scalars": np.zeros(4)}, r"vertex_scalars of shape \(4,\); .* needs \(6,\)"),
        ({"added_faces": np.array([[0, 1, 3]]), "face_selection": np.ones(2, dtype=bool)}, r"needs \(3,\)"),
    ],
)
def test_additions_that_do_not_fit_are_refused(edit: dict[str, Any], message: str) -> None:
    """Indices out of range, faces that are none, and arrays of the old length are refused, and the mesh stays as it was."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 2, 3]])))
    before = everything(meshes)
    with pytest.raises(pymeshlab.PyMeshLabException, match=f"^give_back_edit: gave back .*{message}"):
        meshes.apply_step(give_back(Edit(**edit)))
    assert differences(before, everything(meshes)) == []


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (pymeshlab.Mesh(np.eye(3)), "which has no faces; .* return them as a new layer"),
        (pymeshlab.Mesh(np.eye(4, 3), np.array([[0, 1, 2], [1, 1, 2]])), "1 faces of '' have the same vertex twice, .* face 1"),
        (
            pymeshlab.Mesh(vertex_matrix=np.eye(4, 3), face_matrix=np.array([[0, 1, 2]]), edge_matrix=np.array([[0, 3], [3, 0]])),
            "edges of '' occur twice",
        ),
        (pymeshlab.Mesh(np.diag([1.0, 1.0, np.nan]), np.array([[0, 1, 2]])), "coordinates that are not finite"),
    ],
)
def test_meshes_that_cannot_be_added_to_stay_as_they_were(mesh: Any, message: str) -> None:
    """A cloud, degenerate faces, doubled edges and NaN are named and left alone."""
    meshes = MeshSet()
    meshes.add_mesh(mesh)
    before = everything(meshes)
    with pytest.raises(MeshError, match=message):
        meshes.apply_step(give_back(Edit(added_vertices=np.ones((1, 3)))))
    assert differences(before, everything(meshes)) == []


@pytest.mark.parametrize("kind", ["scalar", "point"])
@pytest.mark.parametrize("element", ["vertex", "face"])
@pytest.mark.parametrize("name", ["a b", "A-b", "1a", "é"])
def test_an_attribute_that_meshlab_cannot_compute_with_stops_an_addition_before_it_begins(
    name: str, element: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a custom attribute whose name no expression can hold no filter of MeshLab is applied, and the message names it."""
    meshes = named(name, element, kind)
    before = everything(meshes)
    monkeypatch.setattr(Workbench, "apply", lambda *_, **__: pytest.fail("a filter was applied"))
    with pytest.raises(MeshError, match=f"custom {element} attribute {name!r}: .* letters a to z, digits and _"):
        meshes.apply_step(give_back(Edit(added_vertices=np.ones((1, 3)))))
    assert differences(before, everything(meshes)) == []


@pytest.mark.parametrize(("element", "name"), [("vertex", "vi"), ("vertex", "x"), ("face", "fi"), ("face", "ti")])
def test_an_attribute_that_hides_a_variable_of_meshlab_stops_an_addition_before_it_begins(element: str, name: str) -> None:
    """A custom attribute called as what the expressions ask for is named, and the mesh stays as it was."""
    meshes = named(name, element, "scalar")
    before = everything(meshes)
    with pytest.raises(MeshError, match=f"custom {element} attribute {name!r}: .* no variable or constant of its expressions"):
        meshes.apply_step(give_back(Edit(added_vertices=np.ones((1, 3)))))
    assert differences(before, everything(meshes)) == []


@pytest.mark.parametrize("kind", ["scalar", "point"])
@pytest.mark.parametrize("element", ["vertex", "face"])
@pytest.mark.parametrize("name", ["Label", "distanceToCentre", "Some_Words_in_CAPITALS", "oDD", "X", "FI"])
def test_attributes_with_capitals_stay(name: str, element: str, kind: str) -> None:
    """A custom attribute with capitals keeps its values, and is 0 at added elements."""
    meshes = named(name, element, kind)
    read = getattr(meshes.current_mesh(), f"{element}_custom_{kind}_attribute_" + ("array" if kind == "scalar" else "matrix"))
    before = read(name)
    meshes.apply_step(give_back(Edit(**additions(meshes, 5, 9))))
    after = read(name)
    assert same(after[: len(before)], before)
    assert len(after) > len(before)
    assert not after[len(before) :].any()


def test_an_attribute_whose_spelling_is_not_found_is_named() -> None:
    """Of a long name with capitals in odd places MeshLab tells too little; the mesh stays as it was."""
    meshes = named("vEry_lOng_nAme_with_odd_cApitals", "face", "scalar")
    before = everything(meshes)
    with pytest.raises(MeshError, match="attribute 'very_long_name_with_odd_capitals': MeshLab does not tell which"):
        meshes.apply_step(give_back(Edit(added_vertices=np.ones((1, 3)))))
    assert differences(before, everything(meshes)) == []


def named(attribute: str, element: str, kind: str) -> MeshSet:
    """Two triangles with a custom attribute of that name."""
    meshes = MeshSet()
    mesh = pymeshlab.Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 2, 3]]))
    meshes.add_mesh(mesh)
    mesh = meshes.current_mesh()
    count = mesh.vertex_number() if element == "vertex" else mesh.face_number()
    values = np.random.default_rng(5).normal(size=count if kind == "scalar" else (count, 3))
    getattr(mesh, f"add_{element}_custom_{kind}_attribute")(values, attribute)
    return meshes


class Stopped(BaseException):
    """What an impatient user does."""


@pytest.mark.slow
@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("make", MESHES, ids=lambda f: f.__name__)
def test_an_interrupted_addition_leaves_no_trace(make: Any, late: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped before or after any of MeshLab's filters, the mesh, its place among the layers and their number stay."""
    apply = Workbench.apply
    for stop_at in range(1000):
        meshes = make()
        before, layers = everything(meshes), [(m.id(), m.label()) for m in meshes]
        edit = Edit(**additions(meshes, 3, 8), vertices=before["vertices"] + 1.0)
        count = iter(range(2000))

        def stopping(self: Any, *args: Any, count: Any = count, stop_at: int = stop_at, **kwargs: Any) -> Any:
            here = next(count) == stop_at
            if here and not late:
                raise Stopped
            told = apply(self, *args, **kwargs)
            if here:
                raise Stopped
            return told

        with monkeypatch.context() as patch:
            patch.setattr(Workbench, "apply", stopping)
            try:
                meshes.apply_step(give_back(edit))
            except Stopped:
                pass
            else:
                break
        assert differences(before, everything(meshes), but=MADE - before.keys()) == [], stop_at
        assert [(m.id(), m.label()) for m in meshes] == layers, stop_at
        assert meshes.current_mesh_id() == before["id"]
    assert 20 < stop_at < 999


def test_an_addition_stopped_as_the_matrix_is_put_back_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last of MeshLab's filters gives the layer its matrix back: stopped there once, the mesh and its matrix stay."""
    apply, meshes, stops = Workbench.apply, coloured_ply(), iter([True])
    before = everything(meshes)
    edit = Edit(**additions(meshes, 3, 8), vertices=before["vertices"] + 1.0)

    def stopping(self: Any, name: str, /, **parameters: Any) -> Any:
        if name == "set_matrix" and not np.array_equal(parameters["transformmatrix"], np.eye(4)) and next(stops, False):
            raise Stopped
        return apply(self, name, **parameters)

    monkeypatch.setattr(Workbench, "apply", stopping)
    with pytest.raises(Stopped):
        meshes.apply_step(give_back(edit))
    assert differences(before, everything(meshes)) == []


def test_scalars_that_are_nan_stay_when_an_addition_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are equal to themselves: putting the mesh back writes nothing, so that it gets no helper attribute."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]]), v_scalar_array=np.array([0.0, np.nan, 1.0])))
    monkeypatch.setattr(writing, "grow", lambda *_: (_ for _ in ()).throw(MeshError("no room")))
    monkeypatch.setattr(writing, "bring_in", lambda *_: pytest.fail("values were written"))
    with pytest.raises(MeshError, match=r"no room$"):
        write_edit(Workbench(meshes), Edit(added_vertices=np.ones((1, 3)), added_faces=np.array([[0, 1, 3]])))
    assert same(meshes.current_mesh().vertex_scalar_array(), np.array([0.0, np.nan, 1.0]))


@pytest.mark.parametrize("size", [1e-300, 1e156, 1e300])
def test_meshes_of_any_size_can_be_added_to(size: float) -> None:
    """Where squares of distances overflow or vanish, added elements still take after the nearest ones."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(3) * size, np.array([[0, 1, 2]])))
    meshes.compute_scalar_by_function_per_vertex(q="vi")
    edit = Edit(added_vertices=np.eye(3)[::-1] * size * 1.5, added_faces=np.array([[2, 1, 3]], dtype=np.int32))
    meshes.apply_step(give_back(edit))
    mesh = meshes.current_mesh()
    assert same(mesh.vertex_matrix(), np.vstack([np.eye(3), np.eye(3)[::-1] * 1.5]) * size)
    assert mesh.vertex_scalar_array().tolist()[3:5] == [2, 1]


def test_scalars_of_faces_that_are_all_the_same_bring_no_colours() -> None:
    """With one scalar at all faces a mesh without colours of faces has none after an addition; with unlike ones it has some."""
    for scalars in ([5.0, 5.0], [5.0, 6.0]):
        meshes = MeshSet()
        triangles = np.array([[0, 1, 2], [0, 2, 3]])
        meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=np.eye(4, 3), face_matrix=triangles, f_scalar_array=np.array(scalars)))
        meshes.apply_step(give_back(Edit(added_faces=np.array([[1, 3, 2], [2, 3, 1], [0, 3, 1]]))))
        mesh = meshes.current_mesh()
        assert set(mesh.face_scalar_array()) == set(scalars)
        assert mesh.has_face_color() == (len(set(scalars)) > 1)


def test_edges_stay() -> None:
    """Edges beside faces keep their order and their ends."""
    meshes = MeshSet()
    chain = np.array([[4, 5], [6, 5], [0, 7]])
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=np.eye(8, 3), face_matrix=np.array([[0, 1, 2], [1, 0, 3]]), edge_matrix=chain))
    meshes.apply_step(give_back(Edit(**additions(meshes, 5, 9))))
    assert same(meshes.current_mesh().edge_matrix(), chain.astype(np.int32))


@pytest.mark.parametrize(("make", "extension"), [(textured_obj, "obj"), (coloured_ply, "ply")])
def test_a_saved_file_has_the_additions_and_the_texture(make: Any, extension: str, tmp_path: Path) -> None:
    """Saved and read again, the mesh has its added elements, its texture and no attribute of ours."""
    meshes = make()
    n, m = meshes.current_mesh().vertex_number(), meshes.current_mesh().face_number()
    meshes.apply_step(give_back(Edit(**additions(meshes, 6, 10))))
    file = tmp_path / f"mesh.{extension}"
    meshes.save_current_mesh(str(file))
    again = pymeshlab.MeshSet()
    again.load_new_mesh(str(file))
    assert (again.current_mesh().vertex_number(), again.current_mesh().face_number()) == (n + 6, m + 10)
    assert set(again.current_mesh().textures()) == set(meshes.current_mesh().textures())
    assert again.current_mesh().has_wedge_tex_coord() == (extension == "obj")
    assert attributes.PREFIX.encode() not in file.read_bytes()
