"""The work for the page: the scan, read and measured once, and each result compared with it and packed for the browser.

It is done in a process that stays, so that libraries and the scan are there when a parameter changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..declaration import Floats
from ..filters.inspection import mean_curvature, symmetric_limits
from ..looking.comparison import compare
from ..looking.mesh_state import MeshState, state_of
from ..looking.words import DISTANCE_HEADERS, comparison_lines, distance_rows, measure_rows
from ..processes.worker import report
from ..report.display import shown_mesh
from ..report.scene import Scene, pack_scene
from ..running.job import Job, PhaseStarted
from ..running.measuring import Measuring
from ..running.read import ReadMesh, read_mesh
from ..running.session import Session

#: the box of coordinates is so much larger than the scan, as results may grow
_ROOM = 1.5


#: the numbers of a result, and its mesh for the browser
Result: TypeAlias = tuple[dict[str, Any], bytes]


class Bench:
    """One scan, and what recipes make of it.

    Args:
        scan: the file to run recipes on.
    """

    def __init__(self, scan: Path) -> None:
        """Read and measure the scan."""
        self._before = state_of(read_mesh(scan))
        vertices = self._before.mesh.vertices
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        self._box = 0.5 * (low + high), 0.5 * _ROOM * float((high - low).max()) or 1.0

    def opening(self) -> Result:
        """What the page shows before anything ran."""
        return {"measures": measure_rows({"scan": self._before.measures})}, self._packed("scan", self._before, {}).message

    def run(self, job: Job, stage: Path) -> Result:
        """Carry out the steps of a job, compare and pack."""
        session = Session(job, stage, report)
        outcome = session.carry_out(self._before.mesh)
        report(PhaseStarted("comparing"))
        result = Measuring(wanted=True).look(outcome.result)
        after = state_of(ReadMesh(job.input, outcome.result, result, ()))
        found, distances = compare(self._before, after)
        numbers = {
            "measures": measure_rows({"scan": self._before.measures, "result": after.measures}),
            "distance": [list(DISTANCE_HEADERS), *distance_rows(found)],
            "lines": comparison_lines(found),
            "warnings": session.warnings,
            "step_seconds": [round(step.seconds, 3) for step in outcome.steps],
        }
        return numbers, self._packed("result", after, {"distance": distances.after.at_vertices}).message

    def _packed(self, name: str, state: MeshState, scalars: Mapping[str, Floats]) -> Scene:
        mesh = state.mesh
        numbers = dict(scalars)
        if len(mesh.faces):
            numbers["curvature"] = mean_curvature(mesh.vertices, mesh.faces)
        limits = {key: symmetric_limits(np.asarray(values)) for key, values in numbers.items()}
        shown = shown_mesh(
            name, mesh.vertices, mesh.faces, mesh.edges, normals=mesh.vertex_attributes.get("normals"), scalars=numbers
        )
        return pack_scene([shown], limits, box=self._box)


# ------------------------------------------------------------------------------------------------ tasks of a process that stays

_BENCHES: dict[Path, Bench] = {}


def open_scan(scan: Path) -> Result:
    """Read the scan of this process; what the page shows of it."""
    _BENCHES[scan] = Bench(scan)
    return _BENCHES[scan].opening()


def run_recipe(job: Job, stage: Path) -> Result:
    """Run a recipe on the scan of this process, which is read if need be."""
    if job.input not in _BENCHES:
        open_scan(job.input)
    return _BENCHES[job.input].run(job, stage)
