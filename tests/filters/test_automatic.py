"""Denoising without parameters."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.filters.denoising.automatic import SHARP, automatic_parameters, denoise_automatically
from pymeshfair.filters.denoising.noise_level import smooth_normals
from pymeshfair.filters.denoising.normal_filtering import normal_filtering
from pymeshfair.filters.diffusion.taubin import taubin_fairing
from pymeshfair.filters.geometry import face_normals, mean_edge_length
from tests.angles import mean_angle
from tests.meshes import cube, grid, icosphere, irregular_grid, noisy, renumbered, rotation, single_triangle, subdivided, torus

FINE_CUBE = subdivided(*subdivided(*subdivided(*subdivided(*cube()))))


def _along_normals(mesh: tuple[np.ndarray, np.ndarray], level: float) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = mesh
    heights = np.random.default_rng(3).normal(size=len(vertices)) * level * mean_edge_length(vertices, faces)
    return vertices + heights[:, None] * smooth_normals(vertices, faces), faces


BLOCK = _along_normals(FINE_CUBE, 0.3)
ROUND = _along_normals(torus(60, 30), 0.2)
SCATTERED = noisy(torus(60, 30), 0.06, seed=4)


@pytest.mark.parametrize("mesh", [cube(), FINE_CUBE, grid(), irregular_grid(), single_triangle()])
def test_designed_planes_are_fixed(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    """A cube without noise stays a cube, turned or not, and a plane a plane, to the bit."""
    for turn in (np.eye(3), rotation()):
        vertices = mesh[0] @ turn.T
        result, choice = denoise_automatically(vertices, mesh[1])
        assert choice.kind == "clean"
        assert np.array_equal(result, vertices)


def test_a_mesh_without_faces_is_fixed() -> None:
    """Points alone stay where they are."""
    points = np.eye(3)
    assert np.array_equal(denoise_automatically(points, np.empty((0, 3), dtype=np.int32))[0], points)


def test_a_noisy_cube_is_taken_for_sharp_and_gets_its_sides_back() -> None:
    """The mean angle to the true normals falls to less than a sixth, and below half of what Taubin's 10 default steps leave."""
    vertices, faces = BLOCK
    result, choice = denoise_automatically(vertices, faces)
    truth = face_normals(FINE_CUBE[0], faces)
    assert choice.kind == "sharp"
    angle, before, faired = (
        mean_angle(face_normals(v, faces), truth) for v in (result, vertices, taubin_fairing(vertices, faces))
    )
    assert angle < before / 6.0
    assert angle < 0.5 * faired


def test_a_noisy_sphere_is_nearer_the_truth() -> None:
    """The vertices come nearer to where they were, and the normals are better than after Taubin's 10 default steps."""
    vertices, faces = noisy(icosphere(4), 0.012, seed=5)
    true_vertices = icosphere(4)[0]
    result, _ = denoise_automatically(vertices, faces)
    truth = face_normals(true_vertices, faces)
    angles = [mean_angle(face_normals(v, faces), truth) for v in (result, taubin_fairing(vertices, faces))]
    assert angles[0] < angles[1]
    assert np.linalg.norm(result - true_vertices, axis=1).mean() < np.linalg.norm(vertices - true_vertices, axis=1).mean()


def test_a_cube_with_noise_in_all_directions_is_relaxed_first() -> None:
    """Its sides come back nevertheless: the mean angle is below a third of what Taubin's 10 default steps leave."""
    vertices, faces = noisy(FINE_CUBE, 0.3 * mean_edge_length(*FINE_CUBE), seed=4)
    result, choice = denoise_automatically(vertices, faces)
    truth = face_normals(FINE_CUBE[0], faces)
    assert choice.kind == "sharp"
    assert choice.relaxation > 0
    angle, faired = (mean_angle(face_normals(v, faces), truth) for v in (result, taubin_fairing(vertices, faces)))
    assert angle < faired / 3.0


@pytest.mark.parametrize("mesh", [BLOCK, ROUND, SCATTERED])
def test_the_parameters_reproduce_the_result(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    """What `automatic_parameters` says, given to `normal_filtering`, does what `denoise_automatically` does."""
    result, choice = denoise_automatically(*mesh)
    assert automatic_parameters(*mesh).parameters == choice.parameters
    assert choice.parameters is not None
    assert choice.relaxation > 0 or choice.kind != "scattered"
    fair = taubin_fairing(*mesh, iterations=choice.relaxation)
    np.testing.assert_allclose(result, normal_filtering(fair, mesh[1], **vars(choice.parameters)), atol=1e-12)


@pytest.mark.parametrize("mesh", [BLOCK, ROUND, SCATTERED])
def test_turned_scaled_and_renumbered_meshes_get_the_same_result(mesh: tuple[np.ndarray, np.ndarray]) -> None:
    """The result moves with the mesh to 1e-9 of its size."""
    vertices, faces = mesh
    result, choice = denoise_automatically(vertices, faces)
    turn = rotation()
    turned, other = denoise_automatically(10.0 * vertices @ turn.T, faces)
    assert other.parameters == choice.parameters
    np.testing.assert_allclose(turned, 10.0 * result @ turn.T, atol=1e-8)
    shuffled_vertices, shuffled_faces, old = renumbered(mesh)
    shuffled, _ = denoise_automatically(shuffled_vertices, shuffled_faces)
    np.testing.assert_allclose(shuffled, result[old], atol=1e-9)


def test_vertices_that_may_not_move_keep_every_bit() -> None:
    """`movable` is respected by every setting."""
    for vertices, faces in (BLOCK, ROUND, SCATTERED):
        movable = np.random.default_rng(0).random(len(vertices)) < 0.5
        result, _ = denoise_automatically(vertices, faces, movable=movable)
        assert np.array_equal(result[~movable], vertices[~movable])
        assert not np.array_equal(result[movable], vertices[movable])


def test_progress_rises_to_1() -> None:
    """Fractions never fall, and the last is 1."""
    told: list[float] = []
    denoise_automatically(*ROUND, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0


@pytest.mark.parametrize(("name", "kind", "best"), [("fandisk_n3", "sharp", 2.56), ("nicolo_n2", "smooth", 6.15)])
def test_pairs_of_the_literature(name: str, kind: str, best: float) -> None:
    """On a machine part and on a figure the automatic result beats the best published or tuned one."""
    folder = os.environ.get("PYMESHFAIR_DATA")
    if not folder:
        pytest.skip("PYMESHFAIR_DATA is not set: it is the folder with denoising/NAME_noisy.ply")
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    for part in ("truth", "noisy"):
        meshes.load_new_mesh(str(Path(folder) / "denoising" / f"{name}_{part}.ply"))
    scan, truth = meshes.mesh(1), meshes.mesh(0)
    result, choice = denoise_automatically(scan.vertex_matrix(), scan.face_matrix())
    angle = mean_angle(face_normals(result, truth.face_matrix()), face_normals(truth.vertex_matrix(), truth.face_matrix()))
    assert choice.kind == kind
    assert angle < best
    if kind == "sharp":
        assert choice.parameters == SHARP
