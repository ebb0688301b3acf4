"""What comes of a task on a worker, in a form that crosses from process to process and from machine to machine."""

from __future__ import annotations

import os
import socket
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..errors import FilterInputError, PymeshfairError
from ..files.errors import ContentsError
from ..operating_system import this_system


class LostWorkerError(PymeshfairError):
    """Every worker that began a task was lost."""


@dataclass(frozen=True)
class Answer:
    """What came of a task.

    Attributes:
        result: what it gave back.
        failure: why it gave nothing back, as a kind and words.
        process: where it was done.
        peak: the most bytes that this process has held so far, as far as that is known.
        seconds: processor time.
    """

    result: Any = None
    failure: tuple[str, str] | None = None
    process: str = ""
    peak: int | None = None
    seconds: float = 0.0


def answer(task: Callable[..., Any], *arguments: Any) -> Answer:
    """Do a task, in this process."""
    started = time.process_time()
    failure, result = None, None
    try:
        result = task(*arguments)
    except ContentsError as error:
        failure = "contents", str(error)
    except FilterInputError as error:
        failure = "filter", str(error)
    except MemoryError:
        failure = "memory", ""
    except OSError as error:
        failure = "disk", (error.strerror or str(error)).lower()
    except Exception:
        failure = "defect", traceback.format_exc()
    process = f"{socket.gethostname()} {os.getpid()}"
    return Answer(result, failure, process, this_system().peak_memory(), time.process_time() - started)
