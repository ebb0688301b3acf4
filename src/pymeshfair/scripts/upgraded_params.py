"""The values of one filter of an old script, under the names and in the types of today."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ..declaration import Bool, Enum, FileOpen, Filter, Float, Parameter, Percentage, Point
from ..meshlab.former import Former
from .changes import Change
from .elements import FilterElement, ParamElement
from .param_types import OLD_TYPES, WHOLE, parsed, type_complaints
from .suggestions import close_spelling

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
