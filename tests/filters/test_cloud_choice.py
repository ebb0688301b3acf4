"""The setting of the bilateral projection that held-out points choose."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cloud_pairs import SURFACES, spacing_of  # benchmarks/cloud_pairs.py

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.choosing import Projection, chosen_projection
from pymeshfair.filters.choosing import clouds as choosing
from pymeshfair.filters.choosing.clouds import CloudSample
from pymeshfair.filters.compilation import single_thread
from pymeshfair.filters.denoising import bilateral_projection
from tests.meshes import Floats, rotation

N = 3000


def cloud(name: str, level: float = 0.0) -> Floats:
    """Points strewn over a surface of the benchmark, with normally distributed noise of so many spacings in all directions."""
    points = SURFACES[name][0](np.random.default_rng(0), N)
    return np.asarray(points + np.random.default_rng(1).normal(size=points.shape) * level * spacing_of(points))


def error(name: str, points: Floats) -> float:
    """The root mean square distance to the surface."""
    return float(np.sqrt(np.mean(SURFACES[name][1](points) ** 2)))


def sheet(points: Floats) -> CloudSample:
    """A sample of points over the plane z = 0, its normals known."""
    return CloudSample(points, np.ones(len(points), dtype=np.bool_), np.tile([0.0, 0.0, 1.0], (len(points), 1)))


@pytest.mark.parametrize("name", ["ball", "land", "box"])
def test_a_cloud_without_noise_is_clean(name: str) -> None:
    """Whether it is curved, wavy or has edges; then there is no choice, and nothing to do."""
    assert chosen_projection(cloud(name)) is None


@pytest.mark.slow
@pytest.mark.parametrize("level", [0.1, 0.3, 0.6])
def test_the_choice_is_nearly_the_best(level: float) -> None:
    """On a ball the error is within a fifth of the least of seven settings from weak to strong, and at most 0.6 of the noise."""
    points = cloud("ball", level)
    found = chosen_projection(points)
    assert found is not None
    tried = [(8, 1), (12, 1), (12, 2), (18, 1), (18, 2), (27, 1), (27, 2)]
    best = min(error("ball", bilateral_projection(points, neighbors=k, iterations=i)) for k, i in tried)
    result = error("ball", bilateral_projection(points, **found.chosen.label._asdict()))
    assert result < 1.2 * best
    assert result < 0.6 * error("ball", points)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "most"), [("torus", 0.7), ("box", 1.0)])
def test_quadrics_are_chosen_where_they_are_better(name: str, most: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a noisy torus the degree 2 leaves less than 0.7 of the error of the degree 1, on a box with sharp edges no more."""
    points, errors = cloud(name, 0.3), []
    for degrees in ({1, 2}, {1}):
        monkeypatch.setattr(choosing, "_TRIED", {degree: choosing._TRIED[degree] for degree in degrees})
        found = chosen_projection(points)
        assert found is not None
        assert name == "box" or found.chosen.label.degree == max(degrees)
        errors.append(error(name, bilateral_projection(points, **found.chosen.label._asdict())))
    assert errors[0] <= most * errors[1]


def test_the_first_trial_is_doing_nothing_and_the_chosen_one_is_as_good_as_the_best() -> None:
    """Its excess over the best is at most one standard error, and no other as good does less."""
    found = chosen_projection(cloud("land", 0.3))
    assert found is not None
    assert found.trials[0].label == Projection(0, 0.0, 0)
    equal = [trial for trial in found.trials if trial.excess <= trial.uncertainty]
    assert found.chosen in equal
    assert found.chosen.label.amount == min(trial.label.amount for trial in equal)


def test_place_size_order_and_threads_make_no_difference() -> None:
    """The same errors of the same settings, range sigmas scaled with the cloud."""
    points = cloud("land", 0.3)
    first = chosen_projection(points)
    order = np.random.default_rng(4).permutation(len(points))
    with single_thread():
        second = chosen_projection(7.0 * points[order] @ rotation().T + [5.0, -3.0, 2.0])
    assert first is not None
    assert second is not None
    assert first.chosen.label[::2] == second.chosen.label[::2]
    np.testing.assert_allclose([t.error for t in second.trials], [t.error for t in first.trials], rtol=1e-6)
    np.testing.assert_allclose([t.label[1] for t in second.trials], [7.0 * t.label[1] for t in first.trials], rtol=1e-9)


def test_what_is_given_is_not_chosen() -> None:
    """A range sigma that is given is that of every setting tried, with the points' own normals too."""
    found = chosen_projection(cloud("ball", 0.3), normals=cloud("ball"), range_kernel="tukey", range_sigma=0.05, space_sigma=0.1)
    assert found is not None
    np.testing.assert_allclose([trial.label.range_sigma for trial in found.trials[1:]], 0.05, rtol=1e-12)
    assert found.chosen.label.iterations > 0


@pytest.mark.slow
def test_patches_of_a_large_cloud_choose_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """On patches of a ball the numbers of neighbours and iterations are within one step of those on all of it."""
    points = cloud("ball", 0.3)
    whole = chosen_projection(points)
    monkeypatch.setattr(choosing, "_WHOLE", 1000)
    patched = chosen_projection(points)
    assert whole is not None
    assert patched is not None
    assert whole.chosen.label.degree == patched.chosen.label.degree
    counts = choosing._TRIED[whole.chosen.label.degree][0]
    steps = [counts.index(found.chosen.label.neighbors) for found in (whole, patched)]
    assert abs(steps[0] - steps[1]) <= 1
    assert abs(whole.chosen.label.iterations - patched.chosen.label.iterations) <= 1


@pytest.mark.slow
def test_only_points_that_may_move_are_evidence() -> None:
    """Where none may there is no choice; where the noisy half may not, the other half is clean."""
    points, noisy = cloud("ball"), cloud("ball", 0.3)
    assert chosen_projection(noisy, movable=np.zeros(N, dtype=np.bool_)) is None
    upper = points[:, 2] > 0.0
    half = np.where(upper[:, None], noisy, points)
    assert chosen_projection(half, movable=~upper) is None
    assert chosen_projection(half, movable=upper) is not None


def test_held_out_points_tell_nothing_of_themselves() -> None:
    """Wherever a held-out point of a plane is along the normal, the others and where it is put are the same; the cost is not."""
    points = np.random.default_rng(5).random((400, 3)) * [20.0, 20.0, 0.0]
    held = np.array([100], dtype=np.int32)
    moved = points.copy()
    moved[100, 2] = 0.01
    for cloud, height in ((points, 0.0), (moved, 0.01)):
        sample = sheet(cloud)
        start, cost = sample.without(held)
        np.testing.assert_array_equal(np.delete(start, 100, axis=0), np.delete(cloud, 100, axis=0))
        # What it is off by is as large as the noise, which is its own distance here.
        assert abs(start[100, 2]) <= np.sqrt(3.0) / 0.6745 * height
        assert np.abs(cost[0]) <= np.sqrt(2.0) * height


def test_neighbours_agree_on_waves_and_not_on_noise() -> None:
    """Heights of independent noise over a plane agree by less than 0, those of short waves by more."""
    points = np.random.default_rng(6).random((N, 3)) * [50.0, 50.0, 0.0]
    for height, sign in ((0.2 * np.random.default_rng(7).normal(size=N), -1.0), (np.sin(1.5 * points[:, 0]), 1.0)):
        assert sign * sheet(points + height[:, None] * [0.0, 0.0, 1.0]).correlation > 0.05


def test_clouds_that_are_no_clouds() -> None:
    """Too few points are refused; coincident ones, a line of points, and seven of them are left alone."""
    with pytest.raises(FilterInputError, match="6 neighbours need a cloud of at least 7 points"):
        chosen_projection(cloud("ball")[:6])
    assert chosen_projection(np.zeros((100, 3))) is None
    assert chosen_projection(np.outer(np.arange(100.0), [1.0, 2.0, 3.0])) is None
    assert chosen_projection(cloud("ball")[:7]) is None


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_a_bad_scale_or_kernel_is_named_as_it_was_given(noise: float) -> None:
    """The error has the caller's value, not the value in spacings, and clean clouds raise it too."""
    with pytest.raises(FilterInputError, match="space_kernel 'cosine' is not one of 'l2'"):
        chosen_projection(cloud("ball", noise), space_kernel="cosine")  # type: ignore[arg-type]
    with pytest.raises(FilterInputError, match=r"range_sigma is -1\.0: it must be finite and above 0"):
        chosen_projection(cloud("ball", noise), range_sigma=-1.0)


@pytest.mark.parametrize("name", ["range_kernel", "space_kernel"])
def test_an_unknown_kernel_is_refused_on_a_clean_cloud_too(name: str) -> None:
    """A cloud on which no kernel is used does not hide the mistake."""
    unknown: dict[str, Any] = {name: "box"}
    with pytest.raises(FilterInputError, match=f"{name} 'box' is not one of 'l2', "):
        chosen_projection(cloud("ball"), **unknown)
