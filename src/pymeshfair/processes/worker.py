"""The worker process, which carries out orders: ``python -m pymeshfair.processes.worker MODULE...``.

It reads pickled orders from stdin, and writes pickled events and answers to the original stdout. It imports the modules while it
waits for the first order. Its parent process sends the orders; when the parent ends, the worker ends too, even during a task.
"""

from __future__ import annotations

import faulthandler
import importlib
import io
import os
import pickle
import platform
import re
import sys
import threading
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from queue import SimpleQueue
from typing import Any, BinaryIO

from ..errors import PymeshfairError
from ..filters.libraries import blas
from ..garbage import collect_seldom
from ..operating_system import this_system

_WORDS = "MemoryError|bad_alloc|out of memory|memory allocation|allocate memory|start new thread|map segment"
#: how Python and the libraries say that memory ran out; not beside a slash or before an extension, as in "memoryerror.ply"
_LACK = re.compile(rf"(?<![/\\])({_WORDS})(?![/\\]|\.\w)", re.I)
#: a quoted name with a slash or a dot, unlike 'std::bad_alloc'; a path from its first slash to its extension
_FILE = re.compile(r"""(['"])[^'"\n]*[/\\.][^'"\n]*\1|[/\\].*?\.\w+""")
#: the line on stderr after the last line of a task
END_OF_TALK = b"\npymeshfair-end-of-talk\n"


class DefectError(PymeshfairError):
    """A task raised an unexpected exception, which the message names; that is a defect of pymeshfair."""


@dataclass(frozen=True)
class Order:
    """A call of a function in another process."""

    call: bytes  # pickled: a function of a module or a method of a picklable object, and its arguments
    memory_limit: int | None = None  # the most bytes of memory that the process may use
    if_lost: bytes | None = None  # a pickled function that the worker calls if its parent ends

    @classmethod
    def of(
        cls, task: Callable[..., Any], *arguments: Any, memory_limit: int | None = None, if_lost: Callable[[], None] | None = None
    ) -> Order:
        return cls(pickle.dumps((task, arguments)), memory_limit, None if if_lost is None else pickle.dumps(if_lost))


@dataclass(frozen=True)
class Answer:
    """The result of a task."""

    result: Any = None
    #: the exception that it raised: a `PymeshfairError`, MemoryError, ImportError, OSError or `DefectError`
    error: Exception | None = None
    details: str = ""  # the traceback of the error
    process: str = ""  # the machine and the id of the process
    peak_memory: int | None = None  # during the task, in bytes; None if the system does not measure it
    is_used_up: bool = False  # see `use_up`


def answer(task: Callable[..., Any], *arguments: Any) -> Answer:
    """Does a task in this process, and measures its peak memory."""
    this_system().forget_peak_memory()
    result, error, details = None, None, ""
    try:
        result = task(*arguments)
    except Exception as raised:
        error, details = _sendable(raised), traceback.format_exc()
    return Answer(result, error, details, f"{platform.node()} {os.getpid()}", this_system().peak_memory())


def says_lack_of_memory(text: str) -> bool:
    """Returns whether a text says that memory ran out; names of files in it do not count."""
    return _LACK.search(_FILE.sub(" ", text)) is not None


def is_lack_of_memory(error: BaseException | None) -> bool:
    """Returns whether an exception or its cause says that memory ran out."""
    text = str((isinstance(error, OSError) and error.strerror) or error)  # without the name of a file
    is_lack = isinstance(error, MemoryError) or (not isinstance(error, PymeshfairError) and says_lack_of_memory(text))
    return error is not None and (is_lack or is_lack_of_memory(error.__cause__))


def _sendable(error: Exception) -> Exception:
    if is_lack_of_memory(error):
        return MemoryError("memory ran out")
    match error:
        case PymeshfairError():
            return error
        case ImportError():
            return ImportError(str(error))
        case OSError():
            return OSError(error.errno, error.strerror or str(error), error.filename)
    return DefectError(f"{type(error).__name__}: {error}")


class _Channel:
    """The channel from this worker to its parent; `reports` is None in a process that is no worker."""

    reports: io.BufferedWriter | None = None
    if_lost: bytes | None = None
    is_used_up = False


def report(event: Any) -> None:
    """Sends an event to the parent; does nothing in a process that is no worker."""
    if _Channel.reports is not None:
        with suppress(OSError):  # the parent has ended
            pickle.dump(("event", event), _Channel.reports)
            _Channel.reports.flush()


def use_up() -> None:
    """Marks this process as used up: the current task has left a state that changes the results of later tasks."""
    _Channel.is_used_up = True


def serve(modules: Sequence[str]) -> None:
    """Carries out the orders on stdin; imports `modules` while it waits for the first order."""
    collect_seldom()
    orders, reports = _take_over_streams()
    faulthandler.enable()
    _Channel.reports = reports
    inbox: SimpleQueue[Order] = SimpleQueue()
    threading.Thread(target=_receive, args=(orders, inbox), daemon=True).start()
    _prepare(modules, inbox)
    while True:
        order = inbox.get()
        if order.memory_limit is not None and order.memory_limit < 10**9:
            blas.dgemm  # noqa: B018 - loads OpenBLAS, which may hang if the limit refuses its first buffer
        this_system().limit_memory(order.memory_limit)
        done = answer(_call, order)
        with suppress(OSError):
            os.write(2, END_OF_TALK)
            pickle.dump(("answer", replace(done, is_used_up=_Channel.is_used_up)), reports)
            reports.flush()


def _call(order: Order) -> Any:
    task, arguments = pickle.loads(order.call)
    return task(*arguments)


def _prepare(modules: Sequence[str], inbox: SimpleQueue[Order]) -> None:
    from ..filters.compilation.machine_code import load_linker

    loads: list[Callable[[], Any]] = [*(partial(importlib.import_module, name) for name in modules), load_linker]
    for load in loads:
        if not inbox.empty():
            return
        with suppress(Exception):  # the order will raise the same error and report it
            load()


def _receive(orders: BinaryIO, inbox: SimpleQueue[Order]) -> None:
    try:
        while True:
            order: Order = pickle.load(orders)
            _Channel.if_lost = order.if_lost
            inbox.put(order)
    except (EOFError, pickle.UnpicklingError, OSError):  # the parent has ended
        if _Channel.if_lost is not None:
            pickle.loads(_Channel.if_lost)()
    finally:
        os._exit(1)


def _take_over_streams() -> tuple[BinaryIO, io.BufferedWriter]:
    """Keeps stdin and stdout for orders and answers; filters get the null device, as MeshLab's filters print to stdout."""
    orders = os.fdopen(os.dup(0), "rb")
    reports = os.fdopen(os.dup(1), "wb")
    null_device = os.open(os.devnull, os.O_RDWR)
    os.dup2(null_device, 0)
    os.dup2(null_device, 1)
    os.close(null_device)
    return orders, reports


if __name__ == "__main__":
    # Tasks import this module by its full name, so its state must be in the module of this name and not in `__main__`.
    from pymeshfair.processes import worker

    worker.serve(sys.argv[1:])
