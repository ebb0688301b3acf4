"""Reads and measures mesh files for commands that change no file, and runs filters on a mesh for the values that they report."""

import math
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..declaration import Bools, Length
from ..errors import FilterInputError, RunError
from ..files.errors import InputError
from ..files.formats import ATTRIBUTES, UNCHECKED, contents_of, extension
from ..files.inputs import read_file
from ..mesh_data import MeshData
from ..recipe import Recipe
from ..registry import find_filter
from ..scripts.guards import NO_GUARDS
from ..scripts.script import Script, Step
from ..scripts.warnings import check_needs
from .job import Event, Job, StepReport, plain
from .measuring import MeasuredMesh, measure, self_intersecting_apart
from .suitability import traits_of
from .supervise import run_job

MOST_CUTS = 200_000  # with this number of vertices MeshLab's search for self-intersections takes as long as the rest of a report


@dataclass(frozen=True, eq=False)
class ReadMesh:
    """A mesh that was read from a file."""

    path: Path
    mesh: MeshData
    measured: MeasuredMesh
    warnings: tuple[str, ...]  # about the file
    self_intersecting: Bools | None = None  # (m,) which faces cut others; None without a search, or if it failed

    @property
    def measures(self) -> dict[str, Any]:
        """The measures by name, see `pymeshfair.filters.inspection.surface_measures.SurfaceMeasures`."""
        return self.measured.described or {}

    def traits(self) -> dict[str, Any]:
        return dict(plain(traits_of(self.measured)))


def read_mesh(
    path: Path, *, self_intersections: bool | None = False, allow_outside: bool = False, unchecked: bool = False
) -> ReadMesh:
    """Read and measure a mesh file; `allow_outside` and `unchecked` are as in `Job`.

    `self_intersections` says whether to search for faces that cut others; None searches only meshes of at most `MOST_CUTS`
    vertices. A failure of this search becomes a warning. Raises `InputError` for a file that cannot be read, and `RunError` if
    MeshLab crashes while it reads the file.
    """
    path = Path(path).absolute()
    if unchecked and extension(path) in UNCHECKED:
        with tempfile.TemporaryDirectory(prefix="pymeshfair-read-") as folder:
            converted = Path(folder) / "mesh.ply"
            result = run_job(Job(Recipe("reading", Script(())), path, converted, unchecked=True, measures=False))
            reading = read_file(converted)
        warnings = [*result.warnings, *reading.doubts]
    else:
        reading = read_file(path, allow_outside=allow_outside)
        warnings = [f"{path.name}: {doubt}" for doubt in reading.doubts]
    try:
        measured = measure(reading.mesh)
    except FilterInputError as error:
        raise InputError(path, "it has coordinates that are not finite") from error
    cuts = None
    if self_intersections or (self_intersections is None and len(reading.mesh.vertices) <= MOST_CUTS):
        try:
            cuts = self_intersecting_apart(reading.mesh)
        except RunError:
            warnings.append(f"MeshLab's search for self-intersections of {path.name} failed")
    return ReadMesh(path, reading.mesh, measured, tuple(warnings), cuts)


def inspect_mesh(path: Path, *, allow_outside: bool, unchecked: bool) -> dict[str, Any]:
    """The entry ``mesh`` in the document of ``pymeshfair info MESH``: measures and more, see docs/documents.md."""
    from ..filters.holes import find_rims
    from ..filters.mesh import bounding_box

    read = read_mesh(path, self_intersections=None, allow_outside=allow_outside, unchecked=unchecked)
    vertices, faces = read.mesh.vertices, read.mesh.faces
    present = contents_of(read.mesh)
    return {
        **read.measures,
        "unit": read.mesh.unit,
        "self_intersecting_faces": None if read.self_intersecting is None else int(read.self_intersecting.sum()),
        "attributes": [a for a in ATTRIBUTES if a in present],
        "warnings": list(read.warnings),
        "box": [plain(end.tolist()) for end in bounding_box(vertices)] if len(vertices) else [],
        "rims": [
            {"edges": rim.edges, "length": rim.length, "middle": plain(rim.middle.tolist()), "outer": rim.outer}
            for rim in (find_rims(vertices, faces) if len(faces) else [])
        ],
        "traits": read.traits(),
    }


def reported_values(
    mesh: Path,
    filter: str,
    values: Mapping[str, Any],
    *,
    timeout: float | None = None,
    on_event: Callable[[Event], None] = lambda event: None,
) -> dict[str, Any]:
    """The values that a filter, given by its Python name, reports on a mesh file with these parameters."""
    script = Script((Step(find_filter(filter)).with_values(values),))
    with tempfile.TemporaryDirectory() as folder:
        job = Job(Recipe(filter, script), mesh, Path(folder) / "result.ply", timeout=timeout, measures=False)
        return dict(run_job(job, on_event).steps[0].values)


def lengths_on_mesh(script: Script, path: Path) -> list[Mapping[str, Length]]:
    """Runs the steps up to the last with relative lengths; gives these lengths of each step in mesh units, by parameter."""
    steps = script.with_defaults().steps
    count = max((number for number, step in enumerate(steps, 1) if step.relative_lengths), default=0)
    advice = "--for runs the steps on one mesh alone: write the lengths of this step and of all later ones in mesh units"
    reports = zip(steps, _reports(script, steps[:count], path, advice), strict=False)
    return [{name: Length(report.parameters[name]) for name in step.relative_lengths} for step, report in reports]


def diagonals_on_mesh(script: Script, path: Path) -> list[float]:
    """The diagonal of the mesh before each step up to the last with lengths, found by running the steps."""
    with_lengths = (i for i, step in enumerate(script.steps, 1) if any(isinstance(v, Length) for v in step.values.values()))
    measuring, count = Step(find_filter("get_geometric_measures")), max(with_lengths, default=0)
    steps = [each for step in script.steps[:count] for each in (measuring, step)][:-1]
    advice = '--relative-to runs the steps on one mesh alone: leave it out, and write lengths such as relative="1%" by hand'
    diagonals = [math.dist(*report.values["bbox"]) for report in _reports(script, steps, path, advice)[::2]]
    if 0.0 in diagonals:
        step = diagonals.index(0.0) + 1
        raise InputError(path, f"its points are all in one place before step {step}: no length can be relative to its size")
    return diagonals


def _reports(script: Script, steps: Sequence[Step], path: Path, advice: str) -> Sequence[StepReport]:
    """The reports of these steps of a script on a mesh file; `advice` says what to do if they need more layers."""
    if not steps:
        return ()
    name = "script" if script.path is None else script.path.stem
    first = replace(script, steps=tuple(steps), guards=NO_GUARDS)
    check_needs(first, layers=1, advice=advice)
    with tempfile.TemporaryDirectory(prefix="pymeshfair-measured-") as folder:
        return run_job(Job(Recipe(name, first), path, Path(folder) / "mesh.ply", measures=False)).steps
