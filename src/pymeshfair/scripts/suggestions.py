"""Suggestions for wrong names: from the facts about older MeshLab versions, else by similar spelling."""

from collections.abc import Iterable
from difflib import SequenceMatcher

from ..declaration import Enum
from ..errors import plain_name
from ..meshlab.facts import Former, former_parameters
from ..registry import all_filters, find_filter

#: from so many letters on a name may have so many slips; ``Delete Selection`` is not meant to be ``Dilate Selection``
_SLIPS = ((20, 2), (4, 1), (0, 0))


def close_spelling(name: str, names: Iterable[str]) -> str | None:
    """The only one of `names` that differs from `name` by case, spaces or a slip or two; None if there is none or several."""
    plain = plain_name(name)
    allowed = next(slips for letters, slips in _SLIPS if len(plain) >= letters)
    slips = {other: _slips(plain, plain_name(other), allowed) for other in names}
    least = min(slips.values(), default=allowed)
    closest = [other for other, count in slips.items() if count == least <= allowed]
    return closest[0] if len(closest) == 1 else None


def suggested_filter(name: str) -> str | None:
    """The name in menus of the filter that a slip of spelling leads to, whether in its name in menus or in Python."""
    filters = all_filters()
    menu = close_spelling(name, (f.name for f in filters))
    python = close_spelling(name, (f.python_name for f in filters)) if menu is None and name.isidentifier() else None
    return menu or (find_filter(python).name if python else None)


def same_but_case(name: str) -> str | None:
    """The name of the filter that is written so but for capital letters and spaces; None if there is none."""
    plain = plain_name(name)
    return next((f.name for f in all_filters() if plain_name(f.name) == plain), None)


def about_former(former: Former) -> str:
    """The sentence about a filter that has another name today, or that there is no more or never was."""
    if former.idle:
        return "MeshLab has dropped this filter, which changed nothing; leave it out, or let `pymeshfair upgrade` do so"
    if former.now is None:
        which = "; `pymeshfair upgrade` writes the one that is meant" if former.splits else ""
        return f"there is no such filter today: {former.note}{which}"
    if former.invented:
        note = f": {former.note}" if former.note else ""
        return f"no MeshLab has had a filter of that name; {former.now!r} is what comes closest{note}"
    sentence, declared = f"MeshLab has renamed this filter to {former.now!r}", find_filter(former.now).parameters
    for name, text in former.sets.items():
        parameter = next(p for p in declared if p.xml_name == name)
        meaning = f" ({parameter.choices[int(text)]})" if isinstance(parameter, Enum) else ""
        sentence += f"; give it the parameter {name} with the value {text}{meaning}"
    if renames := former_parameters(former.now).renames:
        sentence += "; of its parameters " + ", ".join(f"{old} is {new}" for old, new in renames.items())
    return sentence + "; `pymeshfair upgrade` rewrites it"


def former_parameter_hint(former: Former, name: str) -> tuple[str, str | None]:
    """Today's form of an old parameter, as the end of a sentence, and the parameter to write instead; empty if not known."""
    if name in former.renames:
        return f"it is called {former.renames[name]!r} now; `pymeshfair upgrade` rewrites it", former.renames[name]
    if name in former.turns:
        values = " and ".join(sorted({new for case in former.turns[name].values() for new in case}))
        return f"{values} says that now; `pymeshfair upgrade` rewrites it", None
    if name in {*former.drops, *former.loses}:
        return "MeshLab has dropped it; `pymeshfair upgrade` leaves it out", None
    return "", None


def _slips(first: str, second: str, most: int) -> int:
    """How many letters are added, dropped, changed or moved; of words that differ more in length, `most` + 1."""
    if abs(len(first) - len(second)) > most:
        return most + 1
    blocks = SequenceMatcher(None, first, second, autojunk=False).get_matching_blocks()
    return max(len(first), len(second)) - sum(block.size for block in blocks)
