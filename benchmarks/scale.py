"""Clouds and meshes by tiles: ``python benchmarks/scale.py WHAT [--points N ...] [--memory 1GB] [--folder FOLDER]``.

* clouds: LoOP with deletion on a bumpy sphere with noise and 1 % of stray points, by ``pymeshfair run --tiles``: processor time,
  and ten times a second the memory of all its processes together and the bytes on the disk.
* whole: the same cloud in one piece by the library, compared with the output of `clouds` in --folder, bit by bit.
* meshes: a bumpy square of N vertices by Taubin Fairing, by tiles.
* model: bytes that a tile takes for each of its points, in processes of their own: what `pymeshfair.tiles.plan` rests on.

Exits with 1 if more memory was taken than given, or the bits differ.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pymeshfair.commands.options import memory_limit
from pymeshfair.files.provenance import provenance_path
from pymeshfair.tiles.sources import PlyFile

NEIGHBORS, EXTENT, THRESHOLD = 20, 3.0, 0.5
LOOP = f"""<!DOCTYPE FilterScript>
<FilterScript>
<filter name="Select Outliers by Probability (LoOP)">
<Param type="RichInt" name="neighbors" value="{NEIGHBORS}"/>
<Param type="RichFloat" name="extent" value="{EXTENT}"/>
<Param type="RichDynamicFloat" name="threshold" value="{THRESHOLD}" min="0" max="1"/>
</filter>
<filter name="Delete Selected Vertices"/>
</FilterScript>
"""
TAUBIN = '<!DOCTYPE FilterScript>\n<FilterScript><filter name="Taubin Fairing"/></FilterScript>\n'
#: points that are made at a time
SLICE = 1 << 20


def write_cloud(path: Path, count: int) -> None:
    """A bumpy sphere in single precision, with noise, and one point of a hundred anywhere around it."""
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {count}", *(f"property float {c}" for c in "xyz")]
    with path.open("wb") as file:
        file.write("\n".join([*lines, "end_header", ""]).encode())
        for first in range(0, count, SLICE):
            random, size = np.random.default_rng([7, first]), min(SLICE, count - first)
            points = random.normal(size=(size, 3))
            points /= np.linalg.norm(points, axis=1, keepdims=True)
            points *= 1 + 0.05 * np.sin(9 * points[:, :1])
            points += random.normal(scale=1e-4, size=points.shape)
            stray = random.random(size) < 0.01
            points[stray] = random.uniform(-1.3, 1.3, (int(stray.sum()), 3))
            file.write(points.astype("<f4").tobytes())


def write_mesh(path: Path, count: int) -> int:
    """A bumpy square of about so many vertices, with noise; how many there are."""
    n: int = round(count**0.5)
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {n * n}", *(f"property float {c}" for c in "xyz")]
    lines += [f"element face {2 * (n - 1) ** 2}", "property list uchar int vertex_indices", "end_header", ""]
    random = np.random.default_rng(7)
    with path.open("wb") as file:
        file.write("\n".join(lines).encode())
        for row in range(n):
            heights = 20 * np.sin(row / 60) * np.cos(np.arange(n) / 70) + random.normal(scale=0.2, size=n)
            file.write(np.stack([np.full(n, row), np.arange(n), heights], axis=1).astype("<f4").tobytes())
        for row in range(n - 1):
            a = np.arange(n - 1) + row * n
            faces = np.empty(2 * (n - 1), [("count", "u1"), ("corners", "<i4", 3)])
            faces["count"] = 3
            faces["corners"] = np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)])
            file.write(faces.tobytes())
    return n * n


def processes_of(parent: int) -> dict[int, int]:
    """The bytes in memory of a process and of all that it has started."""
    parents: dict[int, int] = {}
    held: dict[int, int] = {}
    for path in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError, IndexError):
            parents[int(path.name)] = int((path / "stat").read_text().rpartition(")")[2].split()[1])
            held[int(path.name)] = int((path / "statm").read_text().split()[1]) * resource.getpagesize()
    found, waiting = {}, [parent]
    while waiting:
        process = waiting.pop()
        found[process] = held.get(process, 0)
        waiting += [child for child, of in parents.items() if of == process]
    return found


def bytes_in(folder: Path, pattern: str) -> int:
    """The bytes on the disk of what a run keeps in a folder."""
    total: int = 0
    for path in folder.glob(pattern):
        with contextlib.suppress(OSError):  # files, and at the end the folder, go meanwhile
            for file in path.rglob("*"):
                with contextlib.suppress(OSError):
                    total += file.stat().st_blocks * 512
    return total


def measured(recipe: str, scan: Path, output: Path, memory: str) -> bool:
    """Run by tiles, and say what it took; whether it kept to its memory."""
    script = output.with_suffix(".mlx")
    script.write_text(recipe)
    command = [
        sys.executable,
        "-m",
        "pymeshfair",
        "run",
        script,
        scan,
        "-o",
        output,
        "--tiles",
        "--memory",
        memory,
        "--overwrite",
    ]
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL)
    most = disk = 0
    while process.poll() is None:
        most = max(most, sum(processes_of(process.pid).values()))
        disk = max(disk, bytes_in(output.parent, ".pymeshfair-*"))
        time.sleep(0.1)
    if process.returncode:
        raise SystemExit(f"the run has failed with {process.returncode}")
    after, record = resource.getrusage(resource.RUSAGE_CHILDREN), json.loads(provenance_path(output).read_bytes())
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    count = record["measures"]["before"]["vertices"]
    print(
        f"{count:>12,} in {record['tiles']['stages'][0]['tiles']:>4} tiles: {seconds:8.1f} s of processor time "
        f"({1e6 * seconds / count:.2f} us each), {time.monotonic() - began:8.1f} s, memory {most / 1e6:7.0f} MB at one moment "
        f"(told {record['run']['peak_memory_bytes'] / 1e6:.0f}), disk {disk / 1e6:8.0f} MB ({disk / count:.0f} bytes each)",
        flush=True,
    )
    return bool(most <= (memory_limit(memory) or 0))


def clouds(folder: Path, points: list[int], memory: str) -> bool:
    """See the module."""
    good = True
    for count in points:
        scan = folder / f"cloud-{count}.ply"
        if not scan.exists():
            write_cloud(scan, count)
        good &= measured(LOOP, scan, folder / f"clean-{count}.ply", memory)
    return good


def meshes(folder: Path, points: list[int], memory: str) -> bool:
    """See the module."""
    good = True
    for count in points:
        scan = folder / f"mesh-{count}.ply"
        write_mesh(scan, count)
        good &= measured(TAUBIN, scan, folder / f"smooth-{count}.ply", memory)
    return good


def whole(folder: Path, points: list[int], memory: str) -> bool:
    """See the module."""
    from pymeshfair.filters.outliers import local_outlier_probability

    good = True
    for count in points:
        source, output = (PlyFile(folder / f"{name}-{count}.ply") for name in ("cloud", "clean"))
        started = time.process_time()
        places: NDArray[np.float64] = np.empty((count, 3))
        for number, part in enumerate(source.points(SLICE)):
            places[number * SLICE : number * SLICE + len(part)] = part
        probabilities = local_outlier_probability(places, neighbors=NEIGHBORS, extent=EXTENT)
        seconds = time.process_time() - started
        kept = np.flatnonzero(probabilities <= THRESHOLD)
        same, first = len(kept) == len(output), 0
        for rows in output.vertices.slices(SLICE):
            here = kept[first : first + len(rows)]
            first += len(rows)
            same &= np.array_equal(rows["quality"], probabilities[here])
            same &= np.array_equal(np.stack([rows[c] for c in "xyz"], axis=1), places[here].astype("<f4"))
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
        print(
            f"{count:>12,} in one piece by the library: {seconds:.1f} s of processor time, {peak:,.0f} MB; "
            f"{count - len(kept):,} removed, {'the same bits' if same else 'OTHER BITS'}"
        )
        good &= bool(same)
    return good


#: one run by tiles of a given size, in a process of its own; prints the sum of the peaks of its processes
PROGRAM = """
import sys
from pathlib import Path
from pymeshfair.recipe import load_recipe
from pymeshfair.running.job import Job
from pymeshfair.tiles.course import run_by_tiles
if __name__ == "__main__":
    recipe, scan, output, tile = sys.argv[1:]
    job = Job(load_recipe(recipe), Path(scan), Path(output), memory_limit=500_000_000, overwrite=True)
    print(run_by_tiles(job, most=int(tile)).peak_memory)
"""


def model(folder: Path, points: list[int], memory: str) -> bool:
    """See the module."""
    program, script = folder / "one.py", folder / "one.mlx"
    program.write_text(PROGRAM)
    for kind, recipe in (("cloud", LOOP), ("mesh", TAUBIN)):
        script.write_text(recipe)
        for count in points:
            scan = folder / f"model-{kind}-{count}.ply"
            if kind == "cloud":
                write_cloud(scan, count)
            else:
                write_mesh(scan, count)
            peaks = []
            for tile in (count // 16, count // 4):
                command = [sys.executable, program, script, scan, folder / "model-out.ply", tile]
                done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True)
                peaks.append(int(done.stdout))
            each = (peaks[1] - peaks[0]) / (count // 4 - count // 16)
            besides = peaks[0] - each * (count // 16)
            print(f"{kind}: {each:.0f} bytes for each of {count // 16:,} to {count // 4:,}, {besides / 1e6:.0f} MB besides")
    return True


def main() -> int:
    """Measure; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=["clouds", "whole", "meshes", "model"])
    parser.add_argument("--points", type=float, nargs="+", default=[1e6])
    parser.add_argument("--memory", default="1GB")
    parser.add_argument("--folder", type=Path)
    options = parser.parse_args()
    measure = {"clouds": clouds, "whole": whole, "meshes": meshes, "model": model}[options.what]
    points = [int(count) for count in options.points]
    if options.folder is not None:
        options.folder.mkdir(exist_ok=True)
        return int(not measure(options.folder, points, options.memory))
    with tempfile.TemporaryDirectory() as folder:
        return int(not measure(Path(folder), points, options.memory))


if __name__ == "__main__":
    sys.exit(main())
