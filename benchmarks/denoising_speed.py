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
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from denoising_findings import chest
from diffusion import make_mesh

from pymeshfair.filters.denoising import FIXED, AutomaticParameters
from pymeshfair.filters.denoising.automatic import denoise_automatically
from pymeshfair.filters.denoising.normal_filtering import normal_filtering

Mesh = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Case:
    """One denoising of one mesh.

    Attributes:
        name: what is done.
        mesh: "bunny", "chest", or the name of a pair.
        run: takes vertices and faces; returns what to say of the result.
        seconds: the most that it may take.
        megabytes: the most that the process may have.
    """

    name: str
    mesh: str
    run: Callable[[np.ndarray, np.ndarray], str]
    seconds: float
    megabytes: float = 1500.0


def automatically(vertices: np.ndarray, faces: np.ndarray) -> str:
    """Without parameters."""
    return denoise_automatically(vertices, faces)[1].kind


def with_parameters(parameters: AutomaticParameters) -> Callable[[np.ndarray, np.ndarray], str]:
    """Without a choice."""

    def run(vertices: np.ndarray, faces: np.ndarray) -> str:
        normal_filtering(vertices, faces, **vars(parameters))
        return ""

    return run


def bilaterally(vertices: np.ndarray, faces: np.ndarray) -> str:
    """Zheng's filter with the parameters of its authors' code."""
    normal_filtering(vertices, faces)
    return ""


LARGE = (
    Case("automatic, figure", "bunny", automatically, 40.0, 900.0),
    Case("automatic, machine part", "chest", automatically, 40.0, 900.0),
    Case("fixed, machine part", "chest", with_parameters(FIXED), 60.0),
)
PAIRS = (
    Case("automatic, julius_n2", "julius_n2", automatically, 5.0),
    Case("bilateral, fandisk_n3", "fandisk_n3", bilaterally, 0.13),
    Case("bilateral, julius_n2", "julius_n2", bilaterally, 0.76),
)


def load(name: str, n_faces: int, folder: Path | None) -> Mesh:
    """The mesh of a case."""
    if name == "bunny":
        return make_mesh(n_faces // 2, "loop")
    if name == "chest":
        shape = chest(round((n_faces / 12) ** 0.5))
        return shape.noisy, shape.faces
    import pymeshlab

    assert folder is not None
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(folder / f"{name}_noisy.ply"))
    mesh = meshes.current_mesh()
    return np.ascontiguousarray(mesh.vertex_matrix()), np.ascontiguousarray(mesh.face_matrix(), dtype=np.int32)


def measure(case: Case, path: str) -> dict[str, float | str]:
    """Time the case on the saved mesh, in this process."""
    with np.load(path) as saved:
        vertices, faces = saved["vertices"], saved["faces"]
    small = chest(8)
    for work in (automatically, case.run):
        work(small.noisy, small.faces)
    if len(faces) < 200_000:
        case.run(vertices, faces)
    start, used = time.perf_counter(), time.process_time()
    words = case.run(vertices, faces)
    took, used = time.perf_counter() - start, time.process_time() - used
    return {"words": words, "faces": len(faces), "seconds": took, "processor": used, "megabytes": peak_megabytes()}


def peak_megabytes() -> float:
    """The largest resident set of this process."""
    # The system's account of a process begins with what its parent had; Linux also tells of the process alone.
    status = Path("/proc/self/status")
    if status.exists():
        return float(next(line.split()[1] for line in status.read_text().splitlines() if line.startswith("VmHWM"))) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> int:
    """Run each case in a process of its own, print the table, and return 1 if a bound is passed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("faces", type=int, nargs="?", default=1_000_000)
    parser.add_argument("--pairs", type=Path, help="the folder of NAME_noisy.ply")
    parser.add_argument("--only", default="", help="the cases whose names hold these words")
    parser.add_argument("--measure", nargs=2, metavar=("CASE", "MESH"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        name, path = options.measure
        print(json.dumps(measure(next(case for case in (*LARGE, *PAIRS) if case.name == name), path)))
        return 0
    passed = False
    print(f"{'':26} {'faces':>10} {'clock':>9} {'processor':>10} {'bound':>8} {'memory':>8}")
    for case in (*LARGE, *(PAIRS if options.pairs else ())):
        if options.only not in case.name:
            continue
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "mesh.npz")
            vertices, faces = load(case.mesh, options.faces, options.pairs)
            np.savez(path, vertices=vertices, faces=faces)
            done = subprocess.run(
                [sys.executable, __file__, "--measure", case.name, path], check=True, capture_output=True, text=True
            )
        found = json.loads(done.stdout.splitlines()[-1])
        too_slow = min(found["seconds"], found["processor"]) > case.seconds
        too_large = found["megabytes"] > case.megabytes
        passed |= too_slow or too_large
        print(
            f"{case.name:26} {found['faces']:10,} {found['seconds']:7.2f} s {found['processor']:8.2f} s {case.seconds:6.2f} s "
            f"{found['megabytes']:5.0f} MB {found['words']}{' PASSED' if too_slow or too_large else ''}",
            flush=True,
        )
    return int(passed)


if __name__ == "__main__":
    sys.exit(main())
