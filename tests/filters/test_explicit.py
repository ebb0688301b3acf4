"""Explicit steps: against the matrices of the operators, the theory, and every border policy."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
import scipy.sparse.linalg
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pymeshfair.filters import execution as parallel
from pymeshfair.filters import mesh as ordering
from pymeshfair.filters import topology
from pymeshfair.filters.checks import FilterInputError, UnstableStepError
from pymeshfair.filters.compilation import allowed_threads, set_threads
from pymeshfair.filters.diffusion.explicit import explicit_smoothing
from pymeshfair.filters.mesh import check_mesh
from pymeshfair.filters.operators import OPERATOR_NAMES, OperatorName, build_laplacian, curve_laplacian, uniform_laplacian
from pymeshfair.filters.topology import BORDER_POLICIES, BorderPolicy
from tests.filters.test_operators import any_mesh
from tests.meshes import (
    AWKWARD,
    Mesh,
    area,
    bow_tie,
    diagonal,
    grid,
    icosphere,
    irregular_grid,
    moebius_strip,
    noisy,
    renumbered,
    rotation,
    sample,
    single_triangle,
    tetrahedron,
    tube,
    volume,
)

Floats = NDArray[np.float64]
NORMALISED: tuple[OperatorName, ...] = ("uniform", "inverse_length", "cotangent")


def safe_step(mesh: Mesh, operator: OperatorName, share: float = 0.5) -> float:
    """A step that is stable on this mesh and on what a few of them make of it."""
    if operator in NORMALISED:
        return share
    vertices, faces = check_mesh(*mesh)
    bounds = [build_laplacian(vertices, faces, operator).spectral_bound()]
    if len(faces):
        bounds.append(curve_laplacian(vertices, topology.border_edges(faces), operator).spectral_bound())
    return share * 2 / max(*bounds, 1e-300)


def by_matrices(
    mesh: Mesh,
    operator: OperatorName,
    step: float,
    iterations: int,
    border: BorderPolicy,
    movable: NDArray[np.bool_] | None = None,
) -> Floats:
    """The same steps by the assembled matrices, row by row as the border policy says."""
    vertices, faces = mesh
    n = len(vertices)
    border_edges, on_border = topology.border_edges(faces), topology.border_vertices(faces, n)
    moves = np.ones(n, dtype=bool) if movable is None else movable
    points = vertices.copy()
    for iteration in range(iterations):
        if iteration == 0 or operator != "robust":
            surface, curve = build_laplacian(points, faces, operator), curve_laplacian(points, border_edges, operator)
        change = surface.apply(points)
        if border == "along":
            change[on_border] = curve.apply(points)[on_border]
        elif border == "fixed":
            change[on_border] = 0.0
        points = points + step * np.where(moves[:, None], change, 0.0)
    return points


@pytest.mark.parametrize("operator", OPERATOR_NAMES)
@pytest.mark.parametrize("border", BORDER_POLICIES)
@pytest.mark.parametrize(
    "mesh",
    [
        noisy(irregular_grid(), 0.1),
        noisy(tube(), 0.03),
        moebius_strip(),
        bow_tie(),
        AWKWARD["ten pages"](),
        AWKWARD["large hub"](),
    ],
    ids=["irregular grid", "tube", "moebius strip", "bow tie", "ten pages", "large hub"],
)
def test_steps_are_those_of_the_matrices(operator: OperatorName, border: BorderPolicy, mesh: Mesh) -> None:
    """Three fused steps equal three with assembled matrices and their border rows, for every operator and policy, to rounding."""
    step = safe_step(mesh, operator, 0.02)
    found = explicit_smoothing(*mesh, operator=operator, step=step, iterations=3, border=border)
    np.testing.assert_allclose(found, by_matrices(mesh, operator, step, 3, border), atol=1e-13 * diagonal(mesh[0]))


def test_the_length_of_an_edge_without_length_is_that_in_the_matrices() -> None:
    """Such an edge counts as a millionth of the mean edge, so that its ends move about as much: that is seen beside rounding."""
    vertices, faces = noisy(icosphere(1), 0.1)
    a, b = faces[10, :2]
    vertices[a] = vertices[b]
    found = explicit_smoothing(vertices, faces, operator="inverse_length", step=0.5, iterations=1)
    expected = by_matrices((vertices, faces), "inverse_length", 0.5, 1, "along")
    assert 1e-8 < np.linalg.norm(expected[a] - vertices[a]) < 1e-5
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * diagonal(vertices))


@given(any_mesh(), st.sampled_from(OPERATOR_NAMES), st.sampled_from(BORDER_POLICIES))
def test_a_step_on_any_faces_at_all_is_that_of_the_matrices(mesh: Mesh, operator: OperatorName, border: BorderPolicy) -> None:
    """Coincident, collinear, repeated, non-manifold: one step is finite, that of the matrices, and moves nothing it may not."""
    vertices, faces = mesh
    step = 0.5
    if operator not in NORMALISED:
        try:
            explicit_smoothing(vertices, faces, operator=operator, step=1e300, iterations=1, border=border)
        except UnstableStepError as error:
            step = 0.5 * error.largest_stable
    found = explicit_smoothing(vertices, faces, operator=operator, step=step, iterations=1, border=border)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found, by_matrices(mesh, operator, step, 1, border), atol=1e-13 * diagonal(vertices))
    still = ~topology.referenced_vertices(faces, len(vertices))
    if border == "fixed":
        still |= topology.border_vertices(faces, len(vertices))
    assert found[still].tobytes() == vertices[still].tobytes()


@pytest.mark.parametrize("operator", OPERATOR_NAMES)
@pytest.mark.parametrize("border", BORDER_POLICIES)
def test_only_movable_vertices_move_and_all_are_seen(operator: OperatorName, border: BorderPolicy) -> None:
    """With a mask the others keep every bit, and the movable ones go where the matrices with the other rows at 0 take them."""
    mesh = noisy(tube(), 0.03)
    movable = np.random.default_rng(1).random(len(mesh[0])) < 0.5
    step = safe_step(mesh, operator, 0.2)
    found = explicit_smoothing(*mesh, operator=operator, step=step, iterations=3, border=border, movable=movable)
    assert found[~movable].tobytes() == mesh[0][~movable].tobytes()
    expected = by_matrices(mesh, operator, step, 3, border, movable)
    np.testing.assert_allclose(found, expected, atol=1e-13 * diagonal(mesh[0]))


@pytest.mark.parametrize("operator", NORMALISED)
def test_the_tetrahedron_shrinks_by_its_closed_form(operator: OperatorName) -> None:
    """Every normalised operator has the eigenvalue -4/3 on the regular tetrahedron: n steps scale it by (1 - 4/3 step)^n."""
    vertices, faces = tetrahedron()
    found = explicit_smoothing(vertices, faces, operator=operator, step=0.25, iterations=7)
    np.testing.assert_allclose(found, vertices * (1 - 0.25 * 4 / 3) ** 7, rtol=1e-13)


def test_one_triangle_by_closed_form() -> None:
    """A single triangle is all border: a uniform step of 1/2 takes each vertex 3/4 of the way to the mean, which stays."""
    vertices, faces = single_triangle()
    mean = vertices.mean(axis=0)
    for border in ("along", "free"):
        found = explicit_smoothing(vertices, faces, step=0.5, iterations=1, border=border)
        np.testing.assert_allclose(found - mean, (vertices - mean) * (1 - 0.5 * 1.5), atol=1e-15)
    assert explicit_smoothing(vertices, faces, border="fixed").tobytes() == vertices.tobytes()


# ----------------------------------------------------------------------------------------------------------------- statements


def test_a_hundred_uniform_steps_shrink_the_sphere_as_the_transfer_function_predicts() -> None:
    """On the icosphere of 2,562 vertices 100 steps of 1/2 lose over 30 % of the volume: (1 - k/2)^300 with k of the lowest modes.

    The sphere's coordinates lie in the space of the three lowest modes but for a share eps in the norm of the masses, 2 %; a
    relative change of positions by eps changes the volume by 3 eps at most, to first order.
    """
    vertices, faces = icosphere(4)
    laplacian = uniform_laplacian(faces, len(vertices))
    masses = scipy.sparse.diags_array(laplacian.mass)
    start = np.ones(len(vertices))
    values, modes = scipy.sparse.linalg.eigsh(-laplacian.stiffness, M=masses, k=4, sigma=-1e-3, v0=start)
    lowest = modes[:, 1:]
    rest = vertices - lowest @ (lowest.T @ (masses @ vertices))
    eps = math.sqrt((masses @ rest**2).sum() / (masses @ vertices**2).sum())
    assert eps < 0.02
    found = explicit_smoothing(vertices, faces, step=0.5, iterations=100)
    left = volume(found, faces) / volume(vertices, faces)
    assert left < 0.7
    assert left == pytest.approx((1 - 0.5 * values[1:].mean()) ** 300, rel=3 * eps)


def test_a_closed_surface_contracts_to_a_point() -> None:
    """Many uniform steps take a noisy sphere, wherever it is, to a single point inside its box."""
    vertices, faces = noisy(icosphere(1), 0.1)
    found = explicit_smoothing(vertices + 5.0, faces, step=1.0, iterations=400)
    assert diagonal(found) < 1e-6
    assert (np.abs(found - 5.0) < 0.5).all()


@pytest.mark.parametrize("operator", ["cotangent", "laplace_beltrami", "robust"])
def test_a_flat_mesh_keeps_its_interior_under_cotangents(operator: OperatorName) -> None:
    """A flat irregular mesh, obtuse triangles included, comes out of 20 steps as it went in."""
    mesh = irregular_grid(amount=0.45)
    found = explicit_smoothing(*mesh, operator=operator, step=safe_step(mesh, operator), iterations=20, border="fixed")
    # "robust" lengthens edges by up to 1e-5 of the mean edge, 1 here.
    np.testing.assert_allclose(found, mesh[0], atol=1e-3 if operator == "robust" else 1e-12)


def test_a_flat_mesh_is_moved_by_the_uniform_operator() -> None:
    """The same flat mesh is moved, within its plane, by a single uniform step."""
    vertices, faces = irregular_grid(amount=0.45)
    found = explicit_smoothing(vertices, faces, iterations=1, border="fixed")
    assert np.abs(found - vertices).max() > 0.1
    assert not found[:, 2].any()


@given(
    st.integers(0, 10_000),
    st.sampled_from([0.01, 0.1, 0.3]),
    st.floats(0.05, 1.0),
    st.sampled_from(["sphere", "grid"]),
    st.booleans(),
)
def test_a_cotangent_step_never_increases_the_area(seed: int, noise: float, step: float, kind: str, masked: bool) -> None:
    """Whatever the noise, with obtuse triangles and spikes, any step up to 1 leaves no more area than there was.

    The area is the Dirichlet energy of the coordinates under their own cotangents, and no larger than it under any others.
    """
    mesh = noisy(icosphere(1) if kind == "sphere" else grid(4, 4), noise, seed)
    movable = np.random.default_rng(seed).random(len(mesh[0])) < 0.6 if masked else None
    after = explicit_smoothing(*mesh, operator="cotangent", step=step, iterations=1, border="free", movable=movable)
    assert area(after, mesh[1]) <= area(*mesh) * (1 + 1e-12)


@given(
    st.integers(0, 10_000), st.floats(0.05, 1.0), st.sampled_from(["uniform", "inverse_length"]), st.sampled_from(BORDER_POLICIES)
)
def test_mean_steps_stay_in_the_box(seed: int, step: float, operator: OperatorName, border: BorderPolicy) -> None:
    """Steps with weights that are not negative are weighted means: no vertex leaves the box of the input, whatever the policy."""
    vertices, faces = noisy(grid(4, 4), 0.5, seed)
    found = explicit_smoothing(vertices, faces, operator=operator, step=step, iterations=5, border=border)
    assert (found >= vertices.min(axis=0) - 1e-14).all()
    assert (found <= vertices.max(axis=0) + 1e-14).all()


# -------------------------------------------------------------------------------------------------------------------- borders


@pytest.mark.parametrize("operator", OPERATOR_NAMES)
def test_along_the_border_is_a_curve_of_its_own(operator: OperatorName) -> None:
    """Under "along" the border goes its own way however the interior lies, under "free" it does not, under "fixed" it stays."""
    vertices, faces = noisy(grid(5, 6), 0.05)
    on_border = topology.border_vertices(faces, len(vertices))
    bumped = vertices.copy()
    bumped[~on_border, 2] += 0.4
    step = min(safe_step((v, faces), operator, 0.1) for v in (vertices, bumped))
    results = {
        border: [
            explicit_smoothing(v, faces, operator=operator, step=step, iterations=3, border=border)[on_border]
            for v in (vertices, bumped)
        ]
        for border in BORDER_POLICIES
    }
    np.testing.assert_allclose(results["along"][0], results["along"][1], atol=1e-14)
    assert np.abs(results["along"][0] - vertices[on_border]).max() > 1e-3
    assert np.abs(np.subtract(*results["free"])).max() > 1e-3
    assert results["fixed"][0].tobytes() == vertices[on_border].tobytes()


def test_along_a_straight_uneven_border_only_the_uniform_operator_moves_vertices() -> None:
    """On straight, unevenly spaced sides of a grid the border's vertices stay under every operator but the uniform one."""
    vertices, faces = grid(4, 6)
    vertices[:, 0] = np.array([0.0, 0.2, 1.0, 1.1, 3.0, 4.5, 6.0])[vertices[:, 0].astype(int)]
    sides = np.isin(vertices[:, 1], [0.0, 4.0]) & (vertices[:, 0] > 0) & (vertices[:, 0] < 6)
    corners = topology.border_vertices(faces, len(vertices)) & ~sides & np.isin(vertices[:, 1], [0.0, 4.0])
    for operator in OPERATOR_NAMES:
        step = safe_step((vertices, faces), operator)
        found = explicit_smoothing(vertices, faces, operator=operator, step=step, iterations=1, movable=~corners)
        moved = np.abs(found - vertices)[sides].max()
        assert moved > 0.05 if operator == "uniform" else moved < 1e-13


# ------------------------------------------------------------------------------------------------------------------ stability


@pytest.mark.parametrize("noise", [0.01, 0.015, 0.02, 0.025, 0.03])
def test_the_step_that_the_message_advises_is_taken(noise: float) -> None:
    """The written number is not above the largest stable step: half of those rounded to the nearest would be refused again."""
    mesh = noisy(icosphere(3), noise)
    with pytest.raises(UnstableStepError) as caught:
        explicit_smoothing(*mesh, operator="laplace_beltrami", step=1.0, iterations=1)
    advised = re.search(r"on this mesh, (\S+) squared", str(caught.value))
    assert advised
    explicit_smoothing(*mesh, operator="laplace_beltrami", step=float(advised[1]), iterations=1)
    assert float(advised[1]) == pytest.approx(caught.value.largest_stable, rel=1e-5)


@pytest.mark.parametrize("operator", ["scale_dependent", "laplace_beltrami", "robust"])
@pytest.mark.parametrize(
    "mesh", [noisy(icosphere(1), 0.08), noisy(grid(4, 4), 0.1), bow_tie()], ids=["noisy sphere", "noisy grid", "bow tie"]
)
def test_the_largest_stable_step_is_named_and_is_stable(operator: OperatorName, mesh: Mesh) -> None:
    """A longer step is an error that names a step that is taken, within 2 / rho of the true spectrum and over half of it."""
    vertices, faces = mesh
    before = vertices.copy()
    with pytest.raises(UnstableStepError, match=f"largest stable one of operator '{operator}'") as caught:
        explicit_smoothing(vertices, faces, operator=operator, step=1e3, iterations=5, border="free")
    assert vertices.tobytes() == before.tobytes()
    largest = caught.value.largest_stable
    laplacian = build_laplacian(vertices, faces, operator)
    root = np.sqrt(laplacian.inverse_mass)
    rho = -np.linalg.eigvalsh(root[:, None] * laplacian.stiffness.toarray() * root).min()
    assert 1 / rho < largest <= 2 / rho * (1 + 1e-12)
    if operator == "laplace_beltrami":
        assert largest >= 2 / laplacian.spectral_bound() * (1 - 1e-12)
    else:
        assert largest == pytest.approx(2 / laplacian.spectral_bound(), rel=1e-12)
    explicit_smoothing(vertices, faces, operator=operator, step=largest * (1 - 1e-12), iterations=1, border="free")
    with pytest.raises(UnstableStepError):
        explicit_smoothing(vertices, faces, operator=operator, step=largest * (1 + 1e-9), iterations=1, border="free")


@pytest.mark.parametrize("operator", ["scale_dependent", "laplace_beltrami", "robust"])
def test_a_border_of_short_edges_limits_the_step(operator: OperatorName) -> None:
    """Under "along" the largest stable step is no longer than that of the border's curve, here with an edge of 1/1000."""
    vertices, faces = tube(16, 6)
    vertices[0] += 0.999 * (vertices[1] - vertices[0])
    with pytest.raises(UnstableStepError) as caught:
        explicit_smoothing(vertices, faces, operator=operator, step=1e3)
    curve = curve_laplacian(vertices, topology.border_edges(faces), operator)
    assert caught.value.largest_stable <= 2 / curve.spectral_bound() * (1 + 1e-12)


def test_on_equilateral_triangles_the_bound_is_that_of_the_lattice() -> None:
    """A lattice of equilateral triangles with edges h has rho = 6 / h^2: the largest stable step is h^2 / 3 (Gershgorin: 1/4)."""
    vertices, faces = grid(9, 9, spacing=2.0)
    # The squares' diagonal runs from (0, 0) to (1, 1): shear it to the length of the sides.
    vertices = vertices @ np.array([[1.0, 0, 0], [-0.5, math.sqrt(3) / 2, 0], [0, 0, 1]])
    with pytest.raises(UnstableStepError) as caught:
        explicit_smoothing(vertices, faces, operator="laplace_beltrami", step=1e3, border="fixed")
    # A triangle's two eigenvalues coincide; the root of a difference of 1e-16 is 1e-8.
    assert caught.value.largest_stable == pytest.approx(4 / 3, rel=1e-7)


def test_a_step_that_becomes_unstable_while_the_surface_shrinks_is_an_error() -> None:
    """A sphere under mean curvature flow shrinks until the step is too long for its triangles; the error says when."""
    vertices, faces = icosphere(2)
    with pytest.raises(UnstableStepError) as caught:
        explicit_smoothing(vertices, faces, operator="laplace_beltrami", step=1.0)
    step = 0.5 * caught.value.largest_stable
    with pytest.raises(UnstableStepError, match=r"after \d+ iterations, which have shrunk the surface") as later:
        explicit_smoothing(vertices, faces, operator="laplace_beltrami", step=step, iterations=1000)
    assert later.value.largest_stable < step


def test_smoothing_scales_with_the_mesh() -> None:
    """The largest stable step of a mesh of twice the size is four times as long."""
    vertices, faces = noisy(icosphere(1), 0.05)
    named = []
    for size in (1.0, 2.0, 1e30, 1e-30):
        with pytest.raises(UnstableStepError) as caught:
            explicit_smoothing(vertices * size, faces, operator="laplace_beltrami", step=1e200)
        named.append(caught.value.largest_stable / size**2)
    np.testing.assert_allclose(named, named[0], rtol=1e-12)


# ------------------------------------------------------------------------------------------------------------- invariance, bits


@pytest.mark.parametrize("operator", OPERATOR_NAMES)
@pytest.mark.parametrize("border", BORDER_POLICIES)
def test_rotation_place_scale_and_order_make_no_difference(operator: OperatorName, border: BorderPolicy) -> None:
    """A turned, moved, scaled and renumbered mesh goes where the original goes."""
    vertices, faces = noisy(tube(), 0.03)
    step = safe_step((vertices, faces), operator, 0.3)
    found = explicit_smoothing(vertices, faces, operator=operator, step=step, iterations=3, border=border)
    turn, shift, size = rotation(), np.array([30.0, -10.0, 5.0]), 4.0
    moved, moved_faces, order = renumbered((size * vertices @ turn.T + shift, faces))
    moved_step = step if operator in NORMALISED else step * size**2
    image = explicit_smoothing(moved, moved_faces, operator=operator, step=moved_step, iterations=3, border=border)
    np.testing.assert_allclose(image, (size * found @ turn.T + shift)[order], atol=1e-9 if operator == "robust" else 1e-12)


def test_the_order_and_turn_of_faces_makes_no_difference_to_the_bits() -> None:
    """Shuffled and turned faces give the same bits: sums run in an order of the vertices."""
    vertices, faces = noisy(tube(), 0.03)
    rng = np.random.default_rng(2)
    other = np.roll(faces[rng.permutation(len(faces))], 1, axis=1)
    other[::2] = other[::2, ::-1]
    for operator in ("uniform", "inverse_length", "cotangent"):
        plain = explicit_smoothing(vertices, faces, operator=operator)
        assert explicit_smoothing(vertices, other, operator=operator).tobytes() == plain.tobytes()


@pytest.mark.parametrize("operator", OPERATOR_NAMES)
def test_threads_and_reordering_make_no_difference_to_the_bits(operator: OperatorName, monkeypatch: pytest.MonkeyPatch) -> None:
    """One thread, all threads, and new numbers for a mesh in random order give the same bits."""
    vertices, faces, _ = renumbered(noisy(tube(40, 30), 0.01))
    # A non-manifold and an unused vertex too.
    vertices = np.concatenate([vertices, [[5.0, 5, 5], [6.0, 5, 5]]])
    faces = np.concatenate([faces, [[faces[0, 0], faces[0, 1], len(vertices) - 1]]]).astype(np.int32)
    step = safe_step((vertices, faces), operator, 0.2)
    movable = np.random.default_rng(0).random(len(vertices)) < 0.8
    results, named = [], []
    for threads, reordered in ((1, False), (2, False), (1, True), (2, True)):
        if threads > allowed_threads():
            continue
        monkeypatch.setattr(parallel, "SERIAL_BELOW", 0)
        monkeypatch.setattr(ordering, "FITS_IN_CACHE", 0 if reordered else 10**9)
        monkeypatch.setattr(ordering, "NEAR", 0)
        monkeypatch.setattr(ordering, "_SWEEPS_A_REORDERING_COSTS", 0)
        before = allowed_threads()
        set_threads(threads)
        try:
            results.append(
                explicit_smoothing(vertices, faces, operator=operator, step=step, iterations=4, border="free", movable=movable)
            )
            if operator not in NORMALISED:
                with pytest.raises(UnstableStepError) as caught:
                    explicit_smoothing(vertices, faces, operator=operator, step=1e3, border="free")
                named.append(caught.value.largest_stable)
        finally:
            set_threads(before)
    assert len({r.tobytes() for r in results}) == 1
    assert (np.abs(results[0] - vertices).max(axis=1) > 0).sum() > 0.7 * len(vertices)
    assert len(set(named)) <= 1


def test_geo_referenced_meshes_lose_nothing() -> None:
    """At offsets of 5e6 the result is that at the origin to one rounding of the coordinates, 5e-10, after 50 steps."""
    vertices, faces = noisy(icosphere(3), 0.01)
    offset = np.array([512_345.25, 5_487_654.5, 312.125])
    moved = vertices + offset
    # The offset rounds the input too, so start from what is left of it.
    plain = explicit_smoothing(moved - offset, faces, operator="cotangent", iterations=50)
    np.testing.assert_allclose(explicit_smoothing(moved, faces, operator="cotangent", iterations=50) - offset, plain, atol=1e-9)


@pytest.mark.parametrize("operator", OPERATOR_NAMES)
@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_come_out_finite(name: str, operator: OperatorName) -> None:
    """Ten steps: no NaN, no vertex beyond the diagonal, and what no triangle uses keeps every bit, under every policy."""
    vertices, faces = AWKWARD[name]()
    unused = ~topology.referenced_vertices(faces, len(vertices))
    for border in BORDER_POLICIES:
        step = 0.5
        if operator not in NORMALISED:
            try:
                explicit_smoothing(vertices, faces, operator=operator, step=1e300, iterations=1, border=border)
            except UnstableStepError as error:
                step = 0.1 * error.largest_stable
        try:
            found = explicit_smoothing(vertices, faces, operator=operator, step=step, iterations=10, border=border)
        except UnstableStepError:
            # Shrinking may make the step too long: an error is an answer, and an earlier end has one.
            found = explicit_smoothing(vertices, faces, operator=operator, step=step, iterations=1, border=border)
        assert np.isfinite(found).all()
        if len(vertices):
            assert np.linalg.norm(found / 2 - vertices / 2, axis=1).max() <= diagonal(vertices / 2)
        assert found[unused].tobytes() == vertices[unused].tobytes()


def test_scans_with_unreferenced_vertices_and_borders_are_respected() -> None:
    """In a raw range map the unreferenced vertices, and the border when it is fixed, keep every bit, and all is finite."""
    vertices, faces = sample("rangemaps/face000.ply")
    still = ~topology.referenced_vertices(faces, len(vertices))
    assert still.sum() == 667
    for operator in NORMALISED:
        found = explicit_smoothing(vertices, faces, operator=operator, border="fixed")
        kept = still | topology.border_vertices(faces, len(vertices))
        assert found[kept].tobytes() == vertices[kept].tobytes()
        assert np.isfinite(found).all()
        assert np.abs(found - vertices)[~kept].max() < 0.05 * diagonal(vertices)


def test_cotangent_steps_of_one_do_not_blow_up_on_obtuse_scans() -> None:
    """200 full steps on the cow, 16 % of whose edges have negative weights, decrease the area with every one."""
    vertices, faces = sample("cow.obj")
    areas = [area(vertices, faces)]
    for _ in range(200):
        vertices = explicit_smoothing(vertices, faces, operator="cotangent", step=1.0, iterations=1)
        areas.append(area(vertices, faces))
    assert (np.diff(areas) < 0).all()


# ---------------------------------------------------------------------------------------------------------------- point clouds


def test_a_point_cloud_is_smoothed_by_the_robust_operator() -> None:
    """A noisy plane without triangles gets flatter, and points that may not move stay."""
    rng = np.random.default_rng(4)
    points = np.column_stack([rng.random((400, 2)), rng.normal(0, 0.01, 400)])
    faces = np.empty((0, 3), dtype=np.int32)
    with pytest.raises(UnstableStepError) as caught:
        explicit_smoothing(points, faces, operator="robust", step=10.0)
    movable = np.arange(400) >= 10
    step = 0.5 * caught.value.largest_stable
    found = explicit_smoothing(points, faces, operator="robust", step=step, iterations=80, movable=movable)
    assert found[movable, 2].std() < 0.5 * points[movable, 2].std()
    assert found[:10].tobytes() == points[:10].tobytes()


def test_clouds_without_enough_points_or_with_another_operator_are_errors() -> None:
    """The message says which operator takes a cloud, and how many points it takes at least."""
    points = np.random.default_rng(0).random((20, 3))
    with pytest.raises(
        FilterInputError, match="operator 'uniform' needs triangles and there are none; only 'robust' takes point clouds"
    ):
        explicit_smoothing(points, [])
    with pytest.raises(
        FilterInputError, match=r"a point cloud of 20 distinct points has fewer than 30 neighbours for each point: .* at least 31"
    ):
        explicit_smoothing(points, [], operator="robust", step=1e-3)


# ------------------------------------------------------------------------------------------------------------------ parameters


def test_progress_is_told_after_every_step_and_may_stop_the_work() -> None:
    """The share of the work done is reported after each iteration; an exception from there ends the work."""
    vertices, faces = icosphere(1)
    told: list[float] = []
    explicit_smoothing(vertices, faces, iterations=4, progress=told.append)
    assert told == [0.25, 0.5, 0.75, 1.0]

    def stop(done: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        explicit_smoothing(vertices, faces, progress=stop)


def test_nothing_to_do_returns_a_copy() -> None:
    """No iterations, no vertices: the same bits in a new array; the input is never written to."""
    vertices, faces = icosphere(1)
    found = explicit_smoothing(vertices, faces, iterations=0)
    assert found is not vertices
    assert found.tobytes() == vertices.tobytes()
    assert explicit_smoothing([], []).shape == (0, 3)
    assert explicit_smoothing([], [], operator="robust").shape == (0, 3)
    locked = vertices.copy()
    locked.flags.writeable = False
    explicit_smoothing(locked, faces)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"step": 0.0}, "step is 0.0: it must be above 0 and at most 1, for the operator 'uniform'"),
        ({"step": 1.01}, "step is 1.01: it must be above 0 and at most 1"),
        (
            {"step": -0.5, "operator": "laplace_beltrami"},
            "step is -0.5: it must be finite and above 0, for the operator 'laplace_beltrami'",
        ),
        ({"step": float("nan")}, "step is nan: it must be above 0"),
        ({"step": float("inf"), "operator": "robust"}, "step is inf: it must be finite"),
        ({"iterations": -1}, "iterations is -1: it must be a whole number of at least 0"),
        ({"iterations": 1.5}, "iterations is 1.5"),
        ({"operator": "umbrella"}, "operator 'umbrella' is not one of 'uniform', 'inverse_length'"),
        ({"border": "open"}, "border 'open' is not one of 'fixed', 'along', 'free'"),
        ({"update": "jacobi"}, "update 'jacobi' is not one of 'euler', 'meshlab'"),
        (
            {"update": "meshlab", "operator": "robust"},
            "MeshLab's update rule is defined for the operators 'uniform' and 'cotangent', not 'robust'",
        ),
        ({"movable": [True]}, r"movable must be a boolean array of 42 values, one per vertex, got shape \(1,\)"),
        ({"movable": [1] * 42}, "movable must be a boolean array .* of int64"),
    ],
)
def test_parameters_are_checked(options: dict[str, object], message: str) -> None:
    """What is out of range is an error that names the parameter, the value and what is allowed."""
    with pytest.raises(FilterInputError, match=message):
        explicit_smoothing(*icosphere(1), **options)  # type: ignore[arg-type]
