"""What a process is told to do, and what came of it."""

from __future__ import annotations

import pickle
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..errors import PymeshfairError
from ..operating_system import this_system


class DefectError(PymeshfairError):
    """A task raised an exception that is none of ours, which is a defect of pymeshfair; the message names it."""


@dataclass(frozen=True)
class Order:
    """A call of a function in another process.

    Attributes:
        call: the function and its arguments, pickled: a function of a module, or a method of a value that can be pickled.
        memory_limit: bytes that the process may take, or None.
        if_lost: a call without arguments for that process to make if the one that gave the order ends; pickled, or None.
    """

    call: bytes
    memory_limit: int | None = None
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
    """What came of a task.

    Attributes:
        result: what it gave back.
        error: what it raised: an exception of ours, MemoryError, ImportError, OSError, or `DefectError`; None if it ended well.
        details: the traceback of the error.
        process: the number of the process.
        peak_memory: the most bytes that it held during the task, or None where the system does not say.
        seconds: processor time.
        is_used_up: whether the process must not do another task, see `pymeshfair.processes.worker.use_up`.
    """

    result: Any = None
    error: Exception | None = None
    details: str = ""
    process: str = ""
    peak_memory: int | None = None
    seconds: float = 0.0
    is_used_up: bool = False


def answer(task: Callable[[], Any], process: str) -> Answer:
    """Do a task in this process."""
    this_system().forget_peak_memory()
    started = time.process_time()
    result, error, details = None, None, ""
    try:
        result = task()
    except Exception as raised:
        error, details = _sendable(raised), traceback.format_exc()
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
