"""Curve Smoothing and its recipes as MeshLab users meet them: on sections, borders and polylines in a mesh set."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

import pymeshfair
from pymeshfair.declaration import MeshElement
from pymeshfair.filters.curves import curve_smoothing
from pymeshfair.meshlab.base import FilterFailedError
from pymeshfair.plugins.smoothing import apply_coord_curve_smoothing
from pymeshfair.recipe import load_recipe

BUNNY = Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny.obj"


def wavy_ring(n: int = 60) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """A closed curve of radius 1 in a plane, with noise."""
    angles = 2 * np.pi * np.arange(n) / n
    random = np.random.default_rng(4)
    radii = 1 + random.normal(scale=0.03, size=n)
    at = np.arange(n, dtype=np.int32)
    vertices = np.column_stack([radii * np.cos(angles), radii * np.sin(angles), np.full(n, 0.1)])
    return vertices, np.column_stack([at, (at + 1) % n]).astype(np.int32)


def mesh_set(vertices: Any, edges: Any) -> pymeshfair.MeshSet:
    """A mesh set with these curves alone."""
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, edge_matrix=edges))
    return meshes


def test_edges_that_count_for_nothing_change_no_result() -> None:
    """With every vertex joined to itself and every second edge doubled, a ring is smoothed by the same size, to the bit."""
    vertices, edges = wavy_ring()
    loops = np.repeat(np.arange(60, dtype=np.int32)[:, None], 2, axis=1)
    plain, more = mesh_set(vertices, edges), mesh_set(vertices, np.concatenate([edges, loops, edges[::2, ::-1]]))
    for meshes in (plain, more):
        meshes.apply_coord_curve_smoothing()
    np.testing.assert_array_equal(more.current_mesh().vertex_matrix(), plain.current_mesh().vertex_matrix())


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (
            {"detail_size": pymeshlab.PureValue(0.4)},
            {"method": "implicit", "weights": "inverse_length", "detail_size": 0.4, "iterations": 10},
        ),
        ({"method": "explicit", "iterations": 3}, {"method": "explicit", "weights": "inverse_length", "iterations": 3}),
        (
            {"method": "taubin", "weights": "uniform", "pass_band": 0.05},
            {"method": "taubin", "weights": "uniform", "pass_band": 0.05},
        ),
        (
            {"method": "implicit", "weights": "uniform", "time_step": 5.0, "iterations": 1},
            {"method": "implicit", "time_step": 5.0, "iterations": 1},
        ),
    ],
)
def test_the_filter_is_the_function(values: dict[str, Any], expected: dict[str, Any]) -> None:
    """Each way to ask gives the function's coordinates to the bit, and leaves the edges as they are."""
    vertices, edges = wavy_ring()
    meshes = mesh_set(vertices, edges)
    meshes.apply_filter("apply_coord_curve_smoothing", **values)
    np.testing.assert_array_equal(meshes.current_mesh().vertex_matrix(), curve_smoothing(vertices, edges, **expected))
    np.testing.assert_array_equal(meshes.current_mesh().edge_matrix(), edges)


def test_the_default_detail_size_counts_in_the_edges_of_the_curve() -> None:
    """Twelve mean edges of the polyline, though it has no triangle."""
    vertices, edges = wavy_ring()
    meshes = mesh_set(vertices, edges)
    meshes.apply_coord_curve_smoothing()
    mean = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1).mean()
    expected = curve_smoothing(vertices, edges, method="implicit", weights="inverse_length", detail_size=12 * mean)
    np.testing.assert_allclose(meshes.current_mesh().vertex_matrix(), expected, rtol=0, atol=1e-13)


def test_the_detail_size_counts_in_the_edges_of_the_curve_beside_faces() -> None:
    """A triangle a hundred times as large as the curve's edges, in the same layer, changes nothing."""
    vertices, edges = wavy_ring()
    both = np.concatenate([vertices, [[0, 0, 0], [10, 0, 0], [0, 10, 0]]])
    meshes = pymeshfair.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(both, face_matrix=[[60, 61, 62]], edge_matrix=edges))
    asked = meshes.filter_parameter_values("apply_coord_curve_smoothing")
    mean = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1).mean()
    assert asked["detail_size"] == pytest.approx(12 * mean, rel=1e-14)
    meshes.apply_coord_curve_smoothing()
    expected = curve_smoothing(vertices, edges, method="implicit", weights="inverse_length", detail_size=12 * mean)
    np.testing.assert_allclose(meshes.current_mesh().vertex_matrix()[:60], expected, rtol=0, atol=1e-13)


def test_a_mesh_without_edges_is_refused() -> None:
    """A surface has triangles, not edges; the message says what is missing."""
    meshes = pymeshfair.MeshSet()
    meshes.load_new_mesh(str(BUNNY))
    with pytest.raises(FilterFailedError, match="has no edges"):
        meshes.apply_coord_curve_smoothing()
    assert apply_coord_curve_smoothing.requires == MeshElement.EDGENUMBER


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"weights": "uniform"}, "uniform weights ignore lengths: give a time_step"),
        ({"detail_size": pymeshlab.PureValue(0)}, "detail_size is 0 and so is time_step"),
        ({"method": "taubin", "mu": -0.4}, "mu is -0.4: it must be below -step"),
    ],
)
def test_what_does_not_fit_is_refused(values: dict[str, Any], words: str) -> None:
    """Each message says what to give instead, and nothing moves."""
    vertices, edges = wavy_ring()
    meshes = mesh_set(vertices, edges)
    with pytest.raises(FilterFailedError, match=words):
        meshes.apply_filter("apply_coord_curve_smoothing", **values)
    np.testing.assert_array_equal(meshes.current_mesh().vertex_matrix(), vertices)


def test_the_border_of_a_surface_is_a_curve() -> None:
    """The perimeter of a selection, as MeshLab makes it, is smoothed: it gets shorter and keeps its edges."""
    meshes = pymeshfair.MeshSet()
    meshes.load_new_mesh(str(BUNNY))
    meshes.compute_selection_by_condition_per_face(condselect="(x0 > 0.4) && (y0 > 0)")
    meshes.generate_polyline_from_selection_perimeter()
    before = length(meshes)
    edges = meshes.current_mesh().edge_matrix()
    meshes.apply_coord_curve_smoothing()
    np.testing.assert_array_equal(meshes.current_mesh().edge_matrix(), edges)
    assert length(meshes) < 0.95 * before


def length(meshes: Any) -> float:
    """The length of the curves of the current mesh."""
    mesh = meshes.current_mesh()
    return float(np.linalg.norm(np.diff(mesh.vertex_matrix()[mesh.edge_matrix()], axis=1), axis=2).sum())


def test_smooth_contours_removes_noise_and_keeps_the_shape() -> None:
    """Noise of 0.03 on a circle of radius 1 is halved, the mean radius stays to 1.5 % and the plane to the bit."""
    vertices, edges = wavy_ring(200)
    meshes = mesh_set(vertices, edges)
    meshes.load_filter_script(str(load_recipe("smooth_contours").script.path))
    meshes.apply_filter_script()
    smooth = meshes.current_mesh().vertex_matrix()
    radii = np.hypot(smooth[:, 0], smooth[:, 1])
    assert radii.std() < np.hypot(vertices[:, 0], vertices[:, 1]).std() / 2
    assert radii.mean() == pytest.approx(1, abs=0.015)
    np.testing.assert_array_equal(smooth[:, 2], vertices[:, 2])


def test_smooth_section_gives_one_smooth_curve_of_the_bunny() -> None:
    """The middle section is a closed curve in its plane, near the section as cut, and shorter by what its noise was."""
    meshes = pymeshfair.MeshSet()
    meshes.load_new_mesh(str(BUNNY))
    meshes.generate_polyline_from_planar_section(planeaxis="Z Axis", relativeto="Bounding box center")
    cut, cut_length = meshes.current_mesh().vertex_matrix(), length(meshes)
    meshes = pymeshfair.MeshSet()
    meshes.load_new_mesh(str(BUNNY))
    meshes.load_filter_script(str(load_recipe("smooth_section").script.path))
    meshes.apply_filter_script()
    mesh = meshes.current_mesh()
    assert mesh.face_number() == 0
    np.testing.assert_array_equal(np.bincount(mesh.edge_matrix().ravel()), 2)
    np.testing.assert_array_equal(mesh.vertex_matrix()[:, 2], cut[:, 2])
    assert 0.9 * cut_length < length(meshes) < cut_length
    # The detail size, 20 mean edges, is 0.04.
    assert np.linalg.norm(mesh.vertex_matrix() - cut, axis=1).max() < 0.02


def test_smooth_section_cuts_scans_that_are_not_manifold() -> None:
    """A range map with edges of three triangles, which MeshLab refuses to cut, gives a section with no branch in it."""
    meshes = pymeshfair.MeshSet()
    meshes.load_new_mesh(str(BUNNY.parent / "rangemaps" / "face000.ply"))
    with pytest.raises(pymeshlab.PyMeshLabException, match="not two manifold"):
        meshes.generate_polyline_from_planar_section(relativeto="Bounding box center")
    meshes.load_filter_script(str(load_recipe("smooth_section").script.path))
    meshes.apply_filter_script()
    mesh = meshes.current_mesh()
    assert (mesh.face_number(), mesh.edge_number()) == (0, 237)
    assert np.bincount(mesh.edge_matrix().ravel()).max() == 2


@pytest.mark.slow
def test_the_examples_of_the_page_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every code block of docs/curves.md does what it says, in the order of the page, on the bunny of pymeshlab."""
    page = (Path(__file__).parents[2] / "docs" / "curves.md").read_text(encoding="utf-8")
    shell, python = (re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL) for language in ("sh", "python"))
    assert page.count("```") == 2 * (len(shell) + len(python))
    monkeypatch.chdir(tmp_path)
    for name in ("bunny.obj", "scan.obj"):
        shutil.copy(BUNNY, tmp_path / name)
    for line in "".join(shell).splitlines():
        words = shlex.split(line, comments=True)
        assert words[0] == "pymeshfair"
        done = subprocess.run([sys.executable, "-m", "pymeshfair", *words[1:]], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        assert (tmp_path / words[words.index("-o") + 1]).exists()
    for block in python:
        found: dict[str, Any] = {}
        exec(block, found)
        assert found["ms"].current_mesh().edge_number() == 837


@pytest.mark.parametrize(("extension", "notes"), [("obj", 0), ("ply", 1), ("off", 1)])
def test_saving_without_the_edges_is_said(tmp_path: Path, extension: str, notes: int) -> None:
    """MeshLab leaves edges out of all files but OBJ without a word; the mesh set gives a note, and what it says is so."""
    vertices, edges = wavy_ring()
    meshes, heard = mesh_set(vertices, edges), list[str]()
    meshes.on_note = heard.append
    meshes.save_current_mesh(str(tmp_path / f"ring.{extension}"))
    assert len(heard) == notes
    assert all("does not write the 60 edges" in note for note in heard)
    reloaded = pymeshlab.MeshSet()
    reloaded.load_new_mesh(str(tmp_path / f"ring.{extension}"))
    assert reloaded.current_mesh().edge_number() == (0 if notes else 60)
