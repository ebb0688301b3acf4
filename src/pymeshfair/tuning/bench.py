"""The work of the worker: the scan, measured once, and each result compared with it and packed for the browser."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..declaration import Floats
from ..filters.inspection import mean_curvature, symmetric_limits
from ..looking.comparison import compare
from ..looking.mesh_state import MeshState, state_of
from ..looking.words import DISPLACEMENT_HEADERS, comparison_lines, displacement_rows, measure_rows
from ..report.display import shown_mesh
from ..report.scene import Scene, pack_scene
from ..running.measuring import Measuring
from ..running.messages import Assignment
from ..running.read import ReadMesh, read_mesh
from ..running.session import Session

#: the box of coordinates is so much larger than the scan, as results may grow
_ROOM = 1.5


class Bench:
    """One scan, and what recipes make of it.

    Args:
        scan: the file to run recipes on.
        stage: a folder for what is made.
        tell: sends a document to the server.
    """

    def __init__(self, scan: Path, stage: Path, tell: Callable[[Mapping[str, Any]], None]) -> None:
        """Read and measure the scan."""
        self._stage = stage
        self._tell = tell
        self._before = state_of(read_mesh(scan))
        vertices = self._before.mesh.vertices
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        self._box = 0.5 * (low + high), 0.5 * _ROOM * float((high - low).max()) or 1.0

    def opening(self, scene: Path) -> dict[str, Any]:
        """What the page shows before anything ran; the scan is written to `scene` for the browser."""
        scene.write_bytes(self._packed("scan", self._before, {}).message)
        return {"measures": measure_rows({"scan": self._before.measures})}

    def run(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """Carry out the assignment in a document, compare and pack; where the scene is, and the numbers."""
        assignment = Assignment.from_document(document)
        session = Session(assignment, self._tell)
        outcome = session.carry_out(self._before.mesh)
        self._tell({"event": "PhaseStarted", "phase": "comparing"})
        result = Measuring(wanted=True).look(outcome.result)
        after = state_of(ReadMesh(assignment.input, outcome.result, result, ()))
        found, moved = compare(self._before, after)
        scene = assignment.stage / "scene"
        scene.write_bytes(self._packed("result", after, {"displacement": moved.signed}).message)
        shutil.rmtree(assignment.stage / "meshlab", ignore_errors=True)
        return {
            "scene": str(scene),
            "measures": measure_rows({"scan": self._before.measures, "result": after.measures}),
            "displacement": [list(DISPLACEMENT_HEADERS), *displacement_rows(found)],
            "lines": comparison_lines(found),
            "warnings": session.warnings,
            "step_seconds": [round(step["seconds"], 3) for step in outcome.steps],
        }

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
