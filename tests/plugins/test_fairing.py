"""Fairing as MeshLab users meet it: what is selected, what stays, what is told."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pymeshlab
import pytest

import pymeshfair
from pymeshfair.declaration import Filter
from pymeshfair.filters.fairing.bilaplacian import bilaplacian_smoothing, feature_weights, scalar_feature_weights
from pymeshfair.filters.fairing.blend import blend_parts
from pymeshfair.filters.fairing.region import ENERGIES, Energy, fair_region
from pymeshfair.filters.fairing.tangential import tangential_smoothing
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.holes import remesh_region
from pymeshfair.filters.inspection.surface_measures import surface_measures
from pymeshfair.filters.topology import border_vertices
from pymeshfair.plugins import fairing
from pymeshfair.plugins.moving_vertices import irregular_note
from tests.filters.test_blend import two_opened_spheres, two_tubes
from tests.host.snapshots import NORMALS, add_attributes, differences, everything
from tests.meshes import (
    AWKWARD,
    Floats,
    Mesh,
    cube,
    icosphere,
    irregular_grid,
    noisy,
    rotation,
    sample_path,
    tube,
    two_spheres,
)

REGION = "apply_coord_region_fairing"
ENERGY = "apply_coord_bilaplacian_smoothing"
TANGENTIAL = "apply_coord_tangential_smoothing"
BRIDGE = "meshing_bridge_rims_by_fairing"


def mesh_set(mesh: Mesh, **attributes: Any) -> pymeshfair.MeshSet:
    """A mesh set with this mesh alone."""
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*mesh, **attributes))
    return meshes


def vertices_of(meshes: pymeshfair.MeshSet) -> Floats:
    """The coordinates of the current mesh."""
    return np.asarray(meshes.current_mesh().vertex_matrix())


def select(meshes: pymeshfair.MeshSet, condition: str) -> Any:
    """Which vertices were selected by a condition."""
    meshes.compute_selection_by_condition_per_vertex(condselect=condition)
    return meshes.current_mesh().vertex_selection_array()


# ------------------------------------------------------------------------------------------------------------ region fairing


@pytest.mark.parametrize("energy", ENERGIES)
def test_a_region_is_that_of_the_function(energy: Energy) -> None:
    """The selected vertices go where the technique puts them, the others keep every bit, and the result tells the solution."""
    mesh = noisy(icosphere(3), 0.02)
    meshes = mesh_set(mesh)
    chosen = select(meshes, "z > 0.6")
    told = meshes.apply_filter(REGION, energy=energy)
    expected = fair_region(*mesh, chosen, energy=energy)
    found = vertices_of(meshes)
    np.testing.assert_allclose(found, expected.vertices, rtol=0, atol=1e-12)
    assert found[~chosen].tobytes() == mesh[0][~chosen].tobytes()
    assert told["moved"] == chosen.sum()
    assert told["backward_error"] <= 1e-13
    assert set(told) == {"moved", "backward_error", "last_correction", "refinements"}


def test_selected_triangles_stand_for_their_inner_vertices() -> None:
    """With no vertex selected, those move all of whose triangles are: the same as when these are selected themselves."""
    mesh = noisy(icosphere(3), 0.02)
    by_faces = mesh_set(mesh)
    by_faces.compute_selection_by_condition_per_face(condselect="z0 > 0.5 && z1 > 0.5 && z2 > 0.5")
    by_faces.apply_filter(REGION)
    moved = (vertices_of(by_faces) != mesh[0]).any(axis=1)
    directly = mesh_set(mesh)
    directly.compute_selection_by_condition_per_face(condselect="z0 > 0.5 && z1 > 0.5 && z2 > 0.5")
    directly.compute_selection_transfer_face_to_vertex()
    directly.apply_filter(REGION)
    np.testing.assert_allclose(vertices_of(by_faces), vertices_of(directly), rtol=0, atol=1e-15)
    assert 0 < moved.sum() < (mesh[0][:, 2] > 0.5).sum()


def noted_tube() -> tuple[Mesh, pymeshfair.MeshSet, list[str]]:
    """A noisy open tube, a mesh set with it, and the list that gets the notes of its filters."""
    mesh, notes = noisy(tube(24, 12), 0.02), list[str]()
    meshes = mesh_set(mesh)
    meshes.on_note = notes.append
    return mesh, meshes, notes


def test_borders_stay_and_a_note_says_so() -> None:
    """Of a selection that reaches an open border the border vertices keep every bit; how many is told."""
    (vertices, faces), meshes, notes = noted_tube()
    chosen = select(meshes, "z > 2")
    told = meshes.apply_filter(REGION)
    border = border_vertices(faces, len(vertices))
    moved = (vertices_of(meshes) != vertices).any(axis=1)
    np.testing.assert_array_equal(moved, chosen & ~border)
    assert told["moved"] == moved.sum()
    assert notes == ["24 of the 108 selected vertices lie on an open border or have no triangle, and stay."]


def test_vertices_of_triangles_at_a_border_are_not_remade_and_a_note_says_so() -> None:
    """Of a selection that reaches an open border all vertices of triangles that touch it stay, more than those on it."""
    (vertices, faces), meshes, notes = noted_tube()
    chosen = select(meshes, "z > 1 && x > 0")
    meshes.apply_filter(REGION, remesh=True)
    border = border_vertices(faces, len(vertices))
    touching = np.isin(np.arange(len(vertices)), faces[border[faces].any(axis=1)])
    count, selected = int((chosen & touching).sum()), int(chosen.sum())
    assert count > (chosen & border).sum()
    reason = "have no triangle, or one that touches an open border"
    assert notes == [f"{count} of the {selected} selected vertices {reason}, and stay."]


def test_more_iterations_come_nearer_to_the_soap_film() -> None:
    """Between two rings a membrane's area falls with every repetition and its neck tends to that of the catenoid."""
    around, height = 96, 0.5
    vertices, faces = tube(around, 24, length=2 * height)
    meshes = mesh_set((vertices, faces))
    # the catenoid c cosh(z / c) through radius 1 at z = +-0.5
    c = 0.8483379
    assert c * np.cosh(height / c) == pytest.approx(1.0, abs=1e-6)
    necks = []
    for iterations in (1, 20):
        meshes = mesh_set((vertices, faces))
        select(meshes, "z > 0.001 && z < 0.999")
        meshes.apply_filter(REGION, energy="membrane", iterations=iterations)
        necks.append(np.linalg.norm(vertices_of(meshes)[:, :2], axis=1).min())
    assert abs(necks[1] - c) < 0.01 * c < abs(necks[0] - c)


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ("x > 99", "nothing is selected in .*: select the vertices of the part"),
        ("x < 99", "all vertices are selected.*select the part that is to be faired and leave its surroundings"),
        ("x > 2.5", "touch no fixed vertex.*select less than a whole component"),
    ],
    ids=["nothing", "everything", "a whole component"],
)
def test_selections_that_say_nothing_are_refused(condition: str, message: str) -> None:
    """Nothing, everything, or one of two components as a whole: the message says what to select."""
    meshes = mesh_set(two_spheres())
    before = vertices_of(meshes)
    select(meshes, condition)
    with pytest.raises(pymeshlab.PyMeshLabException, match=message):
        meshes.apply_filter(REGION)
    assert vertices_of(meshes).tobytes() == before.tobytes()


# ---------------------------------------------------------------------------------------------------- bi-Laplacian smoothing


def test_energy_smoothing_is_that_of_the_function() -> None:
    """Lengths are resolved on the mesh, the weight is in mean edges, and what was done is told."""
    mesh = noisy(icosphere(3), 0.02)
    edge = mean_edge_length(*mesh)
    for values, expected in (
        ({}, {"detail_size": 6 * edge}),
        ({"detail_size": pymeshlab.PureValue(0.7), "border": "free"}, {"detail_size": 0.7, "border": "free"}),
        ({"weight": 0.02}, {"detail_size": 2 * np.pi * edge / 0.02**0.25}),
    ):
        meshes = mesh_set(mesh)
        told = meshes.apply_filter(ENERGY, **values)
        wanted = bilaplacian_smoothing(*mesh, **expected)
        np.testing.assert_allclose(vertices_of(meshes), wanted, rtol=0, atol=1e-8)
        assert told["weight"] == pytest.approx((2 * np.pi / expected["detail_size"]) ** 4, rel=1e-5)  # type: ignore[operator]
        assert told["moved"] == len(mesh[0])
        assert told["largest_displacement"] == pytest.approx(np.linalg.norm(wanted - mesh[0], axis=1).max(), rel=1e-5)


def test_features_are_found_or_given() -> None:
    """Weights come from the bending of the surface or from the vertex scalar; a mesh without one is told to get one."""
    vertices, faces = noisy(cube(4), 0.01)
    scalars = (np.abs(vertices - 0.5) > 0.45).sum(axis=1).astype(float)
    for values, weights in (
        ({"features": "curvature"}, feature_weights(vertices, faces, feature_angle=30.0)),
        ({"features": "curvature", "feature_angle": 20.0}, feature_weights(vertices, faces, feature_angle=20.0)),
        ({"features": "scalar", "feature_scalar": 0.5}, scalar_feature_weights(scalars, half=0.5)),
    ):
        meshes = mesh_set((vertices, faces), v_scalar_array=scalars)
        meshes.apply_filter(ENERGY, detail_size=pymeshlab.PureValue(0.6), **values)
        wanted = bilaplacian_smoothing(vertices, faces, detail_size=0.6, feature_weights=weights)
        np.testing.assert_allclose(vertices_of(meshes), wanted, rtol=0, atol=1e-6)
    with pytest.raises(pymeshlab.PyMeshLabException, match="features='scalar' needs vertex scalars, but those of the mesh are 0"):
        mesh_set((vertices, faces)).apply_filter(ENERGY, features="scalar")


@pytest.mark.parametrize("name", [ENERGY, TANGENTIAL])
def test_only_selected_vertices_move(name: str) -> None:
    """With `selected` the others keep every bit."""
    vertices, faces = noisy(tube(), 0.02)
    meshes = mesh_set((vertices, faces))
    chosen = select(meshes, "z > 1.5")
    told = meshes.apply_filter(name, selected=True)
    found = vertices_of(meshes)
    assert 0 < chosen.sum() < len(chosen)
    assert found[~chosen].tobytes() == vertices[~chosen].tobytes()
    assert (found[chosen] != vertices[chosen]).any()
    assert 0 < told["moved"] <= chosen.sum()


def test_fixed_borders_stay_and_smoothed_ones_do_not() -> None:
    """Border vertices keep every bit under "fixed", and move under "along"."""
    vertices, faces = noisy(tube(24, 12), 0.02)
    border = border_vertices(faces, len(vertices))
    for policy in ("fixed", "along"):
        meshes = mesh_set((vertices, faces))
        meshes.apply_filter(ENERGY, border=policy)
        stays = (vertices_of(meshes)[border] == vertices[border]).all()
        assert stays == (policy == "fixed")
        assert (vertices_of(meshes)[~border] != vertices[~border]).any()


@pytest.mark.parametrize("unit", [1e-100, 1e100, 1e150])
@pytest.mark.parametrize("values", [{}, {"weight": 0.02}], ids=["detail size", "weight"])
def test_any_unit_will_do(unit: float, values: dict[str, float]) -> None:
    """A mesh in another unit comes out as in its own, though the fourth power of its lengths is no number."""
    vertices, faces = noisy(icosphere(2), 0.02)
    plain, other = mesh_set((vertices, faces)), mesh_set((unit * vertices, faces))
    plain.apply_filter(ENERGY, **values)
    told = other.apply_filter(ENERGY, **values)
    assert np.abs(vertices_of(plain) - vertices).max() > 0.01
    np.testing.assert_allclose(vertices_of(other) / unit, vertices_of(plain), rtol=0, atol=1e-6)
    assert told["moved"] == len(vertices)
    assert 0.01 * unit < told["largest_displacement"] < unit


def test_a_region_that_shrinks_to_what_holds_it_is_told() -> None:
    """A sphere held by the few rings around one vertex loses its area, and a note says so; held by one vertex it is refused."""
    vertices, faces = icosphere(3)
    meshes = mesh_set((vertices, faces))
    notes: list[str] = []
    meshes.on_note = notes.append
    select(meshes, "z > -0.95")
    meshes.apply_filter(REGION, energy="membrane")
    assert len(notes) == 1
    assert notes[0].startswith("The region's area shrank to 0.0")
    select(meshes, "vi != 5")
    with pytest.raises(pymeshlab.PyMeshLabException, match="are held by 1 fixed vertex alone, such as 5, and would shrink"):
        meshes.apply_filter(REGION)


@pytest.mark.parametrize("iterations", [1, 2])
def test_the_first_solution_of_several_is_noted(iterations: int) -> None:
    """Connectivity alone places a cap squashed to a line, which makes it regular for a second solution: told both times."""
    vertices, faces = icosphere(3)
    vertices[vertices[:, 2] > 0.7] *= [1.0, 1e-6, 1.0]
    meshes = mesh_set((vertices, faces))
    notes: list[str] = []
    meshes.on_note = notes.append
    select(meshes, "z > 0.7")
    meshes.apply_filter(REGION, energy="minimum_variation", iterations=iterations)
    assert notes == [irregular_note(101)]


def test_necks_in_doubt_are_told() -> None:
    """Two cups side by side are joined with a note on their orientation, two that face each other without."""
    for degrees, count in ((90, 1), (0, 0)):
        meshes = mesh_set(two_opened_spheres(degrees))
        notes: list[str] = []
        meshes.on_note = notes.append
        meshes.apply_filter(BRIDGE)
        assert len(notes) == count
        assert all("whether both parts face outwards" in note for note in notes)


def test_nothing_to_do_is_said() -> None:
    """A detail size of 0 with no weight is refused."""
    with pytest.raises(pymeshlab.PyMeshLabException, match="detail_size is 0 and so is weight: nothing to do"):
        mesh_set(icosphere(2)).apply_filter(ENERGY, detail_size="0")


# ------------------------------------------------------------------------------------------------------ tangential smoothing


def test_triangles_are_those_of_the_function_and_better() -> None:
    """Positions are the technique's, the deviation is a length of the mesh, and the quality before and after is told."""
    mesh = irregular_sphere()
    both: list[tuple[dict[str, Any], dict[str, Any]]] = [
        ({}, {"max_deviation": 0.05 * mean_edge_length(*mesh)}),
        ({"weight": 1.0, "iterations": 2, "max_deviation": "1"}, {"weight": 1.0, "iterations": 2, "max_deviation": 1.0}),
    ]
    for values, expected in both:
        meshes = mesh_set(mesh)
        told = meshes.apply_filter(TANGENTIAL, **values)
        found = vertices_of(meshes)
        wanted = tangential_smoothing(*mesh, **expected)[0]
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6)
        assert told["triangle_quality_before"] == surface_measures(*mesh).triangle_quality
        assert told["triangle_quality_after"] == pytest.approx(surface_measures(found, mesh[1]).triangle_quality)
        assert told["triangle_quality_after"] > 1.1 * told["triangle_quality_before"]


def test_open_borders_stay_while_triangles_improve() -> None:
    """Border vertices keep every bit, others move."""
    vertices, faces = irregular_grid(12, 12)
    meshes = mesh_set((vertices, faces))
    meshes.apply_filter(TANGENTIAL)
    moved = (vertices_of(meshes) != vertices).any(axis=1)
    border = border_vertices(faces, len(vertices))
    assert not moved[border].any()
    assert moved[~border].any()
    assert (vertices_of(meshes)[:, 2] == 0.0).all()


def test_flipped_triangles_come_last_and_the_others_stay() -> None:
    """Edges are flipped as the function says; selected triangles stay so in number, kept ones keep order and every attribute."""
    vertices, faces = irregular_grid(12, 12, amount=0.4)
    moved, flipped = tangential_smoothing(vertices, faces, flip_edges=True)
    gone = (np.sort(flipped, axis=1) != np.sort(faces, axis=1)).any(axis=1)
    meshes = mesh_set((vertices, faces), f_scalar_array=np.arange(len(faces), dtype=float))
    meshes.compute_selection_by_condition_per_face(condselect="fi < 100")
    selected = meshes.current_mesh().face_selection_array()
    number = meshes.current_mesh().id()
    told = meshes.apply_filter(TANGENTIAL, flip_edges=True)
    mesh = meshes.current_mesh()
    assert mesh.id() == number
    np.testing.assert_array_equal(mesh.face_matrix(), np.concatenate([flipped[~gone], flipped[gone]]))
    np.testing.assert_allclose(vertices_of(meshes), moved, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(mesh.face_scalar_array()[: (~gone).sum()], np.flatnonzero(~gone))
    np.testing.assert_array_equal(mesh.face_selection_array(), np.concatenate([selected[~gone], selected[gone]]))
    assert told["changed_triangles"] == gone.sum() > 0
    assert told["triangle_quality_after"] == pytest.approx(surface_measures(moved, flipped).triangle_quality)


def test_no_edge_of_a_textured_mesh_is_flipped() -> None:
    """Triangles and their texture coordinates stay, vertices move as without flips."""
    vertices, faces = irregular_grid(12, 12, amount=0.4)
    meshes = mesh_set((vertices, faces))
    meshes.compute_texcoord_by_function_per_vertex(u="x/12", v="y/12")
    meshes.compute_texcoord_transfer_vertex_to_wedge()
    corners = meshes.current_mesh().wedge_tex_coord_matrix()
    told = meshes.apply_filter(TANGENTIAL, flip_edges=True)
    mesh = meshes.current_mesh()
    np.testing.assert_array_equal(mesh.face_matrix(), faces)
    np.testing.assert_array_equal(mesh.wedge_tex_coord_matrix(), corners)
    np.testing.assert_allclose(vertices_of(meshes), tangential_smoothing(vertices, faces)[0], rtol=0, atol=1e-6)
    assert told["changed_triangles"] == 0


def irregular_sphere() -> Mesh:
    """A unit sphere whose vertices are shifted along it at random."""
    vertices, faces = noisy(icosphere(3), 0.03)
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True), faces


# -------------------------------------------------------------------------------------------------------- bridges of rims


@pytest.mark.parametrize("energy", ENERGIES)
def test_a_bridge_is_that_of_the_function_and_selected(energy: Energy) -> None:
    """Vertices and faces come after those of the mesh, which keep every bit; they alone are selected, and counted."""
    vertices, faces = two_tubes(24, 31, tilt=0.3)
    meshes = mesh_set((vertices, faces))
    select(meshes, "z < 1")
    told = meshes.apply_filter(BRIDGE, energy=energy)
    blend = blend_parts(vertices, faces, energy=energy)
    mesh = meshes.current_mesh()
    assert vertices_of(meshes)[: len(vertices)].tobytes() == vertices.tobytes()
    np.testing.assert_allclose(vertices_of(meshes)[len(vertices) :], blend.vertices, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(mesh.face_matrix(), np.concatenate([faces, blend.faces]))
    np.testing.assert_array_equal(mesh.vertex_selection_array(), np.arange(mesh.vertex_number()) >= len(vertices))
    np.testing.assert_array_equal(mesh.face_selection_array(), np.arange(mesh.face_number()) >= len(faces))
    assert told == {
        "new_vertices": len(blend.vertices),
        "new_faces": len(blend.faces),
        "first_rim_edges": 24,
        "second_rim_edges": 31,
    }


def test_two_selected_rims_of_one_part_get_a_handle() -> None:
    """With `selected` a tube is closed upon itself; without, there is no second part, and it is said what is missing."""
    mesh = tube(24, 9, length=1.0)
    meshes = mesh_set(mesh)
    with pytest.raises(pymeshlab.PyMeshLabException, match="no two rims of different components to join: 2 found; put both"):
        meshes.apply_filter(BRIDGE)
    select(meshes, "z < 0.01 || z > 0.99")
    meshes.apply_filter(BRIDGE, selected=True)
    assert surface_measures(vertices_of(meshes), meshes.current_mesh().face_matrix()).border_edges == 0


def test_what_the_parts_carry_stays() -> None:
    """Colours, scalars and custom attributes of the parts keep every bit, and new vertices take those of the rims near them."""
    vertices, faces = two_tubes()
    scalars = vertices[:, 2].copy()
    meshes = mesh_set((vertices, faces), v_scalar_array=scalars)
    add_attributes(meshes.current_mesh())
    before = everything(meshes)
    meshes.apply_filter(BRIDGE)
    after = everything(meshes)
    for name in ("vertex_scalars", "vertex_colors", "va_s", "va_p"):
        assert np.array_equal(after[name][: len(vertices)], before[name]), name
    assert (after["id"], after["label"]) == (before["id"], before["label"])
    assert set(np.round(after["vertex_scalars"][len(vertices) :], 6)) == {3.0, 4.5}


# ------------------------------------------------------------------------------------------------------------ all of them

NAMES = (REGION, ENERGY, TANGENTIAL)
DECLARED: list[Filter] = [getattr(fairing, name) for name in (*NAMES, BRIDGE)]


@pytest.mark.parametrize("name", NAMES)
def test_everything_but_the_coordinates_is_kept(name: str) -> None:
    """Selection, colours, scalars, texture coordinates, textures and custom attributes keep every bit."""
    meshes = pymeshfair.MeshSet()
    meshes.load_new_mesh(str(sample_path("bunny10k_textured.obj")))
    add_attributes(meshes.current_mesh())
    meshes.compute_selection_by_condition_per_vertex(condselect="vi > 100 && vi < 140")
    before = everything(meshes)
    meshes.apply_filter(name)
    assert set(differences(before, everything(meshes))) == {"vertices"} | NORMALS


@pytest.mark.parametrize("name", [n for n in AWKWARD if n != "empty"])
def test_awkward_meshes_go_through_every_filter(name: str) -> None:
    """Coordinates stay finite and unselected vertices where they are, or an error of ours says what is wrong."""
    vertices, faces = AWKWARD[name]()
    given: list[tuple[str, dict[str, Any]]] = [(REGION, {"energy": energy}) for energy in ENERGIES]
    given += [
        (ENERGY, {"selected": True}),
        (ENERGY, {"features": "curvature", "selected": True}),
        (TANGENTIAL, {"selected": True}),
    ]
    for python_name, values in given:
        meshes = mesh_set((vertices, faces))
        before = vertices_of(meshes)
        chosen = select(meshes, "vi > 1" if len(vertices) < 20 else "vi > 10 && vi < 40")
        said = ""
        try:
            meshes.apply_filter(python_name, **values)
        except pymeshlab.PyMeshLabException as error:
            said = str(error)
        assert not said or re.search(
            "touch no fixed vertex|are held by|nothing is selected|ill-conditioned|nothing to do", said
        ), said
        assert np.isfinite(vertices_of(meshes)).all()
        np.testing.assert_array_equal(vertices_of(meshes)[~chosen], before[~chosen])


def test_a_remade_region_has_good_triangles_and_the_rest_keeps_every_bit() -> None:
    """A crumpled cap of a sphere is smooth and regular when it is remade; faired alone it keeps bad triangles."""
    vertices, faces = icosphere(4)
    edge = mean_edge_length(vertices, faces)
    crumpled = vertices[:, 2] > 0.85
    damaged = vertices + edge * np.random.default_rng(2).normal(size=vertices.shape) * crumpled[:, None]
    chosen = crumpled.copy()
    chosen[faces[crumpled[faces].any(axis=1)]] = True
    qualities = []
    for remesh in (False, True):
        meshes = mesh_set((damaged, faces), v_scalar_array=chosen.astype(float))
        select(meshes, "q > 0.5")
        values = meshes.apply_coord_region_fairing(energy="minimum_variation", remesh=remesh)
        mesh = meshes.current_mesh()
        measures = surface_measures(mesh.vertex_matrix(), mesh.face_matrix())
        assert measures.border_edges == 0
        new = mesh.vertex_selection_array()
        at = new[mesh.face_matrix()].any(axis=1)
        qualities.append(qualities_of(mesh.vertex_matrix(), mesh.face_matrix()[at]))
    assert values is not None
    assert np.array_equal(mesh.vertex_matrix()[~new], damaged[~chosen])
    assert (values["deleted_vertices"], values["new_vertices"]) == (chosen.sum(), new.sum())
    # As dense as around: edges within a factor of sqrt(2).
    assert 0.5 * chosen.sum() < new.sum() < 2 * chosen.sum()
    assert qualities[1].min() > 0.3 > qualities[0].min()
    assert qualities[1].mean() > 0.8
    # The cap of a sphere, continued in its curvature from a rim that is on it.
    assert np.abs(np.linalg.norm(mesh.vertex_matrix(), axis=1) - 1.0).max() < 0.05


def test_a_remade_region_does_not_depend_on_place_size_numbers_and_stray_vertices() -> None:
    """Turned, scaled and renumbered, with a vertex that no face uses, the new vertices are the same to what solving leaves."""
    vertices, faces = noisy(icosphere(3), 0.02)
    order = np.random.default_rng(1).permutation(len(vertices) + 1)
    turn = rotation(1)
    everything_moved = 3.7 * np.concatenate([vertices, [[9.0, 9.0, 9.0]]]) @ turn.T + 2.0
    moved = np.empty_like(everything_moved)
    moved[order] = everything_moved
    chosen = vertices[:, 2] > 0.6
    expected = remesh_region(vertices, faces, chosen)[1].new_vertices
    elsewhere = np.zeros(len(order), dtype=np.bool_)
    elsewhere[order[:-1]] = chosen
    found = remesh_region(moved, order[faces], elsewhere)[1].new_vertices
    back = (found - 2.0) / 3.7 @ turn
    apart = np.linalg.norm(back[:, None] - expected, axis=2)
    assert len(back) == len(expected)
    # 1e-11 is what fairing is solved to, in three rounds.
    assert apart.min(axis=1).max() < 1e-9


def qualities_of(vertices: Floats, faces: Any) -> Floats:
    """4 sqrt(3) area over the sum of the squared edges of each triangle, 1 for equilateral ones."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    squares = ((b - a) ** 2 + (c - b) ** 2 + (a - c) ** 2).sum(axis=1)
    return np.asarray(2.0 * np.sqrt(3.0) * np.linalg.norm(np.cross(b - a, c - a), axis=1) / squares)


def test_regions_that_cannot_be_remade_are_refused() -> None:
    """At an open border triangles stay; of a whole component nothing is left beside; two patches in a belt would cut the mesh."""
    for mesh, condition, message in (
        (tube(), "z < 0.6", "all of the region lies at an open border"),
        (two_spheres(), "x < 2", "a whole component is selected"),
        (icosphere(2), "z < 0.999", "a whole component is selected"),
        (icosphere(3), "z > -0.3 && z < 0.3", "the region goes all round the mesh"),
        (tube(24, 16), "z > 1.2 && z < 1.8", "the region goes all round the mesh"),
    ):
        meshes = mesh_set(mesh)
        select(meshes, condition)
        with pytest.raises(pymeshlab.PyMeshLabException, match=message):
            meshes.apply_coord_region_fairing(remesh=True)


def test_a_vertex_left_out_inside_a_remade_region_goes_with_its_triangles() -> None:
    """The top of a cap is not selected, and all of its triangles are replaced: no vertex without a triangle is left."""
    vertices, faces = icosphere(3)
    chosen = (vertices[:, 2] > 0.6) & (np.arange(len(vertices)) != vertices[:, 2].argmax())
    region, _ = remesh_region(vertices, faces, chosen)
    assert np.array_equal(np.flatnonzero(~region), np.unique(faces[~region[faces].any(axis=1)]))


def test_a_region_that_reaches_a_border_is_remade_up_to_the_triangles_there() -> None:
    """A wall of a tube selected from end to end: both borders and the triangles at them keep every bit."""
    vertices, faces = tube(24, 16)
    meshes = mesh_set((vertices, faces))
    select(meshes, "x > 0.5")
    values = meshes.apply_coord_region_fairing(remesh=True)
    mesh = meshes.current_mesh()
    assert values is not None
    assert values["deleted_vertices"] == ((vertices[:, 0] > 0.5) & (vertices[:, 2] > 0.3) & (vertices[:, 2] < 2.7)).sum()
    assert surface_measures(mesh.vertex_matrix(), mesh.face_matrix()).border_edges == 48
    assert np.array_equal(mesh.vertex_matrix()[:48], vertices[:48])
