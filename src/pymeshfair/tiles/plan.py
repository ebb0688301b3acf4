"""The steps of a recipe by tiles; refuses recipes that need the whole mesh."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..scripts.problems import Problem, ScriptError
from ..scripts.script import Script, Step

#: steps that select points of a cloud
LOOP, STRAYS = "compute_selection_by_outlier_probability_per_vertex", "compute_selection_by_stray_points_per_vertex"
SURPLUS = "compute_selection_by_grid_per_vertex"
#: the step that removes all but the first of the points at one place
DUPLICATES = "meshing_remove_duplicate_vertices"
_DELETE, _PROJECTION = "meshing_remove_selected_vertices", "apply_coord_bilateral_projection_of_points"
#: the step that gives points normals
POINT_NORMALS = "compute_normal_for_point_clouds"
_CAN = (
    "by tiles a recipe may remove coincident points, select stray, outlying or surplus points of a cloud (Select Stray Points, "
    "LoOP, Select Surplus Points), delete the selected vertices, and compute normals for point sets; or move the vertices of a "
    "mesh by Taubin Smooth, Taubin Fairing, Explicit Smoothing, or Normal Filtering"
)
#: steps that need all of a cloud or a mesh: the reason, and what to take in their place
_WHY = {
    _PROJECTION: "moves points with the bandwidth of the whole cloud; set 'iterations' to 0, which moves none",
    "apply_coord_implicit_fairing": "solves equations for all vertices, and gives whole parts their volume back after every "
    "step; take 'Taubin Fairing', or 'Normal Filtering' against noise",
    "apply_coord_laplacian_smoothing": "is MeshLab's own, which reads the whole mesh; take 'Explicit Smoothing' with update "
    "'meshlab', which does the same",
}


@dataclass(frozen=True)
class CloudStep:
    """Points of a cloud are selected, and deleted if the next step says so, or they get normals."""

    step: int  # its number, from 1
    filter: str  # the Python name, `LOOP`, `STRAYS`, `SURPLUS` or `POINT_NORMALS`; or `DUPLICATES`, which deletes by itself
    values: Mapping[str, Any]  # of its parameters
    deletes: bool  # whether the selected ones are deleted

    @property
    def neighbors(self) -> int:
        """The number of nearest points that a point is compared with."""
        return int(self.values["k"]) - 1 if self.filter == POINT_NORMALS else int(self.values.get("neighbors", 0))


@dataclass(frozen=True)
class Move:
    """The vertices of a mesh are moved."""

    step: int  # its number, from 1
    filter: str  # the Python name
    values: Mapping[str, Any]  # of its parameters


@dataclass(frozen=True)
class Plan:
    """The steps of a recipe by tiles: all on a cloud, or all moves of a mesh."""

    cloud: tuple[CloudStep, ...] = ()  # on a cloud
    moves: tuple[Move, ...] = ()  # of a mesh


def plan_of(script: Script) -> Plan:
    """The steps of a recipe by tiles."""
    from .moves import why_not

    cloud: list[CloudStep] = []
    moves: list[Move] = []
    for number, step in enumerate(script.steps, 1):
        name, values = step.filter.python_name, step.with_defaults().values
        selects = name in (LOOP, STRAYS, SURPLUS, DUPLICATES)
        if (selects or name == POINT_NORMALS) and not moves:
            if why := _why_not(name, values):
                raise _refusal(script, step, why)
            cloud.append(CloudStep(number, name, values, deletes=name == DUPLICATES))
        elif cloud and name == _DELETE and cloud[-1].step == number - 1 and cloud[-1].filter != POINT_NORMALS:
            cloud[-1] = replace(cloud[-1], deletes=True)
        elif name == _DELETE and not moves:
            raise _refusal(script, step, "deletes what a step before has selected, which must be the one right before it")
        elif cloud and name == _PROJECTION and values["iterations"] == 0:
            continue
        elif (why := why_not(name, values)) is None and not cloud:
            moves.append(Move(number, name, values))
        elif selects or why is None or (name in (_DELETE, POINT_NORMALS) and moves):
            raise _refusal(
                script, step, "is of the other kind than the steps before it: a recipe is of clouds, or it moves vertices"
            )
        else:
            raise _refusal(script, step, _WHY.get(name, why))
    open_ = [step for step in cloud if not step.deletes and step.filter != POINT_NORMALS]
    if open_ and any(step.step > open_[0].step and step.filter != POINT_NORMALS for step in cloud):
        raise _refusal(script, script.steps[open_[0].step - 1], "selects what no step deletes, and another selection follows")
    return Plan(tuple(cloud), tuple(moves))


def _why_not(name: str, values: Mapping[str, Any]) -> str | None:
    """The reason why a step on a cloud cannot be done by tiles, or None if it can."""
    if name == POINT_NORMALS and values["k"] < 3:
        return "computes normals from fewer than three points"
    if name == SURPLUS and values["side"].unit == "edge":
        return "has a length in mean edges, which needs the whole cloud; take one in mesh units or in % of the diagonal"
    return None


def _refusal(script: Script, step: Step, why: str) -> ScriptError:
    name = "script" if script.path is None else str(script.path)
    message = f"cannot be done by tiles: it {why}. What can: {_CAN}"
    return ScriptError([Problem(file=name, line=step.line, filter=step.filter.name, message=message)])
