"""``batch.json`` and ``batch.csv``: every scan of a batch, those included that were done before it was resumed.

Of every scan there is one number for every question that is asked of all of them; some lie far from those of the others.
"""

from __future__ import annotations

import csv
import io
import json
import math
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

from ..files.writing import write_file
from ..processes.environment import versions
from ..running.job import Job
from ..running.report import plain
from .journal import Outcome
from .plan import labels

#: of a robust z beyond which a number counts as far from the others [iglewicz1993]
FAR = 3.5
#: with fewer numbers there are no outliers
_FEWEST = 5
#: a normal distribution's standard deviation over its median absolute deviation, and over its mean absolute deviation
_BY_MEDIAN, _BY_MEAN = 1.482602, 1.253314


def displacement_in_edges(outcome: Outcome) -> float | None:
    """The root mean square of the displacement over the mean edge (for a cloud, the mean spacing) of the input."""
    return _in_edges(outcome, "rms")


def largest_in_edges(outcome: Outcome) -> float | None:
    """The largest displacement over the mean edge (for a cloud, the mean spacing) of the input."""
    return _in_edges(outcome, "largest")


def _in_edges(outcome: Outcome, name: str) -> float | None:
    moved, before = outcome.displacement, outcome.before
    edge = before and (before.get("mean_edge") or before.get("mean_spacing"))
    return None if moved is None or not edge else moved[name] / edge


def area_change(outcome: Outcome) -> float | None:
    """By how many percent the area has changed; below 0 it was lost. None for clouds."""
    if outcome.before is None or outcome.after is None or not outcome.before.get("area"):
        return None
    change: float = 100.0 * (outcome.after["area"] / outcome.before["area"] - 1.0)
    return change


#: the numbers in which a scan can be an outlier
QUESTIONS: Mapping[str, Callable[[Outcome], float | None]] = {
    "displacement": displacement_in_edges,
    "area": area_change,
    "noise": lambda outcome: (outcome.before or {}).get("roughness"),  # the mean angle between neighbouring faces
}


def outliers(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """Of each outcome, in which of `QUESTIONS` it lies far from the others."""
    scores = {words: robust_z([measure(outcome) for outcome in outcomes]) for words, measure in QUESTIONS.items()}
    return [tuple(words for words, z in scores.items() if abs(z[k] or 0.0) > FAR) for k in range(len(outcomes))]


def robust_z(numbers: Sequence[float | None]) -> list[float | None]:
    """The distance of each number from the median, in standard deviations estimated by the median absolute deviation.

    Where more than half of the numbers are the same that is 0, and the mean absolute deviation takes its place [iglewicz1993].
    None for what is None or not finite, and for all if they are fewer than five or all the same.
    """
    finite = [x for x in numbers if x is not None and math.isfinite(x)]
    if len(finite) < _FEWEST:
        return [None] * len(numbers)
    middle = statistics.median(finite)
    away = [abs(x - middle) for x in finite]
    scale = _BY_MEDIAN * statistics.median(away) or _BY_MEAN * statistics.fmean(away)
    if not scale:
        return [None] * len(numbers)
    return [None if x is None or not math.isfinite(x) else (x - middle) / scale for x in numbers]


def as_row(outcome: Outcome, far: Sequence[str]) -> dict[str, Any]:
    """The row of a scan in the tables, by the names of their columns."""
    before, after, moved = outcome.before or {}, outcome.after or {}, outcome.displacement or {}
    return {
        "input": outcome.input,
        "output": outcome.output,
        "status": outcome.status,
        "seconds": round(outcome.seconds, 3),
        "vertices_before": before.get("vertices"),
        "vertices_after": after.get("vertices"),
        "faces_before": before.get("faces"),
        "faces_after": after.get("faces"),
        "roughness_before": before.get("roughness"),
        "roughness_after": after.get("roughness"),
        "unit": outcome.unit,
        "displacement_mean": moved.get("mean"),
        "displacement_rms": moved.get("rms"),
        "displacement_largest": moved.get("largest"),
        "displacement_rms_in_edges": displacement_in_edges(outcome),
        "displacement_largest_in_edges": largest_in_edges(outcome),
        "area_change_percent": area_change(outcome),
        "far_in": " ".join(far),
        "warnings": len(outcome.warnings),
        "peak_memory_bytes": outcome.peak_memory,
        "former_output": outcome.former,
        "error": (outcome.error or {}).get("message", "; ".join(str(b["message"]) for b in outcome.breaches)),
    }


#: an outcome, a short name of its scan that no other has, and in which of `QUESTIONS` it lies far from the others
Row: TypeAlias = tuple[Outcome, str, tuple[str, ...]]
SCHEMA = "pymeshfair-batch-1"
TABLE, DOCUMENT = "batch.csv", "batch.json"


@dataclass(frozen=True)
class Summary:
    """The results of a batch."""

    outcomes: Sequence[Outcome]  # of the scans that have one, in the order of the batch
    planned: int  # how many scans the batch has
    template: Job  # of the runs of the batch
    started: str  # when, in UTC
    finished: str  # when, in UTC
    seconds: float  # from start to end

    @cached_property
    def rows(self) -> list[Row]:
        """The outcomes in the order of the batch."""
        names = labels([Path(o.input) for o in self.outcomes], [Path(o.output) for o in self.outcomes])
        return list(zip(self.outcomes, names, outliers(self.outcomes), strict=True))

    @property
    def worst_first(self) -> list[Row]:
        """Failures first, then those with broken guards, then the others from the largest displacement down."""
        order = {"failed": 0, "broken": 1, "done": 2}
        return sorted(self.rows, key=lambda row: (order[row[0].status], -(displacement_in_edges(row[0]) or 0.0), row[0].input))

    @property
    def counts(self) -> dict[str, int]:
        """The number of scans: in all, by status, done before, and not done yet."""
        by_status = Counter(outcome.status for outcome in self.outcomes)
        return {
            "scans": self.planned,
            **{status: by_status[status] for status in ("done", "broken", "failed")},
            "resumed": sum(outcome.resumed for outcome in self.outcomes),
            "left": self.planned - len(self.outcomes),
        }

    def document(self) -> dict[str, Any]:
        """The summary in the types of JSON."""
        recipe = self.template.recipe
        described: dict[str, Any] = plain(
            {
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
        )
        return described

    def table(self) -> str:
        """The summary as comma-separated values, one row a scan."""
        text = io.StringIO()
        rows = [{"name": name, **as_row(outcome, far)} for outcome, name, far in self.rows]
        writer = csv.DictWriter(text, rows[0] if rows else ["name"], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue()

    def write(self, folder: Path) -> tuple[Path, Path]:
        """Write both files, in place of those of a former batch."""
        document = json.dumps(self.document(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        return write_text(folder / DOCUMENT, document), write_text(folder / TABLE, self.table())


def write_text(path: Path, text: str) -> Path:
    """Write a file that appears whole, in place of that of a former batch; see `Task`."""
    write_file(path, text.encode("utf-8", "surrogateescape"), overwrite=True)
    return path
