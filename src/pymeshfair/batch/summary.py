"""``batch.json`` and ``batch.csv``: every scan of a batch, those included that were done before it was resumed."""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ..files.writing import write_file
from ..processes.versions import versions
from ..running.job import Job
from ..running.plain_values import plain
from .inputs import labels
from .journal import Outcome
from .numbers import as_row, outliers

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
    def rows(self) -> list[tuple[Outcome, str, tuple[str, ...]]]:
        """Of each outcome a short name that no other has, and in what it lies far from the others."""
        names = labels([Path(o.input) for o in self.outcomes], [Path(o.output) for o in self.outcomes])
        return list(zip(self.outcomes, names, outliers(self.outcomes), strict=True))

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
