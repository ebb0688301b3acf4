"""Whether an upgraded script does what the old one meant: the grades of `pymeshfair upgrade`, measured in plain pymeshlab.

    python benchmarks/upgraded_meaning.py [FOLDER]

Every old name of a filter makes a script, which is upgraded and run by plain pymeshlab on three meshes; today's filter of that
meaning is called there, too, with the values that the old one had. A script in FOLDER is run as it is and upgraded. A grade "same
meaning" holds if all layers agree to the bit (vertices, faces, edges, normals, colours, scalars, selections), or if both fail.
Prints a line a script, and how many grades hold.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pymeshlab

from pymeshfair.declaration import Bool, Enum, Float, Int, Percentage
from pymeshfair.meshlab.facts import Former, former_filters, table
from pymeshfair.registry import find_filter
from pymeshfair.scripts import ScriptError, Upgrade, format_script
from pymeshfair.scripts.upgrade import upgrade_script

#: by name, MeshLab's filter that makes the mesh: a closed one, one with a handle, and an open one
MESHES = {"sphere.ply": "create_sphere", "torus.ply": "create_torus", "grid.ply": "create_grid"}
#: Carries out orders, each in a copy of the process: filters may end it, or never end. Prints a line each, empty for a failure.
PROGRAM = """
import hashlib, json, os, signal, sys, pymeshlab
ARRAYS = ("vertex_matrix", "face_matrix", "edge_matrix", "vertex_normal_matrix", "vertex_selection_array", "face_selection_array",
          "vertex_color_matrix", "vertex_scalar_array", "face_color_matrix", "face_scalar_array")
def left(order):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(order["mesh"])
    if "script" in order:
        meshes.load_filter_script(order["script"])
        meshes.save_filter_script(f"read{os.getpid()}.mlx")
        assert open(f"read{os.getpid()}.mlx").read().count("<filter ") == order["steps"]  # else MeshLab has left one out
        meshes.apply_filter_script()
    else:
        lengths = {name: pymeshlab.PureValue(value) for name, value in order["lengths"].items()}
        meshes.apply_filter(order["filter"], **order["values"], **lengths)
    digest = hashlib.sha256()
    for mesh in meshes:
        for name in ARRAYS:
            try:
                digest.update(name.encode() + getattr(mesh, name)().tobytes())
            except Exception:
                pass
    return f"{digest.hexdigest()} {meshes.mesh_number()} {meshes.current_mesh_id()}"
for line in sys.stdin:
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1), os.dup2(nowhere, 2)
        signal.setitimer(signal.ITIMER_VIRTUAL, 3.0)
        signal.alarm(60)
        try:
            os.write(write, left(json.loads(line)).encode())
        finally:
            os._exit(0)
    os.close(write)
    with os.fdopen(read) as pipe:
        told = pipe.read()
    status = os.waitpid(child, 0)[1]
    print("cut off" if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGALRM else told, flush=True)
"""


@dataclass(frozen=True)
class Case:
    """A script and what plain pymeshlab is to do for its old and for its new meaning, without the mesh.

    Attributes:
        name: the old filter, or the file.
        same_meaning: the grade of the upgrade.
        old: the order for the old meaning.
        new: the order for the upgraded script.
    """

    name: str
    same_meaning: bool
    old: Mapping[str, Any]
    new: Mapping[str, Any]


def renamed(folder: Path) -> list[Case]:
    """One case for each old name of a filter that MeshLab has today and chance does not decide."""
    there = ((old, former) for old, former in former_filters().items() if former.now is not None)
    return [
        _renamed(old, former, folder)
        for old, former in there
        if find_filter(former.now or "").python_name not in table("unrepeatable")["apart"]
    ]


def _renamed(old: str, former: Former, folder: Path) -> Case:
    known = find_filter(former.now or "")
    values: dict[str, Any] = {}
    lengths: dict[str, float] = {}
    for parameter in known.parameters:
        text = former.sets.get(parameter.xml_name)
        if text is not None and isinstance(parameter, Percentage):
            lengths[parameter.name] = float(text)
        elif text is not None:
            kind = int if isinstance(parameter, Int | Enum) else float if isinstance(parameter, Float) else str
            values[parameter.name] = text == "true" if isinstance(parameter, Bool) else kind(text)
    quoted = old.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    data = f'<!DOCTYPE FilterScript>\n<FilterScript><filter name="{quoted}"/></FilterScript>\n'.encode()
    return _case(old, upgrade_script(data, old), {"filter": known.python_name, "values": values, "lengths": lengths}, folder)


def real(scripts: Path, folder: Path) -> list[Case]:
    """One case for each script that can be upgraded."""
    cases = []
    for path in sorted(scripts.glob("*.mlx")):
        try:
            upgraded = upgrade_script(path.read_bytes(), str(path), path=path)
        except ScriptError:
            continue
        steps = len(upgraded.script.steps)
        if not any(step.filter.python_name in table("unrepeatable")["apart"] for step in upgraded.script.steps):
            cases.append(_case(path.name, upgraded, {"script": str(path), "steps": steps}, folder))
    return cases


def _case(name: str, upgraded: Upgrade, old: Mapping[str, Any], folder: Path) -> Case:
    path = folder / f"{len(list(folder.iterdir()))}.mlx"
    path.write_text(format_script(upgraded.script, known_mesh=False), "utf-8")
    return Case(name, not upgraded.warnings, old, {"script": str(path), "steps": len(upgraded.script.steps)})


def measured(cases: Sequence[Case]) -> list[list[tuple[str, str]]]:
    """By case and mesh, what the old meaning and the new script left; empty where plain pymeshlab fails."""
    with tempfile.TemporaryDirectory() as folder:
        for mesh, maker in MESHES.items():
            made = pymeshlab.MeshSet()
            made.apply_filter(maker)
            made.compute_selection_by_condition_per_face(condselect="x0 > 0.5")
            made.compute_scalar_by_function_per_vertex(q="x + y * z")
            made.compute_color_from_scalar_per_vertex()
            made.save_current_mesh(f"{folder}/{mesh}")
        orders = [{**order, "mesh": f"{folder}/{mesh}"} for case in cases for mesh in MESHES for order in (case.old, case.new)]
        lines = "".join(f"{json.dumps(order)}\n" for order in orders)
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM], input=lines, cwd=folder, capture_output=True, text=True, check=True
        )
    left = iter(done.stdout.splitlines())
    return [[(next(left), next(left)) for _ in MESHES] for _ in cases]


def verdict(results: Sequence[tuple[str, str]]) -> str:
    """What holds on all meshes on which neither was cut off after a minute by the clock, as a busy machine may do."""
    compared = [(old, new) for old, new in results if old and "cut off" not in (old, new)]
    if not compared:
        return "the old one cannot be run"
    return "agrees" if all(old == new for old, new in compared) else "differs"


def main() -> int:
    """Measure them all; the exit status is 1 if a grade is false."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?")
    scripts = parser.parse_args().folder
    count: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        cases = renamed(Path(name)) + ([] if scripts is None else real(scripts, Path(name)))
        for case, results in zip(cases, measured(cases), strict=True):
            words = f"{'same' if case.same_meaning else 'another'} meaning, {verdict(results)}"
            count[words] += 1
            print(f"{case.name[:60]:<60}  {words}")
    print("; ".join(f"{n} {words}" for words, n in sorted(count.items())))
    return int(count["same meaning, differs"] > 0)


if __name__ == "__main__":
    sys.exit(main())
