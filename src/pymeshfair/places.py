"""Places, counts, the unit of distances and folders in messages."""

import os
import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any


def point_text(point: Iterable[float]) -> str:
    """The coordinates of a point, with 6 significant digits; from 1000 on with 9, as nearby points differ in the last digits."""
    return ", ".join(f"{c:.{6 if abs(c) < 1000.0 else 9}g}" for c in point)


def counted(count: int, one: str, several: str = "") -> str:
    """A count with its noun, such as ``1 step`` or ``1,200 steps``."""
    return f"{count:,} {one if count == 1 else several or one + 's'}"


def distance_unit(area_change: float | None) -> str:
    """Names the unit of displacements: mean edges of a mesh, or mean spacings of a cloud, which has no area to change."""
    return "spacings" if area_change is None else "edges"


def without_folders(value: Any, folders: Collection[Path]) -> Any:
    """A text, or a document with texts, without these folders before names: pages are sent to others."""
    if isinstance(value, Mapping):
        return {name: without_folders(part, folders) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [without_folders(part, folders) for part in value]
    for folder in folders if isinstance(value, str) else ():  # also in an argument such as -o/tmp/out.ply
        value = re.sub(rf"(?:(?<!\w)|(?<=^-\w)){re.escape(f'{folder}{os.sep}')}", "", value) if folder.name else value
    return value
