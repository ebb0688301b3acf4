"""Plans runs by tiles: the steps that tiles allow, the rings that steps read, the size of tiles, and the disk space.

``benchmarks/scale.py`` measures the bytes in memory and on the disk that formulas here predict.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from ..declaration import AUTO
from ..errors import FilterInputError, ParameterError
from ..filters import denoising
from ..filters.diffusion import explicit_smoothing, meshlab_taubin_smooth, taubin_fairing
from ..filters.mesh import Floats, Ints, Whole
from ..scripts.script import Script, ScriptError

EXPLICIT, TAUBIN, NORMALS = "apply_coord_explicit_smoothing", "apply_coord_taubin_fairing", "apply_coord_normal_filtering"
MESHLAB = "apply_coord_taubin_smoothing"  # MeshLab's own
#: steps that select points of a cloud
LOOP, STRAYS = "compute_selection_by_outlier_probability_per_vertex", "compute_selection_by_stray_points_per_vertex"
SURPLUS = "compute_selection_by_grid_per_vertex"
#: the step that removes coincident points, except the first of them
DUPLICATES = "meshing_remove_duplicate_vertices"
POINT_NORMALS = "compute_normal_for_point_clouds"
_ON_CLOUDS = (LOOP, STRAYS, SURPLUS, DUPLICATES, POINT_NORMALS)
DELETE, _PROJECTION = "meshing_remove_selected_vertices", "apply_coord_bilateral_projection_of_points"
_CAN = (
    "By tiles a recipe may remove coincident points, select stray, outlying or surplus points of a cloud (Select Stray Points, "
    "LoOP, Select Surplus Points), delete the selected vertices, and compute normals for point sets; or move the vertices of a "
    "mesh by Taubin Smooth, Taubin Fairing, Explicit Smoothing, or Normal Filtering"
)
#: steps that need the whole cloud or mesh: the reason, and the alternative
_WHY = {
    _PROJECTION: "moves points with the bandwidth of the whole cloud; remove this step",
    "apply_coord_implicit_fairing": "solves equations for all vertices; take 'Taubin Fairing', or 'Normal Filtering' "
    "against noise",
    "apply_coord_laplacian_smoothing": "is MeshLab's own, which reads the whole mesh; take 'Explicit Smoothing' with update "
    "'meshlab', which does the same",
}

#: values of parameters of normal filtering that need the whole mesh
_WHOLE = {
    "neighborhood": ("radius", "geodesic"),
    "vertex_update": ("conjugate_gradient",),
    "outliers": ("replace", "only"),
    "rounding": ("undo",),
}
#: the most rings that an automatic setting reads: two for each of 28 pairs of Taubin's steps; a round of filtering reads fewer
_WIDEST = 56
#: planned bytes for each vertex of a tile; measured: 209 for Taubin's steps, 900 for normals averaged over two rings of faces
_BYTES, _BYTES_OF_NORMALS = 400, {"edge": 700, "vertex": 800, "two_ring": 1100, "three_ring": 1700}


@dataclass(frozen=True)
class PlannedStep:
    """A step by tiles."""

    step: int  # its number, from 1
    filter: str  # the Python name
    values: Mapping[str, Any]
    deletes: bool = False  # whether the points found are deleted, by `DUPLICATES` itself or by the step after a selection

    @property
    def is_builtin(self) -> bool:
        return self.filter == MESHLAB

    @property
    def is_on_cloud(self) -> bool:
        return self.filter in _ON_CLOUDS

    @property
    def neighbors(self) -> int:
        return int(self.values["k"]) - 1 if self.filter == POINT_NORMALS else int(self.values.get("neighbors", 0))


def plan_of(script: Script) -> list[PlannedStep]:
    """Returns the steps of a recipe, all for clouds or all for meshes; raises `ScriptError` if one cannot be done by tiles."""
    steps: list[PlannedStep] = []
    for number, step in enumerate(script.steps, 1):
        name, values = step.filter.python_name, step.with_defaults().values
        planned = PlannedStep(number, name, values, deletes=name == DUPLICATES)
        is_cloud, last = bool(steps and steps[0].is_on_cloud), steps[-1] if steps else planned
        if name == DELETE and (is_cloud or not steps):
            if last.step != number - 1 or last.filter == POINT_NORMALS:
                raise _refusal(script, number, "deletes selected vertices, but the step right before it selects none")
            steps[-1] = replace(last, deletes=True)
        elif is_cloud and name == _PROJECTION and values["iterations"] == 0:
            continue
        elif name != DELETE and (why := why_not(name, values)):
            raise _refusal(script, number, _WHY.get(name, why))
        elif (steps and planned.is_on_cloud != is_cloud) or name == DELETE:
            raise _refusal(script, number, "does not fit the steps before it: a recipe is for clouds alone or for meshes alone")
        else:
            steps.append(planned)
    selections = [step for step in steps if step.is_on_cloud and step.filter != POINT_NORMALS]
    for selection in selections[:-1]:
        if not selection.deletes:
            raise _refusal(script, selection.step, "selects points that no step deletes before the next selection")
    return steps


def _refusal(script: Script, number: int, why: str) -> ScriptError:
    return ScriptError([script.problem(script.steps[number - 1], f"cannot be done by tiles: it {why}. {_CAN}")])


def why_not(filter: str, values: Mapping[str, Any]) -> str | None:
    """Returns why a filter with these values cannot be done by tiles; None if it can."""
    if filter == POINT_NORMALS and values["k"] < 3:
        return "computes normals from fewer than three points"
    if filter == SURPLUS and values["side"].unit == "edge":
        return "has a length in mean edges, which needs the whole cloud; take one in mesh units or in % of the diagonal"
    if filter in _ON_CLOUDS:
        return None
    if filter not in (EXPLICIT, TAUBIN, NORMALS, MESHLAB):
        return "needs the whole mesh at once, or is not implemented for tiles yet"
    if values.get("selected"):
        return "moves only selected vertices, and files hold no selection"
    if filter == NORMALS:
        return _why_not_filtering(values)
    if filter != MESHLAB and values["iterations"] == AUTO:
        return "chooses its iterations on the whole mesh; set a number of iterations"
    if filter != MESHLAB and values["operator"] not in ("uniform", "cotangent"):
        return f"has the operator {values['operator']!r}, which needs the whole mesh; take 'uniform' or 'cotangent'"
    return None


def _why_not_filtering(values: Mapping[str, Any]) -> str | None:
    filtering = filtering_of(values)
    parameters = _set_values(values) if filtering is None else filtering.parameters
    bad = next((name for name, refused in _WHOLE.items() if parameters.get(name) in refused), None)
    return bad and f"has {bad} {parameters[bad]!r}, which needs the whole mesh"


@dataclass(frozen=True)
class Filtering:
    """The parameters of normal filtering, none of them automatic."""

    settings: denoising.NormalFilter
    vertex_iterations: int  # the steps of the vertices in a round
    outer_iterations: int  # the rounds
    vertex_update: Any  # how vertices are fitted to the filtered normals
    outliers: str  # the treatment of vertices that stand out
    rounding: str  # the treatment of terraces that rounded coordinates form
    relaxation: int  # pairs of Taubin's steps before the rounds
    relaxation_direction: denoising.RelaxationDirection  # the directions in which these steps may move vertices
    border: Any  # the rule for border vertices
    parameters: Mapping[str, Any]  # all of these but `border`, by name


def filtering_of(values: Mapping[str, Any]) -> Filtering | None:
    """Returns the parameters of normal filtering; None if the filter chooses some of them for the mesh."""
    parameters = denoising.parameters_without_mesh(_set_values(values), values["choice"])
    if parameters is None:
        return None
    of_normals = {f.name for f in fields(denoising.NormalFilter)}
    settings = denoising.NormalFilter(**{n: v for n, v in parameters.items() if n in of_normals})
    others = {n: v for n, v in parameters.items() if n not in of_normals}
    return Filtering(settings, border=values["border"], parameters=parameters, **others)


def _set_values(values: Mapping[str, Any]) -> dict[str, Any]:
    return {n: v for n, v in values.items() if n not in ("choice", "compare", "border", "selected") and v != AUTO}


def choose(values: Mapping[str, Any], vertices: Floats, faces: Ints, *, is_open: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns all parameters, and a report; chooses the automatic ones on a sample of the mesh, as a run in one piece does."""
    set_values, choice, border = _set_values(values), values["choice"], values["border"]
    parameters, made = denoising.parameters_for_mesh(vertices, faces, set_values, choice, border=border)
    if why := _why_not_filtering({**values, **parameters}):
        name = "rounding" if parameters["rounding"] == "undo" else "outliers"
        raise FilterInputError(
            f"the best setting for this mesh {why}: run it in one piece, or set {name} to 'keep' and leave all else 'auto'"
        )
    notes = denoising.notes_of_choice(made, parameters, is_open=is_open)
    return parameters, {**denoising.findings_of_choice(made), "notes": notes}


def cost_of(step: PlannedStep) -> tuple[int, int]:
    """Returns the bytes that a step takes for each vertex of a tile, and the number of rings around the tile that it reads."""
    if step.filter != NORMALS:
        return _BYTES, rings_of(step)
    filtering = filtering_of(step.values)
    if filtering is None:
        return _BYTES_OF_NORMALS["two_ring"], _WIDEST
    rings = denoising.rings_of_round(filtering.settings, filtering.vertex_iterations)
    before = denoising.rings_of_relaxation(filtering.relaxation) if filtering.relaxation else 0
    return _BYTES_OF_NORMALS[filtering.settings.neighborhood], max(rings, before)


def rings_of(step: PlannedStep) -> int:
    """Returns how many rings of faces around a vertex are read by a step of explicit smoothing or of a Taubin filter."""
    if step.is_builtin:
        return 2 * int(step.values["stepsmoothnum"])
    return int(step.values["iterations"]) * (2 if step.filter == TAUBIN else 1)


def apply(step: PlannedStep, vertices: Floats, faces: Ints, whole: Whole) -> Floats:
    """Returns the (n, 3) vertices after Laplacian or Taubin steps; vertices of the tile itself are the same as without tiles."""
    values = {name: value for name, value in step.values.items() if name != "selected"}
    if step.is_builtin:
        lambda_, mu, iterations = values["lambda_"], values["mu"], values["stepsmoothnum"]
        return meshlab_taubin_smooth(vertices, faces, step=lambda_, mu=mu, iterations=iterations, whole=whole)
    if step.filter == EXPLICIT:
        return explicit_smoothing(vertices, faces, whole=whole, **values)
    return taubin_fairing(vertices, faces, whole=whole, **values | {"pass_band": values["pass_band"] or None})


#: bytes planned for the command (enough also with dask), and for a worker with libraries and compiled kernels
COMMAND, WORKER = 160_000_000, 280_000_000
#: the least bytes that a worker has for tiles; if memory does not suffice for all processors, there are fewer workers
LEAST = 60_000_000
#: a tile is planned to take this share of the bytes that a worker has for tiles, since predictions have errors
SHARE = 0.85


@dataclass(frozen=True)
class Budget:
    """Workers and their memory."""

    workers: int
    threads: int  # of each worker
    tile: int  # bytes that a tile may take


def budget(memory: int, processors: int) -> Budget:
    """Divides `memory` bytes among at most `processors` workers."""
    for workers in range(processors, 0, -1):
        each = (memory - COMMAND) // workers - WORKER
        if each >= LEAST:
            return Budget(workers, max(1, processors // workers), int(SHARE * each))
    least = (COMMAND + WORKER + LEAST) / 1e6
    raise ParameterError(
        f"{memory / 1e6:.0f} MB are too little for work by tiles, since libraries take most of it; give {least:.0f}MB"
    )


def cloud_points(tile: int, neighbors: int, *, normals: bool = False) -> int:
    """Returns how many points fit into a tile of `tile` bytes, for LoOP, stray points or `normals` with that many neighbours."""
    return max(4 * neighbors, int(tile / (200 + 40 * neighbors if normals else 180 + 9 * neighbors)))


def surface_vertices(tile: int, each: int, rings: int) -> int:
    """Returns how many vertices a tile of `tile` bytes has, with `each` bytes a vertex and `rings` rings around it.

    Each ring around a tile of v vertices has about 4 sqrt(v) vertices.
    """
    return max(64, int((math.sqrt(4 * rings * rings + tile / each) - 2 * rings) ** 2))


def slice_rows(tile: int, row: int) -> int:
    """Returns how many file rows of `row` bytes, with the arrays made of them, fit into `tile` bytes."""
    return max(1 << 12, int(tile / (6 * row + 150)))


def cloud_room(count: int, row: int, plan: Sequence[PlannedStep]) -> int:
    """Returns the bytes on the disk for the temporary files of a cloud and the output.

    In bytes for each point: cells take 32. LoOP with k neighbours adds 24 for distances and factors, 17 for the probability and
    the mask, and 2 + k for the neighbours in other tiles, which an eighth of the points has. Stray points add 62 + 8 k, normals
    122 + 8 k. For LoOP with 20 neighbours 84 to 87 bytes a point were measured.
    """
    each = {LOOP: (75, 1), STRAYS: (94, 8), POINT_NORMALS: (154, 8)}
    steps = [each[s.filter][0] + each[s.filter][1] * s.neighbors for s in plan if s.filter in each]
    return count * max(64, row + (65 if any(s.filter == POINT_NORMALS for s in plan) else 17), *steps)
