"""The work for the page: the scan, read and measured once; each result packed for the browser, and then compared with the scan.

It is done in a process that stays, so that libraries, the scan and what earlier steps made of it are there when a
parameter changes.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..declaration.units import unit_of_scan
from ..errors import RunError
from ..filters.inspection import mean_curvature, symmetric_limits
from ..looking.comparison import compare
from ..looking.mesh_state import state_of
from ..looking.words import comparison_lines, distance_headers, distance_rows, measure_rows
from ..mesh_data import MeshData
from ..processes.worker import report
from ..report.scene import Shown, pack_scene, shown_mesh
from ..running.job import Event, Job, PhaseStarted
from ..running.measuring import measure
from ..running.read import ReadMesh, read_mesh
from ..running.session import Earlier, Session

#: the box of coordinates is so much larger than the scan, as results may grow
_ROOM = 1.5
#: the file in the folder of a run that asks it to stop
STOP = "stop"

#: the numbers of a result, and its mesh for the browser
Result: TypeAlias = tuple[dict[str, Any], bytes]


class Stopped(RunError):  # noqa: N818 - says what happened
    """The page asked for the run to stop."""


class Bench:
    """One scan, and what recipes make of it."""

    def __init__(self, scan: Path) -> None:
        """Read and measure the scan."""
        self._before = state_of(read_mesh(scan))
        self._unit = unit_of_scan(None, self._before.mesh.unit)
        vertices = self._before.mesh.vertices
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        self._box = 0.5 * (low + high), 0.5 * _ROOM * float((high - low).max()) or 1.0
        self._scan = self._shown("scan", self._before.mesh)
        self._result: tuple[MeshData, Shown] | None = None
        self._earlier = Earlier()

    def opening(self) -> Result:
        """The measures and the mesh that the page shows before a run."""
        return {"measures": measure_rows({"scan": self._before.measures}, self._unit)}, self._packed(self._scan)

    def run(self, job: Job, stage: Path) -> Result:
        """Carry out the steps of a job; the mesh, without the numbers of `measure`, which take longer than many filters."""
        session = Session(job, stage, _stoppable(stage))
        outcome = session.carry_out(self._before.mesh, earlier=self._earlier)
        self._result = outcome.result, self._shown("result", outcome.result)
        numbers = {
            "warnings": session.warnings,
            "step_seconds": [round(step.seconds, 3) for step in outcome.steps],
            "tried": [step.values.get("tried", []) for step in outcome.steps],
        }
        return numbers, self._packed(self._result[1])

    def measure(self, stage: Path) -> Result:
        """The numbers of the last result, and its mesh with distances as colours."""
        assert self._result is not None
        mesh, shown = self._result
        tell = _stoppable(stage)
        tell(PhaseStarted("comparing"))
        after = state_of(ReadMesh(stage / "result.ply", mesh, measure(mesh), ()))
        tell(PhaseStarted("comparing"))
        comparison, distances = compare(self._before, after)
        numbers = {
            "measures": measure_rows({"scan": self._before.measures, "result": after.measures}, self._unit),
            "distance": [list(distance_headers(self._unit)), *distance_rows(comparison)],
            "lines": comparison_lines(comparison, self._unit),
        }
        scalars = {**shown.scalars, "distance": distances.after.at_vertices[shown.kept]}
        return numbers, self._packed(replace(shown, scalars=scalars))

    def _shown(self, name: str, mesh: MeshData) -> Shown:
        first = self._before.mesh
        same = mesh is not first and len(mesh.vertices) == len(first.vertices) and np.array_equal(mesh.faces, first.faces)
        scalars = {"curvature": mean_curvature(mesh.vertices, mesh.faces)} if len(mesh.faces) else {}
        return shown_mesh(name, mesh, scalars=scalars, like=self._scan if same else None)

    def _packed(self, shown: Shown) -> bytes:
        limits = {key: symmetric_limits(np.asarray(values)) for key, values in shown.scalars.items()}
        return pack_scene([shown], limits, box=self._box, unit=self._unit).message


def _stoppable(stage: Path) -> Callable[[Event], None]:
    """Reports events, and stops the work at the next one after the page has asked for that by a file."""

    def tell(event: Event) -> None:
        if (stage / STOP).exists():
            raise Stopped("stopped")
        report(event)

    return tell


# ------------------------------------------------------------------------------------------------ tasks of a process that stays

#: the bench of a scan, which this process reads once after it was opened
_bench = cache(Bench)


def open_scan(scan: Path) -> Result:
    """What the page shows of a scan before a run; the scan is read anew."""
    _bench.cache_clear()
    return _bench(scan).opening()


def run_recipe(job: Job, stage: Path) -> Result:
    """Run a recipe on its scan."""
    return _bench(job.input).run(job, stage)


def measure_result(scan: Path, stage: Path) -> Result:
    """Measure the last result that was made of a scan."""
    return _bench(scan).measure(stage)
