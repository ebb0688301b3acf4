"""Shapes that everyone has: pymeshlab's samples, machine parts of boxes and cylinders, and depth maps of surfaces."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import trimesh
from denoising_findings import chest
from denoising_metrics import Floats, Ints, used_alone
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"


def read_mesh(path: Path) -> tuple[Floats, Ints]:
    """Vertices and faces of any file that MeshLab reads."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    return np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def taken(path: Path, *, faces: int = 0, edge: float = 0.0, smooth: int = 0) -> tuple[Floats, Ints]:
    """A file, with fewer faces, or meshed anew with edges of a percentage of its size, and smoothed."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    meshes.meshing_merge_close_vertices()
    meshes.meshing_repair_non_manifold_edges()
    if smooth:
        meshes.apply_coord_taubin_smoothing(stepsmoothnum=smooth)
    if 0 < faces < meshes.current_mesh().face_number():
        meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=faces, preservenormal=True)
    return remeshed(meshes, edge)


def remeshed(meshes: pymeshlab.MeshSet, edge: float = 1.0) -> tuple[Floats, Ints]:
    """Vertices and faces, with edges of the given percentage of the diagonal; creases of 30 degrees stay."""
    if edge > 0.0:
        meshes.meshing_isotropic_explicit_remeshing(iterations=10, targetlen=pymeshlab.PercentageValue(edge), featuredeg=30)
    meshes.meshing_remove_unreferenced_vertices()
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix().copy(), mesh.face_matrix().astype(np.int32)


def in_order(meshes: pymeshlab.MeshSet) -> pymeshlab.MeshSet:
    """The current mesh alone, its vertices and faces sorted: MeshLab's booleans list them in another order from run to run.

    Coordinates are rounded to nine digits, since their last ones differ too; what is meshed anew would be another mesh.
    """
    mesh = meshes.current_mesh()
    vertices, number = np.unique(np.round(mesh.vertex_matrix(), 9) + 0.0, axis=0, return_inverse=True)
    faces = np.array([np.roll(corners, -corners.argmin()) for corners in number.ravel()[mesh.face_matrix()]])
    ordered = pymeshlab.MeshSet()
    ordered.add_mesh(pymeshlab.Mesh(vertices, faces[np.lexsort(faces.T[::-1])]))
    return ordered


def chest_mesh() -> tuple[Floats, Ints]:
    """Flat and rounded sides that meet at sharp edges, meshed irregularly."""
    made = chest(30)
    return made.truth, made.faces


def part(even: bool) -> tuple[Floats, Ints]:
    """A box with a peg and a hole, meshed evenly, or with triangles of many sizes."""
    meshes = pymeshlab.MeshSet()
    peg, hole = (trimesh.creation.cylinder(radius=r, height=1.4, sections=64) for r in (0.25, 0.3))
    peg.apply_translation((-0.5, 0.0, 0.4))
    hole.apply_translation((0.4, 0.0, 0.0))
    for piece in (trimesh.creation.box((2.0, 1.2, 0.6)), peg, hole):
        meshes.add_mesh(pymeshlab.Mesh(piece.vertices, piece.faces))
    meshes.generate_boolean_union(first_mesh=0, second_mesh=1)
    meshes.generate_boolean_difference(first_mesh=3, second_mesh=2)
    meshes = in_order(meshes)
    vertices, faces = remeshed(meshes, 1.6 if even else 0.9)
    if even:
        return vertices, faces
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=12000, optimalplacement=True, planarquadric=True)
    return remeshed(meshes, 0.0)


def lens() -> tuple[Floats, Ints]:
    """A ball with two flat ends: round and flat parts that meet at sharp edges."""
    meshes = pymeshlab.MeshSet()
    for piece in (trimesh.creation.icosphere(subdivisions=5), trimesh.creation.box((1.2, 3.0, 3.0))):
        meshes.add_mesh(pymeshlab.Mesh(piece.vertices, piece.faces))
    meshes.generate_boolean_intersection(first_mesh=0, second_mesh=1)
    return remeshed(in_order(meshes), 1.5)


def dodecahedron() -> tuple[Floats, Ints]:
    """Twelve planes."""
    meshes = pymeshlab.MeshSet()
    meshes.create_dodecahedron()
    return remeshed(meshes, 1.5)


def torus() -> tuple[Floats, Ints]:
    """Round everywhere, its faces in rows."""
    meshes = pymeshlab.MeshSet()
    meshes.create_torus(hradius=3, vradius=1, hsubdiv=120, vsubdiv=60)
    return remeshed(meshes, 0.0)


def depth_map(height: Callable[[Floats, Floats], Floats], kind: str, n: int = 130) -> tuple[Floats, Floats, Ints]:
    """Noisy vertices, true vertices and faces of a perspective depth map of n^2 points; jumps of depth are cut out."""
    rng = np.random.default_rng(11)
    distance, reach = 3.0, 1.25 / 3.0
    slope = np.linspace(-reach, reach, n)
    x, y = np.meshgrid(slope, slope)
    depth = np.full_like(x, distance)
    for _ in range(50):
        depth = 0.5 * depth + 0.5 * (distance - height(x * depth, y * depth))
    pixel = 2 * reach / n * distance
    if kind == "camera":
        # The disparity, 1 / depth, is matched over windows and rounded; a step is 1.5 pixels deep.
        step = 1.5 * pixel / distance**2
        shared = gaussian_filter(rng.normal(size=depth.shape), 1.5)
        found = 1.0 / (np.round((1.0 / depth + 0.6 * step * shared / shared.std()) / step) * step)
    else:
        found = depth + 0.3 * pixel * rng.normal(size=depth.shape)
    faces = between_rows(np.arange(n * n).reshape(n, n))
    noisy, truth = (np.column_stack([(x * z).ravel(), (y * z).ravel(), -z.ravel()]) for z in (found, depth))
    return used_alone(faces[np.ptp(depth.ravel()[faces], axis=1) < 4 * pixel], noisy, truth)


def between_rows(numbers: NDArray[np.integer[Any]]) -> Ints:
    """The triangles between the rows of vertices that an array of their numbers has."""
    at = numbers.astype(np.int32)
    return halved(at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:])


def halved(a: Ints, b: Ints, c: Ints, d: Ints) -> Ints:
    """(2 k, 3) triangles of k quadrilaterals, given by their corners in order."""
    halves = [np.column_stack([p.ravel() for p in corners]) for corners in ((a, b, c), (a, c, d))]
    return np.concatenate(halves).astype(np.int32)
