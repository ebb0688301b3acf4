"""A pymeshlab mesh as the arrays that filters read."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import Layer
from pymeshfair.errors import MeshError
from pymeshfair.meshset import MeshSet
from tests.host.snapshots import add_attributes, sample
from tests.meshes import icosphere, torus

LINE = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0], [3, 4, 0]])


def test_arrays_are_those_of_the_mesh() -> None:
    """Every array has the mesh's values, the type that the protocol promises, rows one after the other, and cannot be changed."""
    meshes = MeshSet()
    meshes.load_new_mesh(sample("bone.ply"))
    mesh = meshes.current_mesh()
    add_attributes(mesh)
    meshes.compute_scalar_by_function_per_face(q="fi")
    meshes.compute_color_by_function_per_face(r="fi", g="1", b="2", a="3")
    meshes.compute_selection_by_condition_per_vertex(condselect="vi > 10")
    layer: Layer = meshes._bench.current()
    expected: dict[str, tuple[Any, Any]] = {
        "vertices": (mesh.vertex_matrix(), np.float64),
        "faces": (mesh.face_matrix(), np.int32),
        "edges": (mesh.edge_matrix(), np.int32),
        "vertex_normals": (mesh.vertex_normal_matrix(), np.float64),
        "face_normals": (mesh.face_normal_matrix(), np.float64),
        "vertex_selection": (mesh.vertex_selection_array(), np.bool_),
        "face_selection": (mesh.face_selection_array(), np.bool_),
        "vertex_scalars": (mesh.vertex_scalar_array(), np.float64),
        "face_scalars": (mesh.face_scalar_array(), np.float64),
        "vertex_colors": (mesh.vertex_color_matrix(), np.float64),
        "face_colors": (mesh.face_color_matrix(), np.float64),
    }
    for name, (values, dtype) in expected.items():
        array = getattr(layer, name)
        assert array.dtype == dtype, name
        assert array.flags.c_contiguous, name
        assert np.array_equal(array, values), name
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    assert layer.label == "bone.ply"


def test_an_array_is_read_once() -> None:
    """Asking twice gives the same array, so a filter may ask wherever it needs one."""
    meshes = MeshSet()
    meshes.create_cube()
    layer = meshes._bench.current()
    assert layer.vertices is layer.vertices


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (pymeshlab.Mesh(LINE, np.array([[0, 1, 3], [1, 2, 3]])), (1 + 2 + 4 + 5 + np.hypot(2, 4)) / 5),
        (pymeshlab.Mesh(vertex_matrix=LINE, edge_matrix=np.array([[0, 1], [2, 3]])), 2.5),
        (pymeshlab.Mesh(vertex_matrix=LINE), (1 + 1 + 2 + 4) / 4),
        (pymeshlab.Mesh(vertex_matrix=LINE[:1]), 0.0),
    ],
    ids=["surface", "polyline", "cloud", "point"],
)
def test_mean_edge(mesh: Any, expected: float) -> None:
    """The mean of the edges, each counted once; of a cloud the mean distance to the nearest point; of one point 0."""
    meshes = MeshSet()
    meshes.add_mesh(mesh)
    assert meshes._bench.current().mean_edge == pytest.approx(expected, rel=1e-15)


def test_diagonal_is_that_of_the_box_without_the_matrix() -> None:
    """The diagonal is MeshLab's, in the layer's own coordinates."""
    meshes = MeshSet()
    meshes.load_new_mesh(sample("cow.obj"))
    meshes.set_matrix(transformmatrix=np.diag([2.0, 2.0, 2.0, 1.0]), freeze=False)
    box = meshes.current_mesh().bounding_box()
    assert meshes._bench.current().diagonal == pytest.approx(box.diagonal(), rel=1e-15)


def test_selected_vertices_come_from_triangles_when_no_vertex_is_selected() -> None:
    """A vertex counts as selected when all of its triangles are; vertices without triangles do not."""
    vertices, faces = icosphere(1)
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.vstack([vertices, [[9, 9, 9]]]), faces))
    with pytest.raises(MeshError, match="nothing is selected"):
        meshes._bench.current().selected_vertices()
    star = (faces == 0).any(axis=1)
    meshes.compute_selection_by_condition_per_face(condselect=" || ".join(f"fi == {i}" for i in np.flatnonzero(star)))
    assert np.flatnonzero(meshes._bench.current().selected_vertices()).tolist() == [0]
    meshes.compute_selection_by_condition_per_vertex(condselect="vi == 7")
    assert np.flatnonzero(meshes._bench.current().selected_vertices()).tolist() == [7]
    meshes.set_selection_none()
    meshes.compute_selection_by_condition_per_face(condselect="fi == 0")
    with pytest.raises(MeshError, match="triangles on all sides"):
        meshes._bench.current().selected_vertices()


def test_what_a_mesh_lacks_is_said() -> None:
    """Asking for face scalars or colours of a mesh without them is an error that names the mesh; has_... tells before."""
    meshes = MeshSet()
    meshes.load_new_mesh(sample("cow.obj"))
    layer = meshes._bench.current()
    assert (layer.has_face_scalars, layer.has_face_colors, layer.has_vertex_scalars) == (False, False, False)
    with pytest.raises(MeshError, match=r"'cow.obj' has no face scalars"):
        _ = layer.face_scalars
    with pytest.raises(MeshError, match=r"'cow.obj' has no face colors"):
        _ = layer.face_colors


def test_another_layer_can_be_read() -> None:
    """A filter reads other layers by id; one that is not there is an error that lists those that are."""
    meshes = MeshSet()
    meshes.create_cube()
    meshes.add_mesh(pymeshlab.Mesh(*torus()), "ring")
    layer = meshes._bench.current()
    assert np.array_equal(layer.other(0).vertices, meshes.mesh(0).vertex_matrix())
    assert layer.other(1).label == "ring"
    with pytest.raises(MeshError, match=r"there is no layer 5 .*0 'Box/Cube', 1 'ring'"):
        layer.other(5)


def test_another_layer_is_placed_by_both_matrices() -> None:
    """A filter finds another layer where MeshLab shows it, in the coordinates of the current one."""
    meshes = MeshSet()
    for _ in range(2):
        meshes.add_mesh(pymeshlab.Mesh(*icosphere(3)))
    away, twice = np.eye(4), np.diag([2.0, 2.0, 2.0, 1.0])
    away[0, 3] = 5.0
    meshes.set_matrix(transformmatrix=away, freeze=False)
    vertices = meshes.mesh(0).vertex_matrix()
    assert np.array_equal(meshes._bench.current().other(0).vertices, vertices - away[:3, 3])
    assert np.array_equal(meshes._bench.current().other(1).vertices, vertices)
    found = meshes.apply_filter("compute_scalar_by_displacement_per_vertex", reference=0, signed=False)
    assert found["mean_distance"] == pytest.approx(5.0, rel=1e-12)
    found = meshes.apply_filter("compute_selection_by_distance_from_cloud_per_vertex", reference=0)
    assert found["selected_vertices"] == 642
    meshes.set_current_mesh(0)
    meshes.set_matrix(transformmatrix=twice, freeze=False)
    other = meshes._bench.current().other(1)
    assert np.array_equal(other.vertices, (vertices + away[:3, 3]) / 2.0)
    assert np.array_equal(other.other(0).vertices, vertices)


def test_a_layer_is_measured_where_its_matrix_places_it() -> None:
    """Twice as large by its matrix, a layer has four times the area and eight times the volume, as MeshLab says too."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(3)))
    before = meshes.apply_filter("get_surface_measures")
    meshes.set_matrix(transformmatrix=np.diag([2.0, 2.0, 2.0, 1.0]), freeze=False)
    after, theirs = (meshes.apply_filter(name) for name in ("get_surface_measures", "get_geometric_measures"))
    for name, factor in (("area", 4.0), ("volume", 8.0), ("mean_edge", 2.0)):
        assert after[name] == pytest.approx(factor * before[name], rel=1e-12)
    assert after["area"] == pytest.approx(theirs["surface_area"], rel=1e-6)


def test_a_matrix_without_inverse_is_named() -> None:
    """No layer can be placed in the coordinates of a layer that is flattened; the error names it and what to do."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(1)), "far")
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(1)), "flat")
    meshes.set_matrix(transformmatrix=np.diag([1.0, 1.0, 0.0, 1.0]), freeze=False)
    with pytest.raises(MeshError, match=r"the matrix of the layer 'flat' has no inverse: apply .*apply_matrix_freeze"):
        meshes._bench.current().other(0)
    meshes.apply_matrix_freeze()
    assert meshes._bench.current().other(0).label == "far"
