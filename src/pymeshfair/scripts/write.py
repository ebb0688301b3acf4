"""Writes .mlx scripts that MeshLab, pymeshlab and `read_script` read alike, number by number.

MeshLab itself writes six digits and its attributes in random order; here numbers read back exactly, and the same script is
always the same bytes. An exported script needs nothing but MeshLab: its own filters, every parameter, lengths in mesh units.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..declaration import FilterClass, Length
from ..errors import PymeshfairError
from ..files.formats import extension
from ..files.writing import write_file
from ..registry import find_filter
from .guards import ATTRIBUTES as GUARDS
from .guards import NO_GUARDS
from .script import SETTING_ATTRIBUTES, Problem, Script, ScriptError, Step
from .values import param_attributes

#: The bounding-box diagonal that absolute values are written for unless a mesh is given: "1%" then reads as 1 of 100.
NOMINAL_DIAGONAL = 100.0
NOMINAL_EDGE = 0.25  # the mean edge that goes with it, as of a scan with 400 samples across

#: characters that no XML document can hold, not even escaped
_UNWRITABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
#: the escapes in an attribute of XML; xml.sax.saxutils would do the same, and import http for it
_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})


def format_script(
    script: Script, *, diagonal: float = NOMINAL_DIAGONAL, mean_edge: float = NOMINAL_EDGE, known_mesh: bool = True
) -> str:
    """The text of the .mlx file, ending with a newline.

    Every parameter is written, in declared order, except a built-in filter's that is neither given nor known without a mesh (the
    number of triangles to decimate to, another layer), or default lengths without a `known_mesh`: MeshLab then takes its default.
    `diagonal` and `mean_edge` are of the mesh that the absolute values next to ``relative=`` are meant for, which MeshLab reads.
    """
    text = "".join(f"{line}\n" for line in _lines(script.with_defaults(lengths=known_mesh), diagonal, mean_edge))
    if bad := _UNWRITABLE.search(text):
        around = text[max(0, bad.start() - 40) : bad.end() + 40]
        raise PymeshfairError(f"the text {around!r} cannot be written to a script: XML has no {bad.group()!r}")
    return text


def _lines(script: Script, diagonal: float, mean_edge: float) -> Iterator[str]:
    yield "<!DOCTYPE FilterScript>"
    if "--" in script.comment or script.comment.endswith("-"):
        raise PymeshfairError("the head comment of a script cannot contain '--' or end with '-': XML does not allow it")
    if script.comment:
        yield f"<!--\n{script.comment}\n-->"
    unit = {"unit": script.unit} if script.unit else {}
    yield _element("FilterScript", unit | {GUARDS[name]: text for name, text in script.guards.texts().items()}, ">")
    for setting in script.settings:
        texts = {name: getattr(setting, name) for name in SETTING_ATTRIBUTES}
        yield "  " + _element("setting", {name: text for name, text in texts.items() if text or name == "default"})
    for step in script.steps:
        parameters = [p for p in step.filter.parameters if p.name in step.values]
        named = {"name": step.filter.name} | ({"tag": step.tag} if step.tag else {})
        yield "  " + _element("filter", named, ">" if parameters else "/>")
        for parameter in parameters:
            attributes = param_attributes(parameter, step.values[parameter.name], diagonal=diagonal, mean_edge=mean_edge)
            if parameter.name in step.settings:
                attributes["setting"] = step.settings[parameter.name]
            yield "    " + _element("Param", attributes)
        if parameters:
            yield "  </filter>"
    yield "</FilterScript>"


def _element(tag: str, attributes: Mapping[str, str], end: str = "/>") -> str:
    return "".join([f"<{tag}", *(f" {name}={_quoted(text)}" for name, text in attributes.items()), end])


def _quoted(text: str) -> str:
    escaped = text.translate(_ESCAPES)
    if '"' in escaped and "'" not in escaped:
        return f"'{escaped}'"
    return '"' + escaped.replace('"', "&quot;") + '"'


def write_script(
    script: Script, path: Path, *, diagonal: float = NOMINAL_DIAGONAL, mean_edge: float = NOMINAL_EDGE, overwrite: bool = False
) -> None:
    """Write the script as `format_script` does; with `overwrite` even in place of a file, whose name must end with .mlx."""
    text = format_script(script, diagonal=diagonal, mean_edge=mean_edge)
    write_file(path, text.encode("utf-8"), overwrite=overwrite and extension(path) == "mlx")


@dataclass(frozen=True)
class MeshFacts:
    """The sizes of the mesh that a script is exported for."""

    diagonal: float  # of its bounding box
    mean_edge: float  # the mean length of its edges; of a point cloud, the mean distance to the nearest neighbour
    closed: bool  # whether every edge has two faces


def export_script(
    script: Script, *, mesh: MeshFacts | None = None, lengths: Sequence[Mapping[str, Length]] = ()
) -> tuple[str, tuple[str, ...]]:
    """The script for MeshLab's desktop and plain pymeshlab, and one sentence for each filter that was replaced.

    A filter of a plugin is replaced where it declares that one of MeshLab's does the same. Settings, tags, limits and the
    unit, which mean nothing there, are left out.

    Without the mesh that it is for, a script is refused that has relative lengths, or a filter that has an equal on closed meshes
    alone. `lengths` has by step lengths in mesh units by Python parameter name, in place of those that are relative to `mesh`.

    Raises:
        ScriptError: MeshLab alone cannot do what a step does, or a length is relative and no mesh is given; lists all of them.
    """
    whole = script.with_defaults()
    size = MeshFacts(NOMINAL_DIAGONAL, NOMINAL_EDGE, closed=False) if mesh is None else mesh
    closed, steps, replaced, problems = size.closed, list[Step](), list[str](), list[Problem]()
    for number, step in enumerate(whole.steps, 1):
        plain, why_not = (step, "") if step.filter.is_builtin else _equivalent(step, closed=closed, has_mesh=mesh is not None)
        closed = closed and FilterClass.SMOOTHING in step.filter.classes  # any other step may open the mesh, or select
        if why_not:
            problems.append(script.problem(step, why_not))
            continue
        if plain is not step:
            replaced.append(f"step {number}, {step.filter.name!r}, is MeshLab's {plain.filter.name!r}, which does the same")
        elif number <= len(lengths):
            plain = plain.with_checked(lengths[number - 1])
        if mesh is None:
            for name, length in plain.relative_lengths.items():
                why = f"is {length}, which depends on the size of the mesh; say with --for MESH which mesh the script is for"
                problems.append(script.problem(plain, why, parameter=plain.filter.parameter(name).xml_name))
        else:
            plain = plain.in_mesh_units(diagonal=mesh.diagonal, mean_edge=mesh.mean_edge)
        steps.append(replace(plain, tag="", settings={}))
    if problems:
        raise ScriptError(problems)
    bare = replace(whole.with_steps(steps), guards=NO_GUARDS, unit="")
    return format_script(bare, diagonal=size.diagonal, mean_edge=size.mean_edge), tuple(replaced)


def _equivalent(step: Step, *, closed: bool, has_mesh: bool) -> tuple[Step, str]:
    """The step with MeshLab's filter that does the same; or why there is none."""
    equivalent = None if step.filter.equivalent is None else step.filter.equivalent(step.values)
    why = f"is a filter of {step.filter.origin}, which MeshLab lacks; MeshLab alone cannot run this step"
    if equivalent is None:
        return step, why
    own = find_filter(equivalent.filter)
    if equivalent.closed_only and not closed:
        open_mesh = "and this one is open, or a step before may open it or select"
        unknown = "say with --for MESH which mesh it is for"
        return step, f"{why}: {own.name!r} does the same on closed meshes alone, {open_mesh if has_mesh else unknown}"
    return Step(own, own.with_defaults(equivalent.values), step.line), ""
