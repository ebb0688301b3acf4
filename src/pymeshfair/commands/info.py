"""``pymeshfair list filters|recipes`` and ``pymeshfair info FILTER|RECIPE|MESH``: their JSON documents and pages of text."""

from __future__ import annotations

import re
import textwrap
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Argument

from ..places import counted, point_text
from .group import Command
from .options import AllowOutside, Json, Unchecked, recipe_names
from .streams import print_document, print_lines, say, show, warn

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from ..declaration import Filter, Parameter
    from ..recipe import Recipe, RecipeHead, RecipeInfo

_WIDTH, _NARROW = 100, 80  # the width to which text is wrapped in a page, and in a list
_MARGIN = " " * 24  # before the description of a recipe
_MOST_RIMS = 12  # the largest number of holes and outer borders that are listed

listing = typer.Typer(help="List filters or recipes.", rich_markup_mode=None)


@listing.command(cls=Command)
def filters(
    words: Annotated[list[str] | None, Argument(metavar="WORDS", help="Words of the names, the origin or the summary.")] = None,
    json: Json = False,
) -> None:
    """List the filters of MeshLab and of the plugins."""
    from ..registry import all_filters, broken_plugins

    warn(*broken_plugins())
    text = " ".join(words or ())
    plain = partial(re.sub, r"[\s_-]+", " ")  # spaces, dashes and underscores are alike
    wanted = plain(text.casefold()).split()
    texts = ((f, plain(f"{f.python_name} {f.name} {f.origin} {f.summary}".casefold())) for f in all_filters())
    listed = [f for f, description in texts if all(word in description for word in wanted)]
    if not listed and not json:
        typer.echo(f"no filter contains {text!r}", err=True)
    names = ("python_name", "name", "origin", "summary")
    lines = ((f.python_name, *map(_indented, (f"{f.name} ({f.origin})", f.summary))) for f in listed)
    show({"filters": [{name: getattr(f, name) for name in names} for f in listed]}, chain.from_iterable(lines), json=json)


def _indented(text: str, margin: str = " " * 4, width: int = _NARROW) -> str:
    return textwrap.fill(text, width, initial_indent=margin, subsequent_indent=margin)


@listing.command(cls=Command)
def recipes(json: Json = False) -> None:
    """List the recipes that pymeshfair ships, by task."""
    from ..recipe import TASKS, shipped_heads

    heads = sorted(shipped_heads(), key=lambda head: (*(head.info.task != task for task in TASKS), head.name))
    rows = [
        {"name": r.name, **_head(r.info), "for": r.info.purpose, "settings": [s.name for s in r.settings], "steps": r.steps}
        for r in heads
    ]
    show({"recipes": rows}, _by_task(heads), json=json)
    if not json:
        say("\n`pymeshfair info RECIPE` describes a recipe, `pymeshfair run RECIPE INPUT -o OUTPUT` runs it", err=True)


def _head(info: RecipeInfo) -> dict[str, Any]:
    return {"title": info.title, "task": info.task, "fits": info.fits}


def _by_task(heads: Sequence[RecipeHead]) -> Iterator[str]:
    for head, former in zip(heads, [None, *(head.info.task for head in heads)], strict=False):
        if head.info.task != former:
            yield f"{'' if former is None else chr(10)}{head.info.task}"
        yield textwrap.fill(f"  {head.name:<21} {head.info.title}", _NARROW, subsequent_indent=_MARGIN)
        settings = [f"settings: {', '.join(s.name for s in head.settings)}"] if head.settings else []
        for text in (head.info.purpose, *settings):
            yield _indented(text, _MARGIN)


def info(
    subject: Annotated[str, Argument(metavar="FILTER|RECIPE|MESH", help="A name or a path.", autocompletion=recipe_names)],
    allow_outside: AllowOutside = False,
    unchecked: Unchecked = False,
    json: Json = False,
) -> None:
    """Show everything about a filter, a recipe or a mesh file.

    For a mesh: its size, bounding box, holes with their edges, components, noise and attributes, and the recipes that suit it.
    """
    from ..recipe import WITHDRAWN, load_recipe, shipped_recipes

    if subject in (*shipped_recipes(), *shipped_recipes(superseded=True), *WITHDRAWN) or subject.casefold().endswith(".mlx"):
        recipe = load_recipe(subject)
        show({"recipe": recipe_document(recipe)}, recipe_page(recipe), json=json)
        return
    from ..declaration import nearest
    from ..errors import UnknownNameError
    from ..registry import all_filters, find_filter

    try:
        filter = find_filter(subject)
    except UnknownNameError as error:
        if Path(subject).exists():
            _show_mesh(Path(subject), json=json, allow_outside=allow_outside, unchecked=unchecked)
            return
        names = [name for filter in all_filters() for name in (filter.python_name, filter.name)]
        near = nearest(subject, [*names, *shipped_recipes()])
        advice = "`pymeshfair list filters` and `pymeshfair list recipes` show all names"
        hint = error.cause or (f"did you mean {near!r}?" if near else advice)  # a broken plugin may declare this name
        message = f"{subject!r} is no filter, no recipe and no file; {hint}"
        raise UnknownNameError(message, suggestion=near, cause=error.cause) from None
    show({"filter": filter_document(filter)}, filter_page(filter), json=json)


def filter_document(filter: Filter) -> dict[str, Any]:
    """The declaration of a filter in JSON types."""
    return {
        **{n: getattr(filter, n) for n in ("python_name", "name", "origin", "info", "classes", "requires", "changes")},
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
        "default": as_written(parameter.default),
        **{name: getattr(parameter, name, None) for name in ("minimum", "maximum", "choices", "advanced", "help")},
    }


def filter_page(filter: Filter) -> Iterator[str]:
    """The declaration of a filter as the lines of a page."""
    yield f"{filter.python_name}\n{filter.name!r}, a filter of {filter.origin} ({filter.menus})"
    if filter.info:
        yield f"\n{filter.info}"
    yield "\nParameters" if filter.parameters else "\nIt has no parameters."
    for parameter in filter.parameters:
        default = "depends on the mesh" if parameter.default is None else repr(as_written(parameter.default))
        yield f"\n  {parameter.name}  (default {default}{', advanced' if parameter.advanced else ''})"
        for text in (f"{parameter.label}: {parameter.describe_allowed()}.", *([parameter.help] if parameter.help else [])):
            yield _indented(text, " " * 6, _WIDTH)
    yield f"\nIn Python\n{textwrap.indent(python_call(filter), '  ')}"
    yield f"\nIn a .mlx script\n{textwrap.indent(mlx_element(filter), '  ')}"
    if filter.references:
        yield f"\nReferences (docs/bibliography.bib)\n  {', '.join(filter.references)}"


def python_call(filter: Filter) -> str:
    """The call in Python, with every default that does not depend on a mesh."""
    values = [f"{p.name}={as_written(p.default)!r}" for p in filter.parameters if p.default is not None]
    call = f"ms.{filter.python_name}({', '.join(values)})"
    if len(call) <= _WIDTH:
        return call
    return f"ms.{filter.python_name}(\n" + "".join(f"    {g},\n" for g in values) + ")"


def mlx_element(filter: Filter) -> str:
    """The step in a script, with every default that does not depend on a mesh."""
    from ..scripts import Script, Step, format_script

    lines = format_script(Script((Step(filter).with_defaults(),))).splitlines()
    first = next(i for i, line in enumerate(lines) if line.lstrip().startswith("<filter"))
    last = next(i for i, line in enumerate(lines) if line.startswith("</FilterScript"))
    return textwrap.dedent("\n".join(lines[first:last]))


def as_written(value: Any) -> Any:
    """A parameter's value as users write it: lengths as ``"1%"``."""
    from ..declaration import Length

    return str(value) if isinstance(value, Length) else value


def recipe_document(recipe: Recipe) -> dict[str, Any]:
    """The recipe in JSON types."""
    steps = [
        {
            "python_name": step.filter.python_name,
            "name": step.filter.name,
            "tag": step.tag,
            "parameters": {name: as_written(value) for name, value in step.values.items()},
            "settings": step.settings,
        }
        for step in recipe.script.steps
    ]
    settings = [{k: v for k, v in vars(s).items() if k != "line"} for s in recipe.script.settings]
    head = {**_head(recipe.info), "title": recipe.title, "description": recipe.description}
    return {"name": recipe.name, **head, "settings": settings, "steps": steps}


def recipe_page(recipe: Recipe) -> Iterator[str]:
    """The recipe as the lines of a page."""
    yield f"{recipe.name}: {recipe.title}\n\n{recipe.description}\n"
    if recipe.script.settings:
        yield "Settings (--set NAME=VALUE)"
        for s in recipe.script.settings:
            unit, words = f" ({s.unit})" if s.unit else "", f": {s.description}" if s.description else ""
            yield f"      {s.name} = {s.default}{unit}{words}"
        yield ""
    yield "Steps"
    for number, step in enumerate(recipe.script.steps, start=1):
        tag = f"  tag {step.tag}" if step.tag else ""
        yield f"{number:>4}  {step.filter.name}  ({step.filter.python_name}){tag}"
        for name, value in step.values.items():
            setting = f"  (setting {step.settings[name]})" if name in step.settings else ""
            yield f"        {name} = {as_written(value)}{setting}"


def _show_mesh(path: Path, *, json: bool, allow_outside: bool, unchecked: bool) -> None:
    from ..running.read import inspect_mesh
    from ..running.suitability import documents, ranked
    from .display import fitting_lines, show_measures

    measures = inspect_mesh(path, allow_outside=allow_outside, unchecked=unchecked)
    recipes = ranked(measures["traits"])
    if json:
        print_document({"mesh": measures, "recipes": documents(recipes)})
        return
    show_measures({path.name: measures}, measures["unit"])
    print_lines((*_mesh_lines(measures), "\nRecipes for it, the best fit first:"))
    print_lines(fitting_lines([s for s in recipes if s.fits]))
    warn(*measures["warnings"])


def _mesh_lines(measures: Mapping[str, Any]) -> Iterator[str]:
    yield f"\nIt has {', '.join(measures['attributes'] or ['only vertices'])}."
    if measures["box"]:
        low, high = measures["box"]
        sides = " x ".join(f"{b - a:.6g}" for a, b in zip(low, high, strict=True))
        unit = f" {measures['unit']}" if measures["unit"] else ""
        yield f"Its box is {sides}{unit}, from ({point_text(low)}) to ({point_text(high)})."
    if measures["faces"]:
        counts = {None: "not counted, see `pymeshfair compare --self-intersections`", 0: "none"}
        count = measures["self_intersecting_faces"]
        yield f"Faces that cut others: {counts.get(count, f'{count}')}."
        if measures["oriented"] is False:
            yield "Neighbouring faces are oriented differently: `meshing_re_orient_faces_coherently` mends this."
    if "noise" in measures["traits"]:
        yield f"Its noise is about {measures['traits']['noise']:.2g} mean edges."
    rims = measures["rims"]
    if rims:
        holes = sum(not rim["outer"] for rim in rims)
        yield f"It has {counted(holes, 'hole')} and {counted(len(rims) - holes, 'outer border')}:"
    for rim in rims[:_MOST_RIMS]:
        kind = "outer border" if rim["outer"] else "hole"
        yield f"  {kind} of {rim['edges']:,} edges, {rim['length']:.4g} long, around {point_text(rim['middle'])}"
    if len(rims) > _MOST_RIMS:
        yield f"  and {len(rims) - _MOST_RIMS:,} more of at most {rims[_MOST_RIMS]['edges']:,} edges"
