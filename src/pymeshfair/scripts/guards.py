"""The conditions under which a recipe fits a scan, and the limits on its result. Commands may set limits, too.

The ``Fits:`` paragraph of a recipe's head lists conditions, as in ``Fits: mesh, noise 0.1 to 0.4 edges, sharp``. Each is a word,
or a quantity with bounds: ``from A``, ``up to B``, ``A to B``. ``no`` before a word negates it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from ..declaration import Length
from ..errors import ParameterError, hint, nearest

SHARP = 0.68  # a sharp surface has at least this share of bending at sharp edges: machine parts 0.7 to 0.95, statues up to 0.66
ONE_SIDED = 0.4  # the least trait `facing` of a range map: the length of its area-weighted mean normal; half a sphere has 0.5

#: by word: the trait (a number measured on a scan), its lower and upper bound, and the texts for a scan within and outside them
WORDS: Mapping[str, tuple[str, float, float, str, str]] = {
    "mesh": ("mesh", 1, 1, "there are faces", "there are no faces"),
    "cloud": ("cloud", 1, 1, "there are points alone", "there are faces or edges"),
    "curves": ("curves", 1, 1, "there are edges and no faces", "there are no curves"),
    "closed": ("closed", 1, 1, "the surface is closed", "the surface has borders or is not manifold"),
    "open": ("border edges", 1, math.inf, "there are borders", "there is no border"),
    "range map": ("facing", ONE_SIDED, math.inf, "the surface is seen from one side", "the surface faces all sides"),
    "camera noise": ("camera noise", 1, 1, "there is noise that neighbours share", "there is no noise that neighbours share"),
    "sharp": ("sharpness", SHARP, 1, "most of the bending is at sharp edges", "much of the bending is not at sharp edges"),
    "smooth": ("sharpness", 0, SHARP, "much of the bending is not at sharp edges", "most of the bending is at sharp edges"),
    "texture": ("texture", 1, 1, "there is a texture", "there is no texture"),
}
#: the quantities that are counts, and the quantities that need an article in a sentence
COUNTS, ARTICLE = ("vertices", "faces", "pieces", "border edges"), ("longest edge",)
#: by quantity, which is the name of a trait: the unit after the number, if any
QUANTITIES: Mapping[str, str] = {"noise": "edges", "longest edge": "edges", **dict.fromkeys(COUNTS, ""), "triangle quality": ""}
UNKNOWN = "is not known"  # the end of the sentence about a trait that could not be measured
_NUMBER = r"[0-9][0-9,]*(?:\.[0-9]+)?|\.[0-9]+"
_BOUNDS = re.compile(
    rf"(?:from (?P<from>{_NUMBER})|up to (?P<up>{_NUMBER})|(?P<low>{_NUMBER}) to (?P<high>{_NUMBER}))(?P<unit>.*)"
)


@dataclass(frozen=True)
class Condition:
    """One condition under which a recipe fits a scan."""

    text: str  # as the recipe writes it
    trait: str
    least: float
    most: float
    outside: bool = False  # whether the trait must lie outside the bounds, as after ``no``

    def is_met(self, traits: Mapping[str, float]) -> bool:
        value = traits.get(self.trait)
        return value is not None and (self.least <= value <= self.most) != self.outside

    def found(self, traits: Mapping[str, float]) -> str:
        """The trait of a scan, as the end of a sentence."""
        value = traits.get(self.trait)
        if value is None:
            return f"its {self.trait} {UNKNOWN}"
        word = WORDS.get(self.text.removeprefix("no "))
        if word is not None:
            return word[3] if word[1] <= value <= word[2] else word[4]
        unit = QUANTITIES.get(self.trait, "")
        if self.trait in COUNTS:
            return f"there are {value:,.0f} {self.trait}"
        return f"{'the ' if self.trait in ARTICLE else ''}{self.trait} is {value:.2g}{f' {unit}' if unit else ''}"


def parse_fits(text: str) -> tuple[Condition, ...]:
    """The conditions in the text after ``Fits:``; none in an empty text."""
    parts = re.split(r",\s+", text.strip().removesuffix("."))
    return tuple(_condition(" ".join(part.split())) for part in parts if part.strip())


def _condition(text: str) -> Condition:
    word = text.removeprefix("no ")
    if word in WORDS:
        trait, least, most, *_ = WORDS[word]
        return Condition(text, trait, least, most, outside=word != text)
    for name, unit in QUANTITIES.items():
        match = _BOUNDS.fullmatch(text.removeprefix(name).strip()) if text.startswith(f"{name} ") else None
        if match is None:
            continue
        if match["unit"].strip() != unit:
            raise ParameterError(f"Fits: {text!r}: {name} {f'is in {unit}' if unit else 'has no unit'}")
        low, high = match["from"] or match["low"] or "-inf", match["up"] or match["high"] or "inf"
        least, most = (float(bound.replace(",", "")) for bound in (low, high))
        if least > most:
            raise ParameterError(f"Fits: {text!r}: nothing lies between these bounds")
        return Condition(text, name, least, most)
    names = [*WORDS, *QUANTITIES]
    name = re.split(r"\s+(?:from|up|[0-9.])", word)[0]
    bounds = " A quantity has bounds, such as 'up to 3', 'from 1' or '1 to 3'" if nearest(name, names) in QUANTITIES else ""
    raise ParameterError(f"Fits: {text!r} is no condition; {hint(name, names)}{bounds}")


#: the requirements on a result, and whether each takes a number
REQUIREMENTS = dict.fromkeys(("watertight", "manifold", "oriented", "outward", "printable"), False)
REQUIREMENTS |= {"components": True, "genus": True}
#: by field of `Guards`: the attribute of ``<FilterScript>`` that sets it
ATTRIBUTES = {"max_displacement": "maxDisplacement", "max_volume_change": "maxVolumeChange"}
ATTRIBUTES |= {"require": "require", "keep_sharp": "keepSharp"}
_PERCENT = re.compile(r"((?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:e[+-]?[0-9]+)?)\s*%?")


@dataclass(frozen=True)
class Guards:
    """The limits of a run; a limit that is not set is None or empty."""

    max_displacement: Length | None = None  # of a vertex from its place in the input, or in a new mesh from the input's surface
    max_volume_change: float | None = None  # percent of the input's volume, up or down; both meshes must be closed
    require: tuple[tuple[str, int | None], ...] = ()  # words of `REQUIREMENTS`, each with its number, or None if it takes none
    keep_sharp: float | None = None  # the least share of the length of sharp edges that must stay sharp, in percent

    def __bool__(self) -> bool:
        return self != NO_GUARDS

    @classmethod
    def parse(cls, texts: Mapping[str, Any], names: Mapping[str, str] | None = None) -> Guards:
        """Parses limits from texts by field; raises `ParameterError` for a wrong one. `names`: field names for messages."""
        for name, text in texts.items():
            if name not in ATTRIBUTES:
                raise ParameterError(f"there is no limit {name!r}; {hint(name, ATTRIBUTES)}")
            if not isinstance(text, str):
                raise ParameterError(f"{name} is {text!r}: write a text, such as {'watertight' if name == 'require' else '1%'!r}")
        share = partial(_percent, most=100.0)
        readers: dict[str, Any] = {"max_displacement": _length, "require": _requirements, "keep_sharp": share}
        names = names or {name: name for name in texts}
        return cls(**{name: readers.get(name, _percent)(names[name], text) for name, text in texts.items()})

    def texts(self) -> dict[str, str]:
        def text(limit: Any) -> str:
            if isinstance(limit, tuple):
                return ",".join(word if number is None else f"{word}={number}" for word, number in limit)
            return str(limit) if isinstance(limit, Length) else f"{limit!r}%"

        return {name: text(limit) for name, limit in self._limits.items()}

    def overridden(self, others: Guards) -> Guards:
        return replace(self, **others._limits)

    @property
    def _limits(self) -> dict[str, Any]:
        return {name: limit for name, limit in vars(self).items() if limit not in (None, ())}

    def in_mesh_units(self, unit: str | None) -> Guards:
        """These limits, with units converted for a scan in `unit`: one of `pymeshfair.declaration.parameters.METRES`, or None."""
        moved = self.max_displacement
        return self if moved is None else replace(self, max_displacement=moved.in_mesh_units(unit))


NO_GUARDS = Guards()


def refuse_unmeasured(guards: Guards) -> None:
    """Refuse limits for a run that takes no measures."""
    if guards:
        limits = ", ".join(f"{name.replace('_', '-')} {text}" for name, text in guards.texts().items())
        raise ParameterError(
            f"limits need measures: {limits}; leave out --no-measures (measures=False), or the limits (those of a recipe are "
            "attributes of its <FilterScript>)"
        )


def _length(name: str, text: str) -> Length:
    length = Length.parse(text, name)
    if length.amount < 0.0:
        raise ParameterError(f"{name} {text!r} is below 0")
    return length


def _percent(name: str, text: str, most: float = math.inf) -> float:
    match = _PERCENT.fullmatch(text.strip())
    if match is None or not math.isfinite(float(match[1])):
        raise ParameterError(f"{name} {text!r} is no percentage: write it as 1% or 0.5%")
    if float(match[1]) > most:
        raise ParameterError(f"{name} {text!r} is above {most:g} %")
    return float(match[1])


def _requirements(name: str, text: str) -> tuple[tuple[str, int | None], ...]:
    requirements: list[tuple[str, int | None]] = []
    allowed = "allowed are " + ", ".join(f"{word}=N" if takes else word for word, takes in REQUIREMENTS.items())
    for part in text.split(","):
        word, sign, number = (piece.strip() for piece in part.partition("="))
        if word not in REQUIREMENTS:
            raise ParameterError(f"{name}: {word!r} is no requirement; {hint(word, REQUIREMENTS, allowed)}")
        if bool(sign) != REQUIREMENTS[word] or (sign and not (number.isascii() and number.isdigit() and len(number) < 10)):
            raise ParameterError(f"{name}: {part.strip()!r} is wrong; {allowed}")
        requirements.append((word, int(number) if sign else None))
    return tuple(requirements)
