"""Two meshes compared."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
import trimesh

from pymeshfair.looking.comparison import Comparison, compare
from pymeshfair.looking.mesh_state import state_of
from pymeshfair.running.read import read_mesh
from tests.commands.command_line import document, invoke
from tests.meshes import cube, icosphere, noisy, sample, torus
from tests.running.runs import ply_bytes, xyz


def compared(folder: Path, before: Any, after: Any, offset: Any = (0.0, 0.0, 0.0)) -> Comparison:
    """Two meshes written to files, read, and compared."""
    states = []
    for name, (vertices, faces) in (("before.ply", before), ("after.ply", after)):
        path = folder / name
        path.write_bytes(ply_bytes(xyz(np.asarray(vertices) + offset), np.asarray(faces).tolist()))
        states.append(state_of(read_mesh(path, self_intersections=True)))
    return compare(*states)[0]


def test_hausdorff_distance_agrees_with_meshlab(tmp_path: Path) -> None:
    """Both ways, and mean and root mean square, are those of MeshLab's filter with vertices as samples, to single precision."""
    before, after = sample("bone.ply"), noisy(icosphere(3, 0.3), 0.02)
    after = (after[0] + before[0].mean(axis=0), after[1])
    used = np.unique(before[1])
    before = (before[0][used], np.searchsorted(used, before[1]).astype(np.int32))
    found = compared(tmp_path, before, after)
    meshes = pymeshlab.MeshSet()
    for vertices, faces in (before, after):
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    for first, second, ours in ((1, 0, found.after_from_before), (0, 1, found.before_from_after)):
        theirs = meshes.get_hausdorff_distance(
            sampledmesh=first, targetmesh=second, samplevert=True, samplenum=10**7, maxdist=pymeshlab.PureValue(100.0)
        )
        assert ours.mesh_units == pytest.approx(theirs["max"], rel=1e-6)
        if first == 1:
            assert found.displacement.mean.mesh_units == pytest.approx(theirs["mean"], rel=1e-6)
            assert found.displacement.rms.mesh_units == pytest.approx(theirs["RMS"], rel=1e-6)


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
    moved = found.displacement
    assert moved.by_vertex
    for length in (moved.mean, moved.rms, moved.most, moved.largest, found.after_from_before):
        assert length.mesh_units == pytest.approx(0.1, rel=1e-6)
        assert length.mean_edges == pytest.approx(0.1 / found.before["mean_edge"], rel=1e-6)
        assert length.percent_of_diagonal == pytest.approx(10 / found.before["diagonal"], rel=1e-6)
    assert found.area_change == pytest.approx(21.0, rel=1e-9)
    assert found.volume_change == pytest.approx(33.1, rel=1e-9)
    assert found.normal_deviation == pytest.approx(0.0, abs=1e-6)
    assert (found.flipped_faces, found.added_area, found.removed_area) == (0, 0.0, 0.0)
    assert found.attributes_kept == ("faces",)
    assert (found.attributes_lost, found.attributes_gained) == ((), ())


@pytest.mark.parametrize("same_faces", [True, False])
def test_utm_coordinates_change_nothing(tmp_path: Path, same_faces: bool) -> None:
    """Moved to UTM coordinates, given ones that can be moved exactly, every length is the same to 1e-9."""
    vertices, faces = icosphere(3, 40.0)
    vertices = np.round(vertices * 2.0**14) / 2.0**14
    after = np.round(noisy((vertices, faces), 0.4)[0] * 2.0**14) / 2.0**14
    other = faces if same_faces else np.roll(faces, 1, axis=0)
    near = compared(tmp_path, (vertices, faces), (after, other))
    far = compared(tmp_path, (vertices, faces), (after, other), offset=(5e5, 5.5e6, 300.0))
    assert near.displacement.by_vertex is far.displacement.by_vertex is same_faces
    for name in ("mean", "rms", "most", "largest"):
        ours, theirs = (getattr(found.displacement, name).mesh_units for found in (far, near))
        assert ours == pytest.approx(theirs, rel=1e-9), name
    assert far.hausdorff.mesh_units == pytest.approx(near.hausdorff.mesh_units, rel=1e-9)
    for name in ("area", "volume", "mean_edge", "diagonal", "sharp_edge_length"):
        assert far.after[name] == pytest.approx(near.after[name], rel=1e-9), name
    assert far.after["noise"] == pytest.approx(near.after["noise"], rel=1e-6)
    assert far.after["self_intersecting_faces"] == near.after["self_intersecting_faces"]


def test_what_was_removed_and_added(tmp_path: Path) -> None:
    """Without one of two spheres its area counts as removed, the other way round as added."""
    vertices, faces = icosphere(3)
    two = (np.concatenate([vertices, vertices + np.array([5.0, 0, 0])]), np.concatenate([faces, faces + len(vertices)]))
    area = trimesh.Trimesh(vertices, faces, process=False).area
    gone = compared(tmp_path, two, (vertices, faces))
    # The middles of faces nearer than a mean edge to the other sphere: there are none, it is 3 away.
    assert gone.removed_area == pytest.approx(area)
    assert gone.added_area == 0.0
    assert gone.before_from_after.mesh_units == pytest.approx(5.0, abs=0.05)
    grown = compared(tmp_path, (vertices, faces), two)
    assert grown.added_area == pytest.approx(area)
    assert (grown.before["components"], grown.after["components"]) == (1, 2)


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


def test_sharp_edges_of_a_box(tmp_path: Path) -> None:
    """A cube keeps its twelve edges if it is moved a little, and has none of them as a ball."""
    vertices, faces = cube()
    assert compared(tmp_path, (vertices, faces), (vertices + 0.01, faces)).sharp_edges_kept == 1.0
    ball = icosphere(3, 0.6)
    assert compared(tmp_path, (vertices, faces), (ball[0] + 0.5, ball[1])).sharp_edges_kept == 0.0


def test_clouds_are_compared(tmp_path: Path) -> None:
    """Two clouds have displacements and Hausdorff distances, and nothing that needs faces."""
    points = np.random.default_rng(0).normal(size=(200, 3))
    none = np.empty((0, 3), dtype=np.int32)
    found = compared(tmp_path, (points, none), (np.concatenate([points[:150], [[30.0, 0, 0]]]), none))
    assert found.displacement.largest.mesh_units == pytest.approx(np.linalg.norm(points - [30.0, 0, 0], axis=1).min(), rel=1e-6)
    assert found.displacement.vertex == 150
    assert found.normal_deviation is None
    assert found.after["noise"] is None


def test_the_command_prints_both(tmp_path: Path) -> None:
    """As JSON it is one document with the comparison, as text the table and the distances."""
    vertices, faces = icosphere(2)
    for name, size in (("a.ply", 1.0), ("b.ply", 1.5)):
        (tmp_path / name).write_bytes(ply_bytes(xyz(size * vertices), faces.tolist()))
    shown = document(invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply", "--json").stdout)["comparison"]
    assert shown["displacement"]["mean"]["mesh_units"] == pytest.approx(0.5)
    assert math.isclose(shown["volume_change"], 237.5, rel_tol=1e-9)
    text = invoke("compare", tmp_path / "a.ply", tmp_path / "b.ply").stdout
    for words in ("largest displacement, vertex", "Hausdorff distance", "volume: +237.5 %", "self-intersecting", "kept: faces"):
        assert words in text or words == "self-intersecting", words
