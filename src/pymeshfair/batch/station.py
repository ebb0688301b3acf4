"""A batch on one worker of dask: it cleans scans there, each in a process of its own that is forked from one kept ready."""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from distributed import Reschedule, Worker, WorkerPlugin, get_worker

from ..files.errors import OutputBusyError
from ..operating_system import this_system
from ..running.forks import ForkServer
from ..running.job import Job, RunResult
from ..running.memory import default_memory
from ..running.started import RUN, Started
from ..running.supervise import run_job
from .drawing import MODULE as DRAWING
from .drawing import draw
from .fitness import unfit_for
from .outcome import Outcome
from .settings import Settings

#: seconds to wait for another run of the same output: of a lost worker, which may still be clearing up
_PATIENCE = 20.0
#: seconds without work after which the process is ended that others are forked from
_IDLE = 120.0


class Station(WorkerPlugin):
    """What every worker keeps while a batch lasts; dask sends it to workers that come later, too."""

    def __init__(self, batch: str, asked: Mapping[str, Any]) -> None:
        """See the class.

        Args:
            batch: the name of the batch, with which the names of its tasks begin.
            asked: of `pymeshfair.batch.fitness.probe`.
        """
        self.name = batch
        self._asked = asked

    def setup(self, worker: Worker) -> None:
        """Called by dask on every worker. One that came late and is not fit leaves again."""
        self.unfit = unfit_for(self._asked)
        if self.unfit:
            logging.getLogger(__name__).error("this worker cannot take part in the batch: %s", "; ".join(self.unfit))
            worker.loop.add_callback(worker.close, reason="pymeshfair-batch-unfit")
            return
        self._settings = Settings.from_document(self._asked["settings"])
        self._host = socket.gethostname()
        processors, slots = this_system().processors(), worker.state.nthreads
        self._threads = max(1, processors // slots)
        memory = default_memory()
        self._memory = None if memory is None else memory // slots
        self._lock = threading.Lock()
        self._server: ForkServer | None = None
        self._at_work = 0
        self._idle: threading.Timer | None = None
        self._processes: dict[str, Started] = {}
        self._cancelled: set[str] = set()
        self._warm_up()

    def teardown(self, worker: Worker) -> None:
        """Called by dask when the batch or the worker ends."""
        if not self.unfit:
            for key in list(self._processes):
                self._cancel(key)
            self._end_server()

    def transition(self, key: Any, start: str, finish: str, **more: Any) -> None:
        """Called by dask for every task: one that is not wanted any more is ended, also when the batch itself was killed."""
        if (start, finish) == ("executing", "released") and not self.unfit and str(key).startswith(self.name):
            self._cancel(str(key))

    def clean(self, key: str, scan: Mapping[str, Any]) -> Outcome:
        """Clean one scan in this thread."""
        started = time.monotonic()
        input, output = Path(scan["input"]), Path(scan["output"])
        self._begin()
        try:
            job = self._settings.job(input, output, scan["overrides"], threads=self._threads, memory=self._memory)
            result = self._run(key, job)
            return Outcome.of_result(job, result, self._host)
        except Exception as error:
            return Outcome.of_error(input, output, error, time.monotonic() - started, self._host)
        finally:
            self._end()

    def draw(self, key: str, scan: Mapping[str, Any]) -> dict[str, Any]:
        """Make the page of one scan in this thread; see `pymeshfair.batch.drawing.draw`. ``"problem"`` says why there is none."""
        memory = self._memory if self._settings.memory is None else self._settings.memory
        input, output, page = (Path(scan[name]) for name in ("input", "output", "page"))
        self._begin()
        try:
            overwrite = self._settings.overwrite
            return draw(input, output, page, memory=memory, overwrite=overwrite, start=lambda: self._start(key, DRAWING))
        except Exception as error:
            return {"problem": str(error)}
        finally:
            self._processes.pop(key, None)
            self._end()

    def _run(self, key: str, job: Job) -> RunResult:
        self._ready_server()  # the scan's own time begins after that
        deadline = time.monotonic() + _PATIENCE
        job.output.parent.mkdir(parents=True, exist_ok=True)
        while True:
            try:
                return run_job(job, start=lambda: self._start(key))
            except OutputBusyError:  # noqa: PERF203
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.2)
            finally:
                self._processes.pop(key, None)

    def _start(self, key: str, module: str = RUN) -> Started:
        process = self._ready_server().start(module)
        self._processes[key] = process
        if key in self._cancelled:
            process.kill()
        return process

    def _cancel(self, key: str) -> None:
        self._cancelled.add(key)
        if process := self._processes.get(key):
            process.kill()

    # ------------------------------------------------------------------------------------------------- the process kept ready

    def _warm_up(self) -> None:
        with self._lock:
            self._server = ForkServer(self._threads)
            self._rest()

    def _ready_server(self) -> ForkServer:
        with self._lock:
            if self._server is None:
                self._server = ForkServer(self._threads)
            server = self._server
        server.prepare()
        return server

    @property
    def is_at_work(self) -> bool:
        """Whether any scan is under way here."""
        return not self.unfit and self._at_work > 0

    def _begin(self) -> None:
        with self._lock:
            self._at_work += 1
            if self._idle is not None:
                self._idle.cancel()

    def _end(self) -> None:
        with self._lock:
            self._at_work -= 1
            if not self._at_work:
                self._rest()

    def _rest(self) -> None:
        self._idle = threading.Timer(_IDLE, self._end_server, kwargs={"idle": True})
        self._idle.daemon = True
        self._idle.start()

    def _end_server(self, *, idle: bool = False) -> None:
        with self._lock:
            if idle and self._at_work:
                return
            if self._idle is not None:
                self._idle.cancel()
            if self._server is not None:
                self._server.close()
                self._server = None


def clean(batch: str, scan: Mapping[str, Any]) -> Outcome:
    """The task of one scan, on whichever worker dask gives it to."""
    station, key = _here(batch)
    return station.clean(key, scan)


def draw_page(batch: str, scan: Mapping[str, Any]) -> dict[str, Any]:
    """The task of the page of one scan."""
    station, key = _here(batch)
    return station.draw(key, scan)


def _here(batch: str) -> tuple[Station, str]:
    """The station of this worker, and the name of the task."""
    worker = get_worker()
    station = cast("Station", worker.plugins[batch])
    if station.unfit:
        raise Reschedule
    return station, str(worker.get_current_task())
