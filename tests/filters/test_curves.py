"""Smoothing of curves against the spectrum of the closed n-gon, dense algebra, and what curves must do."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest
from numpy.typing import NDArray

from pymeshfair.filters.checks import FilterInputError, UnstableStepError
from pymeshfair.filters.curves import CurveMethod, CurveWeights, curve_smoothing
from pymeshfair.filters.diffusion.explicit import mu_of_pass_band, transfer_function
from pymeshfair.filters.diffusion.implicit import time_step_of_detail_size
from pymeshfair.filters.operators import inverse_length_laplacian, uniform_laplacian

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

#: one of every kind, strong enough to see
SMOOTHINGS: tuple[dict[str, Any], ...] = (
    {"method": "explicit", "weights": "uniform", "iterations": 7},
    {"method": "explicit", "weights": "inverse_length", "iterations": 7},
    {"method": "taubin", "weights": "uniform", "iterations": 7},
    {"method": "taubin", "weights": "inverse_length", "iterations": 7},
    {"method": "implicit", "weights": "uniform", "time_step": 3.0, "iterations": 2},
    {"method": "implicit", "weights": "inverse_length", "time_step": 3.0, "iterations": 2},
    {"method": "implicit", "weights": "inverse_length", "detail_size": 0.8, "iterations": 2},
)


def ring(n: int) -> Ints:
    """The edges of a closed curve of n vertices."""
    at = np.arange(n, dtype=np.int32)
    return np.column_stack([at, (at + 1) % n]).astype(np.int32)


def path(n: int) -> Ints:
    """The edges of an open curve of n vertices."""
    return ring(n)[:-1]


def noise(n: int, seed: int = 7) -> Floats:
    """The vertices of a very wild curve."""
    return np.random.default_rng(seed).normal(size=(n, 3))


def fourier_basis(n: int) -> tuple[Floats, Floats]:
    """The eigenvalues cos(2 pi floor(i / 2) / n) - 1 of the n-gon, i from 1 to n, and the (n, n) orthonormal modes in columns."""
    i, j = np.arange(1, n + 1), np.arange(1, n + 1)[:, None]
    angles = 2 * np.pi * j * (i // 2) / n
    # Of the two waves of n / 2 periods the sine is 0 at every vertex.
    modes = np.where((i % 2 == 0) & (i < n), np.sin(angles), np.cos(angles))
    # The cosine less 1, without its cancellation.
    return -2 * np.sin(np.pi * (i // 2) / n) ** 2, modes / np.linalg.norm(modes, axis=0)


def dense(edges: Ints, n: int) -> Floats:
    """The uniform operator as its definition has it, edge by edge."""
    adjacency = np.zeros((n, n))
    for a, b in edges:
        adjacency[a, b] = adjacency[b, a] = 1.0
    return np.asarray(adjacency / adjacency.sum(axis=1)[:, None] - np.eye(n))


@pytest.mark.parametrize("n", [3, 4, 11, 64])
def test_the_spectrum_of_the_polygon(n: int) -> None:
    """On a closed n-gon the uniform operator has the eigenvalues cos(2 pi floor(i / 2) / n) - 1 with Fourier's basis."""
    eigenvalues, modes = fourier_basis(n)
    np.testing.assert_allclose(eigenvalues, np.cos(2 * np.pi * (np.arange(1, n + 1) // 2) / n) - 1, rtol=0, atol=1e-15)
    applied = uniform_laplacian(ring(n), n).matrix() @ modes
    np.testing.assert_allclose(applied, modes * eigenvalues, rtol=0, atol=1e-14)
    np.testing.assert_allclose(modes.T @ modes, np.eye(n), rtol=0, atol=1e-13)


@pytest.mark.parametrize("n", [3, 11, 64, 65])
@pytest.mark.parametrize(
    ("parameters", "response"),
    [
        ({"method": "explicit", "step": 0.4, "iterations": 9}, lambda k: (1 - 0.4 * k) ** 9),
        (
            {"method": "taubin", "step": 0.6, "mu": -0.64, "iterations": 12},
            lambda k: transfer_function(k, step=0.6, mu=-0.64, iterations=12),
        ),
        (
            {"method": "taubin", "step": 0.5, "pass_band": 0.05, "iterations": 5},
            lambda k: transfer_function(k, step=0.5, mu=mu_of_pass_band(0.05, 0.5), iterations=5),
        ),
        ({"method": "implicit", "time_step": 0.7, "iterations": 1}, lambda k: 1 / (1 + 0.7 * k)),
        ({"method": "implicit", "time_step": 250.0, "iterations": 3}, lambda k: 1 / (1 + 250 * k) ** 3),
    ],
)
def test_every_mode_is_multiplied_by_the_response(n: int, parameters: dict[str, Any], response: Any) -> None:
    """On a closed curve each Fourier coefficient of the coordinates comes out multiplied by the method's response, to 1e-12."""
    eigenvalues, modes = fourier_basis(n)
    points = noise(n)
    smooth = curve_smoothing(points, ring(n), **parameters)
    expected = modes @ (response(-eigenvalues)[:, None] * (modes.T @ points))
    np.testing.assert_allclose(smooth, expected, rtol=0, atol=1e-12 * np.ptp(points))


@pytest.mark.parametrize("time_step", [1e3, 1e8, 1e15, 1e40, 1e300])
def test_no_implicit_step_is_too_long(time_step: float) -> None:
    """However long the step, each mode of a ring of 1000 has its response, and far out the ring is its centroid to rounding."""
    n = 1000
    eigenvalues, modes = fourier_basis(n)
    points = noise(n) + 5.0
    with np.errstate(over="ignore"):
        response = 1 / (1 + time_step * -eigenvalues)
    response[0] = 1.0
    smooth = curve_smoothing(points, ring(n), method="implicit", time_step=time_step, iterations=1)
    expected = modes @ (response[:, None] * (modes.T @ points))
    np.testing.assert_allclose(smooth, expected, rtol=0, atol=2e-13 * np.ptp(points))


BRANCHING = np.array([[0, 1], [1, 2], [1, 3], [3, 4], [5, 6], [7, 8], [8, 5]], dtype=np.int32)


@pytest.mark.parametrize("border", ["fixed", "free"])
@pytest.mark.parametrize("edges", [path(9), BRANCHING])
def test_an_implicit_step_solves_the_equations(border: Any, edges: Ints) -> None:
    """Open and branching curves come out as dense algebra solves (1 - t L) p' = p, with rows of the identity for fixed ends."""
    points, held = noise(9), np.bincount(edges.ravel(), minlength=9) == 1
    matrix = np.eye(9) - 4.0 * dense(edges, 9)
    if border == "fixed":
        matrix[held] = np.eye(9)[held]
    smooth = curve_smoothing(points, edges, method="implicit", time_step=4.0, iterations=1, border=border)
    # Branching curves are solved for to 1e-10 of the diagonal.
    np.testing.assert_allclose(smooth, np.linalg.solve(matrix, points), rtol=0, atol=1e-9)
    if border == "fixed":
        np.testing.assert_array_equal(smooth[held], points[held])


def test_a_branching_vertex_goes_to_the_mean_of_all_its_neighbours() -> None:
    """With a full explicit step the centre of a star of five arms becomes their mean, weighted by inverse lengths if so asked."""
    edges = np.column_stack([np.zeros(5, np.int32), np.arange(1, 6, dtype=np.int32)]).astype(np.int32)
    points = noise(6)
    plain = curve_smoothing(points, edges, step=1.0, iterations=1)
    np.testing.assert_allclose(plain[0], points[1:].mean(axis=0), rtol=0, atol=1e-15)
    weights = 1 / np.linalg.norm(points[1:] - points[0], axis=1)
    weighted = curve_smoothing(points, edges, step=1.0, iterations=1, weights="inverse_length")
    np.testing.assert_allclose(weighted[0], weights @ points[1:] / weights.sum(), rtol=0, atol=1e-14)
    np.testing.assert_array_equal(plain[1:], points[1:])


@pytest.mark.parametrize("parameters", [p for p in SMOOTHINGS if p["weights"] == "inverse_length"])
def test_a_straight_line_stays_however_it_is_sampled(parameters: dict[str, Any]) -> None:
    """Edges whose lengths differ by up to 1:1000 along a slanted line keep their vertices, to rounding."""
    lengths = 10.0 ** np.random.default_rng(3).uniform(-3, 0, size=80)
    along = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
    points = np.array([1.0, -2.0, 0.5]) + along[:, None] * np.array([0.3, 0.9, -0.2])
    smooth = curve_smoothing(points, path(81), **parameters)
    np.testing.assert_allclose(smooth, points, rtol=0, atol=1e-14)
    # With uniform weights vertices would slide along it.
    assert np.abs(curve_smoothing(points, path(81)) - points).max() > 1e-3


@pytest.mark.parametrize("parameters", SMOOTHINGS)
def test_every_method_knows_no_place_size_turn_or_order(parameters: dict[str, Any]) -> None:
    """Moved, turned, scaled, renumbered, its edges shuffled and turned round, a mesh of curves comes out the same."""
    edges = np.concatenate([ring(20), path(15) + 20, [[40, 41], [40, 42], [40, 43]]]).astype(np.int32)
    points = noise(45)
    plain = curve_smoothing(points, edges, **parameters)
    random = np.random.default_rng(5)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    order, scale = random.permutation(45), 1000.0
    number = np.argsort(order).astype(np.int32)
    shuffled = random.permuted(number[random.permutation(edges)], axis=1)
    if "detail_size" in parameters:
        parameters = parameters | {"detail_size": parameters["detail_size"] * scale}
    other = curve_smoothing((points[order] @ turn * scale) + [3.0, 4.0, 5.0], shuffled, **parameters)
    # Weights of short edges magnify rounding; the branching part is solved for to 1e-10 of the diagonal.
    np.testing.assert_allclose((other - [3.0, 4.0, 5.0]) @ turn.T / scale, plain[order], rtol=0, atol=2e-9)


@pytest.mark.parametrize("parameters", SMOOTHINGS)
def test_what_does_not_move_keeps_every_bit(parameters: dict[str, Any]) -> None:
    """Fixed ends, vertices that are not movable, those without an edge however far away, and the plane of a planar curve."""
    points = noise(12)
    points[:, 2] = 0.1
    points[11] = 1e300
    movable = np.ones(12, dtype=np.bool_)
    movable[4:6] = False
    smooth = curve_smoothing(points, path(11), movable=movable, **parameters)
    np.testing.assert_array_equal(smooth[[0, 4, 5, 10, 11]], points[[0, 4, 5, 10, 11]])
    np.testing.assert_array_equal(smooth[:, 2], points[:, 2])
    assert (smooth[[1, 2, 3, 6, 7, 8, 9], :2] != points[[1, 2, 3, 6, 7, 8, 9], :2]).all()


@pytest.mark.parametrize("parameters", SMOOTHINGS)
def test_curves_of_one_mesh_know_nothing_of_each_other(parameters: dict[str, Any]) -> None:
    """A mesh of two curves comes out as the two alone; edges that are twice there or degenerate make no difference."""
    one, two = noise(10, 1), noise(13, 2)
    edges = np.concatenate([ring(10), path(13) + 10, [[3, 2], [5, 5], [3, 2]]]).astype(np.int32)
    together = curve_smoothing(np.concatenate([one, two]), edges, **parameters)
    np.testing.assert_allclose(together[:10], curve_smoothing(one, ring(10), **parameters), rtol=0, atol=1e-13)
    np.testing.assert_allclose(together[10:], curve_smoothing(two, path(13), **parameters), rtol=0, atol=1e-13)


@pytest.mark.parametrize("parameters", SMOOTHINGS)
def test_edges_without_length_do_no_harm(parameters: dict[str, Any]) -> None:
    """Two vertices in the same place, or all of them, give finite coordinates within the bounding box."""
    points = noise(10)
    points[4] = points[5]
    smooth = curve_smoothing(points, ring(10), **parameters)
    assert np.isfinite(smooth).all()
    if parameters["method"] != "taubin":
        assert (smooth >= points.min(axis=0) - 1e-12).all()
        assert (smooth <= points.max(axis=0) + 1e-12).all()
    np.testing.assert_array_equal(curve_smoothing(np.ones((10, 3)), ring(10), **parameters), np.ones((10, 3)))


def test_a_polygon_shrinks_under_laplacian_smoothing_and_keeps_its_size_under_taubin() -> None:
    """A regular polygon, which is its own first mode, shrinks by that mode's response; Taubin's keep length and area to 1 %."""
    n = 60
    angles = 2 * np.pi * np.arange(n) / n
    polygon = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(n)])
    k = 1 - np.cos(2 * np.pi / n)
    explicit = curve_smoothing(polygon, ring(n), step=0.5, iterations=400)
    np.testing.assert_allclose(explicit, (1 - 0.5 * k) ** 400 * polygon, rtol=0, atol=1e-13)
    assert (1 - 0.5 * k) ** 400 < 0.34
    taubin = curve_smoothing(polygon, ring(n), method="taubin", step=0.5, mu=-0.53, iterations=100)
    factor = float(transfer_function(k, step=0.5, mu=-0.53, iterations=100))
    assert factor == pytest.approx(1.0, abs=0.02)
    np.testing.assert_allclose(taubin, factor * polygon, rtol=0, atol=1e-13)


@pytest.mark.parametrize("weights", get_args(CurveWeights))
def test_closed_curves_contract(weights: Any) -> None:
    """A wild closed curve gets shorter with every Laplacian step."""
    points, lengths = noise(30), []
    for _ in range(5):
        lengths.append(np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum())
        points = curve_smoothing(points, ring(30), iterations=3, weights=weights)
    assert (np.diff(lengths) < 0).all()


def test_a_closed_curve_ends_as_its_centroid() -> None:
    """What is left of a wild closed curve after 5000 steps is the mean of its vertices: k = 0.022 is the least but 0."""
    smooth = curve_smoothing(noise(30), ring(30), iterations=5000)
    np.testing.assert_allclose(smooth, np.tile(noise(30).mean(axis=0), (30, 1)), rtol=0, atol=1e-12)


def test_near_neighbours_hold_each_other_but_not_by_arc_length() -> None:
    """Under inverse lengths two vertices next to each other pin a spike; with a detail size it goes like any other."""
    points = np.column_stack([np.arange(21.0), np.zeros(21), np.zeros(21)])
    points[10] = [9.5, 5.0, 0.0]
    points[11] = [9.5001, 5.0, 0.0]
    pinned = curve_smoothing(points, path(21), weights="inverse_length", iterations=10)
    smooth = curve_smoothing(points, path(21), weights="inverse_length", method="implicit", detail_size=20.0, iterations=10)
    assert pinned[10:12, 1].min() > 4.9
    assert smooth[10:12, 1].max() < 3.5


@pytest.mark.parametrize("iterations", [1, 4])
def test_a_wave_of_the_detail_size_is_halved(iterations: int) -> None:
    """On a long line sampled unevenly, a wave of the detail size has half its height, one of four times it 0.941 or more."""
    random = np.random.default_rng(11)
    along = np.sort(random.uniform(0, 40, size=20_001))
    for length, expected in ((1.0, 0.5), (4.0, 1 / (1 + (2 ** (1 / iterations) - 1) / 16) ** iterations)):
        wave = np.cos(2 * np.pi * along / length)
        points = np.column_stack([along, 1e-3 * wave, 0 * along])
        smooth = curve_smoothing(
            points, path(len(along)), method="implicit", weights="inverse_length", detail_size=1.0, iterations=iterations
        )
        inside = (along > 4) & (along < 36)
        height = (smooth[inside, 1] @ wave[inside]) / (wave[inside] @ wave[inside]) / 1e-3
        # Edges of 1/500 of a wave: the second derivative is right to their square over 12; the slope of the wave is 0.006.
        assert height == pytest.approx(expected, abs=1e-3)


def test_a_detail_size_is_a_time_of_the_second_derivative_by_arc_length() -> None:
    """On a regular polygon of edge h the detail size l is the implicit step t = 2 t(l) / h^2 of the normalised operator."""
    n = 40
    angles = 2 * np.pi * np.arange(n) / n
    polygon = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(n)])
    by_size = curve_smoothing(polygon, ring(n), method="implicit", weights="inverse_length", detail_size=2.5, iterations=3)
    time_step = 2 * time_step_of_detail_size(2.5, 3) / (2 * np.sin(np.pi / n)) ** 2
    by_time = curve_smoothing(polygon, ring(n), method="implicit", weights="inverse_length", time_step=time_step, iterations=3)
    np.testing.assert_allclose(by_size, by_time, rtol=0, atol=1e-13)


@pytest.mark.parametrize("exponent", [-900, -665, 665, 900])
def test_a_detail_size_is_a_length_however_small_or_large_the_curve(exponent: int) -> None:
    """Times a power of two the curve and the detail size give the curve times that power, to the bit, where squares are none."""
    vertices, edges = noise(20), np.concatenate([ring(20), [[0, 10]]]).astype(np.int32)
    size = 2.0**exponent
    for pairs in (edges, ring(20)):
        expected = curve_smoothing(vertices, pairs, method="implicit", weights="inverse_length", detail_size=2.0)
        found = curve_smoothing(vertices * size, pairs, method="implicit", weights="inverse_length", detail_size=2.0 * size)
        np.testing.assert_array_equal(found, expected * size)


def test_detail_sizes_beyond_all_measure() -> None:
    """One of 1e-300 moves nothing; one of 1e300 leaves what the largest ordinary one leaves."""
    vertices = noise(20)
    nothing, all_there_is, most = (
        curve_smoothing(vertices, ring(20), method="implicit", weights="inverse_length", detail_size=size)
        for size in (1e-300, 1e300, 1e40)
    )
    np.testing.assert_allclose(nothing, vertices, rtol=0, atol=1e-15)
    np.testing.assert_allclose(all_there_is, most, rtol=0, atol=1e-13)


@pytest.mark.parametrize("weights", get_args(CurveWeights))
def test_explicit_and_implicit_steps_agree_to_first_order(weights: Any) -> None:
    """A short step differs between the two by t^2 |L^2 p| at most: by a quarter for half the step."""
    points = noise(25)
    laplacian = uniform_laplacian(ring(25), 25) if weights == "uniform" else inverse_length_laplacian(points, ring(25))
    twice = np.abs(laplacian.apply(laplacian.apply(points))).max()
    for t in (1e-2, 1e-3):
        explicit = curve_smoothing(points, ring(25), weights=weights, step=t, iterations=1)
        implicit = curve_smoothing(points, ring(25), weights=weights, method="implicit", time_step=t, iterations=1)
        assert 0.5 * t**2 * twice < np.abs(explicit - implicit).max() <= 1.01 * t**2 * twice


@pytest.mark.parametrize(
    "parameters", [{"method": "implicit", "time_step": 1e9, "iterations": 1}, {"method": "taubin", "iterations": 25}]
)
def test_a_large_curve_in_no_order(parameters: dict[str, Any]) -> None:
    """200,001 vertices in random order, some of which stay, have the response of each mode, as the Fourier transform has it."""
    n = 200_001
    angles = 2 * np.pi * np.arange(n) / n
    points = np.column_stack([np.cos(angles), np.sin(angles), np.sin(5 * angles)]) + 1e-3 * noise(n)
    k = 2 * np.sin(np.pi * np.arange(n // 2 + 1) / n) ** 2
    response = 1 / (1 + 1e9 * k) if "time_step" in parameters else transfer_function(k, step=0.5, mu=-0.53, iterations=25)
    expected = np.fft.irfft(np.fft.rfft(points, axis=0) * response[:, None], n=n, axis=0)
    order = np.random.default_rng(9).permutation(n)
    number = np.argsort(order).astype(np.int32)
    # A star that does not move, and a vertex without edges.
    star = np.array([[n, n + 1], [n, n + 2], [n, n + 3]], dtype=np.int32)
    edges = np.concatenate([number[ring(n)], star])
    movable = np.arange(n + 5) < n
    extra = noise(5)
    smooth = curve_smoothing(np.concatenate([points[order], extra]), edges, movable=movable, **parameters)
    np.testing.assert_allclose(smooth[:n], expected[order], rtol=0, atol=1e-11)
    np.testing.assert_array_equal(smooth[n:], extra)


def test_free_ends_draw_in() -> None:
    """With a full step a free end takes its neighbour's place."""
    points = noise(6)
    smooth = curve_smoothing(points, path(6), border="free", step=1.0, iterations=1)
    np.testing.assert_allclose(smooth[[0, 5]], points[[1, 4]], rtol=0, atol=1e-15)


def test_nothing_to_do() -> None:
    """No vertices, no edges, no iterations: the vertices as they came."""
    none = np.empty((0, 2), dtype=np.int32)
    for method in get_args(CurveMethod):
        extra: dict[str, Any] = {"time_step": 1.0} if method == "implicit" else {}
        assert curve_smoothing(np.empty((0, 3)), none, method=method, **extra).shape == (0, 3)
        np.testing.assert_array_equal(curve_smoothing(noise(4), none, method=method, **extra), noise(4))
        np.testing.assert_array_equal(curve_smoothing(noise(4), ring(4), method=method, iterations=0, **extra), noise(4))


def test_progress_ends_at_one_and_can_stop() -> None:
    """The share that is done grows to 1, and what the callback raises comes out."""
    for parameters in SMOOTHINGS:
        shares: list[float] = []
        curve_smoothing(noise(9), ring(9), progress=shares.append, **parameters)
        assert shares == sorted(shares)
        assert shares[-1] == 1.0

        def stop(share: float) -> None:
            raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            curve_smoothing(noise(9), ring(9), progress=stop, **parameters)


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"method": "other"}, "method 'other' is not one of 'explicit'"),
        ({"weights": "cotangent"}, "weights 'cotangent'"),
        ({"border": "along"}, "border 'along' is not one of 'fixed', 'free'"),
        ({"step": 0.0}, "above 0 and at most 1"),
        ({"step": 1.5}, "above 0 and at most 1"),
        ({"step": float("nan")}, "above 0 and at most 1"),
        ({"iterations": -1}, "iterations is -1"),
        ({"method": "taubin", "mu": -0.4}, "mu is -0.4: it must be below -step"),
        ({"method": "taubin", "pass_band": 3.0}, "pass_band is 3.0"),
        ({"method": "implicit"}, "either a time_step or a detail_size"),
        ({"method": "implicit", "time_step": 1.0, "detail_size": 1.0}, "either a time_step or a detail_size"),
        ({"method": "implicit", "time_step": -1.0}, "time_step is -1.0"),
        ({"method": "implicit", "time_step": float("inf")}, "time_step is inf"),
        ({"method": "implicit", "detail_size": 1.0}, "uniform weights do not depend on lengths"),
        ({"method": "implicit", "weights": "inverse_length", "detail_size": 0.0}, "detail_size is 0.0"),
        ({"time_step": 1.0}, "are for the method 'implicit'"),
        ({"movable": [True]}, "movable must be"),
    ],
)
def test_wrong_parameters_are_refused(parameters: dict[str, Any], words: str) -> None:
    """Each message names the parameter, the value and what is allowed."""
    with pytest.raises(FilterInputError, match=words):
        curve_smoothing(noise(5), ring(5), **parameters)


@pytest.mark.parametrize(
    ("edges", "words"),
    [([[0, 1, 2]], "shape"), ([[0.0, 1.0]], "whole numbers"), ([[0, 1], [1, 5]], "edge 1 is"), ([[-1, 1]], "edge 0 is")],
)
def test_wrong_edges_are_refused(edges: Any, words: str) -> None:
    """Edges that are no pairs of vertices are named."""
    with pytest.raises(FilterInputError, match=words):
        curve_smoothing(noise(5), edges)


def test_taubin_steps_that_make_detail_grow_are_refused() -> None:
    """A step back that amplifies the alternation of neighbours is an error that names the largest stable step."""
    with pytest.raises(UnstableStepError, match="makes the finest detail grow"):
        curve_smoothing(noise(4), ring(4), method="taubin", step=0.9, mu=-1.9)


def test_a_spike_of_a_curve_is_not_put_down_to_triangles() -> None:
    """A pass band of nearly all frequencies makes the waves within it grow; the message names the step."""
    with pytest.raises(
        FilterInputError, match=r"diagonals of the bounding box .* or a step too long: improve the mesh first, or smooth"
    ):
        curve_smoothing(noise(60), ring(60), method="taubin", step=0.5, pass_band=1.9, iterations=50)
