"""The scan that is tuned on: the part of a large one, what recipes make of it, and what the page shows of both.

A `Bench` is in a process that stays, so that libraries, the scan and what earlier steps made of it are there when a parameter
changes.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..declaration.parameters import unit_of_scan
from ..errors import RunError
from ..filters.inspection import mean_curvature, symmetric_limits
from ..looking.coloring import same_elements
from ..looking.comparison import compare, state_of
from ..looking.words import comparison_lines, distance_table, measure_rows
from ..mesh_data import MeshData
from ..processes.worker import report
from ..recipe import Recipe
from ..registry import find_filter
from ..report.scene import Shown, pack_scene, shown_mesh
from ..running.job import Event, Job, PhaseStarted
from ..running.measuring import measure
from ..running.read import ReadMesh, read_mesh
from ..running.session import Earlier, Session
from ..running.supervise import run_job
from ..scripts.script import Script, Step

#: vertices of the largest scan that is taken whole at first, and of the part of a larger one
MOST_VERTICES, PART = 200_000, 50_000
#: the box of coordinates is so much larger than the scan, as results may grow
_ROOM = 1.5
#: the file in the folder of a run that asks it to stop
STOP = "stop"

#: the numbers of a result, and its mesh for the browser
Result: TypeAlias = tuple[dict[str, Any], bytes]


@dataclass(frozen=True)
class Scan:
    """A scan to tune on."""

    path: Path
    vertices: int  # how many it has
    diagonal: float  # of its bounding box, in mesh units
    mean_edge: float  # in mesh units
    part: Path | None  # a file with a part of it; None if it is small enough to be taken whole
    warnings: tuple[str, ...]  # contents that reading could not keep


def prepared_scan(path: Path, folder: Path, *, most: int = MOST_VERTICES, part: int = PART) -> Scan:
    """Read a scan; of over `most` vertices a part of about `part` in the middle of the first view, written to the folder."""
    read = read_mesh(path)
    vertices = read.mesh.vertices
    cut = None
    if len(vertices) > most:
        cut = folder / "part.ply"
        # Of what is in the middle of the first view the foremost, so that the part is seen from outside.
        aside = np.linalg.norm(vertices[:, :2] - np.median(vertices[:, :2], axis=0), axis=1)
        central = np.flatnonzero(aside <= max(float(aside.min()), 0.01 * read.measured.diagonal))
        x, y, z = vertices[central[vertices[central, 2].argmax()]].tolist()
        cut_out(path, cut, (x, y, z), vertices=part)
    return Scan(path, len(vertices), read.measured.diagonal, read.measured.resolution(), cut, read.warnings)


def cut_out(
    path: Path, target: Path, centre: tuple[float, float, float], radius: float | None = None, *, vertices: int = PART
) -> None:
    """Write what lies within a ball with all attributes; without a radius such that about so many vertices are in it."""
    x, y, z = centre
    if radius is None:
        distances = np.linalg.norm(read_mesh(path).mesh.vertices - np.array(centre), axis=1)
        radius = float(np.partition(distances, min(vertices, len(distances) - 1))[min(vertices, len(distances) - 1)])
    outside = f"((x - ({x!r}))^2 + (y - ({y!r}))^2 + (z - ({z!r}))^2) > {radius * radius!r}"
    steps = (
        Step(find_filter("compute_selection_by_condition_per_vertex")).with_values({"condselect": outside}),
        Step(find_filter("meshing_remove_selected_vertices")),
    )
    run_job(Job(Recipe("part", Script(steps)), path, target, measures=False))


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
            "distance": distance_table(comparison, self._unit),
            "lines": comparison_lines(comparison, self._unit),
        }
        scalars = {**shown.scalars, "distance": distances.after.at_vertices[shown.kept]}
        return numbers, self._packed(replace(shown, scalars=scalars))

    def _shown(self, name: str, mesh: MeshData) -> Shown:
        first = self._before.mesh
        scalars = {"curvature": mean_curvature(mesh.vertices, mesh.faces)} if len(mesh.faces) else {}
        return shown_mesh(
            name, mesh, scalars=scalars, like=self._scan if mesh is not first and same_elements(mesh, first) else None
        )

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


#: the bench of a scan, which a process reads once
_bench = cache(Bench)


def at_bench(scan: Path, work: str, *arguments: Any) -> Result:
    """The result of a method of the bench of a scan: the task of a process that stays."""
    result: Result = getattr(_bench(scan), work)(*arguments)
    return result
