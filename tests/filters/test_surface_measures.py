"""The measures of surfaces: closed forms, invariances, an independent count, and MeshLab's own figures."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from dataclasses import asdict, replace

import numpy as np
import pymeshlab
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.inspection.surface_measures import inward_faces, measures_and_connectivity, surface_measures
from tests.meshes import (
    AWKWARD,
    book,
    bow_tie,
    cube,
    grid,
    icosphere,
    moebius_strip,
    noisy,
    renumbered,
    rotation,
    sample,
    sample_path,
    single_triangle,
    tetrahedron,
    torus,
    two_spheres,
)

NO_FACES = np.empty((0, 3), dtype=np.int32)


def test_cube() -> None:
    """Every measure of the unit cube is the one worked out by hand."""
    found = surface_measures(*cube())
    # 12 edges of length 1 at 90 degrees, 6 diagonals of sqrt 2 in the plane; half squares have l = 1 and R = 1 / sqrt 2.
    expected = {
        "vertices": 8,
        "faces": 12,
        "edges": 18,
        "unreferenced_vertices": 0,
        "degenerate_faces": 0,
        "folded_faces": 0,
        "border_edges": 0,
        "non_manifold_edges": 0,
        "non_manifold_vertices": 0,
        "components": 1,
        "closed": True,
        "oriented": True,
        "euler_characteristic": 2,
        "genus": 0,
        "diagonal": pytest.approx(math.sqrt(3), rel=1e-15),
        "area": pytest.approx(6, rel=1e-15),
        "volume": pytest.approx(1, rel=1e-15),
        "mean_edge": pytest.approx((12 + 6 * math.sqrt(2)) / 18, rel=1e-15),
        "roughness": pytest.approx(60, rel=1e-15),
        "triangle_quality": pytest.approx(math.sqrt(2 / 3), rel=1e-15),
        "mean_spacing": None,
    }
    assert asdict(found) == expected


def test_regular_tetrahedron() -> None:
    """Equilateral triangles have quality 1; the normals of two faces form an angle whose cosine is -1/3."""
    found = surface_measures(*tetrahedron())
    assert found.triangle_quality == pytest.approx(1, rel=1e-15)
    assert found.roughness == pytest.approx(math.degrees(math.acos(-1 / 3)), rel=1e-14)
    assert found.volume == pytest.approx(8 / 3, rel=1e-15)


def test_right_triangle() -> None:
    """The triangle of sides 3, 4, 5 has area 6 and circumradius 2.5, hence quality 3 / (2.5 sqrt 3); no angle, no volume."""
    found = surface_measures(*single_triangle())
    assert (found.area, found.mean_edge, found.border_edges) == (6, 4, 3)
    assert found.triangle_quality == pytest.approx(3 / (2.5 * math.sqrt(3)), rel=1e-15)
    assert (found.roughness, found.volume, found.genus, found.closed, found.oriented) == (None, None, None, False, True)


def test_grid() -> None:
    """A flat rectangle of 8 x 9 squares has 34 border edges, area 72, Euler characteristic 1 and no roughness at all."""
    found = surface_measures(*grid(8, 9))
    assert (found.border_edges, found.euler_characteristic, found.components) == (34, 1, 1)
    assert (found.area, found.roughness) == (72, 0)
    edges = 8 * 10 + 9 * 9 + 72 * math.sqrt(2)
    assert found.mean_edge == pytest.approx(edges / (80 + 81 + 72), rel=1e-14)


def test_spheres_converge() -> None:
    """Halving the edges of a sphere quarters the errors of area and volume and halves the roughness."""
    coarse, fine = (surface_measures(*icosphere(k, radius=2.0)) for k in (3, 4))
    for name, exact in (("area", 16 * math.pi), ("volume", 32 * math.pi / 3)):
        errors = [exact - getattr(m, name) for m in (coarse, fine)]
        assert errors[0] / errors[1] == pytest.approx(4, rel=0.01)
    assert coarse.roughness is not None
    assert fine.roughness is not None
    assert coarse.roughness / fine.roughness == pytest.approx(2, rel=0.01)


def test_torus() -> None:
    """A torus has genus 1; its volume tends to 2 pi^2 R r^2 with the square of the edges."""
    coarse, fine = (surface_measures(*torus(n, n // 2)) for n in (48, 96))
    assert (fine.genus, fine.euler_characteristic, fine.closed, fine.oriented) == (1, 0, True, True)
    exact = 2 * math.pi**2 * 2.0 * 0.7**2
    assert coarse.volume is not None
    assert fine.volume is not None
    assert (exact - coarse.volume) / (exact - fine.volume) == pytest.approx(4, rel=0.02)


def test_components_and_genus_add_up() -> None:
    """Two spheres are two components of genus 0 altogether; a sphere and a torus have genus 1."""
    spheres = surface_measures(*two_spheres())
    assert (spheres.components, spheres.genus, spheres.euler_characteristic) == (2, 0, 4)
    (v1, f1), (v2, f2) = icosphere(1), torus()
    both = surface_measures(np.concatenate([v1 + 9, v2]), np.concatenate([f1, f2 + len(v1)]))
    assert (both.components, both.genus) == (2, 1)


def test_what_is_not_manifold() -> None:
    """A bow tie has one such vertex, a book one such edge with two; two tetrahedra at a tip are closed but have no genus."""
    assert (surface_measures(*bow_tie()).non_manifold_vertices, surface_measures(*bow_tie()).non_manifold_edges) == (1, 0)
    assert (surface_measures(*book(3)).non_manifold_vertices, surface_measures(*book(3)).non_manifold_edges) == (2, 1)
    vertices, faces = tetrahedron()
    tips = np.concatenate([vertices, 2 * vertices[0] - vertices[1:]])
    mirrored = np.where(faces == 0, 0, faces + 3)[:, ::-1]
    found = surface_measures(tips, np.concatenate([faces, mirrored]))
    assert (found.closed, found.oriented, found.non_manifold_vertices, found.genus) == (True, True, 1, None)
    assert found.volume == pytest.approx(16 / 3, rel=1e-15)


def test_orientation() -> None:
    """Inside out the volume is negative; with one face turned over there is none, and the roughness stays what it was."""
    vertices, faces = noisy(icosphere(2), 0.02)
    found = surface_measures(vertices, faces)
    turned = surface_measures(vertices, faces[:, ::-1])
    assert found.volume is not None
    assert turned.volume == pytest.approx(-found.volume, rel=1e-14)
    faces = faces.copy()
    faces[7] = faces[7, ::-1]
    mixed = surface_measures(vertices, faces)
    assert (mixed.oriented, mixed.closed, mixed.volume, mixed.genus) == (False, True, None, None)
    assert mixed.roughness == pytest.approx(found.roughness, rel=1e-14)
    strip = surface_measures(*moebius_strip())
    assert (strip.oriented, strip.euler_characteristic, strip.non_manifold_vertices) == (False, 0, 0)


def test_rotation_numbering_and_scale() -> None:
    """Turning and renumbering a mesh change nothing; making it 3 times as large multiplies lengths, areas and volumes alone."""
    mesh = noisy(icosphere(3), 0.01)
    found = asdict(surface_measures(*mesh))
    vertices, faces, _ = renumbered(mesh)
    changed = asdict(surface_measures(3 * vertices @ rotation().T, faces))
    dimension = {"mean_edge": 1, "area": 2, "volume": 3}
    for name, value in found.items():
        if name == "diagonal":  # the box is not turned with the mesh
            continue
        factor = 3.0 ** dimension.get(name, 0)
        assert changed[name] == (pytest.approx(value * factor, rel=1e-12) if isinstance(value, float) else value), name


@pytest.mark.parametrize("size", [1.0, 1e-3], ids=["a metre", "a millimetre"])
def test_far_from_the_origin(size: float) -> None:
    """At UTM and ECEF offsets every measure is, to the bit, that of the same mesh at the origin.

    The coordinates are multiples of 2^-28 and the offsets whole numbers, so that shifting them rounds nothing.
    """
    vertices, faces = noisy(icosphere(3, size), size / 100)
    vertices = np.round(vertices * 2**28) / 2**28
    here = surface_measures(vertices, faces)
    assert here == surface_measures(vertices + np.array([451_234.0, 4_512_345.0, 123.0]), faces)
    assert here == surface_measures(vertices + np.array([-2_694_892.0, -4_297_557.0, 3_854_588.0]), faces)


@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes(name: str) -> None:
    """Whatever the mesh, no measure is NaN, counts are consistent, and shares stay between 0 and 1."""
    vertices, faces = AWKWARD[name]()
    found = surface_measures(vertices, faces)
    assert (found.vertices, found.faces) == (len(vertices), len(faces))
    assert not any(isinstance(value, float) and math.isnan(value) for value in asdict(found).values())
    assert 0 <= (found.triangle_quality or 0) <= 1
    assert 0 <= (found.roughness or 0) <= 180
    assert found.unreferenced_vertices == len(vertices) - len(set(faces[proper(faces)].ravel().tolist()))
    assert found.closed == (found.faces > 0 and found.edges > 0 and found.border_edges == found.non_manifold_edges == 0)
    assert found.degenerate_faces >= int((~proper(faces)).sum())


def proper(faces: np.ndarray[tuple[int, ...], np.dtype[np.int32]]) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """(m,) whether a face names three vertices."""
    a, b, c = faces.T
    return np.asarray((a != b) & (b != c) & (c != a))


@pytest.mark.parametrize("exponent", [-100, 100, 150])
def test_sizes_beyond_all_measure(exponent: int) -> None:
    """Lengths from 1e-100 to 1e150 neither overflow nor vanish before they must."""
    found = surface_measures(*icosphere(2, 10.0**exponent))
    unit = surface_measures(*icosphere(2))
    assert found.area == pytest.approx(unit.area * 10.0 ** (2 * exponent), rel=1e-12)
    assert found.triangle_quality == pytest.approx(unit.triangle_quality, rel=1e-12)
    assert found.roughness == pytest.approx(unit.roughness, rel=1e-12)
    assert (found.degenerate_faces, found.genus) == (0, 0)


def test_degenerate_faces() -> None:
    """A triangle on a line counts as degenerate, as quality 0, and not for the roughness; so does a vertex twice in it."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0]])
    found = surface_measures(vertices, np.array([[0, 1, 3], [0, 2, 1], [1, 2, 3], [2, 2, 3]]))
    assert (found.faces, found.degenerate_faces) == (4, 2)
    assert found.roughness == 0
    assert found.edges == 6
    half = surface_measures(vertices, np.array([[0, 1, 3], [1, 2, 3]])).triangle_quality
    assert found.triangle_quality == pytest.approx((half or 0) / 2, rel=1e-15)
    # Two triangles at a right angle, and one without area at the side of one of them.
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0]])
    folded, flat = [[0, 1, 2], [1, 0, 3]], [[2, 1, 4]]
    for faces in (folded + flat, flat + folded):
        assert surface_measures(corner, faces).roughness == pytest.approx(90, rel=1e-15)


def test_against_counting_in_python() -> None:
    """On random soups of triangles the counts are those of plain dictionaries and sets."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        n = int(rng.integers(4, 12))
        faces = rng.integers(0, n, (int(rng.integers(1, 25)), 3)).astype(np.int32)
        kept = [tuple(f) for f in faces.tolist() if len(set(f)) == 3]
        edges = Counter(frozenset((f[k], f[k - 1])) for f in kept for k in range(3))
        found = surface_measures(rng.random((n, 3)), faces)
        assert found.edges == len(edges)
        assert found.border_edges == sum(c == 1 for c in edges.values())
        assert found.non_manifold_edges == sum(c > 2 for c in edges.values())
        assert found.components == _components(kept)
        assert found.non_manifold_vertices == sum(_is_pinched(v, kept, edges) for v in range(n))


def _components(faces: list[tuple[int, ...]]) -> int:
    parts: list[set[int]] = []
    for face in faces:
        touching = [p for p in parts if p & set(face)]
        parts = [p for p in parts if p not in touching] + [set(face).union(*touching)]
    return len(parts)


def _is_pinched(vertex: int, faces: list[tuple[int, ...]], edges: Counter[frozenset[int]]) -> bool:
    if any(vertex in edge and count > 2 for edge, count in edges.items()):
        return True
    fans: list[set[int]] = []
    for link in (set(f) - {vertex} for f in faces if vertex in f):
        touching = [p for p in fans if p & link]
        fans = [p for p in fans if p not in touching] + [link.union(*touching)]
    return len(fans) > 1


@pytest.mark.parametrize("name", ["bone.ply", "cow.obj", "rangemaps/face000.ply"])
def test_against_meshlab(name: str) -> None:
    """Border edges, components, non-manifold parts, genus and area of real meshes are those that MeshLab counts."""
    found = surface_measures(*sample(name))
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(sample_path(name)))
    told = meshes.get_topological_measures() | meshes.get_geometric_measures()
    assert found.border_edges == told["boundary_edges"]
    assert found.edges == told["edges_number"]
    assert found.unreferenced_vertices == told["unreferenced_vertices"]
    assert found.non_manifold_edges == told["non_two_manifold_edges"]
    if found.non_manifold_vertices == 0:
        # MeshLab takes faces as connected that share an edge, and vertices for its own kind of pinch.
        assert found.components == told["connected_components_number"]
    if found.genus is not None:
        assert found.genus == told["genus"]
        assert found.volume == pytest.approx(told["mesh_volume"], rel=1e-6)
    # MeshLab gives the area in single precision.
    assert found.area == pytest.approx(told["surface_area"], rel=1e-7)


def test_polylines() -> None:
    """A square of side 2 and a segment of length 3 besides a stray vertex: 5 edges of mean length 11 / 5, in two parts."""
    points = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [9, 9, 0], [9, 9, 3], [5, 5, 5], [6, 6, 6]])
    # An edge that is there twice counts once; one from a vertex to itself is no edge, yet that vertex is used.
    pairs = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [0, 3], [4, 5], [7, 7]], dtype=np.int32)
    found = surface_measures(points, np.empty((0, 3), dtype=np.int32), edges=pairs)
    assert (found.edges, found.components, found.unreferenced_vertices, found.euler_characteristic) == (5, 2, 1, 1)
    assert found.mean_edge == pytest.approx(11 / 5, rel=1e-15)
    assert found.mean_spacing is None
    assert not found.closed


def test_polylines_beside_faces_are_references_alone() -> None:
    """A triangle with an edge to a fourth vertex measures what the triangle does, but for that vertex being used."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]])
    faces = np.array([[0, 1, 2]], dtype=np.int32)
    alone = surface_measures(points, faces)
    assert alone.unreferenced_vertices == 1
    assert surface_measures(points, faces, edges=[[2, 3]]) == replace(alone, unreferenced_vertices=0)


def test_a_former_connectivity_is_taken_for_the_same_mesh_alone() -> None:
    """Other faces, edges or numbers of vertices have the measures that they have without one; the same ones reuse it."""
    (corners, faces), edges = cube(), [[0, 1]]
    vertices = np.concatenate([corners, corners])
    _, former = measures_and_connectivity(vertices, faces, edges=edges)
    found, reused = measures_and_connectivity(2.0 * vertices, faces, edges=edges, former=former)
    assert reused is former
    assert found == surface_measures(2.0 * vertices, faces, edges=edges)
    for mesh in ((corners, faces, edges), (vertices, faces[1:], edges), (vertices, faces, [[0, 8]])):
        found, _ = measures_and_connectivity(*mesh[:2], edges=mesh[2], former=former)
        assert found == surface_measures(*mesh[:2], edges=mesh[2])


def test_point_clouds() -> None:
    """A cloud has a mean spacing, 2 for a grid of spacing 2, and no edges; one point has none; no points measure nothing."""
    points = grid(5, 5, spacing=2.0)[0]
    found = surface_measures(points, NO_FACES)
    assert (found.mean_spacing, found.mean_edge, found.roughness, found.triangle_quality) == (2, None, None, None)
    assert (found.vertices, found.components, found.closed, found.area) == (36, 0, False, 0)
    assert surface_measures(points[:1], NO_FACES).mean_spacing is None
    nothing = surface_measures(np.empty((0, 3)), NO_FACES)
    assert replace(nothing, mean_spacing=None) == nothing
    assert (nothing.vertices, nothing.diagonal) == (0, 0)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_cannot_be_measured(bad: float) -> None:
    """A coordinate that is not finite and an index that names no vertex are refused."""
    vertices, faces = cube()
    with pytest.raises(FilterInputError, match="not finite"):
        surface_measures(np.where(np.arange(24).reshape(8, 3) == 5, bad, vertices), faces)
    with pytest.raises(FilterInputError, match="vertices are 0 to 6"):
        surface_measures(vertices[:7], faces)


def test_edges_between_no_vertices_are_refused() -> None:
    """As for faces, the index is named."""
    with pytest.raises(FilterInputError, match="edge 0 is"):
        surface_measures(np.zeros((2, 3)), np.empty((0, 3), dtype=np.int32), edges=[[0, 2]])


def test_the_mesh_stays() -> None:
    """Measuring does not write into the arrays, and takes read-only ones."""
    vertices, faces = cube()
    vertices.flags.writeable = faces.flags.writeable = False
    surface_measures(vertices, faces)


@pytest.mark.parametrize(
    ("signs", "expected"),
    [((1, -1, 1), ()), ((1, 1, 1), ()), ((-1, -1, -1), (0, 1, 2)), ((1, -1, -1), (2,)), ((-1, 1, 1), (0, 1))],
)
def test_faces_look_inwards_where_the_winding_number_before_them_is_negative(
    signs: tuple[int, ...], expected: tuple[int, ...]
) -> None:
    """Of three balls within each other every one looks outwards (1) or inwards (-1); a hollow and a ball in it are well."""
    vertices, faces = icosphere(2)
    points = np.concatenate([radius * vertices + 1e3 for radius in (4.0, 2.0, 1.0)])
    cells = [faces[:, ::sign] + np.int32(k * len(vertices)) for k, sign in enumerate(signs)]
    found = inward_faces(points, np.concatenate(cells)).reshape(3, -1)
    assert found.all(axis=1).tolist() == found.any(axis=1).tolist() == [k in expected for k in range(3)]


@pytest.mark.parametrize("seed", range(4))
def test_what_lies_above_or_beside_a_component_does_not_make_it_look_inwards(seed: int) -> None:
    """Long tilted balls, three in each other and two beside: the winding number is the sum of the signs of those around."""
    vertices, faces = icosphere(1)
    rng = np.random.default_rng(seed)
    long = vertices * [1.0, 2.5, 6.0] @ rotation(seed).T
    scales = np.array([4.0, 2.0, 1.0, 1.0, 1.0])
    places = np.array([[0.0, 0, 0], [0, 0, 0], [0, 0, 0], [3, 4, 60], [-50, -50, -50]])
    places[1:3] += 0.1 * rng.normal(size=(2, 3))
    points = (scales[:, None, None] * long + places[:, None]).reshape(-1, 3)
    around: list[list[int]] = [[], [0], [0, 1], [], []]
    for signs in itertools.product((1, -1), repeat=5):
        cells = [faces[:, ::sign] + np.int32(k * len(vertices)) for k, sign in enumerate(signs)]
        found = inward_faces(points, np.concatenate(cells)).reshape(5, -1)
        # In front of a ball that looks inwards is its inside.
        before = [sum(signs[j] for j in around[k]) + min(sign, 0) for k, sign in enumerate(signs)]
        assert found.all(axis=1).tolist() == found.any(axis=1).tolist() == [winding < 0 for winding in before]
