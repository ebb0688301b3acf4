"""Options that several commands share."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_type_hints

import typer
from typer import Argument, Option

from .streams import open_recipe

if TYPE_CHECKING:
    from ..filters.inspection import Limits as Ends
    from ..processes.cluster import Scheduler
    from ..running.job import Job

Json = Annotated[bool, Option("--json", help="Print one JSON document on stdout; messages still go to stderr.")]
Overwrite = Annotated[bool, Option("--overwrite", help="Replace existing files.")]

Tolerance = Annotated[str | None, Option(metavar="LENGTH", help="The allowed distance of the surfaces: 0.1%, 0.5edge, 0.05mm.")]
Limits = Annotated[str | None, Option(metavar="LOW,HIGH", help="The ends of the colour bar: -0.1,0.1 or -0.1mm,0.1mm.")]
Report = Annotated[Path | None, Option(metavar="OUT.html", help="Write a report as a page that needs no network.")]
Up = Annotated[Literal["y", "z"] | None, Option(help="The upright axis in pictures; by default y.")]
PAGES = ("html", "htm")


def refuse_unused(why: str, **unused: object) -> None:
    """Refuse an option that was given and would do nothing; `unused` has the values of such options by name."""
    for name, value in unused.items():
        if value not in (None, []):
            raise typer.BadParameter(why, param_hint=f"--{name}")


def check_report(report: Path | None, *, overwrite: bool, **about: object) -> None:
    """Refuse a report that cannot be written; without a report, refuse the options about one."""
    from ..files.writing import check_target

    if report is None:
        refuse_unused("it is about the report: give --report, too", **about)
    else:
        check_target(report, PAGES, overwrite=overwrite)


def recipe_names(incomplete: str) -> list[str]:
    """The shipped recipes and the scripts whose names begin with the incomplete word in the shell."""
    import glob
    import importlib.resources

    shipped = [f.name for f in importlib.resources.files("pymeshfair.mlx_scripts").iterdir() if f.name.endswith(".mlx")]
    scripts = glob.glob(f"{glob.escape(incomplete)}*.mlx")  # noqa: PTH207 - keeps the path as typed
    return sorted(name.removesuffix(".mlx") for name in shipped if name.startswith(incomplete)) + sorted(scripts)


Recipe = Annotated[
    str, Argument(metavar="RECIPE", help="A shipped name, an .mlx file, or - for stdin.", autocompletion=recipe_names)
]

AllowOutside = Annotated[bool, Option("--allow-outside", help="Let mesh files name files outside their folders.")]
Unchecked = Annotated[bool, Option("--unchecked", help="Let MeshLab read formats that pymeshfair cannot check (.3ds, .ctm ...).")]
Unit = Annotated[str | None, Option(metavar="mm|cm|m|in|ft|um", help="The scan's unit; by default that of its file or recipe.")]
Memory = Annotated[str | None, Option(metavar="SIZE", help="Memory for a run, such as 4GB; by default runs share 80 % of RAM.")]
Timeout = Annotated[float | None, Option(metavar="SECONDS", help="The time limit of a run; in a batch, of each scan.", min=0.001)]


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """The options of a run, and of the runs of a batch; the last five are for a dask scheduler."""

    set: Annotated[
        list[str] | None,
        Option(
            metavar="NAME=VALUE",
            help="Another value for a setting of the recipe, or STEP.PARAM=VALUE for a parameter of a step; STEP is "
            "a number, a tag or a part of the filter's name. Repeatable.",
        ),
    ] = None
    others: Annotated[list[Path] | None, Option("--with", metavar="MESH", help="Add this mesh as a layer. Repeatable.")] = None
    upgrade: Annotated[bool, Option("--upgrade", help="Bring a script of an older MeshLab up to date first.")] = False
    timeout: Timeout = None
    memory: Memory = None
    allow_outside: AllowOutside = False
    unchecked: Unchecked = False
    keep_all: Annotated[bool, Option("--keep-all", help="Fail if OUTPUT would lose anything of INPUT or the result.")] = False
    max_displacement: Annotated[str | None, Option(metavar="LENGTH", help="Fail if vertices move more: 0.1%, 1edge, 2mm.")] = None
    unit: Unit = None
    max_volume_change: Annotated[str | None, Option(metavar="PERCENT", help="Fail if the volume changes by more: 1%.")] = None
    require: Annotated[
        str | None,
        Option(
            metavar="watertight,manifold,oriented,outward,printable,components=N,genus=N",
            help="Fail unless OUTPUT is so; outward is tested only if OUTPUT is closed and oriented.",
        ),
    ] = None
    keep_sharp: Annotated[str | None, Option(metavar="PERCENT", help="Fail if less of the sharp edges is kept: 95%.")] = None
    keep_broken: Annotated[bool, Option("--keep-broken", help="Write OUTPUT even beyond a limit; the exit code stays 1.")] = False
    no_measures: Annotated[
        bool, Option("--no-measures", help="Measure nothing, which is faster; then no limits can be set, and no change is shown.")
    ] = False
    scheduler: Annotated[str | None, Option(metavar="ADDRESS", help="Let the workers of this dask scheduler do the work.")] = None
    scheduler_file: Annotated[Path | None, Option(metavar="FILE", help="The file of `dask scheduler --scheduler-file`.")] = None
    tls_ca_file: Annotated[Path | None, Option(metavar="FILE", help="The CA certificates to verify the scheduler.")] = None
    tls_cert: Annotated[Path | None, Option(metavar="FILE", help="The certificate to show to the scheduler.")] = None
    tls_key: Annotated[Path | None, Option(metavar="FILE", help="The key of the certificate in --tls-cert.")] = None

    def job(self, recipe: str, input: Path, output: Path, *, report: object, **fields: Any) -> Job:
        """The job of a run; `report` is the value of --report, `fields` are further fields of `Job`."""
        from ..running.job import Job
        from ..scripts.guards import ATTRIBUTES, Guards, refuse_unmeasured

        overrides = tuple(self.set or ())
        limits = {name: text for name in ATTRIBUTES if (text := getattr(self, name)) is not None}
        fields |= {
            name: getattr(self, name) for name in ("timeout", "allow_outside", "unchecked", "keep_all", "keep_broken", "unit")
        }
        job = Job(
            open_recipe(recipe, upgrade=self.upgrade).override(overrides),
            input,
            output,
            tuple(path.absolute() for path in self.others or ()),
            memory_limit=memory_limit(self.memory),
            overrides=overrides,
            command=tuple(sys.argv),
            guards=Guards.parse(limits, {name: f"--{name.replace('_', '-')}" for name in limits}),
            measures=not self.no_measures,
            **fields,
        )
        if self.no_measures and report:
            raise typer.BadParameter("a report shows measures: leave out --report or --no-measures", param_hint="--report")
        if self.no_measures:
            refuse_unmeasured(job.all_guards)
        return job

    def chosen_scheduler(self) -> Scheduler | None:
        if self.scheduler is not None and self.scheduler_file is not None:
            raise typer.BadParameter("--scheduler names a scheduler already", param_hint="--scheduler-file")
        if self.scheduler is None and self.scheduler_file is None:
            if self.tls_ca_file or self.tls_cert or self.tls_key:
                raise typer.BadParameter("it needs --scheduler or --scheduler-file", param_hint="--tls-...")
            return None
        from ..processes.cluster import Scheduler

        return Scheduler(self.scheduler or "", self.scheduler_file, self.tls_ca_file, self.tls_cert, self.tls_key)


def with_run_options(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the fields of `RunOptions` as options in place of its parameter `chosen`."""
    hints = get_type_hints(command, include_extras=True)
    run_options = signature(RunOptions, eval_str=True).parameters

    @wraps(command)
    def called(**values: Any) -> None:
        command(chosen=RunOptions(**{name: values.pop(name) for name in run_options}), **values)

    parameters: list[Parameter] = []
    for name, parameter in signature(command).parameters.items():
        keyword = parameter.replace(annotation=hints[name], kind=Parameter.KEYWORD_ONLY)
        parameters += run_options.values() if name == "chosen" else [keyword]
    del called.__wrapped__  # else typer reads the annotations of `command`
    called.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    called.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return called


_BYTES = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12, "KI": 2**10, "MI": 2**20, "GI": 2**30, "TI": 2**40}


def memory_limit(text: str | None) -> int | None:
    """The number of bytes in a text for ``--memory``, such as ``4GB`` or ``2GiB``; None without a text."""
    if text is None:
        return None
    match = re.fullmatch(r"([0-9]{1,15}(?:\.[0-9]{1,15})?)\s*([KMGT]?I?)B?", text.strip().upper())
    if match is None or match[2] not in _BYTES:
        raise typer.BadParameter(f"{text!r} is no amount of memory; write 4GB, 500MB or 2GiB", param_hint="--memory")
    size = int(float(match[1]) * _BYTES[match[2]])
    if size < 10**8:
        raise typer.BadParameter(f"{text!r} is less than the 100 MB that MeshLab alone needs", param_hint="--memory")
    return size


def assumed_unit(typed: str | None, units: dict[str, str | None]) -> tuple[str | None, list[str]]:
    """The typed unit and no warnings; or the first unit in `units` (by file name), and a warning for each file without one."""
    from ..declaration.parameters import unit_of_scan

    known, other = next((u for u in units.items() if u[1]), ("", None))
    silent = [name for name in units if not units[name]] if other and not typed else []
    return unit_of_scan(typed, other), [f"{known} is in {other}, and {s} has no unit: the same one is assumed" for s in silent]


def lengths_in_mesh_units(
    tolerance: str | None, limits: str | None, unit: str | None, diagonal: float, mean_edge: float
) -> tuple[float | None, Ends | None]:
    """The values of ``--tolerance`` and ``--limits LOW,HIGH`` in mesh units; `unit` is that of the scan."""
    from ..declaration import Length
    from ..errors import ParameterError
    from ..filters.inspection import Limits as Ends

    def length(option: str, text: str) -> float:
        given = Length.parse(text, option).in_mesh_units(unit)
        found = given.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge)
        if given.amount and not found:
            measure = "mean edge" if given.unit == "edge" else "diagonal"
            raise ParameterError(f"{text} is 0, as the {measure} of the first mesh is 0: give the length in mesh units")
        return found

    allowed, ends = None, None
    if tolerance is not None and not (allowed := length("--tolerance", tolerance)) > 0.0:
        raise typer.BadParameter(f"{tolerance} is not above 0", param_hint="--tolerance")
    if limits is not None:
        parts = limits.split(",")
        if len(parts) != 2:
            raise typer.BadParameter(f"{limits} is not two lengths: write it as -0.1,0.1 or -0.1mm,0.1mm", param_hint="--limits")
        ends = Ends(*(length("--limits", part) for part in parts))
        if not ends.low < ends.high:
            raise typer.BadParameter(f"{limits}: the first limit must be below the second", param_hint="--limits")
    return allowed, ends
