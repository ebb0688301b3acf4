"""Meshes of other packages go into a mesh set and come back; recipes by name; how a mesh set shows itself."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pymeshlab
import pytest
import trimesh
from PIL import Image

from pymeshfair import MeshSet
from pymeshfair.errors import UnknownNameError
from pymeshfair.meshlab.base import ForeignMeshError
from tests.meshes import icosphere, noisy, torus


def taken(mesh: object) -> pymeshlab.Mesh:
    """The current mesh of a mesh set to which a mesh was added."""
    meshes = MeshSet()
    meshes.add_mesh(mesh, "mine")
    assert meshes.current_mesh().label() == "mine"
    return meshes.current_mesh()


def test_trimesh_meshes_keep_geometry_and_colours_both_ways() -> None:
    """Vertices and faces to the bit, colours of vertices and of faces in their eight bits, and the numbering."""
    vertices, faces = torus()
    colors = np.random.default_rng(0).integers(0, 256, size=(len(vertices), 4), dtype=np.uint8)
    meshes = MeshSet()
    meshes.add_mesh(trimesh.Trimesh(vertices, faces, vertex_colors=colors, process=False))
    back = meshes.to_trimesh()
    np.testing.assert_array_equal(back.vertices, vertices)
    np.testing.assert_array_equal(back.faces, faces)
    np.testing.assert_array_equal(back.visual.vertex_colors, colors)
    shades = np.random.default_rng(1).integers(0, 256, size=(len(faces), 4), dtype=np.uint8)
    found = taken(trimesh.Trimesh(vertices, faces, face_colors=shades, process=False))
    np.testing.assert_allclose(255 * found.face_color_matrix(), shades, atol=0.01)
    cloud = MeshSet()
    cloud.add_mesh(trimesh.PointCloud(vertices, colors=colors))  # type: ignore[no-untyped-call]
    np.testing.assert_array_equal(cloud.to_trimesh().vertices, vertices)
    np.testing.assert_array_equal(cloud.to_trimesh().colors, colors)


def test_texture_coordinates_of_trimesh_are_kept() -> None:
    """One pair for each vertex."""
    vertices, faces = icosphere(1)
    uv = np.random.default_rng(2).random((len(vertices), 2))
    looks = trimesh.visual.TextureVisuals(uv=uv)  # type: ignore[no-untyped-call]
    mesh = trimesh.Trimesh(vertices, faces, process=False, visual=looks)
    np.testing.assert_allclose(taken(mesh).vertex_tex_coord_matrix(), uv, rtol=1e-6)


def test_open3d_meshes_and_clouds_are_known_by_their_looks() -> None:
    """What has triangles, or points with normals and colours, is taken with both, tensors through their legacy form."""
    vertices, faces = icosphere(2)
    colors = np.random.default_rng(3).random((len(vertices), 3))
    mesh = SimpleNamespace(vertices=vertices, triangles=faces, vertex_normals=vertices, vertex_colors=colors)
    for given in (mesh, SimpleNamespace(to_legacy=lambda: mesh)):
        found = taken(given)
        np.testing.assert_array_equal(found.vertex_matrix(), vertices)
        np.testing.assert_array_equal(found.face_matrix(), faces)
        np.testing.assert_allclose(found.vertex_color_matrix()[:, :3], colors, atol=1 / 255)
    cloud = taken(SimpleNamespace(points=vertices, normals=-vertices, colors=np.zeros((0, 3))))
    assert cloud.face_number() == 0
    np.testing.assert_allclose(cloud.vertex_normal_matrix(), -vertices, atol=1e-12)


def test_open3d_gets_its_mesh_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """The attributes that Open3D's classes have are set to its vectors; a mesh without faces becomes a cloud."""
    o3d = ModuleType("open3d")
    o3d.geometry = SimpleNamespace(TriangleMesh=SimpleNamespace, PointCloud=SimpleNamespace)  # type: ignore[attr-defined]
    o3d.utility = SimpleNamespace(Vector3dVector=np.array, Vector3iVector=np.array)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "open3d", o3d)
    vertices, faces = icosphere(1)
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    back = meshes.to_open3d()
    np.testing.assert_array_equal(back.vertices, vertices)
    np.testing.assert_array_equal(back.triangles, faces)
    np.testing.assert_allclose(np.linalg.norm(back.vertex_normals, axis=1), 1.0)
    meshes.add_mesh(pymeshlab.Mesh(vertices))
    np.testing.assert_array_equal(meshes.to_open3d().points, vertices)


def test_values_of_trimesh_are_kept_both_ways() -> None:
    """Attributes of vertices and faces become MeshLab's custom ones, under names that its expressions can hold, and come back."""
    vertices, faces = icosphere(1)
    height: dict[str, Any] = {"height": vertices[:, 2], "my flow": vertices, "x": vertices[:, 0]}
    mesh = trimesh.Trimesh(vertices, faces, process=False, vertex_attributes=height, face_attributes={"part": np.arange(80.0)})
    meshes = MeshSet()
    meshes.add_mesh(mesh)
    meshes.compute_scalar_by_function_per_vertex(q="height + x_")
    back = meshes.to_trimesh()
    np.testing.assert_array_equal(back.vertex_attributes["scalar"], vertices[:, 2] + vertices[:, 0])
    np.testing.assert_array_equal(np.column_stack([back.vertex_attributes[f"my_flow_{axis}"] for axis in "xyz"]), vertices)
    np.testing.assert_array_equal(back.face_attributes["part"], np.arange(80.0))
    again = taken(back)
    np.testing.assert_array_equal(again.vertex_scalar_array(), vertices[:, 2] + vertices[:, 0])


def test_values_get_names_of_their_own_or_are_refused_before_there_is_a_layer() -> None:
    """Names that MeshLab would spell alike are kept apart, and values of another number are named with no layer left behind."""
    vertices, faces = icosphere(1)
    values: dict[str, Any] = {name: i + np.arange(42.0) for i, name in enumerate(("a b", "a_b", "A b", "x", "x_"))}
    meshes = MeshSet()
    meshes.add_mesh(trimesh.Trimesh(vertices, faces, process=False, vertex_attributes=values))
    back = meshes.to_trimesh().vertex_attributes
    assert sorted(array[0] for array in back.values()) == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert back.keys() == {"a_b", "a_b_", "A_b__", "x_", "x__"}
    wrong = trimesh.Trimesh(vertices, faces, process=False, vertex_attributes=values | {"heat": np.zeros(7)})
    with pytest.raises(ForeignMeshError, match=r"vertex values 'heat' have the shape \(7,\).* of the mesh, 42: correct"):
        meshes.add_mesh(wrong)
    assert len(meshes) == 1


def test_paths_of_trimesh_keep_their_edges() -> None:
    """A polyline is a mesh of edges, and comes back as a path."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]])
    path = trimesh.path.Path3D([trimesh.path.entities.Line([0, 1, 2, 3])], points, process=False)  # type: ignore[no-untyped-call]
    meshes = MeshSet()
    meshes.add_mesh(path)
    assert meshes.current_mesh().edge_matrix().tolist() == [[0, 1], [1, 2], [2, 3]]
    back = meshes.to_trimesh()
    np.testing.assert_array_equal(back.vertices, points)
    assert back.vertex_nodes.tolist() == [[0, 1], [1, 2], [2, 3]]


def test_a_scene_is_one_mesh_with_its_parts_in_their_places(caplog: pytest.LogCaptureFixture) -> None:
    """Every .glb is a scene: its parts are moved to where they are, and that they are one mesh now is said."""
    ball = trimesh.Trimesh(*icosphere(1), process=False)
    scene = trimesh.Scene()
    scene.add_geometry(ball)
    scene.add_geometry(ball, transform=trimesh.transformations.translation_matrix([5.0, 0, 0]))  # type: ignore[no-untyped-call]
    found = taken(scene)
    assert (found.vertex_number(), found.face_number()) == (84, 160)
    assert found.bounding_box().max()[0] == pytest.approx(6.0)
    assert "the 2 parts of the scene became one mesh" in caplog.text
    with pytest.raises(ForeignMeshError, match="no geometry"):
        MeshSet().add_mesh(trimesh.Scene())


def test_what_another_package_does_not_take_is_named(caplog: pytest.LogCaptureFixture) -> None:
    """The texture of a mesh stays in MeshLab, and a picture of trimesh's does not get there: a warning says each."""
    meshes = MeshSet()
    meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny10k_textured.obj"))
    meshes.to_trimesh()
    assert "the texture stays in MeshLab" in caplog.text
    vertices, faces = icosphere(1)
    image = Image.new("RGB", (2, 2))
    looks = trimesh.visual.TextureVisuals(uv=np.zeros((len(vertices), 2)), image=image)  # type: ignore[no-untyped-call]
    taken(trimesh.Trimesh(vertices, faces, process=False, visual=looks))
    assert "its coordinates are kept" in caplog.text


def test_pyvista_meshes_keep_everything_both_ways() -> None:
    """Triangles, lines, colours, texture coordinates, and values of points and cells."""
    pyvista = pytest.importorskip("pyvista")
    vertices, faces = icosphere(1)
    mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
    colors = np.random.default_rng(5).integers(0, 256, size=(len(vertices), 4), dtype=np.uint8)
    uv = np.random.default_rng(6).random((len(vertices), 2)).astype(np.float32)
    mesh.point_data["heat"], mesh.point_data["RGBA"] = vertices[:, 0], colors
    mesh.cell_data["part"] = np.arange(80.0)
    mesh.active_texture_coordinates = uv
    meshes = MeshSet()
    meshes.add_mesh(mesh)
    back = meshes.to_pyvista()
    np.testing.assert_array_equal(back.points, vertices)
    np.testing.assert_array_equal(back.regular_faces, faces)
    np.testing.assert_array_equal(back.point_data["heat"], vertices[:, 0])
    np.testing.assert_array_equal(back.point_data["RGBA"], colors)
    np.testing.assert_array_equal(back.cell_data["part"], np.arange(80.0))
    np.testing.assert_array_equal(back.active_texture_coordinates, uv)
    line = pyvista.PolyData(vertices[:3], lines=[3, 0, 1, 2])
    meshes.add_mesh(line)
    assert meshes.current_mesh().edge_matrix().tolist() == [[0, 1], [1, 2]]
    np.testing.assert_array_equal(meshes.to_pyvista().lines, [2, 0, 1, 2, 1, 2])


def test_a_mesh_comes_back_with_what_it_had_and_no_more(caplog: pytest.LogCaptureFixture) -> None:
    """Colours of faces and texture coordinates come back, and no colours, scalars or normals that the mesh never had."""
    vertices, faces = icosphere(1)
    shades = np.random.default_rng(1).integers(0, 256, size=(len(faces), 4), dtype=np.uint8)
    uv = np.random.default_rng(2).random((len(vertices), 2)).astype(np.float32)
    looks = trimesh.visual.TextureVisuals(uv=uv)  # type: ignore[no-untyped-call]
    meshes = MeshSet()
    meshes.add_mesh(trimesh.Trimesh(vertices, faces, face_colors=shades, process=False))
    np.testing.assert_array_equal(meshes.to_trimesh().visual.face_colors, shades)
    meshes.add_mesh(trimesh.Trimesh(vertices, faces, visual=looks, process=False))
    np.testing.assert_array_equal(meshes.to_trimesh().visual.uv, uv)
    assert not meshes.to_trimesh().vertex_attributes
    assert "cannot hold" not in caplog.text


def test_a_note_names_what_the_other_package_cannot_hold() -> None:
    """The normals and scalars of a cloud, which a cloud of trimesh lacks, are named in a note."""
    points, said = icosphere(1)[0], list[str]()
    meshes = MeshSet()
    meshes.on_note = said.append
    meshes.add_mesh(pymeshlab.Mesh(points, v_normals_matrix=points, v_scalar_array=points[:, 0]))
    meshes.to_trimesh()
    assert said == ["a mesh of trimesh without faces cannot hold the normals, values of vertices"]


def test_a_cloud_without_normals_and_colours_gets_none() -> None:
    """Open3D and PyVista see no normals, colours or scalars of a cloud that has none."""
    o3d, pyvista = pytest.importorskip("open3d"), pytest.importorskip("pyvista")
    meshes, said = MeshSet(), list[str]()
    meshes.on_note = said.append
    meshes.add_mesh(o3d.geometry.PointCloud(o3d.utility.Vector3dVector(icosphere(1)[0])))
    back = meshes.to_open3d()
    assert (back.has_points(), back.has_normals(), back.has_colors()) == (True, False, False)
    meshes.add_mesh(pyvista.PolyData(icosphere(1)[0]))
    assert meshes.to_pyvista().point_data.keys() == []
    assert said == []


def test_other_packages_get_a_mesh_where_its_matrix_places_it(caplog: pytest.LogCaptureFixture) -> None:
    """The matrix of a layer is applied to vertices and normals, and a note says so."""
    pyvista = pytest.importorskip("pyvista")
    vertices, faces = icosphere(1)
    meshes = MeshSet()
    meshes.add_mesh(pyvista.PolyData.from_regular_faces(vertices, faces))
    normals = meshes.to_pyvista().point_data["Normals"]
    assert caplog.text == ""
    matrix = np.array([[0.0, -3, 0, 7], [3, 0, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]])
    meshes.set_matrix(transformmatrix=matrix, freeze=False)
    np.testing.assert_array_equal(meshes.to_trimesh().vertices, vertices @ matrix[:3, :3].T + [7, 0, 0])
    np.testing.assert_allclose(meshes.to_pyvista().point_data["Normals"], normals @ matrix[:3, :3].T / 3, atol=1e-12)
    assert "the layer's matrix was applied to its coordinates, as other packages do not hold it" in caplog.text


@pytest.mark.filterwarnings("error")
def test_faces_beside_lines_keep_their_values() -> None:
    """PyVista gets a triangle and an edge with the value and the colour of the triangle, and gives them back."""
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData(icosphere(1)[0][:5], faces=[4, 0, 1, 2, 3], lines=[2, 3, 4])
    mesh.cell_data["part"], mesh.cell_data["RGBA"] = [7.0, 8.0], np.array([[1, 2, 3, 4], [5, 6, 7, 8]], np.uint8)
    meshes = MeshSet()
    for given in (mesh, None):
        meshes.add_mesh(meshes.to_pyvista() if given is None else given)
        back = meshes.to_pyvista()
        assert (back.cell_data["part"].tolist(), back.cell_data["RGBA"].tolist()) == ([0, 8, 8], [[0] * 4, *[[5, 6, 7, 8]] * 2])


def test_strips_beside_lines_keep_their_values() -> None:
    """Each triangle of a strip of PyVista has its value, the triangle before it too; VTK mixes them up beside lines."""
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData(icosphere(1)[0][:7], faces=[3, 0, 1, 2], lines=[2, 5, 6], strips=[4, 0, 2, 1, 3, 3, 2, 3, 4])
    mesh.cell_data["part"] = [6.0, 7.0, 8.0, 9.0]
    meshes = MeshSet()
    meshes.add_mesh(mesh)
    assert meshes.current_mesh().face_matrix().tolist() == [[0, 1, 2], [0, 2, 1], [1, 2, 3], [2, 3, 4]]
    assert meshes.to_pyvista().cell_data["part"].tolist() == [0, 7, 8, 8, 9]


def test_meshes_of_a_class_made_from_that_of_pyvista_are_taken() -> None:
    """The constructor of such a class is its own."""
    pyvista = pytest.importorskip("pyvista")

    class Scan(pyvista.PolyData):  # type: ignore[misc, name-defined]
        """A mesh with a name."""

        def __init__(self, name: str, *content: Any, **cells: Any) -> None:
            super().__init__(*content, **cells)
            self.name = name

    for cells in ({}, {"lines": [2, 1, 2]}):
        mesh = Scan("nose", np.eye(3), faces=[3, 0, 1, 2], **cells)
        mesh.cell_data["part"] = np.arange(mesh.n_cells) + 7.0
        meshes = MeshSet()
        meshes.add_mesh(mesh)
        assert meshes.current_mesh().face_custom_scalar_attribute_array("part").tolist() == [mesh.cell_data["part"][-1]]


def test_pyvista_meshes_of_mixed_polygons_and_point_sets_are_taken() -> None:
    """A quad beside a triangle becomes two triangles, each with its value, and a point set is a cloud."""
    pyvista = pytest.importorskip("pyvista")
    vertices = icosphere(1)[0][:5]
    mixed = pyvista.PolyData(vertices, faces=[3, 0, 1, 2, 4, 2, 3, 4, 1])
    mixed.cell_data["part"] = [7.0, 8.0]
    meshes = MeshSet()
    meshes.add_mesh(mixed)
    triangle, *halves = meshes.current_mesh().face_matrix().tolist()
    assert (triangle, len(halves), {*halves[0], *halves[1]}) == ([0, 1, 2], 2, {1, 2, 3, 4})
    assert meshes.to_pyvista().cell_data["part"].tolist() == [7.0, 8.0, 8.0]
    found = taken(pyvista.PointSet(vertices))
    np.testing.assert_array_equal(found.vertex_matrix(), vertices)
    assert found.face_number() == 0


def test_curves_of_paths_become_short_edges() -> None:
    """A circle is a closed polyline of its length, and an arc joins the line at its end; no control point is left over."""
    circle = trimesh.path.creation.circle(radius=2.0)  # type: ignore[no-untyped-call]
    lines = trimesh.path.entities
    points = np.array([[0.0, 0, 0], [1, 1, 0], [2, 0, 0], [2, -3, 0]])
    hook = trimesh.path.Path3D([lines.Arc([0, 1, 2]), lines.Line([2, 3])], points, process=False)  # type: ignore[no-untyped-call]
    for path, length, ends in ((circle, 4 * np.pi, []), (hook, np.pi + 3, [[0, 0, 0], [2, -3, 0]])):
        mesh = taken(path)
        vertices, edges = mesh.vertex_matrix(), mesh.edge_matrix()
        assert np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1).sum() == pytest.approx(length, rel=2e-3)
        uses = np.bincount(edges.ravel(), minlength=len(vertices))
        assert sorted(vertices[uses == 1].tolist()) == ends
        assert set(uses) <= {1, 2}


@pytest.mark.parametrize("kind", [np.float64, np.uint8, np.int64])
def test_colours_of_pyvista_may_be_levels_of_any_type(kind: type, caplog: pytest.LogCaptureFixture) -> None:
    """Levels from 0 to 255 are the same colours as floats and as whole numbers; what is beyond is named and not taken."""
    pyvista = pytest.importorskip("pyvista")
    cloud = pyvista.PolyData(icosphere(1)[0])
    levels = np.random.default_rng(5).integers(0, 256, size=(42, 3))
    cloud.point_data["rgb"] = levels.astype(kind)
    np.testing.assert_allclose(255 * taken(cloud).vertex_color_matrix()[:, :3], levels, atol=0.01)
    assert not caplog.text
    cloud.point_data["rgb"] = levels.astype(np.uint16) * 257
    taken(cloud)
    assert "the colours are not taken, since they are neither from 0 to 1 nor from 0 to 255" in caplog.text


def test_what_meshlab_does_not_take_is_named() -> None:
    """Units and colours of paths of trimesh, texture coordinates and further values of Open3D, and field data of PyVista."""
    o3d, pyvista = pytest.importorskip("open3d"), pytest.importorskip("pyvista")
    vertices, faces = icosphere(1)
    ball = trimesh.Trimesh(vertices, faces, process=False)
    ball.units = "mm"
    path = trimesh.path.Path3D([trimesh.path.entities.Line([0, 1])], vertices[:2], process=False)  # type: ignore[no-untyped-call]
    path.colors = [[255, 0, 0, 255]]
    cloud = o3d.t.geometry.PointCloud(vertices)
    cloud.point["intensity"] = np.zeros((42, 1))
    mesh = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces))
    mesh.triangle_uvs = o3d.utility.Vector2dVector(np.zeros((240, 2)))
    scan = pyvista.PolyData(vertices)
    scan.field_data["scanner"] = ["A"]
    for given, note in (
        (ball, "MeshLab does not take the unit of the mesh"),
        (path, "MeshLab does not take the colours of the path"),
        (cloud, "MeshLab does not take intensity, the point values of Open3D"),
        (mesh, "of the Open3D mesh MeshLab does not take the texture coordinates"),
        (scan, "MeshLab does not take the field data of PyVista"),
    ):
        meshes, said = MeshSet(), list[str]()
        meshes.on_note = said.append
        meshes.add_mesh(given)
        assert said == [note]


def test_open3d_is_said_to_lose_opacity() -> None:
    """A colour of Open3D has no fourth number."""
    pytest.importorskip("open3d")
    meshes, said = MeshSet(), list[str]()
    meshes.on_note = said.append
    meshes.add_mesh(pymeshlab.Mesh(np.eye(3), v_color_matrix=np.full((3, 4), 0.2)))
    meshes.to_open3d()
    assert said == ["a mesh of Open3D cannot hold the opacity"]


def test_other_packages_get_a_layer_that_its_matrix_flattens() -> None:
    """A matrix without an inverse moves the vertices into a plane, and normals to its normal."""
    pyvista = pytest.importorskip("pyvista")
    vertices, faces = icosphere(1)
    meshes = MeshSet()
    meshes.add_mesh(pyvista.PolyData.from_regular_faces(vertices, faces))
    meshes.set_matrix(transformmatrix=np.diag([1.0, 1, 0, 1]), freeze=False)
    back = meshes.to_pyvista()
    np.testing.assert_array_equal(back.points, vertices * [1, 1, 0])
    assert set(np.abs(back.point_data["Normals"][vertices[:, 2] != 0.0]).ravel()) == {0.0, 1.0}


def test_what_is_no_mesh_is_refused_by_its_type() -> None:
    """The message names the type and the packages that are known."""
    with pytest.raises(TypeError, match=r"trimesh, Open3D or PyVista, got a builtins\.str"):
        MeshSet().add_mesh("scan.ply")


def test_a_recipe_is_applied_by_its_name() -> None:
    """The result is that of its steps with these settings, one report a step, and the filter script stays empty."""
    vertices, faces = noisy(icosphere(3), 0.01)
    first, second = MeshSet(), MeshSet()
    for meshes in (first, second):
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    assert len(first.apply_recipe("smooth_implicit")) == 1
    assert not np.array_equal(first.current_mesh().vertex_matrix(), vertices)
    reports = second.apply_recipe("denoise_meshlab_only", rounds=2)
    assert len(reports) == 3
    assert not np.array_equal(first.current_mesh().vertex_matrix(), second.current_mesh().vertex_matrix())
    with pytest.raises(UnknownNameError, match="did you mean 'denoise'"):
        first.apply_recipe("denoize")


def test_a_mesh_set_says_what_is_in_it() -> None:
    """One line a layer, the current one marked."""
    meshes = MeshSet()
    assert str(meshes) == "MeshSet of 0 layers"
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(1)), "<ball>")
    meshes.add_mesh(pymeshlab.Mesh(np.eye(3), np.array([[0, 1, 2]])), "one")
    meshes.add_mesh(pymeshlab.Mesh(icosphere(2)[0]), "cloud")
    lines = ["  0    <ball>: 42 vertices, 80 faces", "  1    one: 3 vertices, 1 face", "  2*   cloud: 162 vertices"]
    assert str(meshes).splitlines() == ["MeshSet of 3 layers", *lines]


def test_a_bare_number_for_a_length_is_answered_with_what_it_may_mean() -> None:
    """Six mean edges, percent or mesh units: the message has each as it is written."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(2)))
    said = r"'detail_size' is a length.*'6edge' for 6 mean edges, '6%' .* or '6' in quotes"
    with pytest.raises(pymeshlab.PyMeshLabException, match=said):
        meshes.apply_coord_implicit_fairing(detail_size=6)  # type: ignore[arg-type]
