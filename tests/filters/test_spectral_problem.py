"""The eigenproblem of a mesh: which operator, which vertices, which components."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.operators import SurfaceOperatorName, laplace_beltrami
from pymeshfair.filters.spectral import enhance_details, spectral_filter, spectrum
from pymeshfair.filters.spectral.problem import spectral_problem
from tests.meshes import AWKWARD, Mesh, area, book, grid, icosphere, two_spheres, with_caps, with_needles


def is_robust(mesh: Mesh, operator: SurfaceOperatorName) -> bool:
    """Whether the masses are those of the robust operator, thirds of areas instead of mixed Voronoi areas."""
    return np.array_equal(spectral_problem(*mesh, operator=operator).mass, spectral_problem(*mesh, operator="robust").mass)


def test_it_is_laplace_beltrami_with_the_sign_turned() -> None:
    """S = -C and M the mixed Voronoi areas, whose sum is the area; rows of S add up to 0."""
    vertices, faces = icosphere(3)
    problem, laplacian = spectral_problem(vertices, faces), laplace_beltrami(vertices, faces)
    assert (problem.dirichlet != -laplacian.stiffness).nnz == 0
    np.testing.assert_array_equal(problem.mass, laplacian.mass)
    assert problem.mass.sum() == pytest.approx(area(vertices, faces), rel=1e-13)
    assert np.abs(problem.dirichlet.sum(axis=1)).max() < 1e-13
    assert (problem.n_components, problem.n_vertices) == (1, len(vertices))


@pytest.mark.parametrize(
    ("name", "expected"),
    [("three pages", "robust"), ("thin caps", "robust"), ("needles", "robust"), ("two components", "cotangent")],
)
def test_auto_takes_the_robust_operator_where_it_must(name: str, expected: str) -> None:
    """Non-manifold edges and triangles next to no area call for it, other meshes do not."""
    assert is_robust(AWKWARD[name](), "auto") == (expected == "robust")


def test_an_operator_that_is_named_is_taken() -> None:
    """On good meshes "robust" is taken and on thin triangles "cotangent", if one says so."""
    assert not is_robust(icosphere(2), "auto")
    assert not is_robust(with_caps(1e-4), "cotangent")
    assert not is_robust(book(), "cotangent")


def test_unreferenced_vertices_have_no_part() -> None:
    """Rows stand for the vertices that triangles use, in their order."""
    vertices, faces = AWKWARD["isolated vertices"]()
    problem = spectral_problem(vertices, faces)
    np.testing.assert_array_equal(problem.vertices, np.arange(1, len(vertices) - 1))
    assert problem.n_vertices == len(vertices)
    assert problem.dirichlet.shape == (len(vertices) - 2, len(vertices) - 2)


def test_components_are_those_of_the_surface() -> None:
    """No entry of S joins two components, and they are counted from 0 in the order of their first vertex."""
    vertices, faces = two_spheres()
    problem = spectral_problem(vertices, faces)
    np.testing.assert_array_equal(problem.components, np.repeat([0, 1], len(vertices) // 2))
    entries = problem.dirichlet.tocoo()
    assert (problem.components[entries.row] == problem.components[entries.col]).all()


def test_a_component_without_area_has_no_part() -> None:
    """A component that is a point is left out by "cotangent", the others stay; all in one point leaves nothing."""
    vertices, faces = icosphere(2)
    both = np.concatenate([np.zeros((3, 3)), vertices]), np.concatenate([[[0, 1, 2]], faces + 3]).astype(np.int32)
    problem = spectral_problem(*both, operator="cotangent")
    np.testing.assert_array_equal(problem.vertices, np.arange(3, len(both[0])))
    assert problem.n_components == 1
    assert len(spectral_problem(*AWKWARD["all in one point"]()).mass) == 0


def test_a_vertex_without_area_is_refused_by_name() -> None:
    """A vertex all of whose triangles are degenerate has no mass: "cotangent" names it, "auto" can do with it."""
    vertices, faces = grid(3, 3)
    spike = np.concatenate([vertices, [[-1.0, 0.0, 0.0]]]), np.concatenate([faces, [[0, 1, len(vertices)]]]).astype(np.int32)
    with pytest.raises(FilterInputError, match=f"vertex {len(vertices)} has no area.*'robust'"):
        spectral_problem(*spike, operator="cotangent")
    assert (spectral_problem(*spike).mass > 0.0).all()


def test_a_vertex_without_area_has_its_number_in_the_mesh() -> None:
    """Neither vertices without a triangle nor components that may stay without area shift or take the number in the message."""
    vertices, faces = grid(3, 3)
    points = np.concatenate([np.zeros((6, 3)), vertices, [vertices[0]]])
    cells = np.concatenate([[[3, 4, 5]], faces + 6, [[6, 7, len(points) - 1]]]).astype(np.int32)
    for call in (partial(spectral_filter, detail_size=1.0), partial(spectrum, modes=0), enhance_details):
        with pytest.raises(FilterInputError, match=rf"vertex {len(points) - 1} has no area.*\(1 such vertices\)"):
            call(points, cells, operator="cotangent")


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_give_a_semidefinite_problem(name: str) -> None:
    """Whatever the mesh, S is symmetric and finite with nothing below 0 and the masses are above 0."""
    problem = spectral_problem(*AWKWARD[name]())
    assert np.isfinite(problem.dirichlet.data).all()
    assert (problem.mass > 0.0).all()
    if len(problem.mass):
        matrix = problem.dirichlet.toarray()
        size = np.abs(matrix).max()
        assert np.abs(matrix - matrix.T).max() <= 1e-12 * size
        assert np.linalg.eigvalsh(matrix).min() >= -1e-12 * size * len(matrix)


def test_what_is_no_operator_or_mesh_is_refused() -> None:
    """The message lists the operators."""
    with pytest.raises(FilterInputError, match="'auto', 'cotangent', 'robust'"):
        spectral_problem(*icosphere(1), operator="uniform")  # type: ignore[arg-type]
    with pytest.raises(FilterInputError, match="not finite"):
        spectral_problem(np.full((3, 3), np.nan), [[0, 1, 2]])


def test_edges_without_length_are_for_the_robust_operator() -> None:
    """Coincident vertices of a component with area get masses."""
    assert is_robust(with_needles(0.0), "auto")
    assert (spectral_problem(*with_needles(0.0)).mass > 0.0).all()
