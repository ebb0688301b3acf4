"""Lengths with a unit, such as 0.05mm, and the unit of a scan, without which they mean nothing."""

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
                f"{self} would be {readings}, and neither the file nor the recipe says which it is: say it by --unit "
                f"{'|'.join(METRES)} (unit= in Python), or give the length without a unit, as a number of the scan's own units"
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


def unit_of_scan(typed: str | None, of_file: str | None, of_recipe: str = "") -> str | None:
    """The unit of a scan: the one that the user typed, else that of its file, else that of the recipe's head; None without any.

    Raises:
        ParameterError: `typed` is none of `METRES`.
    """
    if typed is not None:
        return check_unit(typed)
    return of_file if of_file in METRES else of_recipe or None


def check_unit(unit: str) -> str:
    """The unit of a scan, or raise `ParameterError` if there is no such one."""
    if unit not in METRES:
        raise ParameterError(f"{unit!r} is no unit of scans: it is one of {', '.join(METRES)}")
    return unit
