"""The process that a run lives in: ``python -m pymeshfair.running.worker``, with its assignment as a line of JSON on stdin.

It reports events as lines of JSON on its original stdout. It ends when stdin is closed, which means that the supervisor is gone.
Nothing here is meant to be called from elsewhere.
"""

from __future__ import annotations

import contextlib
import faulthandler
import json
import os
import select
import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

from ..errors import StepFailedError
from ..files.errors import InputError, OutputBusyError, OutputError
from ..files.output_lock import output_lock
from ..files.staging import hold, remove_folder
from ..filters.compilation.machine_code import load_linker
from ..garbage import collect_seldom
from ..operating_system import this_system
from .messages import Assignment, failure, to_line

#: sends a document to the supervisor
Tell: TypeAlias = Callable[[Mapping[str, Any]], None]
#: does what a document asks and gives its report back
Work: TypeAlias = Callable[[Mapping[str, Any], Tell], dict[str, Any]]


def main(before_end: Callable[[], None] = lambda: None) -> None:
    """Carry out the assignment that stdin gives, as a run; `before_end` is called when all is done and reported."""
    collect_seldom()
    serve(_run, before_end, (_load_session, load_linker))


def serve(work: Work, before_end: Callable[[], None], meanwhile: Sequence[Callable[[], None]] = ()) -> None:
    """Do with the document that stdin gives whatever `work` does, within its limits, and end the process.

    Args:
        work: what to do.
        before_end: called when all is done and reported.
        meanwhile: called one after the other until the document comes, which may take a while.
    """
    orders, reports = take_over_streams()
    faulthandler.enable()
    with contextlib.suppress(Exception):  # `work` meets it again, and tells it
        for prepare in meanwhile:
            if select.select([orders], [], [], 0)[0]:
                break
            prepare()
    line = orders.readline()
    if not line.endswith(b"\n"):
        os._exit(1)
    document = json.loads(line)
    stage = Path(document["stage"])
    lock = hold(stage)
    janitor = threading.Thread(target=_end_with_supervisor, args=(orders, stage, document["output"]), daemon=True)
    janitor.start()
    this_system().limit_memory(document["memory_limit"])

    def tell(report: Mapping[str, Any]) -> None:
        with contextlib.suppress(OSError):  # the supervisor is gone
            reports.write(to_line(report))

    tell(_outcome(work, document, tell))
    before_end()
    reports.close()
    silence(2)
    janitor.join()  # the supervisor ends this process when all is in place; if it dies before that, its folder goes with it
    lock.close()  # in use until here


def take_over_streams() -> tuple[BinaryIO, BinaryIO]:
    """Keep stdin and stdout to ourselves: MeshLab's filters, and whatever they call, print to stdout."""
    orders = os.fdopen(os.dup(0), "rb")
    reports = os.fdopen(os.dup(1), "wb", buffering=0)
    silence(0, 1)
    return orders, reports


def silence(*descriptors: int) -> None:
    """Let streams read nothing and write to nowhere."""
    nothing = os.open(os.devnull, os.O_RDWR)
    for descriptor in descriptors:
        os.dup2(nothing, descriptor)
    os.close(nothing)


def _end_with_supervisor(orders: BinaryIO, stage: Path, output: str | None) -> None:
    while orders.read(4096):
        pass
    remove_folder(stage)
    if output is not None:
        _remove_lock(Path(output))
    os._exit(1)


def _remove_lock(output: Path) -> None:
    """Remove the file that the supervisor had locked, who may lose its pipes a moment before its locks."""
    for _ in range(20):
        try:
            with output_lock(output):
                return
        except OutputBusyError:  # noqa: PERF203
            time.sleep(0.05)
        except OutputError:
            return


def _load_session() -> None:
    from . import session  # noqa: F401  # with MeshLab


def _run(document: Mapping[str, Any], tell: Tell) -> dict[str, Any]:
    from .session import Session

    return Session(Assignment.from_document(document), tell).run()


def _outcome(work: Work, document: Mapping[str, Any], tell: Tell) -> dict[str, Any]:
    """Do the work; what came of it, for the supervisor."""
    try:
        report = work(document, tell)
    except ImportError as error:
        return failure("import", str(error), details=traceback.format_exc())
    except InputError as error:
        return failure("input", error.reason, path=error.path)
    except OutputError as error:
        return failure("output", error.reason, path=error.path)
    except StepFailedError as error:
        return failure("step", error.reason, details=traceback.format_exc())
    except MemoryError:
        return failure("memory", "memory ran out")
    except Exception as error:
        return failure("internal", f"{type(error).__name__}: {error}", details=traceback.format_exc())
    return {"done": report | {"peak_memory": this_system().peak_memory()}}


if __name__ == "__main__":
    main()
