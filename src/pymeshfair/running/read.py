"""Reads a mesh file as arrays in a process of its own, as a damaged file may crash MeshLab."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np

from ..declaration import Bools, Floats, Ints
from ..files.inputs import check_input
from ..files.staging import staging_folder
from ..recipe import Recipe
from ..scripts.script import Script
from .child import WorkerProcess
from .errors import WorkerDied
from .interrupts import Interrupts
from .job import Job
from .memory import default_memory
from .messages import Assignment
from .started import Start
from .watch import Watch

#: what is read of a mesh if it has it, besides vertices, faces and edges; a layer has attributes of the same names
OPTIONAL = ("vertex_normals", "vertex_scalars", "vertex_colors", "face_scalars", "face_colors")


@dataclass(frozen=True, eq=False)
class ReadMesh:
    """A mesh file as arrays: n vertices, m triangles, e edges of polylines.

    Attributes:
        path: the file.
        vertices: (n, 3) coordinates.
        faces: (m, 3) indices of vertices.
        edges: (e, 2) indices of vertices.
        vertex_normals: (n, 3), if the file has them.
        vertex_scalars: (n,), or None.
        vertex_colors: (n, 4) from 0 to 1, or None.
        face_scalars: (m,), or None.
        face_colors: (m, 4) from 0 to 1, or None.
        self_intersecting: (m,) which faces cut others; None if that was not asked for, or could not be told.
        attributes: what the mesh has, in the words of `pymeshfair.files.formats.ATTRIBUTES`.
        measures: `pymeshfair.filters.inspection.surface_measures.SurfaceMeasures` by name.
        warnings: what reading could not keep.
    """

    path: Path
    vertices: Floats
    faces: Ints
    edges: Ints
    vertex_normals: Floats | None
    vertex_scalars: Floats | None
    vertex_colors: Floats | None
    face_scalars: Floats | None
    face_colors: Floats | None
    self_intersecting: Bools | None
    attributes: tuple[str, ...]
    measures: dict[str, Any]
    warnings: tuple[str, ...]


def read_mesh(
    path: Path,
    *,
    self_intersections: bool = False,
    timeout: float | None = None,
    allow_outside: bool = False,
    unchecked: bool = False,
    start: Start | None = None,
) -> ReadMesh:
    """Read a mesh file.

    Args:
        path: the file.
        self_intersections: whether to find the faces that cut others, too. If MeshLab crashes over that, the mesh is read
            without, and a warning says so.
        timeout: seconds that it may take, or None.
        allow_outside: see `pymeshfair.running.job.Job`.
        unchecked: see there.
        start: what starts the process, or None for a fresh one.

    Raises:
        InputError: it cannot be read.
        WorkerDied: MeshLab crashed on it.
        RunTimeout: it took too long.
        KeyboardInterrupt: Ctrl-C.
    """
    path = Path(path).absolute()
    check_input(path)
    limits = {"allow_outside": allow_outside, "unchecked": unchecked}
    try:
        return _read(path, self_intersections, timeout, start, (), **limits)
    except WorkerDied:
        if not self_intersections:
            raise
    told = f"MeshLab crashed while it looked for self-intersections of {path.name}"
    return _read(path, False, timeout, start, (told,), **limits)


def _read(
    path: Path,
    self_intersections: bool,
    timeout: float | None,
    start: Start | None,
    warnings: tuple[str, ...],
    *,
    allow_outside: bool,
    unchecked: bool,
) -> ReadMesh:
    started = time.monotonic()
    queue: SimpleQueue[tuple[str, Any]] = SimpleQueue()
    job = Job(Recipe("reading", Script(())), path, path, timeout=timeout)
    with Interrupts(queue), staging_folder(Path(tempfile.gettempdir()) / "reading") as stage:
        arrays = stage / "arrays.npz"
        assignment = Assignment(
            (),
            path,
            stage,
            memory_limit=default_memory(),
            arrays=arrays,
            self_intersections=self_intersections,
            allow_outside=allow_outside,
            unchecked=unchecked,
        )
        with WorkerProcess(assignment.to_document(), queue, start=start) as worker:
            report = Watch(job, worker, queue, lambda event: None).until_done(started)
        return read_arrays(path, arrays, report, warnings)


def read_arrays(path: Path, arrays: Path, report: Mapping[str, Any], warnings: tuple[str, ...] = ()) -> ReadMesh:
    """The mesh of a file from what a session wrote of it.

    Args:
        path: the file that the session read.
        arrays: the .npz file that it wrote.
        report: what it reported.
        warnings: more, besides its own.
    """
    with np.load(arrays, allow_pickle=False) as found:
        read = {name: found[name] for name in found.files}
    return ReadMesh(
        path,
        read["vertices"],
        read["faces"],
        read["edges"],
        **{name: read.get(name) for name in OPTIONAL},
        self_intersecting=read.get("self_intersecting"),
        attributes=tuple(report["attributes"]),
        measures=report["before"],
        warnings=(*report["warnings"], *warnings),
    )
