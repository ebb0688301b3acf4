"""Smoothing by the bi-Laplacian energy against its response, dense solutions and its own symmetries."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import sparse

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.fairing import bilaplacian
from pymeshfair.filters.fairing.bilaplacian import bilaplacian_smoothing, weight_of_detail_size
from pymeshfair.filters.operators import laplace_beltrami
from pymeshfair.filters.topology import BORDER_POLICIES, BorderPolicy, border_vertices
from tests.meshes import AWKWARD, Floats, Ints, grid, icosphere, irregular_grid, noisy, two_spheres


def normal_equations(vertices: Floats, faces: Ints, weight: float, features: Floats) -> tuple[Floats, Floats]:
    """S M^-1 W S + w M as a dense matrix, and w M p."""
    operator = laplace_beltrami(vertices, faces)
    stiffness = -operator.stiffness.toarray()
    matrix = stiffness @ np.diag(features / operator.mass) @ stiffness + weight * np.diag(operator.mass)
    return matrix, weight * operator.mass[:, None] * vertices


@pytest.mark.parametrize("border", BORDER_POLICIES)
def test_detail_size_halves_a_plane_wave(border: BorderPolicy) -> None:
    """A wave of length l comes out with half its amplitude: w / (w + omega^4) = 1/2; twice as long with 16/17."""
    vertices, faces = grid(64, 64)
    middle = int(np.flatnonzero((vertices[:, 0] == 32) & (vertices[:, 1] == 32))[0])
    for length, kept in ((16.0, 1 / 2), (32.0, 16 / 17)):
        wave = vertices.copy()
        wave[:, 2] = 0.01 * np.cos(2 * np.pi * vertices[:, 0] / length)
        result = bilaplacian_smoothing(wave, faces, detail_size=16.0, border=border)
        # The discrete frequency is smaller than omega by (omega h)^2 / 24, 0.6 %, four times that in omega^4.
        assert result[middle, 2] / wave[middle, 2] == pytest.approx(kept, abs=0.01)


@pytest.mark.parametrize("edges", [0.5, 3.0, 20.0, 1000.0])
def test_dense_solution(edges: float) -> None:
    """The same as LAPACK's solution of the normal equations, with feature weights and without."""
    vertices, faces = noisy(icosphere(3), 0.03)
    weight, size = (0.15 * edges) ** -4.0, 2 * np.pi * 0.15 * edges
    for features in (np.ones(len(vertices)), 0.3 + 0.7 * np.random.default_rng(0).random(len(vertices))):
        matrix, right_side = normal_equations(vertices, faces, weight, features)
        exact = vertices + np.linalg.solve(matrix, right_side - matrix @ vertices)
        result = bilaplacian_smoothing(vertices, faces, detail_size=size, feature_weights=features)
        # LAPACK loses what the condition number says: 1e-16 (8 edges^2)^2.
        assert np.abs(result - exact).max() < max(1e-10, 1e-14 * edges**4)


@pytest.mark.parametrize("edges", [0.5, 3.0, 20.0])
def test_the_normal_equations_hold_to_rounding(edges: float) -> None:
    """|r| / (|A| |x| + |b|) <= 1e-13."""
    vertices, faces = noisy(icosphere(3), 0.03)
    weight = (0.15 * edges) ** -4.0
    matrix, right_side = normal_equations(vertices, faces, weight, np.ones(len(vertices)))
    result = bilaplacian_smoothing(vertices, faces, detail_size=2 * np.pi * 0.15 * edges)
    residual = np.linalg.norm(right_side - matrix @ result)
    assert residual <= 1e-13 * (np.linalg.norm(matrix, 2) * np.linalg.norm(result) + np.linalg.norm(right_side))


@pytest.mark.parametrize("border", BORDER_POLICIES)
def test_a_heavy_weight_returns_the_input(border: BorderPolicy) -> None:
    """As w goes to infinity nothing moves, in the end to the last bit."""
    vertices, faces = noisy(irregular_grid(10, 12), 0.05)
    sizes = [2 * np.pi * w**-0.25 for w in (1e4, 1e6, 1e8, 1e300)]
    moves = [np.abs(bilaplacian_smoothing(vertices, faces, detail_size=size, border=border) - vertices).max() for size in sizes]
    assert moves[2] < 1.1e-2 * moves[1] < 1.3e-4 * moves[0]
    assert moves[3] == 0.0


def test_as_the_weight_vanishes_a_closed_component_keeps_its_centroid() -> None:
    """The equations sum up to w sum M (p' - p) = 0, also where the energy alone leaves a component's place open."""
    vertices, faces = noisy(two_spheres(), 0.02)
    mass = laplace_beltrami(vertices, faces).mass
    result = bilaplacian_smoothing(vertices, faces, detail_size=1e5)
    half = len(vertices) // 2
    for part in (slice(0, half), slice(half, None)):
        centroid = np.average(vertices[part], axis=0, weights=mass[part])
        assert np.abs(np.average(result[part], axis=0, weights=mass[part]) - centroid).max() < 1e-12
        assert np.abs(result[part] - centroid).max() < 1e-6


@pytest.mark.parametrize("border", ["fixed", "free"])
def test_a_flat_sheet_stays(border: BorderPolicy) -> None:
    """Linear functions bend nowhere inside, and the border of the sheet is no place to bend at."""
    vertices, faces = irregular_grid(10, 12)
    result = bilaplacian_smoothing(vertices, faces, detail_size=6.0, border=border)
    assert np.abs(result - vertices).max() < 1e-11 * 12


@pytest.mark.parametrize("border", ["fixed", "free"])
def test_a_noisy_sheet_becomes_flat(border: BorderPolicy) -> None:
    """Of white noise out of the plane, inside the sheet, less than a quarter is left."""
    vertices, faces = irregular_grid(24, 24)
    inside = ~border_vertices(faces, len(vertices))
    noise = np.where(inside, 0.1 * np.random.default_rng(2).normal(size=len(vertices)), 0.0)
    rough = vertices + noise[:, None] * [0.0, 0.0, 1.0]
    result = bilaplacian_smoothing(rough, faces, detail_size=16.0, border=border)
    # Of the frequencies of a unit grid, up to pi in each direction, those below 2 pi / 16 are a share of 0.012.
    left = np.sqrt(np.mean((result - vertices)[inside, 2] ** 2) / np.mean(noise[inside] ** 2))
    assert left < 0.25


def test_a_noisy_sphere_comes_nearer_to_the_clean_one() -> None:
    """Radii that all are 1 without noise spread less than half as much as with it."""
    clean, faces = icosphere(4)
    rough, _ = noisy((clean, faces), 0.02)
    result = bilaplacian_smoothing(rough, faces, detail_size=0.6)
    radial = [float(np.std(np.linalg.norm(vertices, axis=1))) for vertices in (rough, result)]
    assert radial[1] < 0.5 * radial[0]


@pytest.mark.parametrize("scale", [1e-2, 1e-4, 1e-6])
def test_a_small_component_is_treated_as_alone(scale: float) -> None:
    """Beside a component that is larger by any factor it comes out as it does alone, to the rounding of where it lies."""
    vertices, faces = noisy(icosphere(3), 0.01)
    small = scale * vertices + [3.0, 0.0, 0.0]
    both = np.concatenate([vertices, small]), np.concatenate([faces, faces + np.int32(len(vertices))])
    together = bilaplacian_smoothing(*both, detail_size=0.6 * scale)[len(vertices) :]
    alone = bilaplacian_smoothing(small, faces, detail_size=0.6 * scale)
    assert np.abs(alone - small).max() > 0.01 * scale
    assert np.abs(together - alone).max() < 1e-9 * scale + 4e-15


def test_a_finely_sampled_part_is_smoothed() -> None:
    """Rings that shrink by 0.67 each towards the middle of a disc, down to 1e-6: its noise goes there too."""
    around = 16
    ring = np.exp(-2 * np.pi / around) ** np.arange(35)
    angle = 2 * np.pi * (np.arange(around) + 0.5 * (np.arange(35)[:, None] % 2)) / around
    vertices = np.column_stack([(ring[:, None] * turn(angle)).ravel() for turn in (np.cos, np.sin)] + [np.zeros(35 * around)])
    vertices = np.concatenate([vertices, np.zeros((1, 3))])
    faces = []
    for i in range(34):
        for j in range(around):
            low, after = i * around + j, i * around + (j + 1) % around
            first = (i + 1) * around + (j if i % 2 == 0 else (j + 1) % around)
            before = (i + 1) * around + ((j - 1) % around if i % 2 == 0 else j)
            faces += [[low, after, first], [low, first, before]]
    faces += [[34 * around + j, 34 * around + (j + 1) % around, 35 * around] for j in range(around)]
    rough = vertices.copy()
    inside = np.linalg.norm(vertices, axis=1) < 0.9
    rough[inside, 2] = 0.1 * np.random.default_rng(1).normal(size=int(inside.sum())) * np.linalg.norm(vertices, axis=1)[inside]
    fine = np.linalg.norm(vertices, axis=1) < 1e-5
    result = bilaplacian_smoothing(rough, np.array(faces, dtype=np.int32), detail_size=1e-4, border="fixed")
    spread = [float(np.ptp((mesh - mesh[fine].mean(axis=0))[fine, 2])) for mesh in (rough, result)]
    assert spread[1] < 0.25 * spread[0]


@pytest.mark.parametrize("border", BORDER_POLICIES)
def test_held_vertices_keep_every_bit(border: BorderPolicy) -> None:
    """Vertices that may not move do not, nor do border vertices under "fixed"; inner ones do."""
    vertices, faces = noisy(grid(12, 12), 0.1)
    movable = vertices[:, 0] > 4.0
    result = bilaplacian_smoothing(vertices, faces, detail_size=5.0, border=border, movable=movable)
    changed = (result != vertices).any(axis=1)
    may = movable & ~border_vertices(faces, len(vertices)) if border == "fixed" else movable
    assert not changed[~may].any()
    assert changed[may & ~border_vertices(faces, len(vertices))].all()
    assert changed[may].any()


def test_the_result_turns_and_grows_with_the_mesh() -> None:
    """Rotation commutes with it, and a scale s if detail_size grows by s."""
    vertices, faces = noisy(icosphere(3), 0.03)
    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    plain = bilaplacian_smoothing(vertices, faces, detail_size=0.7)
    assert np.abs(bilaplacian_smoothing(vertices @ turn.T, faces, detail_size=0.7) - plain @ turn.T).max() < 1e-11
    large = bilaplacian_smoothing(1e12 * vertices, faces, detail_size=0.7e12)
    assert np.abs(large - 1e12 * plain).max() < 1e-11 * 1e12


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_end_finite(name: str) -> None:
    """Whatever the mesh, coordinates stay finite and vertices without a face keep every bit."""
    vertices, faces = AWKWARD[name]()
    extent = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 1.0
    result = bilaplacian_smoothing(vertices, faces, detail_size=0.3 * (extent or 1.0))
    assert np.isfinite(result).all()
    proper = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    loose = np.setdiff1d(np.arange(len(vertices)), proper)
    assert np.array_equal(result[loose], vertices[loose])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"detail_size": 0.0}, "detail_size is 0.0: it must be finite and above 0"),
        ({"detail_size": -1.0}, "detail_size is -1.0"),
        ({"detail_size": 1.0, "border": "loose"}, "border 'loose'"),
        ({"detail_size": 1.0, "feature_weights": np.full(25, -1.0)}, "feature_weights must be 25 finite values"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, object], message: str) -> None:
    """The message says which argument is wrong and what came."""
    vertices, faces = grid(4, 4)
    with pytest.raises(FilterInputError, match=message):
        bilaplacian_smoothing(vertices, faces, **arguments)  # type: ignore[arg-type]


def test_weight_of_detail_size() -> None:
    """The weight is (2 pi / l)^4."""
    assert weight_of_detail_size(2 * math.pi) == pytest.approx(1.0)
    assert weight_of_detail_size(math.pi) == pytest.approx(16.0)


@pytest.mark.parametrize("features", [False, True])
def test_progress_never_falls(features: bool) -> None:
    """Over the border, the factors and every refinement, with even weights and with uneven ones."""
    vertices, faces = noisy(grid(30, 30), 0.05)
    weights = 10.0 ** np.random.default_rng(0).uniform(-6, 0, len(vertices)) if features else None
    shares: list[float] = []
    bilaplacian_smoothing(vertices, faces, detail_size=8.0, feature_weights=weights, progress=shares.append)
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] < 0.1 < 0.9 < shares[-1] <= 1.0


@pytest.mark.parametrize("border", ["fixed", "free"])
@pytest.mark.parametrize("edges", [0.5, 4.0])
def test_multigrid_and_factors_lead_to_the_same_surface(
    border: BorderPolicy, edges: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What stands for the inverse of a half decides about time alone, with some vertices held or none."""
    vertices, faces = noisy(grid(30, 40), 0.1)
    for movable in (None, np.random.default_rng(0).random(len(vertices)) < 0.9):
        results = []
        for most in (10**9, 0):
            monkeypatch.setattr(bilaplacian, "_QUICK_FACTORS", most)
            results.append(bilaplacian_smoothing(vertices, faces, detail_size=edges, border=border, movable=movable))
        assert np.abs(results[0] - results[1]).max() < 1e-10 * np.linalg.norm(np.ptp(vertices, axis=0))


def test_factors_take_over_from_cycles_that_stall(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where too few iterations are allowed for multigrid, the same surface comes out."""
    vertices, faces = noisy(icosphere(4), 0.02)
    expected = bilaplacian_smoothing(vertices, faces, detail_size=0.5)
    monkeypatch.setattr(bilaplacian, "_QUICK_FACTORS", 0)
    monkeypatch.setattr(bilaplacian, "_MOST_ITERATIONS", 13)
    taken: list[int] = []
    cholesky = bilaplacian.Cholesky  # type: ignore[attr-defined]

    def noted(matrix: sparse.csr_matrix, **options: Any) -> Any:
        taken.append(matrix.shape[0])
        return cholesky(matrix, **options)

    monkeypatch.setattr(bilaplacian, "Cholesky", noted)
    assert np.abs(bilaplacian_smoothing(vertices, faces, detail_size=0.5) - expected).max() < 1e-9
    assert taken == [len(vertices)]


def test_a_large_mesh_can_be_left_at_every_iteration(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without factors the progress is called at every iteration, and what it raises ends the work."""
    monkeypatch.setattr(bilaplacian, "_QUICK_FACTORS", 0)
    calls = []

    def stop(share: float) -> None:
        calls.append(share)
        if len(calls) == 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bilaplacian_smoothing(*noisy(icosphere(4), 0.02), detail_size=2.0, progress=stop)
    assert len(calls) == 20
