"""Asks the installed pymeshlab for facts about MeshLab's filters, without applying one.

``python -u -m pymeshfair.meshlab.survey`` prints them as JSON. It is a process of its own because MeshLab prints the list of a
filter's parameters with C++, which bypasses Python's stdout, and after some failures it prints nothing any more.

MeshLab lists a parameter's Python name, kind and bounds; it computes defaults for the current mesh; and it names the choices of
an enumeration when it refuses a wrong one. What it tells only through the scripts that it saves, and what it does not tell at
all, is kept in the table (`facts`).
"""

import importlib.metadata
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ..errors import PymeshfairError
from .loading import load_pymeshlab

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
    command = [sys.executable, "-u", "-m", __name__]
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


if __name__ == "__main__":
    found = survey_in_this_process()
    print(json.dumps({"version": found.version, "filters": {n: [asdict(p) for p in ps] for n, ps in found.filters.items()}}))
