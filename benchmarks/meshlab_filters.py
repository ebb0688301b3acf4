"""Every filter of MeshLab's with its defaults on real meshes: behind the door of a run, and in plain pymeshlab.

``python benchmarks/meshlab_filters.py [MESH ...]`` prints a line for each filter whose outcome differs, and a summary.
A filter runs in two processes of its own, since some end the process. What differs between two runs of plain pymeshlab
is not compared.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab

from pymeshfair.declaration import Filter
from pymeshfair.files.inputs import read_file
from pymeshfair.meshlab.facts import meshlab_filters
from pymeshfair.running.document import Document
from pymeshfair.scripts.script import Step

SAMPLES = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"
PATIENCE = 60.0


def in_plain(path: Path, known: Filter, folder: Path) -> dict[str, Any]:
    """What plain pymeshlab makes of a mesh."""
    from pymeshfair.meshlab.builtin_filters import constant_defaults

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    values = {n: v for n, v in constant_defaults(known).items() if isinstance(v, bool | int | float | str)}
    told = meshes.apply_filter(known.python_name, **values)
    mesh = meshes.current_mesh()
    found = {"vertices": mesh.vertex_matrix(), "faces": mesh.face_matrix(), "edges": mesh.edge_matrix()}
    found |= {"vertex selection": mesh.vertex_selection_array(), "face selection": mesh.face_selection_array()}
    if mesh.has_vertex_color():
        found["vertex colours"] = np.rint(255 * mesh.vertex_color_matrix())
    if mesh.has_vertex_scalar():
        found["vertex scalars"] = mesh.vertex_scalar_array()
    if mesh.face_number() and mesh.has_face_color():
        found["face colours"] = np.rint(255 * mesh.face_color_matrix())
    if mesh.face_number() and mesh.has_face_scalar():
        found["face scalars"] = mesh.face_scalar_array()
    if mesh.face_number() and mesh.has_wedge_tex_coord():
        found["wedge texture coordinates"] = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2)
    return {"arrays": found, "layers": [(m.id(), m.label()) for m in meshes], "values": sorted(told)}


def in_a_run(path: Path, known: Filter, folder: Path) -> dict[str, Any]:
    """What the same filter makes of it in a run."""
    document = Document(folder)
    document.add(read_file(path).mesh)
    told = document.apply(Step(known, {}, 0))[1]
    mesh = document.current
    found = {"vertices": mesh.vertices, "faces": mesh.faces, "edges": mesh.edges}
    found |= {"vertex selection": mesh.vertex_selection, "face selection": mesh.face_selection}
    for name, key in (("colors", "colours"), ("scalars", "scalars")):
        for element, attributes in (("vertex", mesh.vertex_attributes), ("face", mesh.face_attributes)):
            if name in attributes:
                found[f"{element} {key}"] = attributes[name].astype(np.float64)
    if (wedges := mesh.face_attributes.get("wedge_texture_coordinates")) is not None:
        found["wedge texture coordinates"] = wedges
    layers = [(number, document.mesh(number).label) for number in document.ids]
    return {"arrays": found, "layers": layers, "values": sorted(told)}


def outcome(work: Callable[[Path, Filter, Path], dict[str, Any]], path: Path, known: Filter) -> Mapping[str, Any] | str:
    """What a process of its own comes to, or how it ended."""
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "result"
        pid = os.fork()
        if pid == 0:
            nothing = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nothing, 1)
            os.dup2(nothing, 2)
            try:
                found: Any = work(path, known, Path(folder) / "door")
            except Exception as error:
                found = f"refuses: {type(error).__name__}"
            result.write_bytes(pickle.dumps(found))
            os._exit(0)
        limit = time.monotonic() + PATIENCE
        while not os.waitpid(pid, os.WNOHANG)[0]:
            if time.monotonic() > limit:
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)
                return "takes too long"
            time.sleep(0.005)
        return pickle.loads(result.read_bytes()) if result.exists() else "ends the process"


def differences(one: Any, other: Any) -> list[str]:
    """What differs between two outcomes."""
    if isinstance(one, str) or isinstance(other, str):
        return (
            []
            if one == other
            else [f"{one if isinstance(one, str) else 'works'} / {other if isinstance(other, str) else 'works'}"]
        )
    found = [name for name in ("layers", "values") if one[name] != other[name]]
    names = one["arrays"].keys() | other["arrays"].keys()
    return found + [n for n in sorted(names) if not _same(one["arrays"].get(n), other["arrays"].get(n))]


def _same(one: Any, other: Any) -> bool:
    if one is None or other is None:
        return one is other
    return one.shape == other.shape and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


def main() -> None:
    """Compares every filter on every mesh."""
    paths = [Path(a) for a in sys.argv[1:]] or [SAMPLES / "bone.ply", SAMPLES / "bunny10k_textured.obj"]
    for path in paths:
        counts: Counter[str] = Counter()
        for known in meshlab_filters():
            plain = outcome(in_plain, path, known)
            ours = outcome(in_a_run, path, known)
            apart = differences(plain, ours)
            if apart and (chance := differences(plain, outcome(in_plain, path, known))):
                counts["another result each time"] += 1
                apart = [name for name in apart if name not in chance]
            if apart:
                print(f"{path.name}: {known.python_name}: {', '.join(apart)}")
            counts["differs" if apart else plain if isinstance(plain, str) else "same"] += 1
        print(path.name, dict(counts))


if __name__ == "__main__":
    main()
