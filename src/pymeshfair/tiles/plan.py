"""The steps of a recipe by tiles: those on clouds, and those that move the vertices of meshes, with their rings and calls."""

import inspect
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..declaration import AUTO
from ..errors import FilterInputError
from ..filters import denoising
from ..filters.diffusion import explicit_smoothing, meshlab_taubin_smooth, taubin_fairing
from ..filters.mesh import Whole
from ..scripts.script import Script, ScriptError, Step
from .division import Floats
from .surface import TileMesh

EXPLICIT, TAUBIN, NORMALS = "apply_coord_explicit_smoothing", "apply_coord_taubin_fairing", "apply_coord_normal_filtering"
#: MeshLab's own Taubin Smooth
MESHLAB = "apply_coord_taubin_smoothing"
#: operators whose weights need only the one-ring
_LOCAL = ("uniform", "cotangent")
#: defaults of the other parameters
_DEFAULTS = {"vertex_update": "sun", "outliers": "keep", "rounding": "keep", "relaxation": 0, "relaxation_direction": "all"}
#: defaults of the filter itself, by its authors
_AUTHORS = {field.name: field.default for field in fields(denoising.NormalFilter) if field.name != "radius"} | {
    name: inspect.signature(denoising.normal_filtering).parameters[name].default
    for name in ("vertex_iterations", "outer_iterations")
}
#: rings of the widest setting that is chosen from, but for rounds: those of 28 pairs of Taubin's steps
_WIDEST = 56
#: bytes of a vertex in a tile
_BYTES, _BYTES_OF_NORMALS = 400, {"edge": 700, "vertex": 800, "two_ring": 1100, "three_ring": 1700}


@dataclass(frozen=True)
class Filtering:
    """The parameters of normal filtering, all of them known."""

    settings: denoising.NormalFilter  # the filter of the normals
    vertex_iterations: int  # steps of the vertices in a round
    outer_iterations: int  # rounds
    vertex_update: Any  # how vertices follow
    outliers: str  # the treatment of vertices that stand out
    rounding: str  # the treatment of terraces of rounded coordinates
    relaxation: int  # pairs of Taubin's steps before
    relaxation_direction: denoising.RelaxationDirection  # the directions in which vertices may go
    border: Any  # the rule for border vertices


def filtering_of(values: Mapping[str, Any]) -> Filtering | None:
    """The parameters that the filter takes without a look at the mesh; None if some are chosen for the mesh."""
    set_values = _given(values)
    if not {f.name for f in fields(denoising.AutomaticParameters)} <= set_values.keys():
        if values["choice"] != "fixed":
            return None
        set_values = asdict(denoising.FIXED) | set_values
    parameters: dict[str, Any] = _DEFAULTS | set_values
    own = {f.name: parameters.pop(f.name) for f in fields(denoising.NormalFilter) if f.name in parameters}
    return Filtering(denoising.NormalFilter(**own), border=values["border"], **parameters)


def _given(values: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters that are not automatic."""
    return {n: v for n, v in values.items() if n not in ("choice", "compare", "border", "selected") and v != AUTO}


def chosen(values: Mapping[str, Any], vertices: Floats, faces: NDArray[np.int32]) -> dict[str, Any]:
    """The parameters with those that are automatic chosen on a sample of the mesh, as in one piece."""
    set_values, border = _given(values), values["border"]
    # as in one piece: passes and rounding are no part of what is tried
    tried = denoising.REPERTOIRE.narrowed(**{n: v for n, v in set_values.items() if n not in ("normal_iterations", "rounding")})
    setting = denoising.automatic_choice(vertices, faces, border=border, repertoire=tried).setting
    chosen_values = {"outer_iterations": 0} if setting.parameters is None else asdict(setting.parameters)
    if setting.parameters is None and set_values:
        chosen_values = {}  # what is given is then completed as the authors of the filter would
    before = {n: getattr(setting, n) for n in ("outliers", "rounding", "relaxation", "relaxation_direction")}
    parameters = {**_AUTHORS, **_DEFAULTS, **chosen_values, **before, **set_values}
    if (why := _why_not_filtering(filtering_of({**values, **parameters}))) is not None:
        name = "rounding" if parameters["rounding"] == "undo" else "outliers"
        raise FilterInputError(
            f"what suits this mesh best {why}: run it in one piece, or set {name} to 'keep' and have the rest chosen"
        )
    return parameters


def why_not(filter: str, values: Mapping[str, Any]) -> str | None:
    """The reason why a filter, by its Python name and all its values, cannot be done by tiles; None if it can."""
    if filter not in (EXPLICIT, TAUBIN, NORMALS, MESHLAB):
        return "needs all of the mesh at once, or has not been cut into tiles yet"
    if values["selected"]:
        return "moves selected vertices alone, and a file holds no selection"
    if filter == NORMALS:
        return _why_not_filtering(filtering_of(values))
    if filter == MESHLAB:
        return None
    if values["iterations"] == AUTO:
        return "chooses its iterations from the whole mesh; a number of them can be done"
    if values["operator"] not in _LOCAL:
        return f"has the operator {values['operator']!r}, which needs the whole mesh; 'uniform' and 'cotangent' do not"
    return None


def _why_not_filtering(filtering: Filtering | None) -> str | None:
    if filtering is None:
        return None
    settings = filtering.settings
    for name, value, bad in (
        ("neighborhood", settings.neighborhood, ("radius", "geodesic")),
        ("method", settings.method, ("vertex_normals",)),
        ("vertex_update", filtering.vertex_update, ("conjugate_gradient",)),
        ("outliers", filtering.outliers, ("replace", "only")),
        ("rounding", filtering.rounding, ("undo",)),
    ):
        if value in bad:
            return f"has {name} {value!r}, which needs the whole mesh"
    return None


def cost_of(filter: str, values: Mapping[str, Any]) -> tuple[int, int]:
    """The bytes that a step takes for each vertex of a tile, and how many rings there are around the tile.

    Measured were 209 bytes for Taubin's steps, and 900 for normals averaged over two rings of faces.
    """
    if filter != NORMALS:
        return _BYTES, rings_of(filter, values)
    filtering = filtering_of(values)
    if filtering is None:
        return _BYTES_OF_NORMALS["two_ring"], _WIDEST
    rings = denoising.rings_of_round(filtering.settings, filtering.vertex_iterations)
    before = denoising.rings_of_relaxation(filtering.relaxation) if filtering.relaxation else 0
    return _BYTES_OF_NORMALS[filtering.settings.neighborhood], max(rings, before)


def rings_of(filter: str, values: Mapping[str, Any]) -> int:
    """The number of rings of faces around a vertex on which Laplacian or Taubin steps depend."""
    return 2 * int(values["stepsmoothnum"]) if filter == MESHLAB else int(values["iterations"]) * (2 if filter == TAUBIN else 1)


def apply(filter: str, values: Mapping[str, Any], tile: TileMesh, whole: Whole) -> Floats:
    """(n, 3) the vertices of a tile after such steps; those of the tile itself have the bits of the whole."""
    if filter == MESHLAB:
        return meshlab_taubin_smooth(
            tile.vertices, tile.faces, step=values["lambda_"], mu=values["mu"], iterations=values["stepsmoothnum"], whole=whole
        )
    parameters = {name: value for name, value in values.items() if name != "selected"}
    if filter == EXPLICIT:
        return explicit_smoothing(tile.vertices, tile.faces, whole=whole, **parameters)
    parameters["pass_band"] = parameters["pass_band"] or None
    return taubin_fairing(tile.vertices, tile.faces, whole=whole, **parameters)


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
    return ScriptError([script.problem(step, f"cannot be done by tiles: it {why}. What can: {_CAN}")])
