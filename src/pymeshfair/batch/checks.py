"""Checks before a batch: inputs, outputs, and room on the disk."""

import shutil
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import RunError
from ..files.formats import extension
from ..files.inputs import check_input
from ..files.outputs import MadeFrom, check_output
from ..files.writing import check_place, check_target
from ..running.job import Job
from ..scripts.guards import refuse_unmeasured
from ..scripts.warnings import check_needs
from .journal import NAME as JOURNAL
from .journal import read_journal
from .page import NAME as PAGE
from .plan import Scan
from .summary import DOCUMENT, TABLE

#: an output in doubles over its input in single precision, at most
_GROWTH = 2.0


@dataclass(frozen=True)
class Prospect:
    """The work that a batch would do."""

    states: Mapping[int, str]  # of each scan ``"to do"``, ``"done"`` or ``"cannot be done"``, by its number
    problems: Mapping[int, str]  # of those that cannot be done why, by their numbers
    bytes_in: int  # of the inputs that are to do
    bytes_free: int | None  # where the outputs go, or None where the system does not say

    @property
    def lacks_room(self) -> bool:
        """Whether the outputs probably do not fit on the disk."""
        return self.bytes_free is not None and self.bytes_free < _GROWTH * self.bytes_in


def look_ahead(scans: Sequence[Scan], template: Job, folder: Path, done: Collection[int]) -> Prospect:
    """Look at everything that can be seen without opening a mesh, and change nothing."""
    check_needs(template.recipe.script, layers=1 + len(template.others))
    if not template.measures:
        refuse_unmeasured(template.all_guards)
    for path in template.others:
        check_input(path)
    states, problems, size = {}, {}, 0
    for scan in scans:
        states[scan.number] = "done" if scan.number in done else "to do"
        if scan.number in done:
            continue
        replace(template, input=scan.input, recipe=scan.recipe).check_unit()
        try:
            check_input(scan.input)
            size += scan.input.stat().st_size
            if scan.output.parent.is_dir():
                made_from = MadeFrom(scan.input, scan.recipe.digest, template.others)
                check_output(scan.output, made_from, overwrite=template.overwrite)
        except (RunError, OSError) as error:
            states[scan.number], problems[scan.number] = "cannot be done", str(error)
    return Prospect(states, problems, size, _free(folder))


def check_own_files(folder: Path, template: Job, *, report: bool) -> None:
    """Refuse a folder with files that have the names of those about the batch as a whole, and are not of a former batch.

    Of a former batch they are if the journal is one, see `pymeshfair.batch.journal.read_journal`.
    """
    journal = folder / JOURNAL
    is_ours = check_place(journal) and bool(read_journal(journal) or not journal.stat().st_size)
    for name in (JOURNAL, TABLE, DOCUMENT, *([PAGE] if report else [])):
        check_target(folder / name, (extension(Path(name)),), overwrite=template.overwrite or is_ours)


def _free(folder: Path) -> int | None:
    there = next((parent for parent in (folder, *folder.parents) if parent.exists()), folder)
    try:
        return shutil.disk_usage(there).free
    except OSError:
        return None
