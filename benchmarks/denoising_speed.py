"""How long denoising takes, and how much memory, each case in a process of its own: ``python benchmarks/denoising_speed.py``.

    python benchmarks/denoising_speed.py [FACES] [--pairs FOLDER] [--only WORDS]

Meshes of about FACES (1,000,000 by default): pymeshlab's bunny, subdivided by Loop's scheme, in the order in which this leaves
vertices, with noise of 0.15 mean edges a coordinate; and a chest of flat and round faces with noise of 0.3 mean edges. Both are
denoised automatically, the chest also with the fixed setting. With the folder of the pairs, also
NAME_noisy.ply for two of them: automatically, and by 20 passes and 10 steps of the bilateral filter, for which the code of its
authors takes 0.13 and 0.76 s on one thread. Times are those of the second call of the process, which compiles nothing; memory is
the largest resident set of the process, imports and mesh included. Ends with 1 if a bound is passed by the clock and by the
processor time, of all cores together, alike: on a busy machine the clock alone says too much.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

from denoising_findings import chest
from denoising_holdouts import read_mesh
from denoising_metrics import Floats, Ints
from diffusion import make_mesh
from peers.machine import peak

from pymeshfair.filters.denoising import FIXED, denoise_automatically, normal_filtering


class Case(NamedTuple):
    """What is done to "bunny", "chest" or a pair, and the most seconds and megabytes that it may take."""

    mesh: str
    run: Callable[[Floats, Ints], object]
    seconds: float
    megabytes: float = 1500.0


CASES = {
    "automatic, figure": Case("bunny", denoise_automatically, 40.0, 900.0),
    "automatic, machine part": Case("chest", denoise_automatically, 40.0, 900.0),
    "fixed, machine part": Case("chest", partial(normal_filtering, **vars(FIXED)), 60.0),
    "automatic, julius_n2": Case("julius_n2", denoise_automatically, 5.0),
    "bilateral, fandisk_n3": Case("fandisk_n3", normal_filtering, 0.13),
    "bilateral, julius_n2": Case("julius_n2", normal_filtering, 0.76),
}


def load(name: str, n_faces: int, folder: Path | None) -> tuple[Floats, Ints] | None:
    """The mesh of a case; None of a pair without the folder."""
    if name == "bunny":
        return make_mesh(n_faces // 2, "loop")
    if name == "chest":
        shape = chest(round((n_faces / 12) ** 0.5))
        return shape.noisy, shape.faces
    return None if folder is None else read_mesh(folder / f"{name}_noisy.ply")


def measure(name: str, vertices: Floats, faces: Ints) -> tuple[float, float, float]:
    """Seconds by the clock and of the processor, and megabytes, of a case in this process."""
    small, case = chest(8), CASES[name]
    denoise_automatically(small.noisy, small.faces)
    case.run(small.noisy, small.faces)
    if len(faces) < 200_000:
        case.run(vertices, faces)
    start, used = time.perf_counter(), time.process_time()
    case.run(vertices, faces)
    return time.perf_counter() - start, time.process_time() - used, peak()


def main() -> int:
    """Run each case in a process of its own, print the table, and return 1 if a bound is passed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("faces", type=int, nargs="?", default=1_000_000)
    parser.add_argument("--pairs", type=Path, help="the folder of NAME_noisy.ply")
    parser.add_argument("--only", default="", help="the cases whose names hold these words")
    options = parser.parse_args()
    passed = False
    print(f"{'':26} {'faces':>10} {'clock':>9} {'processor':>10} {'bound':>8} {'memory':>8}")
    for name, case in CASES.items():
        mesh = load(case.mesh, options.faces, options.pairs) if options.only in name else None
        if mesh is None:
            continue
        with get_context("spawn").Pool(1) as pool:
            clock, processor, megabytes = pool.apply(measure, (name, *mesh))
        too_much = min(clock, processor) > case.seconds or megabytes > case.megabytes
        passed |= too_much
        print(
            f"{name:26} {len(mesh[1]):10,} {clock:7.2f} s {processor:8.2f} s {case.seconds:6.2f} s {megabytes:5.0f} MB"
            f"{' PASSED' if too_much else ''}",
            flush=True,
        )
    return int(passed)


if __name__ == "__main__":
    sys.exit(main())
