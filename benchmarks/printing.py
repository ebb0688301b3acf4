"""What `prepare_for_print` makes of open, self-intersecting and many-part shapes: what it writes, three other programs judge.

    python benchmarks/printing.py [--only text,text] [--keep FOLDER]

Each STL file that is written must be closed, oriented and manifold for trimesh, admesh and MeshLab, and no faces may cut others
for MeshLab; of the others the message is printed. admesh is the Debian package of that name.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pymeshlab
import trimesh
from denoising_metrics import Floats, Ints
from denoising_pairs import SAMPLES, between_rows, depth_map, emblems, gear, gyroid, knot, level_set, plate, taken, torus

import pymeshfair
from pymeshfair.filters.geometry import mean_edge_length

Mesh = tuple[Floats, Ints]


def ball(x: float = 0.0, radius: float = 1.0) -> Mesh:
    """A ball."""
    found = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    return found.vertices + np.array([x, 0.0, 0.0]), found.faces.astype(np.int32)


def cube(at: tuple[float, float, float]) -> Mesh:
    """A cube of side 1."""
    found = trimesh.creation.box(bounds=[np.subtract(at, 0.5), np.add(at, 0.5)])
    return np.asarray(found.vertices), found.faces.astype(np.int32)


def parts(*meshes: Mesh) -> Mesh:
    """Several in one file."""
    starts = np.cumsum([0, *(len(points) for points, _ in meshes)])
    faces = [faces + start for (_, faces), start in zip(meshes, starts[:-1], strict=True)]
    return np.concatenate([points for points, _ in meshes]), np.concatenate(faces).astype(np.int32)


def cut(mesh: Mesh, keeps: Callable[[Floats], np.ndarray]) -> Mesh:
    """The faces whose middle is kept."""
    points, faces = mesh
    return points, faces[keeps(points[faces].mean(axis=1))]


def tube(turn: float = 0.0, n: int = 90) -> Mesh:
    """A band around the z axis that makes so many half turns."""
    t, across = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, n, endpoint=False), np.linspace(-0.5, 0.5, 9), indexing="ij")
    out = 1.0 + across * np.sin(turn * t / 2.0)
    points = np.stack([out * np.cos(t), out * np.sin(t), across * np.cos(turn * t / 2.0)], -1).reshape(-1, 3)
    index = np.arange(n * 9).reshape(n, 9)
    index = np.concatenate([index, index[:1, ::-1] if turn % 2 else index[:1]])
    return points, between_rows(index)


def torn() -> Mesh:
    """A ball of which one face in twenty is gone, and one in twenty turned over."""
    points, faces = ball()
    dice = np.random.default_rng(1).random(len(faces))
    faces[dice > 0.95] = faces[dice > 0.95][:, ::-1]
    return points, faces[dice > 0.05]


def scan(name: str, cut_at: float) -> Mesh:
    """The upper part of a sample of pymeshlab."""
    points, faces = taken(SAMPLES / name)
    return cut((points, faces), lambda middles: middles[:, 1] > np.quantile(points[:, 1], cut_at))


def crumpled(level: float) -> Mesh:
    """A ball with so much noise that faces cut others."""
    points, faces = ball()
    return points + np.random.default_rng(2).normal(scale=level * mean_edge_length(points, faces), size=points.shape), faces


SHAPES: dict[str, Callable[[], Mesh]] = {
    "open: tube": tube,
    "open: bowl": lambda: cut(ball(), lambda middles: middles[:, 2] < 0.2),
    "open: ball with five holes": lambda: cut(ball(), lambda m: np.abs(m).max(axis=1) < 0.94),
    "open: half a torus": lambda: cut(torus(), lambda m: m[:, 2] > 0.0),
    "open: half a gear": lambda: cut(gear(), lambda m: m[:, 2] > 0.0),
    "open: gyroid": gyroid,
    "open: cut knot": lambda: cut(knot(), lambda m: m[:, 0] < 2.0),
    "open: sheet of emblems": emblems,
    "open: range map": lambda: depth_map(lambda x, y: 0.3 * np.sin(4 * x) * np.cos(3 * y), 60),
    "open: Moebius strip": lambda: tube(1.0),
    "open: band of a whole turn": lambda: tube(2.0),
    "open: bunny": lambda: scan("bunny10k_textured.obj", 0.1),
    "open: bone": lambda: scan("bone.ply", 0.4),
    "open: torn ball": torn,
    "cuts itself: two balls": lambda: parts(ball(), ball(1.0)),
    "cuts itself: crumpled ball": lambda: crumpled(0.4),
    "cuts itself: airplane": lambda: taken(SAMPLES / "airplane.obj"),
    "cuts itself: cow": lambda: taken(SAMPLES / "cow.obj"),
    "cuts itself: flat knot": lambda: (knot()[0] * np.array([1.0, 1.0, 0.1]), knot()[1]),
    "parts: five balls": lambda: parts(*(ball(3.0 * k) for k in range(5))),
    "parts: hollow ball": lambda: parts(ball(), (ball(radius=0.6)[0], ball()[1][:, ::-1])),
    "parts: ball in a ball": lambda: parts(ball(), ball(radius=0.6)),
    "parts: ball and dust": lambda: parts(ball(), *(ball(1.5 + 0.1 * k, 0.03) for k in range(20))),
    "parts: cubes at an edge": lambda: parts(cube((0.0, 0.0, 0.0)), cube((1.0, 1.0, 0.0))),
    "parts: cubes at a corner": lambda: parts(cube((0.0, 0.0, 0.0)), cube((1.0, 1.0, 1.0))),
    "parts: half balls": lambda: parts(*(cut(ball(3.0 * k), lambda m: m[:, 2] < 0.3) for k in range(3))),
    "parts: plate and blobs": lambda: parts(plate(), level_set(lambda x, y, z: (x**2 + y**2 - 0.4) ** 2 + z**2 - 0.05, 40, 2.0)),
}


def faults(written: Path) -> Iterator[str]:
    """What three programs find wrong with a file."""
    mesh = trimesh.load_mesh(written)
    closed, consistent = mesh.is_watertight, mesh.is_winding_consistent
    if not (closed and consistent and mesh.volume > 0.0):
        yield f"trimesh: watertight {closed}, winding consistent {consistent}, volume {mesh.volume:.3g}"
    said = subprocess.run(["admesh", str(written)], capture_output=True, text=True, check=True).stdout
    for name in ("Degenerate facets", "Edges fixed", "Facets removed", "Facets added", "Facets reversed", "Backwards edges"):
        count = re.search(rf"{name}\s*:\s*(\d+)", said)
        if count is None or int(count[1]):
            yield f"admesh: {name} {'is not said' if count is None else count[1]}"
    open_facets = [int(number) for number in re.findall(r"with \d disconnected edge\S*\s*:\s*(\d+)", said)]
    if len(open_facets) != 3 or any(open_facets):
        yield f"admesh: facets with disconnected edges {open_facets}"
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(written))
    meshes.meshing_remove_duplicate_vertices()
    found = meshes.get_topological_measures()
    for name in ("boundary_edges", "non_two_manifold_edges", "non_two_manifold_vertices"):
        if found[name]:
            yield f"MeshLab: {name} {found[name]}"
    meshes.compute_selection_by_self_intersections_per_face()
    if count := meshes.current_mesh().selected_face_number():
        yield f"MeshLab: {count} faces cut others"


def main() -> int:
    """A line for each shape; exits with 1 where a file has a fault."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="texts, one of which is in the name of a shape")
    parser.add_argument("--keep", type=Path, help="a folder for the files")
    options = parser.parse_args()
    wanted = [name for name in SHAPES if any(text in name for text in options.only.split(","))]
    written = wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in wanted:
            place = options.keep or Path(folder)
            source, target = (place / f"{re.sub(r'[^a-z]+', '_', name.lower())}{end}" for end in (".ply", ".stl"))
            meshes = pymeshlab.MeshSet()
            meshes.add_mesh(pymeshlab.Mesh(*SHAPES[name]()))
            meshes.save_current_mesh(str(source))
            try:
                pymeshfair.run("prepare_for_print", source, target, overwrite=True)
            except pymeshfair.PymeshfairError as error:
                print(f"{name}: not written: {error}", flush=True)
                continue
            found = list(faults(target))
            written, wrong = written + 1, wrong + bool(found)
            print(f"{name}: written, {'; '.join(found) or 'nothing wrong'}", flush=True)
    print(f"{written} of {len(wanted)} written, {wrong} of them with faults")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
