"""Brings a script of an older MeshLab up to date, from the table of facts about former filters and parameters.

Each change is graded: the script means the same, or its meaning changes and it is said how. What no fact is known of stays as it
is and is refused as in any other script. An upgraded script has nothing left to upgrade.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from ..declaration import Filter, Length
from ..errors import UnknownNameError
from ..meshlab.former import Former, former_filter, former_parameters
from ..registry import find_filter
from .changes import Change
from .elements import FilterElement, ParamElement
from .read import SECOND_DOCUMENT_TYPE, parse_document, read_bytes
from .script import Script, Step
from .step_builder import build_script
from .suggestions import same_but_case
from .upgraded_params import upgraded_params
from .upgraded_steps import CurrentLayer, upgraded_steps


@dataclass(frozen=True)
class Upgrade:
    """A script as today's MeshLab runs it.

    Attributes:
        script: the steps.
        changes: what was changed, in the order of the old script; empty if it was up to date.
    """

    script: Script
    changes: tuple[Change, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """The changes after which the script does not mean quite the same."""
        return tuple(str(change) for change in self.changes if not change.same_meaning)


def upgrade_file(path: str | Path, *, mend: bool = False) -> Upgrade:
    """The upgraded script in a file; for `mend` see `upgrade_script`.

    Raises:
        ScriptError: the file cannot be read, or something is wrong that no upgrade cures; lists every problem.
    """
    return upgrade_script(read_bytes(path), str(path), path=Path(path), mend=mend)


def upgrade_script(data: bytes, name: str, *, path: Path | None = None, mend: bool = False) -> Upgrade:
    """The upgraded script in the bytes of an .mlx file; `name` stands for the file in messages.

    A value without a type, which every MeshLab drops, is left out; with `mend` it is set, as it was meant.

    Raises:
        ScriptError: something is wrong that no upgrade cures; lists every problem.
    """
    changes: list[Change] = []
    once = SECOND_DOCUMENT_TYPE.sub(_blank_second, data[: 1 << 16]) + data[1 << 16 :]
    if once != data:
        changes.append(Change(line=1, filter="", what="the second <!DOCTYPE FilterScript> is left out"))
    document = parse_document(once, name)
    result_stays_current: set[int] = set()
    aged = False
    filters: list[FilterElement] = []
    current = CurrentLayer()
    for element in document.filters:
        former = former_filter(element.name or "")
        aged = aged or _is_old(element, former)
        values = {p.attributes.get("name", ""): p.attributes.get("value", "") for p in element.params}
        if current.is_asked_for(element, values):
            what = "left out: of one mesh file it makes the layer current that is so today"
            meaning = "in a run of several mesh files it made another layer current"
            changes.append(Change(line=element.line, filter=element.name or "", what=what, meaning=meaning))
            if current.maker is not None:
                result_stays_current.add(current.maker)
            continue
        upgraded, found = _upgraded(element, values, mend=mend)
        for step in upgraded:
            current.go_on(step, values)
        changes += found
        filters += upgraded
        if former is not None and former.layers == "current":
            result_stays_current.add(element.line)
    script = build_script(replace(document, filters=tuple(filters)), path)
    names = {element.line: element.name or "" for element in document.filters}
    script, found = upgraded_steps(script, names, aged=aged, always_current=frozenset(result_stays_current))
    changes += found
    return Upgrade(script, tuple(sorted(changes, key=lambda change: change.line)))


def _blank_second(match: re.Match[bytes]) -> bytes:
    """The first document type, and blanks in the place of the second."""
    return match[1] + b" " * (len(match[0]) - len(match[1]))


def _upgraded(element: FilterElement, values: Mapping[str, str], *, mend: bool) -> tuple[list[FilterElement], list[Change]]:
    """The element of today, none if it is to be left out, and what was changed; `values` are those of its parameters."""
    name = element.name
    if name is None:
        return [element], []
    former, known = _today(name, values)
    if former is not None and former.idle:
        return [], [Change(line=element.line, filter=name, what="left out, as it never changed a mesh")]
    if known is None:
        return [element], []
    changes = list(_named(element, name, known, former))
    facts = [f for f in (former, former_parameters(known.name)) if f is not None]
    params, found = upgraded_params(element, known, facts, mend=mend)
    written: set[str | None] = {p.attributes.get("name") for p in params}
    for parameter, text in ({} if former is None else former.sets).items():
        if parameter not in written:
            declared = next(p for p in known.parameters if p.xml_name == parameter)
            given = ParamElement({"type": declared.xml_type, "name": parameter, "value": text}, element.line)
            more, _ = upgraded_params(replace(element, params=(given,)), known, [], mend=False)
            params += more
    return [replace(element, kind="filter", name=known.name, params=tuple(params))], changes + found


def _is_old(element: FilterElement, former: Former | None) -> bool:
    """Whether only an older MeshLab can have written the element."""
    old_types = any(p.attributes.get("type") == "RichPoint3f" for p in element.params)
    return element.kind == "xmlfilter" or old_types or (former is not None and not former.invented)


def _today(name: str, values: Mapping[str, str]) -> tuple[Former | None, Filter | None]:
    """What is known of a name of old, and the filter that it means today with these values."""
    try:
        return None, find_filter(name)
    except UnknownNameError:
        former = former_filter(name)
    today = same_but_case(name) if former is None else former.today(values)
    return former, None if today is None else find_filter(today)


def _named(element: FilterElement, name: str, known: Filter, former: Former | None) -> Iterator[Change]:
    """The changes that the tag and the name of a filter need."""
    if element.kind == "xmlfilter":
        yield Change(line=element.line, filter=name, what="is written as <filter>, with the types of its parameters")
    if known.name != name:
        sets = {} if former is None else former.sets
        added = "".join(f", with {parameter}={text}" for parameter, text in sets.items())
        meaning = "" if former is None else former.note
        if former is not None and former.invented and not meaning:
            meaning = "no MeshLab has had a filter of that name"
        yield Change(line=element.line, filter=name, what=f"is {known.name!r} now{added}", meaning=meaning)


def relative_script(script: Script, *, diagonal: float) -> Script:
    """The script with every absolute length as a percentage of the diagonal of the mesh that it was meant for.

    Args:
        script: the steps; a length of 0 stays, as it is 0 on every mesh.
        diagonal: of the bounding box of that mesh, above 0.
    """
    return script.with_steps(_relative(step, diagonal) for step in script.steps)


def _relative(step: Step, diagonal: float) -> Step:
    lengths = {
        name: Length(100.0 * value.amount / diagonal, "percent")
        for name, value in step.values.items()
        if isinstance(value, Length) and value.unit == "absolute" and value.amount
    }
    return step.with_checked(lengths)
