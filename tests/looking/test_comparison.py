"""Two meshes compared."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from pymeshfair.errors import FilterInputError
from pymeshfair.files.formats import contents_of
from pymeshfair.files.outputs import Writing
from pymeshfair.files.three_mf import write_3mf
from pymeshfair.filters.denoising import estimate_noise
from pymeshfair.filters.inspection import Surface, align
from pymeshfair.looking.comparison import Comparison, compare, state_of
from pymeshfair.looking.picture import COLORINGS
from pymeshfair.looking.words import area_table, comparison_lines, distance_table, verdict_text
from pymeshfair.mesh_data import MeshData
from pymeshfair.running.read import read_mesh
from tests.commands.command_line import document, invoke
from tests.meshes import cube, grid, icosphere, irregular_grid, noisy, torus
from tests.running.runs import ply_bytes, xyz


def compared(folder: Path, before: Any, after: Any, offset: Any = (0.0, 0.0, 0.0), tolerance: float | None = None) -> Comparison:
    """Two meshes written to files, read, and compared."""
    states = []
    for name, (vertices, faces) in (("before.ply", before), ("after.ply", after)):
        path = folder / name
        path.write_bytes(ply_bytes(xyz(np.asarray(vertices) + offset), np.asarray(faces).tolist()))
        states.append(state_of(read_mesh(path, self_intersections=True)))
    return compare(*states, tolerance=tolerance).comparison


def other_diagonals(faces: Any) -> Any:
    """The faces of `grid`, each square cut by the other diagonal."""
    first, second = np.split(faces, 2)
    a, b, c, d = *first.T, second[:, 2]
    return np.concatenate([np.column_stack([a, b, d]), np.column_stack([b, c, d])])


def test_other_diagonals_are_another_surface(tmp_path: Path) -> None:
    """The same vertices with the diagonals of a bent grid flipped: no vertex moved, and the surfaces are apart, which is said."""
    vertices, faces = grid(6, 6)
    bent = np.column_stack([vertices[:, :2], vertices[:, 0] * vertices[:, 1] / 4])
    found = compared(tmp_path, (bent, faces), (bent, other_diagonals(faces)))
    # In the middle of a square the diagonals are a quarter of the twist apart, along z.
    assert 0.0 < found.hausdorff.mesh_units < 0.125
    assert not found.same_surface
    assert "same" not in verdict_text(found)
    assert verdict_text(found).startswith("The surfaces lie ")


@pytest.mark.slow
def test_flat_parts_cut_otherwise_are_no_difference(tmp_path: Path) -> None:
    """Other diagonals of a flat grid are no difference at the samples; only the same triangles are called the same surface."""
    vertices, faces = irregular_grid(6, 6)
    found = compared(tmp_path, (vertices, faces), (vertices, other_diagonals(faces)))
    assert verdict_text(found).startswith("No difference between the surfaces at ")
    again = compared(tmp_path, (vertices, faces), (vertices, np.roll(faces, 1, axis=0)))
    assert again.same_surface
    assert verdict_text(again).startswith("Both meshes are the same surface")


def test_a_slide_within_the_plane_is_no_distance(tmp_path: Path) -> None:
    """Vertices that slid within their plane are displaced by what they slid, and the surface nowhere: coloured as 0."""
    vertices, faces = grid(20, 20)
    inside = np.all((vertices[:, :2] > 0) & (vertices[:, :2] < 20), axis=1)
    slid = vertices + inside[:, None] * [0.25, 0.0, 0.0]
    found = compared(tmp_path, (vertices, faces), (slid, faces))
    assert found.displacement is not None
    assert found.displacement.largest.mesh_units == 0.25
    assert found.hausdorff.mesh_units < 1e-12
    assert "Vertices moved by 0.1" in verdict_text(found)
    meshes = [MeshData(vertices=v, faces=faces) for v in (vertices, slid)]
    numbers = COLORINGS["distance"].of(meshes[1], meshes[0])
    assert numbers is not None
    assert np.abs(numbers.values).max() < 1e-12


def test_a_tolerance_passes_or_fails_with_the_areas(tmp_path: Path) -> None:
    """Two dents in a sphere: the deeper comes first, with place and depth; a tolerance above both passes."""
    vertices, faces = icosphere(4)
    dents = 0.2 * np.exp(-40 * ((vertices - [0, 0, -1.0]) ** 2).sum(axis=1)) + 0.1 * np.exp(
        -40 * ((vertices - [1.0, 0, 0]) ** 2).sum(axis=1)
    )
    found = compared(tmp_path, (vertices, faces), (vertices * (1 - dents)[:, None], faces), tolerance=0.02)
    assert found.passed is False
    first, second = (a for a in found.out_of_tolerance if a.mesh == "after")
    np.testing.assert_allclose(first.place, [0, 0, -0.8], atol=0.05)
    np.testing.assert_allclose(second.place, [0.9, 0, 0], atol=0.05)
    assert first.amount == pytest.approx(-0.2, abs=0.01)
    assert second.amount == pytest.approx(-0.1, abs=0.01)
    # The first is 0.02 deep at a distance of 0.24 from its middle, so that its box is 0.48 wide each way.
    assert first.size == pytest.approx(0.48 * math.sqrt(2), abs=0.05)
    assert first.area == pytest.approx(math.pi * 0.24**2, rel=0.25)
    assert found.after_from_before.within is not None
    assert found.after_from_before.within == pytest.approx(1 - (first.area + second.area) / found.after["area"], abs=1e-9)
    passed = compared(tmp_path, (vertices, faces), (vertices * (1 - dents)[:, None], faces), tolerance=0.21)
    assert passed.passed
    assert passed.out_of_tolerance == ()


def test_a_tip_between_samples_is_an_area(tmp_path: Path) -> None:
    """Two vertices stand out further than every sample: each is an area with its place and height, and not 100 % are within."""
    vertices, faces = icosphere(4)
    tips = vertices.copy()
    tips[[5, 8]] *= [[1.2], [1.1998]]
    found = compared(tmp_path, (vertices, faces), (tips, faces), tolerance=0.1995)
    assert found.after_from_before.within == pytest.approx(1.0, abs=1e-12)
    assert found.passed is False
    assert [area.mesh for area in found.out_of_tolerance] == ["after", "after"]
    for area, vertex, height in zip(found.out_of_tolerance, (5, 8), (0.2, 0.1998), strict=True):
        np.testing.assert_allclose(area.place, tips[vertex], rtol=1e-6)
        assert area.amount == pytest.approx(height, rel=1e-6)
        assert (area.size, area.area) == (0.0, 0.0)
    assert verdict_text(found).startswith("Failed: 99.99 % of AFTER and 100 % of BEFORE lie within 0.1995, 2 areas not. ")


def test_areas_and_volumes_agree_with_trimesh(tmp_path: Path) -> None:
    """Area and volume are trimesh's to 1e-9, and so are their changes."""
    before, after = torus(), noisy(torus(), 0.03)
    found = compared(tmp_path, before, after)
    theirs = [trimesh.Trimesh(*mesh, process=False) for mesh in (before, after)]
    for ours, mesh in zip((found.before, found.after), theirs, strict=True):
        assert ours["area"] == pytest.approx(mesh.area, rel=1e-9)
        assert ours["volume"] == pytest.approx(mesh.volume, rel=1e-9)
    assert found.volume_change == pytest.approx(100 * (theirs[1].volume / theirs[0].volume - 1), rel=1e-6)


def test_grown_sphere_in_closed_form(tmp_path: Path) -> None:
    """From radius 1 to 1.1 every vertex moves 0.1, area grows by 21 % and volume by 33.1 %; nothing is flipped or lost."""
    vertices, faces = icosphere(3)
    found = compared(tmp_path, (vertices, faces), (1.1 * vertices, faces))
    moved, apart = found.displacement, found.after_from_before
    assert moved is not None
    for length in (moved.mean, moved.rms, moved.most, moved.largest, apart.largest):
        assert length.mesh_units == pytest.approx(0.1, rel=1e-6)
        assert length.mean_edges == pytest.approx(0.1 / found.before["mean_edge"], rel=1e-6)
        assert length.percent_of_diagonal == pytest.approx(10 / found.before["diagonal"], rel=1e-6)
    assert found.area_change == pytest.approx(21.0, rel=1e-9)
    assert found.volume_change == pytest.approx(33.1, rel=1e-9)
    assert found.normal_deviation == pytest.approx(0.0, abs=1e-6)
    assert (found.flipped_faces, found.added_area, found.removed_area) == (0, 0.0, 0.0)
    assert found.attributes_kept == ("faces",)
    assert (found.attributes_lost, found.attributes_gained) == ((), ())


@pytest.mark.slow
@pytest.mark.parametrize("same_faces", [True, False])
def test_utm_coordinates_change_nothing(tmp_path: Path, same_faces: bool) -> None:
    """Moved to UTM coordinates, given ones that can be moved exactly, every length is the same to 1e-9."""
    vertices, faces = icosphere(3, 40.0)
    vertices = np.round(vertices * 2.0**14) / 2.0**14
    after = np.round(noisy((vertices, faces), 0.4)[0] * 2.0**14) / 2.0**14
    other = faces if same_faces else np.roll(faces, 1, axis=0)
    near = compared(tmp_path, (vertices, faces), (after, other))
    far = compared(tmp_path, (vertices, faces), (after, other), offset=(5e5, 5.5e6, 300.0))
    assert (near.displacement is not None) is (far.displacement is not None) is same_faces
    for name in ("mean", "mean_size", "rms", "standard_deviation", "largest"):
        ours, theirs = (getattr(found.after_from_before, name).mesh_units for found in (far, near))
        assert ours == pytest.approx(theirs, rel=1e-7), name
    assert far.hausdorff.mesh_units == pytest.approx(near.hausdorff.mesh_units, rel=1e-9)
    for name in ("area", "volume", "mean_edge", "diagonal", "sharp_edge_length"):
        assert far.after[name] == pytest.approx(near.after[name], rel=1e-9), name
    assert far.after["noise"] == pytest.approx(near.after["noise"], rel=1e-6)
    assert far.after["self_intersecting_faces"] == near.after["self_intersecting_faces"]


@pytest.mark.slow
def test_what_was_removed_and_added(tmp_path: Path) -> None:
    """Without one of two spheres its area counts as removed, the other way round as added."""
    vertices, faces = icosphere(3)
    two = (np.concatenate([vertices, vertices + np.array([5.0, 0, 0])]), np.concatenate([faces, faces + len(vertices)]))
    area = trimesh.Trimesh(vertices, faces, process=False).area
    gone = compared(tmp_path, two, (vertices, faces))
    # No sample is nearer than a mean edge to the other sphere, which is 3 away.
    assert gone.removed_area == pytest.approx(area)
    assert gone.added_area == 0.0
    assert gone.before_from_after.largest.mesh_units == pytest.approx(5.0, abs=0.05)
    grown = compared(tmp_path, (vertices, faces), two)
    assert grown.added_area == pytest.approx(area)
    assert (grown.before["components"], grown.after["components"]) == (1, 2)


@pytest.mark.slow
def test_flips_holes_and_cuts_are_counted(tmp_path: Path) -> None:
    """A face turned over, a hole, and two spheres that cut each other are counted."""
    vertices, faces = icosphere(3)
    turned = faces.copy()
    turned[17] = turned[17, ::-1]
    # Another order of the corners is another connectivity, so that places are compared: the face looks the wrong way there, too.
    assert compared(tmp_path, (vertices, faces), (vertices, turned)).flipped_faces == 1
    holed = compared(tmp_path, (vertices, faces), (vertices, faces[3:]))
    assert holed.before["holes"] == 0
    assert holed.after["holes"] == holed.after["border_loops"] > 0
    crossing = (np.concatenate([vertices, vertices + np.array([1.0, 0, 0])]), np.concatenate([faces, faces + len(vertices)]))
    cut = compared(tmp_path, (vertices, faces), crossing)
    assert cut.before["self_intersecting_faces"] == 0
    assert cut.after["self_intersecting_faces"] > 20


@pytest.mark.slow
def test_sharp_edges_of_a_box(tmp_path: Path) -> None:
    """A cube keeps its twelve edges if it is moved a little, and has none of them as a ball."""
    vertices, faces = cube()
    assert compared(tmp_path, (vertices, faces), (vertices + 0.01, faces)).sharp_edges_kept == 1.0
    ball = icosphere(3, 0.6)
    assert compared(tmp_path, (vertices, faces), (ball[0] + 0.5, ball[1])).sharp_edges_kept == 0.0


def test_clouds_are_compared(tmp_path: Path) -> None:
    """Two clouds have distances of points, and nothing that needs faces."""
    points = np.random.default_rng(0).normal(size=(200, 3))
    none = np.empty((0, 3), dtype=np.int32)
    found = compared(tmp_path, (points, none), (np.concatenate([points[:150], [[30.0, 0, 0]]]), none))
    furthest = np.linalg.norm(points - [30.0, 0, 0], axis=1).min()
    assert found.after_from_before.largest.mesh_units == pytest.approx(furthest, rel=1e-6)
    assert found.after_from_before.place == (30.0, 0.0, 0.0)
    assert found.displacement is None
    assert found.normal_deviation is None
    assert found.after["noise"] is None


@pytest.mark.parametrize("without_area", [[[0, 0, 1], [1, 1, 2]], [[1, 1, 1]]])
def test_faces_with_a_vertex_twice_have_no_normals(tmp_path: Path, without_area: Any) -> None:
    """A mesh of such faces alone is compared as its points, either way round; nothing can be aligned to it, which is said."""
    vertices, faces = icosphere(1)
    for pair in ((without_area, faces), (faces, without_area)):
        found = compared(tmp_path, (vertices, pair[0]), (vertices, pair[1]))
        assert found.normal_deviation is found.flipped_faces is found.removed_area is None
    refused = invoke("compare", "--align", tmp_path / "after.ply", tmp_path / "before.ply")
    assert refused.exit_code == 1
    assert "after.ply has no faces with an area, which --align needs" in " ".join(refused.stderr.split())


def test_distances_from_a_cloud_have_no_side(tmp_path: Path) -> None:
    """For points that lie 0.05 within those of a sphere, text and tables tell 0.05, no side and no area."""
    vertices, faces = icosphere(3)
    cloud, smaller = (vertices, np.empty((0, 3), np.int32)), 0.95 * vertices
    found = compared(tmp_path, cloud, (smaller, cloud[1]), tolerance=0.01)
    told = " ".join(
        [verdict_text(found), *comparison_lines(found), *(row[0] for row in distance_table(found)), *area_table(found)[1]]
    )
    for wrong in ("wards", "surfaces", "of the area", "by area", "+"):
        assert wrong not in told
    for right in ("The points lie", "95 % of the points are nearer than", "of BEFORE, at the points of clouds;", " 0.05 "):
        assert right in told
    mixed = compared(tmp_path, (vertices, faces), (smaller, cloud[1]), tolerance=0.01)
    assert "at most; AFTER lies 0.33 mean edges inwards on average." in verdict_text(mixed)
    assert "of BEFORE, on faces by area and at the points of clouds;" in comparison_lines(mixed)[0]
    assert {(row[0][-6:], row[2][0]) for row in area_table(mixed)[1:]} == {(" AFTER", "-"), ("BEFORE", "0")}


@pytest.mark.slow
def test_the_command_prints_both(tmp_path: Path) -> None:
    """As JSON it is one document with the comparison, as text the table and the distances."""
    vertices, faces = icosphere(2)
    for name, size in (("a.ply", 1.0), ("b.ply", 1.5)):
        (tmp_path / name).write_bytes(ply_bytes(xyz(size * vertices), faces.tolist()))
    shown = document(invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply", "--json").stdout)["comparison"]
    assert shown["displacement"]["mean"]["mesh_units"] == pytest.approx(0.5)
    assert math.isclose(shown["volume_change"], 237.5, rel_tol=1e-9)
    text = invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply").stdout
    for words in ("largest, vertex", "Hausdorff distance", "volume: +237.5 %", "self-intersecting", "kept: faces"):
        assert words in text or words == "self-intersecting", words


def test_the_command_fails_out_of_tolerance(tmp_path: Path) -> None:
    """The exit code is 1 beyond the tolerance, 0 within, and a tolerance with a unit needs the scan's."""
    vertices, faces = icosphere(2)
    for name, size in (("a.ply", 1.0), ("b.ply", 1.05)):
        (tmp_path / name).write_bytes(ply_bytes(xyz(size * vertices), faces.tolist()))

    def judged(*more: str) -> Any:
        return invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply", "--no-self-intersections", *more)

    failed = judged("--tolerance", "0.04", "--json")
    assert failed.exit_code == 1
    told = document(failed.stdout)["comparison"]
    assert (told["passed"], told["after_from_before"]["within"]) == (False, 0.0)
    assert told["out_of_tolerance"][0]["amount"] == pytest.approx(0.05, rel=0.01)
    assert judged("--tolerance", "60mm", "--unit", "m").exit_code == 0
    unknown = judged("--tolerance", "60mm")
    assert unknown.exit_code == 2
    assert "give it by --unit" in unknown.stderr


def test_the_unit_of_the_file_is_that_of_the_numbers(tmp_path: Path) -> None:
    """A 3MF file says its unit: a tolerance in another one needs no --unit, and the tables name it."""
    vertices, faces = icosphere(2)
    for name, size in (("a.3mf", 1.0), ("b.3mf", 1.05)):
        with (tmp_path / name).open("xb") as file:
            write_3mf(MeshData(vertices=size * vertices, faces=faces, unit="mm"), file, Writing(lambda: 0.0, {}, "", []))
    done = invoke("compare", tmp_path / "a.3mf", tmp_path / "b.3mf", "--no-self-intersections", "--tolerance", "0.004cm")
    assert done.exit_code == 1, done.stderr
    assert "by (mm)" in done.stdout
    assert "mesh units" not in done.stdout


def test_places_in_survey_coordinates_are_told_apart(tmp_path: Path) -> None:
    """At UTM coordinates every place that `compare`, `info` and a limit name is exact to the millimetre."""
    vertices, faces = icosphere(3, 20.0)
    far = vertices + np.array([5e5, 5e6, 100.0])
    dent = far.copy()
    dent[7] += [0.0, 0.0, 3.0]
    for name, shape in (("a.ply", far), ("b.ply", dent)):
        (tmp_path / name).write_bytes(ply_bytes(xyz(shape), faces.tolist()))
    place = ", ".join(f"{c:.9g}" if c > 1000 else f"{c:.6g}" for c in dent[7])
    text = invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply", "--no-self-intersections").stdout
    assert f"largest, vertex 7 at {place}" in " ".join(text.split())
    assert "from (499980, 4999980, 80) to (500020, 5000020, 120)" in invoke("info", tmp_path / "a.ply").stdout
    limited = ("run", "smooth_taubin", tmp_path / "b.ply", "-o", tmp_path / "c.ply", "--max-displacement", "0.2")
    named = re.search(r"vertex (\d+) at \((.*?)\) has moved by ([0-9.]+)", invoke(*limited).stderr)
    assert named is not None
    assert np.linalg.norm(dent[int(named[1])] - np.array(named[2].split(", "), float)) == pytest.approx(float(named[3]), abs=0.01)


def test_a_section_that_cuts_nothing_is_told(tmp_path: Path) -> None:
    """The warning names the plane and how far both meshes reach along its axis; other sections are in the report."""
    vertices, faces = icosphere(2)
    for name, size in (("a.ply", 1.0), ("b.ply", 1.5)):
        (tmp_path / name).write_bytes(ply_bytes(xyz(size * vertices), faces.tolist()))
    sections = ("--report", tmp_path / "c.html", "--section", "y=1.25", "--section", "y=1000")
    done = invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply", "--no-self-intersections", "--json", *sections)
    wanted = "the report has no section y = 1000, which cuts no face: BEFORE and AFTER reach from -1.5 to 1.5 along y"
    assert document(done.stdout)["warnings"] == [wanted]
    assert wanted in done.stderr
    page = (tmp_path / "c.html").read_text("utf-8")
    assert wanted in page
    assert page.count("Section y = 1.25") >= 1


def test_deviations_never_replace_what_is_compared(tmp_path: Path) -> None:
    """A file of deviations that is BEFORE or AFTER is refused, also with --overwrite, and both keep their bytes."""
    vertices, faces = icosphere(2)
    files = [tmp_path / "a.ply", tmp_path / "b.ply"]
    for path in files:
        path.write_bytes(ply_bytes(xyz(vertices), faces.tolist()))
    for path in files:
        done = invoke("compare", *files, "--deviations", path, "--overwrite", "--no-self-intersections")
        assert done.exit_code == 1
        assert "it is BEFORE or AFTER; name another file for the deviations" in done.stderr
    assert [path.read_bytes() for path in files] == [ply_bytes(xyz(vertices), faces.tolist())] * 2


def test_an_alignment_to_a_part_of_the_surface_is_doubted(tmp_path: Path) -> None:
    """Onto 60 % of an egg the egg converges away from its place: a warning says so; onto the whole egg there is none."""
    vertices, faces = icosphere(4)
    egg = vertices * [1.0, 1.5, 2.0] + 0.05 * np.sin(5 * vertices[:, [1, 2, 0]])
    middles = egg[faces].mean(axis=1)[:, 0]
    for name, shape, left in (
        ("whole.ply", egg, faces),
        ("part.ply", egg, faces[middles <= np.quantile(middles, 0.6)]),
        ("moved.ply", egg + np.array([0.0, 0.02, 0.05]), faces),
    ):
        (tmp_path / name).write_bytes(ply_bytes(xyz(shape), left.tolist()))
    options = (tmp_path / "moved.ply", "--align", "--no-self-intersections", "--json")
    doubted, sure = (document(invoke("compare", tmp_path / f"{name}.ply", *options).stdout) for name in ("part", "whole"))
    assert doubted["alignment"]["converged"]
    assert [re.sub(r"stay [\d.]+", "stay #", text) for text in doubted["warnings"]] == [
        "the nearest 80 % of AFTER stay # mean edges from BEFORE (root mean square): --align may have ended at a wrong "
        "place, as it needs 80 % of AFTER to lie on BEFORE"
    ]
    assert sure["warnings"] == []


@pytest.mark.slow
def test_scans_taken_twice_are_aligned(tmp_path: Path) -> None:
    """Turned by 5 degrees and moved, an egg with noise comes back onto itself; the turn, the shift and the residual are told."""
    vertices, faces = icosphere(4)
    egg = vertices * [1.0, 1.5, 2.0] + 0.05 * np.sin(5 * vertices[:, [1, 2, 0]])
    a = math.radians(5.0)
    turn = np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
    shift = np.array([0.05, -0.03, 0.04])
    twice = noisy((egg @ turn.T + shift, faces), 0.02)[0]
    for name, shape in (("a.ply", egg), ("b.ply", twice), ("far.ply", egg + 10.0)):
        (tmp_path / name).write_bytes(ply_bytes(xyz(shape), faces.tolist()))
    options = ("--align", "--no-self-intersections", "--json")
    done = document(invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply", *options).stdout)
    told, found = done["alignment"], done["comparison"]["after_from_before"]
    assert told["converged"]
    assert told["degrees"] == pytest.approx(5.0, abs=0.05)
    assert abs(found["mean"]["mean_edges"]) < 0.01
    apart = compared(tmp_path, (egg, faces), (noisy((egg, faces), 0.02)[0], faces))
    assert found["rms"]["mesh_units"] == pytest.approx(apart.after_from_before.rms.mesh_units, rel=0.05)
    refused = invoke("compare", tmp_path / "a.ply", tmp_path / "far.ply", *options)
    assert refused.exit_code == 1
    assert "do not overlap" in refused.stderr


def test_the_matrix_of_an_alignment_repeats_it_elsewhere(tmp_path: Path) -> None:
    """The matrix in the document moves the points of the file to those of the table of deviations."""
    vertices, faces = icosphere(2)
    egg = vertices * [1.0, 1.5, 2.0] + [5e3, 0.0, 0.0]
    a = math.radians(3.0)
    turned = (egg - [5e3, 0, 0]) @ np.array([[math.cos(a), math.sin(a), 0], [-math.sin(a), math.cos(a), 0], [0, 0, 1]]) + [
        5e3,
        0.1,
        0,
    ]
    for name, shape in (("a.ply", egg), ("b.ply", turned)):
        (tmp_path / name).write_bytes(ply_bytes(xyz(shape), faces.tolist()))
    options = ("--align", "--no-self-intersections", "--json", "--deviations", tmp_path / "d.csv")
    done = document(invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply", *options).stdout)
    matrix = np.array(done["alignment"]["matrix"])
    places = np.loadtxt(tmp_path / "d.csv", delimiter=",", skiprows=1)[:, 1:4]
    np.testing.assert_allclose(turned @ matrix[:3, :3].T + matrix[:3, 3], places, atol=1e-11)


def test_a_vertex_without_a_face_is_no_part_of_an_alignment(tmp_path: Path) -> None:
    """Far from the origin, where such a vertex lies, an egg turned by 4 degrees comes back onto itself."""
    vertices, faces = icosphere(3)
    egg, a = vertices * [1.0, 1.5, 2.0] + 0.05 * np.sin(5 * vertices[:, [1, 2, 0]]), math.radians(4.0)
    turned = egg @ np.array([[math.cos(a), math.sin(a), 0.0], [-math.sin(a), math.cos(a), 0.0], [0.0, 0.0, 1.0]])
    place = np.array([5e5, 5.5e6, 300.0])
    found = align(np.concatenate([turned + place, [[0.0, 0.0, 0.0]]]), faces, Surface.of(egg + place, faces))
    assert found.degrees == pytest.approx(4.0, abs=1e-6)
    np.testing.assert_allclose(found.vertices[:-1], egg + place, rtol=0, atol=1e-8)


def test_the_noise_is_what_info_says(tmp_path: Path) -> None:
    """A shape with fine waves has the noise of its traits, which `info` shows in mean edges."""
    vertices, faces = torus(60, 30)
    vertices[:, 2] += 0.02 * np.sin(9.0 * vertices[:, 0]) * np.cos(11.0 * vertices[:, 1])
    (tmp_path / "waves.ply").write_bytes(ply_bytes(xyz(vertices), faces.tolist()))
    read = read_mesh(tmp_path / "waves.ply")
    noise, edge = state_of(read).measures["noise"], read.measures["mean_edge"]
    assert noise == pytest.approx(read.traits()["noise"] * edge, rel=1e-12)
    assert 0.0 < noise < 0.7 * estimate_noise(vertices, faces).length


@pytest.mark.parametrize("faces", [[], [[0, 1, 2]]])
def test_properties_that_only_the_file_holds_are_custom_attributes(tmp_path: Path, faces: list[list[int]]) -> None:
    """The intensity of a scanner is lost where AFTER lacks it, and `info` names it, for a mesh and for a cloud."""
    places = xyz(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]))
    states = []
    for name, more in (("before.ply", [("float", "intensity", [5.0, 6.0, 7.0])]), ("after.ply", [])):
        (tmp_path / name).write_bytes(ply_bytes([*places, *more], faces))
        states.append(state_of(read_mesh(tmp_path / name)))
    assert compare(*states).comparison.attributes_lost == ("custom attributes",)
    assert "custom attributes" in contents_of(states[0].mesh)
    assert "custom attributes" not in contents_of(states[1].mesh)


def test_curves_are_compared_at_their_vertices_with_a_warning(tmp_path: Path) -> None:
    """A polyline with a further vertex on its edge seems to lie apart, and the warning says why."""
    for name, places in (("a.obj", (0, 1)), ("b.obj", (0, 0.5, 1))):
        line = " ".join(str(k) for k in range(1, len(places) + 1))
        (tmp_path / name).write_text("".join(f"v {x} 0 0\n" for x in places) + f"l {line}\n")
    told = invoke("compare", tmp_path / "a.obj", tmp_path / "b.obj", "--no-self-intersections").stderr
    for name in ("a.obj", "b.obj"):
        assert f"{name}: it has edges and no faces: its vertices are compared, not its edges" in " ".join(told.split())


def test_a_vertex_beyond_all_measure_is_named(tmp_path: Path) -> None:
    """A vertex at 1e200 beside a grid of size 5 is refused by its number and place, before any square overflows."""
    vertices, faces = grid(6, 6)
    vertices[3] = [1e200, 0.0, 0.0]
    corners = "".join("f {} {} {}\n".format(*face) for face in faces + 1)
    (tmp_path / "far.obj").write_text("".join("v {!r} {!r} {!r}\n".format(*v) for v in vertices.tolist()) + corners)
    with pytest.raises(FilterInputError, match=r"^vertex 3 at \[1e\+200, 0\.0, 0\.0\] is so far from the others"):
        state_of(read_mesh(tmp_path / "far.obj"))


@pytest.mark.parametrize("align", [(), ("--align",)])
def test_coordinates_whose_areas_overflow_are_named_with_their_file(tmp_path: Path, align: tuple[str, ...]) -> None:
    """Spheres of 1e80 are refused in one sentence with the file, the size and the advice; spheres of 1e75 are compared."""
    vertices, faces = icosphere(1)
    corners = "".join("f {} {} {}\n".format(*face) for face in faces + 1)
    for name, size in (("huge.obj", 1e80), ("large.obj", 1e75)):
        (tmp_path / name).write_text("".join("v {!r} {!r} {!r}\n".format(*v) for v in (size * vertices).tolist()) + corners)
    refused = invoke("compare", *align, tmp_path / "large.obj", tmp_path / "huge.obj")
    assert refused.exit_code == 1
    told = "huge.obj: a coordinate is 1e+80 in size; areas and distances are computed up to 1e+76: scale the mesh down first"
    assert told in " ".join(refused.stderr.split())
    assert invoke("compare", tmp_path / "large.obj", tmp_path / "large.obj").exit_code == 0


def test_the_areas_that_are_not_listed_are_counted(tmp_path: Path) -> None:
    """Of 30 points out of tolerance the table has 20, and a line says so; of 20 points it has all."""
    line = np.column_stack([np.arange(30.0), np.zeros((30, 2))])
    no_faces = np.empty((0, 3), int)
    found = compared(tmp_path, (line, no_faces), (line + np.array([0.0, 0.3, 0.0]), no_faces), tolerance=0.1)
    areas = len(found.out_of_tolerance)
    assert areas == 60
    assert len(area_table(found)) == 21
    assert "areas out of tolerance: 60; the 20 furthest are listed" in comparison_lines(found)
    assert " mean spacings apart" in verdict_text(found)  # points have no edges
    few = replace(found, out_of_tolerance=found.out_of_tolerance[:20])
    assert not any(text.startswith("areas out of") for text in comparison_lines(few))


def test_a_missing_half_is_in_the_first_sentence(tmp_path: Path) -> None:
    """What is left lies on the whole surface: the verdict begins with the distance of the whole from what is left."""
    vertices, faces = grid(9, 9)
    left = faces[vertices[faces][:, :, 0].max(axis=1) <= 4.0]
    found = compared(tmp_path, (vertices, faces), (vertices, left))
    far = found.before_from_after
    assert verdict_text(found).startswith(f"BEFORE lies {far.rms.mean_edges:.3g} mean edges from AFTER (root mean square), and ")
    assert "AFTER lies 0 mean edges from BEFORE." in verdict_text(found)
