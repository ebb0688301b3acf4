"""A recipe as a table of a notebook."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from ..scripts import Script, Step


def recipe_table(name: str, script: Script) -> str:
    """HTML: the title, the settings, and one row a step with the values that are not the defaults."""
    title = script.comment.partition("\n")[0].strip() or name
    parts = [f"<p><b>{escape(title)}</b></p>"]
    if script.settings:
        rows = ((s.name, s.default, s.unit, s.description) for s in script.settings)
        parts.append(_table(("setting", "value", "unit", "meaning"), rows))
    steps = ((str(n), step.filter.name, _values(step), step.tag) for n, step in enumerate(script.steps, 1))
    parts.append(_table(("step", "filter", "values", "tag"), steps))
    return "\n".join(parts)


def _values(step: Step) -> str:
    said = {name: value for name, value in step.values.items() if value != step.filter.defaults[name] or name in step.settings}
    return ", ".join(f"{name} = {step.settings.get(name, value)}" for name, value in said.items())


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    lines = ["<table>", f"<tr>{''.join(f'<th>{escape(word)}</th>' for word in head)}</tr>"]
    lines += [f"<tr>{''.join(f'<td>{escape(word)}</td>' for word in row)}</tr>" for row in rows]
    return "\n".join([*lines, "</table>"])
