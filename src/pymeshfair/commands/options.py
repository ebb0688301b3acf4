"""The options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from ..declaration import Length
    from ..declaration.units import PhysicalLength
    from ..filters.inspection import Limits as Ends
    from ..processes.cluster import Scheduler
    from ..scripts.guards import Guards

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout; messages still go to stderr.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace what is written if it exists.")]

# ---------------------------------------------------------------------------------------- of commands that look at meshes

Tolerance = Annotated[
    str | None,
    typer.Option(metavar="LENGTH", help="How far the surfaces may lie apart: 0.05, 0.1%, 0.5edge; 0.05mm if the unit is known."),
]
Limits = Annotated[
    str | None,
    typer.Option(metavar="LOW,HIGH", help="The ends of the colours, such as -0.1,0.1; -0.1mm,0.1mm if the unit is known."),
]

# ------------------------------------------------------------------------------------------ of commands that run a recipe


def _recipes(incomplete: str) -> list[str]:
    """The shipped recipes, scripts and folders that a word may become, for the shell."""
    import glob
    import importlib.resources
    import os

    shipped = (
        f.name.removesuffix(".mlx") for f in importlib.resources.files("pymeshfair.mlx_scripts").iterdir() if ".mlx" in f.name
    )
    paths = glob.glob(f"{glob.escape(incomplete)}*")  # noqa: PTH207 - as it was typed
    own = [path + "/" if os.path.isdir(path) else path for path in paths if path.endswith(".mlx") or os.path.isdir(path)]  # noqa: PTH112
    return sorted(name for name in shipped if name.startswith(incomplete)) + sorted(own)


Recipe = Annotated[
    str,
    typer.Argument(
        metavar="RECIPE", help="A shipped name, the path of an .mlx file, or - for standard input.", autocompletion=_recipes
    ),
]

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
    bool, typer.Option("--unchecked", help="Let MeshLab read formats that are not checked before (.3ds, .ctm ...).")
]
KeepAll = Annotated[bool, typer.Option("--keep-all", help="Fail if anything of INPUT or of the result would not be in OUTPUT.")]
MaxDisplacement = Annotated[
    str, typer.Option(metavar="LENGTH", help="Fail if a vertex moves further: 0.05, 0.1%, 0.5edge; 0.05mm if the unit is known.")
]
Unit = Annotated[
    str | None, typer.Option(metavar="mm|cm|m|in", help="The unit that the scan is in; else that of its file, or of the recipe.")
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
    """Refuse a report of what was not measured."""
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


def map_tolerance(text: str | None, path: Path | None) -> Length | PhysicalLength | None:
    """The length that ``--map-tolerance`` means, None without it."""
    from ..declaration.units import parse_length

    if text is None:
        return None
    if path is None:
        raise typer.BadParameter("it is about the intervention map: give --map, too", param_hint="--map-tolerance")
    length = parse_length(text)
    if length.amount < 0.0:
        raise typer.BadParameter(f"{text} is below 0", param_hint="--map-tolerance")
    return length


def tolerance_in_mesh_units(text: str | None, unit: str | None, diagonal: float, mean_edge: float) -> float | None:
    """The length that ``--tolerance`` means, such as ``0.05``, ``0.1%``, ``0.5edge`` or ``0.05mm``; None if it is not given."""
    if text is None:
        return None
    length = _in_mesh_units(text, unit, diagonal, mean_edge)
    if not length > 0.0:
        raise typer.BadParameter(f"{text} is not above 0", param_hint="--tolerance")
    return length


def limits_in_mesh_units(text: str | None, unit: str | None, diagonal: float, mean_edge: float) -> Ends | None:
    """The two ends that ``--limits LOW,HIGH`` means; None if it is not given; see `tolerance_in_mesh_units`."""
    from ..filters.inspection import Limits as Ends

    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 2:
        raise typer.BadParameter(f"{text} is not two lengths: write it as -0.1,0.1 or -0.1mm,0.1mm", param_hint="--limits")
    low, high = (_in_mesh_units(part, unit, diagonal, mean_edge) for part in parts)
    if not low < high:
        raise typer.BadParameter(f"{text}: the lower limit comes first", param_hint="--limits")
    return Ends(low, high)


def _in_mesh_units(text: str, unit: str | None, diagonal: float, mean_edge: float) -> float:
    from ..declaration.units import PhysicalLength, check_unit, parse_length

    if unit is not None:
        check_unit(unit)
    length = parse_length(text)
    if isinstance(length, PhysicalLength):
        length = length.in_mesh_units(unit)
    return length.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge)


# ---------------------------------------------------------------------------------- of commands with a scheduler of dask

SchedulerAddress = Annotated[
    str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Let the workers of this scheduler of dask do the work.")
]
SchedulerFile = Annotated[
    Path | None, typer.Option(metavar="FILE", help="The same, by the file of `dask scheduler --scheduler-file`.")
]
TlsCaFile = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Certificates that sign those of the scheduler and its workers.")
]
TlsCert = Annotated[Path | None, typer.Option(metavar="FILE", help="The certificate with which to go to the scheduler.")]
TlsKey = Annotated[Path | None, typer.Option(metavar="FILE", help="The key of that certificate.")]


def scheduler_of(
    address: str | None, file: Path | None, ca_file: Path | None, certificate: Path | None, key: Path | None
) -> Scheduler | None:
    """The scheduler that the options name, None without one."""
    if address is not None and file is not None:
        raise typer.BadParameter("--scheduler names one already", param_hint="--scheduler-file")
    if address is None and file is None:
        if ca_file or certificate or key:
            raise typer.BadParameter("it needs --scheduler or --scheduler-file", param_hint="--tls-...")
        return None
    from ..processes.cluster import Scheduler

    return Scheduler(address or "", file, ca_file, certificate, key)
