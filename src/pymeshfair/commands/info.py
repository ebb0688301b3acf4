"""``pymeshfair info FILTER|RECIPE|MESH``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import AllowOutside, Json, Unchecked
from .streams import counted, print_document, print_lines, warn

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping


def info(
    subject: Annotated[str, typer.Argument(metavar="FILTER|RECIPE|MESH", help="A name, or the path of an .mlx or mesh file.")],
    allow_outside: AllowOutside = False,
    unchecked: Unchecked = False,
    json: Json = False,
) -> None:
    """Show everything about a filter, a recipe or a mesh file.

    For a mesh: its size, box, holes with their edges, pieces, noise and attributes, and the recipes that suit it.
    """
    from ..recipe import shipped_recipes

    if subject in shipped_recipes() or subject.casefold().endswith(".mlx"):
        _show_recipe(subject, json=json)
        return
    from ..errors import UnknownNameError
    from ..registry import find_filter

    try:
        filter = find_filter(subject)
    except UnknownNameError as error:
        if not Path(subject).exists():
            raise _unknown_subject(subject, error.cause) from None
        _show_mesh(Path(subject), json=json, allow_outside=allow_outside, unchecked=unchecked)
    else:
        from .info_pages import filter_document, filter_page

        if json:
            print_document({"filter": filter_document(filter)})
        else:
            print_lines(filter_page(filter))


def _unknown_subject(subject: str, cause: str | None) -> Exception:
    """The error for an unknown subject, with the nearest name, or the broken plugin that may declare it."""
    from ..declaration import nearest
    from ..errors import UnknownNameError
    from ..recipe import shipped_recipes
    from ..registry import all_filters

    names = [name for filter in all_filters() for name in (filter.python_name, filter.name)]
    near = nearest(subject, [*names, *shipped_recipes()])
    every = "`pymeshfair list filters` and `pymeshfair list recipes` show all names"
    hint = cause or (f"did you mean {near!r}?" if near else every)
    return UnknownNameError(f"{subject!r} is no filter, no recipe and no file; {hint}", suggestion=near, cause=cause)


def _show_recipe(name: str, *, json: bool) -> None:
    from ..recipe import load_recipe
    from .info_pages import recipe_document, recipe_page

    recipe = load_recipe(name)
    if json:
        print_document({"recipe": recipe_document(recipe)})
    else:
        print_lines(recipe_page(recipe))


def _show_mesh(path: Path, *, json: bool, allow_outside: bool, unchecked: bool) -> None:
    from ..running.read import inspect_mesh
    from ..running.suitability import documents, ranked
    from .tables import console, fitting_lines, measures_table, rim_lines

    measures = inspect_mesh(path, allow_outside=allow_outside, unchecked=unchecked)
    recipes = ranked(measures["traits"])
    if json:
        print_document({"mesh": measures, "recipes": documents(recipes)})
        return
    unit = measures["unit"]
    console().print(measures_table({path.name: measures}, unit))
    print_lines((*_mesh_lines(measures), *rim_lines(measures["rims"]), "\nRecipes for it, the best fit first:"))
    print_lines(fitting_lines([s for s in recipes if s.fits]))
    warn(*measures["warnings"])


def _mesh_lines(measures: Mapping[str, Any]) -> Iterator[str]:
    """Attributes, box, noise and the number of rims of a mesh, one line each."""
    yield f"\nIt has {', '.join(measures['attributes'] or ['vertices alone'])}."
    if measures["box"]:
        low, high = measures["box"]
        sides = " x ".join(f"{b - a:.6g}" for a, b in zip(low, high, strict=True))
        unit = f" {measures['unit']}" if measures["unit"] else ""
        yield f"Its box is {sides}{unit}, from {_place(low)} to {_place(high)}."
    if measures["faces"]:
        counts = {None: "not counted, see `pymeshfair compare --self-intersections`", 0: "none"}
        count = measures["self_intersecting_faces"]
        yield f"Faces that cut others: {counts.get(count, f'{count}')}."
    traits = measures["traits"]
    if "noise" in traits:
        yield f"Its noise is about {traits['noise']:.2g} mean edges."
    if measures["rims"]:
        holes = sum(not rim["outer"] for rim in measures["rims"])
        yield f"It has {counted(holes, 'hole')} and {len(measures['rims']) - holes:,} outer borders:"


def _place(point: Iterable[float]) -> str:
    return "(" + ", ".join(f"{c:.6g}" for c in point) + ")"
