"""Jobs, recipes and files for the tests of a run."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pymeshlab

from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply_tables import Lists, PlyElement, PlyHeader
from pymeshfair.recipe import Recipe
from pymeshfair.registry import find_filter
from pymeshfair.running.job import Job
from pymeshfair.running.session import Session
from pymeshfair.scripts.script import Script, Step

SAMPLES = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"
#: the real range map of the pymeshlab wheel, 85,849 vertices
RANGE_MAP = SAMPLES / "rangemaps" / "face000.ply"
BONE = SAMPLES / "bone.ply"

#: a filter's Python name and its values
Given: TypeAlias = tuple[str, Mapping[str, Any]]

#: takes 20 s on the bone, all of it in one call of MeshLab's
SLOW: Given = ("apply_coord_taubin_smoothing", {"stepsmoothnum": 100_000})
#: a built-in filter that crashes the process on every mesh (SIGSEGV)
CRASHES: Given = ("compute_matrix_by_icp_between_meshes", {})
SMOOTH: Given = ("apply_coord_taubin_smoothing", {"stepsmoothnum": 2})

TETRAHEDRON = (
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]),
)


def recipe_of(*steps: Given) -> Recipe:
    """A recipe of filters by their Python names, as if read from lines 3, 4, ... of test.mlx."""
    found = [(find_filter(name), values) for name, values in steps]
    script = Script(tuple(Step(f, f.check(values), i) for i, (f, values) in enumerate(found, 3)), "A test", Path("test.mlx"))
    return Recipe("test", script)


def element(header: PlyHeader, name: str) -> PlyElement:
    """The element of a header with this name."""
    return next(e for e in header.elements if e.name == name)


def session_report(
    source: Path, output: Path, *steps: Given, allow_outside: bool = False, keep_all: bool = False, map: Path | None = None
) -> dict[str, Any]:
    """What a worker reports of a run, carried out in this process; the output is left in the staging folder."""
    stage = output.parent / f"stage-{output.name}"
    (stage / "new").mkdir(parents=True)
    options: dict[str, Any] = {"allow_outside": allow_outside, "keep_all": keep_all, "map": map}
    job = Job(recipe_of(*steps), source.absolute(), output.absolute(), **options)
    report = Session(job, stage.absolute(), lambda event: None).run()
    return {**vars(report), "warnings": list(report.warnings), "steps": [vars(step) for step in report.steps]}


def warnings_besides_unit(report: Mapping[str, Any], name: str) -> list[str]:
    """The warnings of a run from a file to out.ply, without the last, which names the unit of the file if that states one."""
    warnings: list[str] = report["warnings"]
    if (unit := report["input"].get("unit")) is None:
        return warnings
    keeps = "; .3mf and .glb keep it" if report["after"]["faces"] else ""
    assert warnings[-1] == f"out.ply does not hold the unit of {name}, {unit}{keeps}"
    return warnings[:-1]


def staged_files(report: Mapping[str, Any]) -> dict[str, Path]:
    """The files that a session staged, by the name that they are meant to get."""
    return {file.target.name: file.staged for file in report["staged"]}


def columns(path: Path) -> dict[tuple[str, str], np.ndarray[Any, Any]]:
    """Everything that a PLY file has, by element and property; lists of all rows are joined."""
    mesh = read_file(path).mesh
    assert mesh.source is not None
    tables = mesh.source.document.tables.items()
    return {
        (element, name): column.values if isinstance(column, Lists) else column
        for element, table in tables
        for name, column in table.columns.items()
    }


def ply_bytes(
    vertex_properties: Sequence[tuple[str, str, Sequence[Any]]],
    faces: Sequence[Sequence[int]] = TETRAHEDRON[1].tolist(),
    face_properties: Sequence[tuple[str, str, Sequence[Any]]] = (),
    head: str = "",
    rows_before: bytes = b"",
) -> bytes:
    """A binary PLY file: (type, name, values) for each property; lists are typed ``list uchar float``."""
    n = len(vertex_properties[0][2]) if vertex_properties else 0
    lines = ["ply", "format binary_little_endian 1.0", *head.splitlines(), f"element vertex {n}"]
    lines += [f"property {type_} {name}" for type_, name, _ in vertex_properties]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    lines += [f"property {type_} {name}" for type_, name, _ in face_properties]
    data = "\n".join([*lines, "end_header", ""]).encode() + rows_before
    for i in range(n):
        data += b"".join(_packed(type_, values[i]) for type_, _, values in vertex_properties)
    for i, face in enumerate(faces):
        data += struct.pack(f"<B{len(face)}i", len(face), *face)
        data += b"".join(_packed(type_, values[i]) for type_, _, values in face_properties)
    return data


def xyz(points: np.ndarray[Any, Any] = TETRAHEDRON[0], type_: str = "double") -> list[tuple[str, str, Sequence[Any]]]:
    """The three coordinates as properties for `ply_bytes`."""
    return [(type_, name, points[:, k].tolist()) for k, name in enumerate("xyz")]


def _packed(type_: str, value: Any) -> bytes:
    codes = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}
    if type_.startswith("list"):
        _, count, item = type_.split()
        return struct.pack(f"<{codes[count]}{len(value)}{codes[item]}", len(value), *value)
    return struct.pack(f"<{codes[type_]}", value)


def names_in(folder: Path) -> set[str]:
    """Everything in a folder, hidden things included."""
    return {path.name for path in folder.iterdir()}
