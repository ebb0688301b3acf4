"""The measures of the denoising benchmark, on meshes whose errors are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from denoising_metrics import angles_to_truth, errors

from tests.meshes import Mesh, cube, grid, icosphere, noisy, rotation, single_triangle


def tilted(degrees: float) -> Mesh:
    """The right-angled triangle turned about its side of 3."""
    vertices, faces = single_triangle()
    angle = math.radians(degrees)
    turn = np.array([[1, 0, 0], [0, math.cos(angle), -math.sin(angle)], [0, math.sin(angle), math.cos(angle)]])
    return vertices @ turn.T, faces


@pytest.mark.parametrize("degrees", [0.0, 1e-9, 1e-4, 37.0, 90.0, 179.0, 180.0])
def test_a_turned_triangle_is_off_by_the_angle_of_the_turn(degrees: float) -> None:
    """Angles from a billionth of a degree to 180 come out to 12 digits, where an arc cosine would give 0 below a millionth."""
    truth, faces = single_triangle()
    found = errors(tilted(degrees)[0], truth, faces)
    assert [found.mad, found.mad_by_area, found.rms] == pytest.approx([degrees] * 3, rel=1e-12, abs=1e-14)
    assert found.flips == (degrees > 90)


def sliding_grid() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A flat grid of unit squares and its copy whose inner vertices slide by 0.2."""
    truth, faces = grid(6, 6)
    inner = (truth[:, 0] % 6 > 0) & (truth[:, 1] % 6 > 0)
    return truth + np.outer(inner, [0.2, 0.0, 0.0]), truth, faces


@pytest.mark.parametrize(
    ("mesh", "edge", "distance", "displacement", "angle"),
    [
        # A 3-4-5 triangle turned by 90 degrees moves its third corner by 4 root 2 and lifts it by 4.
        ((tilted(90.0)[0], *single_triangle()), 4.0, 4.0 / 3, 4.0 * math.sqrt(2) / 3, 90.0),
        # Drift within the surface shows in the displacement alone.
        (sliding_grid(), (2 * 42 + 36 * math.sqrt(2)) / (84 + 36), 0.0, 0.2 * 25 / 49, 0.0),
        # A cube moved by 0.1 has right normals; each vertex is off by 0.1, the half outside by as much.
        ((cube()[0] + [0.1, 0, 0], *cube()), (12 + 6 * math.sqrt(2)) / 18, 0.05, 0.1, 0.0),
    ],
)
def test_distances_are_in_mean_true_edges(
    mesh: tuple[np.ndarray, np.ndarray, np.ndarray], edge: float, distance: float, displacement: float, angle: float
) -> None:
    """Those to the surface and those to the true places, in closed form."""
    found = errors(*mesh)
    assert (found.distance * edge, found.displacement * edge) == pytest.approx((distance, displacement))
    assert found.mad == pytest.approx(angle, abs=1e-13)
    assert found.flips == 0


def test_means_are_over_faces_and_over_area() -> None:
    """Of two triangles with areas 1 to 9, the small one off by 90 degrees: 45 by faces, 9 by area, 90 / sqrt 2 as RMS."""
    truth = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 0], [8, 0, 0], [5, 3, 0]], float)
    tilted = truth.copy()
    tilted[2] = [0, 0, 1]
    found = errors(tilted, truth, np.array([[0, 1, 2], [3, 4, 5]], dtype=np.int32))
    assert found.mad == pytest.approx(45.0)
    assert found.mad_by_area == pytest.approx(9.0)
    assert found.rms == pytest.approx(90.0 / math.sqrt(2))


def test_a_face_squashed_to_nothing_does_not_count_as_right() -> None:
    """Without a normal it is 90 degrees off, and one that truly has no area is left out."""
    truth = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], float)
    faces = np.array([[0, 1, 2], [0, 1, 3]], dtype=np.int32)
    squashed = truth.copy()
    squashed[2] = 0.0
    angles, areas = angles_to_truth(squashed, truth, faces)
    assert (list(angles), list(areas)) == ([90.0], [0.5])
    assert list(angles_to_truth(truth, truth, faces)[0]) == [0.0]


def test_turns_scales_and_vertices_that_no_face_uses_change_nothing() -> None:
    """Angles and distances in edges belong to the shape, to 1e-10; a stray vertex that moves by 100 does not count."""
    truth, faces = icosphere(2)
    rough, turn = noisy((truth, faces), 0.05)[0], 1e3 * rotation(1)
    expected = errors(rough, truth, faces)
    assert errors(np.append(rough, [[100.0, 0, 0]], axis=0), np.append(truth, [[0.0, 0, 0]], axis=0), faces) == expected
    turned = errors(rough @ turn.T, truth @ turn.T, faces)
    assert list(vars(turned).values()) == pytest.approx(list(vars(expected).values()), rel=1e-10)
