"""Everything that a recipe says about itself, as data and as a page of text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from ..recipe import Recipe
from ..scripts.script import Step
from ..scripts.settings import Setting
from .filter_page import said


def recipe_document(recipe: Recipe) -> dict[str, Any]:
    """The recipe in terms of JSON."""
    return {
        "name": recipe.name,
        "title": recipe.title,
        "task": recipe.info.task,
        "fits": recipe.info.fits,
        "description": recipe.description,
        "settings": [{k: v for k, v in asdict(s).items() if k != "line"} for s in recipe.script.settings],
        "steps": [_step_document(step) for step in recipe.script.steps],
    }


def _step_document(step: Step) -> dict[str, Any]:
    return {
        "python_name": step.filter.python_name,
        "name": step.filter.name,
        "tag": step.tag,
        "parameters": {name: said(value) for name, value in step.values.items()},
        "settings": step.settings,
    }


def recipe_page(recipe: Recipe) -> str:
    """The recipe for people: what it is for, what can be set, and its steps."""
    return "\n".join(_lines(recipe))


def _lines(recipe: Recipe) -> Iterator[str]:
    yield f"{recipe.name}: {recipe.title}\n\n{recipe.description}\n"
    if recipe.script.settings:
        yield "Settings (--set NAME=VALUE)"
        yield from (f"      {setting_line(setting)}" for setting in recipe.script.settings)
        yield ""
    yield "Steps"
    for number, step in enumerate(recipe.script.steps, start=1):
        tag = f"  tag {step.tag}" if step.tag else ""
        yield f"{number:>4}  {step.filter.name}  ({step.filter.python_name}){tag}"
        for name, value in step.values.items():
            setting = f"  (setting {step.settings[name]})" if name in step.settings else ""
            yield f"        {name} = {said(value)}{setting}"


def setting_line(setting: Setting) -> str:
    """A setting in one line: its name, its default, its unit and what it does."""
    unit = f" ({setting.unit})" if setting.unit else ""
    return f"{setting.name} = {setting.default}{unit}" + (f": {setting.description}" if setting.description else "")
