"""Edits go back into MeshLab's meshes in place, to the bit, and touch nothing else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import Arity, Edit, NewLayer
from pymeshfair.mesh_data import MeshData
from pymeshfair.meshset import MeshSet
from pymeshfair.running.document import Document
from pymeshfair.write_back import attributes
from tests.host.snapshots import (
    NORMALS,
    PER_FACE,
    PER_VERTEX,
    add_attributes,
    differences,
    everything,
    give_back,
    same,
    sample,
    wild,
)

#: what an edit can set, with the columns of each
SETTABLE = {
    "vertices": 3,
    "vertex_normals": 3,
    "face_normals": 3,
    "vertex_scalars": 1,
    "face_scalars": 1,
    "vertex_colors": 4,
    "face_colors": 4,
    "vertex_selection": 1,
    "face_selection": 1,
}


def textured_obj() -> MeshSet:
    """A bunny with texture, wedge UV and custom attributes, between two other layers, one of them of the same name and hidden."""
    meshes = MeshSet()
    for name in ("cube.obj", "bunny10k_textured.obj", "bunny10k_textured.obj"):
        meshes.load_new_mesh(sample(name))
    meshes.mesh(2).set_label(meshes.mesh(1).label())
    meshes.set_mesh_visibility(2, False)
    meshes.set_current_mesh(1)
    decorate(meshes)
    return meshes


def coloured_ply() -> MeshSet:
    """An airplane with vertex colours and custom attributes, sheared by a matrix that is not applied, and hidden."""
    meshes = MeshSet()
    meshes.load_new_mesh(sample("colored_airplane.ply"))
    decorate(meshes)
    meshes.set_matrix(transformmatrix=np.array([[1, 2, 3, 4], [0, 1, 0.3, 7], [0, 0, 2, 1 / 3], [0, 0, 0, 1]]), freeze=False)
    meshes.set_current_mesh_visibility(False)
    return meshes


def decorate(meshes: MeshSet) -> None:
    """Selections, scalars, colours and custom attributes for the current mesh."""
    add_attributes(meshes.current_mesh())
    meshes.compute_selection_by_condition_per_vertex(condselect="vi < 100")
    meshes.compute_selection_by_condition_per_face(condselect="fi > 200")
    meshes.compute_scalar_by_function_per_vertex(q="sin(x) / 3")
    meshes.compute_scalar_by_function_per_face(q="cos(fi) / 3")
    meshes.compute_color_by_function_per_vertex(x="vi / 100", y="10", z="20", a="30")
    meshes.compute_color_by_function_per_face(r="fi / 100", g="10", b="20", a="30")


def cloud() -> MeshSet:
    """Points with normals that are not unit vectors, scalars and attributes; some of the points coincide."""
    random = np.random.default_rng(5)
    points = wild(random, 300, 3)
    points[10:20] = points[10]
    meshes = MeshSet()
    mesh = pymeshlab.Mesh(vertex_matrix=points, v_normals_matrix=wild(random, 300, 3), v_scalar_array=wild(random, 300))
    meshes.add_mesh(mesh, "points")
    add_attributes(meshes.current_mesh())
    return meshes


def polyline() -> MeshSet:
    """A chain of edges."""
    random = np.random.default_rng(6)
    chain = np.column_stack([np.arange(199), np.arange(1, 200)])
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=wild(random, 200, 3), edge_matrix=chain), "chain")
    add_attributes(meshes.current_mesh())
    return meshes


def single_point() -> MeshSet:
    """A cloud of one point."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=np.array([[1.0, 2.0, 3.0]])))
    return meshes


KINDS = [textured_obj, coloured_ply, cloud, polyline, single_point]


def random_edit(meshes: MeshSet, random: np.random.Generator, share: float) -> dict[str, Any]:
    """New values for a random `share` of what an edit can set on the current mesh."""
    rows = {"v": meshes.current_mesh().vertex_number(), "f": meshes.current_mesh().face_number()}
    chosen: dict[str, Any] = {}
    for name, columns in SETTABLE.items():
        count = rows[name[0]]
        if not count or random.random() > share:
            continue
        if name.endswith("selection"):
            chosen[name] = random.random(count) < random.choice([0.0, 0.5, 1.0])
        elif columns == 4:
            chosen[name] = random.integers(0, 256, (count, 4)) / 255.0
        else:
            chosen[name] = wild(random, count, 3) if columns == 3 else wild(random, count)
    return chosen


def as_read(name: str, value: Any) -> Any:
    """A value of an edit as `everything` reads it: colours are one number of four bytes, opacity first, then red."""
    if not name.endswith("colors"):
        return value
    red, green, blue, alpha = np.rint(value * 255).astype(np.uint32).T
    return alpha << 24 | red << 16 | green << 8 | blue


@pytest.mark.parametrize("make", KINDS, ids=lambda f: f.__name__)
def test_every_property_is_written_exactly_and_no_other_changes(make: Any) -> None:
    """Twelve random edits, most after the helper attributes are used up, give their values to the bit and nothing else."""
    meshes, random = make(), np.random.default_rng(7)
    others = [meshes[m.id()].vertex_matrix() for m in meshes if m.id() != meshes.current_mesh_id()]
    handle, before = meshes.current_mesh(), everything(meshes)
    for _ in range(12):
        edit = random_edit(meshes, random, 0.5)
        meshes.apply_step(give_back(Edit(**edit)))
        expected = before | {name: as_read(name, value) for name, value in edit.items()}
        after = everything(meshes)
        # face_normal_matrix() applies the matrix; that case is test_normals_under_a_matrix
        unread = {"face_normals"} if not np.array_equal(after["matrix"], np.eye(4)) else set()
        derived = NORMALS - edit.keys() if "vertices" in edit and handle.face_number() else set()
        assert differences(expected, after, but=derived | unread) == []
        before = after
    assert same(handle.vertex_matrix(), before["vertices"])
    assert all(map(same, others, [meshes[m.id()].vertex_matrix() for m in meshes if m.id() != meshes.current_mesh_id()]))


@pytest.mark.parametrize("make", [textured_obj, coloured_ply], ids=lambda f: f.__name__)
def test_moved_vertices_get_the_normals_that_meshlab_gives(make: Any) -> None:
    """After a filter of ours moved the vertices, normals and box are those of a filter of MeshLab that moved them likewise."""
    ours, theirs = make(), make()
    theirs.apply_coord_taubin_smoothing(stepsmoothnum=3)
    ours.apply_step(give_back(Edit(vertices=theirs.current_mesh().vertex_matrix())))
    # MeshLab's Taubin smoothing overwrites the vertex selection
    assert differences(everything(ours), everything(theirs), but={"vertex_selection"}) == []
    assert same(ours.current_mesh().bounding_box().min(), theirs.current_mesh().bounding_box().min())


@pytest.mark.parametrize("mirrored", [False, True])
def test_normals_under_a_matrix(mirrored: bool) -> None:
    """Face normals are read and written as they are stored, although pymeshlab applies the layer's matrix to what it gives."""
    meshes = MeshSet()
    meshes.load_new_mesh(sample("bone.ply"))
    normals = wild(np.random.default_rng(1), meshes.current_mesh().face_number(), 3)
    matrix = np.diag([-1.0 if mirrored else 1.0, 2.0, 3.0, 1.0])
    matrix[0, 1] = 1 / 3
    meshes.set_matrix(transformmatrix=matrix, freeze=False)
    meshes.apply_step(give_back(Edit(face_normals=normals)))
    assert same(meshes._bench.current().face_normals.copy(), normals)
    assert same(meshes.current_mesh().transform_matrix(), matrix)
    meshes.set_matrix_identity()
    assert same(meshes.current_mesh().face_normal_matrix(), normals)


@pytest.mark.parametrize(("make", "extension"), [(textured_obj, "obj"), (coloured_ply, "ply")])
def test_a_file_is_byte_by_byte_what_meshlabs_own_filters_give(make: Any, extension: str, tmp_path: Path) -> None:
    """Coordinates, scalars and a selection from a filter of ours make the files that MeshLab's make, textures included."""
    files = {}
    for whose in ("theirs", "ours"):
        meshes = make()
        meshes.set_selection_none()
        if whose == "theirs":
            meshes.apply_coord_taubin_smoothing(stepsmoothnum=3)
            meshes.compute_scalar_by_function_per_vertex(q="x")
            meshes.compute_selection_by_condition_per_vertex(condselect="x > 0")
            points = meshes.current_mesh().vertex_matrix()
        else:
            x = points[:, 0].copy()
            meshes.apply_step(give_back(Edit(vertices=points, vertex_scalars=x, vertex_selection=x > 0)))
        attributed = {f"__ca_{name[0]}{name[-1]}__{name}": True for name in ("va_s", "va_p", "fa_s", "fa_p")}
        folder = tmp_path / whose
        folder.mkdir()
        meshes.save_current_mesh(str(folder / f"mesh.{extension}"), **(attributed if extension == "ply" else {}))
        files[whose] = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert files["ours"] == files["theirs"]
    assert len(files["ours"]) == (3 if extension == "obj" else 1)  # with its material and texture
    assert extension == "obj" or all(name in files["ours"]["mesh.ply"] for name in (b"va_s", b"va_p", b"fa_s", b"fa_p"))
    assert not any(attributes.PREFIX.encode() in content for content in files["ours"].values())


@pytest.mark.parametrize(
    ("make", "what"),
    [(make, what) for make in (textured_obj, coloured_ply) for what in ("vertices", "faces", "both", "all")]
    + [(make, what) for make in (cloud, single_point) for what in ("vertices", "all")],
)
def test_deletions_keep_the_rest_in_order(make: Any, what: str) -> None:
    """What stays keeps its order, values and selection."""
    meshes, random = make(), np.random.default_rng(8)
    mesh = meshes.current_mesh()
    n, m = mesh.vertex_number(), mesh.face_number()
    gone = np.zeros(n, dtype=np.bool_) if what == "faces" else random.random(n) < (1.1 if what == "all" else 0.1)
    gone_faces = random.random(m) < 0.1 if what in ("faces", "both") else None
    meshes.apply_step(give_back(Edit(vertex_selection=np.arange(n) % 3 == 0)))
    before = everything(meshes)
    meshes.apply_step(give_back(Edit(delete_vertices=gone, delete_faces=gone_faces)))
    after = everything(meshes)
    kept_faces = ~gone[before["faces"]].any(axis=1)
    if gone_faces is not None:
        kept_faces &= ~gone_faces
    expected = before | {name: before[name][~gone] for name in PER_VERTEX if name in before}
    expected |= {name: before[name][kept_faces] for name in PER_FACE if name in before}
    expected["faces"] = (np.cumsum(~gone) - 1)[expected["faces"]].astype(np.int32)
    assert differences(expected, after, but=NORMALS) == []
    assert mesh.vertex_number() == (~gone).sum()


def test_edges_are_not_left_without_ends() -> None:
    """Deleting a vertex of a polyline is refused, as MeshLab would keep its edges; a vertex without edges goes."""
    chain = np.array([[0, 1], [1, 2]])
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=np.eye(4, 3), edge_matrix=chain))
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"the 2 edges of .* would lose an end"):
        meshes.apply_step(give_back(Edit(delete_vertices=np.array([False, True, False, False]))))
    assert meshes.current_mesh().vertex_number() == 4
    meshes.apply_step(give_back(Edit(delete_vertices=np.array([False, False, False, True]))))
    assert meshes.current_mesh().vertex_number() == 3
    assert same(meshes.current_mesh().edge_matrix(), chain.astype(np.int32))


@pytest.mark.parametrize("make", [textured_obj, cloud, polyline], ids=lambda f: f.__name__)
def test_fifty_steps_leave_few_helper_attributes(make: Any) -> None:
    """However many steps there are, a layer ends with at most 12 helper attributes for its vertices and 12 for its faces."""
    meshes, random = make(), np.random.default_rng(9)
    for number in range(50):
        n, m = meshes.current_mesh().vertex_number(), meshes.current_mesh().face_number()
        face_scalars = wild(random, m) if m and number % 3 == 0 else None
        meshes.apply_step(give_back(Edit(vertex_scalars=wild(random, n), face_scalars=face_scalars)))
    offered = pymeshlab.MeshSet.filter_parameter_values(meshes, "ply")
    helpers = [key for key in offered if attributes.PREFIX in key]
    assert len([key for key in helpers if "__ca_vs__" in key]) == attributes.MOST == 12
    assert len([key for key in helpers if "__ca_fs__" in key]) <= attributes.MOST
    assert not [key for key in meshes.filter_parameter_values("ply") if attributes.PREFIX in key]


def test_deletions_under_a_matrix_after_many_steps() -> None:
    """A matrix does not disturb the selection that deletes faces, also when there is no room for further helper attributes."""
    meshes, random = MeshSet(), np.random.default_rng(2)
    meshes.load_new_mesh(sample("bone.ply"))
    meshes.set_matrix(transformmatrix=np.diag([-1.0, 2.0, 3.0, 1.0]), freeze=False)
    faces = meshes.current_mesh().face_matrix()
    for _ in range(attributes.MOST):
        meshes.apply_step(give_back(Edit(face_selection=random.random(len(faces)) < 0.5)))
    gone = random.random(len(faces)) < 0.5
    meshes.apply_step(give_back(Edit(delete_faces=gone)))
    assert same(meshes.current_mesh().face_matrix(), faces[~gone])


def test_moving_vertices_of_a_mesh_leaves_no_attribute() -> None:
    """Coordinates of a mesh with faces come by another way, so nothing is left on it."""
    meshes = textured_obj()
    before = set(pymeshlab.MeshSet.filter_parameter_values(meshes, "ply"))
    meshes.apply_step(give_back(Edit(vertices=meshes.current_mesh().vertex_matrix() + 1.0)))
    assert set(pymeshlab.MeshSet.filter_parameter_values(meshes, "ply")) == before


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        ({"vertices": np.full((4, 3), np.nan)}, "vertices with NaN or infinity in 4 of 4 rows, first in row 0"),
        ({"vertices": np.array([[0, 0, 0]] * 3 + [[0, np.inf, 0]], dtype=float)}, "in 1 of 4 rows, first in row 3"),
        ({"vertices": np.zeros((3, 3))}, r"shape \(3, 3\); this mesh needs \(4, 3\)"),
        ({"vertex_scalars": np.array([0, 1, np.nan, 2])}, "vertex_scalars with NaN"),
        ({"vertex_selection": np.array([0, 1, 0, 1])}, "of type int64; they must be bool"),
        ({"vertex_colors": np.full((4, 4), 2.0)}, "outside 0 to 1, from 2 to 2"),
        ({"vertices": np.array([["x"] * 3] * 4)}, "of type <U1; they must be float64"),
        ({"face_scalars": np.zeros(4)}, r"this mesh needs \(2,\)"),
        (
            {"new_layers": (NewLayer(label="far", vertices=np.array([[0.0, 0, 0], [0, np.nan, 0]])),)},
            "vertices of the new layer 'far' with NaN or infinity in 1 of 2 rows, first in row 1",
        ),
        (
            {"new_layers": (NewLayer(label="far", vertices=np.eye(3), vertex_scalars=np.zeros(2)),)},
            r"vertex_scalars of the new layer 'far' of shape \(2,\); this mesh needs \(3,\)",
        ),
    ],
)
def test_a_result_that_does_not_fit_is_refused(edit: dict[str, Any], message: str) -> None:
    """A filter that gives NaN, or arrays of the wrong length or type, is named, and the mesh stays as it was."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(4, 3), np.array([[0, 1, 2], [0, 2, 3]])))
    before = everything(meshes)
    with pytest.raises(pymeshlab.PyMeshLabException, match=f"^give_back_edit: gave back .*{message}"):
        meshes.apply_step(give_back(Edit(**edit)))
    assert differences(before, everything(meshes)) == []


def test_new_layers_are_added_and_the_first_becomes_current() -> None:
    """New layers hold their arrays to the bit and carry their labels; the layer that the filter read stays as it was."""
    meshes = cloud()
    before = everything(meshes)
    points = wild(np.random.default_rng(3), 5, 3)
    triangle, chain = np.array([[0, 1, 2]], dtype=np.int32), np.array([[0, 1], [1, 4]], dtype=np.int32)
    layers = (
        NewLayer(label="surface", vertices=points, faces=triangle, vertex_scalars=points[:, 0].copy()),
        NewLayer(label="curve", vertices=points, edges=chain),
        NewLayer(label="points of normals", vertices=points, vertex_normals=points * 2),
    )
    meshes.apply_step(give_back(Edit(new_layers=layers)))
    assert [m.label() for m in meshes] == ["points", "surface", "curve", "points of normals"]
    assert meshes.current_mesh().label() == "surface"
    assert all(same(meshes.mesh(i).vertex_matrix(), points) for i in (1, 2, 3))
    assert same(meshes.mesh(1).face_matrix(), triangle)
    assert same(meshes.mesh(1).vertex_scalar_array(), points[:, 0].copy())
    assert same(meshes.mesh(2).edge_matrix(), chain)
    assert same(meshes.mesh(3).vertex_normal_matrix(), points * 2)
    meshes.set_current_mesh(0)
    assert differences(before, everything(meshes)) == []


def test_a_new_layer_has_the_matrix_of_the_layer_that_it_is_made_of(tmp_path: Path) -> None:
    """It lies beside that layer, in a mesh set and in a run; what a filter makes of no layer has no matrix."""
    step = give_back(Edit(new_layers=(NewLayer(label="made", vertices=np.eye(3)), NewLayer(label="too", vertices=np.eye(3)))))
    alone = replace(step, filter=replace(step.filter, arity=Arity.NONE))
    matrix = np.array([[0.0, -2, 0, 5], [2, 0, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]])
    meshes, document = cloud(), Document(tmp_path)
    meshes.set_matrix(transformmatrix=matrix, freeze=False)
    document.add(MeshData(vertices=np.eye(3), matrix=matrix))
    for made in (alone, step):
        meshes.set_current_mesh(0)
        document.current_id = 0
        meshes.apply_step(made)
        document.apply(made)
    assert meshes.current_mesh_id() == document.current_id == 3
    for number, wanted in enumerate([matrix, np.eye(4), np.eye(4), matrix, matrix]):
        np.testing.assert_array_equal(meshes.mesh(number).transform_matrix(), wanted)
        found = document.mesh(number).matrix
        np.testing.assert_array_equal(np.eye(4) if found is None else found, wanted)


def test_an_attribute_that_meshlab_cannot_name_is_said() -> None:
    """A custom attribute whose name no expression can hold stops MeshLab's filters; the message names it."""
    meshes = MeshSet()
    meshes.load_new_mesh(sample("bone.ply"))
    meshes.current_mesh().add_vertex_custom_scalar_attribute(np.zeros(meshes.current_mesh().vertex_number()), "a b")
    scalars = np.arange(meshes.current_mesh().vertex_number(), dtype=float)
    with pytest.raises(pymeshlab.PyMeshLabException, match="because of the name of its custom vertex attribute 'a b'"):
        meshes.apply_step(give_back(Edit(vertex_scalars=scalars)))
    points = meshes.current_mesh().vertex_matrix() + 1.0
    meshes.apply_step(give_back(Edit(vertices=points)))  # coordinates of a mesh need no expression
    assert same(meshes.current_mesh().vertex_matrix(), points)
