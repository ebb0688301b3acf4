"""Brings a script of an older MeshLab up to date, by the table of facts about former filters and parameters.

Unknown filters stay, and are refused as in any other script.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path

from ..declaration import Arity, Bool, Enum, FileOpen, Filter, Float, Length, Parameter, Percentage, Shot, String
from ..errors import UnknownNameError, nearest
from ..meshlab.facts import Former, former_filter, former_parameters
from ..registry import find_filter
from .read import SECOND_DOCUMENT_TYPE, SLIP, FilterElement, ParamElement, build_script, parse_document, same_but_case
from .script import Change, Script, Step
from .values import OLD_TYPES, Attributes, parsed, spelled, type_complaints
from .write import NOMINAL_EDGE

_GONE = "is left out, as MeshLab has dropped it"
_NEVER_EXISTED = "no version of MeshLab has such a parameter; all ignore it"
_OTHER_CASE = "no MeshLab reads a parameter under the old name; all take its default"
_UNTYPED = "is left out: without a type every MeshLab ignores the value and takes the default"
_MISREAD = "today's MeshLab reads another value in the old script: 0, true or the default"
_DELETED = "MeshLab deleted input, result or both, depending on its version; now nothing is deleted, and the result is current"
_CURRENT = "MeshLab 2016 left the input current; today later steps work on the result, and the result is written"
_WHOLE = "without this parameter MeshLab worked only on the faces that were new and selected; now on the whole mesh"


@dataclass(frozen=True)
class Upgrade:
    """An upgraded script."""

    script: Script
    changes: tuple[Change, ...]  # in the order of the old script; empty if it was up to date

    @property
    def warnings(self) -> tuple[str, ...]:
        return tuple(str(change) for change in self.changes if not change.same_meaning)


def upgrade_script(data: bytes, name: str, *, path: Path | None = None) -> Upgrade:
    """Upgrade the script in the bytes of an .mlx file; the arguments are those of `parse_script`."""
    changes: list[Change] = []
    # Blanks replace the second document type, so that problems keep their line numbers.
    single = SECOND_DOCUMENT_TYPE.sub(lambda m: m[1].ljust(len(m[0])), data[: 1 << 16]) + data[1 << 16 :]
    if single != data:
        changes.append(Change(line=1, filter="", what="the second <!DOCTYPE FilterScript> is left out"))
    document = parse_document(single, name)
    if lines := document.later_comments:
        what = f"comments between the steps and at the end are left out ({len(lines)})"
        changes.append(Change(line=lines[0], filter="", what=what))
    filters: list[FilterElement] = []
    aged, always_current = False, set[int]()  # aged: whether some element can only come from an older MeshLab
    for element in document.filters:
        former = former_filter(element.name or "")
        aged |= element.kind == "xmlfilter" or (former is not None and not former.invented)
        aged |= any(p.attributes.get("type") in OLD_TYPES for p in element.params)
        values = {p.attributes.get("name", ""): p.attributes.get("value", "") for p in element.params}
        upgraded, of_element = _upgraded(element, values)
        if upgraded is not None:
            filters.append(upgraded)
        changes += of_element
        if former is not None and former.layers == "current":
            always_current.add(element.line)
    script = build_script(replace(document, filters=filters), path)
    names = {element.line: element.name or "" for element in document.filters}
    script, of_steps = _upgraded_steps(script, names, aged, always_current)
    return Upgrade(script, tuple(sorted([*changes, *of_steps], key=lambda change: change.line)))


def _upgraded(element: FilterElement, values: Attributes) -> tuple[FilterElement | None, list[Change]]:
    """The element in today's form (None if it is left out), and the changes; `values` are the texts of its parameters."""
    name = element.name
    if name is None:
        return element, []
    note, former = partial(Change, line=element.line, filter=name), None
    try:
        today = find_filter(name)
    except UnknownNameError:
        former = former_filter(name)
        if former is not None and former.idle:
            return None, [note(what="left out, as it never changed a mesh")]
        name_today = same_but_case(name) if former is None else former.today(values)
        if name_today is None:
            return element, []
        today = find_filter(name_today)
    changes: list[Change] = []
    if element.kind == "xmlfilter":
        changes.append(note(what="is written as <filter>, with the types of its parameters"))
    facts = [former_parameters(today.name)] if former is None else [former, former_parameters(today.name)]
    sets = {} if former is None else former.sets
    if today.name != name:
        added = "".join(f", with {parameter}={text}" for parameter, text in sets.items())
        meaning = facts[0].note or ("no MeshLab has had a filter of that name" if facts[0].invented else "")
        changes.append(note(what=f"is {today.name!r} now{added}", meaning=meaning))
    params, of_params = _upgraded_params(element, today, facts)
    declared, written = {p.xml_name: p for p in today.parameters}, {p.attributes.get("name") for p in params}
    for parameter, newer in facts[-1].newer.items():
        given, _, needed = newer.get("if", "").partition("=")
        if parameter not in {*written, *sets} and values.get(given, "").strip() == needed:
            sets = {**sets, parameter: newer["value"]}
            changes.append(note(what=f"{parameter} is {newer['value']} now, was missing", meaning=newer["meaning"]))
    for parameter, text in sets.items():
        if parameter not in written:
            attributes = {"name": parameter, "value": text.removesuffix("%")} | ({"relative": text} if text.endswith("%") else {})
            params.append(_typed(declared[parameter], attributes, element.line))
    return replace(element, kind="filter", name=today.name, params=params), changes + of_params


def _upgraded_params(element: FilterElement, today: Filter, facts: Sequence[Former]) -> tuple[list[ParamElement], list[Change]]:
    """The parameters for today's filter, and the changes; a parameter without a name stays, and is refused later."""
    params: dict[object, ParamElement] = {}
    changes: list[Change] = []
    declared = {p.xml_name: p for p in today.parameters}
    is_typed = element.kind != "xmlfilter"
    for index, param in enumerate(element.params):
        name = param.attributes.get("name")
        if name is None:
            params[index] = param
            continue
        note = partial(Change, line=param.line, filter=element.name or "", parameter=name)
        if is_typed and "type" not in param.attributes:
            changes.append(note(what=_UNTYPED))
            continue
        target = name if name in declared else _fact(facts, name, param.attributes.get("value", ""), declared)
        if isinstance(target, tuple):
            changes.append(note(what=target[0], meaning=target[1]))
            continue
        if isinstance(target, Mapping):
            values = ", ".join(f"{new}={text}" for new, text in target.items())
            changes.append(note(what=f"is {values} now" if values else "is left out: today's default is the same"))
            params |= {new: _typed(declared[new], {"name": new, "value": text}, param.line) for new, text in target.items()}
            continue
        if target != name:
            known = any(name in former.renames for former in facts)
            changes.append(note(what=f"is {target!r} now", meaning="" if known else _OTHER_CASE))
        attributes, parameter = {**param.attributes, "name": target}, declared[target]
        if any(target in former.relabelled for former in facts):  # choices have new words, but their numbers mean the same
            attributes = {k: v for k, v in attributes.items() if not k.startswith("enum_val")}
        typed = _typed(parameter, attributes, param.line)
        if target in params:
            old, new = ({**each.attributes, "min": "", "max": ""} for each in (params[target], typed))  # bounds of a slider
            meaning = "" if old == new else "the values differ, and the last one is kept"
            changes.append(note(what="was given several times, and is given once now", meaning=meaning))
        params[target] = typed
        if is_typed:
            changes += _type_changes(parameter, attributes, typed.attributes, note, runs_today=today.name == element.name)
    return list(params.values()), changes


def _fact(
    facts: Sequence[Former], name: str, value: str, declared: Mapping[str, Parameter]
) -> str | Mapping[str, str] | tuple[str, str]:
    """Today's name of a parameter; or today's parameters with equivalent values; or why it is left out, and what that changes."""
    for former in facts:
        if name in former.renames:
            return former.renames[name]
        turned = former.turned(name, value)
        if turned is not None:
            return turned
        if name in former.drops:
            neutral, number = former.drops[name], parsed(value)
            same = neutral is None or value.strip().lower() == neutral or (number is not None and number == parsed(neutral))
            return _GONE, "" if same else f"MeshLab has no such parameter any more and works as with {neutral!r}"
        if name in former.loses:
            return _GONE, former.loses[name]
    by_case = [xml for xml, p in declared.items() if name.casefold() == xml.casefold() or name == p.name]
    if len(by_case) == 1:
        return by_case[0]
    near = nearest(name, declared, cutoff=SLIP)
    return "is left out", _NEVER_EXISTED + (f"; if {near!r} is meant, write that" if near else "")


def _typed(parameter: Parameter, attributes: Attributes, line: int) -> ParamElement:
    """The element with the type and attributes that MeshLab needs; unchanged if the value does not fit."""
    typed = dict(attributes)
    numbers = [] if isinstance(parameter, Bool | String | Shot) else spelled(parameter, attributes)
    if isinstance(parameter, Bool):
        value = attributes.get("value", "").strip()
        typed["value"] = {"1": "true", "0": "false"}.get(value, value.lower())
    if any(isinstance(n, str) for n in numbers) or (isinstance(parameter, Bool) and typed["value"] not in ("true", "false")):
        return ParamElement(attributes, line)
    if isinstance(parameter, Percentage) or (isinstance(parameter, Float) and typed.get("type") != "RichFloat"):
        number = float(numbers[0])
        typed.setdefault("min", repr(min(0.0, number)))
        typed.setdefault("max", repr(number))
    elif isinstance(parameter, Enum):
        typed.setdefault("enum_cardinality", str(len(parameter.choices)))
    elif isinstance(parameter, FileOpen):
        typed.setdefault("exts_cardinality", "0")
    if list(type_complaints(parameter, typed)):
        typed["type"] = parameter.xml_type
    return ParamElement(typed, line)


def _type_changes(
    parameter: Parameter, old: Attributes, new: Attributes, note: partial[Change], *, runs_today: bool
) -> Iterator[Change]:
    """The changes in the attributes of a parameter; `runs_today` if MeshLab still has the old step's filter."""
    if old.get("type") in OLD_TYPES:
        misread = False
    elif any(type_complaints(parameter, old)):  # today's MeshLab reads a value of a wrong type as 0
        misread = new.get("value", "").lower() not in ("0", "0.0", "false") or new["type"] == old.get("type")
    else:
        misread = isinstance(parameter, Bool) and old.get("value") != new.get("value") and old.get("value", "").lower() != "true"
    meaning = _MISREAD if runs_today and misread else ""
    for attribute, text in new.items():
        if old.get(attribute) != text:
            written = f"was {old[attribute]!r}" if attribute in old else "was missing"
            yield note(what=f"{attribute} is {text!r}, {written}", meaning=meaning, parameter=parameter.xml_name)
            meaning = ""  # reported once


def _upgraded_steps(
    script: Script, names: Mapping[int, str], aged: bool, always_current: set[int]
) -> tuple[Script, list[Change]]:
    """The script with its steps fitted to today's rules for the current layer and the selection, and the changes."""
    deleting, steps, changes = set(deletes_result(script.steps)), list[Step](), list[Change]()
    for index, step in enumerate(script.steps):
        line = step.line or 0
        if index in deleting:
            by_version = not aged or script.steps[index - 1].line in always_current
            layers = (
                s.values.get("visiblelayer", s.filter.arity in (Arity.FIXED, Arity.VARIABLE)) or s.values.get("alllayers")
                for s in script.steps[index + 1 :]
            )
            meaning = _DELETED if by_version or any(layers) else ""
            what = "is left out: today it would delete the result of the step before, in MeshLab 2016 the input"
            changes.append(Change(line=line, filter=step.filter.name, what=what, meaning=meaning))
            continue
        left_current = aged and former_parameters(step.filter.name).layers == "left"
        if left_current and index + 1 not in deleting and line not in always_current:
            name = names.get(line, step.filter.name)
            changes.append(Change(line=line, filter=name, what="its result is the current layer now", meaning=_CURRENT))
        steps.append(step)
    for index, _ in list(works_on_leftover_selection(steps)):
        step = steps[index]
        what = f"{step.filter.parameter('selected').xml_name} is false now"
        changes.append(Change(line=step.line or 0, filter=step.filter.name, what=what, meaning=_WHOLE))
        steps[index] = step.with_values({"selected": False})
    return replace(script, steps=tuple(steps)), changes


def deletes_result(steps: Sequence[Step]) -> Iterator[int]:
    """The indices of the steps that today delete the result of the step before, but deleted the input in MeshLab 2016."""
    for index, (before, step) in enumerate(pairwise(steps), 1):
        if step.filter.python_name == "delete_current_mesh" and former_parameters(before.filter.name).layers == "left":
            yield index


def works_on_leftover_selection(steps: Sequence[Step]) -> Iterator[tuple[int, str]]:
    """The indices of steps that work only on the new faces that an earlier step selected, each with the earlier step's filter."""
    leftover = ""
    for index, step in enumerate(steps):
        name = step.filter.python_name
        if name.startswith(("meshing_close_holes", "meshing_bridge_rims")):
            leftover = step.filter.name if step.values.get("newfaceselected", True) is True else ""
        elif "selection" in name or name.startswith(("create_", "generate_")):
            leftover = ""
        elif leftover and step.filter.defaults.get("selected", True) is None and "selected" not in step.values:
            yield index, leftover


def relative_script(upgraded: Upgrade, diagonals: Sequence[float]) -> Upgrade:
    """The script with absolute lengths in percent of the diagonal of the mesh before their step; 0 stays 0."""
    steps, changes = list(upgraded.script.steps), list(upgraded.changes)
    for index, diagonal in enumerate(diagonals):
        step, new = steps[index], dict[str, Length]()
        for name, old in step.values.items():
            if isinstance(old, Length) and old.unit == "absolute" and old.amount:
                new[name] = Length(100.0 * old.amount / diagonal, "percent")
                what = f"is {new[name].amount:.6g}% of the diagonal {diagonal:.6g} now, was {old.amount:g}"
                parameter = step.filter.parameter(name).xml_name
                changes.append(Change(line=step.line or 0, filter=step.filter.name, parameter=parameter, what=what))
        steps[index] = replace(step.with_checked(new), size=(diagonal, NOMINAL_EDGE))
    return Upgrade(upgraded.script.with_steps(steps), tuple(sorted(changes, key=lambda change: change.line)))
