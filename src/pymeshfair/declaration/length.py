"""Lengths that carry over from mesh to mesh."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from ..errors import ParameterError
from .values import as_float, shown

LengthUnit: TypeAlias = Literal["absolute", "percent", "edge"]
_LENGTH_SUFFIX: Mapping[LengthUnit, str] = {"absolute": "", "percent": "%", "edge": "edge"}
_LENGTH = re.compile(r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(%|edges?)?")


@dataclass(frozen=True)
class Length:
    """A length in mesh units, in percent of the bounding box's diagonal, or in mean edges.

    Written ``"0.3"``, ``"1%"`` and ``"0.5edge"``. The last two carry over from scan to scan. On a point cloud an "edge" is the
    mean distance from a point to its nearest neighbour.
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
        """Read ``"0.3"``, ``"1%"`` or ``"0.5edge"``; raise `ParameterError` for anything else."""
        match = _LENGTH.fullmatch(text.strip()) if len(text) <= 400 else None
        if match is None:
            raise ParameterError(
                f"{shown(text)} is no length: write 0.3 (mesh units), 1% (of the diagonal) or 0.5edge (mean edges)"
            )
        amount, suffix = match.groups()
        unit: LengthUnit = "percent" if suffix == "%" else "edge" if suffix else "absolute"
        return cls(float(amount), unit)

    def resolve(self, *, diagonal: float, mean_edge: Callable[[], float]) -> float:
        """The length in mesh units on a mesh of that bounding-box diagonal; `mean_edge` is only called when it is needed."""
        if self.unit == "percent":
            return self.amount / 100.0 * diagonal
        if self.unit == "edge":
            return self.amount * mean_edge()
        return self.amount

    def __str__(self) -> str:
        return f"{self.amount!r}{_LENGTH_SUFFIX[self.unit]}"
