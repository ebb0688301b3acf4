"""Measures a mesh file in a process of its own, as a damaged file may crash MeshLab."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from ..files.inputs import check_input
from ..files.staging import staging_folder
from ..recipe import Recipe
from ..scripts.script import Script
from .child import WorkerProcess
from .interrupts import Interrupts
from .job import Job
from .memory import default_memory
from .messages import Assignment
from .started import Start
from .watch import Watch


def inspect_mesh(
    path: Path,
    *,
    timeout: float | None = None,
    allow_outside: bool = False,
    unchecked: bool = False,
    traits: bool = False,
    start: Start | None = None,
) -> dict[str, Any]:
    """The measures of a mesh file by name, under ``"attributes"`` what it has, and under ``"warnings"`` what MeshLab loses of it.

    With `traits` there are three more: ``"box"``, its two corners; ``"rims"``, the largest first; and ``"traits"``, what recipes
    ask of a scan.

    Args:
        path: the file.
        timeout: seconds, or None.
        allow_outside: let it name files outside its own folder.
        unchecked: let MeshLab read formats that are not checked before.
        traits: look at the surface, too, which takes a moment: its rims, and traits such as noise.
        start: what starts the process; None starts a fresh one.

    Raises:
        InputError: it cannot be read.
        WorkerDied: MeshLab crashed on it.
        RunTimeout: it took too long.
        KeyboardInterrupt: Ctrl-C.
    """
    started = time.monotonic()
    path = Path(path).absolute()
    check_input(path)
    queue: SimpleQueue[tuple[str, Any]] = SimpleQueue()
    job = Job(Recipe("measures", Script(())), path, path, timeout=timeout)
    with Interrupts(queue), staging_folder(Path(tempfile.gettempdir()) / "measures") as stage:
        assignment = Assignment(
            (),
            path,
            stage,
            memory_limit=default_memory(),
            allow_outside=allow_outside,
            unchecked=unchecked,
            traits=traits,
        )
        with WorkerProcess(assignment.to_document(), queue, start=start) as worker:
            report = Watch(job, worker, queue, lambda event: None).until_done(started)
    return {**report["before"], "attributes": report["attributes"], "warnings": report["warnings"], **report["survey"]}
