"""What two scripts do differently."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import SequenceMatcher

from ..scripts import Script, Step


def differences(first: Script, second: Script) -> list[str]:
    """One sentence for each step that only one of them has and for each value that differs; values that are not said count as
    their defaults, so that scripts which do the same have no difference.
    """
    ours, theirs = first.with_defaults().steps, second.with_defaults().steps
    names, other_names = ([step.filter.python_name for step in steps] for steps in (ours, theirs))
    found: list[str] = []
    for kind, i, i_end, j, j_end in SequenceMatcher(None, names, other_names, autojunk=False).get_opcodes():
        if kind == "equal":
            for k in range(i_end - i):
                found += _changed(ours[i + k], theirs[j + k], j + k + 1)
            continue
        found += [f"step {k + 1}, {ours[k].filter.name}, is left out" for k in range(i, i_end)]
        found += [f"step {k + 1}, {theirs[k].filter.name}, is new" for k in range(j, j_end)]
    if first.guards != second.guards:
        found.append(f"limits are {second.guards.texts() or 'none'}, not {first.guards.texts() or 'none'}")
    return found


def _changed(ours: Step, theirs: Step, number: int) -> Iterator[str]:
    for parameter in theirs.filter.parameters:
        before, after = (step.values.get(parameter.name) for step in (ours, theirs))
        if before != after:
            said = ["what suits the mesh" if value is None else value for value in (after, before)]
            yield f"step {number}, {theirs.filter.name}: {parameter.name} is {said[0]}, not {said[1]}"
