"""The outcomes of scans, and the journal of a batch: one line of JSON for each, on the disk before the outcome is reported."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Literal

from ..errors import PymeshfairError
from ..files.provenance import read_provenance
from ..operating_system import this_system

#: file name of the journal in the folder of outputs, from which a batch resumes
NAME = "batch.jsonl"
#: done; written although a guard was broken, as `keep_broken` asks; or not written
Status = Literal["done", "broken", "failed"]


@dataclass(frozen=True)
class Outcome:
    """The outcome of one scan."""

    input: str
    output: str  # the file that was or should have been written
    status: Status
    seconds: float  # that it took, the wait for its turn not among them
    finished: str = ""  # when, in UTC
    host: str = ""  # on which machine
    #: SHA-256 of ``"input"``, ``"recipe"`` and ``"output"``, of a scan that was written
    digests: Mapping[str, str] = field(default_factory=dict)
    #: measures of the mesh as read, as `pymeshfair.filters.inspection.surface_measures.SurfaceMeasures` by name; None where there
    #: are none
    before: Mapping[str, Any] | None = None
    after: Mapping[str, Any] | None = None  # of the mesh as written
    displacement: Mapping[str, Any] | None = None  # `pymeshfair.running.shape_change.Moved` by name; None where it is not known
    steps: tuple[Mapping[str, Any], ...] = ()  # the name and the seconds of each
    warnings: tuple[str, ...] = ()  # of the run
    breaches: tuple[Mapping[str, Any], ...] = ()  # the guards that were broken
    #: of a scan that failed: ``"kind"``, ``"message"``, ``"doing"`` (where in the run), ``"details"``
    error: Mapping[str, Any] | None = None
    peak_memory: int | None = None  # bytes
    former: str = ""  # of a scan that failed, the file that lies at the place of its output; empty if there is none
    resumed: bool = False  # whether it was done before this batch began
    unit: str | None = None  # of the lengths, if it is known

    @classmethod
    def of_error(cls, input: Any, output: Any, error: BaseException, seconds: float, host: str) -> Outcome:
        """Of a run that failed."""
        unexpected = "" if isinstance(error, PymeshfairError | OSError) else f"unexpected {type(error).__name__}: "
        place = getattr(error, "place", None)
        description = {
            "kind": type(error).__name__,
            "message": f"{unexpected}{error}",
            "doing": None if place is None else str(place),
            "details": getattr(error, "details", ""),
        }
        breaches = tuple(getattr(error, "breaches", ()))
        former = _former(Path(output))
        return cls(str(input), str(output), "failed", seconds, now(), host, breaches=breaches, error=description, former=former)

    @classmethod
    def of_record(cls, record: Mapping[str, Any], input: Any, output: Any) -> Outcome:
        """Of a scan that was written, from its provenance."""
        run, breaches = record["run"], tuple(record.get("guards", {}).get("breaches", ()))
        names = [step["filter"] for step in record["steps"]]
        return cls(
            str(input),
            str(output),
            "broken" if breaches else "done",
            run["seconds"],
            run["started"],
            digests=digests_of(record),
            before=record["measures"]["before"],
            after=record["measures"]["after"],
            displacement=(record["measures"]["change"] or {}).get("moved"),
            steps=tuple({"filter": n, "seconds": s} for n, s in zip(names, run["step_seconds"], strict=True)),
            warnings=tuple(record["warnings"]),
            breaches=breaches,
            peak_memory=run["peak_memory_bytes"],
            unit=record["measures"]["unit"],
        )

    def to_document(self) -> dict[str, Any]:
        """The outcome in the types of JSON."""
        return {name: value for name, value in asdict(self).items() if name != "resumed"}


def _former(output: Path) -> str:
    """The run that a file at the place of an output is of, in words; empty if there is no file."""
    if not output.exists():
        return ""
    record = read_provenance(output)
    if record is None:
        return "the file there is of no run"
    run, recipe = record.get("run", {}), record.get("recipe", {})
    return f"the file there is of {recipe.get('name', 'another recipe')}, run at {run.get('started', 'an unknown time')}"


def digests_of(record: Mapping[str, Any]) -> dict[str, str]:
    """The digests that a provenance document has."""
    return {part: str(record[part]["sha256"]) for part in ("input", "recipe", "output") if part in record}


def now() -> str:
    """The time in UTC, to the second."""
    return datetime.fromtimestamp(time.time(), timezone.utc).isoformat(timespec="seconds").replace("+00:00", "Z")


class BatchError(PymeshfairError):
    """The batch as a whole has failed; the scans in its journal stay done."""


class Journal:
    """The journal in a folder; a context manager that locks the folder against other batches."""

    def __init__(self, folder: Path, *, resume: bool) -> None:
        """Open and lock the journal in the folder of outputs; without `resume` its lines are deleted when the first scan ends."""
        self.path = folder / NAME
        try:
            self._file = self.path.open("a+b", buffering=0)
        except OSError as error:
            raise BatchError(f"cannot write the journal {self.path}: {error.strerror or error}") from error
        if this_system().try_lock(self._file, alone=True) is False:
            self._file.close()
            raise BatchError(f"another batch is writing to {folder} at this moment; wait for it, or name another folder")
        self._is_old = not resume
        try:
            self.before = read_journal(self.path)  # the outcomes of earlier batches by output, whether the file keeps them or not
            self._end_torn_line()
        except OSError as error:
            self._file.close()
            raise BatchError(f"cannot read the journal {self.path}: {error.strerror or error}") from error

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def append(self, outcome: Outcome) -> None:
        """Write one line, and wait until the disk has it."""
        try:
            if self._is_old:
                self._file.truncate(0)
                self._is_old = False
            line = json.dumps(outcome.to_document(), ensure_ascii=False)
            self._file.write(line.encode("utf-8", "surrogateescape") + b"\n")
            os.fsync(self._file.fileno())
        except OSError as error:
            raise BatchError(f"cannot write the journal {self.path}: {error.strerror or error}") from error

    def _end_torn_line(self) -> None:
        """End an incomplete last line, which a killed batch leaves, so that the next line stands by itself."""
        size = self._file.seek(0, os.SEEK_END)
        if size:
            self._file.seek(size - 1)
            if self._file.read(1) != b"\n":
                self._file.write(b"\n")


def read_journal(path: Path) -> dict[str, Outcome]:
    """The last outcome of each output; incomplete lines are skipped, and a missing journal is empty."""
    outcomes: dict[str, Outcome] = {}
    try:
        lines = path.read_bytes().splitlines()
    except FileNotFoundError:
        return outcomes
    for line in lines:
        try:
            document = json.loads(line)
            outcome = Outcome(**{f.name: document[f.name] for f in fields(Outcome) if f.name in document})
        except (ValueError, TypeError, AttributeError):
            continue
        outcomes[outcome.output] = outcome
    return outcomes
