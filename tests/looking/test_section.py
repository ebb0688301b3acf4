"""Sections of meshes, and deviations as files."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.errors import ParameterError
from pymeshfair.files.inputs import read_file
from pymeshfair.looking.comparison import deviations_file
from pymeshfair.mesh_data import MeshData
from pymeshfair.report.page import Plane, outline, section_chart
from tests.meshes import cube, icosphere


def test_a_section_of_a_sphere_is_a_circle() -> None:
    """At height 0.5 its radius is that of the circle there, its length the circumference, and its ends meet in pairs."""
    vertices, faces = icosphere(5)
    segments = outline(MeshData(vertices=vertices, faces=faces), Plane.parse("z=0.5"))
    np.testing.assert_allclose(np.linalg.norm(segments, axis=2), np.sqrt(0.75), rtol=1e-3)
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum()
    assert length == pytest.approx(2 * np.pi * np.sqrt(0.75), rel=1e-3)
    ends, counts = np.unique(np.round(segments.reshape(-1, 2), 6), axis=0, return_counts=True)
    assert (counts % 2 == 0).all()
    assert len(ends) <= len(segments)


def test_a_plane_through_vertices_has_a_whole_outline() -> None:
    """At the heights of its bottom and its top a cube has the outline of its sides: 4 long."""
    vertices, faces = cube()
    mesh = MeshData(vertices=vertices, faces=faces)
    lengths = [np.linalg.norm(np.ptp(outline(mesh, Plane(2, z)), axis=1), axis=1).sum() for z in (0.0, 1.0)]
    assert lengths == pytest.approx([4.0, 4.0])


def test_a_plane_that_touches_a_tip_has_no_section() -> None:
    """At the poles of a sphere all ends of segments are one point, which has no size to draw."""
    vertices, faces = icosphere(2)
    vertices = vertices - vertices[vertices[:, 2].argmax()]
    tip = MeshData(vertices=vertices, faces=faces)
    turned = MeshData(vertices=-vertices, faces=faces)
    assert len(outline(tip, Plane(2, 0.0)))
    assert [section_chart([mesh], Plane(2, 0.0), None) for mesh in (tip, turned)] == [None, None]


@pytest.mark.parametrize("text", ["w=1", "z", "z=", "z=nan", "=1", "xy=1"])
def test_wrong_sections_are_named(text: str) -> None:
    """What is no section is refused with an example."""
    with pytest.raises(ParameterError, match=r"such as z=12\.5"):
        Plane.parse(text)


def test_deviations_are_read_back_to_the_bit(tmp_path: Path) -> None:
    """The table and the scalar of the mesh are the distances."""
    vertices, faces = icosphere(2)
    distances = np.random.default_rng(0).normal(size=len(vertices))
    mesh = MeshData(vertices=vertices, faces=faces)
    table = np.loadtxt(io.BytesIO(deviations_file(mesh, distances, "csv")), delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table, np.column_stack([np.arange(len(vertices)), vertices, distances]))
    (tmp_path / "d.ply").write_bytes(deviations_file(mesh, distances, "ply"))
    np.testing.assert_array_equal(read_file(tmp_path / "d.ply").mesh.vertex_scalars, distances)


def test_deviations_of_curves_keep_their_edges(tmp_path: Path) -> None:
    """A file of the distances is the curve that was compared, not the cloud of its vertices."""
    curve = MeshData(vertices=np.eye(3), edges=np.array([[0, 1], [1, 2]], dtype=np.int32))
    (tmp_path / "d.ply").write_bytes(deviations_file(curve, np.zeros(3), "ply"))
    np.testing.assert_array_equal(read_file(tmp_path / "d.ply").mesh.edges, curve.edges)
