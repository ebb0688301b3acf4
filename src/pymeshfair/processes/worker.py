"""A process that carries out orders: ``python -m pymeshfair.processes.worker MODULE...``.

Orders come on stdin one after the other, events and answers go to the original stdout, all of them pickled. The modules are
imported until the first order comes. The process ends with the one that gives the orders, also in the middle of a task.
"""

import faulthandler
import importlib
import io
import os
import pickle
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from queue import SimpleQueue
from typing import Any, BinaryIO

from ..garbage import collect_seldom
from ..operating_system import this_system
from .order import Order, answer

#: the line on stderr that ends the talk of a task
END_OF_TALK = b"\npymeshfair-end-of-talk\n"


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

    loads: list[Callable[[], Any]] = [lambda name=name: importlib.import_module(name) for name in modules]  # type: ignore[misc]
    for load in (*loads, load_linker):
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
