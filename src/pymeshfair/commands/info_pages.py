"""The declarations of filters and the heads of recipes, as data and as pages of text."""

import textwrap
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from ..declaration import Filter, Length, Parameter
from ..recipe import Recipe
from ..scripts import Script, Step, format_script
from ..scripts.script import Setting

_WIDTH = 100


def filter_document(filter: Filter) -> dict[str, Any]:
    """The declaration in terms of JSON."""
    return {
        "python_name": filter.python_name,
        "name": filter.name,
        "origin": filter.origin,
        "info": filter.info,
        "classes": filter.classes,
        "requires": filter.requires,
        "changes": filter.changes,
        "arity": filter.arity.name.lower(),
        "references": filter.references,
        "parameters": [_parameter_document(p) for p in filter.parameters],
        "python": python_call(filter),
        "mlx": mlx_element(filter),
    }


def _parameter_document(parameter: Parameter) -> dict[str, Any]:
    return {
        "name": parameter.name,
        "mlx_name": parameter.xml_name,
        "mlx_type": parameter.xml_type,
        "label": parameter.label,
        "type": type(parameter).__name__.lower(),
        "allowed": parameter.describe_allowed(),
        "default": said(parameter.default),
        "minimum": getattr(parameter, "minimum", None),
        "maximum": getattr(parameter, "maximum", None),
        "choices": getattr(parameter, "choices", None),
        "advanced": parameter.advanced,
        "help": parameter.help,
    }


def filter_page(filter: Filter) -> Iterator[str]:
    """The declaration as the lines of a page: what it does, its parameters, how to call it."""
    menus = ", ".join(c.name.replace("_", " ").lower() for c in type(filter.classes) if c in filter.classes and c.name)
    yield f"{filter.python_name}\n{filter.name!r}, a filter of {filter.origin} ({menus})"
    if filter.info:
        yield f"\n{filter.info}"
    yield "\nParameters" if filter.parameters else "\nIt has no parameters."
    for parameter in filter.parameters:
        default = "depends on the mesh" if parameter.default is None else repr(said(parameter.default))
        yield f"\n  {parameter.name}  (default {default}{', advanced' if parameter.advanced else ''})"
        yield _indented(f"{parameter.label}: {parameter.describe_allowed()}.")
        if parameter.help:
            yield _indented(parameter.help)
    yield f"\nIn Python\n{textwrap.indent(python_call(filter), '  ')}"
    yield f"\nIn a .mlx script\n{textwrap.indent(mlx_element(filter), '  ')}"
    if filter.references:
        yield f"\nReferences (docs/bibliography.bib)\n  {', '.join(filter.references)}"


def _indented(text: str) -> str:
    return textwrap.fill(text, _WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 6)


def python_call(filter: Filter) -> str:
    """The call with every default that is known without a mesh."""
    values = [f"{p.name}={said(p.default)!r}" for p in filter.parameters if p.default is not None]
    call = f"ms.{filter.python_name}({', '.join(values)})"
    if len(call) <= _WIDTH:
        return call
    return f"ms.{filter.python_name}(\n" + "".join(f"    {g},\n" for g in values) + ")"


def mlx_element(filter: Filter) -> str:
    """The step of a script with every default that is known without a mesh."""
    lines = format_script(Script((Step(filter).with_defaults(),))).splitlines()
    first = next(i for i, line in enumerate(lines) if line.lstrip().startswith("<filter"))
    last = next(i for i, line in enumerate(lines) if line.startswith("</FilterScript"))
    return textwrap.dedent("\n".join(lines[first:last]))


def said(value: Any) -> Any:
    """A parameter's value as users write it: lengths as ``"1%"``."""
    return str(value) if isinstance(value, Length) else value


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


def recipe_page(recipe: Recipe) -> Iterator[str]:
    """The recipe as the lines of a page: what it is for, what can be set, and its steps."""
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
