"""The expected errors of the slopes of results, against closed forms and against the errors that a known truth shows."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from pymeshfair.filters.denoising.noise_level import smooth_normals
from pymeshfair.filters.diffusion import taubin_fairing
from pymeshfair.filters.evidence import SlopeError, choose, random_numbers, roughness, slope_errors
from pymeshfair.filters.geometry import mean_edge_length, vertex_normals_by_area
from pymeshfair.filters.topology import edges
from tests.meshes import Floats, Ints, cube, icosphere, irregular_grid, renumbered, rotation, torus

STEPS = (0, 1, 2, 3, 5, 8, 12, 18, 28, 42)


def _scan(mesh: tuple[Floats, Ints], level: float, seed: int = 0) -> tuple[Floats, Floats, Ints]:
    """The truth with a mean edge of 1, the same with so much noise along its normals, and the faces."""
    vertices, faces = mesh
    truth = vertices / mean_edge_length(vertices, faces)
    noise = level * np.random.default_rng(seed).normal(size=len(truth))
    return truth, truth + noise[:, None] * vertex_normals_by_area(truth, faces), faces


def _by_taubin(points: Floats, faces: Ints, normals: Floats) -> Callable[[Floats], dict[int, Floats]]:
    def heights(start: Floats) -> dict[int, Floats]:
        results = {steps: taubin_fairing(start, faces, iterations=steps) for steps in STEPS}
        return {steps: np.einsum("ij,ij->i", result - points, normals) for steps, result in results.items()}

    return heights


def _expected(points: Floats, faces: Ints, best: int, seed: int = 0) -> dict[int, SlopeError]:
    normals, scored = smooth_normals(points, faces), np.ones(len(points), dtype=np.bool_)
    heights = _by_taubin(points, faces, normals)
    return slope_errors(points, faces, heights(points), heights, best=best, normals=normals, scored=scored, seed=seed)


@pytest.mark.parametrize("level", [0.03, 0.1, 0.3])
def test_of_multiples_of_noise_the_errors_are_those_of_what_is_left(level: float) -> None:
    """Where a sheet's heights z are multiplied by k, the error is k^2 E (z_i - z_j)^2 = 2 k^2 s^2, whichever is the best."""
    vertices, faces = irregular_grid(60, 60)
    _, points, faces = _scan((vertices, faces), level)
    shares = {0: 1.0, 1: 0.6, 2: 0.3, 3: 0.1}

    def heights(start: Floats) -> dict[int, Floats]:
        return {at: share * start[:, 2] - points[:, 2] for at, share in shares.items()}

    up, scored = np.tile([0.0, 0.0, 1.0], (len(points), 1)), np.ones(len(points), dtype=np.bool_)
    for best in (1, 2, 3):
        found = slope_errors(points, faces, heights(points), heights, best=best, normals=up, scored=scored)
        for at, share in shares.items():
            # Means of about 10,000 squares at 3,600 vertices: 2 s^2 sqrt(2 / 3600) is a standard error of either of both.
            tolerance = 5.0 * 2.0 * level**2 * np.sqrt(2.0 / len(points))
            assert found[at].error == pytest.approx(2.0 * share**2 * level**2, abs=tolerance)


@pytest.mark.parametrize("mesh", ["torus", "ball"])
@pytest.mark.parametrize("level", [0.05, 0.2])
def test_the_least_expected_error_is_nearly_the_least_true_one(mesh: str, level: float) -> None:
    """Of numbers of Taubin's steps the one with the least expected error has at most 1.1 times the least true error."""
    truth, points, faces = _scan(torus(60, 30) if mesh == "torus" else icosphere(4), level)
    normals, (i, j) = smooth_normals(points, faces), edges(faces).T
    heights = _by_taubin(points, faces, normals)(points)
    off = {steps: h + np.einsum("ij,ij->i", points - truth, normals) for steps, h in heights.items()}
    true = {steps: float(np.mean((e[i] - e[j]) ** 2)) for steps, e in off.items()}
    expected = _expected(points, faces, best=8)
    assert true[min(expected, key=lambda steps: expected[steps].error)] <= 1.1 * min(true.values())


def test_the_errors_are_the_same_for_the_mesh_turned_and_renumbered() -> None:
    """To rounding, which the added noise, a tenth of that of the scan, makes ten times larger."""
    _, points, faces = _scan(torus(40, 20), 0.1)
    found = [slope.error for slope in _expected(points, faces, best=8).values()]
    turned = points @ rotation().T
    shuffled, other_faces, _ = renumbered((points, faces))
    for vertices, triangles in ((turned, faces), (shuffled, other_faces)):
        again = [slope.error for slope in _expected(vertices, triangles, best=8).values()]
        np.testing.assert_allclose(again, found, rtol=0, atol=1e-10)


def test_without_noise_nothing_is_asked() -> None:
    """A best filter that takes nothing away says of no noise how others pass it on."""
    _, points, faces = _scan(icosphere(3), 0.0)
    assert _expected(points, faces, best=0) == {0: SlopeError(0.0, 0.0, 0.0)}


def test_random_numbers_are_even_and_others_for_other_seeds() -> None:
    """Of n numbers n/10 lie in each tenth, within four deviations; neighbours and seeds do not correlate, by 4 over root n."""
    _, points, faces = _scan(torus(60, 30), 0.05)
    pairs = edges(faces)
    numbers = [random_numbers(points, pairs, seed) for seed in range(3)]
    n = len(points)
    for values in numbers:
        counts = np.histogram(values, bins=10, range=(0.0, 1.0))[0]
        assert (np.abs(counts - n / 10) < 4.0 * np.sqrt(n * 0.09)).all()
        i, j = pairs.T
        assert abs(np.corrcoef(values[i], values[j])[0, 1]) < 4.0 / np.sqrt(len(pairs))
    assert abs(np.corrcoef(numbers[0], numbers[1])[0, 1]) < 4.0 / np.sqrt(n)
    assert abs(np.corrcoef(numbers[1], numbers[2])[0, 1]) < 4.0 / np.sqrt(n)


def test_among_equals_slopes_decide() -> None:
    """A filter that errs as little at held-out vertices, but leaves ripples of one edge, loses against one that leaves none."""
    _, points, faces = _scan(irregular_grid(40, 40), 0.1)
    up, rng = np.tile([0.0, 0.0, 1.0], (len(points), 1)), np.random.default_rng(1)
    ripples, bump = 0.02 * rng.normal(size=len(points)), 0.02 * np.sqrt(2.0) * np.sin(0.2 * points[:, 0])

    def candidates(start: Floats, held: Ints) -> list[Iterator[Floats]]:
        flat = start * (1.0, 1.0, 0.0)
        return [iter([start]), iter([flat + ripples[:, None] * up]), iter([flat + bump[:, None] * up])]

    scored = np.ones(len(points), dtype=np.bool_)
    labels = [["nothing"], ["ripples"], ["bump"]]
    found = choose(points, faces, candidates, labels, normals=up, scored=scored)
    assert found is not None
    assert found.chosen.label == "bump"
    ripple, bumpy = found.trials[1:]
    assert abs(ripple.excess - bumpy.excess) < 2.0 * max(ripple.uncertainty, bumpy.uncertainty)
    assert ripple.slopes is not None
    assert bumpy.slopes is not None
    # (r_i - r_j)^2 has the mean 2 * 0.02^2, the slopes of the bump less than 0.02 sqrt(2) * 0.2.
    assert ripple.slopes - bumpy.slopes == pytest.approx(2.0 * 0.02**2, rel=0.3)
    without = choose(points, faces, candidates, labels, normals=up, scored=scored, slopes=False)
    assert without is not None
    assert without.chosen == min(without.trials, key=lambda trial: trial.error)


def test_where_slopes_cannot_tell_the_flatter_is_taken() -> None:
    """Ripples of a thousandth of the noise are no evidence: a flat sheet wins over one with them, first or last."""
    _, points, faces = _scan(irregular_grid(40, 40), 0.1)
    up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    ripples = 1e-4 * np.random.default_rng(1).normal(size=len(points))[:, None] * up

    for added in ({"flat": 0.0, "ripples": 1.0}, {"ripples": 1.0, "flat": 0.0}):

        def candidates(start: Floats, held: Ints, added: dict[str, float] = added) -> list[Iterator[Floats]]:
            return [iter([start]), *(iter([start * (1.0, 1.0, 0.0) + much * ripples]) for much in added.values())]

        labels = [["nothing"], *([name] for name in added)]
        found = choose(points, faces, candidates, labels, normals=up, scored=np.ones(len(points), dtype=np.bool_))
        assert found is not None
        assert found.chosen.label == "flat"


def test_the_roughness_of_a_cube() -> None:
    """Twelve of its 18 edges are right angles, |n - m| = sqrt(2), six lie in a side; a plane and one triangle have 0."""
    vertices, faces = cube()
    assert roughness(vertices, faces) == pytest.approx(12.0 * np.sqrt(2.0) / 18.0)
    assert roughness(*irregular_grid()) == pytest.approx(0.0, abs=1e-12)
    assert roughness(vertices, faces[:1]) == 0.0
