"""A run from the checks to the files in their places; the work between them is done in one piece by a worker, or by tiles."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import TypeAlias

from ..files.inputs import check_input
from ..files.output_lock import output_lock
from ..files.outputs import check_maps, check_output
from ..files.provenance import formatted, provenance_path
from ..files.staging import clear_up, remove_folder, staging_folder
from ..files.writing import StagedFile, place, stage_file
from ..processes.order import Order
from ..processes.pool import Lender, Pool
from ..processes.process import Items
from ..processes.worker import report as report_event
from ..scripts.guards import refuse_unmeasured
from ..scripts.warnings import check_needs
from .errors import GuardBroken
from .interrupts import Interrupts
from .intervention import removed_path
from .job import Event, Job, RunResult
from .memory import default_memory
from .record import record_of, result_of
from .report import Report
from .watch import Watch

#: what a worker of a run imports before its first order comes
MODULES = ("pymeshfair.running.session",)
#: does the work of a run: is given the job, the staging folder, what takes signals, and what to call with each event
Work: TypeAlias = "Callable[[Job, Path, Items, Callable[[Event], None]], Report]"


def workers_of_runs(most: int = 1, threads: int | None = None, *, rest_after: float | None = None) -> Pool:
    """Processes for `run_job`, see `pymeshfair.processes.pool.Pool`."""
    return Pool(most, threads, MODULES, rest_after=rest_after)


def run_job(
    job: Job,
    on_event: Callable[[Event], None] = lambda event: None,
    *,
    workers: Lender | None = None,
    work: Work | None = None,
    also: Callable[[RunResult], Sequence[StagedFile]] | None = None,
) -> RunResult:
    """Carry out a job: everything is checked, the work is done, and the files appear whole or not at all.

    Args:
        job: what to do.
        on_event: called with each event, in this thread. An exception that it raises stops the run and is passed on.
        workers: lends the process that does the work; None starts one.
        work: does the work otherwise.
        also: makes further files, which appear with the output or not at all. It is given the result while the output, its side
            files and its provenance are still in the staging folder, all in one.

    Raises:
        ScriptError: a step needs layers or rasters that the run does not have.
        ParameterError: there are limits, but no measures are to be taken; or one has a unit, and that of the scan is not known.
        InputError: the input, or another file, cannot be read.
        OutputError: the output cannot or must not be written.
        StepFailedError: a filter could not do its work.
        WorkerDied: the worker process crashed or was killed.
        GuardBroken: the result goes beyond a limit.
        RunTimeout, OutOfMemory: the run needed more than it was given.
        KeyboardInterrupt: Ctrl-C, within a second, after everything has been cleaned up.
    """
    started, clock = datetime.now(timezone.utc), time.monotonic()
    others = tuple(Path(other).absolute() for other in job.others)
    job = replace(job, input=Path(job.input).absolute(), output=Path(job.output).absolute(), others=others)
    check_needs(job.recipe.script, layers=1 + len(others))
    job.check_unit()
    if not job.measures:
        refuse_unmeasured(job.all_guards)
    for path in (job.input, *others):
        check_input(path)
    if job.map is not None:
        job = replace(job, map=Path(job.map).absolute())
    _check_outputs(job)
    items: Items = SimpleQueue()
    with (
        Interrupts(items) as interrupts,
        output_lock(job.output),
        staging_folder(job.output) as stage,
        nullcontext(workers) if workers else workers_of_runs(1, job.threads) as pool,
    ):
        report = (work or partial(_in_one_piece, pool, clock))(job, stage, items, on_event)
        interrupts.check()
        seconds = time.monotonic() - clock
        if report.output is None:
            _check_outputs(job)  # again, as files may have come meanwhile
            place(report.maps, stage)
            raise GuardBroken(report.breaches, [file.target for file in report.maps])
        record = record_of(job, report, started=started, seconds=seconds)
        provenance = stage_file(stage / "provenance.json", provenance_path(job.output), formatted(record))
        output, *side_files = report.staged
        more: Sequence[StagedFile] = ()
        if also is not None:
            staged = result_of(job, record, [file.staged for file in side_files], [file.staged for file in report.maps])
            with interrupts.lifted():
                more = also(replace(staged, output=output.staged, provenance=provenance.staged))
        interrupts.check()
        _check_outputs(job)
        place([*side_files, *report.maps, *more, output, provenance], stage, outdated=provenance.target)
        remove_folder(stage)  # while the worker lives, which removes it if this process is killed meanwhile
    return result_of(job, record, [file.target for file in side_files], [file.target for file in report.maps])


def _check_outputs(job: Job) -> None:
    """Refuse files that cannot or must not be written."""
    check_output(job.output, job.made_from, overwrite=job.overwrite)
    if job.map is not None:
        check_maps((job.map, removed_path(job.map)), job.output, job.made_from, overwrite=job.overwrite)


def _in_one_piece(pool: Lender, started: float, job: Job, stage: Path, items: Items, on_event: Callable[[Event], None]) -> Report:
    """Let one process do the work."""
    limit = default_memory() if job.memory_limit is None else job.memory_limit
    if_lost = partial(clear_up, stage, job.output)
    with pool.lend() as worker:
        worker.give(Order.of(carry_out, job, stage, memory_limit=limit, if_lost=if_lost), items)
        return Watch(job, worker, items, on_event).until_done(started)


def carry_out(job: Job, stage: Path) -> Report:
    """The work of a run, in the process that does it."""
    from .session import Session

    return Session(job, stage, report_event).run()
