"""Scans, killers and batches in processes of their own for the tests of a batch."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pymeshfair.files.provenance import provenance_path
from tests.commands.command_line import COMMAND
from tests.meshes import icosphere
from tests.running.runs import ply_bytes, xyz

#: what the name of a scan begins with on which a worker dies, where `KILLERS` is loaded
KINDS = ("segfault", "abort", "hang", "memory", "truncated")
#: a sitecustomize module: workers die on scans whose names say how, as MeshLab does on some files
KILLERS = """
import os, signal, time
import pymeshfair.files.inputs as inputs

def read(path, *arguments, read=inputs.read_file, **options):
    if path.name.startswith("segfault"):
        os.kill(os.getpid(), signal.SIGSEGV)
    if path.name.startswith("abort"):
        os.abort()
    if path.name.startswith("hang"):
        time.sleep(1e6)
    if path.name.startswith("memory"):
        taken = [bytearray(10**8) for _ in range(10**6)]
    return read(path, *arguments, **options)

inputs.read_file = read
"""
#: Laplacian smoothing by MeshLab, then a filter of ours
RECIPE = """<!DOCTYPE FilterScript>
<FilterScript>
<filter name="Laplacian Smooth"><Param type="RichInt" name="stepSmoothNum" value="{steps}"/></filter>
<filter name="Taubin Fairing"/>
</FilterScript>
"""


def write_scan(path: Path, seed: int, *, subdivisions: int = 2, noise: float = 0.01) -> Path:
    """A noisy sphere of 10 * 4^subdivisions + 2 vertices."""
    vertices, faces = icosphere(subdivisions)
    vertices = vertices + np.random.default_rng(seed).normal(scale=noise, size=vertices.shape)
    path.write_bytes(ply_bytes(xyz(vertices), faces.tolist()))
    return path


def write_scans(folder: Path, count: int, *, subdivisions: int = 2) -> Path:
    """A folder of `count` scans, ``scan000.ply`` and so on."""
    folder.mkdir()
    for number in range(count):
        write_scan(folder / f"scan{number:03}.ply", number, subdivisions=subdivisions)
    return folder


def write_killers(folder: Path, each: int = 1) -> None:
    """So many killers of each of `KINDS`."""
    for kind in KINDS:
        for number in range(each):
            path = write_scan(folder / f"{kind}{number}.ply", number)
            if kind == "truncated":
                path.write_bytes(path.read_bytes()[:-100])


def write_recipe(path: Path, *, steps: int = 3) -> Path:
    """The script of `RECIPE`."""
    path.write_text(RECIPE.format(steps=steps))
    return path


def with_module(folder: Path, program: str) -> dict[str, str]:
    """The environment in which every interpreter runs this program as it starts."""
    folder.mkdir(exist_ok=True)
    (folder / "sitecustomize.py").write_text(program)
    return {"PYTHONPATH": os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])}


def start_batch(
    *arguments: str | Path, environment: Mapping[str, str] | None = None, quiet: bool = False
) -> subprocess.Popen[str]:
    """``pymeshfair batch`` in a session of its own, as in the background of a terminal; `quiet` if nobody reads what it says."""
    heard = subprocess.DEVNULL if quiet else subprocess.PIPE
    return subprocess.Popen(
        [*COMMAND, "batch", *map(str, arguments)],
        stdout=heard,
        stderr=heard,
        encoding="utf-8",
        start_new_session=True,
        env={**os.environ, **(environment or {})},
    )


def run_batch(*arguments: str | Path, environment: Mapping[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """The same to its end."""
    process = start_batch(*arguments, environment=environment)
    out, err = process.communicate(timeout=300)
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def contents(folder: Path) -> dict[str, bytes]:
    """What the outputs of a batch hold, but for what is different each time: when, how long, and by which command."""
    found = {}
    for path in sorted(folder.iterdir()):
        if path.name.startswith("batch.") or path.name == "reports":
            continue
        found[path.name] = path.read_bytes()
        if path.name.endswith(".provenance.json"):
            found[path.name] = told_by(path)
    return found


def told_by(path: Path) -> bytes:
    """A provenance file without its times, its folder and its threads."""
    record = json.loads(path.read_bytes())
    for name in ("run", "threads"):
        del record[name]
    del record["output"]["path"]
    return json.dumps(record).encode()


def results_of_run(recipe: Path, scans: Path, folder: Path, only: Sequence[str] = ()) -> dict[str, bytes]:
    """What ``run`` makes of the scans in a folder, all or some, in the form of `contents`."""
    from pymeshfair.recipe import load_recipe
    from pymeshfair.running.job import Job
    from pymeshfair.running.supervise import run_job

    folder.mkdir()
    for scan in (scans / name for name in only or sorted(p.name for p in scans.iterdir())):
        run_job(Job(load_recipe(recipe), scan, folder / scan.name))
        assert provenance_path(folder / scan.name).exists()
    return contents(folder)


def journal_of(folder: Path) -> list[dict[str, Any]]:
    """The whole lines of a journal."""
    path = folder / "batch.jsonl"
    lines = path.read_bytes().split(b"\n")[:-1] if path.exists() else []
    return [json.loads(line) for line in lines if line.startswith(b"{") and line.endswith(b"}")]


def dask(*arguments: str, environment: Mapping[str, str] | None = None, prefix: tuple[str, ...] = ()) -> subprocess.Popen[bytes]:
    """A process of dask's own command."""
    return subprocess.Popen(
        [*prefix, sys.executable, "-m", "dask", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env={**os.environ, **(environment or {})},
    )
