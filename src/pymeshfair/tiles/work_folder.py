"""The folder of the files of a run by tiles, with a journal of the finished tasks: a run that was killed goes on from it.

The same run gives the same tasks in the same order. So a resumed run takes the results of finished tasks from the journal, and
their files are in the folder. A task that was under way is done again.
"""

import contextlib
import hashlib
import os
import pickle
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from ..files.errors import OutputError
from ..files.staging import WORK_PREFIX, in_use, remove_folder
from ..processes.order import Answer

_JOURNAL = "journal"


class WorkFolder:
    """The folder and its journal.

    Attributes:
        path: the folder.
        note: why the files of a former run are not used; empty if they are, or if there are none.
    """

    def __init__(self, path: Path, journal: BinaryIO, answers: dict[tuple[int, int], Answer], note: str) -> None:
        self.path = path
        self.note = note
        self._journal = journal
        self._answers = answers

    def answer(self, call: int, number: int) -> Answer | None:
        """The answer of a finished task: the `number`-th of the `call`-th group of tasks."""
        return self._answers.get((call, number))

    def append(self, call: int, number: int, answer: Answer) -> None:
        """Write down that a task is finished."""
        self._journal.write(pickle.dumps((call, number, answer)))
        self._journal.flush()


def work_path(output: Path) -> Path:
    """The folder of the run to an output: a hidden one beside it."""
    return output.with_name(WORK_PREFIX + hashlib.sha256(os.fsencode(output.name)).hexdigest()[:16])


@contextlib.contextmanager
def work_folder(
    output: Path, key: Mapping[str, Any], *, resume: bool, keep: tuple[type[BaseException], ...]
) -> Iterator[WorkFolder]:
    """The folder for a run to `output`, removed at the end of the run; the output must be locked.

    Args:
        output: the file to write.
        key: stands for all on which the tasks and their files depend. Files of a run with another key are removed.
        resume: use the files of a former run with the same key.
        keep: exceptions at which the folder stays, for a later run.

    Raises:
        OutputError: it cannot be made.
    """
    path = work_path(output)
    answers, end, note = _former(path, key) if resume else ({}, 0, "")
    with contextlib.ExitStack() as opened:
        try:
            if not end:
                remove_folder(path)
                path.mkdir(mode=0o700)
            opened.enter_context(in_use(path))
            journal = opened.enter_context((path / _JOURNAL).open("r+b" if end else "wb"))
            journal.truncate(end)
            journal.seek(end)
            if not end:
                journal.write(pickle.dumps(dict(key)))
                journal.flush()
        except OSError as error:
            raise OutputError(output, f"cannot make a folder beside it: {error.strerror or error}") from error
        try:
            yield WorkFolder(path, journal, answers, note)
        except keep:
            raise
        except BaseException:
            remove_folder(path)
            raise
        remove_folder(path)


def _former(path: Path, key: Mapping[str, Any]) -> tuple[dict[tuple[int, int], Answer], int, str]:
    """Of a former run its answers, the end of its last whole record in bytes (0 if it cannot be used), and why it cannot."""
    answers: dict[tuple[int, int], Answer] = {}
    end = 0
    try:
        # Pickles run code, so that a folder of another user is not read.
        status = path.lstat()
        if not stat.S_ISDIR(status.st_mode) or (hasattr(os, "getuid") and status.st_uid != os.getuid()):
            return {}, 0, f"the folder {path} belongs to another user"
        with (path / _JOURNAL).open("rb") as file:
            former = pickle.load(file)
            if former != dict(key):
                names = " and ".join(name for name in key if former.get(name) != key[name])
                return {}, 0, f"the files of the former run are not used, since it differs in {names}"
            end = file.tell()
            while True:
                call, number, answer = pickle.load(file)
                answers[call, number] = answer
                end = file.tell()
    except FileNotFoundError:
        return {}, 0, ""
    except Exception:  # the end of the file, or a record that was not written to its end
        return answers, end, ""
