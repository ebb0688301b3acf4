"""The options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from ..scripts.guards import Guards

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout; messages still go to stderr.")]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is written if it exists.")]

# ---------------------------------------------------------------------------------------- of commands that look at meshes

Tolerance = Annotated[
    str | None,
    typer.Option(metavar="LENGTH", help="How far the surfaces may lie apart: 0.05, 0.1%, 0.5edge, or with --unit 0.05mm."),
]
Limits = Annotated[
    str | None,
    typer.Option(metavar="LOW,HIGH", help="The ends of the colours, such as -0.1,0.1 or with --unit -0.1mm,0.1mm."),
]

# ------------------------------------------------------------------------------------------ of commands that run a recipe

SetValues = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help="Another value for a setting of the recipe, or STEP.PARAM=VALUE for a parameter of a step, whose STEP is "
        "a number, a tag or a part of the filter's name. May be repeated.",
    ),
]
Others = Annotated[
    list[Path] | None,
    typer.Option("--with", metavar="MESH", help="The file of a further layer that the recipe names. May be repeated."),
]
Upgrade = Annotated[bool, typer.Option("--upgrade", help="Bring a script of an older MeshLab up to date first.")]
AllowOutside = Annotated[
    bool, typer.Option("--allow-outside", help="Let mesh files name textures, materials and buffers outside their folders.")
]
Unchecked = Annotated[
    bool, typer.Option("--unchecked", help="Let MeshLab read formats that are not checked before (.3ds, .ctm, .e57 ...).")
]
KeepAll = Annotated[bool, typer.Option("--keep-all", help="Fail if anything of INPUT or of the result would not be in OUTPUT.")]
MaxDisplacement = Annotated[
    str, typer.Option(metavar="LENGTH", help="Fail if a vertex moves further: 0.05, 0.1%, 0.5edge, or with --unit 0.05mm.")
]
Unit = Annotated[
    str | None, typer.Option(metavar="mm|cm|m|in", help="The unit that the scan is in, which limits with a unit need.")
]
MaxVolumeChange = Annotated[str, typer.Option(metavar="PERCENT", help="Fail if the volume changes by more: 1%.")]
Require = Annotated[
    str,
    typer.Option(metavar="WHAT,...", help="Fail unless it is: watertight, manifold, oriented, printable, components=N, genus=N."),
]
KeepSharp = Annotated[str, typer.Option(metavar="PERCENT", help="Fail if less of the length of the sharp edges is kept: 95%.")]
KeepBroken = Annotated[
    bool, typer.Option("--keep-broken", help="Write OUTPUT even if it goes beyond a limit; the exit code is 1 all the same.")
]
NoMeasures = Annotated[
    bool,
    typer.Option(
        "--no-measures",
        help="Measure nothing before and after, which is sooner: nothing is said of the shape, nor whether the recipe suits it. "
        "Limits cannot be held.",
    ),
]


def check_measured(*, no_measures: bool) -> None:
    """Refuse a report of what was not measured.

    Raises:
        typer.BadParameter: nothing is to be measured.
    """
    if no_measures:
        raise typer.BadParameter("a report shows measures: leave it out, or --no-measures", param_hint="--report")


def memory_limit(text: str | None) -> int | None:
    """The bytes that ``--memory`` means."""
    from ..running.memory import parse_memory

    try:
        return None if text is None else parse_memory(text)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--memory") from None


def guards(**texts: str) -> Guards:
    """The limits that the options of a run set; empty texts set none."""
    from ..scripts.guards import Guards

    return Guards.parse({name: text for name, text in texts.items() if text})
