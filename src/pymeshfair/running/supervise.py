"""Runs a job in a worker process, and puts its output in place when all went well."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from ..files.inputs import check_input
from ..files.output_lock import output_lock
from ..files.outputs import check_maps, check_output
from ..files.provenance import formatted, provenance_path
from ..files.staging import remove_folder, staging_folder
from ..files.writing import StagedFile, place, stage_file
from ..scripts.guards import refuse_unmeasured
from ..scripts.needs import check_needs
from .child import WorkerProcess
from .errors import GuardBroken
from .interrupts import Interrupts
from .intervention import removed_path
from .job import Event, Job, RunResult
from .messages import Assignment
from .record import record_of, result_of
from .started import Start
from .watch import Watch


def run_job(
    job: Job,
    on_event: Callable[[Event], None] = lambda event: None,
    *,
    start: Start | None = None,
    also: Callable[[RunResult], Sequence[StagedFile]] | None = None,
) -> RunResult:
    """Carry out a job: everything is checked, the worker runs, and the files appear whole or not at all.

    Args:
        job: what to do.
        on_event: called with each event, in this thread. An exception that it raises stops the run and is passed on.
        start: what starts the worker's process; None starts a fresh one.
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
    limits = job.all_guards
    if not job.measures:
        refuse_unmeasured(limits)
    for path in (job.input, *others):
        check_input(path)
    if job.map is not None:
        job = replace(job, map=Path(job.map).absolute())
    _check_outputs(job)
    queue: SimpleQueue[tuple[str, Any]] = SimpleQueue()
    with (
        Interrupts(queue) as interrupts,
        output_lock(job.output),
        staging_folder(job.output) as stage,
        WorkerProcess(Assignment.of(job, stage).to_document(), queue, threads=job.threads, start=start) as worker,
    ):
        watch = Watch(job, worker, queue, on_event)
        report = watch.until_done(clock)
        interrupts.check()
        seconds = time.monotonic() - clock
        maps = [StagedFile(Path(f["staged"]), Path(f["target"])) for f in report.get("maps", ())]
        if "staged" not in report:
            _check_outputs(job)  # again, as files may have come meanwhile
            place(maps, stage)
            raise GuardBroken(report["breaches"], [file.target for file in maps])
        record = record_of(job, report, watch.said, watch.warned, started=started, seconds=seconds)
        provenance = stage_file(stage / "provenance.json", provenance_path(job.output), formatted(record))
        output, *side_files = (StagedFile(Path(f["staged"]), Path(f["target"])) for f in report["staged"])
        more: Sequence[StagedFile] = ()
        if also is not None:
            staged = result_of(job, record, [file.staged for file in side_files], [file.staged for file in maps])
            with interrupts.lifted():
                more = also(replace(staged, output=output.staged, provenance=provenance.staged))
        interrupts.check()
        _check_outputs(job)
        place([*side_files, *maps, *more, output, provenance], stage, outdated=provenance.target)
        remove_folder(stage)  # while the worker lives, which removes it if this process is killed meanwhile
    result = result_of(job, record, [file.target for file in side_files], [file.target for file in maps])
    return replace(result, displacement=report.get("displacement"))


def _check_outputs(job: Job) -> None:
    """Refuse files that cannot or must not be written."""
    check_output(job.output, job.made_from, overwrite=job.overwrite)
    if job.map is not None:
        check_maps((job.map, removed_path(job.map)), job.output, job.made_from, overwrite=job.overwrite)
