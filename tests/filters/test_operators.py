"""The Laplace operators: closed forms, definitions written out, invariances, and libigl."""

from __future__ import annotations

import itertools
import math
from typing import Any

import igl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pymeshfair.filters import topology
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.operators import (
    OPERATOR_NAMES,
    OperatorName,
    build_laplacian,
    cotangent_laplacian,
    cotangent_stiffness,
    inverse_length_laplacian,
    laplace_beltrami,
    mixed_voronoi_areas,
    scale_dependent_laplacian,
    uniform_laplacian,
)
from tests.meshes import (
    AWKWARD,
    Mesh,
    area,
    cube,
    grid,
    icosphere,
    irregular_grid,
    noisy,
    renumbered,
    rotation,
    sample,
    single_triangle,
    tetrahedron,
    torus,
    tube,
    with_caps,
)

Floats = NDArray[np.float64]

# The mollification of "robust" moves edge lengths by up to 1e-5 of the mean edge, and its entries by about as much.
MOLLIFIED = 1e-4
NORMALISED: tuple[OperatorName, ...] = ("uniform", "inverse_length", "cotangent")


@st.composite
def any_mesh(draw: st.DrawFn) -> Mesh:
    """Any triples of up to eight vertices on a small lattice: coincident, collinear, non-manifold, repeated."""
    n = draw(st.integers(1, 8))
    coordinate = st.sampled_from([-2.0, -1.0, 0.0, 1e-7, 0.5, 1.0, 3.0])
    vertices = np.array(draw(st.lists(st.tuples(*[coordinate] * 3), min_size=n, max_size=n)))
    triple = st.tuples(*[st.integers(0, n - 1)] * 3)
    return vertices, np.array(draw(st.lists(triple, min_size=1, max_size=12)), dtype=np.int32)


def plain_weights(mesh: Mesh, operator: str) -> tuple[Floats, Floats]:
    """Dense weights and masses, straight from the definitions, for meshes without degenerate parts."""
    vertices, faces = mesh
    n = len(vertices)
    weights = np.zeros((n, n))
    areas = np.zeros(n)
    for face in faces:
        for k in range(3):
            i, j, o = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
            u, v = vertices[i] - vertices[o], vertices[j] - vertices[o]
            cotangent = u @ v / np.linalg.norm(np.cross(u, v))
            if operator in ("cotangent", "laplace_beltrami"):
                weights[i, j] += cotangent / 2
                weights[j, i] += cotangent / 2
            else:
                length = np.linalg.norm(vertices[i] - vertices[j])
                weights[i, j] = weights[j, i] = 1.0 if operator == "uniform" else 1.0 / length
        sides = np.linalg.norm(vertices[np.roll(face, -1)] - vertices[np.roll(face, -2)], axis=1)
        angles = np.arccos((sum(sides**2) - 2 * sides**2) / (2 * np.prod(sides) / sides))
        size = np.linalg.norm(np.cross(vertices[face[1]] - vertices[face[0]], vertices[face[2]] - vertices[face[0]])) / 2
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            if angles.max() > math.pi / 2:
                areas[face[k]] += size / (2 if angles[k] > math.pi / 2 else 4)
            else:
                areas[face[k]] += (sides[b] ** 2 / math.tan(angles[b]) + sides[a] ** 2 / math.tan(angles[a])) / 8
    if operator == "laplace_beltrami":
        return weights, areas
    if operator == "scale_dependent":
        return weights, np.divide(1.0, weights, out=np.zeros_like(weights), where=weights > 0).sum(axis=1) / 2
    return weights, np.abs(weights).sum(axis=1)


@pytest.mark.parametrize("operator", ["uniform", "inverse_length", "scale_dependent", "cotangent", "laplace_beltrami"])
@pytest.mark.parametrize(
    "mesh",
    [noisy(icosphere(1), 0.1), irregular_grid(), cube(), tube(6, 2)],
    ids=["noisy sphere", "irregular grid", "cube", "tube"],
)
def test_operators_are_their_definitions(operator: OperatorName, mesh: Mesh) -> None:
    """Every entry of stiffness and mass is that of the definition written out face by face, to rounding (1e-13)."""
    weights, masses = plain_weights(mesh, operator)
    laplacian = build_laplacian(*mesh, operator)
    np.testing.assert_allclose(laplacian.stiffness.toarray(), weights - np.diag(weights.sum(axis=1)), atol=1e-13)
    np.testing.assert_allclose(laplacian.mass, masses, rtol=1e-13)


@pytest.mark.parametrize(
    "mesh",
    [noisy(icosphere(3), 0.02), irregular_grid(20, 20, amount=0.45), torus(), sample("cow.obj")],
    ids=["noisy sphere", "irregular grid", "torus", "cow"],
)
def test_cotangents_and_areas_are_those_of_libigl(mesh: Mesh) -> None:
    """Stiffness and mixed Voronoi areas equal igl.cotmatrix and igl.massmatrix, to 1e-12 of their largest."""
    vertices, faces = mesh
    expected = igl.cotmatrix(vertices, faces)
    assert abs(cotangent_stiffness(vertices, faces) - expected).max() <= 1e-12 * abs(expected).max()
    ours = mixed_voronoi_areas(vertices, faces)
    theirs = igl.massmatrix(vertices, faces, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    np.testing.assert_allclose(ours, theirs, atol=1e-12 * theirs.max())
    assert ours.sum() == pytest.approx(area(vertices, faces), rel=1e-12)


def test_closed_forms_on_one_triangle() -> None:
    """On the triangle 3, 4, 5 the cotangents are 0, 3/4 and 4/3; the right corner owns half the area 6, the others a quarter."""
    laplacian = laplace_beltrami(*single_triangle())
    expected = np.array([[-(3 / 8 + 4 / 6), 4 / 6, 3 / 8], [4 / 6, -4 / 6, 0], [3 / 8, 0, -3 / 8]])
    # The angle at vertex 1 (3, 0) has cotangent 3/4 and weighs the edge (0, 2); that at vertex 2 has 4/3 and weighs (0, 1).
    np.testing.assert_allclose(laplacian.stiffness.toarray(), expected, rtol=1e-15, atol=1e-16)
    np.testing.assert_allclose(laplacian.mass, [3.0, 1.5, 1.5], rtol=1e-15)


def test_closed_forms_on_the_tetrahedron() -> None:
    """Each operator of the regular tetrahedron shrinks it towards the centre at the rate of its closed form."""
    vertices, faces = tetrahedron()
    edge = 2 * math.sqrt(2)
    triangle = math.sqrt(3) / 4 * edge**2
    rates = {
        "uniform": 4 / 3,
        "inverse_length": 4 / 3,
        "cotangent": 4 / 3,
        "scale_dependent": 4 / edge / (3 * edge / 2),
        "laplace_beltrami": 4 / math.sqrt(3) / triangle,
        "robust": 4 / math.sqrt(3) / triangle,
    }
    for operator, rate in rates.items():
        laplacian = build_laplacian(vertices, faces, operator)  # type: ignore[arg-type]
        np.testing.assert_allclose(laplacian.apply(vertices), -rate * vertices, rtol=MOLLIFIED if operator == "robust" else 1e-14)


@given(any_mesh(), st.sampled_from(OPERATOR_NAMES))
def test_every_mesh_has_a_symmetric_stiffness_whose_rows_sum_to_zero(mesh: Mesh, operator: OperatorName) -> None:
    """Whatever the mesh: C finite, symmetric, rows sum to 0 within rounding of their largest entry; M finite, not negative."""
    laplacian = build_laplacian(*mesh, operator)
    stiffness = laplacian.stiffness.toarray()
    assert np.isfinite(stiffness).all()
    assert np.isfinite(laplacian.mass).all()
    assert (laplacian.mass >= 0).all()
    assert np.isfinite(laplacian.matrix().toarray()).all()
    largest = np.abs(stiffness).max(initial=0.0)
    if operator == "robust":
        assert np.abs(stiffness - stiffness.T).max() <= 1e-12 * largest
    else:
        assert np.array_equal(stiffness, stiffness.T)
    assert np.abs(stiffness.sum(axis=1)).max() <= 1e-14 * len(mesh[1]) * largest
    assert np.linalg.eigvalsh(stiffness).max() <= 1e-12 * max(largest, 1.0)
    unused = ~topology.referenced_vertices(mesh[1], len(mesh[0]))
    assert not stiffness[unused].any()
    assert not laplacian.mass[unused].any()


@given(any_mesh(), st.sampled_from(OPERATOR_NAMES))
def test_the_spectral_bound_is_one(mesh: Mesh, operator: OperatorName) -> None:
    """No eigenvalue of -L exceeds Gershgorin's bound, and that of a normalised operator does not exceed 2."""
    laplacian = build_laplacian(*mesh, operator)
    bound = laplacian.spectral_bound()
    root = np.sqrt(laplacian.inverse_mass)
    largest = -np.linalg.eigvalsh(root[:, None] * laplacian.stiffness.toarray() * root).min()
    assert largest <= bound * (1 + 1e-12)
    if operator in NORMALISED:
        assert bound <= 2 + 1e-13


@pytest.mark.parametrize("operator", OPERATOR_NAMES)
def test_rotation_place_scale_and_order_make_no_difference(operator: OperatorName) -> None:
    """A turned, moved, scaled and renumbered mesh has the same operator, turned, and scaled where it has a unit."""
    vertices, faces = noisy(icosphere(2), 0.05)
    image = build_laplacian(vertices, faces, operator).apply(vertices)
    scale, turn, shift = 37.0, rotation(), np.array([100.0, -50.0, 20.0])
    new_vertices, new_faces, order = renumbered((scale * vertices @ turn.T + shift, faces))
    expected = (image @ turn.T)[order] * (scale if operator in NORMALISED else 1 / scale)
    found = build_laplacian(new_vertices, new_faces, operator).apply(new_vertices)
    # Coordinates of 1e2 known to 1e-14 leave differences of 1e-12 in edges of length 10, and the operator sums up a few.
    tolerance = 1e-9 if operator == "robust" else 1e-12
    np.testing.assert_allclose(found, expected, atol=tolerance * np.abs(expected).max() * 10)


@pytest.mark.parametrize("size", [1e-150, 1e-30, 1e30, 1e150])
@pytest.mark.parametrize("operator", OPERATOR_NAMES)
def test_size_makes_no_difference_at_the_ends_of_the_number_line(operator: OperatorName, size: float) -> None:
    """Meshes of 1e-150 and 1e150 units have the operator of the same mesh in ordinary units."""
    vertices, faces = noisy(icosphere(1), 0.05)
    ordinary, extreme = build_laplacian(vertices, faces, operator), build_laplacian(vertices * size, faces, operator)
    expected = ordinary.apply(vertices)
    found = extreme.apply(vertices * size) * (1 / size if operator in NORMALISED else size)
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_far_from_the_origin_nothing_is_lost_but_the_coordinates_digits() -> None:
    """At geo-referenced offsets of 5e6 the cotangents of a mesh with edges of 0.3 change by less than 1e-7."""
    vertices, faces = icosphere(2)
    # The coordinates themselves are rounded to 1e-9, which turns an edge of 0.3 by 3e-9 and a weight by some ten times that.
    moved = vertices + np.array([5e5, 5.5e6, 300.0])
    assert abs(cotangent_stiffness(moved, faces) - cotangent_stiffness(vertices, faces)).max() < 1e-7


@pytest.mark.parametrize("operator", ["cotangent", "laplace_beltrami", "robust"])
def test_a_flat_mesh_has_no_laplacian_inside(operator: OperatorName) -> None:
    """L p = 0 at interior vertices of a flat irregular mesh, negative weights included."""
    vertices, faces = irregular_grid(amount=0.45)
    laplacian = build_laplacian(vertices, faces, operator)
    inside = ~topology.border_vertices(faces, len(vertices))
    if operator != "robust":
        off_diagonal = laplacian.stiffness - np.diag(laplacian.stiffness.diagonal())
        assert off_diagonal.min() < -0.1, "the mesh is meant to have negative weights"
    # "robust" turns the edges of the plane's triangulation, mollified by 1e-5.
    assert np.abs(laplacian.apply(vertices))[inside].max() < (1e-3 if operator == "robust" else 1e-11)


def test_a_flat_mesh_has_a_uniform_laplacian() -> None:
    """The uniform operator moves the vertices of a flat irregular mesh within its plane."""
    vertices, faces = irregular_grid()
    image = uniform_laplacian(faces, len(vertices)).apply(vertices)
    inside = ~topology.border_vertices(faces, len(vertices))
    assert np.abs(image[inside]).max() > 0.1
    assert not image[:, 2].any()


def test_a_straight_uneven_polyline_has_no_inverse_length_laplacian() -> None:
    """On a straight polyline with steps from 0.001 to 9, L p = 0 inside for inverse length and arc length, not for uniform."""
    steps = np.array([1.0, 0.001, 9.0, 0.3, 2.0, 0.05, 4.0])
    vertices = np.outer(np.concatenate([[0.0], np.cumsum(steps)]), [1.0, -2.0, 0.5])
    edges = np.column_stack([np.arange(7), np.arange(1, 8)]).astype(np.int32)
    assert np.abs(inverse_length_laplacian(vertices, edges).apply(vertices)[1:-1]).max() < 1e-12
    # Divided by half the length of the edges beside it, 0.5 at the shortest, and with weights of up to 500.
    assert np.abs(scale_dependent_laplacian(vertices, edges).apply(vertices)[1:-1]).max() < 1e-10
    assert np.abs(uniform_laplacian(edges, 8).apply(vertices)[1:-1]).max() > 1.0


@pytest.mark.parametrize("n", [5, 12])
def test_a_closed_polygon_has_the_spectrum_of_the_circle(n: int) -> None:
    """The uniform operator of an n-gon has the eigenvalues cos(2 pi floor(i/2) / n) - 1."""
    polygon = np.column_stack([np.arange(n), np.roll(np.arange(n), -1)]).astype(np.int32)
    found = np.sort(np.linalg.eigvals(uniform_laplacian(polygon, n).matrix().toarray()).real)[::-1]
    np.testing.assert_allclose(found, [math.cos(2 * math.pi * ((i + 1) // 2) / n) - 1 for i in range(n)], atol=1e-14)


def test_uniform_eigenvalues_end_at_three_halves_where_every_edge_has_two_triangles() -> None:
    """The eigenvalues of -L lie in [0, 3/2] on closed manifold meshes, and reach it on the octahedron."""
    octahedron = np.array(
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]], dtype=np.int32
    )
    for faces in (octahedron, tetrahedron()[1], icosphere(1)[1], torus(9, 6)[1]):
        values = np.linalg.eigvals(uniform_laplacian(faces, int(faces.max()) + 1).matrix().toarray()).real
        assert values.max() < 1e-14
        assert values.min() > -1.5 - 1e-13
    assert np.linalg.eigvals(uniform_laplacian(octahedron, 6).matrix().toarray()).real.min() == pytest.approx(-1.5)


def test_on_a_sphere_laplace_beltrami_tends_to_twice_the_curvature() -> None:
    """L p -> -2 p / r^2 on finer icospheres: first order in the edge length at the worst vertex, 1.4 in the mean square.

    The neighbours of most vertices of valence 6 are not symmetric about them: the worst error only halves when the edges do.
    """
    radius = 3.0
    errors = []
    for level in (2, 3, 4):
        vertices, faces = icosphere(level, radius)
        image = laplace_beltrami(vertices, faces).apply(vertices)
        error = np.linalg.norm(image + 2 * vertices / radius**2, axis=1) * radius
        errors.append((error.max(), math.sqrt((error**2).mean())))
    for (worst, mean), (next_worst, next_mean) in itertools.pairwise(errors):
        assert 1.9 < worst / next_worst < 2.1
        assert 2 ** (4 / 3) - 0.4 < mean / next_mean < 2**1.5
    assert errors[-1][0] < 0.01


def test_valence_five_is_exact_with_mixed_areas_and_never_with_thirds() -> None:
    """At valence 5 mixed Voronoi areas give -2 p / r^2 by symmetry; thirds of triangles stay off by 3 / (4 cos^2 36)."""
    for level in (2, 4):
        vertices, faces = icosphere(level)
        five = np.arange(12)
        stiff = (cotangent_stiffness(vertices, faces) @ vertices)[five]
        mixed = mixed_voronoi_areas(vertices, faces)[five]
        thirds = igl.massmatrix(vertices, faces, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()[five]
        # 1e-12: a ratio of sums that cancel to the square of an edge, 0.07 at the finest.
        np.testing.assert_allclose(stiff / mixed[:, None], -2 * vertices[five], atol=1e-12)
        # Flat stars have that ratio; those of an icosphere come within the square of an edge of it.
        edge = mean_edge_length(vertices, faces)
        np.testing.assert_allclose(mixed / thirds, 3 / (4 * math.cos(math.pi / 5) ** 2), atol=edge**2)


def test_mean_curvature_converges_on_a_torus_and_is_exact_on_a_cylinder() -> None:
    """|L p| = 2 H: second order on a torus of (R + 2 r cos v) / (r (R + r cos v)); to rounding on a cylinder's inner vertices."""
    errors = []
    for n in (12, 24, 48):
        vertices, faces = torus(2 * n, n, 2.0, 0.7)
        cosine = np.cos(2 * np.pi * np.tile(np.arange(n), 2 * n) / n)
        curvature = (2.0 + 1.4 * cosine) / (0.7 * (2.0 + 0.7 * cosine))
        image = laplace_beltrami(vertices, faces).apply(vertices)
        errors.append(np.abs(np.linalg.norm(image, axis=1) - curvature).max())
    assert 3.5 < errors[0] / errors[1] < 4.5
    assert 3.5 < errors[1] / errors[2] < 4.5
    vertices, faces = tube(12, 6, radius=2.0)
    inside = ~topology.border_vertices(faces, len(vertices))
    image = laplace_beltrami(vertices, faces).apply(vertices)
    np.testing.assert_allclose(image[inside], -(vertices * [1, 1, 0] / 4.0)[inside], atol=1e-12)


def test_obtuse_triangles_slow_the_normalised_operator_down_and_nothing_else() -> None:
    """Where no weight is negative the mass is the sum of the weights; elsewhere it is larger, by twice the negative ones."""
    vertices, faces = irregular_grid(amount=0.45)
    laplacian = cotangent_laplacian(vertices, faces)
    dense = laplacian.stiffness.toarray()
    np.fill_diagonal(dense, 0.0)
    negative = -np.minimum(dense, 0.0).sum(axis=1)
    np.testing.assert_allclose(laplacian.mass, dense.sum(axis=1) + 2 * negative, rtol=1e-13)
    assert (negative == 0).any()
    assert (negative > 0).any()


@pytest.mark.parametrize("height", [1e-3, 1e-6, 1e-8, 1e-9, 1e-10])
def test_thin_caps_keep_the_cotangents_semidefinite(height: float) -> None:
    """However thin a cap, no eigenvalue of C is positive beyond what computing eigenvalues costs: n eps times the largest."""
    vertices, faces = with_caps(height)
    eigenvalues = np.linalg.eigvalsh(cotangent_stiffness(vertices, faces).toarray())
    assert eigenvalues[-1] <= len(vertices) * np.finfo(float).eps * -eigenvalues[0]


def test_short_edges_pull_like_the_shortest_that_counts() -> None:
    """An edge of length 0 gets the weight of one of a millionth of the mean, 1/3 here, so that its ends stay together."""
    vertices = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0]])
    path = np.array([[0, 1], [1, 2], [2, 3]], dtype=np.int32)
    stiffness = inverse_length_laplacian(vertices, path).stiffness.toarray()
    assert stiffness[1, 2] == pytest.approx(1e6 * 3, rel=1e-12)
    assert stiffness[0, 1] == 1.0


@pytest.mark.parametrize("operator", OPERATOR_NAMES)
@pytest.mark.parametrize("name", [name for name in AWKWARD if name != "empty"])
def test_awkward_meshes_have_finite_operators(name: str, operator: OperatorName) -> None:
    """Stiffness, mass and L p of every awkward mesh are finite, and L is 0 at vertices that no triangle uses."""
    vertices, faces = AWKWARD[name]()
    laplacian = build_laplacian(vertices, faces, operator)
    assert np.isfinite(laplacian.stiffness.data).all()
    assert np.isfinite(laplacian.mass).all()
    image = laplacian.apply(vertices)
    assert np.isfinite(image).all()
    assert not image[~topology.referenced_vertices(faces, len(vertices))].any()


def test_names_are_checked_and_clouds_take_the_robust_operator() -> None:
    """An unknown operator is an error that lists the known ones; points without faces have the operator "robust" alone."""
    vertices, faces = icosphere(2)
    with pytest.raises(FilterInputError, match="operator 'umbrella' is not one of 'uniform', 'inverse_length'"):
        build_laplacian(vertices, faces, "umbrella")  # type: ignore[arg-type]
    with pytest.raises(FilterInputError, match="operator 'uniform' needs triangles and there are none"):
        build_laplacian(vertices, faces[:0], "uniform")
    assert build_laplacian(vertices, faces[:0], "robust").mass.sum() > 0


def test_an_operator_applies_to_one_value_or_several() -> None:
    """L of (n,) and of (n, 2) values is the product with the matrix L."""
    vertices, faces = noisy(icosphere(1), 0.1)
    laplacian = laplace_beltrami(vertices, faces)
    values: Any = np.random.default_rng(0).normal(size=(len(vertices), 2))
    dense = laplacian.matrix().toarray()
    np.testing.assert_allclose(laplacian.apply(values), dense @ values, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(laplacian.apply(values[:, 0]), dense @ values[:, 0], rtol=1e-12, atol=1e-12)
    assert grid()[1].dtype == np.int32
