"""LoOP against the paper's formula, PyNomaly, ELKI and MeshLab."""

from __future__ import annotations

import math
import os
import warnings
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray
from PyNomaly import loop
from scipy.special import erf
from scipy.stats import rankdata

from pymeshfair.filters import execution as threads
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.neighbours import nearest_neighbours
from pymeshfair.filters.outliers.local_outlier_probability import local_outlier_probability, outlier_factors

Floats = NDArray[np.float64]
SAMPLES = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"

#: the 20 scalars of PyNomaly's own tests and the probabilities published there, for 10 neighbours and extent 3
SCALARS = [
    0.02059752, 0.32629926, 0.63036653, 0.94409321, 0.63251097, 0.47598494, 0.80204026, 0.34845067, 0.81556468, 0.89183,
    0.25210317, 0.11460502, 0.19953434, 0.36955067, 0.06038041, 0.34527368, 0.56621582, 0.90533649, 0.33773613, 0.71573306,
]  # fmt: skip
PUBLISHED = [
    0.6356276742921594, 0, 0, 0.48490790006974044, 0, 0, 0, 0, 0.021728288376168012, 0.28285086151683225,
    0, 0.18881886507113213, 0, 0, 0.45350246469681843, 0, 0.07886635748113013, 0.3349068501560546, 0, 0,
]  # fmt: skip


def cloud(n: int, outliers: int, seed: int = 0) -> Floats:
    """A bumpy sphere of n points whose density varies tenfold, and the given number of points in the box around it at its end."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(n, 3)) * [1.0, 1.0, 3.0]
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points *= 1.0 + 0.1 * np.sin(7.0 * points[:, :1])
    return np.concatenate([points, random.uniform(-1.5, 1.5, (outliers, 3))])


def by_the_formula(points: Floats, k: int, extent: float) -> Floats:
    """The definition, with all distances in a matrix."""
    distances = np.linalg.norm(points[:, None] - points[None, :], axis=2)
    np.fill_diagonal(distances, np.inf)
    nearest = np.argsort(distances, axis=1)[:, :k]
    sigma = np.sqrt((np.take_along_axis(distances, nearest, axis=1) ** 2).sum(axis=1) / k)
    factors = sigma / sigma[nearest].mean(axis=1) - 1.0
    probabilities: Floats = np.maximum(0.0, erf(factors / (extent * np.sqrt((factors**2).mean()) * math.sqrt(2.0))))
    return probabilities


@pytest.mark.parametrize(("k", "extent"), [(1, 1.0), (5, 2.0), (20, 3.0), (64, 0.5)])
def test_is_the_formula_of_the_paper(k: int, extent: float) -> None:
    """The probabilities are those of the definition, written down with a matrix of distances.

    PLOF is a difference of numbers near 1, so a few roundings of 1e-16 over its spread of about 0.1 remain: 1e-13.
    """
    points = cloud(900, 30)
    probabilities = local_outlier_probability(points, neighbors=k, extent=extent)
    np.testing.assert_allclose(probabilities, by_the_formula(points, k, extent), rtol=0.0, atol=1e-13)


def test_pynomaly_published() -> None:
    """The 20 published values of PyNomaly, scalars taken as points of the x axis."""
    points = np.stack([SCALARS, np.zeros(20), np.zeros(20)], axis=1)
    np.testing.assert_allclose(local_outlier_probability(points, neighbors=10, extent=3.0), PUBLISHED, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(("k", "extent"), [(10, 3), (25, 2), (40, 1)])
def test_pynomaly_live(k: int, extent: int) -> None:
    """PyNomaly, run on the same cloud, gives the same probabilities."""
    points = cloud(300, 20, seed=k)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # PyNomaly's own
        theirs = loop.LocalOutlierProbability(points, extent=extent, n_neighbors=k).fit().local_outlier_probabilities
    np.testing.assert_allclose(
        local_outlier_probability(points, neighbors=k, extent=extent), np.asarray(theirs, dtype=float), rtol=0.0, atol=1e-9
    )


@pytest.fixture(scope="module")
def elki() -> tuple[Floats, NDArray[np.bool_]]:
    """The 960 points of ELKI's unit test of LoOP, and which of them are noise."""
    folder = os.environ.get("PYMESHFAIR_DATA")
    if not folder:
        pytest.skip("PYMESHFAIR_DATA does not name the folder that holds loop_elki_960x3.txt")
    lines = (Path(folder) / "loop_elki_960x3.txt").read_text().splitlines()
    rows = [line.split() for line in lines if line and not line.startswith("#")]
    return np.array([row[:3] for row in rows], dtype=float), np.array([row[3] == "Noise" for row in rows])


def test_elki_area_under_the_curve(elki: tuple[Floats, NDArray[np.bool_]]) -> None:
    """The probabilities rank ELKI's noise above its clusters as well as ELKI's do: AUC 0.94438, ties worth half a point."""
    points, noise = elki
    ranks = rankdata(local_outlier_probability(points, neighbors=14, extent=2.0))
    positives = np.count_nonzero(noise)
    area = (ranks[noise].sum() - positives * (positives + 1) / 2) / (positives * np.count_nonzero(~noise))
    assert area == pytest.approx(0.94438, abs=1e-4)


def test_elki_score(elki: tuple[Floats, NDArray[np.bool_]]) -> None:
    """Object 945, counted from 1, has the paper's value; ELKI's own differs, as ELKI clamps PLOF at 0 before it squares."""
    points, _ = elki
    assert local_outlier_probability(points, neighbors=14, extent=2.0)[944] == pytest.approx(0.39687877213960254, abs=1e-12)
    clamped = np.maximum(0.0, outlier_factors(points, neighbors=14))
    score = math.erf(clamped[944] / (2.0 * math.sqrt(np.mean(clamped**2)) * math.sqrt(2.0)))
    assert score == pytest.approx(0.39805457858293325, abs=1e-12)


def meshlab_series(x: Floats) -> Floats:
    """MeshLab's stand-in for erf: Abramowitz and Stegun 7.1.27 without its fourth power, 0 where that is negative."""
    return np.maximum(0.0, 1.0 - 1.0 / (1.0 + 0.278393 * x + 0.230389 * x**2 + 0.000972 * x**3 + 0.078108 * x**4))


def meshlab_scores(points: Floats, k: int) -> Floats:
    """MeshLab's LoOP: p is one of its own k neighbours, extent 1, and `meshlab_series` for erf."""
    distances, indices = nearest_neighbours(points, k - 1)
    sigma = np.sqrt((distances**2).sum(axis=1) / k)
    factors = sigma / ((sigma + sigma[indices].sum(axis=1)) / k) - 1.0
    return meshlab_series(factors / (np.sqrt(np.mean(factors**2)) * math.sqrt(2.0)))


@pytest.mark.parametrize(("k", "threshold"), [(32, 0.8), (16, 0.5), (8, 0.2)])
@pytest.mark.parametrize("sample", ["chameleon.pts", "bunny.obj"])
def test_meshlab_selection(sample: str, k: int, threshold: float) -> None:
    """With MeshLab's conventions the neighbours give MeshLab's selection exactly, on samples with 2 % of outliers added.

    MeshLab sums in single precision, so scores differ by up to 3e-6; none is that near to the threshold.
    """
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(SAMPLES / sample))
    surface = meshes.current_mesh().vertex_matrix()
    random = np.random.default_rng(42)
    low, high = surface.min(axis=0), surface.max(axis=0)
    points = np.concatenate([surface, random.uniform(low, high, (len(surface) // 50, 3))])
    meshes.add_mesh(pymeshlab.Mesh(points))
    meshes.compute_selection_point_cloud_outliers(knearest=k, propthreshold=threshold)
    scores = meshlab_scores(points, k)
    theirs = meshes.current_mesh().vertex_custom_scalar_attribute_array("outlierScore")
    np.testing.assert_allclose(scores, theirs, rtol=0.0, atol=3e-6)
    assert np.abs(scores - threshold).min() > 3e-6
    selected = meshes.current_mesh().vertex_selection_array()
    np.testing.assert_array_equal(scores > threshold, selected)
    assert 0 < np.count_nonzero(selected) < len(points) // 5


def test_meshlab_lacks_a_fourth_power() -> None:
    """At one deviation MeshLab's series gives 0.370 where erf gives 0.843; with the fourth power of the handbook it would be erf.

    Abramowitz and Stegun promise 5e-4 for x >= 0; below 0 MeshLab's series rises again, so that dense points get high scores.
    """
    x = np.linspace(0.0, 3.0, 301)
    handbook = 1.0 - (1.0 - meshlab_series(x)) ** 4
    assert np.abs(handbook - erf(x)).max() <= 5e-4
    assert meshlab_series(np.array(1.0)) == pytest.approx(0.370, abs=5e-4)
    assert math.erf(1.0) == pytest.approx(0.843, abs=5e-4)
    assert meshlab_series(np.array(-2.8)) == pytest.approx(0.853, abs=5e-4)


def test_finds_the_outliers() -> None:
    """Of 60 points strewn around a bumpy sphere those far from it are found, and few of the sphere's own 6,000."""
    points = cloud(6000, 60)
    far = np.abs(np.linalg.norm(points, axis=1) - 1.0) > 0.25
    selected = local_outlier_probability(points) > 0.5
    assert selected[far].mean() > 0.9
    assert selected[:6000].mean() < 0.01


def test_larger_extent_gives_smaller_probabilities() -> None:
    """The extent works in the direction that the documentation says, at every point with a probability above 0."""
    points = cloud(500, 20)
    narrow, wide = (local_outlier_probability(points, extent=extent) for extent in (1.0, 3.0))
    assert (wide[narrow > 0.0] < narrow[narrow > 0.0]).all()
    assert not wide[narrow == 0.0].any()


@pytest.mark.parametrize("unit", [1e-30, 1e-3, 1e3, 1e30])
def test_unit(unit: float) -> None:
    """The unit does not matter. Rounding the scaled coordinates changes distances by 1e-16, as in the test of the formula."""
    points = cloud(800, 20)
    np.testing.assert_allclose(local_outlier_probability(points * unit), local_outlier_probability(points), rtol=0.0, atol=1e-12)


def test_rotation_and_order() -> None:
    """Neither the orientation of the cloud nor the order of its points matters."""
    points = cloud(800, 20)
    expected = local_outlier_probability(points)
    rotation, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))
    np.testing.assert_allclose(local_outlier_probability(points @ rotation), expected, rtol=0.0, atol=1e-12)
    order = np.random.default_rng(1).permutation(len(points))
    np.testing.assert_allclose(local_outlier_probability(points[order]), expected[order], rtol=0.0, atol=1e-12)


def test_map_coordinates() -> None:
    """At the offset of map coordinates only the rounding of the input is felt.

    Coordinates of 5e6 are rounded by 5e-10; the shortest sigma is about 0.03, so PLOF moves by 1e-7 at the most.
    """
    points = cloud(800, 20)
    moved = points + np.array([448_262.0, 5_411_932.0, 121.0])
    np.testing.assert_allclose(local_outlier_probability(moved), local_outlier_probability(points), rtol=0.0, atol=1e-6)


def test_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """One thread and three threads give the same bits."""
    points = cloud(80_000, 100)
    monkeypatch.setattr(threads, "allowed_threads", lambda: 3)
    several = local_outlier_probability(points, neighbors=7)
    monkeypatch.setattr(threads, "allowed_threads", lambda: 1)
    one = local_outlier_probability(points, neighbors=7)
    np.testing.assert_array_equal(several, one)


def test_coincident_points() -> None:
    """Where a point and all its neighbours coincide the probability is 0, and nothing is NaN."""
    assert not local_outlier_probability(np.full((100, 3), 0.3), neighbors=5).any()
    random = np.random.default_rng(0)
    points = np.concatenate([np.zeros((50, 3)), np.full((7, 3), 0.5), random.random((200, 3))])
    probabilities = local_outlier_probability(points, neighbors=6)
    assert np.isfinite(probabilities).all()
    assert not probabilities[:57].any()


def test_a_point_beside_a_heap() -> None:
    """Beside a heap of coincident points the ratio is infinite: probability 1, and the others keep theirs."""
    others = cloud(400, 10) + 50.0
    heap = np.zeros((30, 3))
    with_point = local_outlier_probability(np.concatenate([others, heap, [[1e-3, 0.0, 0.0]]]), neighbors=10)
    without = local_outlier_probability(np.concatenate([others, heap]), neighbors=10)
    assert with_point[-1] == 1.0
    np.testing.assert_allclose(with_point[:-1], without, rtol=0.0, atol=1e-12)
    assert local_outlier_probability(np.concatenate([heap, [[1.0, 0.0, 0.0]]]), neighbors=10).tolist() == [0.0] * 30 + [1.0]


@pytest.mark.parametrize("offset", [0.0, 5e5])
def test_a_regular_arrangement_has_no_outliers(offset: float) -> None:
    """On evenly spaced points of a circle all distances are equal but for rounding, which is not taken for a difference."""
    angles = np.arange(100) * 2.0 * math.pi / 100
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(100)], axis=1) + offset
    assert not local_outlier_probability(circle, neighbors=4).any()


def test_distances_that_differ_beyond_all_measure() -> None:
    """A ratio of distances whose square no float64 holds gives probabilities all the same."""
    points = np.concatenate([np.random.default_rng(0).random((40, 3)) * 1e-160, [[1.0, 0.0, 0.0]]])
    probabilities = local_outlier_probability(points, neighbors=5)
    assert np.isfinite(probabilities).all()
    assert probabilities[-1] == pytest.approx(math.erf(math.sqrt(41.0) / (3.0 * math.sqrt(2.0))), abs=1e-6)


@pytest.mark.parametrize("extent", [0.0, -1.0, math.nan, math.inf])
def test_extent_out_of_bounds(extent: float) -> None:
    """An extent that is not a finite number above 0 is refused with its value."""
    with pytest.raises(FilterInputError, match=f"^extent is {extent}: it must be finite and above 0"):
        local_outlier_probability(cloud(50, 0), extent=extent)


def test_too_few_points() -> None:
    """A cloud without that many neighbours is refused with what is needed."""
    with pytest.raises(FilterInputError, match="20 neighbours need a cloud of at least 21 points, got 20"):
        local_outlier_probability(cloud(20, 0))


def test_points_that_are_not_finite() -> None:
    """NaN is refused with the number of points that have one and the first of them."""
    points = cloud(50, 0)
    points[[3, 4], 1] = np.nan
    with pytest.raises(FilterInputError, match=r"vertex 3 is \[.*\]: 2 of 50 vertices have a coordinate"):
        local_outlier_probability(points)


def test_progress_rises_to_one() -> None:
    """The progress never falls and ends at 1."""
    shares: list[float] = []
    local_outlier_probability(cloud(30_000, 0), progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
