"""Which recipes can be done by tiles, and what each of their steps does there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..scripts.problems import Problem, ScriptError
from ..scripts.script import Script, Step

#: steps that select points of a cloud
LOOP, STRAYS = "compute_selection_by_outlier_probability_per_vertex", "compute_selection_by_stray_points_per_vertex"
#: the step that removes all but the first of the points at one place
DUPLICATES = "meshing_remove_duplicate_vertices"
_DELETE, _PROJECTION = "meshing_remove_selected_vertices", "apply_coord_bilateral_projection_of_points"
_NORMALS = "compute_normal_for_point_clouds"
_CAN = (
    "by tiles a recipe may remove coincident points, select stray points or outliers of a cloud (Select Stray Points, LoOP) and "
    "delete the selected vertices, or move the vertices of a mesh by Taubin Smooth, Taubin Fairing, Explicit Smoothing, or Normal"
    " Filtering with fixed parameters"
)
_WITHOUT_NORMALS = (
    "no normals are computed by tiles: 'Compute normals for point sets' turns them alike from point to point through the whole "
    "cloud. Compute them on a part of the result"
)
#: steps that need all of a cloud or a mesh: the reason, and what to take in their place
_WHY = {
    _PROJECTION: "moves points with the bandwidth of the whole cloud; set 'iterations' to 0, which moves none",
    "apply_coord_implicit_fairing": "solves one system of equations for all vertices; take 'Taubin Fairing'",
    "apply_coord_laplacian_smoothing": "is MeshLab's own, which reads the whole mesh; take 'Explicit Smoothing' with update "
    "'meshlab', which does the same",
}


@dataclass(frozen=True)
class Selection:
    """Points of a cloud are selected, and deleted if the next step says so.

    Attributes:
        step: its number, from 1.
        filter: the Python name, `LOOP` or `STRAYS`; or `DUPLICATES`, which deletes by itself.
        values: of its parameters.
        deletes: whether the selected ones are deleted.
    """

    step: int
    filter: str
    values: Mapping[str, Any]
    deletes: bool

    @property
    def neighbors(self) -> int:
        """How many nearest points a point is compared with."""
        return int(self.values.get("neighbors", 0))


@dataclass(frozen=True)
class Move:
    """The vertices of a mesh are moved.

    Attributes:
        step: its number, from 1.
        filter: the Python name.
        values: of its parameters.
    """

    step: int
    filter: str
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Plan:
    """What the steps of a recipe are by tiles: all selections, or all moves.

    Attributes:
        selections: of a cloud.
        moves: of a mesh.
        notes: what the run says of steps that are left out.
    """

    selections: tuple[Selection, ...] = ()
    moves: tuple[Move, ...] = ()
    notes: tuple[str, ...] = ()


def plan_of(script: Script) -> Plan:
    """What the steps of a recipe are by tiles.

    Raises:
        ScriptError: a step cannot be done by tiles; it is named, and why.
    """
    from .moves import why_not

    selections: list[Selection] = []
    moves: list[Move] = []
    notes: list[str] = []
    for number, step in enumerate(script.steps, 1):
        name, values = step.filter.python_name, step.with_defaults().values
        selects = name in (LOOP, STRAYS, DUPLICATES)
        if selects and not moves:
            selections.append(Selection(number, name, values, deletes=name == DUPLICATES))
        elif selections and name == _DELETE and selections[-1].step == number - 1:
            selections[-1] = replace(selections[-1], deletes=True)
        elif name == _DELETE and not moves:
            raise _refusal(script, step, "deletes what a step before has selected, which must be the one right before it")
        elif selections and name == _NORMALS:
            notes.append(f"step {number} was left out: {_WITHOUT_NORMALS}")
        elif selections and name == _PROJECTION and values["iterations"] == 0:
            continue
        elif (why := why_not(name, values)) is None and not selections:
            moves.append(Move(number, name, values))
        elif selects or why is None or (name == _DELETE and moves):
            raise _refusal(script, step, "is of the other kind than the steps before it: a recipe selects, or it moves vertices")
        else:
            raise _refusal(script, step, _WHY.get(name, why))
    if any(not selection.deletes for selection in selections[:-1]):
        raise _refusal(
            script, script.steps[selections[0].step - 1], "selects what no step deletes, and another selection follows"
        )
    return Plan(tuple(selections), tuple(moves), tuple(notes))


def _refusal(script: Script, step: Step, why: str) -> ScriptError:
    name = "script" if script.path is None else str(script.path)
    message = f"cannot be done by tiles: it {why}. What can: {_CAN}"
    return ScriptError([Problem(file=name, line=step.line, filter=step.filter.name, message=message)])
