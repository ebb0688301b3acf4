"""Which filters of a mesh can be done by tiles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def why_not(filter: str, values: Mapping[str, Any]) -> str | None:
    """Why a step cannot be done by tiles, or None if it can.

    Args:
        filter: its Python name.
        values: of all its parameters.
    """
    return "needs all of the mesh at once, or has not been cut into tiles yet"
