"""Whether the first recipe that `pymeshfair suggest` names is the best, on made scans whose truth is known.

    python benchmarks/suggestions.py [--set first|second|third|NUMBER] [--kinds text,text] [--sizes 1.0,0.7,1.4]

Ten kinds of scans, each in three versions: other noise by the factor of a size, other random numbers. The sets with names are in
`suggestion_scans.py`, and the ranking was made with them in view; a number draws a set, see `drawn_scans.py`. Shapes of all but
the first are stretched by the size along z too. The measure is the root mean square distance of the result's vertices from the
true surface, in mean edges of the truth, 0.01 at least, so that nothing done on an exact scan is as good as next to nothing.
Every recipe that fits and is there to clean, denoise or smooth is run; doing nothing counts too, as does the first recipe
whatever its task. The first is right if it is the best or within 5 %.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pymeshlab
from denoising_metrics import Floats, Ints
from drawn_scans import drawn
from suggestion_scans import SETS, Kinds, Mesh

import pymeshfair
from pymeshfair.filters.geometry import mean_edge_length

TASKS = ("clean", "denoise", "smooth")
LEAST, TOLERANCE = 0.01, 0.05


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


def judged(chosen: str, kinds: Kinds, kind: str, size: float, folder: Path) -> tuple[str, dict[str, float]]:
    """The first recipe for a made scan of the chosen set, and the measure of every one that was run."""
    make, noise, level = kinds[kind]
    truth, number = make(), [list(kinds).index(kind), int(100 * size)]
    if chosen != "first":
        place = 1 + list(SETS).index(chosen) if chosen in SETS else int(chosen)
        truth, number = (truth[0] * [1.0, 1.0, size], truth[1]), [*number, place]
    points = noise(level * size)(*truth, np.random.default_rng(number))
    scan = saved(folder / "scan.ply", points, truth[1] if len(points) == len(truth[0]) else np.empty((0, 3), np.int32))
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
    parser.add_argument("--set", default="first", help=f"{', '.join(SETS)}, or a number, from which a set is drawn")
    parser.add_argument("--kinds", default="", help="texts, one of which is in the name of a kind")
    parser.add_argument("--sizes", default="1.0,0.7,1.4", help="factors of the noise")
    options = parser.parse_args()
    kinds = SETS[options.set] if options.set in SETS else drawn(int(options.set))
    wanted = [kind for kind in kinds if any(text in kind for text in options.kinds.split(","))]
    wrong = 0
    for size in map(float, options.sizes.split(",")):
        for kind in wanted:
            with tempfile.TemporaryDirectory() as folder:
                first, found = judged(options.set, kinds, kind, size, Path(folder))
            best = min(found, key=lambda name: found[name])
            right = found.get(first, np.inf) <= (1.0 + TOLERANCE) * found[best]
            wrong += not right
            told = ", ".join(f"{name} {value:.3f}" for name, value in sorted(found.items(), key=lambda item: item[1]))
            print(f"{'right' if right else 'WRONG'}  {kind} x {size:g}: {first} first; {told}", flush=True)
    print(f"{wrong} of {len(wanted) * len(options.sizes.split(','))} first recipes are not the best or within {TOLERANCE:.0%}")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
