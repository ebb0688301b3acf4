"""The bilateral filters of positions against loops over vertices, and what they must leave as it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pymeshfair.filters import topology
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.denoising.bilateral import bilateral_fleishman, bilateral_jones
from pymeshfair.filters.robust import KERNEL_NAMES, KernelName, weight
from tests.meshes import (
    AWKWARD,
    Mesh,
    cube,
    diagonal,
    grid,
    icosphere,
    noisy,
    rotation,
    tube,
)

Floats = NDArray[np.float64]
Filter = Callable[..., Floats]
FILTERS: list[Filter] = [bilateral_fleishman, bilateral_jones]


def area_vectors(vertices: Floats, faces: NDArray[np.int32]) -> Floats:
    """Half the cross product of the edges of every face."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def fleishman_by_loops(mesh: Mesh, f: KernelName, g: KernelName, space: float, height: float) -> Floats:
    """One step of Fleishman's filter, written from its equation."""
    vertices, faces = mesh
    vectors = area_vectors(vertices, faces)
    touching = {(int(a), int(b)) for t in faces for a in t for b in t if a != b}
    result = vertices.copy()
    for i, p in enumerate(vertices):
        normal = vectors[(faces == i).any(axis=1)].sum(axis=0)
        normal /= np.linalg.norm(normal)
        near = set(np.flatnonzero(np.linalg.norm(vertices - p, axis=1) <= math.sqrt(2) * space).tolist())
        found, grown = {i}, True
        while grown:
            more = {j for j in near if any((k, j) in touching for k in found)} | found
            found, grown = more, len(more) > len(found)
        others = sorted(found - {i})
        heights = (vertices[others] - p) @ normal
        weights = weight(f, np.linalg.norm(vertices[others] - p, axis=1), space)
        weights = weights * weight(g, heights, height)
        if weights.sum() > 0:
            result[i] = p + normal * (weights @ heights) / weights.sum()
    return result


def jones_by_loops(mesh: Mesh, f: KernelName, g: KernelName, space: float, height: float) -> Floats:
    """Jones's filter, written from its equations."""
    vertices, faces = mesh
    areas, centres = np.linalg.norm(area_vectors(vertices, faces), axis=1), vertices[faces].mean(axis=1)
    smooth, result = vertices.copy(), vertices.copy()
    for i, p in enumerate(vertices):
        distances = np.linalg.norm(centres - p, axis=1)
        near = distances <= math.sqrt(2) * space / 2
        weights = areas[near] * weight(f, distances[near], space / 2)
        if weights.sum() > 0:
            smooth[i] = weights @ centres[near] / weights.sum()
    normals = area_vectors(smooth, faces)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    for i, p in enumerate(vertices):
        distances = np.linalg.norm(centres - p, axis=1)
        near = distances <= math.sqrt(2) * space
        predictions = p + normals[near] * ((centres[near] - p) * normals[near]).sum(axis=1, keepdims=True)
        weights = areas[near] * weight(f, distances[near], space)
        weights = weights * weight(g, np.linalg.norm(predictions - p, axis=1), height)
        if weights.sum() > 0:
            result[i] = weights @ predictions / weights.sum()
    return result


KERNEL_PAIRS: list[tuple[KernelName, KernelName]] = [(f, "gaussian") for f in KERNEL_NAMES] + [
    ("gaussian", g) for g in KERNEL_NAMES
]


@pytest.mark.parametrize(("f", "g"), KERNEL_PAIRS)
def test_loops_over_vertices_give_the_same(f: KernelName, g: KernelName) -> None:
    """Both filters are their equations, for every kernel of distances and of heights, to 1e-10."""
    mesh = noisy(icosphere(2), 0.03)
    sigmas: dict[str, Any] = {"space_sigma": 0.45, "range_sigma": 0.05}
    found = bilateral_fleishman(*mesh, space_kernel=f, range_kernel=g, iterations=1, **sigmas)
    np.testing.assert_allclose(found, fleishman_by_loops(mesh, f, g, 0.45, 0.05), rtol=0, atol=1e-10)
    found = bilateral_jones(*mesh, space_kernel=f, range_kernel=g, **sigmas)
    np.testing.assert_allclose(found, jones_by_loops(mesh, f, g, 0.45, 0.05), rtol=0, atol=1e-10)


def test_iterations_are_steps_one_after_the_other() -> None:
    """Two iterations with given scales are one, twice."""
    vertices, faces = noisy(icosphere(2), 0.03)
    sigmas: dict[str, Any] = {"space_sigma": 0.45, "range_sigma": 0.05}
    once = bilateral_fleishman(vertices, faces, iterations=1, **sigmas)
    twice = bilateral_fleishman(vertices, faces, iterations=2, **sigmas)
    np.testing.assert_allclose(bilateral_fleishman(once, faces, iterations=1, **sigmas), twice, rtol=0, atol=1e-14)


@pytest.mark.parametrize("seed", range(5))
def test_a_triangle_that_nothing_is_near_to_stays(seed: int) -> None:
    """Its mollified shape is a point with a normal of roundings: in the middle of a noisy sphere it does not move."""
    vertices, faces = noisy(icosphere(2), 0.01)
    alone = np.random.default_rng(seed).uniform(-0.1, 0.1, (3, 3))
    there, three = np.concatenate([vertices, alone]), len(vertices) + np.arange(3, dtype=np.int32)
    found = bilateral_jones(there, np.concatenate([faces, three[None]]))
    np.testing.assert_allclose(found[three], alone, rtol=0, atol=1e-15)


def test_vertices_whose_normals_cancel_out_stay() -> None:
    """On a sphere whose faces are all there twice, both ways round, the sum of normals is that of their roundings."""
    vertices, faces = noisy(icosphere(2), 0.01)
    for order in (np.arange(640), np.random.default_rng(0).permutation(640)):
        both = np.concatenate([faces, faces[:, ::-1]])[order]
        np.testing.assert_array_equal(bilateral_fleishman(vertices, both), vertices)


@pytest.mark.parametrize("name", KERNEL_NAMES)
@pytest.mark.parametrize("apply", FILTERS)
def test_a_plane_is_a_fixed_point(apply: Filter, name: KernelName) -> None:
    """A plane keeps every vertex to rounding, with automatic scales as with given ones."""
    vertices, faces = grid()
    vertices = vertices @ rotation(3).T
    for options in ({}, {"range_sigma": 0.1, "space_sigma": 1.7}):
        found = apply(vertices, faces, range_kernel=name, space_kernel=name, **options)
        np.testing.assert_allclose(found, vertices, rtol=0, atol=1e-13)


def test_jones_does_not_see_orientation() -> None:
    """Turning half of the triangles over changes nothing: projections to planes do not know the normal's sign."""
    vertices, faces = noisy(icosphere(2), 0.02)
    turned = faces.copy()
    turned[::2] = turned[::2, ::-1]
    np.testing.assert_allclose(bilateral_jones(vertices, turned), bilateral_jones(vertices, faces), rtol=0, atol=1e-13)


@pytest.mark.parametrize("apply", FILTERS)
def test_noise_on_a_sphere_falls(apply: Filter) -> None:
    """With no parameter the mean distance to the sphere falls to less than half, and its mean radius changes by under 1 %."""
    vertices, faces = noisy(icosphere(5), 0.01)

    def error(points: Floats) -> float:
        return float(np.abs(np.linalg.norm(points, axis=1) - 1).mean())

    found = apply(vertices, faces)
    assert error(found) < 0.5 * error(vertices)
    assert abs(np.linalg.norm(found, axis=1).mean() - 1) < 0.01


@pytest.mark.parametrize("apply", FILTERS)
def test_an_edge_survives_and_flat_parts_get_flat(apply: Filter) -> None:
    """A redescending range kernel leaves the cube's edges within 60 % of what "l2" rounds them by, and flattens its sides."""
    vertices, faces = cube(4)
    given = vertices + np.random.default_rng(0).normal(0, 0.004, vertices.shape)
    on_edge = (((vertices == 0) | (vertices == 1)).sum(axis=1) == 2) & (np.abs(vertices - 0.5).min(axis=1) < 0.3)
    middle = (vertices[:, 2] == 1) & (np.abs(vertices[:, :2] - 0.5).max(axis=1) < 0.3)

    def inward(points: Floats) -> float:
        outward = np.sign(vertices - 0.5) * ((vertices == 0) | (vertices == 1)) / math.sqrt(2)
        return -float(((points - given) * outward)[on_edge].sum(axis=1).mean())

    robust = apply(given, faces, range_kernel="tukey", range_sigma=0.012)
    assert inward(robust) < 0.6 * inward(apply(given, faces, range_kernel="l2"))
    assert robust[middle, 2].std() < 0.7 * given[middle, 2].std()


@pytest.mark.parametrize("apply", FILTERS)
def test_borders_stay_or_move_as_told(apply: Filter) -> None:
    """A fixed border keeps every bit and a free one moves; what is not movable keeps every bit."""
    vertices, faces = noisy(tube(), 0.03)
    border = topology.border_vertices(faces, len(vertices))
    fixed = apply(vertices, faces, border="fixed")
    assert fixed[border].tobytes() == vertices[border].tobytes()
    assert (fixed[~border] != vertices[~border]).any(axis=1).all()
    assert (apply(vertices, faces, border="free")[border] != vertices[border]).any()
    movable = np.arange(len(vertices)) % 3 > 0
    held = apply(vertices, faces, border="free", movable=movable)
    assert held[~movable].tobytes() == vertices[~movable].tobytes()
    free = apply(vertices, faces, border="free")
    if apply is bilateral_jones:  # it takes one step, so that what others do makes no difference
        assert held[movable].tobytes() == free[movable].tobytes()


def test_a_border_that_is_filtered_along_sees_itself_alone() -> None:
    """Under "along" a border vertex goes to the mean height of those on the border, those inside as if free."""
    vertices, faces = noisy(tube(), 0.02)
    border = topology.border_vertices(faces, len(vertices))
    sigmas: dict[str, Any] = {"space_sigma": 0.6, "range_sigma": 0.05, "iterations": 1}
    along = bilateral_fleishman(vertices, faces, **sigmas)
    free = bilateral_fleishman(vertices, faces, border="free", **sigmas)
    assert along[~border].tobytes() == free[~border].tobytes()
    normal = area_vectors(vertices, faces)[(faces == 1).any(axis=1)].sum(axis=0)
    normal /= np.linalg.norm(normal)
    arms = vertices[[0, 2, 3, 15]] - vertices[1]  # the loop is 0 to 15; within 0.85 are two vertices to either side
    weights = np.exp(-((np.linalg.norm(arms, axis=1) / 0.6) ** 2)) * np.exp(-((arms @ normal / 0.05) ** 2))
    assert np.linalg.norm(arms, axis=1).max() < 0.8
    np.testing.assert_allclose(along[1] - vertices[1], normal * (weights @ (arms @ normal)) / weights.sum(), atol=1e-14)
    assert np.abs(along[1] - free[1]).max() > 1e-4


@pytest.mark.parametrize("distance", [1e9, 1e16])
@pytest.mark.parametrize("apply", FILTERS)
def test_a_far_vertex_that_no_face_uses_changes_no_bit(apply: Filter, distance: float) -> None:
    """With the vertex before or behind the others they come out as without it, bit by bit, and so does the vertex."""
    vertices, faces = noisy(icosphere(3), 0.01)
    far = np.array([[distance, 0.0, 0.0]])
    alone = apply(vertices, faces)
    assert apply(np.concatenate([vertices, far]), faces).tobytes() == np.concatenate([alone, far]).tobytes()
    assert apply(np.concatenate([far, vertices]), faces + 1).tobytes() == np.concatenate([far, alone]).tobytes()


@pytest.mark.parametrize("apply", FILTERS)
@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_stay_finite(name: str, apply: Filter) -> None:
    """Nothing becomes NaN or leaves the mesh, and vertices that no face uses keep every bit."""
    vertices, faces = AWKWARD[name]()
    unused = ~topology.referenced_vertices(faces, len(vertices))
    for kernel in ("gaussian", "l1", "tukey"):
        found = apply(vertices, faces, range_kernel=kernel, space_kernel=kernel)
        assert np.isfinite(found).all()
        if len(vertices):
            assert np.linalg.norm(found / 2 - vertices / 2, axis=1).max() <= diagonal(vertices / 2)
        assert found[unused].tobytes() == vertices[unused].tobytes()


def test_nothing_to_do_returns_a_copy_of_the_same_bits() -> None:
    """No iterations: the same bits in a new array; the input is never written to."""
    vertices, faces = icosphere(1)
    found = bilateral_fleishman(vertices, faces, iterations=0)
    assert found is not vertices
    assert found.tobytes() == vertices.tobytes()
    vertices.flags.writeable = False
    bilateral_fleishman(vertices, faces)
    bilateral_jones(vertices, faces)


def test_progress_is_told() -> None:
    """The share of the work done rises to 1."""
    told: list[float] = []
    bilateral_fleishman(*icosphere(2), iterations=4, progress=told.append)
    assert told == [0.25, 0.5, 0.75, 1.0]
    told.clear()
    bilateral_jones(*icosphere(2), progress=told.append)
    assert told[-1] == 1.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"range_kernel": "cauchy"}, "kernel 'cauchy' is not one of 'l2', 'l1'"),
        ({"space_kernel": "box"}, "kernel 'box' is not one of"),
        ({"range_sigma": -1.0}, "range_sigma is -1.0: it must be finite and above 0"),
        ({"space_sigma": math.nan}, "space_sigma is nan: it must be finite"),
        ({"border": "open"}, "border 'open' is not one of 'fixed'"),
        ({"movable": [True]}, r"movable must be a boolean array of 42 values, one per vertex, got shape \(1,\)"),
    ],
)
@pytest.mark.parametrize("apply", FILTERS)
def test_parameters_are_checked(apply: Filter, options: dict[str, Any], message: str) -> None:
    """What is out of range is an error that names the parameter, the value and what is allowed."""
    with pytest.raises(FilterInputError, match=message):
        apply(*icosphere(1), **options)


def test_each_filter_has_limits_of_its_own() -> None:
    """Iterations are whole, and planes predict no curve."""
    with pytest.raises(FilterInputError, match=r"iterations is 1\.5: it must be a whole number of at least 0"):
        bilateral_fleishman(*icosphere(1), iterations=1.5)  # type: ignore[arg-type]
    with pytest.raises(FilterInputError, match="border 'along' is not one of 'fixed', 'free'"):
        bilateral_jones(*icosphere(1), border="along")  # type: ignore[arg-type]
