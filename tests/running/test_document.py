"""The layers of a run: filters of plugins as in `MeshSet`, filters of MeshLab's as in pymeshlab, to the bit."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

from pymeshfair import MeshSet
from pymeshfair.declaration import Filter
from pymeshfair.errors import MeshError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply_write import write_ply
from pymeshfair.filters.geometry import unit_vectors
from pymeshfair.mesh_data import MeshData, Texture
from pymeshfair.recipe import Recipe
from pymeshfair.registry import find_filter
from pymeshfair.running.document import Document
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from pymeshfair.scripts.script import Script, Step
from tests.contracts.scenes import CHOSEN_BELOW, Scene, apply, arrays_of, mesh_set, scene_for
from tests.contracts.variants import FILTERS
from tests.meshes import icosphere

from .runs import BONE, SAMPLES


def step(name: str, /, **values: Any) -> Step:
    """A step by the Python name of its filter."""
    known = find_filter(name)
    return Step(known, known.check(values), 0)


def mesh_of(scene: Scene, *, select: bool) -> MeshData:
    """A scene as a mesh; `select` selects what `tests.contracts.scenes.mesh_set` selects."""
    vertex: dict[str, Any] = {"scalars": scene.scalars, "colors": np.rint(255 * scene.colors).astype(np.uint8)}
    face: dict[str, Any] = {}
    if select:
        vertex["selection"] = scene.chosen
        face["selection"] = scene.chosen_faces
    return MeshData(vertices=scene.vertices, faces=scene.faces, edges=scene.edges, vertex_attributes=vertex, face_attributes=face)


def arrays(mesh: MeshData) -> dict[str, Any]:
    """What `tests.contracts.scenes.arrays_of` tells of a mesh set, of a mesh."""
    return {
        "vertices": mesh.vertices,
        "faces": mesh.faces,
        "edges": mesh.edges,
        "vertex_scalars": mesh.vertex_scalars,
        "vertex_colors": mesh.vertex_colors,
        "vertex_selection": mesh.vertex_selection,
        "face_selection": mesh.face_selection,
        "face_normals": mesh.face_normals,
    }


@pytest.mark.slow
@pytest.mark.parametrize("declared", FILTERS, ids=lambda f: f.python_name)
def test_our_filters_do_what_they_do_in_a_mesh_set(tmp_path: Path, declared: Filter) -> None:
    """Every filter of ours gives the same arrays and reports the same values in a run and in a program."""
    if any(type(p).__name__ == "Mesh" for p in declared.parameters):
        pytest.skip("compares two layers")
    scene = scene_for(declared)
    document = Document(tmp_path)
    document.add(mesh_of(scene, select=True))
    told = document.apply(Step(declared, {}, 0))[1]
    expected = apply(declared, scene, {})
    assert set(told) == set(expected.values)
    found = arrays(document.current)
    for name, array in expected.arrays.items():
        np.testing.assert_array_equal(found[name], array, err_msg=name)


def outcome_in_pymeshlab(path: Path, name: str) -> dict[str, Any] | None:
    """What a filter with its defaults makes of a file in plain pymeshlab; None if it refuses."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    try:
        meshes.apply_filter(name)
    except Exception:
        return None
    return arrays_of(meshes) if meshes.mesh_number() else {}


@pytest.mark.slow
@pytest.mark.parametrize("path", [BONE, SAMPLES / "rangemaps" / "face000.ply"], ids=lambda p: p.stem)
def test_meshlabs_filters_do_what_they_do_in_pymeshlab(tmp_path: Path, path: Path) -> None:
    """Through the door, vertices, faces, scalars, colours and selection have the bits that plain pymeshlab gives."""
    names = [
        "apply_coord_laplacian_smoothing",
        "meshing_remove_duplicate_vertices",
        "compute_curvature_principal_directions_per_vertex",
    ]
    names += [
        "compute_selection_from_mesh_border",
        "meshing_decimation_quadric_edge_collapse",
        "compute_scalar_by_border_distance_per_vertex",
    ]
    names += [
        "meshing_surface_subdivision_midpoint",
        "compute_color_from_scalar_per_vertex",
        "meshing_close_holes",
        "meshing_invert_face_orientation",
    ]
    for name in names:
        known = find_filter(name)
        expected = outcome_in_pymeshlab(path, known.python_name)
        document = Document(tmp_path / name)
        document.add(read_file(path).mesh)
        if expected is None:
            with pytest.raises(pymeshlab.PyMeshLabException):
                document.apply(step(name))
            continue
        document.apply(step(name))
        found = arrays(document.current)
        for key in ("vertices", "faces", "vertex_scalars", "vertex_colors", "vertex_selection", "face_selection"):
            np.testing.assert_array_equal(found[key], expected[key], err_msg=f"{name} {key}")


def test_what_meshlab_cannot_carry_waits_outside(tmp_path: Path) -> None:
    """Custom attributes and the numbers of elements come back to the vertices that are still the same."""
    mesh = read_file(BONE).mesh
    stamps = np.arange(len(mesh.vertices)) + 0.5
    mesh = mesh.with_attributes({"stamp": stamps}, {"patch": np.arange(len(mesh.faces)) * 2.0})
    document = Document(tmp_path)
    document.add(mesh)
    document.apply(step("meshing_decimation_quadric_edge_collapse", targetfacenum=1000))
    after = document.current
    assert after.vertex_ids is not None
    assert after.face_ids is not None
    assert (after.vertex_ids >= 0).all()
    np.testing.assert_array_equal(after.vertex_attributes["stamp"], after.vertex_ids + 0.5)
    same = after.face_ids >= 0
    np.testing.assert_array_equal(after.face_attributes["patch"], np.where(same, 2.0 * after.face_ids, 0.0))
    corners = np.sort(after.vertex_ids[after.faces[same]], axis=1)
    np.testing.assert_array_equal(corners, np.sort(mesh.faces[after.face_ids[same]], axis=1))
    assert after.source is mesh.source


def test_a_new_mesh_has_no_source(tmp_path: Path) -> None:
    """A filter that makes another mesh loses the numbers, and with them the file."""
    document = Document(tmp_path)
    document.add(read_file(BONE).mesh)
    document.apply(step("generate_resampled_uniform_mesh", cellsize="5%"))
    assert document.current_id == 1
    assert document.current.source is None
    assert document.current.vertex_ids is None or (document.current.vertex_ids == -1).all()


def test_an_expression_may_name_an_attribute_of_the_file(tmp_path: Path) -> None:
    """MeshLab gets the custom attributes that a step names, and those that it makes come back."""
    mesh = read_file(BONE).mesh.with_attributes({"height": read_file(BONE).mesh.vertices[:, 2]})
    document = Document(tmp_path)
    document.add(mesh)
    middle = float(np.median(mesh.vertices[:, 2]))
    document.apply(step("compute_selection_by_condition_per_vertex", condselect=f"height > {middle!r}"))
    np.testing.assert_array_equal(document.current.vertex_selection, mesh.vertices[:, 2] > middle)
    document.apply(step("compute_new_custom_scalar_attribute_per_vertex", name="twice", expr="2*height"))
    np.testing.assert_array_equal(document.current.vertex_attributes["twice"], 2 * mesh.vertices[:, 2])
    document.apply(step("apply_coord_taubin_fairing"))
    np.testing.assert_array_equal(document.current.vertex_attributes["twice"], 2 * mesh.vertices[:, 2])


def test_an_attribute_that_an_expression_reads_keeps_its_type_and_digits(tmp_path: Path) -> None:
    """MeshLab holds it in double precision: whole numbers of 64 bits stay whole and exact, at the vertices that are left."""
    mesh = read_file(BONE).mesh
    numbers = np.arange(len(mesh.vertices)) + 2**60
    document = Document(tmp_path)
    document.add(mesh.with_attributes({"number": numbers}))
    document.apply(step("compute_selection_by_condition_per_vertex", condselect="number >= 0 && vi > 99"))
    document.apply(step("meshing_remove_selected_vertices"))
    np.testing.assert_array_equal(document.current.vertex_attributes["number"], numbers[:100], strict=True)


def test_normals_that_meshlab_transfers_to_a_mesh_are_kept(tmp_path: Path) -> None:
    """A mesh whose file had no normals has those of the other layer, as for filters that are made for normals."""
    vertices, faces = icosphere(2)
    tilted = unit_vectors(vertices + np.eye(3)[2])
    document = Document(tmp_path)
    document.add(MeshData(vertices=vertices, faces=faces, vertex_attributes={"normals": tilted}, keeps_normals=True))
    document.add(MeshData(vertices=vertices, faces=faces))
    document.apply(step("transfer_attributes_per_vertex", sourcemesh=0, targetmesh=1, normaltransfer=True))
    assert document.mesh(1).writes_normals
    np.testing.assert_allclose(document.mesh(1).vertex_normals, tilted, atol=1e-6)


def test_texture_coordinates_that_vertices_get_beside_those_of_corners_are_kept(tmp_path: Path) -> None:
    """A filter that is made to set them sets them in a run, too, and a later filter does not lose them."""
    vertices, faces = icosphere(1)
    wedges = (vertices[:, :2].astype(np.float32) * 2.0)[faces]
    document = Document(tmp_path)
    document.add(MeshData(vertices=vertices, faces=faces, face_attributes={"wedge_texture_coordinates": wedges}))
    document.apply(step("compute_texcoord_transfer_wedge_to_vertex"))
    document.apply(step("apply_coord_taubin_fairing"))
    document.apply(step("set_selection_all"))
    np.testing.assert_array_equal(document.current.vertex_attributes["texture_coordinates"][faces], wedges)


@pytest.mark.parametrize("name", ["apply_normal_robust_filtering_per_face", "apply_normal_smoothing_per_face"])
def test_normals_of_faces_pass_the_door(tmp_path: Path, name: str) -> None:
    """Filters of MeshLab's read and keep those that a filter has made, ours or MeshLab's, as in a mesh set."""
    vertices, faces = icosphere(2)
    vertices = vertices + np.random.default_rng(0).normal(size=vertices.shape) * 0.05
    document, meshes = Document(tmp_path), MeshSet()
    document.add(MeshData(vertices=vertices, faces=faces))
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    for one in (step(name), step("compute_selection_by_condition_per_face", condselect="fnz > 0.5"), step("set_selection_all")):
        document.apply(one)
        meshes.apply_step(one)
        np.testing.assert_array_equal(document.current.face_normals, meshes.current_mesh().face_normal_matrix())
        np.testing.assert_array_equal(document.current.face_selection, meshes.current_mesh().face_selection_array())


def test_normals_of_faces_after_a_mirror_are_numbers(tmp_path: Path) -> None:
    """MeshLab makes them NaN; they are computed from the faces."""
    vertices, faces = icosphere(1)
    document = Document(tmp_path)
    document.add(MeshData(vertices=vertices, faces=faces))
    document.apply(step("apply_normal_smoothing_per_face"))
    document.apply(step("apply_matrix_flip_or_swap_axis", flipx=True))
    np.testing.assert_allclose(np.linalg.norm(document.current.face_normals, axis=1), 1.0)


def test_texture_numbers_beside_coordinates_of_vertices_pass_the_door(tmp_path: Path) -> None:
    """MeshLab gets them with coordinates of corners alone; without, the faces that are left keep theirs."""
    vertices, faces = icosphere(1)
    numbers = (np.arange(len(faces)) % 2).astype(np.int32)
    textures = tuple(Texture(f"{name}.png", None) for name in "ab")
    of_vertices = {"texture_coordinates": vertices[:, :2]}
    document = Document(tmp_path)
    document.add(
        MeshData(
            vertices=vertices, faces=faces, vertex_attributes=of_vertices, face_attributes={"texture": numbers}, textures=textures
        )
    )
    document.apply(step("compute_selection_by_condition_per_face", condselect="fi < 9"))
    document.apply(step("meshing_remove_selected_faces"))
    np.testing.assert_array_equal(document.current.face_attributes["texture"], numbers[9:], strict=True)
    assert document.current.textures == textures


def test_expressions_read_and_change_numbers_of_polygons(tmp_path: Path) -> None:
    """A number of a square in a file counts for both of its triangles."""
    path, document = tmp_path / "square.ply", Document(tmp_path)
    head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    head += "property list uchar int vertex_indices\nproperty int part\nend_header\n"
    path.write_text(f"{head}0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 7\n")
    document.add(read_file(path).mesh)
    document.apply(step("compute_selection_by_condition_per_face", condselect="part == 7"))
    assert document.current.face_selection.tolist() == [True, True]
    document.add(read_file(path).mesh)
    document.apply(step("compute_new_custom_scalar_attribute_per_face", name="part", expr="fi"))
    assert document.current.face_attributes["part"].tolist() == [0.0, 1.0]


def test_a_mesh_that_had_no_faces_gets_some(tmp_path: Path) -> None:
    """Its attributes of faces, also those of its file, are 0 at the faces that MeshLab makes, which belong to no polygon."""
    vertices, path = read_file(BONE).mesh.vertices, tmp_path / "cloud.ply"
    empty = MeshData(vertices=vertices, face_attributes={"part": np.empty(0, np.int16), "polygon": np.empty(0, np.int32)})
    head = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
    head += "element face 0\nproperty list uchar int vertex_indices\nproperty short part\nend_header"
    np.savetxt(path, vertices, header=head, comments="")
    for number, mesh in enumerate((empty, read_file(path).mesh)):
        document = Document(tmp_path / str(number))
        document.add(mesh)
        document.apply(step("generate_surface_reconstruction_ball_pivoting"))
        assert all((values == (0, -1)[name == "polygon"]).all() for name, values in document.current.face_attributes.items())
        document.add(document.current)
        document.apply(step("compute_selection_by_condition_per_face", condselect="fi > 9"))
        assert document.current.face_selection.sum() == len(document.current.faces) - 10 > 0


def test_custom_attributes_of_points_and_with_capitals_come_back(tmp_path: Path) -> None:
    """A new attribute of points, and new values of one whose name has capitals, are in the mesh after MeshLab's step."""
    mesh = read_file(BONE).mesh.with_attributes({"Height": np.zeros(len(read_file(BONE).mesh.vertices))})
    document = Document(tmp_path)
    document.add(mesh)
    document.apply(step("compute_new_custom_scalar_attribute_per_vertex", name="Height", expr="z"))
    document.apply(step("compute_new_custom_scalar_attribute_per_vertex", name="aLongNameWithOddCaPitalsWithin", expr="z"))
    document.apply(step("compute_new_custom_point_attribute_per_vertex", name="place", x_expr="x", y_expr="y", z_expr="z"))
    np.testing.assert_array_equal(document.current.vertex_attributes["Height"], mesh.vertices[:, 2])
    np.testing.assert_array_equal(document.current.vertex_attributes["aLongNameWithOddCaPitalsWithin"], mesh.vertices[:, 2])
    np.testing.assert_array_equal(document.current.vertex_attributes["place"], mesh.vertices)


def test_quads_that_a_step_makes_are_said_to_become_triangles(tmp_path: Path) -> None:
    """It is a loss of the run, unless a later step makes triangles of them."""
    document = Document(tmp_path)
    document.add(read_file(BONE).mesh)
    document.apply(step("meshing_tri_to_quad_by_smart_triangle_pairing"))
    assert document.losses == ["the quads that MeshLab has made are written as triangles"]
    document.apply(step("meshing_poly_to_tri"))
    assert document.losses == []


def test_a_hidden_layer_stays_hidden(tmp_path: Path) -> None:
    """Steps of MeshLab's after one of ours find each layer visible or not, as it was."""
    document = Document(tmp_path)
    document.add(read_file(BONE).mesh)
    document.add(read_file(BONE).mesh)
    assert document.state is not None
    document.restore(document.state._replace(visible={0: False, 1: True}))
    document.apply(step("apply_coord_taubin_smoothing"))
    document.mesh(0), document.mesh(1)
    assert document.state is not None
    assert document.state.visible == {0: False, 1: True}


def test_layers_have_the_ids_of_meshlab(tmp_path: Path) -> None:
    """Ids, labels and the current layer are those of a pymeshlab mesh set after the same steps, ours between them or not."""
    steps = [
        step("generate_copy_of_current_mesh"),
        step("apply_coord_taubin_fairing"),
        step("create_cube"),
        step("generate_copy_of_current_mesh"),
        step("delete_current_mesh"),
        step("create_sphere"),
    ]
    document = Document(tmp_path)
    document.add(read_file(BONE).mesh)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(BONE))
    for one in steps:
        document.apply(one)
        if one.filter.is_builtin:
            meshes.apply_filter(one.filter.python_name)
        there = {mesh.id(): mesh.label() for mesh in meshes}
        assert {number: document.mesh(number).label for number in document.ids} == there
        assert document.current_id == meshes.current_mesh_id()
    with pytest.raises(MeshError, match="there is no layer 9"):
        document.mesh(9)


def test_textures_are_there_for_as_long_as_steps_run(tmp_path: Path) -> None:
    """Colours that MeshLab takes from a texture are those that plain pymeshlab takes, also after a step of ours."""
    from pymeshfair.mesh_data import Texture

    shutil.copy(SAMPLES / "TextureDouble_A.png", tmp_path / "t.png")
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    wedges = vertices[[[0, 1, 2], [0, 2, 3]]][:, :, :2]
    mesh = MeshData(
        vertices=vertices,
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        face_attributes={"wedge_texture_coordinates": wedges, "texture": np.zeros(2, np.int32)},
        textures=(Texture("t.png", tmp_path / "t.png"),),
    )
    document = Document(tmp_path / "door")
    document.add(mesh)
    document.apply(step("apply_coord_explicit_smoothing"))
    document.apply(step("compute_color_from_texture_per_vertex"))
    colors = document.current.vertex_attributes["colors"]
    from PIL import Image

    pixels = np.asarray(Image.open(tmp_path / "t.png").convert("RGB"))
    assert {tuple(c) for c in colors[:, :3].tolist()} <= {tuple(p) for p in pixels.reshape(-1, 3).tolist()}
    assert document.current.textures == mesh.textures


def test_polygons_come_back_whole(tmp_path: Path) -> None:
    """Quads are quads again after a filter of MeshLab's that keeps them, and MeshLab sees them as such."""
    points = np.array([[x, y, 0.0] for y in range(3) for x in range(3)])
    faces = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    mesh = MeshData(vertices=points, faces=faces, face_attributes={"polygon": np.array([0, 0, 1, 1], np.int32)})
    document = Document(tmp_path)
    document.add(mesh)
    measures = document.apply(step("get_geometric_measures"))[1]
    assert measures["total_edge_length"] == 7.0
    document.apply(step("apply_coord_laplacian_smoothing"))
    assert document.current.face_attributes["polygon"].tolist() == [0, 0, 1, 1]


def test_a_corner_that_is_doubled_again_is_a_new_vertex(tmp_path: Path) -> None:
    """Two tetrahedra touch in a point that each has; it becomes one and then two again: what is written has those faces."""
    one: NDArray[np.float64] = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]])
    cells = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], dtype=np.int32)
    scan, target = tmp_path / "scan.ply", tmp_path / "out.ply"
    with scan.open("wb") as file:
        write_ply(MeshData(vertices=np.concatenate([one, -one]), faces=np.concatenate([cells + np.int32(4), cells])), file)
    steps = (step("meshing_remove_duplicate_vertices"), step("meshing_repair_non_manifold_vertices", vertdispratio=0.0))
    run_job(Job(Recipe("doubled", Script(steps)), scan, target))
    before, after = (read_file(path).mesh for path in (scan, target))
    np.testing.assert_array_equal(after.vertices[after.faces], before.vertices[before.faces])


@pytest.mark.parametrize("blades", [2, 4], ids=["manifold", "split"])
def test_elements_that_meshlab_copies_stay_the_same(tmp_path: Path, blades: int) -> None:
    """Faces around an edge are split from each other, and then smoothed: vertices and faces keep numbers and attributes."""
    points = np.array([[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])[: 2 + blades]
    faces = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4], [1, 0, 5]], dtype=np.int32)[:blades]
    heat, label = np.arange(1.0, 3.0 + blades), np.arange(5.0, 5.0 + blades)
    document = Document(tmp_path)
    attributes: Any = {"vertex_attributes": {"heat": heat}, "face_attributes": {"label": label}}
    document.add(MeshData(vertices=points, faces=faces, **attributes))
    document.apply(step("meshing_repair_non_manifold_edges", method="Split Vertices"))
    document.apply(step("apply_coord_laplacian_smoothing"))
    mesh = document.current
    assert mesh.face_ids is None or mesh.face_ids.tolist() == list(range(blades))
    assert mesh.face_attributes["label"].tolist() == label.tolist()
    np.testing.assert_array_equal(mesh.vertex_attributes["heat"][mesh.faces], heat[faces])


def test_faces_keep_their_attributes_when_doubled_corners_become_one(tmp_path: Path) -> None:
    """Two triangles with corners of their own at one edge are the same faces after the corners are merged."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    document = Document(tmp_path)
    faces, label = np.array([[0, 1, 2], [4, 3, 5]], np.int32), np.array([5.0, 6.0])
    document.add(MeshData(vertices=points, faces=faces, face_attributes={"label": label}))
    document.apply(step("meshing_remove_duplicate_vertices"))
    assert len(document.current.vertices) == 4
    assert document.current.face_attributes["label"].tolist() == label.tolist()


def test_new_vertices_have_texture_coordinates_of_the_nearest_old_one(tmp_path: Path) -> None:
    """MeshLab leaves those of the vertices that it adds undefined, other in each run."""
    vertices, faces = icosphere(2)
    uv = np.random.default_rng(0).random((len(vertices), 2)).astype(np.float32)
    document = Document(tmp_path)
    document.add(MeshData(vertices=vertices, faces=faces, vertex_attributes={"texture_coordinates": uv}))
    document.apply(step("meshing_surface_subdivision_midpoint", iterations=1, threshold="0"))
    after = document.current
    distances = np.linalg.norm(after.vertices[:, None] - vertices, axis=2)
    shown = (after.vertex_attributes["texture_coordinates"][:, None] == uv).all(axis=2)
    assert len(after.vertices) > len(vertices)
    np.testing.assert_allclose(np.where(shown, distances, np.inf).min(axis=1), distances.min(axis=1), rtol=1e-12, atol=0)


def test_selections_pass_the_door(tmp_path: Path) -> None:
    """What one of our filters selects, a filter of MeshLab's deletes, and the other way round."""
    scene = scene_for(find_filter("apply_coord_taubin_fairing"))
    document = Document(tmp_path)
    document.add(mesh_of(scene, select=True))
    meshes = mesh_set(scene, select=True)
    for name in ("apply_selection_dilatation", "meshing_remove_selected_vertices"):
        document.apply(step(name))
        meshes.apply_filter(name)
        for key, array in arrays_of(meshes).items():
            if key not in ("face_normals",):
                np.testing.assert_array_equal(arrays(document.current)[key], array, err_msg=f"{name} {key}")
    assert (document.current.vertex_scalars < CHOSEN_BELOW).sum() < scene.chosen.sum()


def test_what_a_filter_of_ours_selects_is_what_meshlab_deletes(tmp_path: Path) -> None:
    """Vertices and faces that are selected when a mesh passes the door count as selected for MeshLab's filters."""
    mesh = read_file(BONE).mesh
    chosen = np.arange(len(mesh.vertices)) < 10
    document = Document(tmp_path)
    document.add(mesh.with_attributes({"selection": chosen}))
    document.apply(step("meshing_remove_selected_vertices"))
    assert len(document.current.vertices) == len(mesh.vertices) - 10
    faces = np.arange(len(mesh.faces)) < 20
    document.add(mesh.with_attributes(face={"selection": faces}))
    document.apply(step("meshing_remove_selected_faces"))
    assert len(document.current.faces) == len(mesh.faces) - 20
