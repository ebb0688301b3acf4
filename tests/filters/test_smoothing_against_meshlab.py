"""Explicit and Taubin smoothing against MeshLab's own filters, on the meshes that pymeshlab carries."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

from pymeshfair.filters import topology
from pymeshfair.filters.diffusion.explicit import explicit_smoothing, taubin_fairing
from pymeshfair.filters.operators import cotangent_laplacian
from tests.meshes import Mesh, book, cube, diagonal, grid, icosphere, irregular_grid, noisy, sample, tube

Floats = NDArray[np.float64]

CLOSED = ("bunny.obj", "bone.ply", "cow.obj")
SMALL = {"noisy sphere": noisy(icosphere(2), 0.05), "cube": cube(), "tube": noisy(tube(), 0.03), "grid": irregular_grid()}


def by_meshlab(mesh: Mesh, name: str, **parameters: Any) -> Floats:
    """The vertices after one of MeshLab's filters."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*mesh))
    meshes.apply_filter(name, **parameters)
    return np.asarray(meshes.current_mesh().vertex_matrix())


def as_meshlab_reads(value: float) -> float:
    """MeshLab's floating parameters have 32 bits."""
    return float(np.float32(value))


def out_of_reach(mesh: Mesh, steps: int) -> NDArray[np.bool_]:
    """The vertices from which no border and no non-manifold edge is reached within that many steps along edges."""
    vertices, faces = mesh
    pairs, counts = topology.edge_face_counts(faces)
    reached = np.zeros(len(vertices), dtype=bool)
    reached[pairs[counts != 2]] = True
    for _ in range(steps - 1):
        touched = pairs[reached[pairs].any(axis=1)]
        reached[touched] = True
    return ~reached


@pytest.mark.parametrize("name", CLOSED)
def test_taubin_is_meshlabs_on_closed_meshes(name: str) -> None:
    """Ten pairs equal `apply_coord_taubin_smoothing` on every vertex of bunny, bone and cow, to 1e-9 of the diagonal."""
    mesh = sample(name)
    expected = by_meshlab(mesh, "apply_coord_taubin_smoothing", lambda_=0.5, mu=-0.53, stepsmoothnum=10)
    found = taubin_fairing(*mesh, step=as_meshlab_reads(0.5), mu=as_meshlab_reads(-0.53))
    assert np.abs(found - mesh[0]).max() > 1e-4 * diagonal(mesh[0])
    assert np.abs(found - expected).max() < 1e-9 * diagonal(mesh[0])


@pytest.mark.parametrize("mesh", [sample("rangemaps/face000.ply"), noisy(grid(40, 40), 0.1)], ids=["face000", "grid"])
def test_taubin_is_meshlabs_wherever_no_border_reaches(mesh: Mesh) -> None:
    """Four pairs on open meshes equal MeshLab's to 1e-9 of the diagonal on every vertex no border reaches in eight steps."""
    expected = by_meshlab(mesh, "apply_coord_taubin_smoothing", lambda_=0.6, mu=-0.63, stepsmoothnum=4)
    found = taubin_fairing(*mesh, step=as_meshlab_reads(0.6), mu=as_meshlab_reads(-0.63), iterations=4)
    inside = out_of_reach(mesh, steps=8)
    assert 0.3 < inside.mean() < 1.0
    assert np.abs(found - expected)[inside].max() < 1e-9 * diagonal(mesh[0])
    assert np.abs(found - expected)[~inside].max() > 1e-6 * diagonal(mesh[0])


@pytest.mark.parametrize("mesh", [sample("rangemaps/face000.ply"), SMALL["tube"]], ids=["face000", "tube"])
def test_on_a_border_meshlabs_step_goes_two_thirds_of_ours(mesh: Mesh) -> None:
    """One step: MeshLab averages a border vertex in with its two border neighbours, so it goes 2/3 of the way of "along".

    Where a border touches itself a vertex has four border neighbours and the share is 4/5.
    """
    vertices, faces = mesh
    border = topology.one_rings(topology.border_edges(faces), len(vertices))
    neighbours = np.diff(border.offsets)
    ours = explicit_smoothing(vertices, faces, step=0.5, iterations=1) - vertices
    theirs = by_meshlab(mesh, "apply_coord_taubin_smoothing", lambda_=0.5, mu=0.0, stepsmoothnum=1) - vertices
    share = np.where(neighbours > 0, neighbours / (neighbours + 1), 1.0)
    assert (neighbours == 2).sum() > 20
    assert np.abs(ours[neighbours == 2]).max() > 1e-4 * diagonal(vertices)
    np.testing.assert_allclose(theirs, share[:, None] * ours, atol=1e-15 * np.abs(vertices).max() * 10)


@pytest.mark.parametrize("boundary", [True, False])
@pytest.mark.parametrize("name", [*CLOSED, "rangemaps/face000.ply", *SMALL])
def test_meshlabs_uniform_rule_is_reproduced(name: str, boundary: bool) -> None:
    """Ten steps of update="meshlab" equal `apply_coord_laplacian_smoothing` everywhere, borders along and free, to 1e-13."""
    mesh = SMALL[name] if name in SMALL else sample(name)
    expected = by_meshlab(
        mesh, "apply_coord_laplacian_smoothing", stepsmoothnum=10, boundary=boundary, cotangentweight=False, selected=False
    )
    found = explicit_smoothing(*mesh, update="meshlab", border="along" if boundary else "free")
    assert np.abs(found - expected).max() < 1e-13 * diagonal(mesh[0])


@pytest.mark.parametrize("boundary", [True, False])
@pytest.mark.parametrize("name", [*CLOSED, "rangemaps/face000.ply", *SMALL])
def test_meshlabs_cotangent_rule_is_reproduced(name: str, boundary: bool) -> None:
    """One step of update="meshlab" with cotangents equals MeshLab's to 1e-8 of the diagonal: its weights have 32 bits."""
    mesh = SMALL[name] if name in SMALL else sample(name)
    expected = by_meshlab(
        mesh, "apply_coord_laplacian_smoothing", stepsmoothnum=1, boundary=boundary, cotangentweight=True, selected=False
    )
    found = explicit_smoothing(
        *mesh, operator="cotangent", iterations=1, update="meshlab", border="along" if boundary else "free"
    )
    assert np.abs(found - mesh[0]).max() > 1e-4 * diagonal(mesh[0])
    assert np.abs(found - expected).max() < 1e-8 * diagonal(mesh[0])


@pytest.mark.parametrize("name", ["bunny.obj", "bone.ply"])
def test_meshlabs_cotangent_rule_is_reproduced_for_ten_steps_where_it_is_stable(name: str) -> None:
    """Ten steps, too, agree to 1e-8 where few triangles are obtuse; the cow's negative weights amplify the error of 32 bits."""
    mesh = sample(name)
    expected = by_meshlab(mesh, "apply_coord_laplacian_smoothing", stepsmoothnum=10, cotangentweight=True)
    found = explicit_smoothing(*mesh, operator="cotangent", update="meshlab")
    assert np.abs(found - expected).max() < 1e-8 * diagonal(mesh[0])


def test_meshlabs_rule_counts_the_faces_of_non_manifold_edges() -> None:
    """On the spine of a book with three pages an edge counts three times, in MeshLab's rule as in ours."""
    mesh = book()
    expected = by_meshlab(mesh, "apply_coord_laplacian_smoothing", stepsmoothnum=3, boundary=False, cotangentweight=False)
    np.testing.assert_allclose(explicit_smoothing(*mesh, update="meshlab", iterations=3, border="free"), expected, atol=1e-14)
    cotangent = by_meshlab(mesh, "apply_coord_laplacian_smoothing", stepsmoothnum=1, boundary=False, cotangentweight=True)
    found = explicit_smoothing(*mesh, operator="cotangent", update="meshlab", iterations=1, border="free")
    np.testing.assert_allclose(found, cotangent, atol=1e-7)


@pytest.mark.parametrize("name", CLOSED)
def test_where_the_two_rules_coincide(name: str) -> None:
    """One uniform step of MeshLab's is an Euler step of 2 d / (2 d + 1) at a vertex of valence d, on closed meshes."""
    vertices, faces = sample(name)
    valence = np.diff(topology.one_rings(faces, len(vertices)).offsets)[:, None]
    theirs = by_meshlab((vertices, faces), "apply_coord_laplacian_smoothing", stepsmoothnum=1, cotangentweight=False) - vertices
    ours = explicit_smoothing(vertices, faces, step=1.0, iterations=1) - vertices
    np.testing.assert_allclose(theirs, 2 * valence / (2 * valence + 1) * ours, atol=1e-14 * np.abs(vertices).max())


@pytest.mark.parametrize("name", ["bone.ply", "noisy sphere"])
def test_where_the_two_rules_coincide_with_cotangents(name: str) -> None:
    """With no negative weight MeshLab's step is an Euler step of W / (W + 1), W the sum of the cotangents (twice our weights)."""
    vertices, faces = SMALL[name] if name in SMALL else sample(name)
    laplacian = cotangent_laplacian(vertices, faces)
    positive = np.isclose(laplacian.mass, -laplacian.stiffness.diagonal(), rtol=1e-12)
    assert positive.mean() > 0.8
    theirs = by_meshlab((vertices, faces), "apply_coord_laplacian_smoothing", stepsmoothnum=1, cotangentweight=True) - vertices
    ours = explicit_smoothing(vertices, faces, operator="cotangent", step=1.0, iterations=1) - vertices
    weight = 2 * laplacian.mass[:, None]
    assert np.abs(theirs - weight / (weight + 1) * ours)[positive].max() < 1e-8 * diagonal(vertices)


@pytest.mark.parametrize("name", CLOSED)
def test_scale_dependent_is_meshlabs_on_closed_meshes(name: str) -> None:
    """Five steps of delta / 2 equal `apply_coord_laplacian_smoothing_scale_dependent` of delta, whose L lacks our factor 2."""
    mesh = sample(name)
    size = diagonal(mesh[0])
    delta = 2e-8 * size**2
    expected = by_meshlab(
        mesh, "apply_coord_laplacian_smoothing_scale_dependent", stepsmoothnum=5, delta=pymeshlab.PureValue(delta)
    )
    # MeshLab reads delta with 32 bits.
    found = explicit_smoothing(*mesh, operator="scale_dependent", step=as_meshlab_reads(delta) / 2, iterations=5)
    assert np.abs(found - mesh[0]).max() > 1e-8 * size
    assert np.abs(found - expected).max() < 1e-12 * size


def test_scale_dependent_differs_from_meshlabs_on_borders_alone() -> None:
    """MeshLab counts an edge once a face, so border edges half as much as interior ones; inside it agrees."""
    vertices, faces = noisy(grid(), 0.05)
    delta = 0.01
    rings = topology.one_rings(faces, len(vertices))
    expected = vertices.copy()
    for i in range(len(vertices)):
        ring = slice(rings.offsets[i], rings.offsets[i + 1])
        spokes = vertices[rings.neighbours[ring]] - vertices[i]
        lengths, counts = np.linalg.norm(spokes, axis=1), rings.face_counts[ring]
        expected[i] += as_meshlab_reads(delta) * (counts / lengths) @ spokes / (counts @ lengths)
    theirs = by_meshlab(
        (vertices, faces), "apply_coord_laplacian_smoothing_scale_dependent", stepsmoothnum=1, delta=pymeshlab.PureValue(delta)
    )
    np.testing.assert_allclose(theirs, expected, atol=1e-14)
    step = as_meshlab_reads(delta) / 2
    ours = explicit_smoothing(vertices, faces, operator="scale_dependent", step=step, iterations=1, border="free")
    on_border = topology.border_vertices(faces, len(vertices))
    np.testing.assert_allclose(ours[~on_border], theirs[~on_border], atol=1e-14)
    assert (np.abs(ours - theirs)[on_border].max(axis=1) > 1e-5).any()
