"""Steps on meshes by tiles are those of the whole, to the bit, however the mesh is cut."""

from __future__ import annotations

import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast
from unittest import mock

import numpy as np
import pymeshlab
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pymeshfair.declaration import Edit
from pymeshfair.errors import FilterInputError
from pymeshfair.files.errors import ContentsError
from pymeshfair.filters.denoising import FIXED, REPERTOIRE, automatic_choice, denoise_automatically, denoised, preparation
from pymeshfair.filters.diffusion import explicit_smoothing, taubin_fairing
from pymeshfair.filters.inspection import folded_faces
from pymeshfair.mesh_data import MeshData, View
from pymeshfair.registry import find_filter
from pymeshfair.scripts.script import Script, Step
from pymeshfair.tiles import cells as cells_module
from pymeshfair.tiles.mesh import MeshTiles, cut, do_move
from pymeshfair.tiles.plan import MESHLAB, PlannedStep, plan_of, why_not
from pymeshfair.tiles.sources import MeshFile
from pymeshfair.tiles.workers import Tasks
from tests.meshes import icosphere
from tests.tiles.tiling import Here, write_mesh

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
EXPLICIT, TAUBIN = "apply_coord_explicit_smoothing", "apply_coord_taubin_fairing"
NORMALS = "apply_coord_normal_filtering"


def awkward(seed: int) -> tuple[Floats, Ints]:
    """A noisy sphere far from the origin, in no order, with holes, a fin, unused, coincident and wild vertices."""
    random = np.random.default_rng(seed)
    vertices, faces = icosphere(3)
    vertices = vertices * [1.0, 2.0, 0.5] + random.normal(scale=0.02, size=vertices.shape) + [1000.0, -50.0, 7.0]
    faces = np.delete(faces, random.integers(0, len(faces), 60), axis=0)
    n = len(vertices)
    fin = [[faces[5, 0], faces[5, 1], n], [faces[9, 0], n + 1, n + 2], [3, 3, 4]]
    vertices = np.concatenate([vertices, vertices[:3] + 0.3, [[1e6, 0, 0]], vertices[10:12]])
    faces = np.concatenate([faces, fin]).astype(np.int32)
    mixed = random.permutation(len(vertices))
    return vertices[np.argsort(mixed)], mixed[random.permutation(faces)].astype(np.int32)


def by_tiles(vertices: Floats, faces: Ints, *moves: PlannedStep, most: int, cell: int, seed: int = 0) -> Floats:
    """The vertices after the steps, from the file that is written."""
    with tempfile.TemporaryDirectory() as name, mock.patch.object(cells_module, "CELL", cell):
        folder = Path(name)
        mesh = MeshFile(write_mesh(folder / "in.ply", vertices, faces))
        pool = cast("Tasks", Here(seed))
        surface, known = cut(mesh, folder, pool, 10**6, steps=moves, most=most, progress=lambda share: None)
        assert known["faces"] == len(faces)
        tiles = surface.cells.tiles(most)
        assert len(tiles) > 1
        for move in moves:
            do_move(surface, move, tiles, pool, lambda share: None)
        work = MeshTiles(surface)
        pool.map(work.finish, tiles, lambda share: None)
        mesh.write_points(work.results, surface.cells.slots_of_tiles(tiles), folder / "out.ply", 77)
        written = MeshFile(folder / "out.ply")
        np.testing.assert_array_equal(np.concatenate(list(written.faces(100))), faces)
        return np.concatenate(list(written.points(100)))


@pytest.mark.slow
@settings(max_examples=10)
@given(
    operator=st.sampled_from(["uniform", "cotangent"]),
    border=st.sampled_from(["fixed", "along", "free"]),
    update=st.sampled_from(["euler", "meshlab"]),
    iterations=st.integers(0, 6),
    most=st.integers(30, 400),
    cell=st.integers(3, 60),
    seed=st.integers(0, 100),
)
def test_explicit_steps_by_tiles_change_no_bit(
    operator: Any, border: Any, update: Any, iterations: int, most: int, cell: int, seed: int
) -> None:
    """K steps with k rings around each tile are k steps of the whole."""
    vertices, faces = awkward(seed)
    values = {"operator": operator, "step": 0.4, "iterations": iterations, "update": update, "border": border}
    move = PlannedStep(1, EXPLICIT, {**values, "selected": False})
    try:
        whole = explicit_smoothing(vertices, faces, **values)
    except FilterInputError:  # MeshLab's cotangents may throw a vertex away; then tiles name the same
        with pytest.raises(FilterInputError):
            by_tiles(vertices, faces, move, most=most, cell=cell, seed=seed)
        return
    np.testing.assert_array_equal(by_tiles(vertices, faces, move, most=most, cell=cell, seed=seed), whole)


@pytest.mark.parametrize(("most", "cell"), [(300, 40), (90, 7)])
def test_taubin_after_explicit_steps(most: int, cell: int) -> None:
    """A second step begins where the first has ended; Taubin's pairs need two rings each."""
    vertices, faces = awkward(3)
    first = {"operator": "cotangent", "step": 0.3, "iterations": 2, "update": "euler", "border": "free"}
    second = {"operator": "uniform", "step": 0.5, "mu": -0.53, "pass_band": 0.0, "iterations": 3, "border": "along"}
    whole = explicit_smoothing(vertices, faces, **first)  # type: ignore[arg-type]
    whole = taubin_fairing(whole, faces, **{**second, "pass_band": None})  # type: ignore[arg-type]
    moves = PlannedStep(1, EXPLICIT, {**first, "selected": False}), PlannedStep(2, TAUBIN, {**second, "selected": False})
    np.testing.assert_array_equal(by_tiles(vertices, faces, *moves, most=most, cell=cell), whole)


def test_a_run_in_the_folder_of_an_earlier_one_has_cells_of_its_own(tmp_path: Path) -> None:
    """A process that works on two meshes with one folder after the other divides each by its own vertices."""
    step = PlannedStep(1, EXPLICIT, {"iterations": 1})
    for level in (2, 3):
        mesh = MeshFile(write_mesh(tmp_path / "in.ply", *icosphere(level)))
        surface = cut(mesh, tmp_path, cast("Tasks", Here()), 10**6, steps=[step], most=100, progress=lambda share: None)[0]
        assert surface.cells.starts[-1] == surface.cells.count == len(mesh)


@pytest.mark.parametrize(("most", "cell"), [(300, 40), (90, 7)])
def test_taubin_smooth_by_tiles_is_that_of_meshlab(most: int, cell: int) -> None:
    """By tiles MeshLab's filter takes the vertices of an open mesh where it takes them in one piece, but for rounding."""
    random = np.random.default_rng(most)
    vertices, faces = icosphere(3)
    vertices = vertices + random.normal(scale=0.02, size=vertices.shape)
    faces = np.delete(faces, random.integers(0, len(faces), 60), axis=0)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.apply_coord_taubin_smoothing(lambda_=0.4, mu=-0.45, stepsmoothnum=3)
    move = PlannedStep(1, MESHLAB, {"lambda_": 0.4, "mu": -0.45, "stepsmoothnum": 3, "selected": False})
    found = by_tiles(vertices, faces, move, most=most, cell=cell)
    np.testing.assert_allclose(found, meshes.current_mesh().vertex_matrix(), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize(
    ("most", "cell", "settings"),
    [
        (250, 30, {"method": "bilateral", "neighborhood": "vertex", "normal_iterations": 2, "range_sigma": 0.4}),
        (120, 8, {"method": "guided", "neighborhood": "edge", "normal_iterations": 1, "range_sigma": 0.3}),
        (120, 20, {"method": "averaged", "neighborhood": "two_ring", "vertex_update": "ohtake", "border": "free"}),
        (300, 50, {"method": "unilateral", "range_kernel": "tukey", "border": "fixed", "outer_iterations": 4}),
        (200, 16, {"method": "mean", "neighborhood": "three_ring", "normal_iterations": 3, "relaxation": 2}),
        (150, 30, {"method": "mean", "relaxation": 7, "relaxation_direction": "normal", "vertex_iterations": 5}),
        (150, 30, {"method": "mean", "relaxation": 7, "border": "free"}),
    ],
)
def test_normal_filtering_by_tiles_changes_no_bit(most: int, cell: int, settings: dict[str, Any]) -> None:
    """Rounds by tiles, with the mean distance of centres found in a pass before each, are those of the whole."""
    vertices, faces = awkward(most)
    given = {"vertex_iterations": 3, "outer_iterations": 2, **settings}
    fixed = {**asdict(FIXED), **given}
    before = {name: fixed.pop(name) for name in ("relaxation", "relaxation_direction") if name in fixed}
    border = fixed.pop("border", "along")
    whole = denoised(vertices, faces, **before, filtering=fixed, border=border)
    values = find_filter(NORMALS).defaults | {"choice": "fixed", "border": "along"} | given
    found = by_tiles(vertices, faces, PlannedStep(1, NORMALS, values), most=most, cell=cell)
    # Of the way along the surface borders keep a share that comes from sums over all vertices.
    np.testing.assert_allclose(found, whole, rtol=0.0, atol=1e-9 if before and border == "along" else 0.0)
    assert not np.array_equal(whole, vertices)


def test_folded_faces_are_taken_back_across_tiles() -> None:
    """Steps that fold more faces over than before end, by tiles too, with the vertices of the whole, and no more of them."""
    vertices, faces = awkward(2)
    given = {"method": "mean", "vertex_iterations": 3, "outer_iterations": 6}
    filtering = {**asdict(FIXED), **given}
    with mock.patch.object(preparation, "unfolded", lambda before, after, faces: after):
        folding = denoised(vertices, faces, relaxation=20, filtering=filtering)
    before, most = (int(folded_faces(points, faces).sum()) for points in (vertices, folding))
    assert most > before
    values = find_filter(NORMALS).defaults | {"choice": "fixed", "border": "along", "relaxation": 20} | given
    found = by_tiles(vertices, faces, PlannedStep(1, NORMALS, values), most=150, cell=30)
    assert folded_faces(found, faces).sum() <= before
    np.testing.assert_allclose(found, denoised(vertices, faces, relaxation=20, filtering=filtering), rtol=0.0, atol=1e-9)


def in_one_piece(vertices: Floats, faces: Ints, step: PlannedStep) -> Edit:
    """What the filter returns."""
    function, mesh = find_filter(step.filter).function, MeshData(vertices=vertices, faces=faces)
    assert function is not None
    return function(View(mesh, lambda number: mesh), **step.values)


def reported(vertices: Floats, faces: Ints, step: PlannedStep) -> dict[str, Any]:
    """What a step by tiles reports."""
    with tempfile.TemporaryDirectory() as name, mock.patch.object(cells_module, "CELL", 30):
        mesh, pool = MeshFile(write_mesh(Path(name) / "in.ply", vertices, faces)), cast("Tasks", Here())
        surface, _ = cut(mesh, Path(name), pool, 10**6, steps=[step], most=150, progress=lambda share: None)
        return do_move(surface, step, surface.cells.tiles(150), pool, lambda share: None)


@pytest.mark.parametrize("rounds", [0, 2])
def test_notes_on_folded_faces_are_those_of_one_piece(rounds: int) -> None:
    """Slivers and turned faces, which explain folds, are counted once each, in whatever tiles they and their neighbours are."""
    vertices, faces = awkward(3)
    vertices, faces[::7] = vertices * [1.0, 1.0, 0.05], faces[::7, ::-1]
    values = find_filter(NORMALS).with_defaults({"choice": "fixed", "relaxation": 0, "outer_iterations": rounds})
    step = PlannedStep(1, NORMALS, values)
    edit, found = in_one_piece(vertices, faces, step), reported(vertices, faces, step)
    assert len(edit.notes) == 2
    names = ("folded_before", "folded_after")
    assert (found["notes"], [found[name] for name in names]) == (edit.notes, [edit.values[name] for name in names])


@pytest.mark.parametrize("name", [EXPLICIT, TAUBIN, NORMALS])
def test_a_far_vertex_is_refused_as_in_one_piece(name: str) -> None:
    """The refusal names the same vertex, whichever tile it is in."""
    vertices, faces = awkward(4)
    vertices[faces[50, 1]] += 1e15
    step = PlannedStep(1, name, find_filter(name).with_defaults({"choice": "fixed"} if name == NORMALS else {"iterations": 2}))
    with pytest.raises(FilterInputError, match=f"vertex {faces[50, 1]} at .* is so far from the others") as whole:
        in_one_piece(vertices, faces, step)
    with pytest.raises(FilterInputError) as parts:
        reported(vertices, faces, step)
    assert str(parts.value) == str(whole.value)


@pytest.mark.parametrize("given", [{}, {"outliers": "keep", "method": "bilateral"}])
def test_settings_are_chosen_once_for_all_tiles(given: dict[str, Any]) -> None:
    """Of a mesh that is small enough to be looked at as a whole they are those of one piece, and so are the vertices."""
    random = np.random.default_rng(7)
    vertices, faces = icosphere(4)
    vertices = vertices * [1.0, 1.4, 0.7] + random.normal(scale=0.006, size=vertices.shape)
    if given:
        choice = automatic_choice(vertices, faces, repertoire=REPERTOIRE.narrowed(**given))
        whole = choice.setting.apply(vertices, faces, border="along", movable=None)
    else:
        whole, choice = denoise_automatically(vertices, faces)
    assert choice.setting.parameters is not None or choice.setting.relaxation
    found = by_tiles(vertices, faces, PlannedStep(1, NORMALS, find_filter(NORMALS).defaults | given), most=700, cell=64)
    np.testing.assert_array_equal(found, whole)


def test_settings_are_chosen_on_the_same_patches_with_all_sizes_of_tiles(tmp_path: Path) -> None:
    """Cells, of which the patches are made, have the same vertices with little and with much memory."""
    step, numbers = PlannedStep(1, NORMALS, find_filter(NORMALS).defaults), []
    mesh = MeshFile(write_mesh(tmp_path / "in.ply", *icosphere(4)))
    for most in (300, 2000):
        surface = cut(mesh, tmp_path, cast("Tasks", Here()), 10**6, steps=[step], most=most, progress=lambda share: None)[0]
        assert len(surface.cells.tiles(most)) > 1
        numbers.append(surface.cells.numbers.read(0, len(mesh)))
    np.testing.assert_array_equal(numbers[0], numbers[1])


def test_a_mesh_without_noise_stays() -> None:
    """Nothing is chosen, and nothing moves."""
    vertices, faces = icosphere(4)
    found = by_tiles(vertices, faces, PlannedStep(1, NORMALS, find_filter(NORMALS).defaults), most=700, cell=64)
    np.testing.assert_array_equal(found, vertices)


def test_what_is_chosen_but_cannot_be_cut_is_said() -> None:
    """Outliers are replaced in one piece alone, and what to take in its place is said."""
    random = np.random.default_rng(7)
    vertices, faces = icosphere(4)
    vertices = vertices + random.normal(scale=0.002, size=vertices.shape)
    spikes = random.choice(len(vertices), len(vertices) // 8, replace=False)
    vertices[spikes] *= 1.0 + random.normal(scale=0.2, size=(len(spikes), 1))
    with pytest.raises(
        FilterInputError, match=r"outliers '(replace|only)', which needs the whole mesh: .* set outliers to 'keep'"
    ):
        by_tiles(vertices, faces, PlannedStep(1, NORMALS, find_filter(NORMALS).defaults), most=700, cell=64)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"choice": "fixed", "neighborhood": "radius"}, "neighborhood 'radius'"),
        ({"choice": "fixed", "vertex_update": "conjugate_gradient"}, "vertex_update 'conjugate_gradient'"),
        ({"choice": "fixed", "outliers": "replace"}, "outliers 'replace'"),
        ({"neighborhood": "radius"}, "neighborhood 'radius'"),
        ({"choice": "fixed", "selected": True}, "selected vertices"),
    ],
)
def test_what_needs_the_whole_mesh_is_said(values: dict[str, Any], said: str) -> None:
    """Parameters of normal filtering that look at more than rings of faces are refused by their names."""
    assert said in str(why_not(NORMALS, find_filter(NORMALS).defaults | values))


def test_taubin_smooth_without_values_can_be_cut() -> None:
    """A script that names MeshLab's Taubin Smooth alone, without its parameters, is done by tiles."""
    (planned,) = plan_of(Script((Step(find_filter(MESHLAB)),)))
    assert planned.values["stepsmoothnum"] == 10


@pytest.mark.parametrize(
    ("corners", "row", "said"),
    [
        ("list uchar int vertex_indices", b"\4" + bytes(16), "its first face has 4 corners"),
        ("list uchar int vertex_index", b"\0", "its first face has 0 corners"),
        ("int vertex_indices", bytes(4), "it has no faces"),
    ],
)
def test_files_without_triangles_are_refused(corners: str, row: bytes, said: str, tmp_path: Path) -> None:
    """Faces of other sizes, and corners that are a number and no list, are named."""
    places = "".join(f"property float {axis}\n" for axis in "xyz")
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex 1\n{places}element face 1\nproperty {corners}\nend_header\n"
    (tmp_path / "in.ply").write_bytes(head.encode() + bytes(12) + row)
    with pytest.raises(ContentsError, match=said):
        _ = MeshFile(tmp_path / "in.ply").faces_table
