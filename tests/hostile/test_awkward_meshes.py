"""Meshes as no scanner should write them, through every filter; benchmarks/hostile_meshes.py tries two thousand of them."""

from __future__ import annotations

import tracemalloc
from collections.abc import Mapping
from typing import Any

import numpy as np
import pymeshlab
import pytest

import pymeshfair
from pymeshfair.declaration import Filter
from pymeshfair.errors import PymeshfairError
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.fairing import bilaplacian_smoothing, fair_region
from pymeshfair.filters.holes import close_holes
from pymeshfair.filters.mesh import check_healthy, spikes
from pymeshfair.filters.operators import surface_laplacian
from pymeshfair.filters.spectral import spectral_filter
from pymeshfair.registry import custom_filters
from tests.contracts.variants import each_filter
from tests.meshes import Floats, icosphere

from .awkward import awkward_mesh
from .every_filter import complaint_about

#: as many as fit into a few seconds: the choice of parameters alone takes a tenth of a second on each
NUMBERS = (3, 14, 23, 54, 106, 644)


@each_filter
def test_filters_end_well_or_refuse(declared: Filter) -> None:
    """No NaN, no vertex beyond two diagonals, no raw error of Python and no warning of NumPy, whatever the mesh."""
    values = {"choice": "fixed"} if any(p.name == "choice" for p in declared.parameters) else {}
    for number in NUMBERS:
        harms, mesh = awkward_mesh(number)
        assert complaint_about(declared, mesh, values) is None, f"mesh {number}: {harms}"


@pytest.mark.parametrize(
    ("filter_name", "number"),
    [
        ("apply_coord_bilateral_fleishman", 8040),
        ("apply_coord_bilateral_jones", 8040),
        ("apply_coord_bilateral_projection_of_points", 8063),
    ],
)
def test_heights_below_rounding_are_no_noise(filter_name: str, number: int) -> None:
    """Of heights of 1e-201 the square is 0, by which a kernel divided in compiled code; nothing is to be removed there."""
    (declared,) = (f for f in custom_filters() if f.python_name == filter_name)
    assert complaint_about(declared, awkward_mesh(number)[1], {"range_kernel": "lorentzian"}) is None


@pytest.mark.parametrize("number", [8156, 8193, 8201])
def test_regions_with_faces_that_name_a_vertex_twice(number: int) -> None:
    """A vertex that only such a face uses belongs to no component, and is no part of a region that is remade."""
    (declared,) = (f for f in custom_filters() if f.python_name == "apply_coord_region_fairing")
    assert complaint_about(declared, awkward_mesh(number)[1], {"remesh": True}) is None


@pytest.mark.parametrize(
    ("filter_name", "values"),
    [
        ("apply_coord_explicit_smoothing", {"operator": "scale_dependent"}),
        ("apply_coord_explicit_smoothing", {"operator": "robust"}),
        ("apply_coord_implicit_fairing", {"time_step": 1.0}),
    ],
)
@pytest.mark.parametrize("exponent", [-600, 600])
def test_steps_in_squared_edges_of_any_unit(filter_name: str, values: Mapping[str, Any], exponent: int) -> None:
    """Time steps in squared edges are refused where the square of an edge overflows or is 0."""
    vertices, faces = icosphere(1)
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.ldexp(vertices, exponent), faces))
    with pytest.raises(PymeshfairError, match=r"is too (short|long) to be squared: scale the mesh"):
        meshes.apply_filter(filter_name, **values)


@pytest.mark.parametrize("number", [97, 109, 196, 366, 378, 390, 446, 489])
def test_region_fairing_throws_no_vertex_out(number: int) -> None:
    """On triangles so uneven that the surface's own equations threw a vertex out by up to a million diagonals, none goes far.

    It is said for how many vertices their connectivity had to do; fixed vertices keep every bit.
    """
    _, (vertices, faces) = awkward_mesh(number)
    free = np.random.default_rng(number).random(len(vertices)) < 0.4
    found = fair_region(vertices, faces, free, energy="minimum_variation")
    assert found.irregular > 0
    np.testing.assert_array_equal(found.vertices[~found.free], vertices[~found.free])
    assert _furthest(vertices, found.vertices) <= 2.0


@pytest.mark.parametrize("number", [71, 79, 127, 130, 177, 275, 42, 82])
def test_smoothing_throws_no_vertex_out(number: int) -> None:
    """The same for surfaces of least bending whose border is free; where the equations have no solution, this is said."""
    _, (vertices, faces) = awkward_mesh(number)
    told: list[int] = []
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    found = bilaplacian_smoothing(vertices, faces, detail_size=3 * size, border="free", on_irregular=told.append)
    assert _furthest(vertices, found) <= 2.0
    assert len(told) <= 1


def _furthest(before: Floats, after: Floats) -> float:
    """How far the furthest vertex went, in diagonals."""
    unit = np.abs(before).max()
    lengths = np.linalg.norm(after / unit - before / unit, axis=1)
    return float(lengths.max() / np.linalg.norm(np.ptp(before / unit, axis=0)))


def test_what_is_regular_stays_as_it_was() -> None:
    """Beside a part whose triangles throw vertices out, another part is smoothed as it is by itself, but for rounding.

    Both parts are smoothed twice, and the reported share does not fall.
    """
    _, bad = awkward_mesh(275)
    diagonal = float(np.linalg.norm(np.ptp(bad[0], axis=0)))
    good = icosphere(2)[0] * 0.1 * diagonal + bad[0].mean(axis=0), icosphere(2)[1]
    both = np.concatenate([good[0], bad[0]]), np.concatenate([good[1], bad[1] + len(good[0])])
    told: list[int] = []
    shares: list[float] = []
    found = bilaplacian_smoothing(
        *both, detail_size=3 * diagonal, border="free", on_irregular=told.append, progress=shares.append
    )
    assert told == [len(np.unique(bad[1]))]
    assert shares == sorted(shares)
    alone = bilaplacian_smoothing(*good, detail_size=3 * diagonal, border="free")
    np.testing.assert_allclose(found[: len(good[0])], alone, rtol=0, atol=1e-9 * diagonal)


def test_a_spike_is_refused_by_its_vertex() -> None:
    """A vertex beyond two diagonals, or at no number, is an error that names it."""
    before = np.zeros((3, 3))
    for x in (2.1, np.nan, np.inf):
        after = before.copy()
        after[1, 0] = x
        with pytest.raises(FilterInputError, match=r"vertex 1 would be moved by .* diagonals"):
            check_healthy(before, after, 1.0)
        np.testing.assert_array_equal(spikes(before, after, 1.0), [False, True, False])


def test_holes_beside_faces_that_name_a_vertex_twice() -> None:
    """A vertex that only such a face uses belongs to no component, which is no reason to fail."""
    _, (vertices, faces) = awkward_mesh(23)
    assert close_holes(vertices, faces).new_faces.shape[1] == 3


@pytest.mark.parametrize("number", [6000, 6012])
def test_a_filling_stays_near_its_rim(number: int) -> None:
    """Beside a spike of a billion edges a thin plate left the rim by up to 230 diagonals, and 160,000 triangles followed it.

    Now the next lower energy places such a filling, which is said, and no new vertex is further out than one diagonal.
    """
    _, (vertices, faces) = awkward_mesh(number)
    filling = close_holes(vertices, faces)
    assert any(filling.thrown_out)
    for k, rim in enumerate(filling.closed):
        low, high = vertices[rim].min(axis=0), vertices[rim].max(axis=0)
        new = filling.new_vertices[filling.hole_of_vertex == k]
        outside = np.linalg.norm(np.maximum(np.maximum(low - new, new - high), 0.0), axis=1)
        assert outside.max(initial=0.0) <= np.linalg.norm(high - low)
        assert len(new) <= len(rim) ** 2  # edges are down to a quarter as long as at the rim
    assert all(not thrown or energy == "membrane" for thrown, energy in zip(filling.thrown_out, filling.energies, strict=True))


def test_thin_triangles_take_no_memory_in_spectral_filters() -> None:
    """A polynomial that would take longer than solving is not sampled: 1.6 million samples took 62 MB and more for 190 faces."""
    _, (vertices, faces) = awkward_mesh(6001)
    spectral_filter(vertices, faces, detail_size=0.5)  # what is loaded once does not count
    tracemalloc.start()
    try:
        found = spectral_filter(vertices, faces, detail_size=0.5)
        assert tracemalloc.get_traced_memory()[1] < 10e6
    finally:
        tracemalloc.stop()
    assert found.route == "rational"


def test_an_operator_without_numbers_is_refused() -> None:
    """Edges that differ in length by twenty orders of magnitude leave no cotangents."""
    _, (vertices, faces) = awkward_mesh(106)
    with pytest.raises(FilterInputError, match="orders of magnitude"):
        surface_laplacian(vertices, faces, "robust")
