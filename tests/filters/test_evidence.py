"""Choosing by held-out vertices: who is held out, where they are expected, and which candidate that speaks for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from pymeshfair.filters.denoising import Scan, noise_floor
from pymeshfair.filters.denoising.impulses import flattening, outlying_vertices, sizes_beside
from pymeshfair.filters.evidence import Choice, predicted_heights, scores_of, tuned
from pymeshfair.filters.evidence.held_out import far_from_border, held_out_vertices, middles_of_balls, put_at_means, random_signs
from pymeshfair.filters.geometry import mean_edge_length, roughness
from pymeshfair.filters.topology import OneRings, edges, one_rings
from tests.meshes import Floats, Ints, cube, grid, icosphere, irregular_grid, noisy, renumbered, rotation, torus

SHEET, FACES = irregular_grid(30, 34)
UP = np.tile([0.0, 0.0, 1.0], (len(SHEET), 1))
INNER = far_from_border(FACES, len(SHEET))
RINGS = one_rings(FACES, len(SHEET))


def rough(level: float) -> Floats:
    """The sheet with noise of so many mean edges along its normal; its mean edge is 1."""
    points = SHEET / mean_edge_length(SHEET, FACES)
    points[:, 2] += level * np.random.default_rng(0).normal(size=len(points))
    return points


def ring(i: int, rings: OneRings = RINGS) -> Ints:
    """The neighbours of a vertex."""
    return rings.neighbours[rings.offsets[i] : rings.offsets[i + 1]]


def chosen(points: Floats, families: Any, labels: Sequence[Sequence[Any]], stays: float = tuned.STAYS) -> Choice[Any]:
    """The choice on the sheet; `families` makes iterators over results of vertices of which some are held out."""
    scan = Scan(points, FACES)
    vars(scan)["normals"] = UP
    found = scan.choose(lambda vertices, held: families(vertices), labels, stays=stays)
    assert found is not None
    return found


def test_prediction_is_weighted_least_squares() -> None:
    """Height and gain are those of a quadric fitted by numpy to the two rings around, without the vertex and hidden ones."""
    points, hidden = rough(0.3), np.arange(len(SHEET)) % 7 == 0
    which = np.flatnonzero(INNER)[::50].astype(np.int32)
    heights, gains = predicted_heights(points, RINGS, UP, which, hidden)
    for i, height, gain in zip(which, heights, gains, strict=True):
        two = np.unique(np.concatenate([ring(i), *map(ring, ring(i))]))
        others = two[(two != i) & ~hidden[two]]
        scale = np.linalg.norm((points[ring(i)] - points[i])[:, :2], axis=1).mean()
        u, v, h = ((points[others] - points[i]) / scale).T
        root = np.sqrt(np.exp(-(u**2 + v**2) / (2 * 1.3**2)))
        terms = np.column_stack([np.ones_like(u), u, v, u * u, u * v, v * v]) * root[:, None]
        row = np.linalg.pinv(terms)[0] * root
        np.testing.assert_allclose([height, gain], [scale * row @ h, np.linalg.norm(row)], rtol=1e-9)


def test_a_held_out_vertex_is_the_mean_of_those_that_are_not() -> None:
    """Wherever it was; of two adjacent ones neither counts for the other, one without others stays, and all others stay."""
    points, faces = noisy(torus(12, 8), 0.1)
    rings = one_rings(faces, len(points))
    held = np.array([3, 5, ring(5, rings)[0]], dtype=np.int32)
    moved = points.copy()
    moved[held] += 7.0
    result = put_at_means(moved, rings, held)
    for i in held:
        np.testing.assert_allclose(result[i], points[np.setdiff1d(ring(i, rings), held)].mean(axis=0), rtol=1e-12)
    rest = np.setdiff1d(np.arange(len(points)), held)
    assert np.array_equal(result[rest], points[rest])
    assert np.array_equal(put_at_means(moved, rings, np.append(ring(5, rings), 5).astype(np.int32))[5], moved[5])


def test_the_errors_on_a_sheet_have_a_closed_form() -> None:
    """Doing nothing errs by z_i less the mean of z around it; pressing the sheet flat errs by z_i; each clipped at 4 medians.

    The medians are those of the flat sheet or of nothing, whichever has the smaller one: over all held-out vertices for the
    errors, over the 60 nearest ones for the excess.
    """
    points = rough(0.2)
    found = chosen(points, lambda v: [iter([v]), iter([v * (1.0, 1.0, 0.0)])], [["nothing"], ["flat"]], stays=1e12)
    held = np.concatenate(held_out_vertices(points, FACES, scored=INNER, sets=tuned.SETS))
    height = points[:, 2]
    sizes = np.abs([height[held] - [height[ring(i)].mean() for i in held], height[held]])
    best = sizes[np.median(sizes, axis=1).argmin()]
    near = np.linalg.norm(points[held, None] - points[held], axis=2).argsort(axis=1)[:, :60]
    errors = np.sqrt((np.minimum(sizes, 4.0 * np.median(best)) ** 2).mean(axis=1))
    np.testing.assert_allclose([trial.error for trial in found.trials], errors, rtol=1e-12)
    squares = (np.minimum(sizes, 4.0 * np.median(best[near], axis=1)) ** 2).mean(axis=1)
    np.testing.assert_allclose([trial.excess for trial in found.trials], squares - squares.min(), rtol=1e-12, atol=1e-15)


def test_held_out_vertices_are_apart_disjoint_and_of_the_geometry() -> None:
    """No two of a set are adjacent, the sets share none, each holds a twelfth to an eighth, and a moved mesh has the same."""
    vertices, faces = noisy(icosphere(4), 0.01)
    scored, pairs = np.ones(len(vertices), dtype=np.bool_), edges(faces)
    masks = held_out_vertices(vertices, faces, scored=scored, sets=4)
    for mask in masks:
        assert not np.isin(pairs, mask).all(axis=1).any()
        assert len(vertices) / 14 < len(mask) < len(vertices) / 7
    assert len(np.unique(np.concatenate(masks))) == sum(map(len, masks))
    shuffled, other_faces, old = renumbered((vertices, faces))
    again = held_out_vertices(5.0 * shuffled @ rotation().T + 2.0, other_faces, scored=scored, sets=4)
    assert [set(old[other]) for other in again] == [set(mask) for mask in masks]
    assert set(held_out_vertices(vertices, faces, scored=scored, sets=4, seed=1)[0]) != set(masks[0])


def test_balls_of_a_set_do_not_touch_and_are_of_the_geometry() -> None:
    """Middles are six edges apart or more, so that balls of two rings have a vertex between them; no ball more would fit."""
    vertices, faces = noisy(icosphere(4), 0.01)
    scored = np.ones(len(vertices), dtype=np.bool_)
    sets = middles_of_balls(vertices, faces, scored=scored, sets=4)
    graph = csr_matrix((np.ones(len(edges(faces))), edges(faces).T), shape=(len(vertices), len(vertices)))
    for middles in sets:
        steps = dijkstra(graph, directed=False, indices=middles, unweighted=True)
        assert steps[:, middles][~np.eye(len(middles), dtype=np.bool_)].min() >= 6
        assert steps.min(axis=0).max() <= 5
    shuffled, other_faces, old = renumbered((vertices, faces))
    again = middles_of_balls(5.0 * shuffled @ rotation().T + 2.0, other_faces, scored=scored, sets=4)
    assert [set(old[other]) for other in again] == [set(middles) for middles in sets]


def test_far_from_border_is_more_than_two_edges_away() -> None:
    """On a grid the three outermost rows are near."""
    vertices, faces = grid(9, 10)
    expected = np.zeros((10, 11), dtype=np.bool_)
    expected[3:-3, 3:-3] = True
    assert np.array_equal(far_from_border(faces, len(vertices)), expected.ravel())


def test_scores_are_those_of_clipped_squares() -> None:
    """The best, its excess and the standard error of that by their formulas; outliers count up to four medians."""
    deviations = np.random.default_rng(3).normal(size=(3, 400)) * np.array([[1.0], [1.5], [1.02]])
    deviations[0, 0] = 1e6
    scores = scores_of(deviations)
    squares = np.minimum(np.abs(deviations), 4 * np.median(np.abs(deviations), axis=1).min()) ** 2
    assert scores.best == int(squares.mean(axis=1).argmin())
    excess = squares[1] - squares[scores.best]
    assert (scores.excess[1], scores.uncertainty[1]) == pytest.approx((excess.mean(), excess.std() / 20.0))
    assert not scores.within(1.0)[1]
    assert scores.within(0.0)[scores.best]


def test_a_flipped_face_counts_as_a_deviation_of_three_tenths_of_an_edge() -> None:
    """Of equal heights those with fewer flipped faces are best; the excess is 0.09 times the difference of the shares."""
    heights = np.random.default_rng(5).normal(scale=0.1, size=50)
    scores = scores_of(np.stack([heights, -heights]), flipped=np.array([0.3, 0.1]))
    assert scores.best == 1
    np.testing.assert_allclose(scores.excess, [0.09 * 0.2, 0.0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(scores.errors**2, [(heights**2).mean() + 0.027, (heights**2).mean() + 0.009], rtol=1e-12)


def test_a_result_with_flipped_faces_loses_to_one_without() -> None:
    """A mirrored sheet has the heights of the sheet at its places, and every face of it flipped."""
    points = rough(0.05)
    mirrored = points * (-1.0, 1.0, 1.0)
    mirrored[:, 2] = points[:, 2]
    found = chosen(points, lambda v: [iter([mirrored, v])], [["mirrored", "as it is"]])
    assert found.chosen.label == "as it is"


def test_noise_on_a_plane_is_taken_away_and_a_wave_is_not() -> None:
    """Of multiples of the heights over a plane, noise speaks for a quarter at most and a smooth wave for 1."""
    shrink, wave = (1.0, 0.75, 0.5, 0.25, 0.0), rough(0.0)
    wave[:, 2] = 2.0 * np.sin(0.3 * wave[:, 0])
    for points, least, most in ((rough(0.2), 0.0, 0.25), (wave, 1.0, 1.0)):
        found = chosen(points, lambda v: [iter([v * (1.0, 1.0, keep) for keep in shrink])], [shrink])
        assert least <= found.chosen.label <= most


def test_a_family_that_falls_behind_is_not_run_to_its_end() -> None:
    """Of heights multiplied ever more, on a sheet with noise, no mask sees more than the first two."""
    shrink, grow = (1.0, 0.0), (2.0, 4.0, 8.0, 16.0, 32.0)
    made: list[float] = []

    def times(vertices: Floats, factors: tuple[float, ...]) -> Iterator[Floats]:
        for factor in factors:
            made.append(factor)
            yield vertices * (1.0, 1.0, factor)

    found = chosen(rough(0.2), lambda vertices: [times(vertices, shrink), times(vertices, grow)], [shrink, grow])
    assert found.chosen.label == 0.0
    assert set(made) == {*shrink, *grow[:2]}
    assert made.count(grow[0]) == 1


def test_a_single_candidate_that_is_left_is_not_asked_again() -> None:
    """The true plane beats one an edge above it on the first held-out vertices: no others are needed; without any no choice."""
    flat, asked = rough(0.3) * [1.0, 1.0, 0.0], list[int]()

    def families(vertices: Floats) -> list[Iterator[Floats]]:
        asked.append(len(vertices))
        return [iter([flat + UP]), iter([flat])]

    found = chosen(rough(0.3), families, [["above"], ["flat"]])
    assert (found.chosen.label, len(asked)) == ("flat", 1)
    assert Scan(rough(0.1), FACES, np.zeros_like(INNER)).choose(lambda points, _: families(points), [["above"], ["flat"]]) is None


def test_spikes_stand_out_and_the_tip_of_a_cone_does_not() -> None:
    """Every spike of an edge and a half on a sheet with noise is found, hardly anything else is, and a cone keeps its tip.

    They are the same places of a renumbered sheet.
    """
    spikes = np.flatnonzero(INNER)[::23]
    points = rough(0.1)
    points[spikes, 2] += 1.5
    found = outlying_vertices(points, FACES, UP)
    assert found[spikes].all()
    assert np.count_nonzero(found) < len(spikes) + 0.01 * len(points)
    assert not outlying_vertices(rough(0.1), FACES, UP)[spikes].any()
    shuffled, faces, old = renumbered((points, FACES))
    assert np.array_equal(outlying_vertices(shuffled, faces, UP), found[old])
    cone = rough(0.01)
    away = np.linalg.norm(cone[:, :2] - np.median(cone[:, :2], axis=0), axis=1)
    cone[:, 2] -= away
    assert not outlying_vertices(cone, FACES, UP)[away.argmin()]


def test_beside_spikes_a_sheet_is_as_rough_as_elsewhere_and_where_noise_is_loud_it_is_rougher() -> None:
    """With spikes both medians agree to a fifth; where noise is loud on one half outliers are there, and it is rougher."""
    spiky, uneven, none = rough(0.1), rough(0.05), np.zeros_like(INNER)
    spiky[np.flatnonzero(INNER)[::23], 2] += 1.5
    loud = uneven[:, 0] > np.median(uneven[:, 0])
    uneven[loud, 2] *= 6.0
    beside, elsewhere = sizes_beside(spiky, FACES, UP, outlying_vertices(spiky, FACES, UP), INNER)
    assert beside == pytest.approx(elsewhere, rel=0.2)
    outlying = outlying_vertices(uneven, FACES, UP)
    assert outlying[loud].sum() > 10 * outlying[~loud].sum()
    beside, elsewhere = sizes_beside(uneven, FACES, UP, outlying, INNER)
    assert beside > 1.5 * elsewhere
    assert sizes_beside(spiky, FACES, UP, none, INNER)[0] == 0.0
    assert sizes_beside(spiky, FACES, UP, none, none) == (0.0, 0.0)


def test_noise_floor_is_that_of_the_flat_part() -> None:
    """Noise of 0.1 edges is found, less up to 0.04, whether or not half of the sheet has rough details; a quadric has none.

    A third of the sheet without noise, as the base that closes a scan, leaves the level of the rest, a little less near it.
    """
    uneven, based = rough(0.1), rough(0.1)
    half = uneven[:, 0] > np.median(uneven[:, 0])
    uneven[half, 2] += 0.5 * np.random.default_rng(5).normal(size=half.sum())
    based[based[:, 0] < np.quantile(based[:, 0], 0.33), 2] = 0.0
    for points, least, most in ((rough(0.1), 0.06, 0.1), (uneven, 0.06, 0.1), (based, 0.04, 0.1), (rough(0.0), -1e-12, 1e-12)):
        assert least <= noise_floor(points, FACES, normals=UP, scored=INNER) < most


def test_a_small_mesh_is_its_own_sample_and_a_large_one_is_sampled() -> None:
    """A sample has a mean edge of 1; patches are whole discs of about 450 faces at the same places of a renumbered mesh."""
    vertices, faces = torus(40, 20)
    whole, _ = Scan.sampled(vertices, faces)
    assert np.array_equal(whole.faces, faces)
    mesh = noisy(torus(150, 80), 0.01)
    patches, origin = Scan.sampled(*mesh)
    assert 40 * 450 <= len(patches.faces) < 40 * 600
    for sample in (whole, patches):
        assert mean_edge_length(sample.points, sample.faces) == pytest.approx(1.0)
    shuffled, other_faces, old = renumbered(mesh)
    assert np.array_equal(np.sort(old[Scan.sampled(shuffled, other_faces)[1]]), np.sort(origin))


def test_taking_spikes_flattens_a_roof_and_rounding_its_ridge_does_not() -> None:
    """Where spikes and the vertices of the ridge may all go to where a rounding filter has them, the spikes alone do."""
    flat, faces = grid(20, 21)
    roof = flat - [10.0, 10.0, 0.0]
    roof[:, 2] = -1.5 * np.abs(roof[:, 0])
    inner = far_from_border(faces, len(roof), rings=0)
    ridge = (roof[:, 0] == 0.0) & inner
    spikes = np.isin(np.arange(len(roof)), np.flatnonzero(inner & ~ridge)[3::11])
    points, rounded = roof + np.outer(spikes, [0.0, 0.0, 1.0]), roof - np.outer(ridge, [0.0, 0.0, 0.4])
    assert np.array_equal(flattening(points, rounded, faces, ridge | spikes), spikes)
    turned, others, old = renumbered((points @ rotation().T, faces))
    found = flattening(turned, (rounded @ rotation().T)[old], others, (ridge | spikes)[old])
    assert np.array_equal(found, spikes[old])
    assert not flattening(points, roof, faces, np.zeros_like(spikes)).any()


def test_random_signs_are_even_and_others_for_other_seeds() -> None:
    """Of n signs half are 1, within four deviations; neighbours and seeds do not correlate, by 4 over the root of the number."""
    points, faces = noisy(torus(60, 30), 0.05)
    pairs = edges(faces)
    signs = [random_signs(points, pairs, seed) for seed in range(3)]
    i, j = pairs.T
    for values in (*signs, signs[0] * signs[1], signs[1] * signs[2]):
        assert abs(np.mean(values)) < 4.0 / np.sqrt(len(points))
    assert all(abs(np.mean(values[i] * values[j])) < 4.0 / np.sqrt(len(pairs)) for values in signs)


def test_the_roughness_of_a_cube() -> None:
    """Twelve of its 18 edges are right angles, |n - m| = sqrt(2), six lie in a side; a plane and one triangle have 0."""
    vertices, faces = cube()
    assert roughness(vertices, faces) == pytest.approx(12.0 * np.sqrt(2.0) / 18.0)
    assert roughness(*irregular_grid()) == pytest.approx(0.0, abs=1e-12)
    assert roughness(vertices, faces[:1]) == 0.0
