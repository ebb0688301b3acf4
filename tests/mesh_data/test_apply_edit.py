"""What an edit makes of a mesh: the same as in MeshLab's mesh, where that can be compared, and every attribute at its element."""

from __future__ import annotations

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import Edit, NewLayer
from pymeshfair.errors import MeshError
from pymeshfair.mesh_data import MeshData, Source, Texture, apply_edit, as_layer, moved
from pymeshfair.write_back import Workbench, write_edit
from tests.meshes import icosphere

from ..running.runs import SAMPLES

IMAGE = SAMPLES / "TextureDouble_A.png"


def sphere(*, textured: bool = False) -> MeshData:
    """A sphere with everything that a mesh may have."""
    rng = np.random.default_rng(4)
    vertices, faces = icosphere(2)
    n, m = len(vertices), len(faces)
    face = {"colors": rng.integers(0, 256, (m, 4), np.uint8), "scalars": rng.normal(size=m), "area": rng.random(m)}
    if textured:
        face |= {"wedge_texture_coordinates": rng.random((m, 3, 2)).astype("f4").astype(float), "texture": np.zeros(m, np.int32)}
    return MeshData(
        vertices=vertices,
        faces=faces,
        vertex_attributes={
            "colors": rng.integers(0, 256, (n, 4), np.uint8),
            "scalars": rng.normal(size=n),
            "selection": rng.random(n) < 0.5,
            "time": rng.random(n),
        },
        face_attributes=face,
        textures=(Texture("t.png", IMAGE),) if textured else (),
    )


def in_meshlab(mesh: MeshData) -> pymeshlab.MeshSet:
    """The same mesh in MeshLab, without what its constructor does not take."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(
        pymeshlab.Mesh(
            mesh.vertices,
            mesh.faces,
            v_scalar_array=mesh.vertex_scalars,
            f_scalar_array=mesh.face_scalars,
            v_color_matrix=mesh.vertex_colors,
            f_color_matrix=mesh.face_colors,
        )
    )
    return meshes


def cap(mesh: MeshData) -> Edit:
    """Faces 0 and 1 are gone; two vertices and three faces are added."""
    a, b, c = mesh.faces[0].tolist()
    n = len(mesh.vertices)
    points = mesh.vertices[[a, b]] * 1.3
    return Edit(added_vertices=points, added_faces=np.array([[a, b, n], [b, n + 1, n], [b, c, n + 1]], np.int32))


def test_additions_are_those_of_the_write_back() -> None:
    """Scalars and colours of added vertices and faces are what `MeshSet` gives them in MeshLab."""
    mesh = sphere()
    edit = cap(mesh)
    after = apply_edit(mesh, edit)
    meshes = in_meshlab(mesh)
    write_edit(Workbench(meshes), edit)
    there = meshes.current_mesh()
    np.testing.assert_array_equal(after.vertices, there.vertex_matrix())
    np.testing.assert_array_equal(after.faces, there.face_matrix())
    np.testing.assert_array_equal(after.vertex_scalars, there.vertex_scalar_array())
    np.testing.assert_array_equal(after.face_scalars, there.face_scalar_array())
    np.testing.assert_array_equal(after.vertex_attributes["colors"], np.rint(255 * there.vertex_color_matrix()))
    np.testing.assert_array_equal(after.face_attributes["colors"], np.rint(255 * there.face_color_matrix()))


def test_added_elements_are_new_and_have_no_custom_values() -> None:
    """Their numbers are -1, custom attributes and selection 0; all others keep theirs."""
    mesh = sphere(textured=True)
    after = apply_edit(mesh, cap(mesh))
    n, m = len(mesh.vertices), len(mesh.faces)
    assert after.vertex_ids is not None
    assert after.face_ids is not None
    assert after.vertex_ids.tolist() == [*range(n), -1, -1]
    assert after.face_ids.tolist() == [*range(m), -1, -1, -1]
    assert after.vertex_attributes["time"][n:].tolist() == [0.0, 0.0]
    assert after.face_attributes["area"][m:].tolist() == [0.0] * 3
    assert not after.vertex_selection[n:].any()
    for name, values in mesh.vertex_attributes.items():
        np.testing.assert_array_equal(after.vertex_attributes[name][:n], values)
    for name, values in mesh.face_attributes.items():
        np.testing.assert_array_equal(after.face_attributes[name][:m], values)
    wedges = after.face_attributes["wedge_texture_coordinates"][m:]
    assert (wedges == wedges[:, :1]).all(), "an added face shows one place of the texture"
    assert wedges.min() >= 0
    assert wedges.max() <= 1


def test_deleted_vertices_take_their_faces_along() -> None:
    """What is left is numbered anew and keeps its attributes and its numbers in the source."""
    mesh = sphere(textured=True)
    gone = np.zeros(len(mesh.vertices), np.bool_)
    gone[[3, 50]] = True
    gone_faces = np.zeros(len(mesh.faces), np.bool_)
    gone_faces[7] = True
    after = apply_edit(mesh, Edit(delete_vertices=gone, delete_faces=gone_faces))
    left = ~gone[mesh.faces].any(axis=1) & ~gone_faces
    assert after.vertex_ids is not None
    assert after.face_ids is not None
    np.testing.assert_array_equal(after.vertex_ids, np.flatnonzero(~gone))
    np.testing.assert_array_equal(after.face_ids, np.flatnonzero(left))
    np.testing.assert_array_equal(after.vertices[after.faces], mesh.vertices[mesh.faces[left]])
    for name, values in mesh.vertex_attributes.items():
        np.testing.assert_array_equal(after.vertex_attributes[name], values[~gone])
    for name, values in mesh.face_attributes.items():
        np.testing.assert_array_equal(after.face_attributes[name], values[left])


def test_edges_do_not_lose_an_end() -> None:
    """Deleting a vertex at which an edge ends is refused."""
    mesh = MeshData(vertices=np.eye(3), edges=np.array([[0, 1], [1, 2]]))
    with pytest.raises(MeshError, match=r"the 2 edges of '' that end in vertices to be deleted"):
        apply_edit(mesh, Edit(delete_vertices=np.array([False, True, False])))


def test_normals_follow_the_coordinates() -> None:
    """Normals of a mesh are dropped when a vertex moves, and found by angle as MeshLab finds them; a cloud keeps its own."""
    vertices, faces = icosphere(2)
    wrong = np.tile([1.0, 0.0, 0.0], (len(vertices), 1))
    mesh = MeshData(vertices=vertices, faces=faces, vertex_attributes={"normals": wrong}, keeps_normals=True)
    np.testing.assert_array_equal(moved(mesh, vertices.copy()).vertex_normals, wrong)
    other = moved(mesh, vertices * [1.0, 2.0, 0.5])
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(other.vertices, faces))
    sums = meshes.current_mesh().vertex_normal_matrix()
    np.testing.assert_allclose(other.vertex_normals, sums / np.linalg.norm(sums, axis=1)[:, None], atol=1e-14)
    np.testing.assert_array_equal(other.face_normals, meshes.current_mesh().face_normal_matrix())
    cloud = moved(MeshData(vertices=vertices, vertex_attributes={"normals": wrong}), vertices + 1)
    np.testing.assert_array_equal(cloud.vertex_normals, wrong)


def test_vertices_of_no_face_keep_their_normals() -> None:
    """Moved or added elements change the normals of faces and of their corners alone, as in MeshLab."""
    vertices, faces = icosphere(1)
    normals = np.tile([[1.0, 0.0, 0.0]], (len(vertices) + 1, 1))
    mesh = MeshData(vertices=np.append(vertices, [[9.0, 9, 9]], axis=0), faces=faces[1:], vertex_attributes={"normals": normals})
    for after in (moved(mesh, mesh.vertices * 2.0), apply_edit(mesh, Edit(added_faces=faces[:1]))):
        assert after.vertex_normals[-1].tolist() == [1.0, 0.0, 0.0]
        computed = MeshData(vertices=after.vertices, faces=after.faces).vertex_normals
        np.testing.assert_array_equal(after.vertex_normals[:-1], computed[:-1])


def test_values_cannot_be_changed_in_place() -> None:
    """Arrays of a mesh are read-only, attributes too."""
    mesh = sphere()
    for array in (mesh.vertices, mesh.faces, mesh.vertex_attributes["scalars"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_a_new_layer_comes_from_no_file() -> None:
    """Its elements are all new ones, and faces that name no vertex are refused."""
    layer = as_layer(NewLayer(label="cut", vertices=np.eye(3), edges=np.array([[0, 1]], np.int32)))
    assert (layer.label, layer.source, layer.vertex_ids.tolist()) == ("cut", None, [-1, -1, -1])  # type: ignore[union-attr]
    with pytest.raises(MeshError, match="outside 0 to 2"):
        as_layer(NewLayer(label="bad", vertices=np.eye(3), faces=np.array([[0, 1, 3]], np.int32)))


def test_a_matrix_is_applied_to_points_and_normals() -> None:
    """Normals turn with the inverse transpose, so that they stay at right angles to the surface; each keeps its length."""
    rng = np.random.default_rng(0)
    matrix = np.eye(4)
    matrix[:3] = rng.normal(size=(3, 4))
    vertices, faces = icosphere(1)
    lengths = rng.random((len(vertices), 1))
    mesh = MeshData(vertices=vertices, faces=faces, vertex_attributes={"normals": vertices * lengths}, matrix=matrix)
    after = mesh.without_matrix()
    np.testing.assert_allclose(after.vertices, vertices @ matrix[:3, :3].T + matrix[:3, 3])
    a, b = after.vertices[faces[:, 1]] - after.vertices[faces[:, 0]], vertices[faces[:, 1]] - vertices[faces[:, 0]]
    normals = after.vertex_attributes["normals"]
    size = np.linalg.norm(vertices @ np.linalg.inv(matrix[:3, :3]), axis=1, keepdims=True)
    ends = (normals / lengths * size)[faces[:, 0]], vertices[faces[:, 0]]
    np.testing.assert_allclose((a * ends[0]).sum(axis=1), (b * ends[1]).sum(axis=1), atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), lengths[:, 0], atol=1e-15)


def test_a_mesh_knows_its_source_through_two_edits(tmp_path: object) -> None:
    """Numbers of elements are those of the file, whatever was deleted and added before."""
    source = Source(IMAGE, "ply")
    mesh = MeshData(vertices=np.arange(15.0).reshape(5, 3), source=source)
    once = apply_edit(mesh, Edit(delete_vertices=np.array([True, False, False, False, False])))
    twice = apply_edit(once, Edit(delete_vertices=np.array([False, True, False, False])))
    assert twice.vertex_ids is not None
    assert twice.vertex_ids.tolist() == [1, 3, 4]
    assert twice.source is source
