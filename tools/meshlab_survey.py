"""The filters of the installed pymeshlab, without applying one, and how they differ from the table of facts (for maintainers).

``python -u tools/meshlab_survey.py`` prints the filters as JSON. It is a process of its own because MeshLab prints the list of a
filter's parameters with C++, which bypasses Python's stdout, and after some failures it prints nothing any more.

MeshLab lists a parameter's Python name, kind and bounds; it computes defaults for the current mesh; and it names the choices of
an enumeration when it refuses a wrong one. All else is kept in the table (`pymeshfair.meshlab.facts`).
"""

import importlib.metadata
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from pymeshfair.declaration import Length
from pymeshfair.errors import PymeshfairError
from pymeshfair.meshlab.facts import differing_names, python_name, table, table_version
from pymeshfair.meshlab.loading import load_pymeshlab

#: the bounding-box diagonal of MeshLab's unit cube, on which defaults and bounds are listed
CUBE_DIAGONAL = 3.0**0.5

_PARAMETER = re.compile(
    r"\t(?P<name>\w+) : (?P<kind>.+?) = (?P<default>.*?)(?: \[min: (?P<minimum>\S+); max: (?P<maximum>\S+)\])?"
)
_NO_CHOICE = "no such choice"


class SurveyError(PymeshfairError):
    """The installed pymeshlab cannot be asked, for example because a system library is missing."""


@dataclass(frozen=True)
class InstalledParameter:
    """One parameter of the installed pymeshlab."""

    name: str  # the Python name
    kind: str  # as pymeshlab lists it, e.g. ``float (bounded)``.
    default: Any  # on the unit cube; a length in mesh units, a choice as its index
    bounds: Sequence[float] | None = None  # on the unit cube, both ends, where it lists some
    choices: Sequence[str] = ()  # the words of an enumeration


@dataclass(frozen=True)
class Survey:
    """The installed pymeshlab: its version, and the parameters of each filter in order, by Python name."""

    version: str
    filters: Mapping[str, Sequence[InstalledParameter]]


def survey_installed() -> Survey:
    """The facts about the installed pymeshlab, read by a process of its own in about half a second."""
    # Unbuffered: output in a buffer would appear after stdout has been redirected.
    command = [sys.executable, "-u", __file__]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)
    if done.returncode != 0:
        last = done.stderr.strip().rpartition("\n")[2]
        raise SurveyError(f"pymeshlab could not be asked about its filters (exit {done.returncode}): {last}")
    answer = json.loads(done.stdout)
    filters = {name: [InstalledParameter(**p) for p in parameters] for name, parameters in answer["filters"].items()}
    return Survey(answer["version"], filters)


def survey_in_this_process() -> Survey:
    """The facts about the installed pymeshlab; afterwards this process's MeshLab may print nothing any more."""
    load_pymeshlab()
    import pymeshlab

    names = sorted(pymeshlab.filter_list())
    listing = _what_is_printed(lambda: [pymeshlab.print_filter_parameter_list(name) for name in names])
    meshes = pymeshlab.MeshSet()
    meshes.create_cube()
    meshes.compute_scalar_by_function_per_face(q="0")  # three filters list no defaults without it
    filters = {}
    for name in names:
        defaults = {key: plain_value(value) for key, value in meshes.filter_parameter_values(name).items()}
        filters[name] = [_parameter(meshes, name, line, defaults) for line in _listed(listing, name)]
    return Survey(importlib.metadata.version("pymeshlab"), filters)


def plain_value(value: Any) -> Any:
    """A parameter's value as pymeshlab hands it out, as numbers and lists; a C float as the number that its digits mean."""
    import numpy as np

    if isinstance(value, float):
        return float(str(np.float32(value)))
    if isinstance(value, np.ndarray):
        return value.tolist()
    if hasattr(value, "alpha"):
        return [value.red(), value.green(), value.blue(), value.alpha()]
    return value


def _what_is_printed(work: Callable[[], object]) -> str:
    """The output of Python and C++ to the file descriptor of stdout while `work` is called."""
    sys.stdout.flush()
    saved = os.dup(1)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 1)
        try:
            work()
        finally:
            os.dup2(saved, 1)
            os.close(saved)
        file.seek(0)
        return file.read().decode("utf-8")


def _listed(listing: str, filter_name: str) -> Sequence[re.Match[str]]:
    _, _, rest = listing.partition(f"\n{filter_name} filter - list of parameter names:\n")
    rows = []
    for line in rest.splitlines():
        match = _PARAMETER.fullmatch(line)
        if match is None:
            break
        rows.append(match)
    return rows


def _parameter(meshes: Any, filter_name: str, line: re.Match[str], defaults: dict[str, Any]) -> InstalledParameter:
    name, kind = line["name"], line["kind"]
    bounds = None if line["minimum"] is None else (float(line["minimum"]), float(line["maximum"]))
    choices = _choices(meshes, filter_name, name) if kind == "str" and isinstance(defaults.get(name), int) else ()
    return InstalledParameter(name, kind, defaults.get(name), bounds, choices)


def _choices(meshes: Any, filter_name: str, name: str) -> tuple[str, ...]:
    import pymeshlab

    try:
        meshes.filter_parameter_values(filter_name, **{name: _NO_CHOICE})
    except pymeshlab.InvalidEnumException as error:
        _, _, words = str(error).partition("Possible values are '")
        return tuple(words.rstrip().removesuffix("';").split("'; '"))
    return ()


#: the kinds that pymeshlab's own list has for those of the table
_KINDS: Mapping[str, tuple[str, ...]] = {
    "Bool": ("bool",),
    "Color": ("Color",),
    "Direction": ("numpy.ndarray[numpy.float64[3]]",),
    "Enum": ("str",),
    "FileOpen": ("str",),
    "FileSave": ("str",),
    "Float": ("float", "float (bounded)"),
    "Int": ("int",),
    "Matrix": ("numpy.ndarray[numpy.float64[4, 4]]",),
    "Mesh": ("int",),
    "Percentage": ("PercentageValue",),
    "Point": ("numpy.ndarray[numpy.float64[3]]",),
    "Shot": ("Shotf [still unsupported]",),
    "String": ("str",),
}


def differences_from_table(installed: Survey) -> list[str]:
    """The differences of a survey from the table of facts, one sentence each; empty if there are none."""
    differences = []
    if installed.version != table_version():
        differences.append(f"pymeshlab {installed.version} is installed; the table of its filters is of {table_version()}")
    expected = {row[0]: row[-1] for row in table("filters")["filters"]}
    differences += differing_names(installed.filters, expected)
    for name, rows in expected.items():
        if name in installed.filters:
            differences += [f"filter {name!r}: {text}" for text in _parameter_differences(rows, installed.filters[name])]
    return differences


def _parameter_differences(rows: list[list[Any]], installed: Sequence[InstalledParameter]) -> Iterator[str]:
    names, installed_names = [python_name(row[0]) for row in rows], [p.name for p in installed]
    if names != installed_names:
        yield f"has the parameters {', '.join(installed_names)}; in the table {', '.join(names)}"
        return
    for (_, kind, default, *more), parameter in zip(rows, installed, strict=True):
        say = f"parameter {parameter.name!r} has the"
        if parameter.kind not in _KINDS[kind] or (kind == "Float" and bool(more) != (parameter.bounds is not None)):
            yield f"{say} kind {parameter.kind!r}; in the table it is {kind}"
        elif not _same_default(kind, default, parameter.default):
            yield f"{say} default {parameter.default!r}; in the table {default!r}"
        elif kind == "Enum" and more[0] != list(parameter.choices):
            yield f"{say} choices {', '.join(parameter.choices)}; in the table {', '.join(more[0])}"
        elif kind == "Float" and more and None not in more and more != list(parameter.bounds or ()):
            yield f"{say} bounds {parameter.bounds}; in the table {more}"


def _same_default(kind: str, default: Any, installed: Any) -> bool:
    if default is None:
        return True  # it depends on the mesh or on the machine
    if kind != "Percentage":
        return bool(default == installed)
    length = Length.parse(default).resolve(diagonal=CUBE_DIAGONAL, mean_edge=lambda: math.nan)
    return math.isclose(length, installed, rel_tol=1e-4)  # the table gives parts of the diagonal with five digits


if __name__ == "__main__":
    found = survey_in_this_process()
    print(json.dumps({"version": found.version, "filters": {n: [asdict(p) for p in ps] for n, ps in found.filters.items()}}))
