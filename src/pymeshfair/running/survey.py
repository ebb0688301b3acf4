"""What `info` and `suggest` know of a scan besides its measures: its box, its rims, and what recipes ask of it."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from typing import Any

from ..filters.mesh import bounding_box
from .measuring import Found
from .messages import Assignment
from .plain_values import plain
from .suitability import traits_asked_for


def survey(assignment: Assignment, found: Found, attributes: AbstractSet[str]) -> dict[str, Any]:
    """Box, rims and traits of a mesh, in terms of JSON; nothing if the assignment does not ask."""
    if not assignment.traits:
        return {}
    from ..filters.holes import find_rims

    vertices, faces = found.mesh.vertices, found.mesh.faces
    traits, _ = traits_asked_for(assignment, found, attributes)
    return {
        "box": [plain(end.tolist()) for end in bounding_box(vertices)] if len(vertices) else [],
        "rims": [
            {"edges": rim.edges, "length": rim.length, "middle": plain(rim.middle.tolist()), "outer": rim.outer}
            for rim in (find_rims(vertices, faces) if len(faces) else [])
        ],
        "traits": plain(traits),
    }
