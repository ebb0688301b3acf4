"""OFF files: colours, normals, texture coordinates, polygons and edges, read and written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
import trimesh

from pymeshfair.files.inputs import read_file
from pymeshfair.mesh_data import MeshData
from tests.meshes import icosphere

from .round_trips import assert_same, meshlab, read, save

RNG = np.random.default_rng(1)
LEVELS = RNG.integers(0, 256, (42, 4), np.uint8)
#: what a mesh of 42 vertices and 80 faces may have
PARTS: dict[str, dict[str, Any]] = {
    "plain": {},
    "colours": {"vertex_attributes": {"colors": LEVELS}},
    "normals": {"vertex_attributes": {"normals": RNG.random((42, 3))}, "keeps_normals": True},
    "both": {"vertex_attributes": {"normals": RNG.random((42, 3)), "colors": LEVELS}, "keeps_normals": True},
    "texture": {"vertex_attributes": {"texture_coordinates": RNG.random((42, 2)), "colors": LEVELS}},
    "faces": {"face_attributes": {"colors": RNG.integers(0, 256, (80, 4), np.uint8)}},
    "edges": {"edges": np.array([[0, 3], [9, 2]])},
}


@pytest.mark.parametrize("kind", PARTS)
def test_what_is_written_is_read_everywhere(tmp_path: Path, kind: str) -> None:
    """Each attribute comes back to the bit; MeshLab reads all but texture coordinates, trimesh the same volume."""
    vertices, faces = icosphere(1)
    mesh = MeshData(vertices=vertices, faces=faces, **PARTS[kind])
    path = tmp_path / "a.off"
    assert save(mesh, path) == ()
    assert_same(read_file(path).mesh, mesh)
    theirs, _meshes = meshlab(path)
    np.testing.assert_array_equal(theirs.vertex_matrix(), vertices)
    np.testing.assert_array_equal(theirs.face_matrix(), faces)
    assert theirs.edge_number() == len(mesh.edges)
    if mesh.has_vertex_colors:
        np.testing.assert_array_equal(np.rint(255 * theirs.vertex_color_matrix()), LEVELS)
    if mesh.keeps_normals:
        np.testing.assert_array_equal(theirs.vertex_normal_matrix(), mesh.vertex_normals)
    if mesh.has_face_colors:
        np.testing.assert_array_equal(np.rint(255 * theirs.face_color_matrix()), mesh.face_attributes["colors"])
    if kind == "plain":
        np.testing.assert_allclose(trimesh.load_mesh(path).volume, float(trimesh.Trimesh(vertices, faces).volume))


def test_colours_before_normals_are_read_as_they_were_written(tmp_path: Path) -> None:
    """MeshLab writes colours before normals and reads normals first: what it wrote is read with the right ones of both."""
    vertices, faces = icosphere(1)
    colors = LEVELS / 255
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces, v_color_matrix=colors))
    meshes.compute_normal_per_vertex()
    normals = meshes.current_mesh().vertex_normal_matrix()
    meshes.save_current_mesh(str(tmp_path / "ball.off"))
    meshes.load_new_mesh(str(tmp_path / "ball.off"))
    assert not np.allclose(meshes.current_mesh().vertex_color_matrix(), colors)
    mesh = read_file(tmp_path / "ball.off").mesh
    np.testing.assert_array_equal(mesh.vertex_attributes["colors"], LEVELS)
    np.testing.assert_allclose(mesh.vertex_normals, normals, rtol=0, atol=1e-6)


def test_polygons_stay_whole(tmp_path: Path) -> None:
    """A concave polygon has the area that it has, its colour, and is a polygon again; a pair of vertices is an edge."""
    arrow = "OFF # an arrow\n5 3 0\n0 0 0\n4 0 0\n4 4 0\n3 1 0\n9 9 9\n4 0 1 2 3 255 0 0\n3 0 1 4 0.2 0.4 1.0 0.5\n2 1 4\n"
    mesh = read(tmp_path / "a.off", arrow)
    np.testing.assert_allclose(trimesh.Trimesh(mesh.vertices, mesh.faces[:2], process=False).area, 4.0)
    assert mesh.face_attributes["colors"].tolist() == [[255, 0, 0, 255], [255, 0, 0, 255], [51, 102, 255, 128]]
    assert mesh.edges.tolist() == [[1, 4]]
    assert save(mesh, tmp_path / "b.off") == ("b.off does not hold these contents of a.off: comments",)
    lines = (tmp_path / "b.off").read_text().splitlines()
    assert sorted(lines[7].split()[1:5]) == ["0", "1", "2", "3"]
    assert lines[8:] == ["3 0 1 4 51 102 255 128", "2 1 4"]


def test_colours_of_edges_are_named(tmp_path: Path) -> None:
    """A face of two vertices is an edge, which has no colour."""
    mesh = read(tmp_path / "a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1 255 0 0\n")
    assert mesh.source is not None
    assert mesh.source.extras == ("colours of edges",)
