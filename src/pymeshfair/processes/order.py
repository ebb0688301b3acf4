"""Messages between processes: the call that a worker process makes, and its result."""

from __future__ import annotations

import os
import pickle
import platform
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..errors import PymeshfairError
from ..operating_system import this_system


class DefectError(PymeshfairError):
    """A task raised an exception of an unexpected kind: a defect of pymeshfair. The message names the exception."""


@dataclass(frozen=True)
class Order:
    """A call of a function in another process."""

    call: bytes  # the function and its arguments, pickled: a function of a module, or a method of a value that can be pickled
    memory_limit: int | None = None  # bytes that the process may take, or None
    #: a function without arguments that the worker calls if the process that sent the order ends; pickled, or None
    if_lost: bytes | None = None

    @classmethod
    def of(
        cls,
        task: Callable[..., Any],
        *arguments: Any,
        memory_limit: int | None = None,
        if_lost: Callable[[], None] | None = None,
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
    seconds: float = 0.0  # processor time
    is_used_up: bool = False  # whether the process must not do another task, see `pymeshfair.processes.worker.use_up`


def answer(task: Callable[..., Any], *arguments: Any) -> Answer:
    """Do a task in this process, and measure it."""
    this_system().forget_peak_memory()
    started = time.process_time()
    result, error, details = None, None, ""
    try:
        result = task(*arguments)
    except Exception as raised:
        error, details = _sendable(raised), traceback.format_exc()
    process = f"{platform.node()} {os.getpid()}"
    return Answer(result, error, details, process, this_system().peak_memory(), time.process_time() - started)


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
