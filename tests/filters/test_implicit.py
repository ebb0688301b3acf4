"""Implicit fairing against closed forms, dense and independent solutions, and its own symmetries."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.diffusion.explicit import explicit_smoothing
from pymeshfair.filters.diffusion.implicit import (
    BackwardEulerStep,
    Flow,
    ImplicitOperator,
    implicit_fairing,
    time_step_of_detail_size,
)
from pymeshfair.filters.execution import ignore_progress
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.operators import Laplacian, OperatorName, build_laplacian, curve_laplacian
from pymeshfair.filters.topology import BorderPolicy, border_edges, border_vertices, referenced_vertices
from tests.meshes import (
    AWKWARD,
    Floats,
    Mesh,
    area,
    diagonal,
    grid,
    icosphere,
    irregular_grid,
    noisy,
    renumbered,
    rotation,
    sample,
    single_triangle,
    subdivided,
    torus,
    tube,
    two_spheres,
    volume,
    with_caps,
)

OPERATORS: tuple[ImplicitOperator, ...] = ("uniform", "inverse_length", "scale_dependent", "cotangent", "robust")
FLOWS: tuple[Flow, ...] = ("linear", "mean_curvature", "conformalized")
BORDERS: tuple[BorderPolicy, ...] = ("along", "free")
#: what the solver leaves: 1e-10 of the diagonal on average, more at vertices with little mass
SOLVED = 1e-9


def surface_operator(operator: ImplicitOperator) -> OperatorName:
    """The name by which `build_laplacian` knows it."""
    return "laplace_beltrami" if operator == "cotangent" else operator


def unit_of_time(mesh: Mesh, operator: ImplicitOperator) -> float:
    """One squared mean edge, or 1 for operators without unit."""
    return 1.0 if operator in ("uniform", "inverse_length") else mean_edge_length(*mesh) ** 2


def dumbbell(thickness: float = 0.15) -> Mesh:
    """A sphere of 2,562 vertices stretched to two balls on a bar of that thickness."""
    vertices, faces = icosphere(4)
    x = vertices[:, 0]
    waist = thickness + (1 - thickness) * np.clip(np.abs(x) / 0.6, 0, 1) ** 2
    return vertices * np.column_stack([np.full(len(x), 2.0), waist, waist]), faces


# ------------------------------------------------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("iterations", [1, 2, 5])
@pytest.mark.parametrize("wave", [6, 12, 40])
def test_a_wave_of_the_detail_size_is_halved(wave: int, iterations: int) -> None:
    """A sine wave of `wave` edges a period on a flat strip comes out with the amplitude that the five-point Laplacian predicts.

    That differs from one half by the discretisation: the operator's eigenvalue is omega^2 (1 - (omega h)^2 / 12 + ...).
    """
    vertices, faces = grid(rows=4, columns=wave)
    omega = 2 * math.pi / wave
    height = 1e-6 * np.sin(omega * vertices[:, 0])
    vertices[:, 2] = height
    inside = (vertices[:, 0] > 0) & (vertices[:, 0] < wave)
    t = time_step_of_detail_size(wave, iterations)
    smooth = implicit_fairing(vertices, faces, time_step=t, iterations=iterations, border="free", movable=inside)
    amplitude = float(smooth[:, 2] @ height / (height @ height))
    eigenvalue = 2 - 2 * math.cos(omega)
    assert amplitude == pytest.approx((1 + t * eigenvalue) ** -iterations, abs=1e-7)
    # d(amplitude)/amplitude = -n t d(eigenvalue) / (1 + t eigenvalue), at most ln 2 times the relative change, (omega h)^2 / 12.
    assert abs(amplitude - 0.5) <= 0.5 * math.log(2) * omega**2 / 12 * 1.05
    assert np.abs(smooth[:, 2] - amplitude * height).max() < 1e-7 * 1e-6


def test_the_wave_of_the_detail_size_by_the_robust_operator() -> None:
    """The robust operator halves the same wave within one per cent on an irregular grid of 20 edges a period."""
    wave = 20
    vertices, faces = irregular_grid(rows=6, columns=wave, amount=0.2)
    height = 1e-4 * np.sin(2 * math.pi / wave * vertices[:, 0])
    vertices[:, 2] = height
    inside = (vertices[:, 0] > 0) & (vertices[:, 0] < wave)
    t = time_step_of_detail_size(wave)
    smooth = implicit_fairing(vertices, faces, operator="robust", time_step=t, border="free", movable=inside)
    assert smooth[:, 2] @ height / (height @ height) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("t", [0.01, 0.1, 10.0])
def test_a_sphere_shrinks_as_its_curvature_says(t: float) -> None:
    """A step takes a sphere of radius r to r / (1 + 2 t / r^2), and the error falls to a quarter as edges are halved."""
    errors = []
    for subdivisions in (3, 4):
        vertices, faces = icosphere(subdivisions, radius=3.0)
        radius = np.linalg.norm(implicit_fairing(vertices, faces, time_step=9 * t), axis=1)
        errors.append(np.abs(radius * (1 + 2 * t) / 3.0 - 1).max())
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 2.5


def test_mean_curvature_flow_of_a_sphere() -> None:
    """Under mean curvature flow r^2 = r0^2 - 4 t; halving the steps halves the error, as backward Euler's is of first order."""
    vertices, faces = icosphere(3)
    errors = []
    for steps in (10, 20, 40):
        smooth = implicit_fairing(vertices, faces, time_step=0.1 / steps, iterations=steps, flow="mean_curvature")
        errors.append(np.linalg.norm(smooth, axis=1).mean() - math.sqrt(1 - 4 * 0.1))
    assert errors[2] < 0.01
    assert errors[0] / errors[1] == pytest.approx(2, abs=0.15)
    assert errors[1] / errors[2] == pytest.approx(2, abs=0.15)


def test_a_tube_with_fixed_borders_tends_to_the_catenoid() -> None:
    """Fixed borders hold the surface: one long step gives L p = 0 for the input's weights, the flow the surface of least area."""
    vertices, faces = noisy(tube(around=24, along=12, radius=1.0, length=1.0), 0.01)
    smooth = implicit_fairing(vertices, faces, time_step=1e9, border="fixed")
    stiffness = build_laplacian(vertices, faces, "laplace_beltrami").stiffness
    border = border_vertices(faces, len(vertices))
    assert np.abs((stiffness @ smooth)[~border]).max() < 1e-8
    again = implicit_fairing(vertices, faces, time_step=0.01, iterations=60, flow="mean_curvature", border="fixed")
    waist = np.linalg.norm(again[np.abs(again[:, 2] - 0.5) < 0.01][:, :2], axis=1)
    # r = a cosh(z / a) with r = 1 at z = 1/2 has a = 0.8483. Chords of 24 edges replace the circles: 1 - cos(pi / 24) = 0.9 %.
    assert waist.mean() == pytest.approx(0.8483, rel=0.015)


# --------------------------------------------------------------------------------------------------- against other solutions


@pytest.mark.parametrize("border", ["fixed", "along", "free"])
@pytest.mark.parametrize("operator", OPERATORS)
def test_equals_a_dense_solution(operator: ImplicitOperator, border: BorderPolicy) -> None:
    """On an open mesh with held vertices the step solves the coupled system, written out row by row and solved densely."""
    mesh = noisy(irregular_grid(7, 8, amount=0.3), 0.1)
    vertices, faces = mesh
    n = len(vertices)
    movable = np.ones(n, dtype=bool)
    movable[[0, 3, 30, 31]] = False
    t = 2.0 * unit_of_time(mesh, operator)

    surface = build_laplacian(vertices, faces, surface_operator(operator))
    curve = curve_laplacian(vertices, border_edges(faces), surface_operator(operator))
    on_border = border_vertices(faces, n)
    rows = np.eye(n) - t * surface.matrix().toarray()
    if border == "along":
        rows[on_border] = (np.eye(n) - t * curve.matrix().toarray())[on_border]
    held = ~movable | (on_border if border == "fixed" else False)
    rows[held] = np.eye(n)[held]
    expected = np.linalg.solve(rows, vertices)

    smooth = implicit_fairing(vertices, faces, operator=operator, time_step=t, border=border, movable=movable)
    assert np.abs(smooth - expected).max() < SOLVED * diagonal(vertices)
    assert np.array_equal(smooth[held], vertices[held])
    assert np.abs(smooth - vertices)[~held].max() > 0.01


@pytest.mark.parametrize("edges", [0.5, 3.0, 40.0])
def test_equals_libigl(edges: float) -> None:
    """On MeshLab's cow, 16 % of whose weights are negative, the step equals a direct solution with libigl's matrices."""
    igl = pytest.importorskip("igl")
    vertices, faces = sample("cow.obj")
    t = (edges * mean_edge_length(vertices, faces)) ** 2
    mass = igl.massmatrix(vertices, faces, igl.MASSMATRIX_TYPE_VORONOI)
    matrix = sparse.csc_matrix(mass - t * igl.cotmatrix(vertices, faces))
    expected = spsolve(matrix, mass @ vertices)
    smooth = implicit_fairing(vertices, faces, time_step=t, border="free")
    assert np.abs(smooth - expected).max() < SOLVED * diagonal(vertices)


def test_one_step_of_ten_smooths_like_ten_explicit_steps_of_one() -> None:
    """Both reduce every mode as their transfer functions say, 1 / (1 + 10 k) and (1 - k)^10, and leave as much noise.

    All 642 modes of the uniform operator are compared. The functions agree where 10 k is small; then the explicit one falls off
    faster, so the implicit step also leaves less of the long waves, and of white noise about the same.
    """
    vertices, faces = icosphere(3)
    noise = np.random.default_rng(0).normal(0.0, 0.02, vertices.shape)
    laplacian = build_laplacian(vertices, faces, "uniform")
    root = np.sqrt(laplacian.mass)[:, None]
    values, modes = np.linalg.eigh(-laplacian.stiffness.toarray() / root / root.T)

    def spectrum(points: Floats) -> Floats:
        return np.asarray(modes.T @ (root * points))

    implicit = spectrum(implicit_fairing(vertices + noise, faces, operator="uniform", time_step=10.0))
    explicit = spectrum(explicit_smoothing(vertices + noise, faces, operator="uniform", step=1.0, iterations=10))
    by_implicit, by_explicit = 1 / (1 + 10 * values), (1 - values) ** 10
    assert np.abs(implicit - by_implicit[:, None] * spectrum(vertices + noise)).max() < 1e-8
    assert np.abs(explicit - by_explicit[:, None] * spectrum(vertices + noise)).max() < 1e-12
    low = 10 * values < 0.6
    assert low.sum() >= 9
    # 1 / (1 + x) - exp(-x) = x^2 / 2 - ..., and (1 - k)^10 is below exp(-10 k) by about 5 k^2.
    assert (np.abs(by_implicit - by_explicit)[low] <= 0.55 * (10 * values[low]) ** 2 + 1e-12).all()
    left = [np.linalg.norm(transfer[:, None] * spectrum(noise)) for transfer in (by_implicit, by_explicit)]
    assert left[0] < 0.25 * np.linalg.norm(spectrum(noise))
    assert left[1] / 1.5 < left[0] < 1.5 * left[1]


@pytest.mark.parametrize("operator", OPERATORS)
def test_agrees_with_an_explicit_step_to_first_order(operator: ImplicitOperator) -> None:
    """An explicit and an implicit step differ by t^2 L^2 p, so halving the step quarters the difference."""
    vertices, faces = noisy(icosphere(2), 0.02)
    t = 1e-3 * unit_of_time((vertices, faces), operator)
    differences = []
    for step in (t, t / 2):
        implicit = implicit_fairing(vertices, faces, operator=operator, time_step=step)
        laplacian = build_laplacian(vertices, faces, surface_operator(operator))
        differences.append(np.linalg.norm(implicit - (vertices + step * laplacian.apply(vertices))))
    assert differences[0] / differences[1] == pytest.approx(4, rel=0.02)


def test_the_linear_flow_repeats_one_system() -> None:
    """Several linear steps are powers of one matrix; those of the mean curvature flow start anew each time."""
    vertices, faces = noisy(icosphere(2), 0.03)
    laplacian = build_laplacian(vertices, faces, "laplace_beltrami")
    step = np.linalg.inv(np.eye(len(vertices)) - 0.02 * laplacian.matrix().toarray())
    linear = implicit_fairing(vertices, faces, time_step=0.02, iterations=6)
    assert np.abs(linear - np.linalg.matrix_power(step, 6) @ vertices).max() < SOLVED
    anew = vertices
    for _ in range(3):
        anew = implicit_fairing(anew, faces, time_step=0.02)
    curved = implicit_fairing(vertices, faces, time_step=0.02, iterations=3, flow="mean_curvature")
    assert np.abs(curved - anew).max() < SOLVED


def test_the_conformalized_flow_keeps_the_stiffness() -> None:
    """Its second step solves with the stiffness of the input and the areas of the first step's surface."""
    vertices, faces = noisy(icosphere(2), 0.03)
    stiffness = build_laplacian(vertices, faces, "laplace_beltrami").stiffness.toarray()
    expected = vertices
    for _ in range(2):
        mass = np.diag(build_laplacian(expected, faces, "laplace_beltrami").mass)
        expected = np.linalg.solve(mass - 0.1 * stiffness, mass @ expected)
    smooth = implicit_fairing(vertices, faces, time_step=0.1, iterations=2, flow="conformalized")
    assert np.abs(smooth - expected).max() < SOLVED


def test_the_conformalized_flow_of_borders_and_lengths() -> None:
    """With weights by lengths and a border along its curve too, only the masses of the second step are new."""
    vertices, faces = noisy(irregular_grid(6, 7), 0.1)
    on_border = border_vertices(faces, len(vertices))
    t = 0.5
    stiffness = build_laplacian(vertices, faces, "scale_dependent").stiffness.toarray()
    along = curve_laplacian(vertices, border_edges(faces), "scale_dependent").stiffness.toarray()
    expected = vertices
    for _ in range(2):
        mass = build_laplacian(expected, faces, "scale_dependent").mass
        mass = np.where(on_border, curve_laplacian(expected, border_edges(faces), "scale_dependent").mass, mass)
        rows = np.diag(mass) - t * np.where(on_border[:, None], along, stiffness)
        expected = np.linalg.solve(rows, mass[:, None] * expected)
    smooth = implicit_fairing(
        vertices, faces, operator="scale_dependent", time_step=t, iterations=2, flow="conformalized", border="along"
    )
    assert np.abs(smooth - expected).max() < SOLVED * diagonal(vertices)


# ------------------------------------------------------------------------------------------------------------------ geometry


@pytest.mark.parametrize("flow", FLOWS)
@pytest.mark.parametrize("operator", ["cotangent", "uniform", "robust"])
def test_volume_is_preserved(operator: ImplicitOperator, flow: Flow) -> None:
    """Every closed component, also one turned inside out, keeps its volume to 1e-12, component by component."""
    vertices, faces = noisy(two_spheres(), 0.03)
    half = len(vertices) // 2
    vertices[half:] *= 0.5
    faces[len(faces) // 2 :] = faces[len(faces) // 2 :, ::-1]
    t = 2.0 * unit_of_time((vertices, faces), operator)
    smooth = implicit_fairing(vertices, faces, operator=operator, time_step=t, iterations=2, flow=flow, preserve_volume=True)
    for part in (faces[: len(faces) // 2], faces[len(faces) // 2 :]):
        assert volume(smooth, part) == pytest.approx(volume(vertices, part), rel=1e-12)
        assert area(smooth, part) < area(vertices, part)


def test_volume_is_given_back_about_the_centroid() -> None:
    """What preserves the volume is a scaling that leaves the centroid of each component's surface where the step left it."""

    def centroid(points: Floats, part: NDArray[np.int32]) -> Floats:
        a, b, c = (points[part[:, k]] for k in range(3))
        weights = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        return np.asarray(weights @ (a + b + c) / 3 / weights.sum())

    vertices, faces = noisy(two_spheres(), 0.05)
    plain = implicit_fairing(vertices, faces, time_step=0.05)
    kept = implicit_fairing(vertices, faces, time_step=0.05, preserve_volume=True)
    for part in (faces[: len(faces) // 2], faces[len(faces) // 2 :]):
        growth = (volume(vertices, part) / volume(plain, part)) ** (1 / 3)
        own = np.unique(part)
        centre = centroid(plain, part)
        assert np.abs(centroid(kept, part) - centre).max() < 1e-13
        assert np.abs(kept[own] - centre - growth * (plain[own] - centre)).max() < 1e-12


def test_open_or_held_components_keep_no_volume() -> None:
    """A component with a border, with incoherent faces or with a vertex that may not move is left as the flow leaves it."""
    vertices, faces = noisy(icosphere(2), 0.03)
    turned = faces.copy()
    turned[5] = turned[5, ::-1]
    held = np.ones(len(vertices), dtype=bool)
    held[7] = False
    for triangles, movable in ((faces[1:], None), (turned, None), (faces, held)):
        plain = implicit_fairing(vertices, triangles, time_step=0.05, movable=movable)
        kept = implicit_fairing(vertices, triangles, time_step=0.05, movable=movable, preserve_volume=True)
        assert np.array_equal(plain, kept)


def test_nothing_left_of_a_volume_is_an_error() -> None:
    """A step that leaves a point cannot preserve the volume, and says what can."""
    vertices, faces = icosphere(2)
    with pytest.raises(FilterInputError, match="shorter time step, or more steps with flow='conformalized'"):
        implicit_fairing(vertices, faces, time_step=1e9, preserve_volume=True)


@pytest.mark.parametrize("t", [0.01, 0.1, 1.0])
def test_a_sphere_gets_its_radius_back(t: float) -> None:
    """The loss of a sphere is the same everywhere, so that what is given back is all of it, however long the step.

    On an icosphere it is as even as its triangles are: to about the squared edge, 1 %.
    """
    vertices, faces = icosphere(4)
    kept = implicit_fairing(vertices, faces, time_step=t, keep_dimensions=True)
    shrunk = implicit_fairing(vertices, faces, time_step=t)
    radii = np.linalg.norm(kept, axis=1)
    assert np.abs(radii - 1.0).max() < 0.01 * (1.0 - np.linalg.norm(shrunk, axis=1).mean())


@pytest.mark.parametrize("wave", [6, 12, 40])
def test_the_wave_of_the_detail_size_is_halved_with_dimensions_kept(wave: int) -> None:
    """A flat sine wave of which a step leaves s = 1 / (1 + t k), k the five-point Laplacian's, keeps 1 - (1 - s) (1 - s^2)^2.

    Its slope is below 1e-6, so that normals are vertical and heights losses along them to 1e-12.
    """
    vertices, faces = grid(rows=4, columns=wave)
    omega = 2 * math.pi / wave
    vertices[:, 2] = height = 1e-6 * np.sin(omega * vertices[:, 0])
    inside = (vertices[:, 0] > 0) & (vertices[:, 0] < wave)
    t = time_step_of_detail_size(wave, keep_dimensions=True)
    s = 1.0 / (1.0 + t * (2.0 - 2.0 * math.cos(omega)))
    smooth = implicit_fairing(vertices, faces, time_step=t, border="free", movable=inside, keep_dimensions=True)
    amplitude = float(smooth[:, 2] @ height / (height @ height))
    assert amplitude == pytest.approx(1.0 - (1.0 - s) * (1.0 - s * s) ** 2, abs=1e-6)
    # As without: d(amplitude) is at most 0.37 times the relative change of the eigenvalue, (omega h)^2 / 12.
    assert abs(amplitude - 0.5) <= 0.37 * omega**2 / 12 * 1.05


def test_limbs_keep_their_thickness() -> None:
    """An ellipsoid of 5 : 1 : 1, whose thickness a step cuts by 9 %, keeps it to 0.1 %, and its length to 2 %."""
    vertices, faces = icosphere(4)
    vertices = vertices * [5.0, 1.0, 1.0]
    plain, kept = (implicit_fairing(vertices, faces, time_step=0.1, keep_dimensions=keep) for keep in (False, True))
    change = [np.abs(np.ptp(points, axis=0) / np.ptp(vertices, axis=0) - 1.0) for points in (plain, kept)]
    assert change[0][1:].min() > 0.09
    assert change[1][1:].max() < 0.001
    assert change[1][0] < 0.02


@pytest.mark.parametrize("name", ["keep_dimensions", "preserve_volume"])
def test_dimensions_and_volume_of_a_cloud_are_refused(name: str) -> None:
    """A point cloud has no triangles, so no normals to give anything back along, and no volume."""
    options: dict[str, Any] = {"operator": "robust", name: True}
    with pytest.raises(FilterInputError, match=f"{name} needs triangles"):
        implicit_fairing(icosphere(1)[0], np.empty((0, 3), int), time_step=0.1, **options)


def test_a_neck_does_not_pinch_off_under_the_conformalized_flow() -> None:
    """A dumbbell's neck closes under mean curvature flow; conformalized, its thinnest triangle keeps a fifth of its shape."""
    vertices, faces = dumbbell()

    def thinnest(points: Floats) -> float:
        a, b, c = (points[faces[:, k]] for k in range(3))
        longest = np.maximum(np.maximum(((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1)), ((a - c) ** 2).sum(1))
        return float((np.linalg.norm(np.cross(b - a, c - a), axis=1) / longest).min())

    def flowed(flow: Flow) -> Floats:
        return implicit_fairing(vertices, faces, time_step=0.005, iterations=16, flow=flow, preserve_volume=True)

    assert np.isfinite(flowed("conformalized")).all()
    assert thinnest(flowed("conformalized")) > 0.2 * thinnest(vertices)
    assert thinnest(flowed("mean_curvature")) < 0.001 * thinnest(vertices)


def test_surfaces_without_handles_tend_to_a_sphere() -> None:
    """The conformalized flow takes an ellipsoid of axes 2 : 1 : 1 to a sphere: the isoperimetric quotient rises from 0.8 to 1.

    Coarse triangles limit it: what is missing falls to less than half as edges are halved.
    """
    missing = []
    for subdivisions in (3, 4):
        vertices, faces = icosphere(subdivisions)
        vertices = vertices * [2.0, 1.0, 1.0]
        smooth = implicit_fairing(vertices, faces, time_step=0.2, iterations=60, flow="conformalized", preserve_volume=True)
        missing.append(1 - 36 * math.pi * volume(smooth, faces) ** 2 / area(smooth, faces) ** 3)
        assert 36 * math.pi * volume(vertices, faces) ** 2 / area(vertices, faces) ** 3 < 0.82
    assert missing[0] < 0.01
    assert missing[1] < missing[0] / 2


@pytest.mark.parametrize("factor", [1e-12, 1e-3, 1.0, 1e3, 1e6, 1e12, 1e200])
@pytest.mark.parametrize("operator", OPERATORS)
def test_no_step_is_too_long(operator: ImplicitOperator, factor: float) -> None:
    """Whatever the step, both of two components stay within their box and keep their centroids, weighted by M, to rounding.

    From 1e12 squared edges on they are points there, and below 1e-12 nothing moves by more than that times an edge or so.
    """
    vertices, faces = noisy(two_spheres(), 0.02)
    t = factor * unit_of_time((vertices, faces), operator)
    smooth = implicit_fairing(vertices, faces, operator=operator, time_step=t)
    mass = build_laplacian(vertices, faces, surface_operator(operator)).mass[:, None]
    for part in (slice(0, 162), slice(162, 324)):
        centre = (mass * vertices)[part].sum(axis=0) / mass[part].sum()
        assert np.abs((mass * smooth)[part].sum(axis=0) / mass[part].sum() - centre).max() < 1e-13
        assert (smooth[part] >= vertices[part].min(axis=0)).all()
        assert (smooth[part] <= vertices[part].max(axis=0)).all()
        if factor >= 1e12:
            assert np.abs(smooth[part] - centre).max() < 1e-10
    if factor <= 1e-12:
        assert np.abs(smooth - vertices).max() < 1e-12


@pytest.mark.parametrize("t", [1e6, 1e30])
def test_slivers_follow_however_long_the_step(t: float) -> None:
    """Weights of 1e9, whose rounding errors alone outweigh the masses of a long step, do not keep a sphere from its centroid."""
    vertices, faces = with_caps(1e-9)
    mass = build_laplacian(vertices, faces, "laplace_beltrami").mass[:, None]
    centre = (mass * vertices).sum(axis=0) / mass.sum()
    # The caps lose nine digits and more.
    assert np.abs(implicit_fairing(vertices, faces, time_step=t) - centre).max() < 1e-3


def test_flat_interiors_stay_flat_and_in_place() -> None:
    """The cotangent operator moves no interior vertex of a flat mesh with fixed border; the uniform one does."""
    vertices, faces = irregular_grid()
    cotangent = implicit_fairing(vertices, faces, time_step=5.0, border="fixed")
    uniform = implicit_fairing(vertices, faces, operator="uniform", time_step=5.0, border="fixed")
    assert np.abs(cotangent - vertices).max() < 1e-10
    assert np.abs(uniform - vertices).max() > 0.05
    assert (uniform[:, 2] == 0).all()


# ---------------------------------------------------------------------------------------------------------------- invariances


@pytest.mark.parametrize("border", ["along", "free"])
@pytest.mark.parametrize("operator", OPERATORS)
def test_rotations_and_vertex_order_make_no_difference(operator: ImplicitOperator, border: BorderPolicy) -> None:
    """The rotated and renumbered mesh comes out as the mesh rotated and renumbered, within the solver's tolerance."""
    vertices, faces = noisy(irregular_grid(9, 9, amount=0.2), 0.1)
    t = 3 * unit_of_time((vertices, faces), operator)
    expected = implicit_fairing(vertices, faces, operator=operator, time_step=t, border=border)
    turn = rotation(1)
    shuffled, triangles, order = renumbered((vertices @ turn.T, faces), seed=2)
    smooth = implicit_fairing(shuffled, triangles, operator=operator, time_step=t, border=border)
    assert np.abs(smooth - (expected @ turn.T)[order]).max() < SOLVED * diagonal(vertices)


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("scale", [1e-30, 1e-3, 1e30])
def test_units_make_no_difference(operator: ImplicitOperator, scale: float) -> None:
    """A mesh measured in other units, with the time step in their squares, comes out in these units."""
    vertices, faces = noisy(icosphere(2), 0.02)
    t = 5 * unit_of_time((vertices, faces), operator)
    expected = implicit_fairing(vertices, faces, operator=operator, time_step=t, iterations=2, preserve_volume=True)
    scaled_t = t if operator in ("uniform", "inverse_length") else t * scale**2
    smooth = implicit_fairing(vertices * scale, faces, operator=operator, time_step=scaled_t, iterations=2, preserve_volume=True)
    assert np.abs(smooth / scale - expected).max() < SOLVED


@pytest.mark.parametrize("operator", OPERATORS)
def test_place_makes_no_difference(operator: ImplicitOperator) -> None:
    """A sphere of one millimetre at geo-referenced coordinates is smoothed like one at the origin, but for their last digit."""
    offset = np.array([451234.0, 4512345.0, 123.0])
    vertices, faces = noisy(icosphere(2, radius=1e-3), 2e-5)
    there = vertices + offset
    here = there - offset  # what is left of the coordinates over there, exactly
    t = 3 * unit_of_time((here, faces), operator)
    smooth_here = implicit_fairing(here, faces, operator=operator, time_step=t, preserve_volume=True)
    smooth_there = implicit_fairing(there, faces, operator=operator, time_step=t, preserve_volume=True)
    assert np.abs(smooth_there - offset - smooth_here).max() <= 1.5 * np.spacing(offset.max())


def test_finer_triangles_make_little_difference() -> None:
    """The same torus with four times as many triangles is smoothed by the same length: lengths, not triangles, count."""
    t = time_step_of_detail_size(1.0)
    coarse, fine = torus(48, 24), torus(96, 48)
    shrunk = [volume(implicit_fairing(*mesh, time_step=t), mesh[1]) / volume(*mesh) for mesh in (coarse, fine)]
    assert shrunk[0] == pytest.approx(shrunk[1], rel=0.005)
    assert shrunk[0] < 0.95


# ------------------------------------------------------------------------------------------------------------------- awkward


@pytest.mark.parametrize("name", AWKWARD)
@pytest.mark.parametrize("operator", OPERATORS)
def test_awkward_meshes(operator: ImplicitOperator, name: str) -> None:
    """No mesh gives NaN or a spike beyond its box, for short and very long steps; vertices that no face uses keep every bit."""
    vertices, faces = AWKWARD[name]()
    used = referenced_vertices(faces, len(vertices))
    if len(faces) and not used.any() and operator == "robust":
        pytest.skip("a robust operator of no triangle at all is that of a cloud")
    low, high = (vertices[used].min(axis=0), vertices[used].max(axis=0)) if used.any() else (np.zeros(3), np.zeros(3))
    # Negative weights allow more than the box; a fifth of its size more would be a spike.
    slack = 0.2 * float((high - low).max())
    unit = unit_of_time((vertices, faces), operator)
    for factor in (1e-6, 1.0, 1e3, 1e12):
        t = min(factor * unit, 1e300)
        for border in BORDERS:
            smooth = implicit_fairing(vertices, faces, operator=operator, time_step=t, border=border)
            assert np.isfinite(smooth).all()
            assert (smooth[used] >= low - slack).all()
            assert (smooth[used] <= high + slack).all()
            assert np.array_equal(smooth[~used].view(np.uint64), vertices[~used].view(np.uint64))


def test_indefinite_weights_are_replaced() -> None:
    """Given weights that are not semidefinite, as rounding makes those of slivers, a step is that without the negative ones."""
    weights = np.array([[0.0, 1.0, 1.0, -5.0], [1.0, 0.0, 1.0, 1.0], [1.0, 1.0, 0.0, 1.0], [-5.0, 1.0, 1.0, 0.0]])
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]])
    positive = np.maximum(weights, 0.0)

    def stiffness(w: Floats) -> Floats:
        return w - np.diag(np.where(w > 0, w, 0).sum(axis=1))

    assert np.linalg.eigvalsh(stiffness(weights))[-1] > 0.1
    laplacian = Laplacian(sparse.csr_matrix(stiffness(weights)), np.full(4, 0.5))
    nobody = np.zeros(4, dtype=bool)
    step = BackwardEulerStep(laplacian, 3.0, fixed=nobody, components=np.zeros(4, dtype=np.int32))
    moved = step.displacement(points, np.zeros((4, 3)), diagonal=1.0, progress=ignore_progress)
    expected = np.linalg.solve(0.5 * np.eye(4) - 3.0 * stiffness(positive), 0.5 * points)
    assert np.abs(points + moved - expected).max() < 1e-9


@pytest.mark.parametrize("flow", ["mean_curvature", "conformalized"])
@pytest.mark.parametrize("name", ["thin caps", "needles", "three pages", "moebius strip", "all in one point", "one triangle"])
def test_flows_of_awkward_meshes_stay_finite(name: str, flow: Flow) -> None:
    """Long flows, that collapse what they are given, give finite coordinates at every step."""
    vertices, faces = AWKWARD[name]()
    t = mean_edge_length(vertices, faces) ** 2
    assert np.isfinite(implicit_fairing(vertices, faces, time_step=100 * t, iterations=8, flow=flow, border="free")).all()


def test_a_stray_vertex_far_away_makes_no_difference() -> None:
    """A vertex that no face uses, however far away, neither moves nor changes how the others do."""
    vertices, faces = noisy(icosphere(2), 0.02)
    expected = implicit_fairing(vertices, faces, time_step=0.05)
    smooth = implicit_fairing(np.concatenate([[[1e30, -1e30, 5.0]], vertices]), faces + 1, time_step=0.05)
    assert np.array_equal(smooth[1:], expected)
    assert np.array_equal(smooth[0], [1e30, -1e30, 5.0])


def test_a_point_cloud() -> None:
    """A noisy flat cloud is flattened by the robust operator alone; the others say that they need triangles."""
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(0, 1, (900, 2)), rng.normal(0, 0.01, 900)])
    none = np.empty((0, 3), dtype=np.int32)
    smooth = implicit_fairing(points, none, operator="robust", time_step=0.003)
    inside = (np.abs(points[:, :2] - 0.5) < 0.4).all(axis=1)
    assert smooth[inside, 2].std() < 0.4 * points[inside, 2].std()
    with pytest.raises(FilterInputError, match="operator 'cotangent' needs triangles and there are none; for a point cloud take"):
        implicit_fairing(points, none, time_step=0.003)


def test_immovable_vertices_are_seen() -> None:
    """Held vertices keep every bit and pull the others towards them."""
    vertices, faces = icosphere(2)
    movable = vertices[:, 2] > 0
    smooth = implicit_fairing(vertices, faces, time_step=1e6, movable=movable)
    assert np.array_equal(smooth[~movable], vertices[~movable])
    assert np.abs(smooth[movable, 2]).max() < 0.2
    none = np.zeros(len(vertices), dtype=bool)
    assert np.array_equal(implicit_fairing(vertices, faces, time_step=1.0, movable=none), vertices)


@pytest.mark.parametrize("options", [{"time_step": 0.0}, {"time_step": 1.0, "iterations": 0}])
def test_no_step_no_change(options: dict[str, float]) -> None:
    """A time step of 0, or no iteration, returns a copy."""
    vertices, faces = noisy(icosphere(1), 0.02)
    smooth = implicit_fairing(vertices, faces, **options)  # type: ignore[arg-type]
    assert np.array_equal(smooth, vertices)
    assert smooth is not vertices


def test_progress_runs_from_none_to_all() -> None:
    """Progress never goes back over several steps with borders, ends at 1, and an exception of it comes through."""
    vertices, faces = noisy(grid(), 0.1)
    told: list[float] = []
    implicit_fairing(vertices, faces, time_step=1.0, iterations=3, flow="mean_curvature", progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0

    def stop(done: float) -> None:
        raise InterruptedError

    with pytest.raises(InterruptedError):
        implicit_fairing(vertices, faces, time_step=1.0, progress=stop)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"time_step": math.nan}, "time_step is nan"),
        ({"time_step": math.inf}, "time_step is inf"),
        ({"time_step": -1.0}, r"time_step is -1\.0: it must be finite and at least 0"),
        ({"time_step": 1.0, "iterations": -1}, "iterations is -1"),
        ({"time_step": 1.0, "iterations": 1.5}, r"iterations is 1\.5"),
        ({"time_step": 1.0, "operator": "laplace"}, "operator 'laplace' is not one of 'uniform'"),
        ({"time_step": 1.0, "flow": "fast"}, "flow 'fast' is not one of 'linear'"),
        ({"time_step": 1.0, "border": "open"}, "border 'open' is not one of 'fixed'"),
        ({"time_step": 1.0, "movable": np.ones(4, dtype=bool)}, "boolean array of 3 values"),
        ({"time_step": 1.0, "movable": np.ones(3)}, "boolean array of 3 values"),
    ],
)
def test_parameters_that_are_refused(options: dict[str, object], message: str) -> None:
    """A parameter out of range is named with its value and what is allowed."""
    with pytest.raises(FilterInputError, match=message):
        implicit_fairing(*single_triangle(), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(("size", "iterations"), [(0.0, 1), (-1.0, 1), (math.nan, 1), (math.inf, 1), (1.0, 0)])
def test_detail_sizes_that_are_refused(size: float, iterations: int) -> None:
    """A detail size is a positive length, for at least one step."""
    with pytest.raises(FilterInputError, match=r"detail_size|together they halve waves of the detail size"):
        time_step_of_detail_size(size, iterations)


def test_a_mesh_with_nan_is_refused() -> None:
    """Coordinates that are not finite are an error that says how many."""
    vertices, faces = icosphere(1)
    vertices[3, 1] = math.nan
    with pytest.raises(FilterInputError, match="1 of 42 vertices"):
        implicit_fairing(vertices, faces, time_step=0.1)


def test_finer_meshes_of_a_subdivision_are_connected() -> None:
    """The solver's preconditioner changes with the step and the size, the answer does not: both sides of the switch agree."""
    vertices, faces = noisy(subdivided(*icosphere(2)), 0.01)
    unit = mean_edge_length(vertices, faces) ** 2
    steps: NDArray[np.float64] = np.geomspace(0.5, 50.0, 12) * unit
    lengths = [np.linalg.norm(implicit_fairing(vertices, faces, time_step=float(t))) for t in steps]
    laplacian = build_laplacian(vertices, faces, "laplace_beltrami")
    for t, length in zip(steps, lengths, strict=True):
        matrix = sparse.csc_matrix(sparse.diags_array(laplacian.mass) - t * laplacian.stiffness)
        assert length == pytest.approx(np.linalg.norm(spsolve(matrix, laplacian.mass[:, None] * vertices)), rel=1e-9)
