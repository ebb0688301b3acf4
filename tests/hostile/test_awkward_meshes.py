"""Meshes as no scanner should write them, through every filter; benchmarks/hostile_meshes.py tries two thousand of them."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.declaration import Filter
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.fairing import bilaplacian_smoothing, fair_region
from pymeshfair.filters.holes import close_holes
from pymeshfair.filters.operators import surface_laplacian
from tests.contracts.variants import each_filter

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


def test_a_spike_is_refused_by_its_vertex() -> None:
    """Minimum variation may throw vertices far out between uneven triangles; the error names one and says what stays closer."""
    _, (vertices, faces) = awkward_mesh(97)
    free = np.random.default_rng(97).random(len(vertices)) < 0.4
    with pytest.raises(FilterInputError, match=r"vertex \d+ would be moved by .* diagonals .*; a thin plate or a membrane stays"):
        fair_region(vertices, faces, free, energy="minimum_variation")
    assert np.isfinite(fair_region(vertices, faces, free, energy="thin_plate").vertices).all()


def test_smoothing_may_not_throw_vertices_out() -> None:
    """The same for a surface of least bending whose border is free."""
    _, (vertices, faces) = awkward_mesh(127)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    with pytest.raises(FilterInputError, match=r"vertex \d+ would be moved by"):
        bilaplacian_smoothing(vertices, faces, detail_size=3 * size, border="free")


def test_holes_beside_faces_that_name_a_vertex_twice() -> None:
    """A vertex that only such a face uses belongs to no component, which is no reason to fail."""
    _, (vertices, faces) = awkward_mesh(23)
    assert close_holes(vertices, faces).new_faces.shape[1] == 3


def test_an_operator_without_numbers_is_refused() -> None:
    """Edges that differ in length by twenty orders of magnitude leave no cotangents."""
    _, (vertices, faces) = awkward_mesh(106)
    with pytest.raises(FilterInputError, match="orders of magnitude"):
        surface_laplacian(vertices, faces, "robust")
