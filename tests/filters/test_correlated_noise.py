"""Noise that neighbours share: found, measured, and what is chosen there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pymeshlab
import pytest
from denoising_cameras import SCENES, Camera, fused_map
from denoising_findings import chest
from denoising_metrics import measured
from denoising_pairs import along_an_axis, averaged, rounded, terrain
from drawn_scans import drawn
from scipy.ndimage import gaussian_filter
from suggestions import distance

from pymeshfair.filters.denoising import correlated_noise
from pymeshfair.filters.denoising.automatic import automatic_choice
from pymeshfair.filters.denoising.candidates import Repertoire
from pymeshfair.filters.denoising.correlated_noise import noise_field, on_lines_of_sight, setting_of_shared, shared_noise
from pymeshfair.filters.denoising.noise_level import estimate_noise, ring_means
from pymeshfair.filters.denoising.preparation import denoised
from pymeshfair.filters.denoising.rounding import Rounding, rounding_of
from pymeshfair.filters.denoising.scan import Scan
from pymeshfair.filters.diffusion.explicit import taubin_fairing
from pymeshfair.filters.evidence import Choice
from pymeshfair.filters.geometry import mean_edge_length, vertex_normals_by_area
from pymeshfair.filters.mesh import normalised_mesh
from pymeshfair.filters.topology import border_vertices, edges
from tests.meshes import Mesh, grid, icosphere, irregular_grid, noisy, renumbered, rotation, sample, torus, tube

FLAT, FACES = irregular_grid(80, 80)
UP = np.broadcast_to([0.0, 0.0, 1.0], FLAT.shape)
MEANS = ring_means(edges(FACES), len(FLAT))


def _scan(points: np.ndarray, faces: np.ndarray = FACES, normals: np.ndarray = UP) -> Scan:
    """With normals that are known."""
    scan = Scan(points, faces, rings=3)
    vars(scan)["normals"] = normals
    return scan


SCORED = _scan(FLAT).scored


def _shared(width: int, seed: int = 1) -> np.ndarray:
    """Heights with a variance of 1, smoothed over so many means of the ring, the vertex counting a third."""
    noise = np.random.default_rng(seed).normal(size=len(FLAT))
    for _ in range(width):
        noise = noise / 3.0 + 2.0 / 3.0 * (MEANS @ noise)
    return np.asarray(noise / noise[SCORED].std())


def _map(camera: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A hilly map of pixels, its truth and its faces: "light" has steps, "flight" blurred noise, "view" independent noise."""
    rng = np.random.default_rng(2)
    vertices, faces = grid(90, 90)
    x, y = vertices[:, 0], vertices[:, 1]
    blurred = gaussian_filter(rng.normal(size=(91, 91)), 1.2).ravel()
    blurred /= blurred.std()
    z, own = 4.0 * np.sin(x / 14.0) * np.cos(y / 17.0), rng.normal(size=len(x))
    found = {"light": 1.5 * np.round(z / 1.5 + 0.5 * blurred), "flight": z + 0.3 * blurred + 0.1 * own, "view": z + 0.3 * own}
    return np.column_stack([x, y, found[camera]]), np.column_stack([x, y, z]), faces


def _fused(level: float) -> tuple[np.ndarray, np.ndarray]:
    """A level set of hills in cells of 3 mm, with noise of several widths."""
    camera = Camera("fused", level=level, focal=3.0)
    vertices, _, faces = fused_map(SCENES["looked_at"]["hills"], camera, np.random.default_rng(0))
    return vertices, faces


def _found(vertices: np.ndarray, faces: np.ndarray) -> bool:
    return shared_noise(vertices, faces, estimate_noise(vertices, faces)) > 0.0


@pytest.mark.parametrize("width", [0, 2, 4])
def test_the_width_of_the_noise_that_was_put_in_is_found(width: int) -> None:
    """Four fifths and more of the variance are of that width, and the variance is right within a quarter."""
    variances, heights, _ = noise_field(_scan(FLAT + 0.3 * _shared(width)[:, None] * UP), (0, 2, 4), (1, 2, 4))
    assert variances[(0, 2, 4).index(width)] > 0.8 * variances.sum()
    assert variances.sum() == pytest.approx(0.09, rel=0.25)
    assert heights[SCORED].std() == pytest.approx(0.3, rel=0.15)


def test_half_of_the_noise_is_shared() -> None:
    """Of equal parts of two widths about a half is shared, and the other part is the noise of a vertex of its own."""
    noise = (0.2 * _shared(0) + 0.2 * _shared(2, seed=5))[:, None] * UP
    (own, shared), *_ = noise_field(_scan(FLAT + noise), (0, 2), (1, 4))
    assert shared / (own + shared) == pytest.approx(0.5, abs=0.15)
    assert np.sqrt(own) == pytest.approx(0.2, rel=0.15)


def test_no_noise_is_nothing() -> None:
    """Neither a plane nor a mesh of which no vertex counts has any."""
    for scan in (_scan(FLAT), Scan(FLAT, FACES, np.zeros_like(SCORED))):
        variances, heights, _ = noise_field(scan, (0, 2), (1, 4))
        assert not variances.any()
        assert not heights.any()


def test_the_noise_is_the_same_for_a_moved_and_renumbered_mesh() -> None:
    """Random numbers are made of the geometry."""
    points = FLAT + 0.3 * _shared(2)[:, None] * UP
    moved, faces, order = renumbered((points @ rotation().T + 5.0, FACES), seed=3)
    variances, heights, _ = noise_field(_scan(points), (0, 2), (1, 4))
    others, of_other, _ = noise_field(_scan(moved, faces, (UP @ rotation().T)[order]), (0, 2), (1, 4))
    np.testing.assert_allclose(others, variances, rtol=1e-6)
    np.testing.assert_allclose(of_other, heights[order], atol=1e-6)


def _with_shared(mesh: Mesh, level: float, times: int, calm: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Noise along the normals, averaged `times` over the rings, of so many mean edges; times `calm` where x is below 0."""
    vertices, faces = mesh
    moves = averaged(level, times)(vertices, faces, np.random.default_rng(4)) - vertices
    return vertices + moves * np.where(vertices[:, :1] < 0.0, calm, 1.0), faces


CHEST = chest(40)
SOLIDS = {"ball": icosphere(5), "ring": torus(160, 60), "chest": (CHEST.truth, CHEST.faces)}


@pytest.mark.parametrize("solid", SOLIDS)
@pytest.mark.parametrize("level", [0.15, 0.3])
def test_even_noise_that_neighbours_share_is_found_on_any_shape(solid: str, level: float) -> None:
    """Noise that is averaged twice over the rings is found, and its deviation within two fifths."""
    vertices, faces = _with_shared(SOLIDS[solid], level, 2)
    turned, other, _ = renumbered((vertices @ rotation().T + 5.0, faces), seed=2)
    for points, triangles in ((vertices, faces), (turned, other)):
        scaled = points / mean_edge_length(points, triangles)
        assert shared_noise(scaled, triangles, estimate_noise(points, triangles)) == pytest.approx(level, rel=0.4)


@pytest.mark.parametrize("solid", SOLIDS)
@pytest.mark.parametrize(
    ("level", "times", "calm"), [(0.0, 0, 1.0), (0.05, 0, 1.0), (0.3, 0, 1.0), (0.25, 2, 0.1), (0.3, 8, 1.0)]
)
def test_neither_a_surface_nor_independent_nor_uneven_nor_wide_noise_is_taken_for_it(
    solid: str, level: float, times: int, calm: float
) -> None:
    """Exact shapes, noise of each vertex by itself, a tenth of shared noise on one half, and noise as wide as details are not."""
    assert not _found(*_with_shared(SOLIDS[solid], level, times, calm))


@pytest.mark.parametrize("solid", SOLIDS)
@pytest.mark.parametrize(("length", "found"), [(4.0, True), (15.0, False)])
def test_among_slivers_no_shared_noise_is_looked_for(solid: str, length: float, found: bool) -> None:
    """Triangles of 1:4 show it; of 1:15 a ring of neighbours has no width, and what looks like such noise is left alone."""
    vertices, faces = SOLIDS[solid]
    assert _found(*_with_shared((vertices * [length, 1.0, 1.0], faces), 0.25, 2)) == found


@pytest.mark.parametrize(("level", "times"), [(0.25, 2), (0.1, 1)])
def test_shared_noise_on_a_solid_is_taken_away(level: float, times: int) -> None:
    """Half of the angle and more goes where held-out vertices, which their neighbours predict with their noise, leave it."""
    truth, faces = SOLIDS["ring"]
    vertices, _ = _with_shared((truth, faces), level, times)
    choice = automatic_choice(vertices, faces)
    assert choice.kind == "correlated"
    before, after = (measured(points, truth, faces)[0] for points in (vertices, choice.setting.apply(vertices, faces)))
    assert after < 0.5 * before


@pytest.mark.parametrize(("level", "kind"), [(0.2, "correlated"), (0.0, "clean")])
def test_weakly_shared_noise_on_a_part_is_taken_away(level: float, kind: str) -> None:
    """Averaged once over the rings, noise passes for surface with single vertices; a third of its angle is left, with balls."""
    truth, faces = SOLIDS["chest"]
    vertices, _ = _with_shared((truth, faces), level, 1)
    choice = automatic_choice(vertices, faces)
    assert choice.kind == kind
    before, after = (measured(points, truth, faces)[0] for points in (vertices, choice.setting.apply(vertices, faces)))
    assert after <= before / 3.0


def test_in_doubt_a_choice_that_does_not_halve_the_error_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chest is left to the other steps where the only setting tried is to do nothing."""
    vertices, faces = _with_shared(SOLIDS["chest"], 0.1, 1)
    mesh, noise = normalised_mesh(vertices, faces), estimate_noise(vertices, faces)
    assert setting_of_shared(mesh, noise, border="along") is not None
    monkeypatch.setattr(correlated_noise, "CORRELATED", Repertoire(taubin=(0,), relaxations=(), chains=()))
    assert setting_of_shared(mesh, noise, border="along") is None


def test_the_curvature_of_the_surface_is_not_counted_as_noise() -> None:
    """On waves noise of 0.2 edges is measured within a fifth if residuals as of wide noise are left out, and as more if not."""
    waves = 3.0 * np.sin(FLAT[:, :1] / 3.0) * np.cos(FLAT[:, 1:2] / 3.0) * UP
    scan = _scan(FLAT + waves + 0.2 * _shared(1)[:, None] * UP)
    alone, apart = (noise_field(scan, (0, 1), (1, 2, 4, 8, 16), 0.05, surface).variances.sum() ** 0.5 for surface in ((), (16,)))
    assert apart == pytest.approx(0.2, rel=0.2)
    assert alone > 1.5 * apart


def _by_risk(points: np.ndarray, noise: np.ndarray) -> Choice[int] | None:
    """The choice among doing nothing and two numbers of Taubin's steps."""
    return _scan(points).choose_by_risk(
        lambda start, _: [(taubin_fairing(start, FACES, iterations=k) if k else start for k in (0, 3, 10))], [[0, 3, 10]], noise
    )


def test_the_risk_is_the_error_and_the_variance_of_the_noise() -> None:
    """The expected squared error of the slopes is right within a tenth of the noise's, though neighbours share the noise."""
    true, noise = 0.5 * np.sin(FLAT[:, 0] / 8.0), 0.3 * _shared(2)
    points = FLAT + (true + noise)[:, None] * UP
    found = _by_risk(points, 0.3 * _shared(2, seed=9))
    assert found is not None
    pairs = FACES[SCORED[FACES].all(axis=1)][:, :2]

    def slopes(heights: np.ndarray) -> float:
        return float((np.diff(heights[pairs], axis=1) ** 2).mean())

    for trial in found.trials:
        result = taubin_fairing(points, FACES, iterations=trial.label) if trial.label else points
        assert trial.error**2 == pytest.approx(slopes(result[:, 2] - true) + slopes(noise), abs=0.1 * 2.0 * slopes(noise))
    assert found.chosen.label == 10


def test_without_noise_nothing_is_better_than_the_scan() -> None:
    """The least risk is that of doing nothing; of no vertices nothing is known."""
    found = _by_risk(FLAT + np.sin(FLAT[:, :1] / 2.0) * UP, np.zeros(len(FLAT)))
    assert found is not None
    assert found.chosen.label == 0
    assert Scan(FLAT, np.empty((0, 3), dtype=np.int32)).choose_by_risk(lambda p, h: [], []) is None


@pytest.mark.parametrize(("camera", "expected"), [("light", True), ("flight", True), ("view", False)])
def test_maps_of_cameras_are_told_by_their_noise(camera: str, expected: bool) -> None:
    """All are on lines of sight, turned or not, but only two share noise; the truth has none."""
    noisy, truth, faces = _map(camera)
    for vertices in (noisy, 7.0 * noisy @ rotation().T - 3.0):
        assert on_lines_of_sight(vertices, faces)
        assert (rounding_of(vertices, faces) is not None) == (camera == "light")
        assert _found(vertices, faces) is expected
    assert not _found(truth, faces)


def test_fused_maps_are_told_until_they_are_smoothed() -> None:
    """Cut-off corners and shared noise tell them; after three of MeshLab's Laplacian steps, or without noise, there is none."""
    vertices, faces = _fused(1.0)
    assert _found(vertices, faces)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.apply_coord_laplacian_smoothing(stepsmoothnum=3)
    assert not _found(meshes.current_mesh().vertex_matrix(), faces)
    assert not _found(*_fused(0.0))


def _bone() -> Mesh:
    """A closed surface with noise along one axis."""
    vertices, faces = sample("bone.ply")
    heights = 0.2 * mean_edge_length(vertices, faces) * np.random.default_rng(0).normal(size=len(vertices))
    assert on_lines_of_sight(vertices + np.outer(heights, [0.0, 0.0, 1.0]), faces)
    return vertices + np.outer(heights, [0.0, 0.0, 1.0]), faces


def _land() -> Mesh:
    """Waves of all sizes with independent noise."""
    vertices, faces = terrain()
    return along_an_axis(0.2)(vertices, faces, np.random.default_rng(1)), faces


@pytest.mark.parametrize("make", [_bone, _land, lambda: noisy(icosphere(4), 0.01)])
def test_rough_land_and_closed_shapes_are_no_maps(make: Callable[[], Mesh]) -> None:
    """The vertices of a bone are off along lines, but no camera sees it from all sides; land shares no noise."""
    assert not _found(*make())


@pytest.mark.slow
@pytest.mark.parametrize(("camera", "ratio"), [("light", 0.1), ("flight", 0.3)])
def test_what_is_chosen_leaves_little_of_the_noise_of_a_camera(camera: str, ratio: float) -> None:
    """Less than a tenth of the angle is left of rounded depths, less than a third of noise that is partly filtered."""
    noisy, truth, faces = _map(camera)
    told: list[float] = []
    found = automatic_choice(noisy, faces, border="along", progress=told.append)
    setting, evidence = found.setting, found.evidence
    assert found.kind == "correlated"
    assert evidence is not None
    assert evidence.chosen.label == setting
    assert setting.rounding == ("undo" if camera == "light" else "keep")
    assert told[-1] == 1.0
    result = setting.apply(noisy, faces, border="along", movable=None)
    assert measured(result, truth, faces)[0] < ratio * measured(noisy, truth, faces)[0]


def test_what_may_not_move_is_no_evidence() -> None:
    """Where no vertex may move nothing speaks for any setting."""
    noisy, _, faces = _map("flight")
    mesh = normalised_mesh(noisy, faces, np.zeros(len(noisy), dtype=np.bool_))
    assert setting_of_shared(mesh, estimate_noise(noisy, faces), border="along") is None


def _waves() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A bumpy sheet rounded along a slanting axis to steps of half an edge, its truth and its faces; its mean edge is 1."""
    truth, faces = grid(80, 80)
    truth[:, 2] = 6.0 * np.sin(truth[:, 0] / 13.0) * np.cos(truth[:, 1] / 17.0)
    truth /= mean_edge_length(truth, faces)
    return rounded(0.5)(truth, faces, np.random.default_rng(0)), truth, faces


def _rounding(vertices: np.ndarray, faces: np.ndarray) -> Rounding:
    found = rounding_of(vertices, faces)
    assert found is not None
    return found


def test_the_amount_of_shared_noise_is_seen() -> None:
    """Rounding to half an edge is noise of 0.5 / sqrt(12); a camera's map has as much as was put in, within a third."""
    vertices, _, faces = _waves()
    assert shared_noise(vertices, faces, estimate_noise(vertices, faces)) == pytest.approx(0.5 / 12**0.5, rel=0.1)
    noisy, truth, faces = _map("flight")
    added = np.einsum("ij,ij->i", noisy - truth, vertex_normals_by_area(truth, faces)).std()
    edge = mean_edge_length(noisy, faces)
    assert shared_noise(noisy / edge, faces, estimate_noise(noisy, faces)) == pytest.approx(added / edge, rel=0.35)


def test_the_axis_and_the_levels_of_rounding_are_found() -> None:
    """Along any axis, in any unit: the axis is right to a thousandth, all levels are multiples of the step."""
    vertices, truth, faces = _waves()
    found = _rounding(40.0 * vertices @ rotation().T, faces)
    axis = (vertices - truth)[0] @ rotation().T
    (direction,), (levels,) = found.directions, found.levels
    assert abs(direction @ axis) > (1.0 - 1e-6) * np.linalg.norm(axis)
    steps = np.diff(levels) / 20.0
    assert np.abs(steps - np.round(steps)).max() < 1e-3


def test_undoing_rounding_leaves_no_vertex_out_of_its_step_and_little_of_the_angle() -> None:
    """Every vertex is within half a step of where it was, along the axis alone, and less than a fifth of the angle is left.

    What may not move keeps every bit.
    """
    vertices, truth, faces = _waves()
    found = _rounding(vertices, faces)
    undone = found.undone(vertices, faces)
    moves = undone - vertices
    (direction,) = found.directions
    assert np.abs(moves @ direction).max() <= 0.25 + 1e-9
    assert np.abs(np.cross(moves, direction)).max() < 1e-9
    np.testing.assert_allclose(found.deviations(vertices), 0.5 / 12**0.5, rtol=1e-3)
    assert np.std((vertices - truth) @ direction) == pytest.approx(0.5 / 12**0.5, rel=0.03)
    assert measured(undone, truth, faces)[0] < 0.2 * measured(vertices, truth, faces)[0]
    movable = vertices[:, 0] > np.median(vertices[:, 0])
    part = found.undone(vertices, faces, movable)
    assert np.array_equal(part[~movable], vertices[~movable])
    assert not np.array_equal(part, vertices)


def test_steps_of_files_are_equal_and_those_of_disparity_are_not() -> None:
    """Levels of a file are multiples of one step, though some are missing; depths of whole disparities are not."""
    vertices, _, faces = _waves()
    assert _rounding(vertices, faces).equal_steps
    assert Rounding((UP[0],), (np.array([0.0, 1.0, 2.0, 5.0, 6.0, 9.0]),)).equal_steps
    assert not Rounding((UP[0],), (np.sort(100.0 / np.arange(20.0, 40.0)),)).equal_steps


def test_the_flattest_of_results_that_are_as_good_is_chosen() -> None:
    """Within one standard error of the least, or below the limit: squared errors of 1, of 1.005 with and without spread, of 2."""
    at = np.flatnonzero(SCORED).astype(np.int32)
    spread = np.random.default_rng(4).normal(size=len(at))
    one, two = np.ones(len(at)), np.full(len(at), 2.0)
    for near, limit, expected in ((0.005 + spread - spread.mean(), 0.0, "b"), (0.005, 0.0, "a"), (0.005, 1.5, "c")):
        found = _scan(FLAT).flattest(at, [one, one + near, two], [3.0, 2.0, 1.0], [["a", "b", "c"]], limit)
        assert found.chosen.label == expected
        assert [trial.error for trial in found.trials] == pytest.approx([1.0, 1.005**0.5, 2.0**0.5])


def test_a_rounded_relief_keeps_its_relief() -> None:
    """Bosses of two edges, rounded to 0.6 edges: more than half of the angle is gone. Least roughness would flatten them."""
    truth, faces = grid(40, 40)
    truth = truth.astype(float)
    truth[:, 2] = np.clip(3.0 * np.cos(np.pi * truth[:, 0] / 8.0) * np.cos(np.pi * truth[:, 1] / 8.0), -1.0, 1.0)
    scan = rounded(0.6)(truth, faces, np.random.default_rng(1))
    result = automatic_choice(scan, faces).setting.apply(scan, faces)
    assert measured(result, truth, faces)[0] < 0.5 * measured(scan, truth, faces)[0]


def test_edges_are_not_rounded_off_to_undo_small_steps() -> None:
    """A folded plane, rounded to 0.3 edges: filters that keep the rounding are chosen, and leave under a fifth of the angle."""
    truth, faces = irregular_grid(60, 60)
    truth[:, 2] = 0.7 * np.abs(truth[:, 0] % 20.0 - 10.0)
    truth /= mean_edge_length(truth, faces)
    scan = rounded(0.3)(truth, faces, np.random.default_rng(1))
    found = automatic_choice(scan, faces)
    assert rounding_of(scan, faces) is not None
    assert found.setting.rounding == "keep"
    assert measured(found.setting.apply(scan, faces), truth, faces)[0] < 0.2 * measured(scan, truth, faces)[0]


def test_coordinates_that_are_all_rounded_are_put_back_along_three_axes() -> None:
    """On a turned ball of 16 edges across: three axes at right angles, one step, and less than half of the distance is left."""
    truth, faces = icosphere(4)
    truth /= mean_edge_length(truth, faces)
    vertices = 0.4 * np.round(truth / 0.4)
    found = _rounding(vertices @ rotation().T, faces)
    axes = np.stack(found.directions) @ rotation()
    assert np.sort(np.abs(axes), axis=None)[-3:] == pytest.approx(1.0)
    assert [float(np.median(np.diff(levels))) for levels in found.levels] == pytest.approx([0.4] * 3)
    undone = found.undone(vertices @ rotation().T, faces) @ rotation()
    assert distance(undone, (truth, faces)) < 0.5 * distance(vertices, (truth, faces))


def test_a_fixed_border_keeps_its_rounding() -> None:
    """What is done to the rest leaves its bits."""
    vertices, _, faces = _waves()
    on_border = border_vertices(faces, len(vertices))
    found = denoised(vertices, faces, rounding="undo", border="fixed")
    assert np.array_equal(found[on_border], vertices[on_border])
    assert not np.array_equal(found, vertices)


def _stairs() -> Mesh:
    vertices, faces = grid(60, 60)
    vertices[:, 2] = np.floor(vertices[:, 0] / 5.0)
    return vertices, faces


@pytest.mark.parametrize("make", [_stairs, lambda: tube(41, 90, 7.0, 90.0), lambda: (FLAT, FACES), lambda: sample("bone.ply")])
def test_levels_of_designed_and_of_clean_shapes_are_no_rounding(make: Callable[[], Mesh]) -> None:
    """Treads of stairs, rings of a tube, a plane and a figure are as they were made."""
    assert rounding_of(*make()) is None


@pytest.mark.slow
def test_a_map_of_steep_things_is_not_rounded_off_beside_its_border() -> None:
    """Forty rounds move what is beside the border of a drawn view by more than its noise, 0.15 edges, and are not taken."""
    make, noise, level = drawn(5)["view, shared noise"]
    points, faces = make()
    scan = noise(0.7 * level)(points, faces, np.random.default_rng(2))
    result = automatic_choice(scan, faces).setting.apply(scan, faces)
    assert distance(result, (points, faces)) < 0.8 * distance(scan, (points, faces))
