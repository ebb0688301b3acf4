"""What a run says of the shape it has changed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pymeshfair.filters.inspection import surface_measures
from pymeshfair.running.shape_change import ShapeChange, shape_change, warnings_of
from tests.commands.command_line import document, run_process
from tests.meshes import Mesh, icosphere


def change_of(before: Mesh, after: Mesh) -> ShapeChange:
    """The change from one mesh to another."""
    return shape_change(before, after, (surface_measures(*before), surface_measures(*after)))


def test_a_stretched_sphere() -> None:
    """Twice as long along x is +100 % there and in volume; the pole of x moves furthest, by its coordinate."""
    vertices, faces = icosphere(3)
    found = change_of((vertices, faces), (vertices * [2.0, 1.0, 1.0], faces))
    assert found.sides == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    assert found.volume == pytest.approx(1.0)
    assert found.moved is not None
    assert found.moved.largest == pytest.approx(np.abs(vertices[:, 0]).max())
    assert found.moved.place[0] == pytest.approx(vertices[found.moved.vertex, 0])
    assert found.turned == 0
    (dimensions, moved) = warnings_of(found)
    assert "x +100.0%, y +0.0%, z +0.0%" in dimensions
    assert f"vertex {found.moved.vertex} at " in moved


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


def test_other_elements_have_no_displacement_and_no_warning() -> None:
    """Where faces were removed vertices may still correspond, but the shape was changed on purpose."""
    vertices, faces = icosphere(2)
    found = change_of((vertices, faces), (vertices[:100], np.empty((0, 3), dtype=np.int32)))
    assert found.moved is None
    assert list(warnings_of(found)) == []


@pytest.mark.parametrize("scale", [1e-160, 1e150])
def test_sizes_at_the_ends_of_the_numbers(scale: float) -> None:
    """No square of a length leaves the range of numbers."""
    vertices, faces = icosphere(2)
    moved = change_of((vertices * scale, faces), (vertices * (1.5 * scale), faces)).moved
    assert moved is not None
    assert moved.mean == pytest.approx(0.5 * scale)


def test_a_run_says_it(tmp_path: Path) -> None:
    """The document of a run has the change, the table a line of it, and shrinking by more than 1 % is a warning."""
    vertices, faces = icosphere(2)
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0", *(f"{x} {y} {z}" for x, y, z in vertices)]
    (tmp_path / "ball.off").write_text("\n".join([*lines, *(f"3 {a} {b} {c}" for a, b, c in faces)]) + "\n")
    ran = run_process("run", "smooth_laplacian", tmp_path / "ball.off", "-o", tmp_path / "small.off", "--json")
    change = document(ran.stdout)["change"]
    assert change["sides"] == pytest.approx([change["sides"][0]] * 3, abs=0.01)
    assert change["sides"][0] < -0.02
    assert change["moved"]["mean"] == pytest.approx(-change["sides"][0], rel=0.2)
    assert "the result has other dimensions: x -" in ran.stderr
