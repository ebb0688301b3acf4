"""Choosing by held-out vertices: who is held out, where they are expected, and which candidate that speaks for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pymeshfair.filters.denoising import noise_floor
from pymeshfair.filters.evidence import (
    choose,
    far_from_border,
    flattening,
    held_out_vertices,
    outlying_vertices,
    predicted_heights,
    random_numbers,
    roughness,
    sample_of,
    scores_of,
    sizes_beside,
    tuned,
    without,
)
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import border_vertices, edges, one_rings
from tests.meshes import Floats, Ints, cube, grid, icosphere, irregular_grid, noisy, renumbered, rotation, torus

FLAT = irregular_grid(30, 34)
UP = np.tile([0.0, 0.0, 1.0], (len(FLAT[0]), 1))


def _rough(level: float, seed: int = 0) -> Floats:
    """The sheet with noise of so many mean edges along its normal; its mean edge is 1."""
    vertices, faces = FLAT
    points = vertices / mean_edge_length(vertices, faces)
    points[:, 2] += level * np.random.default_rng(seed).normal(size=len(points))
    return points


def test_a_quadric_is_predicted_exactly() -> None:
    """On z = a x^2 + b xy + c y^2 + d x + e every inner vertex lies where the others expect it, to rounding."""
    vertices, faces = FLAT
    points = vertices.copy()
    x, y = points[:, 0], points[:, 1]
    points[:, 2] = 0.03 * x**2 - 0.02 * x * y + 0.01 * y**2 + 0.1 * x + 5.0
    inner = np.flatnonzero(far_from_border(faces, len(points))).astype(np.int32)
    heights, gains = predicted_heights(points, one_rings(faces, len(points)), UP, inner)
    np.testing.assert_allclose(heights, 0.0, atol=1e-9)
    assert (gains < 1.0).all()


def test_prediction_is_weighted_least_squares() -> None:
    """Height and gain are those of a fit by numpy to the two rings around, the vertex itself and hidden ones left out."""
    points = _rough(0.3)
    rings = one_rings(FLAT[1], len(points))
    hidden = np.zeros(len(points), dtype=np.bool_)
    hidden[::7] = True
    which = np.flatnonzero(far_from_border(FLAT[1], len(points)))[::50].astype(np.int32)
    heights, gains = predicted_heights(points, rings, UP, which, hidden)
    for i, height, gain in zip(which, heights, gains, strict=True):
        ring = rings.neighbours[rings.offsets[i] : rings.offsets[i + 1]]
        two = {int(k) for j in ring for k in rings.neighbours[rings.offsets[j] : rings.offsets[j + 1]]} | set(map(int, ring))
        others = [j for j in sorted(two - {int(i)}) if not hidden[j]]
        scale = np.linalg.norm((points[ring] - points[i])[:, :2], axis=1).mean()
        u, v, h = ((points[others] - points[i]) / scale).T
        root = np.sqrt(np.exp(-(u**2 + v**2) / (2 * 1.3**2)))
        terms = np.column_stack([np.ones_like(u), u, v, u * u, u * v, v * v]) * root[:, None]
        row = np.linalg.pinv(terms)[0] * root
        np.testing.assert_allclose(height, scale * row @ h, rtol=1e-9)
        np.testing.assert_allclose(gain, np.linalg.norm(row), rtol=1e-9)


def test_a_held_out_vertex_is_the_mean_of_those_that_are_not() -> None:
    """Wherever it was; of two adjacent ones neither counts for the other, one without others stays, and all others stay."""
    points, faces = noisy(torus(12, 8), 0.1)
    rings = one_rings(faces, len(points))
    ring = rings.neighbours[rings.offsets[5] : rings.offsets[6]]
    held = np.array([3, 5, ring[0]], dtype=np.int32)
    moved = points.copy()
    moved[held] += 7.0
    result = without(moved, rings, held)
    for i in held:
        others = [j for j in rings.neighbours[rings.offsets[i] : rings.offsets[i + 1]] if j not in held]
        np.testing.assert_allclose(result[i], points[others].mean(axis=0), rtol=1e-12)
    rest = np.setdiff1d(np.arange(len(points)), held)
    assert np.array_equal(result[rest], points[rest])
    alone = np.append(ring, 5).astype(np.int32)
    assert np.array_equal(without(moved, rings, alone)[5], moved[5])


def test_the_errors_on_a_sheet_have_a_closed_form() -> None:
    """Doing nothing errs by z_i less the mean of z around it; pressing the sheet flat errs by z_i; each clipped at 4 medians."""
    points, rings = _rough(0.2), one_rings(FLAT[1], len(FLAT[0]))
    scored = far_from_border(FLAT[1], len(points))

    def candidates(vertices: Floats, held: Ints) -> list[Iterator[Floats]]:
        return [iter([vertices]), iter([vertices * (1.0, 1.0, 0.0)])]

    found = choose(points, FLAT[1], candidates, [["nothing"], ["flat"]], normals=UP, scored=scored, stays=1e12)
    assert found is not None
    masks = held_out_vertices(points, FLAT[1], scored=scored, masks=tuned.MASKS)
    held = np.concatenate(masks)
    height = points[:, 2]
    around = [height[rings.neighbours[rings.offsets[i] : rings.offsets[i + 1]]].mean() for i in held]
    sizes = np.abs([height[held] - around, height[held]])
    squares = np.minimum(sizes, 4.0 * np.median(sizes, axis=1).min()) ** 2
    np.testing.assert_allclose([trial.error for trial in found.trials], np.sqrt(squares.mean(axis=1)), rtol=1e-12)


def test_held_out_vertices_are_apart_disjoint_and_of_the_geometry() -> None:
    """No two of a set are adjacent, the sets share none, each holds a twelfth to an eighth, and a moved mesh has the same."""
    vertices, faces = noisy(icosphere(4), 0.01)
    scored = np.ones(len(vertices), dtype=np.bool_)
    masks = held_out_vertices(vertices, faces, scored=scored, masks=4)
    pairs = edges(faces)
    for mask in masks:
        chosen = np.zeros(len(vertices), dtype=np.bool_)
        chosen[mask] = True
        assert not chosen[pairs].all(axis=1).any()
        assert len(vertices) / 14 < len(mask) < len(vertices) / 7
    assert len(np.unique(np.concatenate(masks))) == sum(map(len, masks))
    shuffled, other_faces, old = renumbered((vertices, faces))
    again = held_out_vertices(5.0 * shuffled @ rotation().T + 2.0, other_faces, scored=scored, masks=4)
    for mask, other in zip(masks, again, strict=True):
        assert set(old[other]) == set(mask)
    assert set(held_out_vertices(vertices, faces, scored=scored, masks=4, seed=1)[0]) != set(masks[0])


def test_far_from_border_is_more_than_two_edges_away() -> None:
    """On a grid the three outermost rows are near."""
    vertices, faces = grid(9, 10)
    far = far_from_border(faces, len(vertices)).reshape(10, 11)
    assert far[3:-3, 3:-3].all()
    assert not far[:3].any()
    assert not far[:, -3:].any()
    assert not border_vertices(faces, len(vertices))[far.ravel()].any()


def test_scores_are_those_of_clipped_squares() -> None:
    """Errors, excess and its standard error by their formulas; outliers count up to four medians."""
    deviations = np.random.default_rng(3).normal(size=(3, 400)) * np.array([[1.0], [1.5], [1.02]])
    deviations[0, 0] = 1e6
    scores = scores_of(deviations)
    squares = np.minimum(np.abs(deviations), 4 * np.median(np.abs(deviations), axis=1).min()) ** 2
    np.testing.assert_allclose(scores.errors, np.sqrt(squares.mean(axis=1)))
    assert scores.best == int(squares.mean(axis=1).argmin())
    excess = squares[1] - squares[scores.best]
    assert scores.excess[1] == pytest.approx(excess.mean())
    assert scores.uncertainty[1] == pytest.approx(excess.std() / 20.0)
    assert not scores.within(1.0)[1]
    assert scores.within(0.0)[scores.best]


def _choose(points: Floats, faces: Ints, shrink: tuple[float, ...]) -> float:
    """Which share of the noise of a sheet the held-out vertices want to be left, from smoothing alone to nothing."""

    def candidates(vertices: Floats, held: Ints) -> list[Iterator[Floats]]:
        return [iter([np.column_stack([vertices[:, :2], keep * vertices[:, 2]]) for keep in shrink])]

    scored = far_from_border(faces, len(points))
    found = choose(points, faces, candidates, [shrink], normals=UP, scored=scored)
    assert found is not None
    return found.chosen.label


def test_noise_on_a_plane_is_taken_away_and_a_wave_is_not() -> None:
    """Of multiples of the heights over a plane, noise speaks for a quarter at most and a smooth wave for 1."""
    shrink = (1.0, 0.75, 0.5, 0.25, 0.0)
    assert _choose(_rough(0.2), FLAT[1], shrink) <= 0.25
    wave = _rough(0.0)
    wave[:, 2] = 2.0 * np.sin(0.3 * wave[:, 0])
    assert _choose(wave, FLAT[1], shrink) == 1.0


def test_a_family_that_falls_behind_is_not_run_to_its_end() -> None:
    """Of heights multiplied ever more, on a sheet with noise, no mask sees more than the first two."""
    points, shrink = _rough(0.2), (1.0, 0.0)
    grow = (2.0, 4.0, 8.0, 16.0, 32.0)
    made: list[float] = []

    def candidates(vertices: Floats, held: Ints) -> list[Iterator[Floats]]:
        def times(factors: tuple[float, ...]) -> Iterator[Floats]:
            for factor in factors:
                made.append(factor)
                yield np.column_stack([vertices[:, :2], factor * vertices[:, 2]])

        return [times(shrink), times(grow)]

    found = choose(points, FLAT[1], candidates, [shrink, grow], normals=UP, scored=far_from_border(FLAT[1], len(points)))
    assert found is not None
    assert found.chosen.label == 0.0
    assert set(made) == {*shrink, *grow[:2]}
    assert made.count(grow[0]) == 1


def test_a_single_candidate_that_is_left_is_not_asked_again() -> None:
    """The true plane beats one an edge above it on the first set of held-out vertices: the others are not needed."""
    points, held_out = _rough(0.3), list[int]()
    flat = points * [1.0, 1.0, 0.0]

    def candidates(start: Floats, held: Ints) -> list[Iterator[Floats]]:
        held_out.append(len(held))
        return [iter([flat + UP]), iter([flat])]

    found = choose(points, FLAT[1], candidates, [["above"], ["flat"]], normals=UP, scored=far_from_border(FLAT[1], len(points)))
    assert found is not None
    assert (found.chosen.label, len(held_out)) == ("flat", 1)


def test_nothing_can_be_said_where_no_vertex_can_be_held_out() -> None:
    """Without a scored vertex there is no choice."""
    points = _rough(0.1)
    none_scored = np.zeros(len(points), dtype=np.bool_)
    assert choose(points, FLAT[1], lambda p, _: [iter([p])], [["nothing"]], normals=UP, scored=none_scored) is None


def test_spikes_stand_out_and_the_tip_of_a_cone_does_not() -> None:
    """Every spike of an edge and a half on a sheet with noise is found, hardly anything else is, and a cone keeps its tip."""
    spikes = np.flatnonzero(far_from_border(FLAT[1], len(FLAT[0])))[::23]
    points = _rough(0.1)
    points[spikes, 2] += 1.5
    found = outlying_vertices(points, FLAT[1], UP)
    assert found[spikes].all()
    assert np.count_nonzero(found) < len(spikes) + 0.01 * len(points)
    assert not outlying_vertices(_rough(0.1), FLAT[1], UP)[spikes].any()
    cone = _rough(0.01)
    away = np.linalg.norm(cone[:, :2] - np.median(cone[:, :2], axis=0), axis=1)
    cone[:, 2] -= away
    assert not outlying_vertices(cone, FLAT[1], UP)[away.argmin()]


def test_beside_spikes_a_sheet_is_as_rough_as_elsewhere_and_where_noise_is_loud_it_is_rougher() -> None:
    """With spikes both medians agree to a fifth; where noise is loud on one half outliers are there, and it is rougher."""
    scored = far_from_border(FLAT[1], len(FLAT[0]))
    spiky, uneven, none = _rough(0.1), _rough(0.05), np.zeros(len(FLAT[0]), dtype=np.bool_)
    spiky[np.flatnonzero(scored)[::23], 2] += 1.5
    loud = uneven[:, 0] > np.median(uneven[:, 0])
    uneven[loud, 2] *= 6.0
    beside, elsewhere = sizes_beside(spiky, FLAT[1], UP, outlying_vertices(spiky, FLAT[1], UP), scored)
    assert beside == pytest.approx(elsewhere, rel=0.2)
    outlying = outlying_vertices(uneven, FLAT[1], UP)
    assert outlying[loud].sum() > 10 * outlying[~loud].sum()
    beside, elsewhere = sizes_beside(uneven, FLAT[1], UP, outlying, scored)
    assert beside > 1.5 * elsewhere
    assert sizes_beside(spiky, FLAT[1], UP, none, scored)[0] == 0.0
    assert sizes_beside(spiky, FLAT[1], UP, none, none) == (0.0, 0.0)


def test_what_stands_out_is_the_same_for_a_renumbered_mesh() -> None:
    """The same places, whatever their numbers."""
    points = _rough(0.1)
    points[200::50, 2] -= 1.0
    shuffled, faces, old = renumbered((points, FLAT[1]))
    found = np.flatnonzero(outlying_vertices(shuffled, faces, UP))
    assert np.array_equal(np.sort(old[found]), np.flatnonzero(outlying_vertices(points, FLAT[1], UP)))


def test_noise_floor_is_that_of_the_flat_part() -> None:
    """Noise of 0.1 edges is found, less up to 0.04, whether or not half of the sheet has rough details; a quadric has none."""
    scored = far_from_border(FLAT[1], len(FLAT[0]))
    even, uneven = _rough(0.1), _rough(0.1)
    half = uneven[:, 0] > np.median(uneven[:, 0])
    uneven[half, 2] += 0.5 * np.random.default_rng(5).normal(size=half.sum())
    for points in (even, uneven):
        assert 0.06 < noise_floor(points, FLAT[1], normals=UP, scored=scored) < 0.1
    assert noise_floor(_rough(0.0), FLAT[1], normals=UP, scored=scored) == pytest.approx(0.0, abs=1e-12)


def test_an_exact_plane_does_not_make_a_noisy_scan_calm() -> None:
    """A third of the sheet without noise, as the base that closes a scan, leaves the level of the rest, a little less near it."""
    scored = far_from_border(FLAT[1], len(FLAT[0]))
    points = _rough(0.1)
    points[points[:, 0] < np.quantile(points[:, 0], 0.33), 2] = 0.0
    assert 0.04 < noise_floor(points, FLAT[1], normals=UP, scored=scored) < 0.1


def test_a_small_mesh_is_its_own_sample_and_a_large_one_is_sampled() -> None:
    """A sample has a mean edge of 1; patches are whole discs of about 450 faces at the same places of a renumbered mesh."""
    vertices, faces = torus(40, 20)
    whole = sample_of(vertices, faces)
    assert np.array_equal(whole.faces, faces)
    assert mean_edge_length(whole.points, whole.faces) == pytest.approx(1.0)
    mesh = noisy(torus(150, 80), 0.01)
    patches = sample_of(*mesh)
    assert 40 * 450 <= len(patches.faces) < 40 * 600
    assert mean_edge_length(patches.points, patches.faces) == pytest.approx(1.0)
    shuffled, other_faces, old = renumbered(mesh)
    again = sample_of(shuffled, other_faces)
    assert np.array_equal(np.sort(old[again.origin]), np.sort(patches.origin))


def test_taking_spikes_flattens_a_roof_and_rounding_its_ridge_does_not() -> None:
    """Where spikes and the vertices of the ridge may all go to where a rounding filter has them, the spikes alone do."""
    flat, faces = grid(20, 21)
    roof = flat - [10.0, 10.0, 0.0]
    roof[:, 2] = -1.5 * np.abs(roof[:, 0])
    inner = far_from_border(faces, len(roof), rings=0)
    ridge = (roof[:, 0] == 0.0) & inner
    spikes = np.zeros_like(ridge)
    spikes[np.flatnonzero(inner & ~ridge)[3::11]] = True
    points, rounded = roof.copy(), roof.copy()
    points[spikes, 2] += 1.0
    rounded[ridge, 2] -= 0.4
    assert np.array_equal(flattening(points, rounded, faces, ridge | spikes), spikes)
    turned, others, old = renumbered((points @ rotation().T, faces))
    found = flattening(turned, (rounded @ rotation().T)[old], others, (ridge | spikes)[old])
    assert np.array_equal(found, spikes[old])
    assert not flattening(points, roof, faces, np.zeros_like(spikes)).any()


def test_random_numbers_are_even_and_others_for_other_seeds() -> None:
    """Of n numbers n/10 lie in each tenth, within four deviations; neighbours and seeds do not correlate, by 4 over root n."""
    points, faces = noisy(torus(60, 30), 0.05)
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


def test_the_roughness_of_a_cube() -> None:
    """Twelve of its 18 edges are right angles, |n - m| = sqrt(2), six lie in a side; a plane and one triangle have 0."""
    vertices, faces = cube()
    assert roughness(vertices, faces) == pytest.approx(12.0 * np.sqrt(2.0) / 18.0)
    assert roughness(*irregular_grid()) == pytest.approx(0.0, abs=1e-12)
    assert roughness(vertices, faces[:1]) == 0.0
