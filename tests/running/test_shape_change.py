"""What a run says of the shape it has changed."""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

from pymeshfair.door import load_unchecked
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.inspection import surface_measures
from pymeshfair.looking.words import change_lines
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import RecipeHead, load_recipe, shipped_heads
from pymeshfair.running.job import plain
from pymeshfair.running.shape_change import Origins, ShapeChange, find_origins, milder, shape_change, warnings_of
from pymeshfair.scripts.changing import override
from tests.commands.command_line import document, run_process
from tests.meshes import Mesh, cube, grid, icosphere, rotation


def change_of(before: Mesh, after: Mesh) -> ShapeChange:
    """The change from one mesh to another."""
    first, second = (MeshData(vertices=v, faces=f) for v, f in (before, after))
    same = len(first.vertices) == len(second.vertices)
    numbers = [np.arange(n) if same else np.full(n, -1) for n in (len(second.vertices), len(second.faces))]
    origins = Origins(first, second, numbers[0], numbers[1], followed=same)
    return shape_change(origins, (surface_measures(*before), surface_measures(*after)))


def test_a_stretched_sphere() -> None:
    """Twice as long along x is +100 % there and in volume; the pole of x moves furthest, by its coordinate."""
    vertices, faces = icosphere(3)
    found = change_of((vertices, faces), (vertices * [2.0, 1.0, 1.0], faces))
    assert found.sides == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    assert found.volume == pytest.approx(1.0)
    assert found.moved is not None
    assert found.moved.largest == pytest.approx(np.abs(vertices[:, 0]).max())
    assert found.moved.place[0] == pytest.approx(2.0 * vertices[found.moved.vertex, 0])
    assert found.turned == 0
    steps = load_recipe("smooth_implicit").script.steps
    (dimensions, moved) = warnings_of(found, steps, lambda: "another")
    assert dimensions.endswith("To keep them: a smaller value of detail_size than 'auto' takes, or take another")
    assert f"vertex {found.moved.vertex} at " in moved


@pytest.mark.parametrize("factor", [1.0, -1.0, 1000.0, 1e-3])
def test_a_mesh_that_moves_as_a_whole_keeps_its_details(factor: float) -> None:
    """Turned, mirrored, scaled and shifted by many edges a pleated sheet keeps relief and sharp edges, and its sides are true."""
    vertices, faces = grid(40, 40)
    vertices = vertices + np.array([0.0, 0.0, 2.5]) * np.abs(vertices[:, :1] % 10.0 / 5.0 - 1.0)
    found = change_of((vertices, faces), (factor * vertices @ rotation().T + [50.0, -30.0, 20.0], faces))
    assert found.sharp_kept == pytest.approx(1.0)
    assert found.relief_lost == pytest.approx(0.0, abs=1e-6)
    assert found.turned == 0
    assert found.sides_without_noise == pytest.approx(found.sides, rel=1e-9)


def test_moves_of_a_cloud_are_in_mean_spacings() -> None:
    """A point of a square lattice that rises by 40 times the spacing is named so in the warning and in both lines."""
    vertices, none = grid(9, 9, spacing=0.5)[0], np.empty((0, 3), dtype=np.int32)
    found = change_of((vertices, none), (vertices + 20.0 * (np.arange(len(vertices)) == 40)[:, None] * [0.0, 0.0, 1.0], none))
    (text,) = warnings_of(found, (), str)
    assert "moved by 20 (40.0 mean spacings): look at the place" in text
    first, *_, last = change_lines(plain(asdict(found)))
    assert first.endswith("mean spacings on average, 40 at most")
    assert "at most 20 (40 mean spacings), vertex 40" in last


@pytest.mark.parametrize("head", shipped_heads(), ids=lambda head: head.name)
def test_a_recipe_is_told_what_it_has(head: RecipeHead) -> None:
    """What a warning advises is a setting of the recipe or a parameter of its steps; the region of fair_selection has none."""
    script = load_recipe(head.name).script
    said = milder(script.steps)
    names = {s.name for s in script.settings} | {p.name for step in script.steps for p in step.filter.parameters}
    assert not said or said.removeprefix("a smaller value of ").removesuffix(" than 'auto' takes") in names
    assert not said or head.name != "fair_selection"


def test_the_step_that_smoothed_first_is_to_do_less() -> None:
    """clean_range_map removes noise by itself, and waves of detail_size only if that is set."""
    script = load_recipe("clean_range_map").script
    assert milder(script.steps) == "a smaller value of outer_iterations than 'auto' takes"
    assert milder(override(script, ("detail_size=6edge",)).steps) == "a smaller value of detail_size"


def test_what_does_nothing_is_not_to_be_smaller() -> None:
    """The spectral low pass ignores its gain: the advice is another detail size, also if the filter chooses that itself."""
    script = override(load_recipe("spectral_low_pass").script, ("detail_size=auto",))
    assert milder(script.steps) == "a smaller value of detail_size than 'auto' takes"
    assert milder(load_recipe("enhance_details").script.steps) == "a smaller value of gain"


def test_a_gain_below_1_is_milder_if_larger() -> None:
    """A gain of 1 changes nothing, and one of 0 removes all relief."""
    script = override(load_recipe("enhance_details").script, ("gain=0.5",))
    assert milder(script.steps) == "a larger value of gain"


def test_much_new_surface_is_a_warning() -> None:
    """A sheet of a square to which one as large is added has as much new surface as it had."""
    vertices, faces = grid(3, 3)
    more = len(vertices)
    both = np.concatenate([vertices, vertices + 9.0]), np.concatenate([faces, faces + np.int32(more)])
    before, after = (MeshData(vertices=v, faces=f) for v, f in ((vertices, faces), both))
    numbers = [np.concatenate([np.arange(n), np.full(n, -1)]) for n in (more, len(faces))]
    found = shape_change(
        Origins(before, after, numbers[0], numbers[1], followed=True),
        (surface_measures(vertices, faces), surface_measures(*both)),
    )
    (text,) = warnings_of(found, (), str)
    assert text.startswith("new surface was added without measurements, 100% of the scanned area")


def test_a_wrap_that_goes_inside_is_a_warning() -> None:
    """A sphere in a sphere of the same size has twice the area of the one that was scanned."""
    vertices, faces = icosphere(2)
    both = np.concatenate([vertices, vertices]), np.concatenate([faces, faces[:, ::-1] + np.int32(len(vertices))])
    (text,) = warnings_of(change_of((vertices, faces), both), (), str)
    assert text.startswith("the new surface has 100% more area than the scan")
    assert "prepare_for_print" in text


def test_faces_that_turned_over_are_counted() -> None:
    """A reflection in a point leaves the directions of all faces as they are; a fold turns one over."""
    vertices, faces = icosphere(2)
    mirrored = vertices * -1.0
    assert change_of((vertices, faces), (mirrored, faces)).turned == 0
    flat: NDArray[np.float64] = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    triangles = np.array([[0, 1, 2], [1, 3, 2]], dtype=np.int32)
    folded = flat.copy()
    folded[3] = [0.25, 0.25, 0.0]
    assert change_of((flat, triangles), (folded, triangles)).turned == 1


#: a chevron whose corner in the middle sees all of its border, which the mean of the others does not, and a frame around it
CHEVRON = np.array([[0.0, 0, 0], [0, -0.5, 0], [4, 4, 0], [0, 0.5, 0], [-4, 4, 0], [0, -6, 0], [9, 9, 0], [0, 12, 0], [-9, 9, 0]])
AROUND = np.array([[0, i, j] for i, j in ((1, 2), (2, 3), (3, 4), (4, 1))], dtype=np.int32)
FRAME = np.array([[[i, i + 4, j + 4], [i, j + 4, j]] for _, i, j in AROUND], dtype=np.int32).reshape(-1, 3)
FRAMED = np.concatenate([AROUND, FRAME])


def test_faces_that_were_folded_over_are_a_warning_with_a_place() -> None:
    """The mean of the neighbours lies outside of the chevron: two faces fold over, and one of them is named with its centre."""
    moved = CHEVRON.copy()
    moved[0, 1] = 2.0
    found = change_of((CHEVRON, FRAMED), (moved, FRAMED))
    assert found.folded is not None
    assert (found.folded.count, found.folded.face) == (2, 1)
    assert found.folded.place == pytest.approx((4 / 3, 6.5 / 3, 0.0))
    (text,) = warnings_of(found, (), str)
    assert text.startswith("2 faces were folded over, the largest is face 1 at (1.33333, 2.16667, 0): look at the place")
    assert change_of((moved, FRAMED), (CHEVRON, FRAMED)).folded is None


def test_other_elements_have_no_displacement_and_no_warning() -> None:
    """Where a new mesh was made all counts as removed and added, and the shape was changed on purpose."""
    vertices, faces = icosphere(2)
    found = change_of((vertices, faces), (vertices[:100], np.empty((0, 3), dtype=np.int32)))
    assert found.moved is not None
    assert not found.moved.same
    assert found.moved.largest == 0.0
    assert (found.removed.faces, found.removed.loose) == (len(faces), 1)
    assert found.removed.share == pytest.approx(1.0)
    assert (found.added.vertices, found.added.faces) == (100, 0)
    assert list(warnings_of(found, (), str)) == []


def test_pieces_that_were_removed_are_listed_by_area() -> None:
    """Floating squares of 8 faces and of 2, of 95 square units in all: each with its share, its size and its place."""
    (sheet, of_sheet), (large, of_large), (small, of_small) = grid(9, 10), grid(2, 2), grid(1, 1)
    vertices = np.concatenate([sheet, large + np.array([20.0, 0.0, 5.0]), small + np.array([40.0, 0.0, 0.0])])
    faces = np.concatenate([of_sheet, of_large + len(sheet), of_small + len(sheet) + len(large)]).astype(np.int32)
    first, second = MeshData(vertices=vertices, faces=faces), MeshData(vertices=sheet, faces=of_sheet)
    origins = Origins(first, second, np.arange(len(sheet)), np.arange(len(of_sheet)), followed=True)
    change = shape_change(origins, (surface_measures(vertices, faces), surface_measures(sheet, of_sheet)))
    assert [(piece.faces, piece.place) for piece in change.removed.largest] == [(8, (21.0, 1.0, 5.0)), (2, (40.5, 0.5, 0.0))]
    assert [piece.share for piece in change.removed.largest] == pytest.approx([4.0 / 95.0, 1.0 / 95.0])
    assert [piece.size for piece in change.removed.largest] == pytest.approx([8.0**0.5, 2.0**0.5])
    lines = change_lines(plain(asdict(change)))
    assert "  removed: 8 faces, 4.21 % of the area, 2.83 across, at 21, 1, 5" in lines


def test_smoothing_runs_say_what_is_left_of_relief_and_of_sharp_edges() -> None:
    """Bumps halved leave half of the relief, a box scaled to a flat one its edges; where nothing moves nothing is said."""
    vertices, faces = icosphere(4)
    x, y, z = 9.0 * vertices.T
    bumps = vertices * (1.0 + 0.02 * np.sin(x) * np.sin(y) * np.cos(z))[:, None]
    halved = change_of((bumps, faces), (0.5 * (bumps + vertices), faces))
    assert halved.relief_lost == pytest.approx(0.5, abs=0.05)
    (line,) = (line for line in change_lines(plain(asdict(halved))) if line.startswith("kept: "))
    assert line.endswith(" % of the relief apart from noise")
    box, sides = cube()
    assert change_of((box, sides), (box * [1.0, 1.0, 0.9], sides)).sharp_kept == pytest.approx(1.0)
    still = change_of((box, sides), (box, sides))
    assert (still.relief_lost, still.sharp_kept) == (None, None)


def test_spikes_that_are_taken_away_are_no_relief() -> None:
    """Where a tenth of the vertices of a bumpy ball is off by an edge, and they go back, nothing is said of its relief."""
    vertices, faces = icosphere(4)
    x, y, z = 9.0 * vertices.T
    bumps = vertices * (1.0 + 0.02 * np.sin(x) * np.sin(y) * np.cos(z))[:, None]
    rng = np.random.default_rng(0)
    hit = rng.random((len(bumps), 1)) < 0.1
    spiked = bumps + rng.normal(scale=mean_edge_length(bumps, faces), size=bumps.shape) * hit
    assert change_of((spiked, faces), (bumps, faces)).relief_lost is None


def test_words_on_faces_that_were_turned_over_say_whether_that_is_a_fault() -> None:
    """Two faces of the chevron fold over, which is one; turned back they are none."""
    folded = CHEVRON.copy()
    folded[0, 1] = 2.0
    changes = [change_of((a, FRAMED), (b, FRAMED)) for a, b in ((CHEVRON, folded), (folded, CHEVRON))]
    bad, good = (change_lines(plain(asdict(change)))[-1] for change in changes)
    assert bad == "turned over: 2 faces, a fault: more faces are folded over than before"
    assert good == "turned over: 2 faces, no fault: no more faces are folded over than before"


@pytest.mark.parametrize("scale", [1e-160, 1e150])
def test_sizes_at_the_ends_of_the_numbers(scale: float) -> None:
    """No square of a length leaves the range of numbers."""
    vertices, faces = icosphere(2)
    moved = change_of((vertices * scale, faces), (vertices * (1.5 * scale), faces)).moved
    assert moved is not None
    assert moved.mean == pytest.approx(0.5 * scale)


def test_noise_at_the_ends_is_no_change_of_dimensions() -> None:
    """The box around noise of half an edge is larger by some three deviations at each end; taking it off warns of nothing."""
    vertices, faces = icosphere(4)
    edge = mean_edge_length(vertices, faces)
    noisy = vertices * (1.0 + np.random.default_rng(4).normal(scale=0.5 * edge, size=(len(vertices), 1)))
    found = change_of((noisy, faces), (vertices, faces))
    assert all(side is not None and side < -0.02 for side in found.sides)
    assert list(warnings_of(found, (), str)) == []
    smaller = change_of((noisy, faces), (vertices * 0.97, faces))
    assert smaller.sides_without_noise == pytest.approx([-0.03] * 3, abs=0.01)
    (text,) = warnings_of(smaller, (), str)
    assert "not only because noise is gone: x -" in text


SHRINK = """<!DOCTYPE FilterScript>
<FilterScript>
  <filter name="Laplacian Smooth">
    <Param type="RichInt" name="stepSmoothNum" value="3"/>
    <Param type="RichBool" name="Boundary" value="true"/>
    <Param type="RichBool" name="cotangentWeight" value="true"/>
    <Param type="RichBool" name="Selected" value="false"/>
  </filter>
</FilterScript>
"""


EVEN = """<!DOCTYPE FilterScript>
<FilterScript>
  <filter name="Conditional Vertex Selection">
    <Param type="RichString" name="condSelect" value="(x == 0) &amp;&amp; (y == 0)"/>
  </filter>
  <filter name="Explicit Smoothing">
    <Param type="RichFloat" name="step" value="1"/>
    <Param type="RichInt" name="iterations" value="1"/>
    <Param type="RichBool" name="selected" value="true"/>
  </filter>
</FilterScript>
"""


def test_a_run_warns_of_folded_faces_and_shows_them(tmp_path: Path) -> None:
    """The table has the folded faces before and after, the terminal the warning."""
    lines = ["OFF", f"{len(CHEVRON)} {len(FRAMED)} 0", *(f"{x} {y} {z}" for x, y, z in CHEVRON)]
    (tmp_path / "chevron.off").write_text("\n".join([*lines, *(f"3 {a} {b} {c}" for a, b, c in FRAMED)]) + "\n")
    (tmp_path / "even.mlx").write_text(EVEN)
    ran = run_process("run", tmp_path / "even.mlx", tmp_path / "chevron.off", "-o", tmp_path / "even.off")
    assert "2 faces were folded over" in ran.stderr
    assert re.search(r"folded faces +0 +2 *\n", ran.stdout)


def test_a_run_says_it(tmp_path: Path) -> None:
    """The document of a run has the change, the table a line of it, and shrinking by more than 1 % is a warning."""
    vertices, faces = icosphere(2)
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0", *(f"{x} {y} {z}" for x, y, z in vertices)]
    (tmp_path / "ball.off").write_text("\n".join([*lines, *(f"3 {a} {b} {c}" for a, b, c in faces)]) + "\n")
    (tmp_path / "shrink.mlx").write_text(SHRINK)
    ran = run_process("run", tmp_path / "shrink.mlx", tmp_path / "ball.off", "-o", tmp_path / "small.off", "--json")
    change = document(ran.stdout)["change"]
    assert change["sides"] == pytest.approx([change["sides"][0]] * 3, abs=0.01)
    assert change["sides"][0] < -0.02
    assert change["moved"]["mean"] == pytest.approx(-change["sides"][0], rel=0.2)
    assert "the shape's dimensions changed, not only because noise is gone: x -" in ran.stderr


def test_vertices_of_a_file_that_meshlab_reads_are_followed(tmp_path: Path) -> None:
    """Each vertex of an unchanged mesh is the one with the same number in the file."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*cube()))
    meshes.save_current_mesh(str(tmp_path / "cube.ctm"))
    mesh = load_unchecked(tmp_path / "cube.ctm", tmp_path / "meshlab").mesh
    np.testing.assert_array_equal(find_origins(mesh, mesh).vertices, np.arange(8))
