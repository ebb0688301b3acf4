"""Brings a script of an older MeshLab up to date, from the table of facts about former filters and parameters.

Every change states whether the script keeps its meaning, and if not, what it does now. Filters without a fact stay as they are
and are refused as in any other script. Upgrading an upgraded script changes nothing.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..declaration import Bool, Enum, FileOpen, Filter, Float, Length, Parameter, Percentage, Point
from ..errors import UnknownNameError
from ..meshlab.facts import Former, former_filter, former_parameters
from ..registry import find_filter
from .problems import Change
from .read import SECOND_DOCUMENT_TYPE, parse_document
from .script import FilterElement, ParamElement, Script, Step
from .step_builder import OLD_TYPES, WHOLE, build_script, parsed, type_complaints
from .suggestions import close_spelling, same_but_case
from .upgraded_steps import CurrentLayer, upgraded_steps

_GONE = "is left out, as MeshLab has dropped it"
_UNHEARD_OF = "no version of MeshLab has such a parameter; all ignore it"
_UNTYPED = "is left out: without a type every MeshLab ignores the value and takes its default (--mend keeps it)"
_MISREAD = "today's MeshLab reads another value here: 0 or its default"


def upgraded_params(
    element: FilterElement, today: Filter, facts: Sequence[Former], *, mend: bool
) -> tuple[list[ParamElement], list[Change]]:
    """The parameters for today's filter, and the changes.

    A value without a type, which every MeshLab ignores, is left out, or kept with `mend`. A parameter that MeshLab has never had
    is left out; one without a name stays, to be refused.
    """
    params: dict[object, ParamElement] = {}
    changes: list[Change] = []
    old = element.name or ""
    declared = {p.xml_name: p for p in today.parameters}
    for index, param in enumerate(element.params):
        name = param.attributes.get("name")
        if name is None:
            params[index] = param
            continue
        if not mend and element.kind != "xmlfilter" and "type" not in param.attributes:
            changes.append(Change(line=param.line, filter=old, parameter=name, what=_UNTYPED))
            continue
        target = name if name in declared else _fact(facts, name, param, declared)
        if isinstance(target, Change):
            changes.append(Change(line=param.line, filter=old, parameter=name, what=target.what, meaning=target.meaning))
            continue
        if isinstance(target, Mapping):
            values = ", ".join(f"{new}={text}" for new, text in target.items()) or "today's default is the same"
            changes.append(Change(line=param.line, filter=old, parameter=name, what=f"is left out: {values}"))
            for new, text in target.items():
                params[new] = _typed(declared[new], {"name": new, "value": text}, param.line)
            continue
        if target not in declared:
            near = close_spelling(name, [*declared])
            meaning = _UNHEARD_OF + (f"; if {near!r} is meant, write that" if near else "")
            changes.append(Change(line=param.line, filter=old, parameter=name, what="is left out", meaning=meaning))
            continue
        if target != name:
            changes.append(Change(line=param.line, filter=old, parameter=name, what=f"is {target!r} now"))
        if target in params:
            meaning = "" if params[target].attributes == param.attributes else "the last of the two values counts, as in MeshLab"
            changes.append(Change(line=param.line, filter=old, parameter=name, what="is given once", meaning=meaning))
        if any(target in former.relabelled for former in facts) and (change := _relabelled(declared[target], param, old)):
            changes.append(change)
            param = ParamElement({k: v for k, v in param.attributes.items() if not k.startswith("enum_val")}, param.line)
        params[target] = _typed(declared[target], {**param.attributes, "name": target}, param.line)
        if element.kind != "xmlfilter":
            changes += _type_changes(declared[target], param, params[target], element, runs_today=today.name == old)
    return list(params.values()), changes


def _fact(
    facts: Sequence[Former], name: str, param: ParamElement, declared: Mapping[str, Parameter]
) -> str | Mapping[str, str] | Change:
    """Today's name of a parameter, or equivalent values by name, or why it is left out; the same name if there is no fact."""
    value = param.attributes.get("value", "")
    for former in facts:
        if name in former.renames:
            return former.renames[name]
        turned = former.turned(name, value)
        if turned is not None:
            return turned
        if name in former.drops:
            neutral = former.drops[name]
            number = parsed(value)
            same = neutral is None or value.strip().lower() == neutral or (number is not None and number == parsed(neutral))
            meaning = "" if same else f"MeshLab has no such parameter any more and does what {neutral} did"
            return Change(line=param.line, filter="", what=_GONE, meaning=meaning)
        if name in former.loses:
            return Change(line=param.line, filter="", what=_GONE, meaning=former.loses[name])
    by_case = [xml for xml, p in declared.items() if name.casefold() == xml.casefold() or name == p.name]
    return by_case[0] if len(by_case) == 1 else name


def _typed(parameter: Parameter, attributes: Mapping[str, str], line: int) -> ParamElement:
    """The element with the type and attributes that MeshLab needs; unchanged if the value cannot be read as that type."""
    typed, is_readable = dict(attributes), True
    value = typed.get("value", "")
    if isinstance(parameter, Bool):
        typed["value"] = {"1": "true", "0": "false"}.get(value.strip(), value.strip().lower())
        is_readable = typed["value"] in ("true", "false")
    elif isinstance(parameter, Point):
        is_readable = all(parsed(typed.get(axis, "")) is not None for axis in "xyz")
    elif isinstance(parameter, Float | Percentage):
        number = parsed(value)
        is_readable = number is not None
        if number is not None and (typed.get("type") != "RichFloat" or parameter.xml_type == "RichAbsPerc"):
            typed.setdefault("min", repr(min(0.0, number)))
            typed.setdefault("max", repr(number))
    elif isinstance(parameter, Enum) or parameter.xml_type in ("RichInt", "RichMesh"):
        is_readable = WHOLE.fullmatch(value) is not None
        if isinstance(parameter, Enum):
            typed.setdefault("enum_cardinality", str(len(parameter.choices)))
    elif isinstance(parameter, FileOpen):
        typed.setdefault("exts_cardinality", "0")
    if not is_readable:
        return ParamElement(attributes, line)
    if list(type_complaints(parameter, typed)):
        typed["type"] = parameter.xml_type
    return ParamElement(typed, line)


def _relabelled(parameter: Parameter, param: ParamElement, filter_name: str) -> Change | None:
    """The change for a choice whose number has another word today; None if the word is the same."""
    value = param.attributes.get("value", "").strip()
    word = param.attributes.get(f"enum_val{value}")
    if not isinstance(parameter, Enum) or word is None or not value.isdigit() or int(value) >= len(parameter.choices):
        return None
    today = parameter.choices[int(value)]
    if word == today:
        return None
    what = f"keeps the number {value}; the former choice {word!r} is called {today!r} today"
    return Change(line=param.line, filter=filter_name, parameter=parameter.xml_name, what=what)


def _type_changes(
    parameter: Parameter, old: ParamElement, new: ParamElement, element: FilterElement, *, runs_today: bool
) -> Iterator[Change]:
    """The changes in the attributes of a parameter; `runs_today` if MeshLab still has the old step's filter."""
    before, misread = old.attributes, _is_misread(parameter, old.attributes, new.attributes)
    meaning = _MISREAD if (misread and runs_today) or "type" not in before else ""
    for attribute, text in new.attributes.items():
        if attribute != "name" and before.get(attribute) != text:
            written = f"was {before[attribute]!r}" if attribute in before else "was missing"
            what = f"{attribute} is {text!r}, {written}"
            yield Change(line=old.line, filter=element.name or "", parameter=parameter.xml_name, what=what, meaning=meaning)
            meaning = ""  # reported once


def _is_misread(parameter: Parameter, old: Mapping[str, str], new: Mapping[str, str]) -> bool:
    """Whether today's MeshLab reads another value from the old attributes than from the new ones."""
    value = old.get("value", "")
    if old.get("type") in OLD_TYPES:
        return False
    if any(type_complaints(parameter, old)):  # it reads a value of a wrong type as 0
        return new.get("value", "").lower() not in ("0", "0.0", "false") or new["type"] == old.get("type")
    return isinstance(parameter, Bool) and value.lower() not in ("true", new["value"])


@dataclass(frozen=True)
class Upgrade:
    """A script as today's MeshLab runs it."""

    script: Script  # the steps
    changes: tuple[Change, ...]  # in the order of the old script; empty if it was up to date

    @property
    def warnings(self) -> tuple[str, ...]:
        """The changes that alter the meaning of the script."""
        return tuple(str(change) for change in self.changes if not change.same_meaning)


def upgrade_script(data: bytes, name: str, *, path: Path | None = None, mend: bool = False) -> Upgrade:
    """The upgraded script in the bytes of an .mlx file; `name` stands for the file in messages.

    A value without a type, which every MeshLab ignores, is left out; with `mend` it is kept.

    Raises:
        ScriptError: something is wrong that no upgrade cures; lists every problem.
    """
    changes: list[Change] = []
    # blanks in the place of the second, so that all else stays in its place
    once = SECOND_DOCUMENT_TYPE.sub(lambda m: m[1].ljust(len(m[0])), data[: 1 << 16]) + data[1 << 16 :]
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
            what = "left out: in a run of one mesh file the layer that it selects is already current today"
            meaning = "in a run of several mesh files it made another layer current"
            changes.append(Change(line=element.line, filter=element.name or "", what=what, meaning=meaning))
            if current.maker is not None:
                result_stays_current.add(current.maker)
            continue
        upgraded, of_element = _upgraded(element, values, mend=mend)
        for step in upgraded:
            current.go_on(step, values)
        changes += of_element
        filters += upgraded
        if former is not None and former.layers == "current":
            result_stays_current.add(element.line)
    script = build_script(replace(document, filters=tuple(filters)), path)
    names = {element.line: element.name or "" for element in document.filters}
    script, of_steps = upgraded_steps(script, names, aged=aged, always_current=frozenset(result_stays_current))
    changes += of_steps
    return Upgrade(script, tuple(sorted(changes, key=lambda change: change.line)))


def _upgraded(element: FilterElement, values: Mapping[str, str], *, mend: bool) -> tuple[list[FilterElement], list[Change]]:
    """Today's element, none if it is left out, and the changes; `values` are those of its parameters."""
    name = element.name
    if name is None:
        return [element], []
    former, today = _today(name, values)
    if former is not None and former.idle:
        return [], [Change(line=element.line, filter=name, what="left out, as it never changed a mesh")]
    if today is None:
        return [element], []
    changes = list(_name_changes(element, name, today, former))
    facts = [f for f in (former, former_parameters(today.name)) if f is not None]
    params, of_params = upgraded_params(element, today, facts, mend=mend)
    written: set[str | None] = {p.attributes.get("name") for p in params}
    for parameter, text in ({} if former is None else former.sets).items():
        if parameter not in written:
            declared = next(p for p in today.parameters if p.xml_name == parameter)
            added = ParamElement({"type": declared.xml_type, "name": parameter, "value": text}, element.line)
            more, _ = upgraded_params(replace(element, params=(added,)), today, [], mend=False)
            params += more
    return [replace(element, kind="filter", name=today.name, params=tuple(params))], changes + of_params


def _is_old(element: FilterElement, former: Former | None) -> bool:
    """Whether only an older MeshLab can have written the element."""
    old_types = any(p.attributes.get("type") == "RichPoint3f" for p in element.params)
    return element.kind == "xmlfilter" or old_types or (former is not None and not former.invented)


def _today(name: str, values: Mapping[str, str]) -> tuple[Former | None, Filter | None]:
    """The facts about a former name, and the filter that it means today with these values."""
    try:
        return None, find_filter(name)
    except UnknownNameError:
        former = former_filter(name)
    today = same_but_case(name) if former is None else former.today(values)
    return former, None if today is None else find_filter(today)


def _name_changes(element: FilterElement, name: str, today: Filter, former: Former | None) -> Iterator[Change]:
    """The changes of the tag and the name of a filter."""
    if element.kind == "xmlfilter":
        yield Change(line=element.line, filter=name, what="is written as <filter>, with the types of its parameters")
    if today.name != name:
        sets = {} if former is None else former.sets
        added = "".join(f", with {parameter}={text}" for parameter, text in sets.items())
        meaning = "" if former is None else former.note
        if former is not None and former.invented and not meaning:
            meaning = "no MeshLab has had a filter of that name"
        yield Change(line=element.line, filter=name, what=f"is {today.name!r} now{added}", meaning=meaning)


def relative_script(script: Script, *, diagonal: float) -> Script:
    """The script with absolute lengths in percent of the diagonal of the mesh that it was written for; 0 stays 0."""
    return script.with_steps(_relative(step, diagonal) for step in script.steps)


def _relative(step: Step, diagonal: float) -> Step:
    lengths = {
        name: Length(100.0 * value.amount / diagonal, "percent")
        for name, value in step.values.items()
        if isinstance(value, Length) and value.unit == "absolute" and value.amount
    }
    return step.with_checked(lengths)
