"""The filters of meshes that work by tiles: the rings of faces that each needs around a tile, and its call."""

import inspect
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..declaration import AUTO
from ..errors import FilterInputError
from ..filters.denoising import (
    FIXED,
    REPERTOIRE,
    AutomaticParameters,
    NormalFilter,
    RelaxationDirection,
    automatic_choice,
    normal_filtering,
    rings_of_relaxation,
    rings_of_round,
)
from ..filters.diffusion import explicit_smoothing, meshlab_taubin_smooth, taubin_fairing
from ..filters.mesh import Whole
from .division import Floats
from .halo import TileMesh

EXPLICIT, TAUBIN, NORMALS = "apply_coord_explicit_smoothing", "apply_coord_taubin_fairing", "apply_coord_normal_filtering"
#: MeshLab's own Taubin Smooth
MESHLAB = "apply_coord_taubin_smoothing"
#: operators whose weights need only the one-ring
_LOCAL = ("uniform", "cotangent")
#: defaults of the other parameters
_DEFAULTS = {"vertex_update": "sun", "outliers": "keep", "rounding": "keep", "relaxation": 0, "relaxation_direction": "all"}
#: defaults of the filter itself, by its authors
_AUTHORS = {field.name: field.default for field in fields(NormalFilter) if field.name != "radius"} | {
    name: inspect.signature(normal_filtering).parameters[name].default for name in ("vertex_iterations", "outer_iterations")
}
#: rings of the widest setting that is chosen from, but for rounds: those of 28 pairs of Taubin's steps
_WIDEST = 56
#: bytes of a vertex in a tile
_BYTES, _BYTES_OF_NORMALS = 400, {"edge": 700, "vertex": 800, "two_ring": 1100, "three_ring": 1700}


@dataclass(frozen=True)
class Filtering:
    """The parameters of normal filtering, all of them known."""

    settings: NormalFilter  # the filter of the normals
    vertex_iterations: int  # steps of the vertices in a round
    outer_iterations: int  # rounds
    vertex_update: Any  # how vertices follow
    outliers: str  # the treatment of vertices that stand out
    rounding: str  # the treatment of terraces of rounded coordinates
    relaxation: int  # pairs of Taubin's steps before
    relaxation_direction: RelaxationDirection  # the directions in which vertices may go
    border: Any  # the rule for border vertices


def filtering_of(values: Mapping[str, Any]) -> Filtering | None:
    """The parameters that the filter takes without a look at the mesh; None if some are chosen for the mesh."""
    given = _given(values)
    if not {f.name for f in fields(AutomaticParameters)} <= given.keys():
        if values["choice"] != "fixed":
            return None
        given = asdict(FIXED) | given
    known: dict[str, Any] = _DEFAULTS | given
    own = {f.name: known.pop(f.name) for f in fields(NormalFilter) if f.name in known}
    return Filtering(NormalFilter(**own), border=values["border"], **known)


def _given(values: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters that are not automatic."""
    return {n: v for n, v in values.items() if n not in ("choice", "compare", "border", "selected") and v != AUTO}


def chosen(values: Mapping[str, Any], vertices: Floats, faces: NDArray[np.int32]) -> dict[str, Any]:
    """The parameters with those that are automatic chosen on a sample of the mesh, as in one piece."""
    given, border = _given(values), values["border"]
    # as in one piece: passes and rounding are no part of what is tried
    tried = REPERTOIRE.narrowed(**{n: v for n, v in given.items() if n not in ("normal_iterations", "rounding")})
    setting = automatic_choice(vertices, faces, border=border, repertoire=tried).setting
    found = {"outer_iterations": 0} if setting.parameters is None else asdict(setting.parameters)
    if setting.parameters is None and given:
        found = {}  # what is given is then completed as the authors of the filter would
    before = {n: getattr(setting, n) for n in ("outliers", "rounding", "relaxation", "relaxation_direction")}
    known = {**_AUTHORS, **_DEFAULTS, **found, **before, **given}
    if (why := _why_not_filtering(filtering_of({**values, **known}))) is not None:
        name = "rounding" if known["rounding"] == "undo" else "outliers"
        raise FilterInputError(
            f"what suits this mesh best {why}: run it in one piece, or set {name} to 'keep' and have the rest chosen"
        )
    return known


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
    rings = rings_of_round(filtering.settings, filtering.vertex_iterations)
    before = rings_of_relaxation(filtering.relaxation) if filtering.relaxation else 0
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
    given = {name: value for name, value in values.items() if name != "selected"}
    if filter == EXPLICIT:
        return explicit_smoothing(tile.vertices, tile.faces, whole=whole, **given)
    given["pass_band"] = given["pass_band"] or None
    return taubin_fairing(tile.vertices, tile.faces, whole=whole, **given)
