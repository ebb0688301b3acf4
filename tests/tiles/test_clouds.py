"""LoOP and stray points by tiles are those in one piece, to the bit, however the cloud is cut."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any, cast
from unittest import mock

import numpy as np
import pymeshlab
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pymeshfair.errors import FilterInputError
from pymeshfair.files.errors import ContentsError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply_write import write_ply
from pymeshfair.filters.outliers import found_words, local_outlier_probability, stray_points, surplus_points
from pymeshfair.mesh_data import MeshData, View
from pymeshfair.registry import find_filter
from pymeshfair.tiles import cells as cells_module
from pymeshfair.tiles.cells import divide
from pymeshfair.tiles.cloud import Cloud, do_step, write_cloud
from pymeshfair.tiles.plan import PlannedStep
from pymeshfair.tiles.sources import PlyFile
from pymeshfair.tiles.workers import Tasks
from tests.files.plys import Element, ply_file
from tests.tiles import tiling
from tests.tiles.tiling import duplicates, loop, normals, strays, surplus

Floats = NDArray[np.float64]


def uneven(seed: int, count: int = 900) -> Floats:
    """A sheet whose density falls a thousandfold from one end to the other, a clump, a haze, and points far from everything."""
    random = np.random.default_rng(seed)
    sheet = random.uniform(0, 1, (count, 3))
    sheet[:, 0] **= 6
    sheet[:, 2] = 1e-3 * random.normal(size=count)
    clump = [0.9, 0.5, 0.05] + 1e-4 * random.normal(size=(40, 3))
    haze = random.uniform(-2, 2, (60, 3))
    points = np.concatenate([sheet, clump, haze, [[1e4, 0, 0], [1e4, 1, 0], [-3e3, 5, 7]]])
    return cast("Floats", random.permutation(points))


def lattice(seed: int) -> Floats:
    """A lattice, in which nearly all distances are ties, with a fourth of its points there twice or five times."""
    random = np.random.default_rng(seed)
    points = np.stack(np.meshgrid(*[np.arange(9.0)] * 3), axis=-1).reshape(-1, 3)
    points = np.concatenate([points, points[:180], *[points[:20]] * 3])
    points[random.integers(len(points))] = [40.0, 3.0, 3.0]
    return cast("Floats", random.permutation(points))


def one_place(seed: int) -> Floats:
    """Most points at one place, the rest around it."""
    points = np.ones((500, 3))
    points[:60] = np.random.default_rng(seed).normal(size=(60, 3))
    return points


def islands(seed: int) -> Floats:
    """Sheets of 10 to 300 points side by side, a winding line, a clump and a haze; parts reach through several tiles."""
    random = np.random.default_rng(seed)
    sheets = [
        [20 * i, 0, 0] + random.uniform(0, 1, (size, 3)) * [size**0.5, size**0.5, 0.02] for i, size in enumerate((10, 60, 300))
    ]
    along = np.linspace(0, 40, 200)
    line = np.stack([along, 25 + np.sin(along), 0 * along], axis=1)
    clump = [30, -10, 5] + 2 * random.normal(size=(150, 3))
    return cast("Floats", random.permutation(np.concatenate([*sheets, line, clump, random.uniform(-20, 60, (100, 3))])))


def by_tiles(
    points: Floats, selection: PlannedStep, *, most: int, cell: int = 16, order: int = 0
) -> tuple[Floats, Floats, dict[str, Any]]:
    """The probabilities of all points if there are any, the points that are kept, and what the filter reports."""
    with tempfile.TemporaryDirectory() as name, mock.patch.object(cells_module, "CELL", cell):
        folder = Path(name)
        cloud = Cloud(PlyFile(tiling.write_cloud(folder / "in.ply", points)), folder)
        pool = cast("Tasks", tiling.Here(order))
        after, values, known = do_step(cloud, selection, pool, 10**6, progress=lambda share: None, most=most)
        assert known["tiles"] > 1 or most >= len(points)
        write_cloud(after, folder / "out.ply", 100)
        rows = PlyFile(folder / "out.ply").vertices.read(0, len(PlyFile(folder / "out.ply")))
        np.testing.assert_array_equal(points[rows["number"]], np.stack([rows[axis] for axis in "xyz"], axis=1))
        assert ("quality" in (rows.dtype.names or ())) == cloud.scalars.path.exists()
        return cloud.scalars.read(0, len(points)) if cloud.scalars.path.exists() else np.empty(0), rows["number"], values


@pytest.mark.parametrize("make", [uneven, lattice, one_place])
@settings(max_examples=8)
@given(
    k=st.integers(1, 30),
    most=st.integers(20, 1200),
    cell=st.integers(2, 100),
    seed=st.integers(0, 1000),
)
def test_tiles_change_no_bit(make: Any, k: int, most: int, cell: int, seed: int) -> None:
    """Tiles of any size, in any order, give the bits of the whole: uneven density, ties and coincident points."""
    points = make(seed)
    whole = local_outlier_probability(points, neighbors=k, extent=3.0)
    found, kept, values = by_tiles(points, loop(1, k, 3.0, 0.5), most=most, cell=cell, order=seed)
    np.testing.assert_array_equal(found, whole)
    np.testing.assert_array_equal(kept, np.flatnonzero(whole <= 0.5))
    assert values["selected_vertices"] == np.count_nonzero(whole > 0.5)
    assert values["largest_probability"] == whole.max()
    assert values["mean_probability"] == pytest.approx(whole.mean(), rel=1e-14)


@pytest.mark.parametrize("make", [lattice, one_place])
@settings(max_examples=8)
@given(
    most=st.integers(20, 1200),
    zero=st.sampled_from([0.0, -0.0]),
    seed=st.integers(0, 1000),
)
def test_of_coincident_points_those_stay_that_meshlab_keeps(make: Any, most: int, zero: float, seed: int) -> None:
    """Remove Duplicate Vertices keeps the first of each place, also where one place fills several tiles, and -0 is 0."""
    points = make(seed)
    points[::2][points[::2] == 0] = zero
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points, v_scalar_array=np.arange(len(points), dtype=float)))
    meshes.meshing_remove_duplicate_vertices()
    _, kept, values = by_tiles(points, duplicates(1), most=most, order=seed)
    np.testing.assert_array_equal(kept, meshes.current_mesh().vertex_scalar_array())
    assert values == {"removed_vertices": len(points) - len(kept)}


@pytest.mark.slow
@pytest.mark.parametrize("make", [uneven, lattice, one_place, islands])
@settings(max_examples=8)
@given(
    k=st.integers(1, 30),
    most=st.integers(20, 1200),
    cell=st.integers(2, 100),
    smallest=st.sampled_from([1, 5, 30, 100, 400]),
    seed=st.integers(0, 1000),
)
def test_tiles_find_the_same_stray_points(make: Any, k: int, most: int, cell: int, smallest: int, seed: int) -> None:
    """The same points are stray in tiles of any size, in any order, though parts reach through several of them."""
    points = make(seed)
    stray = stray_points(points, neighbors=k, sparseness=1.5, smallest_part=smallest)
    if stray.all():
        with pytest.raises(FilterInputError, match="nothing is left of the cloud"):
            by_tiles(points, strays(1, k, 1.5, smallest), most=most, cell=cell, order=seed)
        return
    _, kept, values = by_tiles(points, strays(1, k, 1.5, smallest), most=most, cell=cell, order=seed)
    np.testing.assert_array_equal(kept, np.flatnonzero(~stray))
    assert values == {"selected_vertices": np.count_nonzero(stray)}


@pytest.mark.parametrize("most", [50, 10_000])
def test_copies_among_stray_points_are_counted_as_in_one_piece(most: int, tmp_path: Path) -> None:
    """The number of copies is that of one piece, whichever tiles the copies are in; 0 and -0 are one place."""
    random = np.random.default_rng(6)
    clumps = np.repeat(random.uniform(5, 9, (6, 3)), 40, axis=0)
    clumps[:40] = np.where(np.arange(120).reshape(40, 3) % 2, 0.0, -0.0)
    clumps[:40, 2] = 20.0
    points = random.permutation(np.concatenate([uneven(2), clumps]))
    step = strays(1, 12, 1.5, 100)
    layer = View(MeshData(vertices=points), lambda number: MeshData(vertices=points))
    function = find_filter(step.filter).function
    assert function is not None
    edit = function(layer, **step.values)
    cloud = Cloud(PlyFile(tiling.write_cloud(tmp_path / "in.ply", points)), tmp_path)
    for deletes in (False, True):
        selection = replace(step, step=1 + deletes, deletes=deletes)
        known = do_step(cloud, selection, cast("Tasks", tiling.Here()), 10**6, progress=lambda share: None, most=most)[2]
        count = edit.values["selected_vertices"]
        assert found_words(count, len(points), step.values, known["copies"]) == edit.notes
    assert edit.notes[1].startswith(f"{6 * 40 - 6:,} of them are copies of others")


def test_fewer_points_in_a_tile_than_neighbours() -> None:
    """Where a tile has no k points besides each, all neighbours come from the cells around it."""
    points = uneven(3, 200)
    whole = local_outlier_probability(points, neighbors=50, extent=3.0)
    np.testing.assert_array_equal(by_tiles(points, loop(1, 50, 3.0, 0.5), most=25, cell=5)[0], whole)


def test_a_second_selection_sees_what_the_first_has_left(tmp_path: Path) -> None:
    """Two stages give what LoOP gives on the points that LoOP has left; a point keeps the probability of its last stage."""
    points = uneven(1)
    first = local_outlier_probability(points, neighbors=10, extent=2.0)
    left = np.flatnonzero(first <= 0.4)
    second = local_outlier_probability(points[left], neighbors=5, extent=2.0)
    cloud = Cloud(PlyFile(tiling.write_cloud(tmp_path / "in.ply", points)), tmp_path)
    pool = cast("Tasks", tiling.Here())
    for selection in (loop(1, 10, 2.0, 0.4), loop(3, 5, 2.0, 0.6)):
        cloud = do_step(cloud, selection, pool, 10**6, progress=lambda share: None, most=150)[0]
    expected = first.copy()
    expected[left] = second
    np.testing.assert_array_equal(cloud.scalars.read(0, len(points)), expected)
    np.testing.assert_array_equal(np.flatnonzero(cloud.mask(0, len(points))), left[second <= 0.6])


@pytest.mark.parametrize("type_", ["float", "uchar"])
def test_new_values_of_a_property_are_written_as_in_one_piece(type_: str, tmp_path: Path) -> None:
    """Probabilities take the place of `quality` between coordinates, as real numbers, in the bytes that one piece has."""
    points = uneven(2)
    properties = [("double", "x"), (type_, "quality"), ("double", "y"), ("double", "z"), ("int", "label")]
    rows = [(x, number % 200, y, z, number) for number, (x, y, z) in enumerate(points)]
    (tmp_path / "in.ply").write_bytes(ply_file([Element("vertex", properties, rows)]))
    cloud, pool = Cloud(PlyFile(tmp_path / "in.ply"), tmp_path), cast("Tasks", tiling.Here())
    cloud, told, _ = do_step(cloud, loop(1, 10, 2.0, 0.5), pool, 10**6, progress=lambda share: None, most=300)
    assert told["notes"] == ("the outlier probabilities replace the vertex scalars of the mesh",)
    write_cloud(cloud, tmp_path / "out.ply", 100)
    found = local_outlier_probability(points, neighbors=10, extent=2.0)
    mesh = read_file(tmp_path / "in.ply").mesh.with_attributes({"scalars": found}).part(found <= 0.5)
    target = BytesIO()
    write_ply(mesh, target)
    assert (tmp_path / "out.ply").read_bytes() == target.getvalue()
    written = read_file(tmp_path / "out.ply").mesh
    np.testing.assert_array_equal(written.vertices, points[found <= 0.5])
    np.testing.assert_array_equal(written.vertex_scalars, found[found <= 0.5].astype("f4" if type_ == "float" else "f8"))


def test_new_properties_have_the_order_of_one_piece(tmp_path: Path) -> None:
    """Normals and then the probability follow the properties of the file, whichever step comes first."""
    cloud = Cloud(PlyFile(tiling.write_cloud(tmp_path / "in.ply", uneven(4))), tmp_path)
    pool = cast("Tasks", tiling.Here())
    for step in (loop(1, 10, 2.0, 0.4), normals(3, 10, 0)):
        cloud = do_step(cloud, step, pool, 10**6, progress=lambda share: None, most=400)[0]
    write_cloud(cloud, tmp_path / "out.ply", 100)
    names = PlyFile(tmp_path / "out.ply").vertices.dtype.names
    assert names == ("x", "y", "z", "number", "nx", "ny", "nz", "quality")


@pytest.mark.parametrize(("most", "side"), [(60, 0.3), (300, 3.0), (10_000, 0.01)])
@pytest.mark.parametrize("make", [uneven, lattice, one_place])
def test_thinning_by_tiles_keeps_the_same_points(make: Any, most: int, side: float) -> None:
    """The first point of each cell of the grid stays, however the cloud is cut."""
    points = make(most)
    _, kept, values = by_tiles(points, surplus(1, side), most=most)
    np.testing.assert_array_equal(kept, np.flatnonzero(~surplus_points(points, side)))
    assert values == {"selected_vertices": len(points) - len(kept)}


def hillside(seed: int, count: int = 1500) -> Floats:
    """Points on hills, far from the origin, and a ball beside them."""
    random = np.random.default_rng(seed)
    places = random.uniform(0, 10, (count, 2))
    hills = np.column_stack([places, np.sin(places[:, 0]) + 0.3 * np.cos(2 * places[:, 1])])
    ball = random.normal(size=(count // 2, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    points = random.permutation(np.concatenate([hills, np.add(ball, [20, 0, 0])]))
    return cast("Floats", np.add(points, [5e5, 5.4e6, 300.0]))


def normals_by_tiles(points: Floats, step: Any, *, most: int, cell: int = 16, order: int = 0) -> Floats:
    """The normals of all points, as they are written."""
    with tempfile.TemporaryDirectory() as name, mock.patch.object(cells_module, "CELL", cell):
        folder = Path(name)
        cloud = Cloud(PlyFile(tiling.write_cloud(folder / "in.ply", points)), folder)
        pool = cast("Tasks", tiling.Here(order))
        cloud, _, known = do_step(cloud, step, pool, 10**6, progress=lambda share: None, most=most)
        assert known["tiles"] > 1 or most >= len(points)
        assert write_cloud(cloud, folder / "out.ply", 100) == len(points)
        rows = PlyFile(folder / "out.ply").vertices.read(0, len(points))
        np.testing.assert_array_equal(rows["number"], np.arange(len(points)))
        return np.stack([rows[name] for name in ("nx", "ny", "nz")], axis=1)


@pytest.mark.parametrize("iterations", [0, 2])
@pytest.mark.parametrize(("most", "cell"), [(300, 40), (90, 7), (10_000, 512)])
def test_normals_by_tiles_are_those_of_meshlab(iterations: int, most: int, cell: int) -> None:
    """The directions of MeshLab but for rounding, on the side of the view point; the bits do not depend on the tiles."""
    points, view = hillside(1), (5e5 + 3.0, 5.4e6 + 4.0, 420.0)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points - points[0]))
    meshes.compute_normal_for_point_clouds(k=14, smoothiter=iterations, flipflag=True, viewpos=np.array(view) - points[0])
    theirs = meshes.current_mesh().vertex_normal_matrix()
    found = normals_by_tiles(points, normals(1, 14, iterations, view), most=most, cell=cell)
    edgewise = np.abs(np.einsum("ij,ij->i", theirs, view - points)) < 1e-6
    np.testing.assert_allclose(found[~edgewise], theirs[~edgewise], rtol=0.0, atol=1e-8)
    whole = normals_by_tiles(points, normals(1, 14, iterations, view), most=20_000, order=3)
    np.testing.assert_array_equal(found, whole)


@pytest.mark.parametrize(("most", "cell"), [(300, 40), (90, 7), (10_000, 512)])
def test_normals_without_a_view_point_are_turned_alike(most: int, cell: int) -> None:
    """Through all tiles: the hills look up, and the ball looks out or in, as a whole."""
    points = hillside(2)
    found = normals_by_tiles(points, normals(1, 14, 2), most=most, cell=cell, order=most)
    ball = points[:, 0] > 5e5 + 15
    assert (found[~ball, 2] > 0).all()
    out = np.einsum("ij,ij->i", found[ball], points[ball] - [5e5 + 20, 5.4e6, 300.0])
    assert (out > 0).all() or (out < 0).all()


@pytest.mark.parametrize("make", [uneven, lattice, one_place])
def test_normals_of_awkward_clouds_have_directions_that_do_not_depend_on_the_tiles(make: Any) -> None:
    """Ties, coincident points and density that falls a thousandfold: the same directions in many tiles as in one."""
    points = make(3)
    found = normals_by_tiles(points, normals(1, 10, 1, (1.0, 2.0, 3.0)), most=70, cell=9)
    np.testing.assert_array_equal(found, normals_by_tiles(points, normals(1, 10, 1, (1.0, 2.0, 3.0)), most=20_000))


@pytest.mark.parametrize("make", [uneven, lattice, one_place])
@pytest.mark.parametrize("most", [7, 64, 10_000])
def test_a_division_has_each_point_once(make: Any, most: int, tmp_path: Path) -> None:
    """Every bucket holds at most so many points, by ascending number; together they hold each point once, as it was."""
    points = make(0)
    buckets = divide(
        lambda: ((points[at : at + 50], np.arange(at, min(at + 50, len(points)))) for at in range(0, len(points), 50)),
        len(points),
        tmp_path,
        most=most,
    )
    read = [bucket.read() for bucket in buckets]
    assert max(bucket.count for bucket in buckets) <= most
    assert all((np.diff(numbers) > 0).all() for _, numbers in read)
    numbers = np.concatenate([numbers for _, numbers in read])
    np.testing.assert_array_equal(np.sort(numbers), np.arange(len(points)))
    np.testing.assert_array_equal(np.concatenate([places for places, _ in read]), points[numbers])


def test_points_that_are_not_finite_are_refused(tmp_path: Path) -> None:
    """A NaN among the coordinates is named with its number."""
    points = uneven(0)
    points[777, 1] = np.nan
    cloud = Cloud(PlyFile(tiling.write_cloud(tmp_path / "in.ply", points)), tmp_path)
    with pytest.raises(ContentsError, match=r"point 777 is .*nan.* not finite: drop --tiles, and such points are left out"):
        cloud.survey(100)
