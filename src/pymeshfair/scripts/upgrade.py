"""Brings a script of an older MeshLab up to date, from the table of facts about former filters and parameters.

Each change is graded: the script means the same, or its meaning changes and it is said how. What no fact is known of stays as it
is and is refused as in any other script. An upgraded script has nothing left to upgrade.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..declaration import Bool, Enum, FileOpen, Filter, Float, Length, Parameter, Percentage, Point
from ..errors import UnknownNameError
from ..meshlab.former import Former, former_filter, former_parameters
from ..registry import find_filter
from .changes import Change
from .elements import FilterElement, ParamElement
from .param_types import OLD_TYPES, WHOLE, parsed, type_complaints
from .read import SECOND_DOCUMENT_TYPE, parse_document, read_bytes
from .script import Script, Step
from .step_builder import build_script
from .suggestions import close_spelling, same_but_case
from .upgraded_steps import CurrentLayer, upgraded_steps

_GONE = "is left out, as MeshLab has dropped it"
_UNHEARD_OF = "no version of MeshLab has such a parameter, and all go on without it"
_UNTYPED = "is left out: it has no type, and every MeshLab drops such a value and takes its default (--mend sets it)"
_MISREAD = "the MeshLab of today reads another value there, 0 or its default"


def upgraded_params(
    element: FilterElement, known: Filter, facts: Sequence[Former], *, mend: bool
) -> tuple[list[ParamElement], list[Change]]:
    """The parameters that today's filter takes, and what was changed; what is not known stays as it is.

    A value without a type, which no MeshLab has read, is left out, or set with `mend`.
    """
    params: dict[object, ParamElement] = {}
    changes: list[Change] = []
    old = element.name or ""
    declared = {p.xml_name: p for p in known.parameters}
    for index, param in enumerate(element.params):
        name = param.attributes.get("name")
        if name is None:
            params[index] = param
            continue
        if not mend and element.kind != "xmlfilter" and "type" not in param.attributes:
            changes.append(Change(line=param.line, filter=old, parameter=name, what=_UNTYPED))
            continue
        meant = name if name in declared else _fact(facts, name, param, declared)
        if isinstance(meant, Change):
            changes.append(Change(line=param.line, filter=old, parameter=name, what=meant.what, meaning=meant.meaning))
            continue
        if isinstance(meant, Mapping):
            said = ", ".join(f"{new}={text}" for new, text in meant.items()) or "today's default says the same"
            changes.append(Change(line=param.line, filter=old, parameter=name, what=f"is left out: {said}"))
            for new, text in meant.items():
                params[new] = _typed(declared[new], {"name": new, "value": text}, param.line)
            continue
        if meant not in declared:
            near = close_spelling(name, [*declared])
            meaning = _UNHEARD_OF + (f"; if it is to be {near!r}, write that" if near else "")
            changes.append(Change(line=param.line, filter=old, parameter=name, what="is left out", meaning=meaning))
            continue
        if meant != name:
            changes.append(Change(line=param.line, filter=old, parameter=name, what=f"is {meant!r} now"))
        if meant in params:
            meaning = "" if params[meant].attributes == param.attributes else "the last of the two values counts, as in MeshLab"
            changes.append(Change(line=param.line, filter=old, parameter=name, what="is given once", meaning=meaning))
        if any(meant in former.relabelled for former in facts) and (change := _relabelled(declared[meant], param, old)):
            changes.append(change)
            param = ParamElement({k: v for k, v in param.attributes.items() if not k.startswith("enum_val")}, param.line)
        params[meant] = _typed(declared[meant], {**param.attributes, "name": meant}, param.line)
        if element.kind != "xmlfilter":
            changes += _type_changes(declared[meant], param, params[meant], element, runs_today=known.name == old)
    return list(params.values()), changes


def _fact(
    facts: Sequence[Former], name: str, param: ParamElement, declared: Mapping[str, Parameter]
) -> str | Mapping[str, str] | Change:
    """Today's name of a parameter, or the values that say the same, or why it is left out; the same name if nothing is known."""
    value = param.attributes.get("value", "")
    for former in facts:
        if name in former.renames:
            return former.renames[name]
        turned = former.turned(name, value)
        if turned is not None:
            return turned
        if name in former.drops:
            neutral = former.drops[name]
            same = neutral is None or value.strip().lower() == neutral or (parsed(value) is not None and _equal(value, neutral))
            meaning = "" if same else f"MeshLab has no such parameter any more and does what {neutral} did"
            return Change(line=param.line, filter="", what=_GONE, meaning=meaning)
        if name in former.loses:
            return Change(line=param.line, filter="", what=_GONE, meaning=former.loses[name])
    by_case = [xml for xml, p in declared.items() if name.casefold() == xml.casefold() or name == p.name]
    return by_case[0] if len(by_case) == 1 else name


def _equal(text: str, neutral: str) -> bool:
    return parsed(text) == parsed(neutral)


def _typed(parameter: Parameter, attributes: Mapping[str, str], line: int) -> ParamElement:
    """The element with the type and the attributes that MeshLab needs, where the value can be read in that type."""
    found = dict(attributes)
    value = found.get("value", "")
    if isinstance(parameter, Bool):
        found["value"] = {"1": "true", "0": "false"}.get(value.strip(), value.strip().lower())
        if found["value"] not in ("true", "false"):
            return ParamElement(attributes, line)
    elif isinstance(parameter, Point):
        if any(parsed(found.get(axis, "")) is None for axis in "xyz"):
            return ParamElement(attributes, line)
    elif isinstance(parameter, Float | Percentage):
        number = parsed(value)
        if number is None:
            return ParamElement(attributes, line)
        if found.get("type") != "RichFloat" or parameter.xml_type == "RichAbsPerc":
            for bound, limit in (("min", min(0.0, number)), ("max", number)):
                found[bound] = found.get(bound, repr(limit))
    elif isinstance(parameter, Enum) or parameter.xml_type in ("RichInt", "RichMesh"):
        if WHOLE.fullmatch(value) is None:
            return ParamElement(attributes, line)
        if isinstance(parameter, Enum):
            found["enum_cardinality"] = found.get("enum_cardinality", str(len(parameter.choices)))
    elif isinstance(parameter, FileOpen):
        found["exts_cardinality"] = found.get("exts_cardinality", "0")
    if list(type_complaints(parameter, found)):
        found["type"] = parameter.xml_type
    return ParamElement(found, line)


def _relabelled(parameter: Parameter, param: ParamElement, filter_name: str) -> Change | None:
    """The change of a choice that keeps its number and has another word today; None if it has the same."""
    value = param.attributes.get("value", "").strip()
    word = param.attributes.get(f"enum_val{value}")
    if not isinstance(parameter, Enum) or word is None or not value.isdigit() or int(value) >= len(parameter.choices):
        return None
    today = parameter.choices[int(value)]
    if word == today:
        return None
    what = f"keeps the number {value}; what MeshLab called {word!r} did what it calls {today!r} today"
    return Change(line=param.line, filter=filter_name, parameter=parameter.xml_name, what=what)


def _type_changes(
    parameter: Parameter, old: ParamElement, new: ParamElement, element: FilterElement, *, runs_today: bool
) -> Iterator[Change]:
    """What was changed in the attributes of a parameter; `runs_today` if MeshLab still has the old step's filter."""
    before, misread = old.attributes, _is_misread(parameter, old.attributes, new.attributes)
    meaning = _MISREAD if (misread and runs_today) or "type" not in before else ""
    for attribute, text in new.attributes.items():
        if attribute != "name" and before.get(attribute) != text:
            written = f"was {before[attribute]!r}" if attribute in before else "was missing"
            what = f"{attribute} is {text!r}, {written}"
            yield Change(line=old.line, filter=element.name or "", parameter=parameter.xml_name, what=what, meaning=meaning)
            meaning = ""  # which is said once


def _is_misread(parameter: Parameter, old: Mapping[str, str], new: Mapping[str, str]) -> bool:
    """Whether the MeshLab of today reads another value in the old attributes than in the new ones."""
    value = old.get("value", "")
    if old.get("type") in OLD_TYPES:
        return False
    if any(type_complaints(parameter, old)):  # of a wrong type it reads 0
        return new.get("value", "").lower() not in ("0", "0.0", "false") or new["type"] == old.get("type")
    return isinstance(parameter, Bool) and value.lower() not in ("true", new["value"])


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
