"""Who does the tasks of a batch, and the threads of this process as those who do."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Protocol, TypeAlias

from ..processes.process import Items
from ..running.job import Job
from .drawing import page_path
from .plan import Scan
from .station import Station

#: what is done with a scan: it is cleaned, or its page is drawn
Kind: TypeAlias = Literal["clean", "draw"]


class Workers(Protocol):
    """Do tasks; ``(kind, (scan, result))`` is put into a queue when one has ended, where the result is a function that gives it.

    That raises `LostSchedulerError`, or `ClusterError` where the workers were lost that did it.
    """

    def submit(self, kind: Kind, scan: Scan) -> None:
        """Do a task when those before it are done or under way."""

    def give_up(self) -> None:
        """End what is under way, and begin nothing more."""

    def look(self) -> str | None:
        """What should be said of the workers.

        Raises:
            LostSchedulerError: none of them can be asked any more.
        """


class ThisMachine:
    """Threads of this process with a station; see `Workers`. A context manager that ends them."""

    def __init__(self, template: Job, folder: Path, slots: int, items: Items) -> None:
        """See the class; `slots` tasks are done at a time."""
        self._station = Station(template, slots)
        self._folder = folder
        self._items = items
        self._threads = ThreadPoolExecutor(slots)
        self._keys: set[str] = set()

    def __enter__(self) -> ThisMachine:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.give_up()
        self._station.close()

    def submit(self, kind: Kind, scan: Scan) -> None:
        """See `Workers`."""
        key = f"{kind}-{scan.number}"
        self._keys.add(key)
        future = self._threads.submit(do_task, self._station, kind, scan, self._folder, key)
        result: Callable[[], Any] = future.result
        future.add_done_callback(lambda done: None if done.cancelled() else self._items.put((kind, (scan, result))))

    def give_up(self) -> None:
        """See `Workers`; returns when all has been cleared up."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for key in self._keys:
            self._station.cancel(key)
        self._threads.shutdown()

    def look(self) -> str | None:
        """See `Workers`."""
        return None


def do_task(station: Station, kind: Kind, scan: Scan, folder: Path, key: str) -> Any:
    """Do a task at a station: an `Outcome`, or what `pymeshfair.batch.drawing.draw` gives."""
    if kind == "clean":
        return station.clean(key, scan)
    return station.draw(key, scan, page_path(folder, scan.output))
