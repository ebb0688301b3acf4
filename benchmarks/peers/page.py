"""docs/performance.md, written from a run."""

from __future__ import annotations

from collections.abc import Iterator

from .contest import ORDERS, Contest, Peer
from .every import CONTESTS
from .first_runs import first_runs
from .measurement import OURS, Block
from .results import Run, bandwidth_share, fallen, ratio, slope

_HEAD = """# Performance

How fast every operation is, compared with other libraries (peers). Written by `python benchmarks/all.py`; the figures are in
`benchmarks/all.json`.

{machine}. {date}. {threads} threads; the memory of the machine moves {bandwidth:.0f} GB/s (triad).

{load}

Ratios are the time of the peer over ours by the clock, medians of alternating rounds in one process; **in bold** if the peer is
faster. In brackets the ratio of processor time: if it is smaller, we use more cores. Times are of calls on arrays in memory: ours
from vertices and faces to the result, the peer's from a mesh that it has already loaded. Before a call of less than 20 ms comes
one that does not count. "Scan" is the order in which subdivision leaves a mesh, and for points row by row; in "random" order
neighbours lie anywhere in memory.

![Seconds against vertices](pictures/performance.svg)
"""
_OURS = """Seconds by the clock and of processor time; megabytes above those before the call; the share of the triad's bandwidth
that the necessary reading and writing takes; and the exponent of the growth of time in scan order.

| operation | vertices | order | seconds | processor | MB | best peer's MB | bandwidth | growth |
|---|---:|---|---:|---:|---:|---:|---:|---:|"""


def page(run: Run, saved: Run | None) -> str:
    """The page.

    Args:
        run: what to show.
        saved: the run before, for ratios that fell; None if there is none.
    """
    loads = [block.load_during for block in run.blocks]
    noisy = dict.fromkeys(block.contest for block in run.blocks if not block.is_quiet)
    load = (
        "The machine was quiet: nothing else took more than half a core before or during any block."
        if run.is_quiet
        else f"**The machine was not quiet**: other work took up to {max(loads, default=0.0):.1f} cores "
        f"during {'; '.join(noisy)}. Take the ratios of processor time there; those of the clock are disturbed, and seconds are "
        "too long."
    )
    head = _HEAD.format(machine=run.machine, date=run.date, threads=run.threads, bandwidth=run.bandwidth / 1e9, load=load)
    parts = [head, "## Ratios\n", *_ratios(run, saved), "\n## Ours\n", *_ours(run)]
    parts += ["\n## Where a peer is faster\n", *_behind(run), "\n## What bounds each operation\n", *_bounds(run)]
    parts += first_runs()
    return "\n".join([*parts, "\n## Versions\n", _versions(run)]) + "\n"


def _measured(run: Run) -> Iterator[Contest]:
    names = {block.contest for block in run.blocks}
    yield from (contest for name, contest in CONTESTS.items() if name in names)


def _columns(run: Run) -> list[tuple[int, str]]:
    found = {(block.size, block.order) for block in run.blocks}
    return sorted(found, key=lambda column: (ORDERS.index(column[1]), column[0]))


def _ratios(run: Run, saved: Run | None) -> Iterator[str]:
    columns = _columns(run)
    yield "| operation | peer | " + " | ".join(f"{_short(size)}, {order}" for size, order in columns) + " | goal |"
    yield "|---|---|" + "---|" * len(columns) + "---:|"
    for contest in _measured(run):
        for name, peer in contest.peers.items():
            cells = [_ratio(run.block(contest.name, size, order), name, saved) for size, order in columns]
            yield f"| {contest.name} | {name} | " + " | ".join(cells) + f" | {'' if peer.goal is None else f'{peer.goal:g}'} |"


def _ratio(block: Block | None, peer: str, saved: Run | None) -> str:
    if block is None or peer not in block.timings:
        return ""
    if block.timings[peer].error:
        return "failed" if "not installed" not in block.timings[peer].error else "not installed"
    clock, processor = ratio(block, peer), ratio(block, peer, "processor")
    if clock is None or processor is None:
        return ""
    before = fallen(block, peer, saved)
    text = f"{clock:.2g}" if clock < 10 else f"{clock:.0f}"
    return (f"**{text}**" if clock < 1 else text) + f" ({processor:.2g})" + (f" fell from {before:.2g}" if before else "")


def _ours(run: Run) -> Iterator[str]:
    yield _OURS
    for contest in _measured(run):
        measured = [run.block(contest.name, size, order) for size, order in _columns(run)]
        for block in (b for b in measured if b is not None):
            cells = [contest.name, _short(block.size), block.order, *_own(run, contest, block)]
            yield "| " + " | ".join(cells) + " |"


def _own(run: Run, contest: Contest, block: Block) -> list[str]:
    ours = block.timings[OURS]
    if ours.error:
        return [ours.error, "", "", "", "", ""]
    share = bandwidth_share(contest, block, run.bandwidth)
    growth = slope(run, contest, "scan") if block.order == "scan" and block.size == _largest_measured(run, contest) else None
    theirs = [t.megabytes for n, t in block.timings.items() if n != OURS and t.megabytes is not None and not t.error]
    return [
        f"{ours.seconds:.3g}",
        f"{ours.processor:.3g}",
        _whole(ours.megabytes),
        _whole(min(theirs, default=None)),
        "" if share is None else f"{share:.0%}",
        "" if growth is None else f"{growth:.2f}",
    ]


def _largest_measured(run: Run, contest: Contest) -> int:
    return max(block.size for block in run.blocks if block.contest == contest.name)


def _behind(run: Run) -> Iterator[str]:
    found = []
    for contest in _measured(run):
        for name in contest.peers:
            slower = [b for b in run.blocks if b.contest == contest.name and (ratio(b, name) or 1.0) < 1.0]
            where = ", ".join(f"{_short(b.size)} {b.order} {ratio(b, name):.2g}" for b in slower)
            if slower:
                found.append(f"* {contest.name}: {name} ({where})")
    yield from found or ["Nowhere in this run."]
    missed = list(_missed(run))
    if missed:
        yield "\nBelow the goal, on the largest mesh or cloud in scan order:\n"
        yield from missed


def _missed(run: Run) -> Iterator[str]:
    for contest in _measured(run):
        for name, peer in contest.peers.items():
            found = _largest(run, contest, name, peer)
            if found is not None and peer.goal is not None and found[1] < peer.goal:
                yield f"* {contest.name}, {name}: {found[1]:.2g} of {peer.goal:g} at {_short(found[0])}"


def _largest(run: Run, contest: Contest, name: str, peer: Peer) -> tuple[int, float] | None:
    for size in reversed(contest.sizes):
        block = run.block(contest.name, size, "scan")
        found = None if block is None else ratio(block, name)
        if found is not None:
            return size, found
    return None


def _bounds(run: Run) -> Iterator[str]:
    names: dict[str, list[str]] = {}
    for contest in _measured(run):
        names.setdefault(contest.bound, []).append(contest.name)
    yield from (f"* {'; '.join(of_these)}: {bound}" for bound, of_these in names.items())


def _versions(run: Run) -> str:
    return ", ".join(f"{name} {version}" for name, version in run.versions.items()) + "."


def _short(size: int) -> str:
    return f"{size // 1_000_000}M" if size % 1_000_000 == 0 else f"{size // 1000}k"


def _whole(megabytes: float | None) -> str:
    return "" if megabytes is None else f"{megabytes:.0f}"
