"""Which filters of a mesh can be done by tiles, how many rings of faces around a tile each needs, and the call of each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..filters.diffusion import explicit_smoothing, taubin_fairing
from ..filters.mesh import Whole
from .division import Floats
from .halo import TileMesh

EXPLICIT, TAUBIN = "apply_coord_explicit_smoothing", "apply_coord_taubin_fairing"
#: operators whose weights need nothing but the one-ring
_LOCAL = ("uniform", "cotangent")


class Numbers(NamedTuple):
    """What of the whole mesh a step has to know, found in a pass before it.

    Attributes:
        whole: the box of the vertices that faces use.
    """

    whole: Whole


def why_not(filter: str, values: Mapping[str, Any]) -> str | None:
    """Why a step cannot be done by tiles, or None if it can.

    Args:
        filter: its Python name.
        values: of all its parameters.
    """
    if filter not in (EXPLICIT, TAUBIN):
        return "needs all of the mesh at once, or has not been cut into tiles yet"
    if values["selected"]:
        return "moves selected vertices alone, and a file holds no selection"
    if values["operator"] not in _LOCAL:
        return f"has the operator {values['operator']!r}, which needs the whole mesh; 'uniform' and 'cotangent' do not"
    return None


def rings_of(filter: str, values: Mapping[str, Any]) -> int:
    """How many rings of faces around a vertex decide where it goes."""
    return int(values["iterations"]) * (2 if filter == TAUBIN else 1)


def apply(filter: str, values: Mapping[str, Any], tile: TileMesh, numbers: Numbers) -> Floats:
    """(n, 3) the vertices of a tile after the step; those of the tile itself have the bits of the whole."""
    given = {name: value for name, value in values.items() if name != "selected"}
    if filter == EXPLICIT:
        return explicit_smoothing(tile.vertices, tile.faces, whole=numbers.whole, **given)
    given["pass_band"] = given["pass_band"] or None
    return taubin_fairing(tile.vertices, tile.faces, whole=numbers.whole, **given)
