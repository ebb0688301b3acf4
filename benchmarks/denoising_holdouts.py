"""How `denoise` without parameters does on meshes that its rules were not found on.

    python benchmarks/denoising_holdouts.py [--scans FOLDER] [--only text,text] [--save FOLDER]

Makes noisy meshes of shapes that everyone has: pymeshlab's samples, machine parts of boxes and cylinders, and depth maps of them.
FOLDER may hold scans, which are smoothed to be a truth. Prints the mean angle to the true normals over that of MeshLab's Taubin
filter with the number of steps that is best for this very mesh, and the same for the displacement of the vertices. --save writes
NAME_noisy.ply and NAME_truth.ply for denoising.py.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import igl
import numpy as np
import pymeshlab
import trimesh
from denoising_findings import chest
from denoising_metrics import Floats, Ints, angles_to_truth
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial.transform import Rotation

from pymeshfair.filters.denoising.automatic import denoise_automatically
from pymeshfair.filters.denoising.noise_level import smooth_normals
from pymeshfair.filters.geometry import mean_edge_length

SAMPLES = Path(pymeshlab.__file__).parent / "tests/sample_meshes"
#: the numbers of steps among which Taubin's filter is tuned
STEPS = (2, 3, 5, 7, 10, 15, 20, 30, 40, 60, 80, 120)


class Case(NamedTuple):
    """A mesh, its noisy copy, and the least mean angle and the displacement there that Taubin's filter reaches."""

    name: str
    noisy: Floats
    truth: Floats
    faces: Ints
    angle: float
    displacement: float


def measured(vertices: Floats, truth: Floats, faces: Ints) -> tuple[float, float]:
    """The mean angle in degrees, and the mean displacement in mean true edges."""
    moved = np.linalg.norm(vertices - truth, axis=1).mean() / mean_edge_length(truth, faces)
    return float(angles_to_truth(vertices, truth, faces)[0].mean()), float(moved)


def best_taubin(noisy: Floats, truth: Floats, faces: Ints) -> tuple[float, float]:
    """The measures of MeshLab's Taubin filter where the angle is least."""
    meshes, done, found = pymeshlab.MeshSet(), 0, []
    meshes.add_mesh(pymeshlab.Mesh(noisy, faces))
    for steps in STEPS:
        meshes.apply_coord_taubin_smoothing(stepsmoothnum=steps - done)
        done = steps
        found.append(measured(meshes.current_mesh().vertex_matrix(), truth, faces))
    return min(found)


def along_normals(level: float) -> Callable[[Floats, Ints, np.random.Generator], Floats]:
    """Normally distributed, of the given standard deviation in mean edges."""
    return lambda v, f, r: v + (r.normal(size=len(v)) * level * mean_edge_length(v, f))[:, None] * smooth_normals(v, f)


def all_directions(level: float) -> Callable[[Floats, Ints, np.random.Generator], Floats]:
    """The same along every axis."""
    return lambda v, f, r: v + r.normal(size=v.shape) * level * mean_edge_length(v, f)


def impulses(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
    """A fifth of the vertices are off, by half an edge."""
    return v + (r.normal(size=len(v)) * 0.5 * (r.random(len(v)) < 0.2) * mean_edge_length(v, f))[:, None] * smooth_normals(v, f)


def uniform(v: Floats, f: Ints, r: np.random.Generator) -> Floats:
    """In the directions of a cube, up to 0.4 edges: a standard deviation of 0.23."""
    return v + r.uniform(-0.4, 0.4, size=v.shape) * mean_edge_length(v, f)


NOISES: dict[str, Callable[[Floats, Ints, np.random.Generator], Floats]] = {
    **{f"n{10 * s:.0f}": along_normals(s) for s in (0.1, 0.2, 0.3, 0.5)},
    **{f"a{10 * s:.0f}": all_directions(s) for s in (0.2, 0.3)},
    "i": impulses,
    "u": uniform,
}


def shapes(scans: Path | None) -> Iterator[tuple[str, str, Callable[[], tuple[Floats, Ints]]]]:
    """Name, the noises it gets, and how it is made."""
    yield "bunny10k", "n1 n2 n3 n5 a3 i", lambda: taken(SAMPLES / "bunny10k_textured.obj")
    yield "bunny", "n2 a2", lambda: taken(SAMPLES / "bunny.obj", faces=30000)
    yield "cow", "n1 n3 a2 u", lambda: taken(SAMPLES / "cow.obj", edge=0.9)
    yield "bone", "n2 n5 a2 i", lambda: taken(SAMPLES / "bone.ply", edge=0.9)
    yield "airplane", "n1 n2 n3", lambda: taken(SAMPLES / "airplane.obj", edge=0.7)
    yield "chest", "n1 n3 a3", chest_mesh
    yield "bracket", "n1 n2 n3 n5 a2 a3 i u", lambda: part(True)
    yield "uneven", "n2 n3", lambda: part(False)
    yield "lens", "n1 n2 n3 a2", lens
    yield "dodecahedron", "n2 n5 a3", dodecahedron
    yield "torus", "n1 n3 u", torus
    if scans is not None:
        for file, faces in (("angel.obj", 48000), ("rabbit.obj", 30000), ("iron.ply", 40000)):
            yield file.split(".")[0], "n2 n3 a2", partial(taken, scans / file, faces=faces, smooth=10)


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


def depth_maps() -> Iterator[tuple[str, Floats, Floats, Ints]]:
    """Surfaces seen from one side.

    "camera": on a grid, with the steps of a depth camera and noise that neighbours share. "view": on a grid, with independent
    noise along the view. "fusion": the level set of many such maps in a grid of cubes.
    """
    scenes = {
        "pyramid": lambda x, y: 0.9 * np.maximum(0.0, 0.8 - np.maximum(abs(x), abs(y))),
        "hills": lambda x, y: 0.25 * np.sin(4 * x) * np.cos(3 * y) + 0.2 * np.exp(-8 * (x**2 + y**2)),
        "ball": lambda x, y: np.sqrt(np.maximum(0.64 - x**2 - y**2, 0.0)),
        "steps": lambda x, y: 0.2 * np.floor(2.5 * (x + 0.5 * y)),
    }
    for name, height in scenes.items():
        for kind in ("camera", "view"):
            yield f"{name}_{kind}", *depth_map(height, kind)
        if name != "steps":
            yield f"{name}_fusion", *fusion(height)


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
    at = np.arange(n * n).reshape(n, n)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, 1:].ravel(), at[1:, :-1].ravel()
    faces = np.concatenate([np.column_stack([a, c, b]), np.column_stack([a, d, c])]).astype(np.int32)
    noisy, truth = (np.column_stack([(x * z).ravel(), (y * z).ravel(), -z.ravel()]) for z in (found, depth))
    spread = np.ptp(depth.ravel()[faces], axis=1)
    faces = faces[spread < 4 * pixel]
    kept, numbers = np.unique(faces, return_inverse=True)
    return noisy[kept], truth[kept], np.ascontiguousarray(numbers.reshape(-1, 3), dtype=np.int32)


def fusion(height: Callable[[Floats, Floats], Floats], n: int = 110) -> tuple[Floats, Floats, Ints]:
    """A level set in cells of 2/n, with errors shared over 2 and over 12 cells and weak independent ones, and the truth."""
    rng = np.random.default_rng(13)
    cell = 2.0 / n
    plan, depth = np.linspace(-1.0, 1.0, n), np.arange(-1.2, 1.6, cell)
    # Cells do not lie along the view. The first index of the level set runs fastest.
    turn = Rotation.from_rotvec((0.2, 0.35, 0.1)).as_matrix()
    z, y, x = (a.ravel() for a in np.meshgrid(depth, plan, plan, indexing="ij"))
    grid = np.column_stack([x, y, z])
    error = np.zeros((n, n))
    for wide, size in ((12.0, 0.8), (2.0, 0.25), (0.0, 0.05)):
        layer = rng.normal(size=(n, n))
        layer = gaussian_filter(layer, wide) if wide > 0 else layer
        error += size * cell * layer / layer.std()
    seen = grid @ turn
    values = seen[:, 2] - height(seen[:, 0], seen[:, 1])
    values -= map_coordinates(error, ((seen[:, :2].T + 1.0) / cell).clip(0, n - 1), order=1, mode="nearest")
    found, faces, *_ = igl.marching_cubes(values, grid, n, n, len(depth), 0.0)
    true = found @ turn
    true[:, 2] = height(true[:, 0], true[:, 1])
    true = true @ turn.T
    corners = true[faces]
    large = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) > 1e-3 * cell**2
    kept, numbers = np.unique(faces[large], return_inverse=True)
    return found[kept], true[kept], np.ascontiguousarray(numbers.reshape(-1, 3), dtype=np.int32)


def cases(scans: Path | None, only: list[str]) -> Iterator[Case]:
    """Every mesh with each of its noises."""

    def wanted(name: str) -> bool:
        return not only or any(part in name for part in only)

    for shape, noises, make in shapes(scans):
        names = [noise for noise in noises.split() if wanted(f"{shape}_{noise}")]
        if not names:
            continue
        truth, faces = make()
        for name in names:
            noisy = NOISES[name](truth, faces, np.random.default_rng(7))
            yield Case(f"{shape}_{name}", noisy, truth, faces, *best_taubin(noisy, truth, faces))
    for name, noisy, truth, faces in depth_maps():
        if wanted(name):
            yield Case(name, noisy, truth, faces, *best_taubin(noisy, truth, faces))


def save(folder: Path, case: Case) -> None:
    """NAME_noisy.ply and NAME_truth.ply."""
    folder.mkdir(parents=True, exist_ok=True)
    for part, vertices in (("noisy", case.noisy), ("truth", case.truth)):
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(vertices, case.faces))
        meshes.save_current_mesh(str(folder / f"{case.name}_{part}.ply"))


def main() -> int:
    """Make, denoise and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scans", type=Path, help="a folder with angel.obj, rabbit.obj and iron.ply")
    parser.add_argument("--only", default="", help="parts of names, with commas; all by default")
    parser.add_argument("--save", type=Path, help="the folder for the pairs")
    options = parser.parse_args()
    ratios = []
    print("mesh                faces      kind noise  angle Taubin ratio moved Taubin     s")
    for case in cases(options.scans, [part for part in options.only.split(",") if part]):
        start = time.perf_counter()
        vertices, choice = denoise_automatically(case.noisy, case.faces)
        seconds = time.perf_counter() - start
        angle, moved = measured(vertices, case.truth, case.faces)
        ratios.append((angle / case.angle, moved / case.displacement))
        print(
            f"{case.name:18} {len(case.faces):6} {choice.kind:>9} {choice.noise.level:5.2f} {angle:6.2f} {case.angle:6.2f} "
            f"{ratios[-1][0]:5.2f} {moved:5.2f} {case.displacement:6.2f} {seconds:5.1f}",
            flush=True,
        )
        if options.save:
            save(options.save, case)
    if not ratios:
        raise SystemExit(f"no mesh has a name with {options.only}")
    mean, worst = np.mean(ratios, axis=0), np.max(ratios, axis=0)
    print(f"{len(ratios)} meshes: ratio of angles {mean[0]:.3f}, at worst {worst[0]:.3f}; of displacements {mean[1]:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
