"""Measures one block: a contest on one subject, ours and the peers in turn, in a process of its own."""

from __future__ import annotations

import multiprocessing
import statistics
import time
from dataclasses import asdict, dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from . import machine
from .contest import Contest, Floats, Preparation, Subject
from .every import CONTESTS
from .subjects import loaded_subject

OURS = "ours"
#: A contestant gets no further round once its rounds have taken so many seconds.
PATIENCE = 5.0
#: Calls of fewer seconds follow one of the same that does not count: else the threads of whoever comes first have gone to sleep
#: while the others worked, and those of whoever makes its mesh on all threads before the clock starts have not.
BRIEF = 0.02
#: Seconds after which a block is given up.
_LIMIT = 900.0


@dataclass
class Timing:
    """How one contestant did.

    Attributes:
        seconds: the median by the clock.
        processor: the median of processor time on all cores.
        least: the least by the clock.
        rounds: how many there were.
        megabytes: the most memory of a call over what the process had before, None where the system does not tell.
        apart: how far the result is from ours, as a share of its range; None where it is not the same.
        error: why there is no time.
    """

    seconds: float = 0.0
    processor: float = 0.0
    least: float = 0.0
    rounds: int = 0
    megabytes: float | None = None
    apart: float | None = None
    error: str = ""


@dataclass
class Block:
    """The measurement of a contest on one subject.

    Attributes:
        contest: its name.
        size: the number of vertices, as asked for.
        order: of the vertices.
        load_before: processors that others kept busy before it.
        load_during: and meanwhile.
        timings: by contestant.
    """

    contest: str
    size: int
    order: str
    load_before: float
    load_during: float = 0.0
    timings: dict[str, Timing] = field(default_factory=dict)

    @property
    def is_quiet(self) -> bool:
        """Whether nothing else kept the machine busy."""
        return max(self.load_before, self.load_during) <= machine.QUIET


def measured(contest: Contest, size: int, order: str, path: Path, small: Path, rounds: int) -> Block:
    """A block, in a fresh process; a contestant that kills it costs the block.

    Args:
        contest: what is measured.
        size: of the subject.
        order: of its vertices.
        path: its file.
        small: the file of a small one, on which everybody compiles and loads.
        rounds: that count.
    """
    block = Block(contest.name, size, order, machine.load_of_others())
    receiving, sending = multiprocessing.Pipe(duplex=False)
    child = multiprocessing.get_context("spawn").Process(
        target=_in_child, args=(contest.name, size, path, small, rounds, sending)
    )
    busy, start = machine.busy_seconds(), time.perf_counter()
    child.start()
    sending.close()
    try:
        if not receiving.poll(_LIMIT):
            raise EOFError
        answer = receiving.recv()
    except EOFError:
        child.kill()
        answer = {OURS: asdict(Timing(error="the process died, or took too long"))}, 0.0
    child.join()
    timings, own = answer
    after = machine.busy_seconds()
    if busy is not None and after is not None:
        block.load_during = max(0.0, (after - busy - own) / (time.perf_counter() - start))
    block.timings = {name: Timing(**timing) for name, timing in timings.items()}
    return block


def _in_child(name: str, size: int, path: Path, small: Path, rounds: int, answer: Connection) -> None:
    timings = turns(CONTESTS[name], size, loaded_subject(path), loaded_subject(small), rounds)
    answer.send(({name: asdict(timing) for name, timing in timings.items()}, time.process_time()))


def turns(contest: Contest, size: int, subject: Subject, small: Subject, rounds: int) -> dict[str, Timing]:
    """Each contestant in turn, round by round; the first round measures memory and does not count unless it takes long."""
    ways: dict[str, Preparation] = {OURS: contest.ours}
    timings: dict[str, Timing] = {OURS: Timing()}
    for name, peer in contest.peers.items():
        if size <= peer.largest:
            timings[name] = Timing() if peer.is_installed() else Timing(error=f"{peer.needs} is not installed")
            if peer.is_installed():
                ways[name] = peer.prepare
    taken: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    result: Floats | None = None
    for done in range(rounds + 1):
        for name, prepare in list(ways.items()):
            spent = sum(seconds for seconds, _ in taken[name])
            if spent > PATIENCE:
                continue
            try:
                if done == 0:
                    prepare(small)()
                if done > 0 and taken[name][0][0] < BRIEF:
                    prepare(subject)()
                work = prepare(subject)
                base = machine.start_of_peak() if done == 0 else 0.0
                start, used = time.perf_counter(), time.process_time()
                found = work()
                taken[name].append((time.perf_counter() - start, time.process_time() - used))
                if done == 0:
                    timings[name].megabytes = _number(machine.peak() - base)
                    result, timings[name].apart = _compared(contest, name, found, result)
                del found, work
            except Exception as error:  # a peer's failure is told, and the others go on
                timings[name].error = f"{type(error).__name__}: {error}"[:200]
                del ways[name]
    for name in ways:
        counted = taken[name][1:] if len(taken[name]) > 1 else taken[name]
        clock, processor = [seconds for seconds, _ in counted], [used for _, used in counted]
        timing = timings[name]
        timing.seconds, timing.processor = statistics.median(clock), statistics.median(processor)
        timing.least, timing.rounds = min(clock), len(counted)
    return timings


def _number(value: float) -> float | None:
    return None if np.isnan(value) else max(0.0, value)


def _compared(contest: Contest, name: str, found: Any, ours: Floats | None) -> tuple[Floats | None, float | None]:
    """Our result, and how far a peer's is from it."""
    if name == OURS:
        return (contest.result(found) if any(p.agrees is not None for p in contest.peers.values()) else None), None
    if contest.peers[name].agrees is None or ours is None:
        return ours, None
    return ours, difference(ours, contest.result(found))


def difference(ours: Floats, theirs: Floats) -> float:
    """The largest difference, as a share of the range of the values."""
    return float(np.abs(ours - theirs).max() / np.ptp(ours))
