"""Region fairing against closed forms, libigl's harmonic solver and itself by another solver."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from scipy import sparse

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.compilation import allowed_threads, set_threads
from pymeshfair.filters.fairing.region import ENERGIES, Energy, fair_region
from pymeshfair.filters.linear_solvers import laplacian_power
from pymeshfair.filters.mesh import Bools
from pymeshfair.filters.operators import laplace_beltrami
from pymeshfair.filters.topology import border_vertices, submesh_around
from tests.meshes import AWKWARD, Floats, Ints, Mesh, grid, icosphere, irregular_grid, tube, two_spheres


def capped(subdivisions: int, radius: float) -> tuple[Mesh, Bools, int]:
    """A unit sphere whose cap above the rim of that radius is pressed flat; which vertices that are; the pole."""
    vertices, faces = icosphere(subdivisions)
    pole = int(np.argmax(vertices[:, 2]))
    height = np.sqrt(1.0 - radius**2)
    cap: Bools = np.asarray(vertices[:, 2] > height)
    flat = vertices.copy()
    flat[cap, 2] = height
    return (flat, faces), cap, pole


def rotated(vertices: Floats) -> Floats:
    """Turned about an axis of no special direction."""
    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    return np.asarray(vertices @ turn.T)


def rough_patch(size: int) -> tuple[Mesh, Bools]:
    """A bent irregular sheet, and those of its vertices that lie four rows or more inside."""
    vertices, faces = irregular_grid(size, size, amount=0.2)
    vertices = vertices / size
    vertices[:, 2] = 0.3 * np.sin(3 * vertices[:, 0]) * np.cos(2 * vertices[:, 1])
    inside: Bools = np.asarray((np.abs(vertices[:, :2] - 0.5) < 0.5 - 4.5 / size).all(axis=1))
    return (vertices, faces), inside


def test_a_membrane_in_a_planar_rim_is_planar() -> None:
    """Order 1 with all fixed vertices in a plane ends in the plane: each vertex is a mean of others, to 1e-10 and better."""
    vertices, faces = irregular_grid(20, 20)
    inside = ~border_vertices(faces, len(vertices))
    lifted = vertices.copy()
    lifted[inside, 2] += np.random.default_rng(0).normal(size=int(inside.sum())) * 0.1
    result = fair_region(lifted, faces, inside, energy="membrane")
    assert np.abs(result.vertices[:, 2]).max() <= 1e-10
    assert result.backward_error <= 1e-13


@pytest.mark.parametrize("energy", ENERGIES)
def test_a_flat_sheet_stays_as_it_is(energy: Energy) -> None:
    """Linear functions have L p = 0 at every vertex inside, also beside a border that holds the free region."""
    vertices, faces = irregular_grid(14, 15)
    result = fair_region(vertices, faces, np.ones(len(vertices), dtype=bool), energy=energy)
    assert np.abs(result.vertices - vertices).max() <= 1e-11 * 15
    assert np.array_equal(result.free, ~border_vertices(faces, len(vertices)))


@pytest.mark.parametrize(("radius", "share"), [(0.6, 0.1), (0.3, 0.2)])
def test_the_pole_of_a_cap_filled_flat(radius: float, share: float) -> None:
    """The pole's error tends to 1 - sqrt(1-R^2) at order 1 and to that less R^2/2 at order 2; order 3 stays below 0.35 of it."""
    (vertices, faces), cap, pole = capped(6, radius)
    errors = []
    for energy in ENERGIES:
        result = fair_region(vertices, faces, cap, energy=energy)
        assert result.backward_error <= 1e-13
        assert np.array_equal(result.vertices[~cap], vertices[~cap])
        errors.append(abs(1.0 - result.vertices[pole, 2]))
    height = 1.0 - np.sqrt(1.0 - radius**2)
    assert errors[0] == pytest.approx(height, rel=share)
    assert errors[1] == pytest.approx(height - radius**2 / 2, rel=share)
    assert errors[2] < 0.35 * errors[1]


def test_repeated_membranes_tend_to_the_catenoid() -> None:
    """Between two rings of radius 1, 1 apart, the minimal surface is r = a cosh(z / a), a cosh(1 / 2a) = 1."""
    vertices, faces = tube(around=64, along=24, length=1.0)
    inside = ~border_vertices(faces, len(vertices))
    for _ in range(40):
        vertices = fair_region(vertices, faces, inside, energy="membrane").vertices
    neck = 0.8
    for _ in range(100):
        neck = 1.0 / np.cosh(0.5 / neck)
    radii = np.linalg.norm(vertices[:, :2], axis=1)
    assert np.abs(radii - neck * np.cosh((vertices[:, 2] - 0.5) / neck)).max() < 0.01 * neck


@pytest.mark.parametrize(("energy", "order"), [("membrane", 1), ("thin_plate", 2), ("minimum_variation", 3)])
def test_libigl_agrees_on_ten_thousand_free_vertices(energy: Energy, order: int) -> None:
    """igl.harmonic of that order with the same fixed vertices gives the same surface, to 1e-5 of the diagonal."""
    (vertices, faces), inside = rough_patch(109)
    assert inside.sum() == 10_000
    fixed = np.flatnonzero(~inside)
    theirs = igl.harmonic(vertices, faces.astype(np.int64), fixed.astype(np.int64), vertices[fixed], order)
    ours = fair_region(vertices, faces, inside, energy=energy)
    assert np.abs(ours.vertices - theirs).max() < 1e-5 * np.linalg.norm(np.ptp(vertices, axis=0))
    assert ours.backward_error <= 1e-13


@pytest.mark.parametrize("order", [1, 2, 3])
def test_powers_in_twice_the_precision(order: int) -> None:
    """Against the same power with exact fractions of 80 bits, what is lost is the last rounding; in doubles it is far more."""
    vertices, faces = icosphere(3)
    operator = laplace_beltrami(vertices, faces)
    stiffness, inverse = sparse.csr_matrix(-operator.stiffness), 1.0 / operator.mass
    smooth = 5.0 + 0.01 * vertices
    off = stiffness - sparse.diags_array(stiffness.diagonal())
    rows, columns = off.nonzero()
    weights = np.asarray(stiffness[rows, columns]).ravel().astype(np.longdouble)
    exact = smooth.astype(np.longdouble)
    for step in range(order):
        product = np.zeros_like(exact)
        np.add.at(product, rows, weights[:, None] * (exact[columns] - exact[rows]))
        exact = product * (inverse.astype(np.longdouble)[:, None] if step < order - 1 else 1)
    result = laplacian_power(stiffness, inverse, order, smooth)
    size = float(np.abs(exact).max())
    plain = stiffness @ smooth
    for _ in range(order - 1):
        plain = stiffness @ (inverse[:, None] * plain)
    ours, ordinary = (float(np.abs(r - exact).max()) / size for r in (result, plain))
    assert ours < 1e-12
    assert ours < 1e-2 * ordinary


@pytest.mark.parametrize("energy", ENERGIES)
def test_the_result_turns_grows_and_moves_with_the_mesh(energy: Energy) -> None:
    """Rotation, a scale of 1e12 and a shift commute with fairing, to the rounding of the coordinates."""
    (vertices, faces), cap, _ = capped(4, 0.6)
    plain = fair_region(vertices, faces, cap, energy=energy).vertices
    turned = fair_region(rotated(vertices), faces, cap, energy=energy).vertices
    large = fair_region(vertices * 1e12 + 3e12, faces, cap, energy=energy).vertices
    assert np.abs(turned - rotated(plain)).max() < 1e-10
    assert np.abs(large - (plain * 1e12 + 3e12)).max() < 1e-9 * 1e12


def test_only_rings_around_the_region_matter() -> None:
    """Order k sees k rings: what lies further away can be anything."""
    (vertices, faces), cap, _ = capped(4, 0.5)
    part = submesh_around(vertices, faces, cap, 3)
    elsewhere = np.ones(len(vertices), dtype=bool)
    elsewhere[part.vertices] = False
    moved = vertices + 0.3 * elsewhere[:, None] * np.random.default_rng(1).normal(size=vertices.shape)
    first = fair_region(vertices, faces, cap, energy="minimum_variation").vertices
    second = fair_region(moved, faces, cap, energy="minimum_variation").vertices
    assert np.array_equal(first[cap], second[cap])
    assert len(part.vertices) == int(cap.sum()) + sum(_ring_sizes(faces, cap, 3))


def _ring_sizes(faces: Ints, marked: Bools, rings: int) -> list[int]:
    reached, sizes = marked.copy(), []
    for _ in range(rings):
        wider = reached.copy()
        wider[faces[reached[faces].any(axis=1)]] = True
        sizes.append(int(wider.sum() - reached.sum()))
        reached = wider
    return sizes


def test_a_part_without_fixed_vertex_is_refused_by_name() -> None:
    """All of one of two spheres is free: the message names a vertex of that sphere."""
    vertices, faces = two_spheres()
    free = np.arange(len(vertices)) >= len(vertices) // 2
    with pytest.raises(FilterInputError, match=rf"vertex {len(vertices) // 2} touch no fixed vertex"):
        fair_region(vertices, faces, free)


@pytest.mark.parametrize("energy", ENERGIES)
@pytest.mark.parametrize("held", [1, 2])
def test_a_part_held_by_fewer_than_three_vertices_is_refused(energy: Energy, held: int) -> None:
    """All of a sphere but one vertex or two would shrink to these; all but the three of a triangle has something to span."""
    vertices, faces = icosphere(3)
    free = np.ones(len(vertices), dtype=bool)
    free[faces[0, :held]] = False
    with pytest.raises(FilterInputError, match=f"connected with vertex [0-9]+ are held by {held} fixed [a-z]+ alone"):
        fair_region(vertices, faces, free, energy=energy)
    free[faces[0]] = False
    assert fair_region(vertices, faces, free, energy="membrane").area_share < 0.1


def test_a_part_held_in_one_line_is_refused() -> None:
    """Three fixed vertices that lie in one line span nothing."""
    vertices, faces = icosphere(3)
    line = np.zeros(len(vertices), dtype=bool)
    line[faces[0]] = True
    flat = vertices.copy()
    flat[faces[0]] = [[0.0, 0.0, 1.0], [0.1, 0.0, 1.0], [0.2, 0.0, 1.0]]
    with pytest.raises(FilterInputError, match="are held by 3 fixed vertices in one line"):
        fair_region(flat, faces, ~line)


def test_several_regions_are_faired_on_their_own() -> None:
    """Two regions together come out as each of them alone."""
    vertices, faces = icosphere(4)
    rough = vertices * (1.0 + 0.05 * np.random.default_rng(3).normal(size=(len(vertices), 1)))
    north, south = rough[:, 2] > 0.7, rough[:, 2] < -0.8
    both = fair_region(rough, faces, north | south).vertices
    assert np.abs(both[north] - fair_region(rough, faces, north).vertices[north]).max() < 1e-11
    assert np.abs(both[south] - fair_region(rough, faces, south).vertices[south]).max() < 1e-11


def test_nothing_free_is_no_error() -> None:
    """Without free vertices, or with border vertices alone, all coordinates keep every bit."""
    vertices, faces = grid(4, 4)
    for free in (np.zeros(len(vertices), dtype=bool), border_vertices(faces, len(vertices))):
        result = fair_region(vertices, faces, free)
        assert np.array_equal(result.vertices, vertices)
        assert not result.free.any()


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_end_finite(name: str) -> None:
    """A third of any mesh is faired to finite coordinates, the rest keeps every bit."""
    vertices, faces = AWKWARD[name]()
    free = np.arange(len(vertices)) % 3 == 0
    result = fair_region(vertices, faces, free)
    assert np.isfinite(result.vertices).all()
    assert np.array_equal(result.vertices[~result.free], vertices[~result.free])
    assert result.backward_error <= 1e-13


@pytest.mark.parametrize(
    ("change", "message"),
    [({"energy": "plate"}, "energy 'plate'"), ({"free": np.zeros(3)}, "free must be a boolean array")],
)
def test_wrong_arguments_are_named(change: dict[str, object], message: str) -> None:
    """The message says which argument is wrong and what came."""
    vertices, faces = grid(4, 4)
    arguments: dict[str, object] = {"free": np.ones(len(vertices), dtype=bool), **change}
    with pytest.raises(FilterInputError, match=message):
        fair_region(vertices, faces, **arguments)  # type: ignore[arg-type]


def test_a_raising_progress_stops_the_factorisation() -> None:
    """What `progress` raises while the factors are made in another thread comes out, and soon."""
    (vertices, faces), inside = rough_patch(109)

    def stop(_: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fair_region(vertices, faces, inside, energy="minimum_variation", progress=stop)


def test_the_same_bits_for_any_number_of_threads() -> None:
    """Nothing is summed up in an order that depends on threads."""
    (vertices, faces), inside = rough_patch(60)
    allowed = allowed_threads()
    results = []
    for threads in (1, allowed):
        set_threads(threads)
        try:
            results.append(fair_region(vertices, faces, inside).vertices)
        finally:
            set_threads(allowed)
    assert np.array_equal(results[0], results[1])
