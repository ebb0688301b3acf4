"""The attributes of a ``<Param>`` that say its type, and the spelling of numbers, as MeshLab reads them."""

import math
import re
from collections.abc import Iterator, Mapping

from ..declaration import Parameter
from .problems import shortened

Attributes = Mapping[str, str]
#: the mistake, and the text to write instead
Complaint = tuple[str, "str | None"]

_NUMBERS = frozenset({"RichFloat", "RichDynamicFloat", "RichAbsPerc"})
_POINTS = frozenset({"RichPosition", "RichDirection"})
#: the types that MeshLab reads into the same kind of value, by the parameter's own type
_ACCEPTED: Mapping[str, frozenset[str]] = {
    "RichFloat": _NUMBERS,
    "RichDynamicFloat": _NUMBERS,
    "RichAbsPerc": _NUMBERS,
    "RichEnum": frozenset({"RichEnum", "RichInt"}),
    "RichMesh": frozenset({"RichMesh", "RichInt"}),
    "RichPosition": _POINTS,
    "RichDirection": _POINTS,
    "RichOpenFile": frozenset({"RichOpenFile", "RichString"}),
    "RichSaveFile": frozenset({"RichSaveFile", "RichString"}),
}
#: the attributes that MeshLab needs to keep a parameter of that type, and whether each is a whole number
_REQUIRED: Mapping[str, Mapping[str, bool]] = {
    "RichDynamicFloat": {"min": False, "max": False},
    "RichAbsPerc": {"min": False, "max": False},
    "RichEnum": {"enum_cardinality": True},
    "RichOpenFile": {"exts_cardinality": True},
}
#: names that types once had
OLD_TYPES = frozenset({"RichPoint3f"})
#: MeshLab allocates as many words as a script announces
_MOST_CHOICES = 1000

WHOLE = re.compile(r"\s*[+-]?[0-9]{1,20}\s*")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_MOST_DIGITS = 400


def type_complaints(parameter: Parameter, attributes: Attributes) -> Iterator[Complaint]:
    """Faults by which MeshLab cannot read the value: a type of another kind, or a missing attribute."""
    written = attributes.get("type")
    if written is None:
        yield "the attribute type is missing; MeshLab would drop the parameter and take its default", parameter.xml_type
        return
    if written not in _ACCEPTED.get(parameter.xml_type, {parameter.xml_type}):
        if written in OLD_TYPES:
            yield f"type {written!r} is an old name", parameter.xml_type
        else:
            yield (
                f"has the type {parameter.xml_type}, not {shortened(written)!r}; MeshLab would take 0 or the default",
                parameter.xml_type,
            )
        return
    for name, whole in _REQUIRED.get(written, {}).items():
        text = attributes.get(name)
        if text is None:
            yield f"the attribute {name} is missing; MeshLab would drop the parameter and take its default", None
        elif not (WHOLE.fullmatch(text) and 0 <= int(text) <= _MOST_CHOICES if whole else parsed(text) is not None):
            needed = f"a whole number from 0 to {_MOST_CHOICES}" if whole else "a number"
            yield f"the attribute {name} must be {needed}, got {shortened(text)!r}", None


def parsed(text: str) -> float | None:
    """The finite number that the text spells as MeshLab reads it, with blanks around it; None if it spells none."""
    if len(text) > _MOST_DIGITS or _NUMBER.fullmatch(text.strip()) is None:
        return None
    number = float(text)
    return number if math.isfinite(number) else None
