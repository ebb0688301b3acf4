"""Outcomes of scans: the journal, from which a batch can resume, the search for outliers, and the tables of a batch.

A journal has one line of JSON for each outcome; the line is on the disk before the outcome is reported. ``batch.json`` and
``batch.csv`` have all finished scans, also those cleaned before a resumption.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass, field, fields
from datetime import datetime, timezone
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

from ..errors import PymeshfairError
from ..files.provenance import read_provenance
from ..files.writing import write_file
from ..operating_system import this_system
from ..processes.environment import versions
from ..running.job import Job, plain
from .plan import labels

#: files in the folder of outputs
NAME, TABLE, DOCUMENT = "batch.jsonl", "batch.csv", "batch.json"
SCHEMA = "pymeshfair-batch-1"
#: "done"; "broken": written with `keep_broken` although a guard was broken; "failed": not written
Status = Literal["done", "broken", "failed"]


@dataclass(frozen=True)
class Outcome:
    """The outcome of one scan."""

    input: str
    output: str  # the file to write
    status: Status
    seconds: float  # of the work, without waiting
    finished: str = ""  # the time in UTC; if only the provenance of the output is known, the time when the run started
    host: str = ""  # the machine that did the work
    digests: Mapping[str, str] = field(default_factory=dict)  # SHA-256 of ``"input"``, ``"recipe"`` and ``"output"``
    before: Mapping[str, Any] | None = None  # measures of the input: fields of `SurfaceMeasures`; None if not measured
    after: Mapping[str, Any] | None = None  # measures of the output
    displacement: Mapping[str, Any] | None = None  # fields of `pymeshfair.running.shape_change.Moved`; None if unknown
    steps: tuple[Mapping[str, Any], ...] = ()  # the name and the seconds of each step
    warnings: tuple[str, ...] = ()  # of the run
    breaches: tuple[Mapping[str, Any], ...] = ()  # the guards that were broken
    error: Mapping[str, Any] | None = None  # of a failure: ``"kind"``, ``"message"``, ``"doing"``, ``"details"``
    peak_memory: int | None = None  # bytes
    former: str = ""  # if the scan failed: describes the file at the path of its output; empty if there is none
    resumed: bool = False  # whether an earlier batch cleaned this scan
    unit: str | None = None  # of lengths, if known

    @classmethod
    def of_error(cls, input: Path, output: Path, error: BaseException, seconds: float, host: str) -> Outcome:
        unexpected = "" if isinstance(error, PymeshfairError | OSError) else f"unexpected {type(error).__name__}: "
        place = getattr(error, "place", None)
        description = {
            "kind": type(error).__name__,
            "message": f"{unexpected}{error}",
            "doing": None if place is None else str(place),
            "details": getattr(error, "details", ""),
        }
        breaches = tuple(getattr(error, "breaches", ()))
        former = _former_output(output)
        return cls(str(input), str(output), "failed", seconds, now(), host, breaches=breaches, error=description, former=former)

    @classmethod
    def of_record(cls, record: Mapping[str, Any], input: Path, output: Path) -> Outcome:
        """Returns the outcome of a scan that was written, from its provenance."""
        run, measures, breaches = record["run"], record["measures"], tuple(record.get("guards", {}).get("breaches", ()))
        times = zip(record["steps"], run["step_seconds"], strict=True)
        return cls(
            str(input),
            str(output),
            "broken" if breaches else "done",
            run["seconds"],
            run["started"],
            digests=digests_of(record),
            before=measures["before"],
            after=measures["after"],
            displacement=(measures["change"] or {}).get("moved"),
            steps=tuple({"filter": step["filter"], "seconds": seconds} for step, seconds in times),
            warnings=tuple(record["warnings"]),
            breaches=breaches,
            peak_memory=run["peak_memory_bytes"],
            unit=measures["unit"],
        )

    def to_document(self) -> dict[str, Any]:
        return {name: value for name, value in asdict(self).items() if name != "resumed"}


def _former_output(output: Path) -> str:
    if not output.exists():
        return ""
    record = read_provenance(output)
    if record is None:
        return "the existing output was not written by a run"
    run, recipe = record.get("run", {}), record.get("recipe", {})
    return f"the existing output is of {recipe.get('name', 'another recipe')}, run at {run.get('started', 'an unknown time')}"


def digests_of(record: Mapping[str, Any]) -> dict[str, str]:
    """Returns the checksums in a provenance document, by part."""
    return {part: str(record[part]["sha256"]) for part in ("input", "recipe", "output") if part in record}


def now() -> str:
    """Returns the time in UTC, to the second."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds").replace("+00:00", "Z")


class BatchError(PymeshfairError):
    """The whole batch has failed; the scans in its journal stay done."""


class Journal(AbstractContextManager["Journal"]):
    """The journal of a folder of outputs; a context manager that locks the folder, if the system has locks, for this batch."""

    def __init__(self, folder: Path, *, resume: bool) -> None:
        """Without `resume` the old lines are deleted when the first scan ends."""
        self.path = folder / NAME
        try:
            self._file = self.path.open("a+b", buffering=0)
            is_free = this_system().try_lock(self._file, alone=True) is not False
            self.before = read_journal(self.path)  # the last outcome of each output in earlier batches, also without `resume`
        except OSError as error:
            raise BatchError(f"cannot write the journal {self.path}: {error.strerror or error}") from error
        if not is_free:
            self._file.close()
            raise BatchError(f"another batch is writing to {folder}; wait for it to end, or name another folder")
        self._has_old_lines = not resume

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def append(self, outcome: Outcome) -> None:
        line = json.dumps(outcome.to_document(), ensure_ascii=False).encode("utf-8", "surrogateescape") + b"\n"
        try:
            if self._has_old_lines:
                self._file.truncate(0)
                self._has_old_lines = False
            size = self._file.seek(0, os.SEEK_END)
            self._file.seek(max(0, size - 1))
            if size and self._file.read(1) != b"\n":  # a killed batch leaves an incomplete last line
                line = b"\n" + line
            if self._file.write(line) < len(line):  # the system writes what fits on the disk
                self._file.truncate(size)
                raise BatchError(f"cannot write the journal {self.path}: the disk is full")
            os.fsync(self._file.fileno())
        except OSError as error:
            raise BatchError(f"cannot write the journal {self.path}: {error.strerror or error}") from error


def read_journal(path: Path) -> dict[str, Outcome]:
    """Reads the last outcome of each output; skips incomplete lines."""
    outcomes: dict[str, Outcome] = {}
    for line in path.read_bytes().splitlines() if path.exists() else ():
        try:
            document = json.loads(line)
            outcome = Outcome(**{f.name: document[f.name] for f in fields(Outcome) if f.name in document})
        except (ValueError, TypeError, AttributeError):
            continue
        outcomes[outcome.output] = outcome
    return outcomes


FAR = 3.5  # the absolute robust z-score above which a number is an outlier [iglewicz1993]
_FEWEST = 5  # the fewest numbers among which outliers are searched
#: the standard deviation of a normal distribution, divided by its median absolute deviation and by its mean absolute deviation
_BY_MEDIAN, _BY_MEAN = 1.482602, 1.253314


def displacement_in_edges(outcome: Outcome, name: str = "rms") -> float | None:
    """Returns the displacement called `name` divided by the mean edge (for a cloud, the mean spacing) of the input."""
    moved, before = outcome.displacement, outcome.before
    edge = before and (before.get("mean_edge") or before.get("mean_spacing"))
    return None if moved is None or not edge else float(moved[name]) / float(edge)  # `plain` makes infinity a text


def area_change(outcome: Outcome) -> float | None:
    """Returns the change of the area in percent, below 0 for a loss; None if the input has no area or was not measured."""
    if outcome.before is None or outcome.after is None or not outcome.before.get("area"):
        return None
    return 100.0 * (float(outcome.after["area"]) / float(outcome.before["area"]) - 1.0)


#: the numbers that are compared to find outliers
NUMBERS: Mapping[str, Callable[[Outcome], float | None]] = {
    "displacement": displacement_in_edges,
    "area": area_change,
    "noise": lambda outcome: (outcome.before or {}).get("roughness"),  # the mean angle between neighbouring faces
}


def outliers(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """Returns, for each outcome, the `NUMBERS` in which it is an outlier."""
    scores = {words: robust_z([measure(outcome) for outcome in outcomes]) for words, measure in NUMBERS.items()}
    return [tuple(words for words, z in scores.items() if abs(z[k] or 0.0) > FAR) for k in range(len(outcomes))]


def robust_z(numbers: Sequence[float | None]) -> list[float | None]:
    """Returns robust z-scores: the distance from the median in standard deviations [iglewicz1993].

    The standard deviation is estimated from the median absolute deviation or, if that is 0, from the mean absolute deviation.
    None, infinity and NaN get the score None. If fewer than five numbers are finite, or all finite ones are equal, all get None.
    """
    finite = [x for x in numbers if x is not None and math.isfinite(x)]
    median = statistics.median(finite or [0.0])
    deviations = [abs(x - median) for x in finite] or [0.0]
    scale = _BY_MEDIAN * statistics.median(deviations) or _BY_MEAN * statistics.fmean(deviations)
    if len(finite) < _FEWEST or not scale:
        return [None] * len(numbers)
    return [None if x is None or not math.isfinite(x) else (x - median) / scale for x in numbers]


def as_row(outcome: Outcome, far: Sequence[str]) -> dict[str, Any]:
    """Returns the row of a scan in the table, by column name; `far` are the `outliers` of this scan."""
    before, after, moved = outcome.before or {}, outcome.after or {}, outcome.displacement or {}
    return {
        "input": outcome.input,
        "output": outcome.output,
        "status": outcome.status,
        "seconds": round(outcome.seconds, 3),
        **{f"{name}_{when}": m.get(name) for name in _COMPARED for when, m in (("before", before), ("after", after))},
        "unit": outcome.unit,
        **{f"displacement_{name}": moved.get(name) for name in ("mean", "rms", "largest")},
        "displacement_rms_in_edges": displacement_in_edges(outcome),
        "displacement_largest_in_edges": displacement_in_edges(outcome, "largest"),
        "area_change_percent": area_change(outcome),
        "far_in": " ".join(far),
        "warnings": len(outcome.warnings),
        "peak_memory_bytes": outcome.peak_memory,
        "former_output": outcome.former,
        "error": (outcome.error or {}).get("message", "; ".join(str(b["message"]) for b in outcome.breaches)),
    }


_COMPARED = ("vertices", "faces", "roughness")  # measures that the table has before and after the run
#: an outcome, a unique short name of its scan, and its `outliers`
Row: TypeAlias = tuple[Outcome, str, tuple[str, ...]]


@dataclass(frozen=True)
class Summary:
    """The results of a batch."""

    outcomes: Sequence[Outcome]  # of the finished scans, in the order of the batch
    planned: int  # the number of scans
    template: Job  # the options of all runs
    started: str  # the time in UTC
    finished: str
    seconds: float

    @cached_property
    def rows(self) -> list[Row]:
        names = labels([Path(o.input) for o in self.outcomes], [Path(o.output) for o in self.outcomes])
        return list(zip(self.outcomes, names, outliers(self.outcomes), strict=True))

    @property
    def worst_first(self) -> list[Row]:
        """Returns the failures, then the scans with broken guards, then the others by falling displacement."""
        order = {"failed": 0, "broken": 1, "done": 2}
        return sorted(self.rows, key=lambda row: (order[row[0].status], -(displacement_in_edges(row[0]) or 0.0), row[0].input))

    @property
    def counts(self) -> dict[str, int]:
        by_status = Counter(outcome.status for outcome in self.outcomes)
        return {
            "scans": self.planned,
            **{status: by_status[status] for status in ("done", "broken", "failed")},
            "resumed": sum(outcome.resumed for outcome in self.outcomes),
            "left": self.planned - len(self.outcomes),
        }

    def document(self) -> dict[str, Any]:
        recipe = self.template.recipe
        described = {
            "schema": SCHEMA,
            "recipe": {"name": recipe.name, "sha256": recipe.digest, "overrides": self.template.overrides},
            "limits": self.template.all_guards.texts(),
            "versions": versions(),
            "started": self.started,
            "finished": self.finished,
            "seconds": round(self.seconds, 3),
            "counts": self.counts,
            "scans": [
                {"name": name, **outcome.to_document(), "resumed": outcome.resumed, "far_in": far}
                for outcome, name, far in self.rows
            ],
        }
        return dict(plain(described))

    def write(self, folder: Path) -> tuple[Path, Path]:
        table = io.StringIO()
        rows = [{"name": name, **as_row(outcome, far)} for outcome, name, far in self.rows]
        writer = csv.DictWriter(table, rows[0] if rows else ["name"], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        document = json.dumps(self.document(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        return write_text(folder / DOCUMENT, document), write_text(folder / TABLE, table.getvalue())


def write_text(path: Path, text: str) -> Path:
    """Writes a file atomically; replaces an existing file."""
    write_file(path, text.encode("utf-8", "surrogateescape"), overwrite=True)
    return path
