"""Smoothers that find from the scan how much they smooth."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast
from unittest import mock

import numpy as np
import pymeshlab
import pytest

import pymeshfair
from pymeshfair.declaration import Layer
from pymeshfair.filters.checks import ConvergenceError
from pymeshfair.filters.choosing import DETAIL_SIZES, SMOOTHERS, chosen_amount, compare_smoothers
from pymeshfair.filters.choosing.smoothers import SmootherName
from pymeshfair.filters.denoising.noise_level import smooth_normals
from pymeshfair.filters.diffusion import taubin_fairing
from pymeshfair.filters.geometry import face_normals, mean_edge_length
from pymeshfair.filters.inspection import folded_faces
from pymeshfair.plugins import moving_vertices
from tests.angles import mean_angle
from tests.meshes import Mesh, icosphere, irregular_grid, noisy, renumbered, rotation, torus, volume

TRUE = icosphere(3)
EDGE = mean_edge_length(*TRUE)
HEIGHTS = np.random.default_rng(1).normal(size=len(TRUE[0])) * 0.2 * EDGE
NOISY = (TRUE[0] + HEIGHTS[:, None] * smooth_normals(*TRUE), TRUE[1])

FILTERS: list[tuple[str, dict[str, Any]]] = [
    ("apply_coord_bilaplacian_smoothing", {"detail_size": "auto"}),
    ("apply_coord_spectral_filter", {"detail_size": "auto"}),
    ("apply_coord_taubin_fairing", {"iterations": "auto"}),
]


def _applied(mesh: Mesh, name: str, values: dict[str, Any]) -> tuple[np.ndarray, dict[str, Any]]:
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*mesh))
    told = getattr(meshes, name)(**values)
    return meshes.current_mesh().vertex_matrix(), told


@pytest.mark.parametrize(("name", "values"), FILTERS)
def test_noise_is_taken_and_a_clean_mesh_stays(name: str, values: dict[str, Any]) -> None:
    """The mean angle to the true normals falls by a third at least; without noise every vertex keeps every bit."""
    result, told = _applied(NOISY, name, values)
    truth = face_normals(*TRUE)
    before, after = (mean_angle(face_normals(v, TRUE[1]), truth) for v in (NOISY[0], result))
    assert told["chosen"] > 0.0
    assert len(told["tried"]) > 1
    assert after < before * 2.0 / 3.0
    kept, told = _applied(TRUE, name, values)
    assert told["chosen"] == 0.0
    assert np.array_equal(kept, TRUE[0])


def test_implicit_fairing_finds_its_size_on_a_sheet() -> None:
    """Where it takes no shape away: the heights of noise over a plane fall to a half, and a plane stays."""
    flat, faces = irregular_grid(30)
    level = 0.2 * mean_edge_length(flat, faces)
    rough = flat + np.random.default_rng(2).normal(size=len(flat))[:, None] * (0.0, 0.0, level)
    result, told = _applied((rough, faces), "apply_coord_implicit_fairing", {"detail_size": "auto"})
    assert told["chosen"] > 0.0
    assert result[:, 2].std() < 0.5 * rough[:, 2].std()
    assert np.array_equal(_applied((flat, faces), "apply_coord_implicit_fairing", {"detail_size": "auto"})[0], flat)


@pytest.mark.parametrize("name", ["implicit", "bilaplacian", "spectral"])
def test_a_bent_surface_hardly_shrinks(name: SmootherName) -> None:
    """On a torus with noise of a twentieth of an edge the chosen detail size takes less than a tenth of the volume."""
    true, faces = torus(48, 24, major=1.0, minor=0.3)
    edge = mean_edge_length(true, faces)
    heights = 0.05 * edge * np.random.default_rng(5).normal(size=(len(true), 1))
    rough, (smooth, sizes) = (true + heights * smooth_normals(true, faces)) / edge, SMOOTHERS[name]
    found = chosen_amount(rough, faces, smooth, sizes)
    assert found is not None
    assert found.chosen.label > 0.0
    assert volume(smooth(rough, faces, found.chosen.label, None), faces) > 0.9 * volume(true / edge, faces)


def test_what_was_chosen_repeats_the_result() -> None:
    """The detail size that is told, given to the filter, does the same."""
    name = "apply_coord_bilaplacian_smoothing"
    result, told = _applied(NOISY, name, {"detail_size": "auto"})
    again, _ = _applied(NOISY, name, {"detail_size": pymeshlab.PureValue(told["chosen"])})
    np.testing.assert_allclose(again, result, atol=1e-6 * EDGE)


def test_what_cannot_choose_says_so() -> None:
    """Bands, features and clouds need a size, and a length of curves is not found."""
    for name, values, words in (
        ("apply_coord_spectral_filter", {"detail_size": "auto", "response": "enhance"}, "is for .*'low_pass'"),
        ("apply_coord_bilaplacian_smoothing", {"detail_size": "auto", "features": "curvature"}, "cannot keep features"),
        ("apply_coord_curve_smoothing", {"detail_size": "auto"}, "is no length"),
    ):
        with pytest.raises(pymeshlab.PyMeshLabException, match=words):
            _applied(NOISY, name, values)


def test_the_amount_moves_with_the_mesh() -> None:
    """Moved, turned, scaled and renumbered: the same amount from the same errors."""
    smooth = SMOOTHERS["taubin"][0]
    first = chosen_amount(*NOISY, smooth, (2, 5, 12))
    vertices, faces, _ = renumbered(NOISY)
    second = chosen_amount(5.0 * vertices @ rotation().T - 2.0, faces, smooth, (2, 5, 12))
    assert first is not None
    assert second is not None
    assert first.chosen.label == second.chosen.label
    np.testing.assert_allclose([t.error for t in first.trials], [t.error for t in second.trials], rtol=1e-9)


def test_families_are_compared() -> None:
    """Of every smoother what predicts best, nothing first; the winner errs least or is as good; a clean mesh is not judged."""
    found = compare_smoothers(*NOISY)
    assert found is not None
    names = [trial.label.smoother for trial in found.trials]
    assert names[0] is None
    assert {"taubin", "bilaplacian", "spectral", "normal_filtering"} <= set(names)
    least = min(found.trials, key=lambda trial: trial.error)
    assert found.chosen.excess <= least.excess + found.chosen.uncertainty
    assert found.chosen.label.smoother is not None
    assert compare_smoothers(*TRUE) is None


def test_a_family_that_fails_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Energies of meshes with needles may have no factors: the others are compared."""

    def fails(*_: object) -> np.ndarray:
        raise ConvergenceError("the matrix is not positive definite to rounding")

    monkeypatch.setattr(
        "pymeshfair.filters.choosing.smoothers.SMOOTHERS", dict(SMOOTHERS) | {"bilaplacian": (fails, DETAIL_SIZES)}
    )
    found = compare_smoothers(*NOISY)
    assert found is not None
    assert {"taubin", "spectral"} <= {trial.label.smoother for trial in found.trials}
    assert "bilaplacian" not in {trial.label.smoother for trial in found.trials}


def test_sizes_rise_and_a_fair_ball_needs_no_more() -> None:
    """Detail sizes grow; after many of Taubin's steps nothing is left to remove."""
    assert list(DETAIL_SIZES) == sorted(DETAIL_SIZES)
    fair = taubin_fairing(*noisy(TRUE, 0.1 * EDGE), iterations=60)
    found = chosen_amount(fair, TRUE[1], *SMOOTHERS["taubin"])
    assert found is None or found.chosen.label == 0.0


def test_no_more_faces_are_folded_than_before() -> None:
    """A filter that scatters the vertices folds no more over than there were, where it chooses its amount."""
    vertices, faces = NOISY
    layer = cast(Layer, SimpleNamespace(vertices=vertices, faces=faces))

    def folding(points: np.ndarray, *_: object, **__: object) -> np.ndarray:
        return points + np.random.default_rng(1).normal(scale=0.3 * EDGE, size=points.shape)

    with mock.patch.object(moving_vertices, "chosen_amount") as choice:
        choice.return_value.chosen.label, choice.return_value.trials = 1.0, ()
        found = moving_vertices.smoothed_by_amount(layer, -1.0, folding, (0.0, 1.0), selected=False, progress=lambda _: None)
    assert folded_faces(folding(vertices), faces).sum() > folded_faces(vertices, faces).sum()
    assert folded_faces(found.vertices, faces).sum() <= folded_faces(vertices, faces).sum()


def test_the_spectral_filter_folds_no_more_faces_either() -> None:
    """Where half of a ball shrinks beside fixed vertices, the written vertices are those after folded faces are taken back."""
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*NOISY))
    meshes.compute_selection_by_condition_per_vertex(condselect="sin(x * 30) > 0")
    with mock.patch.object(moving_vertices, "chosen_amount") as choice:
        choice.return_value.chosen.label, choice.return_value.trials = 30.0, ()
        meshes.apply_coord_spectral_filter(detail_size="auto", selected=True)
    moved = meshes.current_mesh().vertex_matrix()
    assert not np.array_equal(moved, NOISY[0])
    assert folded_faces(moved, NOISY[1]).sum() <= folded_faces(*NOISY).sum()
