"""Lengths with a unit, such as 0.05mm, which mean nothing until the unit of the scan is known: mesh files do not say theirs."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from ..errors import ParameterError
from .length import Length

#: the units that a scan may be in, in metres
METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}
_SUFFIX = re.compile(rf"(.*?)\s*(?<![a-z])({'|'.join(METRES)})", re.DOTALL)


@dataclass(frozen=True)
class PhysicalLength:
    """A length in one of the units of `METRES`.

    Attributes:
        amount: how many.
        unit: of them.
    """

    amount: float
    unit: str

    def in_mesh_units(self, unit: str | None) -> Length:
        """The length on a scan in that unit.

        Raises:
            ParameterError: it is not known; the message has the readings and the way out.
        """
        if unit is None:
            amounts = {name: self.in_mesh_units(name).amount for name in (self.unit, "mm", "m")}
            readings = " and ".join(f"{amount:.6g} on a scan in {name}" for name, amount in amounts.items())
            raise ParameterError(
                f"{self} would be {readings}, and mesh files do not say which they are: say it by --unit {'|'.join(METRES)} "
                f"(unit= in Python), or give the length without a unit, as a number of the scan's own units"
            )
        return Length(self.amount * METRES[self.unit] / METRES[check_unit(unit)])

    def resolve(self, *, diagonal: float, mean_edge: Callable[[], float]) -> float:
        """As `Length.resolve`, which needs the scan's unit here, and so raises `ParameterError`."""
        return self.in_mesh_units(None).resolve(diagonal=diagonal, mean_edge=mean_edge)

    def __str__(self) -> str:
        return f"{self.amount!r}{self.unit}"


def parse_length(text: str) -> Length | PhysicalLength:
    """Read a length as `Length.parse` does, or one with a unit; raise `ParameterError` for anything else."""
    match = _SUFFIX.fullmatch(text.strip())
    return Length.parse(text) if match is None else PhysicalLength(Length.parse(match[1]).amount, match[2])


def check_unit(unit: str) -> str:
    """The unit of a scan, or raise `ParameterError` if there is no such one."""
    if unit not in METRES:
        raise ParameterError(f"{unit!r} is no unit of scans: it is one of {', '.join(METRES)}")
    return unit
