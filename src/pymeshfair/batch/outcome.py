"""The outcome of one scan: a line of the journal, a row of the tables."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, Literal

from ..errors import PymeshfairError
from ..files.provenance import read_provenance

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
        told = {
            "kind": type(error).__name__,
            "message": f"{unexpected}{error}",
            "doing": None if place is None else str(place),
            "details": getattr(error, "details", ""),
        }
        breaches = tuple(getattr(error, "breaches", ()))
        former = _former(Path(output))
        return cls(str(input), str(output), "failed", seconds, now(), host, breaches=breaches, error=told, former=former)

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
