"""The options that several commands have."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from .streams import open_recipe

if TYPE_CHECKING:
    from ..declaration import Length
    from ..filters.inspection import Limits as Ends
    from ..processes.cluster import Scheduler
    from ..running.job import Job

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

Report = Annotated[
    Path | None,
    typer.Option(metavar="OUT.html", help="Write a page that needs no network: pictures, 3D, numbers, charts, steps."),
]
Up = Annotated[str, typer.Option(metavar="y|z", help="The upright axis in the pictures of the report.")]

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

AllowOutside = Annotated[
    bool, typer.Option("--allow-outside", help="Let mesh files name textures, materials and buffers outside their folders.")
]
Unchecked = Annotated[
    bool, typer.Option("--unchecked", help="Let MeshLab read formats that are not checked before (.3ds, .ctm ...).")
]
Unit = Annotated[
    str | None, typer.Option(metavar="mm|cm|m|in", help="The unit that the scan is in; else that of its file, or of the recipe.")
]
Memory = Annotated[
    str | None,
    typer.Option(
        metavar="SIZE", help="Memory that a run may take, such as 4GB; by default 80 % of the machine's, or a scan's share."
    ),
]
Timeout = Annotated[float | None, typer.Option(metavar="SECONDS", help="Stop after that time; in a batch, that scan.", min=0.001)]


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """The options of a run, and of the runs of a batch."""

    set: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            help="Another value for a setting of the recipe, or STEP.PARAM=VALUE for a parameter of a step, whose STEP is "
            "a number, a tag or a part of the filter's name. May be repeated.",
        ),
    ] = None
    others: Annotated[
        list[Path] | None,
        typer.Option("--with", metavar="MESH", help="The file of a further layer that the recipe names. May be repeated."),
    ] = None
    upgrade: Annotated[bool, typer.Option("--upgrade", help="Bring a script of an older MeshLab up to date first.")] = False
    timeout: Timeout = None
    memory: Memory = None
    allow_outside: AllowOutside = False
    unchecked: Unchecked = False
    keep_all: Annotated[
        bool, typer.Option("--keep-all", help="Fail if anything of INPUT or of the result would not be in OUTPUT.")
    ] = False
    max_displacement: Annotated[
        str,
        typer.Option(metavar="LENGTH", help="Fail if a vertex moves further: 0.05, 0.1%, 0.5edge; 0.05mm if the unit is known."),
    ] = ""
    unit: Unit = None
    max_volume_change: Annotated[str, typer.Option(metavar="PERCENT", help="Fail if the volume changes by more: 1%.")] = ""
    require: Annotated[
        str,
        typer.Option(
            metavar="WHAT,...", help="Fail unless it is: watertight, manifold, oriented, printable, components=N, genus=N."
        ),
    ] = ""
    keep_sharp: Annotated[
        str, typer.Option(metavar="PERCENT", help="Fail if less of the length of the sharp edges is kept: 95%.")
    ] = ""
    keep_broken: Annotated[
        bool, typer.Option("--keep-broken", help="Write OUTPUT even if it goes beyond a limit; the exit code is 1 all the same.")
    ] = False
    no_measures: Annotated[
        bool,
        typer.Option(
            "--no-measures",
            help="Measure nothing before and after, which is sooner: nothing is said of the shape, nor whether the recipe suits "
            "it. Limits cannot be held.",
        ),
    ] = False

    def job(self, recipe: str, input: Path, output: Path, **more: Any) -> Job:
        """The run of a recipe; `more` are further fields of `Job`."""
        from ..running.job import Job
        from ..scripts.guards import Guards

        overrides = tuple(self.set or ())
        limits = {name: getattr(self, name) for name in ("max_displacement", "max_volume_change", "require", "keep_sharp")}
        return Job(
            open_recipe(recipe, upgrade=self.upgrade).override(overrides),
            input,
            output,
            tuple(path.absolute() for path in self.others or ()),
            timeout=self.timeout,
            memory_limit=memory_limit(self.memory),
            allow_outside=self.allow_outside,
            unchecked=self.unchecked,
            keep_all=self.keep_all,
            overrides=overrides,
            command=tuple(sys.argv),
            guards=Guards.parse({name: text for name, text in limits.items() if text}),
            keep_broken=self.keep_broken,
            measures=not self.no_measures,
            unit=self.unit,
            **more,
        )


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the fields of its groups of options, which are dataclasses, as options of its own."""
    hints = get_type_hints(command, include_extras=True)
    groups: dict[str, Any] = {name: hint for name, hint in hints.items() if is_dataclass(hint)}

    @wraps(command)
    def called(**values: Any) -> None:
        for name, group in groups.items():
            values[name] = group(**{field.name: values.pop(field.name) for field in fields(group)})
        command(**values)

    parameters: list[Parameter] = []
    for name, parameter in signature(command).parameters.items():
        of_group = signature(groups[name], eval_str=True).parameters.values() if name in groups else ()
        parameters += of_group or [parameter.replace(annotation=hints[name], kind=Parameter.KEYWORD_ONLY)]
    del called.__wrapped__  # typer would look at its annotations
    called.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return called


def check_report(path: Path, up: str, *, overwrite: bool) -> None:
    """Refuse a report that could not be written, before anything is computed."""
    from ..files.writing import check_target
    from ..looking.camera import view_rows

    check_target(path, ("html", "htm"), overwrite=overwrite)
    view_rows(0.0, 0.0, up)


def check_measured(*, no_measures: bool) -> None:
    """Refuse a report of what was not measured."""
    if no_measures:
        raise typer.BadParameter("a report shows measures: leave it out, or --no-measures", param_hint="--report")


#: bytes by the prefix of a unit
_BYTES = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12, "KI": 2**10, "MI": 2**20, "GI": 2**30, "TI": 2**40}


def memory_limit(text: str | None) -> int | None:
    """The bytes that ``--memory`` means, such as ``4GB``, ``500MB`` or ``2GiB``; None without it."""
    if text is None:
        return None
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([KMGT]?I?)B?", text.strip().upper())
    if match is None or match[2] not in _BYTES:
        raise typer.BadParameter(f"{text!r} is no amount of memory; write 4GB, 500MB or 2GiB", param_hint="--memory")
    size = int(float(match[1]) * _BYTES[match[2]])
    if size < 10**8:
        raise typer.BadParameter(f"{text!r} is less than the 100 MB that MeshLab takes for itself", param_hint="--memory")
    return size


def map_tolerance(text: str | None, path: Path | None) -> Length | None:
    """The length that ``--map-tolerance`` means, None without it."""
    from ..declaration import Length

    if text is None:
        return None
    if path is None:
        raise typer.BadParameter("it is about the intervention map: give --map, too", param_hint="--map-tolerance")
    length = Length.parse(text)
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
    from ..declaration import Length
    from ..declaration.units import check_unit

    if unit is not None:
        check_unit(unit)
    return Length.parse(text).in_mesh_units(unit).resolve(diagonal=diagonal, mean_edge=lambda: mean_edge)


# ---------------------------------------------------------------------------------- of commands with a scheduler of dask


@dataclass(frozen=True, kw_only=True)
class SchedulerOptions:
    """The options that name a scheduler."""

    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Let the workers of this scheduler of dask do the work.")
    ] = None
    scheduler_file: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The same, by the file of `dask scheduler --scheduler-file`.")
    ] = None
    tls_ca_file: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Certificates that sign those of the scheduler and its workers.")
    ] = None
    tls_cert: Annotated[Path | None, typer.Option(metavar="FILE", help="The certificate with which to go to the scheduler.")] = (
        None
    )
    tls_key: Annotated[Path | None, typer.Option(metavar="FILE", help="The key of that certificate.")] = None

    def chosen(self) -> Scheduler | None:
        """The scheduler that the options name, None without one."""
        if self.scheduler is not None and self.scheduler_file is not None:
            raise typer.BadParameter("--scheduler names one already", param_hint="--scheduler-file")
        if self.scheduler is None and self.scheduler_file is None:
            if self.tls_ca_file or self.tls_cert or self.tls_key:
                raise typer.BadParameter("it needs --scheduler or --scheduler-file", param_hint="--tls-...")
            return None
        from ..processes.cluster import Scheduler

        return Scheduler(self.scheduler or "", self.scheduler_file, self.tls_ca_file, self.tls_cert, self.tls_key)
