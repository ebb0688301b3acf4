"""A process that carries out orders, and gives answers: ``python -m pymeshfair.processes.worker MODULE...``.

Orders come on stdin one after the other, events and answers go to the original stdout, all of them pickled. The modules are
imported until the first order comes. The process ends with the one that gives the orders, also in the middle of a task.
"""

from __future__ import annotations

import faulthandler
import importlib
import io
import os
import pickle
import platform
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
from ..garbage import collect_seldom
from ..operating_system import this_system

#: the line on stderr that ends the talk of a task
END_OF_TALK = b"\npymeshfair-end-of-talk\n"


class DefectError(PymeshfairError):
    """A task raised an exception of an unexpected kind: a defect of pymeshfair. The message names the exception."""


@dataclass(frozen=True)
class Order:
    """A call of a function in another process."""

    call: bytes  # the function and its arguments, pickled: a function of a module, or a method of a value that can be pickled
    memory_limit: int | None = None  # bytes that the process may take, or None
    if_lost: bytes | None = None  # pickled, a function that the worker calls if the process that sent the order ends; or None

    @classmethod
    def of(
        cls, task: Callable[..., Any], *arguments: Any, memory_limit: int | None = None, if_lost: Callable[[], None] | None = None
    ) -> Order:
        """The order to call `task` with those arguments."""
        return cls(pickle.dumps((task, arguments)), memory_limit, None if if_lost is None else pickle.dumps(if_lost))


@dataclass(frozen=True)
class Answer:
    """The result of a task."""

    result: Any = None  # its return value
    #: the exception that it raised: one of pymeshfair's, MemoryError, ImportError, OSError, or `DefectError`; or None
    error: Exception | None = None
    details: str = ""  # the traceback of the error
    process: str = ""  # the machine and the id of the process
    peak_memory: int | None = None  # the peak of its memory during the task in bytes, or None if the system does not measure it
    is_used_up: bool = False  # whether the process must not do another task, see `use_up`


def answer(task: Callable[..., Any], *arguments: Any) -> Answer:
    """Do a task in this process, and measure it."""
    this_system().forget_peak_memory()
    result, error, details = None, None, ""
    try:
        result = task(*arguments)
    except Exception as raised:
        error, details = _sendable(raised), traceback.format_exc()
    process = f"{platform.node()} {os.getpid()}"
    return Answer(result, error, details, process, this_system().peak_memory())


def _sendable(error: Exception) -> Exception:
    """An exception that can be raised in another process."""
    match error:
        case PymeshfairError():
            return error
        case MemoryError():
            return MemoryError("memory ran out")
        case ImportError():
            return ImportError(str(error))
        case OSError():
            return OSError(error.errno, error.strerror or str(error), error.filename)
    return DefectError(f"{type(error).__name__}: {error}")


class _Channel:
    """The channel to the process that gives the orders; None in a process without one."""

    reports: io.BufferedWriter | None = None
    if_lost: bytes | None = None
    is_used_up = False


def report(event: Any) -> None:
    """Send an event to the process that gave the order; in a process without orders nothing happens."""
    if _Channel.reports is not None:
        with suppress(OSError):  # that process has ended
            pickle.dump(("event", event), _Channel.reports)
            _Channel.reports.flush()


def use_up() -> None:
    """Let this process do no other task after this one, which has left something behind that changes the results of others."""
    _Channel.is_used_up = True


def serve(modules: Sequence[str]) -> None:
    """Carry out the orders on stdin; `modules` are imported until the first one comes."""
    collect_seldom()
    orders, reports = _take_over_streams()
    faulthandler.enable()
    _Channel.reports = reports
    inbox: SimpleQueue[Order] = SimpleQueue()
    threading.Thread(target=_receive, args=(orders, inbox), daemon=True).start()
    _prepare(modules, inbox)
    while True:
        order = inbox.get()
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
    """Load what the first order will need while it is on its way."""
    from ..filters.compilation.machine_code import load_linker

    loads: list[Callable[[], Any]] = [*(partial(importlib.import_module, name) for name in modules), load_linker]
    for load in loads:
        if not inbox.empty():
            return
        with suppress(Exception):  # the order meets it again, and tells it
            load()


def _receive(orders: BinaryIO, inbox: SimpleQueue[Order]) -> None:
    try:
        while True:
            order: Order = pickle.load(orders)
            _Channel.if_lost = order.if_lost
            inbox.put(order)
    except (EOFError, pickle.UnpicklingError, OSError):
        if _Channel.if_lost is not None:
            pickle.loads(_Channel.if_lost)()
    finally:
        os._exit(1)


def _take_over_streams() -> tuple[BinaryIO, io.BufferedWriter]:
    """Keep stdin and stdout for orders and answers: MeshLab's filters and their libraries print to stdout."""
    orders = os.fdopen(os.dup(0), "rb")
    reports = os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)
    os.close(nothing)
    assert isinstance(reports, io.BufferedWriter)
    return orders, reports


if __name__ == "__main__":
    # The module that tasks import is this one, too, and not a second of the same name.
    from pymeshfair.processes import worker

    worker.serve(sys.argv[1:])
