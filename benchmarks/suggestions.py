"""Whether the first recipe that `pymeshfair suggest` names is the best, on made scans whose truth is known.

    python benchmarks/suggestions.py [--kinds text,text] [--sizes 1.0,0.7,1.4]

Ten kinds of scans, each in three versions: other noise by the factor of a size, other random numbers. The measure is the root
mean square distance of the result's vertices from the true surface, in mean edges of the truth, 0.01 at least, so that nothing
done on an exact scan is as good as next to nothing. Every recipe that fits and is there to clean, denoise or smooth is run; doing
nothing counts too, as does the first recipe whatever its task. The first is right if it is the best or within 5 % of it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pymeshlab
from numpy.typing import NDArray

import pymeshfair
from pymeshfair.filters.geometry import mean_edge_length

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mesh = tuple[Floats, Ints]
TASKS = ("clean", "denoise", "smooth")
LEAST, TOLERANCE = 0.01, 0.05


def made(**filters: dict[str, object]) -> Mesh:
    """What MeshLab's filters make, one after the other."""
    meshes = pymeshlab.MeshSet()
    for name, values in filters.items():
        getattr(meshes, name)(**values)
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def ball() -> Mesh:
    """A ball."""
    return made(create_sphere={"radius": 1.0, "subdiv": 4})


def box() -> Mesh:
    """A box of even triangles."""
    cells: dict[str, object] = {"targetlen": pymeshlab.PureValue(0.04), "iterations": 6}
    return made(create_cube={"size": 1.0}, meshing_isotropic_explicit_remeshing=cells)


def bumpy(height: float = 0.03) -> Mesh:
    """A ball with bumps of about ten edges."""
    points, faces = ball()
    x, y, z = 6.0 * points.T
    return points * (1.0 + height * np.sin(x) * np.sin(y) * np.cos(z))[:, None], faces


def doughnut() -> Mesh:
    """A torus."""
    return made(create_torus={"hradius": 2.0, "vradius": 0.7, "hsubdiv": 90, "vsubdiv": 30})


def hills(steps: float = 0.0) -> Mesh:
    """A sheet with hills, or with steps of some height."""
    x, y = np.meshgrid(np.arange(55.0), np.arange(50.0), indexing="ij")
    z = 3.0 * np.sin(x / 9.0) * np.cos(y / 8.0) if not steps else steps * (x > 25) + steps * (y > 30)
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return np.stack([x, y, z], -1).reshape(-1, 3), faces.astype(np.int32)


def cut_tube() -> Mesh:
    """An open cylinder."""
    around, along = np.meshgrid(np.arange(90), np.arange(40), indexing="ij")
    points = np.stack([np.cos(around * np.pi / 45), np.sin(around * np.pi / 45), 0.07 * along], -1).reshape(-1, 3)
    index = np.arange(90 * 40).reshape(90, 40)
    a, b = index[:, :-1], np.roll(index, -1, 0)[:, :-1]
    c, d = np.roll(index, -1, 0)[:, 1:], index[:, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return points, faces.astype(np.int32)


def noisy(mesh: Mesh, level: float, rng: np.random.Generator, share: float = 1.0) -> Floats:
    """The vertices with noise in all directions, in mean edges; of a share of them."""
    points, faces = mesh
    hit = rng.random(len(points)) < share
    return points + rng.normal(scale=level * mean_edge_length(points, faces), size=points.shape) * hit[:, None]


#: by name: the truth, the level of noise in mean edges, the share of the vertices that have it
KINDS: dict[str, tuple[Callable[[], Mesh], float, float]] = {
    "ball, noise": (ball, 0.3, 1.0),
    "box, noise": (box, 0.25, 1.0),
    "bumps, no noise": (bumpy, 0.0, 1.0),
    "bumps, noise": (bumpy, 0.2, 1.0),
    "torus, weak noise": (doughnut, 0.1, 1.0),
    "range map of hills, noise": (hills, 0.2, 1.0),
    "range map of steps, noise": (lambda: hills(8.0), 0.15, 1.0),
    "range map of hills, no noise": (hills, 0.0, 1.0),
    "open tube, noise": (cut_tube, 0.2, 1.0),
    "box, impulses": (box, 0.6, 0.2),
}


def saved(path: Path, points: Floats, faces: Ints) -> Path:
    """A file with them."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(points, faces))
    meshes.save_current_mesh(str(path))
    return path


def distance(points: Floats, truth: Mesh) -> float:
    """The measure."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*truth))
    meshes.add_mesh(pymeshlab.Mesh(points))
    meshes.compute_scalar_by_distance_from_another_mesh_per_vertex(measuremesh=1, refmesh=0, signeddist=False)
    away = meshes.mesh(1).vertex_scalar_array()
    return max(LEAST, float(np.sqrt(np.mean(away**2))) / mean_edge_length(*truth))


def ranking(scan: Path) -> list[dict[str, object]]:
    """The recipes in the order of `suggest`."""
    command = [sys.executable, "-m", "pymeshfair", "suggest", str(scan), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return list(json.loads(done.stdout)["recipes"])


def judged(kind: str, size: float, folder: Path) -> tuple[str, dict[str, float]]:
    """The first recipe for a made scan, and the measure of every one that was run."""
    make, level, share = KINDS[kind]
    truth = make()
    rng = np.random.default_rng([list(KINDS).index(kind), int(100 * size)])
    points = noisy(truth, level * size, rng, share)
    scan = saved(folder / "scan.ply", points, truth[1])
    recipes = ranking(scan)
    first = str(recipes[0]["recipe"])
    names = {first, *(str(r["recipe"]) for r in recipes if r["fits"] and r["task"] in TASKS)}
    found = {"nothing": distance(points, truth)}
    for name in sorted(names):
        try:
            pymeshfair.run(name, scan, folder / "result.ply", overwrite=True)
        except pymeshfair.PymeshfairError as error:
            print(f"  {name}: {error}", file=sys.stderr)
            continue
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(folder / "result.ply"))
        found[name] = distance(meshes.current_mesh().vertex_matrix(), truth)
    return first, found


def main() -> int:
    """A line for each scan; exits with 1 if a first recipe is not right."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", default="", help="texts, one of which is in the name of a kind")
    parser.add_argument("--sizes", default="1.0,0.7,1.4", help="factors of the noise")
    options = parser.parse_args()
    wanted = [kind for kind in KINDS if any(text in kind for text in options.kinds.split(","))]
    wrong = 0
    for size in map(float, options.sizes.split(",")):
        for kind in wanted:
            with tempfile.TemporaryDirectory() as folder:
                first, found = judged(kind, size, Path(folder))
            best = min(found, key=lambda name: found[name])
            right = found.get(first, np.inf) <= (1.0 + TOLERANCE) * found[best]
            wrong += not right
            told = ", ".join(f"{name} {value:.3f}" for name, value in sorted(found.items(), key=lambda item: item[1]))
            print(f"{'right' if right else 'WRONG'}  {kind} x {size:g}: {first} first; {told}", flush=True)
    print(f"{wrong} of {len(wanted) * len(options.sizes.split(','))} first recipes are not the best or within {TOLERANCE:.0%}")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
