"""The results of a run: kept as JSON, ratios, how times grow with size, and what has fallen since the run before."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from .contest import Contest
from .measurement import OURS, Block, Timing

#: A ratio below this share of that of the saved run has fallen; smaller changes are noise.
FALLEN = 0.85


@dataclass
class Run:
    """A run of the benchmark.

    Attributes:
        machine: in a line.
        date: on which it ended.
        versions: of the libraries, by name.
        bandwidth: bytes a second of the triad on all threads.
        threads: of our kernels.
        blocks: what was measured.
    """

    machine: str
    date: str
    versions: dict[str, str]
    bandwidth: float
    threads: int
    blocks: list[Block] = field(default_factory=list)

    def saved(self, path: Path) -> None:
        """Write it as JSON."""
        path.write_text(json.dumps(asdict(self), indent=1) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: Path) -> Run | None:
        """A saved run; None if there is none."""
        if not path.exists():
            return None
        told = json.loads(path.read_text("utf-8"))
        blocks = [Block(**{**b, "timings": {n: Timing(**t) for n, t in b["timings"].items()}}) for b in told.pop("blocks")]
        return cls(**told, blocks=blocks)

    @property
    def is_quiet(self) -> bool:
        """Whether every block was measured on a quiet machine."""
        return all(block.is_quiet for block in self.blocks)

    def block(self, contest: str, size: int, order: str) -> Block | None:
        """The block of a contest, if it was measured."""
        same = (b for b in self.blocks if (b.contest, b.size, b.order) == (contest, size, order))
        return next(same, None)

    def together_with(self, saved: Run | None) -> Run:
        """This run, and the blocks of a saved one that it has not measured again."""
        if saved is not None:
            kept = [b for b in saved.blocks if self.block(b.contest, b.size, b.order) is None]
            self.blocks += kept
        return self


def ratio(block: Block, peer: str, by: str = "seconds") -> float | None:
    """A peer's time over ours.

    Args:
        block: the measurement.
        peer: the name.
        by: "seconds" by the clock, or "processor".
    """
    ours, theirs = block.timings.get(OURS), block.timings.get(peer)
    if ours is None or theirs is None or ours.error or theirs.error:
        return None
    return float(getattr(theirs, by) / max(getattr(ours, by), 1e-9))


def fallen(block: Block, peer: str, saved: Run | None) -> float | None:
    """The saved ratio, if the new one is well below it by the clock and by processor time alike."""
    before = None if saved is None else saved.block(block.contest, block.size, block.order)
    if before is None:
        return None
    for by in ("seconds", "processor"):
        now, then = ratio(block, peer, by), ratio(before, peer, by)
        if now is None or then is None or now >= FALLEN * then:
            return None
    return ratio(before, peer)


def bandwidth_share(contest: Contest, block: Block, bandwidth: float) -> float | None:
    """The bytes that the operation must move at the least, over our time, as a share of the measured bandwidth."""
    ours = block.timings.get(OURS)
    if contest.traffic is None or ours is None or ours.error:
        return None
    return contest.traffic * block.size / ours.seconds / bandwidth


def slope(run: Run, contest: Contest, order: str, by: str = "seconds") -> float | None:
    """The exponent with which our time grows with the size, by least squares; None for fewer than two sizes."""
    points = []
    for size in contest.sizes:
        block = run.block(contest.name, size, order)
        if block is not None and not block.timings[OURS].error:
            points.append((np.log(size), np.log(getattr(block.timings[OURS], by))))
    if len(points) < 2:
        return None
    x, y = np.array(points).T
    return float(np.polyfit(x, y, 1)[0])
