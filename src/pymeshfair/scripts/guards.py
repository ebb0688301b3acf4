"""The limits that a recipe or a command sets to the result of a run."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..declaration import Length
from ..errors import ParameterError, hint

#: the requirements on a result, and whether each takes a number
REQUIREMENTS = dict.fromkeys(("watertight", "manifold", "oriented", "printable"), False) | {"components": True, "genus": True}
#: the attributes of ``<FilterScript>`` that set guards, by the names of the fields of `Guards`
ATTRIBUTES = {"max_displacement": "maxDisplacement", "max_volume_change": "maxVolumeChange"}
ATTRIBUTES |= {"require": "require", "keep_sharp": "keepSharp"}
_PERCENT = re.compile(r"([0-9]+(?:\.[0-9]*)?|\.[0-9]+)\s*%?")


@dataclass(frozen=True)
class Guards:
    """The limits of a run; None and nothing for those that are not set."""

    #: no vertex of the input that is still there may have moved further. With a unit, such as ``0.05mm``, it must be made one of
    #: the mesh by `in_mesh_units`.
    max_displacement: Length | None = None
    #: percent of the volume before, which must not change by more, up or down; both meshes must be closed
    max_volume_change: float | None = None
    #: requirements on the result: of `REQUIREMENTS`, with the number for those that take one, else None
    require: tuple[tuple[str, int | None], ...] = ()
    keep_sharp: float | None = None  # percent of the length of the sharp edges near which there must still be one

    def __bool__(self) -> bool:
        """Whether anything is guarded."""
        return self != NO_GUARDS

    @classmethod
    def parse(cls, texts: Mapping[str, str]) -> Guards:
        """The guards that texts spell, by the names of the fields; raise `ParameterError` for other names and texts."""
        for name in texts.keys() - ATTRIBUTES.keys():
            raise ParameterError(f"there is no limit {name!r}; {hint(name, ATTRIBUTES)}")
        readers: Mapping[str, Callable[[str, str], Any]] = {"max_displacement": _length, "require": _requirements}
        return cls(**{name: readers.get(name, _percent)(name, text) for name, text in texts.items()})

    def texts(self) -> dict[str, str]:
        """The texts that `parse` reads, of the guards that are set."""

        def text(limit: Any) -> str:
            if isinstance(limit, tuple):
                return ",".join(word if number is None else f"{word}={number}" for word, number in limit)
            return str(limit) if isinstance(limit, Length) else f"{limit!r}%"

        return {name: text(limit) for name, limit in self._limits.items()}

    def overridden(self, others: Guards) -> Guards:
        """These guards with the ones that `others` sets in their places."""
        return replace(self, **others._limits)

    @property
    def _limits(self) -> dict[str, Any]:
        """The guards that are set, by name."""
        return {name: limit for name, limit in vars(self).items() if limit not in (None, ())}

    def in_mesh_units(self, unit: str | None) -> Guards:
        """These guards on a scan in that unit of `pymeshfair.declaration.parameters.METRES`, or None if it is not known."""
        moved = self.max_displacement
        return self if moved is None else replace(self, max_displacement=moved.in_mesh_units(unit))


NO_GUARDS = Guards()  # no limit at all


def refuse_unmeasured(guards: Guards) -> None:
    """Refuse limits where no measures are taken."""
    if guards:
        named = ", ".join(f"{name.replace('_', '-')} {text}" for name, text in guards.texts().items())
        raise ParameterError(
            f"limits need measures: {named}; leave out --no-measures (measures=False), or the limits (those of a recipe are "
            "attributes of its <FilterScript>)"
        )


def _length(name: str, text: str) -> Length:
    length = Length.parse(text)
    if length.amount < 0.0:
        raise ParameterError(f"{name} {text!r} is below 0")
    return length


def _percent(name: str, text: str) -> float:
    match = _PERCENT.fullmatch(text.strip())
    if match is None or not math.isfinite(float(match[1])):
        raise ParameterError(f"{name} {text!r} is no percentage: write it as 1% or 0.5%")
    if name == "keep_sharp" and float(match[1]) > 100.0:
        raise ParameterError(f"{name} {text!r} is above 100 %")
    return float(match[1])


def _requirements(name: str, text: str) -> tuple[tuple[str, int | None], ...]:
    requirements: list[tuple[str, int | None]] = []
    offered = "it takes " + ", ".join(f"{word}=N" if takes else word for word, takes in REQUIREMENTS.items())
    for part in text.split(","):
        word, sign, number = (piece.strip() for piece in part.partition("="))
        if word not in REQUIREMENTS:
            raise ParameterError(f"{name}: {word!r} is nothing that can be required; {hint(word, REQUIREMENTS, offered)}")
        if bool(sign) != REQUIREMENTS[word] or (sign and not (number.isascii() and number.isdigit() and len(number) < 10)):
            raise ParameterError(f"{name}: {part.strip()!r}; {offered}")
        requirements.append((word, int(number) if sign else None))
    return tuple(requirements)
