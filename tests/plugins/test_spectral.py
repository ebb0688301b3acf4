"""Spectral filters as MeshLab users meet them: on a mesh set, with names, lengths and help."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pymeshlab
import pytest

import pymeshfair
from pymeshfair.declaration import Filter, FilterClass
from pymeshfair.filters.spectral.spectral_filter import spectral_filter
from pymeshfair.filters.spectral.spectrum import spectrum
from pymeshfair.plugins import spectral
from pymeshfair.recipe import load_recipe
from tests.meshes import AWKWARD, Mesh, grid, icosphere, noisy, tube, two_spheres

NAMES = ("apply_coord_spectral_filter", "compute_scalar_by_manifold_harmonic_per_vertex", "get_surface_spectrum")
DECLARED: list[Filter] = [getattr(spectral, name) for name in NAMES]


def mesh_set(mesh: Mesh) -> pymeshfair.MeshSet:
    """A mesh set with this mesh alone."""
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*mesh))
    return meshes


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"detail_size": pymeshlab.PureValue(0.4)}, {"detail_size": 0.4}),
        ({"modes": 20}, {"modes": 20}),
        ({"modes": 20, "method": "polynomial"}, {"modes": 20, "method": "polynomial"}),
        (
            {"response": "enhance", "detail_size": "0.4", "largest_size": "0.9", "gain": 3.0},
            {"response": "enhance", "detail_size": 0.4, "largest_size": 0.9, "gain": 3.0},
        ),
        ({"response": "band_pass", "detail_size": "0.4"}, {"response": "band_pass", "detail_size": 0.4}),
    ],
    ids=["wavelength", "modes", "modes without eigenvectors", "enhance", "band pass"],
)
def test_positions_are_those_of_the_function(values: dict[str, Any], expected: dict[str, Any]) -> None:
    """Every parameter reaches the technique, and what ran is told: route, counts, wavelength, error."""
    mesh = noisy(icosphere(3), 0.01)
    meshes = mesh_set(mesh)
    told = meshes.apply_filter("apply_coord_spectral_filter", **values)
    found = spectral_filter(*mesh, **expected)
    np.testing.assert_allclose(meshes.current_mesh().vertex_matrix(), found.vertices, rtol=0, atol=1e-12)
    assert told["route"] == found.route
    assert (told["modes"], told["degree"]) == (found.modes, found.degree)
    assert told["detail_size"] == pytest.approx(found.detail_size)
    assert told["error"] == pytest.approx(found.error)


def test_the_default_is_six_mean_edges() -> None:
    """Without parameters a low pass by six mean edges, without eigenvectors."""
    vertices, faces = noisy(icosphere(3), 0.01)
    meshes = mesh_set((vertices, faces))
    told = meshes.apply_filter("apply_coord_spectral_filter")
    edges = np.concatenate([vertices[faces[:, k]] - vertices[faces[:, k - 1]] for k in range(3)])
    assert told["detail_size"] == pytest.approx(6 * np.linalg.norm(edges, axis=1).mean(), rel=1e-6)
    assert told["route"] in ("polynomial", "rational")
    assert told["degree"] > 0


def test_only_selected_vertices_move() -> None:
    """With `selected` the others keep every bit."""
    vertices, faces = noisy(tube(), 0.02)
    meshes = mesh_set((vertices, faces))
    meshes.compute_selection_by_condition_per_vertex(condselect="z > 1.5")
    chosen = meshes.current_mesh().vertex_selection_array()
    meshes.apply_filter("apply_coord_spectral_filter", selected=True)
    found = meshes.current_mesh().vertex_matrix()
    assert 0 < chosen.sum() < len(chosen)
    assert found[~chosen].tobytes() == vertices[~chosen].tobytes()
    assert (found[chosen] != vertices[chosen]).any()


def test_the_harmonic_is_the_scalar() -> None:
    """Mode 1 of a sphere has the frequency sqrt(2), and its scalar is a linear function of mean square 1; positions stay."""
    vertices, faces = icosphere(3)
    meshes = mesh_set((vertices, faces))
    told = meshes.apply_filter("compute_scalar_by_manifold_harmonic_per_vertex", mode=1)
    scalars = meshes.current_mesh().vertex_scalar_array()
    assert told["frequency"] == pytest.approx(math.sqrt(2), rel=0.01)
    assert told["wavelength"] == pytest.approx(2 * math.pi / told["frequency"])
    assert told["eigenvalue"] == pytest.approx(told["frequency"] ** 2)
    assert (scalars**2).mean() == pytest.approx(1.0, rel=0.02)
    direction, *_ = np.linalg.lstsq(vertices, scalars, rcond=None)
    np.testing.assert_allclose(vertices @ direction, scalars, rtol=0, atol=0.01)
    assert meshes.current_mesh().vertex_matrix().tobytes() == vertices.tobytes()


def test_the_constant_mode_has_no_wavelength() -> None:
    """Mode 0 is 1 everywhere; mode 1 is a wave, also of two components, and the notes say when it lives on a small one."""
    meshes = mesh_set(two_spheres())
    told = meshes.apply_filter("compute_scalar_by_manifold_harmonic_per_vertex", mode=0)
    assert (told["frequency"], told["wavelength"]) == (0.0, math.inf)
    assert (meshes.current_mesh().vertex_scalar_array() == 1.0).all()
    assert meshes.apply_filter("compute_scalar_by_manifold_harmonic_per_vertex", mode=1)["frequency"] > 1.0


def test_the_spectrum_is_that_of_the_function() -> None:
    """Numbers come as lists, with the lengths by which they may be read."""
    mesh = noisy(icosphere(2), 0.01)
    told = mesh_set(mesh).apply_filter("get_surface_spectrum", modes=12)
    found = spectrum(*mesh, modes=12)
    for name in ("frequencies", "energies", "band_edges", "band_energies"):
        np.testing.assert_allclose(told[name], getattr(found, name), rtol=1e-9)
    assert told["energy"] == pytest.approx(found.energy)
    assert told["diagonal"] > told["mean_edge"] > 0.0


@pytest.mark.parametrize("name", [n for n in AWKWARD if n not in ("empty", "1e150", "1e30", "1e-30")])
def test_awkward_meshes_go_through_every_filter(name: str) -> None:
    """Coordinates and scalars stay finite, or an error of ours says what is wrong; nothing crashes."""
    vertices, faces = AWKWARD[name]()
    given: list[dict[str, Any]] = [{"detail_size": "20%"}, {"mode": 1}, {"modes": 3}]
    for declared, values in zip(DECLARED, given, strict=True):
        meshes = mesh_set((vertices, faces))
        said = ""
        try:
            meshes.apply_filter(declared.python_name, **values)
        except pymeshlab.PyMeshLabException as error:
            said = str(error)
        assert not said or re.search("does not exist|has an area|nothing to do", said), said
        assert np.isfinite(meshes.current_mesh().vertex_matrix()).all()
        if meshes.current_mesh().has_vertex_scalar():
            assert np.isfinite(meshes.current_mesh().vertex_scalar_array()).all()


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("apply_coord_spectral_filter", {"detail_size": "0"}, "detail_size is 0 and so is modes: nothing to do"),
        ("apply_coord_spectral_filter", {"response": "enhance", "largest_size": "1edge"}, "is not above detail_size"),
        (
            "compute_scalar_by_manifold_harmonic_per_vertex",
            {"mode": 400},
            "mode 400 does not exist: this mesh has modes 0 to 161",
        ),
    ],
)
def test_what_makes_no_sense_is_refused(name: str, values: dict[str, Any], message: str) -> None:
    """The message names the parameter and what there is."""
    with pytest.raises(pymeshlab.PyMeshLabException, match=message):
        mesh_set(icosphere(2)).apply_filter(name, **values)


def test_a_body_without_room_for_the_waves_is_named() -> None:
    """A note says that an egg stays since waves of 120 edges are longer than it is thick, and what to do about it."""
    vertices, faces = icosphere(3)
    meshes, notes = mesh_set((vertices * (1.0, 0.8, 0.6), faces)), list[str]()
    meshes.on_note = notes.append
    meshes.apply_coord_detail_enhancement(detail_size="6edge", largest_size="120edge")
    assert "parts far thinner than the longest wave stay; a smaller largest_size moves them" in notes[-1]
    np.testing.assert_allclose(meshes.current_mesh().vertex_matrix(), vertices * (1.0, 0.8, 0.6), atol=1e-3)


def test_borders_and_the_selection_are_causes_too() -> None:
    """A wavy sheet far smaller than the waves hardly moves near its borders, as a note says; a selected vertex needs no cause."""
    vertices, faces = grid(12, 12)
    vertices[:, 2] += np.sin(vertices[:, 0])
    meshes, notes = mesh_set((vertices, faces)), list[str]()
    meshes.on_note = notes.append
    for selected in (False, True):
        meshes.compute_selection_by_condition_per_vertex(condselect="x < 0.1 && y < 0.1")
        meshes.apply_filter("apply_coord_detail_enhancement", detail_size="6edge", largest_size="500edge", selected=selected)
    assert [note for note in notes if "hardly anything moved" in note] == [notes[1]]
    assert "vertices near a border and parts far thinner than the longest wave stay" in notes[1]


def test_each_filter_is_in_its_menu() -> None:
    """Smoothing, quality, measure."""
    assert [d.classes for d in DECLARED] == [FilterClass.SMOOTHING, FilterClass.QUALITY, FilterClass.MEASURE]


def run(recipe: str, mesh: Mesh) -> pymeshfair.MeshSet:
    """A mesh set whose mesh has gone through the recipe."""
    meshes = mesh_set(mesh)
    meshes.load_filter_script(str(load_recipe(recipe).script.path))
    meshes.apply_filter_script()
    return meshes


def test_the_low_pass_recipe_takes_noise_and_keeps_the_size() -> None:
    """Of the noise of a sphere less than a third is left, and the radius stays to a thousandth."""
    vertices = run("spectral_low_pass", noisy(icosphere(4), 0.005)).current_mesh().vertex_matrix()
    radii = np.linalg.norm(vertices, axis=1)
    assert radii.std() < 0.005 / 3
    assert radii.mean() == pytest.approx(1.0, abs=1e-3)


def test_the_enhancing_recipe_doubles_bumps() -> None:
    """Bumps of a sphere, of 9 mean edges, come out nearly twice as high, and the sphere keeps its size."""
    vertices, faces = icosphere(5)
    # Waves of 9 edges of 0.037 have l (l + 1) = (2 pi / 0.33)^2: l = 18.
    legendre = np.polynomial.legendre.Legendre.basis(18)(vertices[:, 2])
    bumpy = vertices * (1 + 2e-3 * legendre[:, None])
    found = run("enhance_details", (bumpy, faces)).current_mesh().vertex_matrix()
    before, after = np.linalg.norm(bumpy, axis=1) - 1, np.linalg.norm(found, axis=1) - 1
    assert before @ after / (before @ before) == pytest.approx(1.9, abs=0.2)
    assert np.ptp(found, axis=0) == pytest.approx(np.ptp(bumpy, axis=0), rel=0.005)


def test_the_harmonics_recipe_colours_a_mode() -> None:
    """The lowest value is red, the highest blue."""
    mesh = run("show_harmonics", icosphere(3)).current_mesh()
    scalars, colors = mesh.vertex_scalar_array(), mesh.vertex_color_matrix()
    extreme = np.abs(scalars).max()
    assert np.ptp(scalars) > extreme
    low, high = colors[scalars.argmin()], colors[scalars.argmax()]
    assert low[0] > low[2]
    assert high[2] > high[0]
