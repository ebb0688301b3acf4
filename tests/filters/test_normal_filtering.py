"""Two-step denoising: against loops face by face, at fixed points, under motions, and against a published value."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from pymeshfair.filters import mesh as ordering
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.compilation import allowed_threads, set_threads
from pymeshfair.filters.denoising import (
    NormalFilter,
    NormalFilterMethod,
    RangeMeasure,
    filter_face_normals,
    normal_filtering,
    round_of_part,
)
from pymeshfair.filters.denoising.face_neighbourhoods import face_neighbourhoods
from pymeshfair.filters.denoising.normal_filter import Weighting, weighted_normals
from pymeshfair.filters.geometry import AREA, CENTRE, NORMAL, face_normals, mean_edge_length, measure_faces
from pymeshfair.filters.inspection import folded_faces
from pymeshfair.filters.mesh import normalised_mesh
from pymeshfair.filters.robust import KERNEL_NAMES, KernelName, weight
from pymeshfair.filters.topology import border_vertices, vertex_faces
from tests.angles import mean_angle
from tests.meshes import (
    AWKWARD,
    Floats,
    Ints,
    Mesh,
    cube,
    grid,
    icosphere,
    irregular_grid,
    noisy,
    renumbered,
    rotation,
    tube,
    wheel,
)

NOISY = noisy(icosphere(2), 0.04)
FIELDS = {field.name for field in fields(NormalFilter)}


# ------------------------------------------------------------------------------------------------------------ one pass, slowly


def around(faces: Ints, shared: int) -> list[list[int]]:
    """The faces that share that many vertices with each."""
    corners = [set(face.tolist()) for face in faces]
    return [[j for j, b in enumerate(corners) if len(a & b) >= shared and j != i] for i, a in enumerate(corners)]


def kernel(name: str, x: float, sigma: float) -> float:
    """The weight of a deviation; the Gaussian with its standard deviation."""
    if name == "gaussian":
        return float(np.exp(-(x**2) / (2 * sigma**2)))
    return float(weight(name, x, sigma))  # type: ignore[arg-type]


def deviation(n: Floats, m: Floats, measure: RangeMeasure) -> float:
    """How far a normal is from another."""
    length = float(np.linalg.norm(n - m))
    if measure == "angle":
        return float(np.arctan2(np.linalg.norm(np.cross(n, m)), n @ m))
    return length if measure == "euclidean" else length**2


def unit(v: Floats) -> Floats:
    """The vector over its length."""
    return np.asarray(v / np.linalg.norm(v))


def slow_guides(normals: Floats, areas: Floats, faces: Ints) -> Floats:
    """Zhang's guide normals by their definition."""
    near, beside = around(faces, 1), around(faces, 2)
    patches = [[i, *near[i]] for i in range(len(faces))]
    measures, means = [], []
    for patch in patches:
        largest = max(np.linalg.norm(normals[j] - normals[k]) for j in patch for k in patch)
        edges = {(min(j, k), max(j, k)) for j in patch for k in beside[j] if k in patch}
        bends = [np.linalg.norm(normals[j] - normals[k]) for j, k in sorted(edges)]
        measures.append(largest * max(bends) / (sum(bends) + 1e-9))
        means.append(unit((areas[patch, None] * normals[patch]).sum(axis=0)))
    return np.array([means[min(patch, key=lambda j: measures[j])] for patch in patches])


def slow_pass(
    mesh: Mesh,
    method: NormalFilterMethod,
    range_kernel: KernelName,
    space_kernel: str,
    measure: RangeMeasure,
    range_sigma: float,
    space_sigma: float,
    passes: int,
) -> Floats:
    """The filter by its definition, over the faces that share a vertex."""
    vertices, faces = mesh
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas, centres = np.linalg.norm(cross, axis=1) / 2, corners.mean(axis=1)
    normals = cross / (2 * areas[:, None])
    near, beside = around(faces, 1), around(faces, 2)
    mean = np.mean([np.linalg.norm(centres[i] - centres[j]) for i, row in enumerate(beside) for j in row])
    for _ in range(passes):
        guide = normals
        if method == "guided":
            guide = slow_guides(normals, areas, faces)
        elif method == "averaged":
            guide = np.array([unit((areas[[i, *row], None] * normals[[i, *row]]).sum(axis=0)) for i, row in enumerate(near)])
        result = np.empty_like(normals)
        for i, row in enumerate(near):
            total = np.zeros(3)
            for j in row if method in ("unilateral", "bilateral") else [i, *row]:
                w = areas[j]
                if method != "mean":
                    w *= kernel(range_kernel, deviation(guide[i], guide[j], measure), range_sigma)
                if method not in ("mean", "unilateral") and space_kernel != "constant":
                    w *= kernel(space_kernel, float(np.linalg.norm(centres[i] - centres[j])), space_sigma * float(mean))
                total += w * normals[j]
            result[i] = unit(total) if total.any() else normals[i]
        normals = result
    return np.asarray(normals)


@pytest.mark.parametrize("method", get_args(NormalFilterMethod))
def test_every_method_is_its_definition(method: NormalFilterMethod) -> None:
    """Two passes of each method equal the loops over faces above, to 1e-10."""
    mesh = noisy(icosphere(1), 0.08)
    fast = filter_face_normals(*mesh, method=method, normal_iterations=2)
    slow = slow_pass(mesh, method, "gaussian", "gaussian", "euclidean", 0.35, 1.0, 2)
    np.testing.assert_allclose(fast, slow, rtol=0, atol=1e-10)


@pytest.mark.parametrize("measure", get_args(RangeMeasure))
@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_every_kernel_and_measure_is_its_definition(name: KernelName, measure: RangeMeasure) -> None:
    """Each of the nine kernels, as range and as space kernel and with each measure, gives the mean of the loops to 1e-10."""
    fast = filter_face_normals(
        *NOISY,
        range_kernel=name,
        space_kernel=name,
        range_measure=measure,
        range_sigma=0.5,
        space_sigma=1.7,
        normal_iterations=1,
    )
    slow = slow_pass(NOISY, "bilateral", name, name, measure, 0.5, 1.7, 1)
    np.testing.assert_allclose(fast, slow, rtol=0, atol=1e-10)


def test_below_the_floor_all_deviations_weigh_the_same() -> None:
    """With a floor no deviation can exceed, every kernel is a filter of distance and area alone."""
    flat = filter_face_normals(*NOISY, range_kernel="l1", range_floor=2.0, normal_iterations=1)
    expected = filter_face_normals(*NOISY, range_kernel="l2", normal_iterations=1)
    np.testing.assert_allclose(flat, expected, rtol=0, atol=1e-12)


def test_outer_iterations_repeat_the_two_steps() -> None:
    """Three outer iterations are three calls of one, the normals measured anew each time."""
    vertices, faces = NOISY
    settings: dict[str, Any] = {"range_kernel": "tukey", "range_sigma": 1.2, "normal_iterations": 2, "vertex_iterations": 3}
    expected = vertices
    for _ in range(3):
        expected = normal_filtering(expected, faces, **settings)
    np.testing.assert_allclose(normal_filtering(vertices, faces, outer_iterations=3, **settings), expected, rtol=0, atol=1e-12)


# ------------------------------------------------------------------------------------------------------------------ fixed points

INTERLEAVED: dict[str, Any] = {"neighborhood": "two_ring", "normal_iterations": 1, "outer_iterations": 20, "vertex_iterations": 5}
EVERY_METHOD: list[dict[str, Any]] = [
    *({"method": method} for method in get_args(NormalFilterMethod)),
    {"range_kernel": "truncated_l1", "range_sigma": 1.0, "space_sigma": 2.5, **INTERLEAVED},
    {"vertex_update": "ohtake"},
    {"vertex_update": "conjugate_gradient"},
    {"method": "guided", "neighborhood": "radius"},
    {"neighborhood": "geodesic"},
]


@pytest.mark.parametrize("settings", EVERY_METHOD)
def test_a_plane_is_a_fixed_point(settings: dict[str, Any]) -> None:
    """Faces of one normal keep it, so no vertex of a plane moves, however uneven its triangles are."""
    vertices, faces = irregular_grid()
    vertices = vertices @ rotation().T
    np.testing.assert_allclose(normal_filtering(vertices, faces, **settings), vertices, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("name", "sigma"), [("truncated_l1", 1.0), ("truncated_l2", 1.0), ("tukey", 1.2)])
def test_a_cube_stays_a_cube(name: KernelName, sigma: float) -> None:
    """Kernels that reach 0 before the deviation of a right angle, sqrt 2, keep a cube exactly."""
    vertices, faces = cube(3)
    after = normal_filtering(vertices, faces, range_kernel=name, range_sigma=sigma, space_sigma=2.5, **INTERLEAVED)
    np.testing.assert_allclose(after, vertices, rtol=0, atol=1e-12)


# ----------------------------------------------------------------------------------------------------------------- invariance


@pytest.mark.parametrize("settings", EVERY_METHOD)
def test_it_follows_rotation_scale_place_and_numbering(settings: dict[str, Any]) -> None:
    """Turned, magnified, shifted and renumbered meshes give the same surface to 1e-9."""
    vertices, faces = NOISY
    plain = normal_filtering(vertices, faces, **settings)
    turn = rotation(3)
    moved = normal_filtering(7.0 * vertices @ turn.T + 3.0, faces, **settings)
    np.testing.assert_allclose((moved - 3.0) @ turn / 7.0, plain, rtol=0, atol=1e-9)
    mixed, mixed_faces, order = renumbered(NOISY)
    np.testing.assert_allclose(normal_filtering(mixed, mixed_faces, **settings), plain[order], rtol=0, atol=1e-9)


def test_the_size_of_the_unit_makes_no_difference() -> None:
    """A power of two as scale, up to the ends of what floats hold, changes no digit."""
    vertices, faces = NOISY
    plain = normal_filtering(vertices, faces)
    for power in (-100, 100):
        np.testing.assert_array_equal(normal_filtering(np.ldexp(vertices, power), faces), np.ldexp(plain, power))


@pytest.mark.parametrize("settings", EVERY_METHOD)
def test_threads_make_no_difference(settings: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """One thread and two give the same bytes."""
    monkeypatch.setattr("pymeshfair.filters.execution.SERIAL_BELOW", 0)
    before = allowed_threads()
    results = []
    try:
        for threads in (1, min(2, before)):
            set_threads(threads)
            results.append(normal_filtering(*NOISY, **settings).tobytes())
    finally:
        set_threads(before)
    assert results[0] == results[1]


# Conjugate gradients take sums over all vertices.
LOCAL = [s for s in EVERY_METHOD if "conjugate_gradient" not in s.values()]


@pytest.mark.parametrize("settings", LOCAL)
def test_an_order_of_space_makes_no_difference_to_the_bits(settings: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Vertices and face normals of a mesh in random order, with borders, are the same where it is put into order inside."""
    vertices, faces, _ = renumbered(noisy(tube(20, 15), 0.02))
    faces = np.random.default_rng(0).permutation(faces)
    results = []
    for fits_in_cache in (10**9, 0):
        monkeypatch.setattr(ordering, "FITS_IN_CACHE", fits_in_cache)
        monkeypatch.setattr(ordering, "NEAR", 0)
        monkeypatch.setattr(ordering, "_SWEEPS_A_REORDERING_COSTS", 1)
        normals = {name: value for name, value in settings.items() if name in FIELDS}
        results.append(
            (normal_filtering(vertices, faces, **settings).tobytes(), filter_face_normals(vertices, faces, **normals).tobytes())
        )
    assert results[0] == results[1]


def test_no_round_folds_a_face_over() -> None:
    """The faces that look away from the normals at their corners after a round did so before it: slivers do not turn over."""
    vertices, faces = irregular_grid(24, 24)
    vertices[:, 2] = -np.abs(vertices[:, 0] - vertices[:, 0].mean())
    vertices += np.random.default_rng(1).normal(0.0, 0.2, vertices.shape)
    before = folded_faces(vertices, faces)
    for rounds in range(1, 9):
        result = normal_filtering(
            vertices, faces, range_kernel="truncated_l1", range_sigma=0.5, normal_iterations=1, outer_iterations=rounds
        )
        after = folded_faces(result, faces)
        assert not (after & ~before).any()
        before = after


def test_a_round_depends_on_nothing_but_the_points_before_it() -> None:
    """Rounds one by one give the bits of all in one run, also where the corners of folded faces move back in every test."""
    vertices, faces = noisy(icosphere(4), 0.8 * mean_edge_length(*icosphere(4)))
    settings: dict[str, Any] = {"range_kernel": "truncated_l1", "range_sigma": 0.5, "space_kernel": "constant"}
    steps: dict[str, Any] = {"vertex_iterations": 10, "vertex_update": "sun", "border": "along"}
    mesh = normalised_mesh(vertices, faces)
    points = mesh.points
    for count in range(1, 5):
        points = round_of_part(points, faces, NormalFilter(**settings), distance=0.0, **steps)
        whole = normal_filtering(vertices, faces, **settings, **steps, outer_iterations=count)
        assert mesh.restored(points).tobytes() == whole.tobytes()


# ------------------------------------------------------------------------------------------------------- what may move, and how


def test_vertices_that_may_not_move_keep_every_bit() -> None:
    """Those that no face uses, those not movable and fixed borders; -0.0 stays -0.0."""
    vertices, faces = noisy(tube(), 0.05)
    vertices = np.concatenate([vertices, [[-0.0, 7.0, 50.0]]])
    movable = np.arange(len(vertices)) % 3 > 0
    after = normal_filtering(vertices, faces, border="fixed", movable=movable)
    stays = ~movable | border_vertices(faces, len(vertices))
    stays[-1] = True
    assert after[stays].tobytes() == vertices[stays].tobytes()
    assert (after[~stays] != vertices[~stays]).any(axis=1).all()


@pytest.mark.parametrize("distance", [1e9, 1e16])
@pytest.mark.parametrize("settings", EVERY_METHOD)
def test_a_far_vertex_that_no_face_uses_changes_no_bit(settings: dict[str, Any], distance: float) -> None:
    """Vertices, face normals and folds are those of the mesh without the vertex, before or behind the others, bit by bit."""
    vertices, faces = NOISY
    far = [[distance, 0.0, 0.0]]
    behind, before = (np.concatenate([vertices, far]), faces), (np.concatenate([far, vertices]), faces + 1)
    alone = normal_filtering(vertices, faces, **settings)
    assert normal_filtering(*behind, **settings)[:-1].tobytes() == alone.tobytes()
    assert normal_filtering(*before, **settings)[1:].tobytes() == alone.tobytes()
    steps: Any = {f.name: settings[f.name] for f in fields(NormalFilter) if f.name in settings}
    assert filter_face_normals(*before, **steps).tobytes() == filter_face_normals(vertices, faces, **steps).tobytes()
    assert np.array_equal(folded_faces(*behind), folded_faces(vertices, faces))


def test_a_face_without_area_of_its_own_vertices_has_no_normal() -> None:
    """Its row is 0, and the rows of all others are those of the mesh without it."""
    vertices, faces = NOISY
    more = np.concatenate([vertices, [[3.0, 3.0, 3.0]]])
    found = filter_face_normals(more, np.insert(faces, 5, len(vertices), axis=0))
    assert (found[5] == 0.0).all()
    assert np.delete(found, 5, axis=0).tobytes() == filter_face_normals(vertices, faces).tobytes()


def test_a_border_along_keeps_its_outline() -> None:
    """A sheet with noise across it alone keeps the outline of its border seen from above, and the border becomes smooth too."""
    vertices, faces = grid(20, 20)
    rough = vertices + np.random.default_rng(0).normal(0, 0.1, len(vertices))[:, None] * [0, 0, 1]
    after = normal_filtering(rough, faces, range_sigma=0.6, outer_iterations=3)
    on_border = border_vertices(faces, len(vertices))
    assert np.abs(after[on_border, :2] - vertices[on_border, :2]).max() < 0.1
    assert after[on_border, 2].std() < 0.8 * rough[on_border, 2].std()


def test_noise_goes_and_edges_stay() -> None:
    """A cube with noise of 0.15 edges: the angles to the true normals fall to less than a tenth, and no face is folded."""
    vertices, faces = cube(4)
    rough, _ = noisy((vertices, faces), 0.15 / 16)
    after = normal_filtering(rough, faces, range_kernel="truncated_l1", range_sigma=1.0, space_sigma=2.5, **INTERLEAVED)
    true = face_normals(vertices, faces)
    assert mean_angle(face_normals(after, faces), true) < 0.1 * mean_angle(face_normals(rough, faces), true)
    assert not folded_faces(after, faces).any()


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_come_out_finite(name: str) -> None:
    """No mesh, however broken, comes out with a coordinate that is not finite."""
    vertices, faces = AWKWARD[name]()
    for settings in EVERY_METHOD:
        after = normal_filtering(vertices, faces, **settings)
        assert after.shape == vertices.shape
        assert np.isfinite(after).all()
    assert np.isfinite(filter_face_normals(vertices, faces)).all()
    assert len(folded_faces(vertices, faces)) == len(faces)


def test_no_iterations_change_nothing() -> None:
    """With no outer iteration, or with no step of the vertices, every bit stays."""
    nothings: list[dict[str, Any]] = [{"outer_iterations": 0}, {"vertex_iterations": 0}]
    for settings in nothings:
        assert normal_filtering(*NOISY, **settings).tobytes() == NOISY[0].tobytes()


def test_the_keywords_are_the_settings() -> None:
    """Functions take each attribute of the settings by name, and refuse other names."""
    settings = NormalFilter(method="unilateral", range_kernel="huber", normal_iterations=3)
    named = filter_face_normals(*NOISY, method="unilateral", range_kernel="huber", normal_iterations=3)
    assert filter_face_normals(*NOISY, **asdict(settings)).tobytes() == named.tobytes()
    with pytest.raises(TypeError, match="unexpected keyword argument 'range_sigmas'"):
        filter_face_normals(*NOISY, range_sigmas=0.3)


def test_progress_runs_from_0_to_1() -> None:
    """It rises, ends at 1, and an exception that it raises stops the work."""
    told: list[float] = []
    normal_filtering(*NOISY, normal_iterations=2, outer_iterations=3, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0

    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        normal_filtering(*NOISY, progress=stop)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"method": "trilateral"}, "method 'trilateral' is not one of"),
        ({"range_kernel": "constant"}, "range_kernel 'constant' is not one of"),
        ({"space_kernel": "cosine"}, "space_kernel 'cosine' is not one of 'constant'"),
        ({"range_measure": "cosine"}, "range_measure 'cosine' is not one of"),
        ({"neighborhood": "all"}, "neighborhood 'all' is not one of"),
        ({"vertex_update": "newton"}, "vertex_update 'newton' is not one of"),
        ({"border": "open"}, "border 'open' is not one of"),
        ({"range_sigma": 0.0}, "range_sigma is 0.0: it must be finite and above 0"),
        ({"space_sigma": float("nan")}, "space_sigma is nan: it must be finite and above 0"),
        ({"range_floor": -0.1}, "range_floor is -0.1: it must be finite and at least 0"),
        ({"normal_iterations": -1}, "normal_iterations is -1"),
        ({"outer_iterations": 1.5}, "outer_iterations is 1.5"),
        ({"movable": np.ones(3, dtype=np.bool_)}, "movable must be a boolean array of 162 values"),
    ],
)
def test_values_out_of_range_are_refused(settings: dict[str, Any], message: str) -> None:
    """The message names the parameter, the value and what is allowed."""
    with pytest.raises(FilterInputError, match=message):
        normal_filtering(*NOISY, **settings)


# -------------------------------------------------------------------------------------------------------------- published values


@pytest.fixture(scope="module")
def pair() -> Callable[[str], tuple[Floats, Floats, Ints]]:
    """Loads the noisy vertices, the true vertices and the faces of a pair."""
    folder = Path(os.environ.get("PYMESHFAIR_DATA", "")) / "denoising"
    if "PYMESHFAIR_DATA" not in os.environ or not folder.is_dir():
        pytest.skip("PYMESHFAIR_DATA names no folder with denoising/")

    def load(name: str) -> tuple[Floats, Floats, Ints]:
        import pymeshlab

        meshes = pymeshlab.MeshSet()
        for kind in ("noisy", "truth"):
            meshes.load_new_mesh(str(folder / f"{name}_{kind}.ply"))
        rough, true = meshes.mesh(0), meshes.mesh(1)
        return rough.vertex_matrix(), true.vertex_matrix(), np.asarray(rough.face_matrix(), dtype=np.int32)

    return load


def test_the_authors_defaults_give_the_published_error(pair: Callable[[str], tuple[Floats, Floats, Ints]]) -> None:
    """Zheng's filter with the parameters of its authors' code leaves 3.49 degrees on Fandisk with noise of 0.3 edges."""
    rough, true, faces = pair("fandisk_n3")
    after = normal_filtering(rough, faces, border="fixed")
    assert mean_angle(face_normals(after, faces), face_normals(true, faces)) == pytest.approx(3.49, abs=0.02)


@pytest.mark.parametrize(
    ("name", "kernel_of_range", "sigma", "floor", "space_sigma", "steps", "most"),
    [
        ("fandisk_n3", "truncated_l1", 1.0, 0.03, 2.5, 2, 1.92),
        ("block_n4", "truncated_l1", 1.0, 0.06, 2.5, 3, 2.88),
        ("twelve_i5", "lorentzian", 0.06, 0.0, 2.0, 2, 1.96),
    ],
)
def test_many_short_rounds_keep_edges(
    pair: Callable[[str], tuple[Floats, Floats, Ints]],
    name: str,
    kernel_of_range: KernelName,
    sigma: float,
    floor: float,
    space_sigma: float,
    steps: int,
    most: float,
) -> None:
    """60 outer iterations of one pass and a few steps leave about half the error of the published filters on machine parts."""
    rough, true, faces = pair(name)
    after = normal_filtering(
        rough,
        faces,
        range_kernel=kernel_of_range,
        range_sigma=sigma,
        range_floor=floor,
        space_sigma=space_sigma,
        neighborhood="two_ring",
        normal_iterations=1,
        vertex_iterations=steps,
        outer_iterations=60,
    )
    assert mean_angle(face_normals(after, faces), face_normals(true, faces)) <= most


@pytest.mark.parametrize(("range_sigma", "space_sigma"), [(0.35, 0.2), (1e-200, 0.2), (0.35, 1e-200)])
def test_two_gaussians_are_the_exponential_of_both(range_sigma: float, space_sigma: float) -> None:
    """Also around a vertex of 90 faces, and where all weights are 0 and the normals stay."""
    vertices, faces = wheel(90)
    vertices = vertices + 0.1 * np.random.default_rng(2).normal(size=vertices.shape)
    table = measure_faces(vertices, faces)
    around = face_neighbourhoods(faces, vertex_faces(faces, len(vertices)), "vertex")
    normals = np.ascontiguousarray(table[:, NORMAL])
    expected = normals.copy()
    for i in range(len(faces)):
        near = around.neighbours[around.offsets[i] : around.offsets[i + 1]]
        distances = np.linalg.norm(table[near, CENTRE] - table[i, CENTRE], axis=1)
        deviations = np.linalg.norm(normals[near] - normals[i], axis=1)
        with np.errstate(over="ignore"):
            weights = table[near, AREA] * np.exp(-0.5 * ((distances / space_sigma) ** 2 + (deviations / range_sigma) ** 2))
        if weights.any():
            expected[i] = weights @ normals[near] / np.linalg.norm(weights @ normals[near])
    found = weighted_normals(normals, table, around, Weighting.of(NormalFilter(range_sigma=range_sigma), space_sigma))
    # Sums of 90 terms are off by as many roundings at most.
    np.testing.assert_allclose(found, expected, rtol=0, atol=90 * 2.0**-52)


def test_faces_that_are_there_both_ways_round_count_as_folded_nowhere() -> None:
    """The normals around them cancel out, and what is left are rounding errors, which would put corners back by chance."""
    vertices, faces = noisy(icosphere(3), 0.01)
    both = np.concatenate([faces, faces[:, ::-1]])
    for turn in (np.eye(3), rotation(3)):
        assert not folded_faces(vertices @ turn.T, both).any()
    found = normal_filtering(vertices, both, outer_iterations=3)
    turned = normal_filtering(vertices @ rotation(3).T, both, outer_iterations=3)
    np.testing.assert_allclose(turned @ rotation(3), found, rtol=0, atol=1e-12)
