"""All contests, by name."""

from __future__ import annotations

from . import explicit, matrices, points, regions
from .contest import Contest

CONTESTS: dict[str, Contest] = {
    contest.name: contest for room in (explicit, matrices, regions, points) for contest in room.CONTESTS
}
