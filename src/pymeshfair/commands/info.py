"""``pymeshfair info FILTER|RECIPE|MESH``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .json_document import print_document
from .options import AllowOutside, Debug, Json, Unchecked

if TYPE_CHECKING:
    from ..declaration import Filter


def info(
    subject: Annotated[str, typer.Argument(metavar="FILTER|RECIPE|MESH", help="A name, or the path of an .mlx or mesh file.")],
    allow_outside: AllowOutside = False,
    unchecked: Unchecked = False,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Tell everything about a filter, a recipe or a mesh file."""
    from ..recipe import shipped_recipes

    if subject in shipped_recipes() or subject.casefold().endswith(".mlx"):
        _tell_recipe(subject, json=json)
        return
    from ..errors import UnknownNameError
    from ..registry import find_filter

    try:
        known = find_filter(subject)
    except UnknownNameError as error:
        if not Path(subject).exists():
            raise _nothing_named(subject, error.cause) from None
        _tell_mesh(Path(subject), json=json, allow_outside=allow_outside, unchecked=unchecked)
    else:
        _tell_filter(known, json=json)


def _nothing_named(subject: str, cause: str | None) -> Exception:
    """The error that says what was looked for, and the nearest name or the plugin that may be to blame."""
    from ..declaration import nearest
    from ..errors import UnknownNameError
    from ..recipe import shipped_recipes
    from ..registry import all_filters

    names = [name for known in all_filters() for name in (known.python_name, known.name)]
    near = nearest(subject, [*names, *shipped_recipes()])
    hint = (
        cause or f"did you mean {near!r}?"
        if near or cause
        else "`pymeshfair list filters` and `pymeshfair list recipes` name what there is"
    )
    return UnknownNameError(f"{subject!r} is no filter, no recipe and no file; {hint}", suggestion=near, cause=cause)


def _tell_filter(known: Filter, *, json: bool) -> None:
    from .filter_page import filter_document, filter_page

    if json:
        print_document({"filter": filter_document(known)})
    else:
        typer.echo(filter_page(known))


def _tell_recipe(name: str, *, json: bool) -> None:
    from ..recipe import load_recipe
    from .recipe_page import recipe_document, recipe_page

    recipe = load_recipe(name)
    if json:
        print_document({"recipe": recipe_document(recipe)})
    else:
        typer.echo(recipe_page(recipe))


def _tell_mesh(path: Path, *, json: bool, allow_outside: bool, unchecked: bool) -> None:
    from ..running.inspect import inspect_mesh
    from .measures_table import measures_table
    from .streams import warn
    from .tables import console

    found = inspect_mesh(path, allow_outside=allow_outside, unchecked=unchecked)
    if json:
        print_document({"mesh": found})
        return
    console().print(measures_table({path.name: found}))
    typer.echo(f"\nIt has {', '.join(found['attributes'] or ['vertices alone'])}.")
    for warning in found["warnings"]:
        warn(warning)
