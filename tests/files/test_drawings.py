"""Curves as drawings: every curve whole, closed ones closed, in DXF with every digit, in SVG upright."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.files.errors import OutputError
from pymeshfair.files.plain import polylines
from pymeshfair.mesh_data import MeshData
from tests.meshes import cube

from .round_trips import save

#: an open curve of three vertices, a closed triangle, and the vertex of a fork of three
OPEN, CLOSED = [[1, 0], [1, 2]], [[3, 4], [5, 4], [5, 3]]
POINTS = np.array([[0.0, 0, 2], [1 / 3, 0, 2], [2, 1, 2], [5, 5, 2], [6, 5, 2], [5, 6, 2]])


def curves() -> MeshData:
    """The open curve and the triangle in the plane z = 2."""
    return MeshData(vertices=POINTS, edges=np.array(OPEN + CLOSED, dtype=np.int32), unit="mm")


def test_edges_are_joined_to_curves_that_end_at_forks() -> None:
    """In any order and direction; a fork of three ends three curves."""
    assert list(polylines(curves().edges)) == [[0, 1, 2], [3, 4, 5, 3]]
    fork = np.array([[0, 1], [2, 1], [1, 3], [3, 4]])
    assert sorted(map(sorted, polylines(fork))) == [[0, 1], [1, 2], [1, 3, 4]]


def test_a_dxf_has_each_curve_with_every_digit(tmp_path: Path) -> None:
    """Pairs of code and value: two polylines in space, the second closed, their vertices those of the mesh."""
    assert save(curves(), tmp_path / "cut.dxf") == ()
    lines = (tmp_path / "cut.dxf").read_text("ascii").splitlines()
    pairs = list(zip(lines[::2], lines[1::2], strict=True))
    starts = [k for k, pair in enumerate(pairs) if pair == ("0", "POLYLINE")]
    assert [dict(pairs[k + 1 : k + 7])["70"] for k in starts] == ["8", "9"]
    vertices = [dict(pairs[k + 1 : k + 6]) for k, pair in enumerate(pairs) if pair == ("0", "VERTEX")]
    np.testing.assert_array_equal([[float(v[code]) for code in ("10", "20", "30")] for v in vertices], POINTS)
    assert pairs[-1] == ("0", "EOF")


def test_an_svg_is_the_plane_of_the_curves_at_their_size(tmp_path: Path) -> None:
    """6 mm wide and high, y upwards; curves that leave their plane lose a coordinate, which is said."""
    assert save(curves(), tmp_path / "cut.svg") == ()
    text = (tmp_path / "cut.svg").read_text("ascii")
    assert 'width="6mm" height="6mm" viewBox="0 -6 6 6"' in text
    assert re.findall(r'd="(.*?)"', text) == [
        "M0.0,-0.0L0.3333333333333333,-0.0L2.0,-1.0",
        "M5.0,-5.0L6.0,-5.0L5.0,-6.0L5.0,-5.0Z",
    ]
    bent = MeshData(vertices=POINTS + np.outer(np.arange(6.0), [0.0, 0.0, 0.1]), edges=curves().edges)
    (warning,) = save(bent, tmp_path / "bent.svg")
    assert "the coordinate z of the curves" in warning


def test_a_mesh_without_curves_is_no_drawing(tmp_path: Path) -> None:
    """It is refused with the recipe that cuts some."""
    vertices, faces = cube()
    with pytest.raises(OutputError, match="smooth_section"):
        save(MeshData(vertices=vertices, faces=faces), tmp_path / "cube.dxf")


def test_a_straight_curve_can_be_seen(tmp_path: Path) -> None:
    """The view of an SVG file shows nothing if its height is 0."""
    save(MeshData(vertices=np.array([[0.0, 0, 0], [8, 0, 0]]), edges=np.array([[0, 1]])), tmp_path / "a.svg")
    assert 'width="8" height="0.008" viewBox="0 -0 8 0.008"' in (tmp_path / "a.svg").read_text()
