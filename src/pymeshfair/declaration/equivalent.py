"""A filter of MeshLab's that does what a plugin's filter does with some of its values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Equivalent:
    """A filter of MeshLab's, with the values by which it gives the same result, to rounding.

    Attributes:
        filter: its Python name.
        values: by Python parameter name.
        closed_only: the results are the same on closed meshes without a selection alone.
    """

    filter: str
    values: Mapping[str, Any]
    closed_only: bool = False
