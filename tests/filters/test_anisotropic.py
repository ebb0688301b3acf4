"""Perona and Malik's diffusion against a loop over vertices, its principles, and what it does to steps and noise."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pymeshfair.filters import topology
from pymeshfair.filters.checks import FilterInputError, UnstableStepError
from pymeshfair.filters.diffusion.anisotropic import EDGE_STOPS, EdgeStop, longest_step, perona_malik
from tests.meshes import AWKWARD, grid, icosphere, renumbered, wheel

Floats = NDArray[np.float64]


def stopping(name: EdgeStop, x: float) -> float:
    """The edge-stopping functions as the papers print them, for a contrast of 1."""
    return {
        "lorentzian": 1 / (1 + x**2),
        "gaussian": math.exp(-(x**2)),
        "tukey": (1 - x**2) ** 2 if x < 1 else 0.0,
        "huber": 1 if x < 1 else 1 / x,
        "hampel": 1.0 if x <= 1 else 1 / x if x <= 2 else (4 - x) / (2 * x) if x < 4 else 0.0,
        "truncated_l2": 1.0 if x < 1 else 0.0,
        "l2": 1.0,
    }[name]


def random_values(n: int, channels: int = 1, seed: int = 0) -> Floats:
    """Deviates from 0 to 1, (n, channels)."""
    return np.random.default_rng(seed).random((n, channels))


@pytest.mark.parametrize("name", EDGE_STOPS)
@pytest.mark.parametrize("channels", [1, 3])
def test_a_loop_over_vertices_gives_the_same(name: EdgeStop, channels: int) -> None:
    """One step is its equation, to 1e-10; the channels of a colour share the norm of their difference."""
    vertices, faces = icosphere(2)
    values = random_values(len(vertices), channels)
    expected = values.copy()
    for i, j in {(i, j) for face in faces.tolist() for i in face for j in face if i != j}:
        difference = values[j] - values[i]
        expected[i] += 0.15 * stopping(name, float(np.linalg.norm(difference)) / 0.4) * difference
    found = perona_malik(values, faces, edge_stop=name, contrast=0.4, step=0.15, iterations=1)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("name", EDGE_STOPS)
def test_the_sum_stays_and_no_value_leaves_the_range(name: EdgeStop) -> None:
    """At the longest step that is allowed the sum of the values is kept to rounding, and the maximum principle to the bit."""
    vertices, faces = icosphere(3)
    values = random_values(len(vertices))[:, 0]
    found = perona_malik(values, faces, edge_stop=name, iterations=200)
    assert found.sum() == pytest.approx(values.sum(), rel=1e-12)
    assert values.min() <= found.min() <= found.max() <= values.max()
    assert found.std() < values.std()


def test_longer_steps_are_refused_with_the_longest() -> None:
    """The bound is one over the largest number of neighbours; a longer step does leave the range, as the error says."""
    _, faces = wheel(7)
    assert longest_step(faces) == 1 / 7
    assert longest_step(faces[:0]) == 1.0
    with pytest.raises(UnstableStepError, match=r"with step 0.143 values may leave their range: take at most 0.142857") as caught:
        perona_malik(np.arange(8.0), faces, step=0.143)
    assert caught.value.largest_stable == 1 / 7
    perona_malik(np.arange(8.0), faces, step=1 / 7)


@pytest.mark.parametrize("name", [k for k in EDGE_STOPS if k not in ("l2", "huber")])
def test_a_step_stays_while_noise_falls(name: EdgeStop) -> None:
    """With the automatic contrast noise of 0.03 falls to a third beside a step of 1 that keeps 90 % of its height."""
    vertices, faces = grid(30, 30)
    right = vertices[:, 0] > 15.5
    values = right + np.random.default_rng(0).normal(0, 0.03, len(vertices))
    found = perona_malik(values, faces, edge_stop=name, iterations=40)
    for side in (right, ~right):
        inner = side & (np.abs(vertices[:, 0] - 15.5) > 3)
        assert found[inner].std() < values[inner].std() / 3
    beside = np.abs(vertices[:, 0] - 15.5) < 1
    assert found[beside & right].mean() - found[beside & ~right].mean() > 0.9
    assert perona_malik(values, faces, edge_stop="l2", iterations=40)[beside & right].mean() < 0.75


def test_scale_shift_and_numbering_make_no_difference() -> None:
    """Values times a number plus another one come out so too, with the automatic contrast; renumbering commutes with it."""
    vertices, faces = icosphere(2)
    values = random_values(len(vertices), 3)
    expected = perona_malik(values, faces)
    np.testing.assert_allclose(perona_malik(values * 255 - 20, faces), expected * 255 - 20, rtol=0, atol=1e-9)
    _, others, order = renumbered((vertices, faces))
    np.testing.assert_allclose(perona_malik(values[order], others), expected[order], rtol=0, atol=1e-12)
    np.testing.assert_allclose(perona_malik(values * 1e200, faces) / 1e200, expected, rtol=0, atol=1e-12)


def test_constant_values_and_vertices_without_faces_keep_every_bit() -> None:
    """Nothing flows between equal values, nor to or from vertices that are unused or not movable."""
    vertices, faces = AWKWARD["isolated vertices"]()
    values = random_values(len(vertices))[:, 0]
    values[0] = -0.0
    unused = ~topology.referenced_vertices(faces, len(vertices))
    movable = np.arange(len(values)) % 2 == 0
    found = perona_malik(values, faces, movable=movable)
    assert found[unused | ~movable].tobytes() == values[unused | ~movable].tobytes()
    assert (found[~unused & movable] != values[~unused & movable]).all()
    constant = np.full(len(values), -0.3)
    assert perona_malik(constant, faces).tobytes() == constant.tobytes()


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_stay_finite(name: str) -> None:
    """Degenerate faces and non-manifold edges give no NaN and no value outside the range."""
    vertices, faces = AWKWARD[name]()
    values = random_values(len(vertices), 4)
    found = perona_malik(values, faces)
    assert found.shape == values.shape
    if len(values):
        assert values.min() <= found.min() <= found.max() <= values.max()


def test_progress_is_told() -> None:
    """The share of the work done is reported after each iteration."""
    told: list[float] = []
    vertices, faces = icosphere(1)
    perona_malik(vertices[:, 0], faces, iterations=4, progress=told.append)
    assert told == [0.25, 0.5, 0.75, 1.0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"edge_stop": "l1"}, "edge_stop 'l1' is not one of 'lorentzian', 'gaussian'"),
        ({"contrast": 0.0}, "contrast is 0.0: it must be finite and above 0"),
        ({"step": -0.1}, "step is -0.1: it must be finite and above 0"),
        ({"iterations": -1}, "iterations is -1: it must be a whole number"),
        ({"movable": [True]}, r"movable must be a boolean array of 42 values, one per vertex, got shape \(1,\)"),
    ],
)
def test_parameters_are_checked(options: dict[str, Any], message: str) -> None:
    """What is out of range is an error that names the parameter, the value and what is allowed."""
    vertices, faces = icosphere(1)
    with pytest.raises(FilterInputError, match=message):
        perona_malik(vertices[:, 0], faces, **options)


def test_values_and_faces_are_checked() -> None:
    """Values that are missing or not finite, in one channel alone too, are errors that say which."""
    vertices, faces = icosphere(1)
    values = vertices[:, 0].copy()
    with pytest.raises(FilterInputError, match="faces name the vertices 0 to 41, but the number of values is 41"):
        perona_malik(values[:-1], faces)
    with pytest.raises(FilterInputError, match="faces name the vertices 0 to 41, but the number of values is 0"):
        perona_malik(values[:0], faces)
    with pytest.raises(FilterInputError, match=r"values must have the shape \(n,\) or \(n, k\), got \(\)"):
        perona_malik(1.0, faces)
    values[[3, 7]] = np.nan, np.inf
    for bad in (values, np.column_stack([np.zeros(42), values])):
        with pytest.raises(FilterInputError, match="2 of 42 vertices have a value that is not finite, the first is vertex 3"):
            perona_malik(bad, faces)
