"""The protocol between supervisor and worker: one JSON document a line, and marks between MeshLab's lines on stderr."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal

from ..declaration import Length
from ..registry import find_filter
from ..scripts.guards import NO_GUARDS, Guards
from ..scripts.script import Step
from .job import Compiling, Event, Job, Message, PhaseStarted, StepFinished, StepProgress, StepStarted
from .memory import default_memory

_EVENTS: Mapping[str, type[Event]] = {
    kind.__name__: kind for kind in (PhaseStarted, StepStarted, StepProgress, StepFinished, Message, Compiling)
}


def encode_event(event: Event) -> dict[str, Any]:
    """The event as a document that `decode_event` reads."""
    return {"event": type(event).__name__, **asdict(event)}


def decode_event(document: Mapping[str, Any]) -> Event | None:
    """The event in a document, or None if it is none."""
    kind = _EVENTS.get(str(document.get("event")))
    return None if kind is None else kind(**{k: v for k, v in document.items() if k != "event"})


def to_line(document: Mapping[str, Any]) -> bytes:
    """The document as one line."""
    return json.dumps(document).encode("ascii") + b"\n"


@dataclass(frozen=True)
class Assignment:
    """What a worker is told to do.

    Attributes:
        steps: Python names of filters and their values, as `Step` has them.
        input: the file to read, an absolute path.
        output: the file to write in the end, an absolute path; None if the result is only to be looked at.
        stage: the staging folder, whose subfolder ``new`` takes what the worker writes.
        memory_limit: bytes, or None.
        allow_outside: let the input name files outside its own folder.
        unchecked: let MeshLab read formats that are not checked before.
        keep_all: whether anything that is not kept is an error.
        guards: what the result must not do.
        keep_broken: whether to write the output even if a guard was broken.
        map: the file for the intervention map, an absolute path; None if none is wanted.
        others: the files of further layers, absolute paths.
        displacement: whether to tell how far vertices have moved.
        own_texture_names: whether the names of textures begin with that of the output.
        recipe: the name of the recipe.
        head: the comment at its head, which may say for which scans it is.
        measures: whether to measure the mesh before and after.
    """

    steps: tuple[Step, ...]
    input: Path
    stage: Path
    output: Path | None = None
    memory_limit: int | None = None
    allow_outside: bool = False
    guards: Guards = NO_GUARDS
    keep_broken: bool = False
    map: Path | None = None
    others: tuple[Path, ...] = ()
    displacement: bool = False
    own_texture_names: bool = False
    unchecked: bool = False
    keep_all: bool = False
    recipe: str = ""
    head: str = ""
    measures: bool = True

    @property
    def is_watched(self) -> bool:
        """Whether there are guards, or an intervention map is wanted."""
        return bool(self.guards) or self.map is not None

    @property
    def is_followed(self) -> bool:
        """Whether elements are numbered, to be known again in the result."""
        return self.is_watched or self.displacement

    @classmethod
    def of(cls, job: Job, stage: Path) -> Assignment:
        """The assignment for the worker of `job`."""
        return cls(
            job.recipe.script.steps,
            job.input.absolute(),
            stage.absolute(),
            job.output.absolute(),
            default_memory() if job.memory_limit is None else job.memory_limit,
            job.allow_outside,
            unchecked=job.unchecked,
            keep_all=job.keep_all,
            guards=job.all_guards,
            keep_broken=job.keep_broken,
            others=tuple(path.absolute() for path in job.others),
            map=None if job.map is None else job.map.absolute(),
            displacement=job.displacement,
            own_texture_names=job.own_texture_names,
            recipe=job.recipe.name,
            head=job.recipe.script.comment,
            measures=job.measures,
        )

    def to_document(self) -> dict[str, Any]:
        """The assignment as a document that `from_document` reads."""
        document = {field.name: _sent(getattr(self, field.name)) for field in fields(self)}
        steps = [{"filter": s.filter.python_name, "values": _sent(s.values), "line": s.line} for s in self.steps]
        return document | {"steps": steps, "guards": self.guards.texts()}

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Assignment:
        """The assignment in a document; its values were checked when the recipe was read."""
        values = {field.name: document[field.name] for field in fields(cls)}
        for name in ("input", "output", "stage", "map"):
            values[name] = None if values[name] is None else Path(values[name])
        values["others"] = tuple(Path(path) for path in values["others"])
        values["guards"] = Guards.parse(values["guards"])
        values["steps"] = tuple(Step(find_filter(s["filter"]), _received(s["values"]), s["line"]) for s in values["steps"])
        return cls(**values)


def _sent(value: Any) -> Any:
    """A checked value in the types of JSON: a length as a dictionary, a tuple as a list, a path as a text."""
    match value:
        case Length():
            return asdict(value)
        case Path():
            return str(value)
        case Mapping():
            return {name: _sent(each) for name, each in value.items()}
        case tuple():
            return [_sent(each) for each in value]
    return value


def _received(values: Mapping[str, Any]) -> dict[str, Any]:
    """What was sent, in the types of checked values again."""
    return {name: _as_checked(value) for name, value in values.items()}


def _as_checked(value: Any) -> Any:
    if isinstance(value, dict):
        return Length(**value)
    return tuple(_as_checked(part) for part in value) if isinstance(value, list) else value


#: how a run failed, as a worker reports it; the supervisor turns it into the exception
FailureKind = Literal["input", "output", "step", "memory", "import", "internal"]


def failure(kind: FailureKind, reason: str, *, path: Path | None = None, details: str = "") -> dict[str, Any]:
    """The document that reports a failure of the worker."""
    return {"failed": kind, "reason": reason, "path": None if path is None else str(path), "details": details}


# ------------------------------------------------------------------------------------------------------------------- stderr

_MARK = "pymeshfair-step"
_LOG = re.compile(r"LOG: (\d+) (.*?)\s*(?:\[ (\d{1,3})% \])?\s*")


def mark(step: int) -> bytes:
    """The line on stderr after which MeshLab's lines belong to that step; 0 for none."""
    return f"\n{_MARK} {step}\n".encode("ascii")


@dataclass(frozen=True)
class Talk:
    """One line that a worker wrote to stderr.

    Attributes:
        text: what it says, without MeshLab's prefix.
        level: of MeshLab's log (0 system, 1 warning, 2 filter, 3 debug); None if the line is not MeshLab's.
        fraction: how far a filter is, from 0 to 1, if the line tells that and nothing else.
        step: the step that begins here, if the line is a mark.
    """

    text: str
    level: int | None = None
    fraction: float | None = None
    step: int | None = None


def parse_talk(line: str) -> Talk:
    """Parse one line of stderr."""
    words = line.split()
    if len(words) == 2 and words[0] == _MARK and words[1].isdigit():
        return Talk("", step=int(words[1]))
    match = _LOG.fullmatch(line)
    if match is None:
        return Talk(line)
    level, text, percent = match.groups()
    return Talk(text.strip(), int(level), None if percent is None else min(int(percent), 100) / 100)
