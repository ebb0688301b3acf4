"""The energy that a part of a surface is to have the least of."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pymeshfair.declaration import Enum
from pymeshfair.filters.fairing import ENERGIES, Energy

FairingEnergy: TypeAlias = Annotated[
    Energy,
    Enum(
        label="Energy",
        choices=ENERGIES,
        help="'membrane' spans it like a soap film, and meets its surroundings with a crease; 'thin_plate' bends least and "
        "continues their tangent planes; 'minimum_variation' continues their curvatures too, so that what is round stays round.",
    ),
]
