"""How often the parts of a scene are placed, before anybody places them: ten lines that each place the one before ten times make
ten thousand million of one triangle.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from .errors import ContentsError

#: placements, and faces of all of them together, of one file
MOST_PLACED, MOST_FACES = 1_000_000, 100_000_000
_DEEPEST = 200
#: what MeshLab's readers do not look at
MIRRORED = (
    "a part of it is placed as in a mirror, but MeshLab leaves its faces as they are: if they point inwards, turn them with "
    "'Invert Faces Orientation'"
)


def mirrors(matrix: NDArray[np.float64]) -> bool:
    """Whether a (3, 3) matrix turns a surface inside out."""
    largest = float(np.abs(matrix).max())
    return largest > 0.0 and float(np.linalg.det(matrix / largest)) < 0.0


def check_instances(
    parts: Mapping[Hashable, Sequence[Hashable]], faces: Mapping[Hashable, int], roots: Iterable[Hashable]
) -> None:
    """Refuse a scene that holds itself, or too much.

    Args:
        parts: what each part places, one entry a placement; names that are none of a part count as nothing.
        faces: how many faces a part has itself.
        roots: the parts that the scene places.

    Raises:
        ContentsError: it does.
    """
    sizes: dict[Hashable, tuple[int, int]] = {}
    placed = total = 0
    for root in roots:
        own = _size(root, parts, faces, sizes)
        placed, total = placed + own[0], total + own[1]
    check_placed(placed, total)


def check_placed(placed: int, faces: int) -> None:
    """Refuse too many placements, or faces of all of them.

    Raises:
        ContentsError: they are.
    """
    if placed > MOST_PLACED or faces > MOST_FACES:
        raise ContentsError(
            f"it places {placed:,} parts with {faces:,} faces; {MOST_PLACED:,} and {MOST_FACES:,} are the most",
        )


def _size(
    root: Hashable,
    parts: Mapping[Hashable, Sequence[Hashable]],
    faces: Mapping[Hashable, int],
    sizes: dict[Hashable, tuple[int, int]],
) -> tuple[int, int]:
    """How many parts and faces one part places, itself included; kept in `sizes`."""
    path, open_parts = [root], {root}
    while path:
        part = path[-1]
        missing = next((p for p in parts.get(part, ()) if p not in sizes and p in parts), None)
        if missing is None:
            found = [sizes[p] for p in parts.get(part, ()) if p in sizes]
            sizes[part] = 1 + sum(n for n, _ in found), faces.get(part, 0) + sum(m for _, m in found)
            open_parts.discard(path.pop())
            continue
        if missing in open_parts:
            raise ContentsError("a part of it is a part of itself")
        if len(path) == _DEEPEST:
            raise ContentsError(f"its parts are more than {_DEEPEST} levels deep")
        path.append(missing)
        open_parts.add(missing)
    return sizes[root]
