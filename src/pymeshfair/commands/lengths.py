"""Lengths that options give to commands that look at meshes, such as a tolerance, in mesh units."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from ..filters.inspection import Limits


def tolerance_in_mesh_units(text: str | None, unit: str | None, diagonal: float, mean_edge: float) -> float | None:
    """The length that ``--tolerance`` means; None if it is not given.

    Args:
        text: such as ``0.05``, ``0.1%``, ``0.5edge`` or ``0.05mm``.
        unit: the scan's, or None if it is not known.
        diagonal: of the first mesh.
        mean_edge: of the first mesh.

    Raises:
        ParameterError: it is no length, or has a unit and that of the scan is not known.
        typer.BadParameter: it is not above 0.
    """
    if text is None:
        return None
    length = _in_mesh_units(text, unit, diagonal, mean_edge)
    if not length > 0.0:
        raise typer.BadParameter(f"{text} is not above 0", param_hint="--tolerance")
    return length


def limits_in_mesh_units(text: str | None, unit: str | None, diagonal: float, mean_edge: float) -> Limits | None:
    """The two ends that ``--limits LOW,HIGH`` means; None if it is not given; see `tolerance_in_mesh_units`.

    Raises:
        ParameterError: see there.
        typer.BadParameter: it is not two lengths, the lower one first.
    """
    from ..filters.inspection import Limits

    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2:
        raise typer.BadParameter(f"{text} is not two lengths: write it as -0.1,0.1 or -0.1mm,0.1mm", param_hint="--limits")
    low, high = (_in_mesh_units(part, unit, diagonal, mean_edge) for part in parts)
    if not low < high:
        raise typer.BadParameter(f"{text}: the lower limit comes first", param_hint="--limits")
    return Limits(low, high)


def _in_mesh_units(text: str, unit: str | None, diagonal: float, mean_edge: float) -> float:
    from ..declaration.units import PhysicalLength, check_unit, parse_length

    if unit is not None:
        check_unit(unit)
    length = parse_length(text)
    if isinstance(length, PhysicalLength):
        length = length.in_mesh_units(unit)
    return length.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge)
