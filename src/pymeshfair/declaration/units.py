"""Numbers and lengths: in mesh units, relative ones that carry over from mesh to mesh, and those with a unit such as 0.05mm."""

from __future__ import annotations

import math
import numbers
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, cast

import numpy as np

from ..errors import ParameterError

LengthUnit: TypeAlias = Literal["absolute", "percent", "edge", "mm", "cm", "m", "in"]
METRES: Mapping[str, float] = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}  # the units that a scan may be in, in metres
_LENGTH_SUFFIX = {"absolute": "", "percent": "%", "edge": "edge"} | {unit: unit for unit in METRES}
_LENGTH = re.compile(rf"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(%|edges?|{'|'.join(METRES)})?")


def as_float(value: Any) -> float | None:
    """The float of a real number of Python or numpy; None of anything else, truth values included."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def shown(value: Any) -> str:
    """The value as it would be written in Python, cut to a length that a message can hold."""
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


@dataclass(frozen=True)
class Length:
    """A length in mesh units, in percent of the bounding box's diagonal, in mean edges, or in a unit of `METRES`.

    Written ``"0.3"``, ``"1%"`` and ``"0.5edge"``. The last two carry over from scan to scan. On a point cloud an "edge" is the
    mean distance from a point to its nearest neighbour. A limit of a result may be ``"0.05mm"``, a parameter may not.
    """

    amount: float
    unit: LengthUnit = "absolute"

    def __post_init__(self) -> None:
        amount = as_float(self.amount)
        if amount is None or not math.isfinite(amount):
            raise ParameterError(f"the amount of a length must be a finite number, got {shown(self.amount)}")
        if self.unit not in _LENGTH_SUFFIX:
            raise ParameterError(f"the unit of a length is one of {', '.join(map(repr, _LENGTH_SUFFIX))}, got {shown(self.unit)}")
        object.__setattr__(self, "amount", amount)  # numpy's numbers print themselves differently

    @classmethod
    def parse(cls, text: str) -> Length:
        """Read ``"0.3"``, ``"1%"``, ``"0.5edge"`` or ``"0.05mm"``; raise `ParameterError` for anything else."""
        match = _LENGTH.fullmatch(text.strip()) if len(text) <= 400 else None
        if match is None:
            raise ParameterError(
                f"{shown(text)} is no length: write 0.3 (mesh units), 1% (of the diagonal) or 0.5edge (mean edges)"
            )
        suffix = match[2] or "absolute"
        return cls(float(match[1]), cast("LengthUnit", {"%": "percent", "edges": "edge"}.get(suffix, suffix)))

    def resolve(self, *, diagonal: float, mean_edge: Callable[[], float]) -> float:
        """The length in mesh units on a mesh of that bounding-box diagonal; `mean_edge` is only called when it is needed."""
        if self.unit == "percent":
            return self.amount / 100.0 * diagonal
        if self.unit == "edge":
            return self.amount * mean_edge()
        return self.in_mesh_units(None).amount

    def in_mesh_units(self, unit: str | None) -> Length:
        """The length on a scan in that unit, without which one in a unit of `METRES` is refused; others stay as they are."""
        if self.unit not in METRES:
            return self
        if unit is None:
            amounts = {name: self.in_mesh_units(name).amount for name in (self.unit, "mm", "m")}
            readings = " and ".join(f"{amount:.6g} on a scan in {name}" for name, amount in amounts.items())
            raise ParameterError(
                f"{self} would be {readings}, and neither the file nor the recipe says which it is: say it by --unit "
                f"{'|'.join(METRES)} (unit= in Python), or give the length without a unit, as a number of the scan's own units"
            )
        return Length(self.amount * METRES[self.unit] / METRES[check_unit(unit)])

    def __str__(self) -> str:
        return f"{self.amount!r}{_LENGTH_SUFFIX[self.unit]}"


def unit_of_scan(typed: str | None, of_file: str | None, of_recipe: str = "") -> str | None:
    """The unit of a scan: that which the user typed, else that of its file, else that of the recipe's head; None without any."""
    if typed is not None:
        return check_unit(typed)
    return of_file if of_file in METRES else of_recipe or None


def check_unit(unit: str) -> str:
    """The unit of a scan, or raise `ParameterError` if there is no such one."""
    if unit not in METRES:
        raise ParameterError(f"{unit!r} is no unit of scans: it is one of {', '.join(METRES)}")
    return unit
