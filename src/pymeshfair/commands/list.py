"""``pymeshfair list filters|recipes``."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING, Annotated

import typer

from .group import Command
from .options import Json
from .streams import print_document, print_lines, say, warn

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from ..declaration import Filter
    from ..recipe import RecipeHead

#: characters of a line
_WIDTH = 80
#: the margin before the words about a recipe
_MARGIN = " " * 24

app = typer.Typer(help="List filters or recipes.", rich_markup_mode=None)


@app.command(cls=Command)
def filters(
    words: Annotated[
        list[str] | None, typer.Argument(metavar="WORDS", help="Words that the names or the summary must contain.")
    ] = None,
    origin: Annotated[str, typer.Option(help="Only filters of pymeshfair, of meshlab or of another package of plugins.")] = "",
    json: Json = False,
) -> None:
    """List the filters, MeshLab's and those of the plugins."""
    from ..registry import all_filters, broken_plugins

    warn(*broken_plugins())
    text = " ".join(words or ())
    listed = [f for f in _of_origin(all_filters(), origin) if _contains(f"{f.python_name} {f.name} {f.summary}", text)]
    if json:
        rows = [{"python_name": f.python_name, "name": f.name, "origin": f.origin, "summary": f.summary} for f in listed]
        print_document({"filters": rows})
        return
    if not listed:
        typer.echo(f"no filter contains {text!r}", err=True)
        return
    for declared in listed:
        typer.echo(declared.python_name)
        for line in (f"{declared.name} ({declared.origin})", declared.summary):
            typer.echo(textwrap.fill(line, _WIDTH, initial_indent="    ", subsequent_indent="    "))


@app.command(cls=Command)
def recipes(json: Json = False) -> None:
    """List the recipes that pymeshfair ships, by what they are there to do."""
    from ..recipe import TASKS, shipped_heads

    heads = sorted(shipped_heads(), key=lambda head: (*(head.info.task != task for task in TASKS), head.name))
    if json:
        rows = [
            {
                "name": r.name,
                "title": r.info.title,
                "task": r.info.task,
                "fits": r.info.fits,
                "for": r.info.purpose,
                "settings": [s.name for s in r.settings],
                "steps": r.steps,
            }
            for r in heads
        ]
        print_document({"recipes": rows})
        return
    print_lines(_by_task(heads))
    say("\n`pymeshfair info RECIPE` tells more, `pymeshfair run RECIPE INPUT -o OUTPUT` runs it", err=True)


def _by_task(heads: Iterable[RecipeHead]) -> Iterator[str]:
    """The recipes in lines, under the tasks that they are for."""
    task = None
    for head in heads:
        if head.info.task != task:
            yield f"{'' if task is None else chr(10)}{head.info.task}"
            task = head.info.task
        yield textwrap.fill(f"  {head.name:<21} {head.info.title}", _WIDTH, subsequent_indent=_MARGIN)
        yield textwrap.fill(head.info.purpose, _WIDTH, initial_indent=_MARGIN, subsequent_indent=_MARGIN)
        if head.settings:
            names = f"settings: {', '.join(s.name for s in head.settings)}"
            yield textwrap.fill(names, _WIDTH, initial_indent=_MARGIN, subsequent_indent=_MARGIN)


def _of_origin(declared: Iterable[Filter], origin: str) -> list[Filter]:
    declared = list(declared)
    if not origin:
        return declared
    chosen = [f for f in declared if f.origin.casefold() == origin.casefold()]
    if not chosen:
        names = ", ".join(sorted({f.origin for f in declared}))
        raise typer.BadParameter(f"no filter comes from {origin!r}; there are {names}", param_hint="'--origin'")
    return chosen


def _contains(haystack: str, words: str) -> bool:
    """Whether every word is in there, capitals and the difference between spaces, dashes and underscores aside."""
    plain = re.sub(r"[\s_-]+", " ", haystack.casefold())
    return all(word in plain for word in re.sub(r"[\s_-]+", " ", words.casefold()).split())
