"""The process that runs recipes for the page: it stays, so that libraries and the scan are there when a parameter changes.

``python -m pymeshfair.tuning.worker``; orders are lines of JSON on stdin, reports lines of JSON on stdout. The first order names
the scan, each further one a recipe to run on it. It is killed when a run is no longer wanted, and ends when stdin is closed.
"""

from __future__ import annotations

import json
import os
import queue
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import PymeshfairError
from ..files.errors import InputError
from ..operating_system import this_system
from ..running.messages import to_line
from ..running.worker import take_over_streams


def main() -> None:
    """Carry out orders until there are no more."""
    stdin, stdout = take_over_streams()
    orders: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    threading.Thread(target=_read_orders, args=(stdin, orders), daemon=True).start()

    def tell(report: Mapping[str, Any]) -> None:
        stdout.write(to_line(report))

    try:
        first = orders.get()
        this_system().limit_memory(first["memory_limit"])
        from .bench import Bench  # imports MeshLab, within the limit

        bench = Bench(Path(first["scan"]), Path(first["stage"]), tell)
        tell({"ready": bench.opening(Path(first["scene"])) if first["scene"] else {}})
    except Exception as error:
        tell(_failure(error))
        return
    while True:
        order = orders.get()
        started = time.perf_counter()
        work = partial(bench.run, order["assignment"])
        report = _outcome(work)
        tell({**report, "run": order["run"], "seconds": round(time.perf_counter() - started, 2)})


def _read_orders(stdin: Any, orders: queue.SimpleQueue[dict[str, Any]]) -> None:
    for line in stdin:
        orders.put(json.loads(line))
    os._exit(0)


def _outcome(work: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    try:
        return {"done": work()}
    except Exception as error:
        return _failure(error)


def _failure(error: Exception) -> dict[str, Any]:
    if isinstance(error, MemoryError):
        return {"failed": "memory ran out"}
    if isinstance(error, InputError | PymeshfairError):
        return {"failed": str(error)}
    return {"failed": f"{type(error).__name__}: {error}", "details": traceback.format_exc()}


if __name__ == "__main__":
    main()
