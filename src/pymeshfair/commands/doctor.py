"""``pymeshfair doctor``: checks of this machine, with advice if something is wrong."""

from __future__ import annotations

import importlib.metadata
import platform
import re
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from typer import Argument, Option

from .options import Json
from .streams import print_document, printable, say, warn

#: the least free space, in bytes: `verify` and other commands write copies of a scan to the folder for temporary files
_ENOUGH_DISK = 1 << 30


@dataclass(frozen=True)
class Finding:
    """The result of one check."""

    name: str
    ok: bool
    detail: str
    advice: str = ""  # the remedy, if something is wrong


def doctor(
    folder: Annotated[Path | None, Argument(metavar="FOLDER", help="Also list folders that killed runs left in FOLDER.")] = None,
    remove: Annotated[bool, Option("--remove", help="Remove the folders that killed runs left in FOLDER.")] = False,
    warm: Annotated[bool, Option("--warm", help="First compile all filters, for example for a container's image.")] = False,
    json: Json = False,
) -> None:
    """Check whether this machine has everything that pymeshfair needs."""
    if remove and folder is None:
        raise typer.BadParameter("it needs the FOLDER to remove folders from", param_hint="--remove")
    if warm:  # compiles the kernels that neither the installation nor a run has compiled
        from ..filters.compilation import compile_ahead, listed_signatures

        say("compiling filters for this machine", err=True)
        warn(*(f"not compiled: {failure}" for failure in (*compile_ahead(listed_signatures()), *_compile_others())))
    findings = []
    for finding in (*look_around(), *(look_at_left_files(folder, remove=remove) if folder else ())):
        findings.append(finding)
        if not json:
            mark = typer.style("ok   ", fg="green") if finding.ok else typer.style("WRONG", fg="red")
            text = f"{finding.name:<12}  {finding.detail}" + (f"\n{'':21}{finding.advice}" if finding.advice else "")
            typer.echo(f"{mark}  {printable(text)}")
    wrong = [f.name for f in findings if not f.ok]
    message = f"something is wrong with {', '.join(wrong)}" if wrong else "all is well"
    if json:
        print_document({"findings": findings} | ({"error": {"kind": "Unwell", "message": message}} if wrong else {}))
    say(message, err=True)
    if wrong:
        raise typer.Exit(1)


def _compile_others() -> list[str]:
    """Compile the kernels of other packages by running their filters; return the errors."""
    from ..meshset import MeshSet
    from ..registry import custom_filters

    failures = []
    for declared in (declared for declared in custom_filters() if declared.origin != "pymeshfair"):
        meshes = MeshSet()
        meshes.create_octahedron()
        meshes.compute_scalar_by_function_per_vertex(q="z")
        meshes.compute_color_by_function_per_vertex(x="x", y="y", z="z")
        try:
            meshes.apply_filter(declared.python_name)
        except Exception as error:  # the filter may need another mesh
            failures.append(f"{declared.python_name}, of {declared.origin}: {type(error).__name__}: {error}")
    return failures


def look_around() -> Iterator[Finding]:
    """The findings of all checks; an exception becomes a finding, so that the other checks go on."""
    for look in (look_at_python, look_at_pymeshlab, look_at_numba, look_at_plugins, look_at_disk):
        try:
            yield from look()
        except Exception as error:  # noqa: PERF203
            yield Finding(look.__name__.removeprefix("look_at_"), False, f"{type(error).__name__}: {error}")


def look_at_python() -> Iterator[Finding]:
    """The interpreter, the system, and the versions of pymeshfair's requirements."""
    yield Finding("python", True, f"{platform.python_version()} ({sys.executable})")
    yield Finding("system", True, platform.platform())
    yield Finding("pymeshfair", True, importlib.metadata.version("pymeshfair"))
    versions, missing = [], []
    for requirement in importlib.metadata.requires("pymeshfair") or ():
        name, marker = re.split(r"[^\w.-]", requirement)[0], requirement.partition(";")[2]
        if "extra ==" in marker:
            continue
        try:
            versions.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            missing += [] if marker else [name]  # a requirement with a marker is only for some systems
    detail = ", ".join([*dict.fromkeys(versions), *(f"{name} is missing" for name in missing)])
    yield Finding("packages", not missing, detail, f"`python -m pip install {' '.join(missing)}`" if missing else "")


def look_at_pymeshlab() -> Iterator[Finding]:
    """Whether pymeshlab can be imported, tried in a separate process, since a broken library may crash Python."""
    import subprocess

    from ..processes.environment import program_of, worker_environment

    command = program_of("pymeshfair.meshlab.loading")
    process = subprocess.run(command, capture_output=True, text=True, timeout=120, env=worker_environment(None))
    if process.returncode == 0:
        yield Finding("pymeshlab", True, "can be imported")
        yield from look_at_facts()
    else:
        last_line = process.stderr.strip().rpartition("\n")[2] or f"the import ended with code {process.returncode}"
        yield Finding("pymeshlab", False, last_line)


def look_at_facts() -> Iterator[Finding]:
    """Whether MeshLab's filters equal the table against which scripts and calls are checked."""
    from ..meshlab.facts import differences_from_installed, table_version

    installed, expected = importlib.metadata.version("pymeshlab"), table_version()
    detail, advice = f"MeshLab's filters equal those of pymeshlab {expected}; {installed} is installed", ""
    if differences := differences_from_installed():
        detail = f"{len(differences)} of MeshLab's filters differ: {'; '.join(differences[:3])}"
        advice = f"`python -m pip install pymeshlab=={expected}`, or a pymeshfair for the installed {installed}"
    yield Finding("facts", not differences, detail, advice)


def look_at_numba() -> Iterator[Finding]:
    """Whether numba compiles, and where compiled kernels are."""
    import numba

    from ..filters.compilation import processor, stored

    works, kernels = numba.njit(lambda number: number + 1)(1) == 2, stored()
    wheel, cache = f"{kernels.installed} kernels are installed for {processor()}", f"{kernels.kept} more are in {kernels.folder}"
    advice = ""
    if not kernels.lasts:
        advice = "this folder cannot be written: set the environment variable NUMBA_CACHE_DIR to another folder"
    elif kernels.installed + kernels.kept == 0:
        advice = "first runs take some seconds longer; `pymeshfair doctor --warm` compiles everything now"
    yield Finding("numba", works and kernels.lasts, f"{'compiles' if works else 'computes wrongly'}; {wheel}, {cache}", advice)


def look_at_plugins() -> Iterator[Finding]:
    """The number of filters, and the plugins that cannot be used."""
    from collections import Counter

    from ..registry import all_filters, broken_plugins

    count = Counter(f.origin for f in all_filters())
    yield Finding("filters", True, ", ".join(f"{n} of {origin}" for origin, n in sorted(count.items())))
    for broken in broken_plugins():
        where = f"{broken.distribution}: {broken.entry_point}: {broken.reason}"
        remedy = "reinstall" if broken.distribution == "pymeshfair" else "update or uninstall"
        yield Finding("plugin", False, where, f"its filters are left out, all others work; {remedy} {broken.distribution}")


def look_at_disk() -> Iterator[Finding]:
    """Whether there is room for temporary files."""
    import tempfile

    folder = tempfile.gettempdir()  # raises FileNotFoundError when no candidate can be written
    free = shutil.disk_usage(folder).free
    advice = "" if free >= _ENOUGH_DISK else "free some space, or set TMPDIR to a folder on another disk"
    yield Finding("disk", free >= _ENOUGH_DISK, f"{free / 1e9:.1f} GB free in {folder}", advice)


def look_at_left_files(folder: Path, *, remove: bool) -> Iterator[Finding]:
    """The temporary folders that killed runs left, which do not count as wrong; with `remove` they are removed."""
    from ..files.writing import WORK_PREFIX, abandoned_folders, remove_folder

    if not folder.is_dir():
        raise typer.BadParameter(f"{folder} is no folder", param_hint="FOLDER")
    folders = abandoned_folders(folder)
    if not folders:
        yield Finding("left files", True, f"no folder of a killed run was found in {folder}")
    for path in folders:
        size = sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
        if remove:
            remove_folder(path)
        detail = f"{'removed: ' if remove else ''}{path}, {size / 1e6:,.1f} MB of a run that was killed"
        can_resume = "the run's command with --resume continues the run; " if path.name.startswith(WORK_PREFIX) else ""
        advice = "" if remove else f"{can_resume}`pymeshfair doctor {folder} --remove` removes what the run left"
        yield Finding("left files", True, detail, advice)
