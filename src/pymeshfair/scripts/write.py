"""Writes .mlx scripts from which MeshLab, pymeshlab and `read_script` read the same numbers.

MeshLab itself writes six digits, and attributes in random order. Here numbers read back exactly, and the same script always has
the same bytes.
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

#: the bounding-box diagonal for absolute values if no mesh is given: MeshLab then reads "1%" as 1
NOMINAL_DIAGONAL = 100.0
NOMINAL_EDGE = 0.25  # the mean edge length in the same case: 1/400 of the diagonal

#: characters that XML does not allow, not even escaped
_UNWRITABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
#: the escapes in an attribute of XML; xml.sax.saxutils would do the same, but imports http
_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})


def format_script(
    script: Script, *, diagonal: float = NOMINAL_DIAGONAL, mean_edge: float = NOMINAL_EDGE, known_mesh: bool = True
) -> str:
    """The text of the .mlx file, ending with a newline.

    Parameters are written in declared order, also those with default values. Two kinds of defaults are left to MeshLab: values
    that follow from the mesh, such as the number of triangles after a decimation; and without `known_mesh`, relative lengths.
    A relative length is in ``relative=``; MeshLab reads ``value=``, the absolute value for the step's `size`, or else for this
    `diagonal` and `mean_edge`.
    """
    text = "".join(f"{line}\n" for line in _lines(script.with_defaults(lengths=known_mesh), diagonal, mean_edge))
    if invalid := _UNWRITABLE.search(text):
        context = text[max(0, invalid.start() - 40) : invalid.end() + 40]
        raise PymeshfairError(f"the text {context!r} cannot be written to a script: XML has no {invalid.group()!r}")
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
        length, edge = step.size or (diagonal, mean_edge)
        for parameter in parameters:
            attributes = param_attributes(parameter, step.values[parameter.name], diagonal=length, mean_edge=edge)
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
    """Write the text of `format_script` to a file; `overwrite` replaces an existing file if its name ends with .mlx."""
    text = format_script(script, diagonal=diagonal, mean_edge=mean_edge)
    write_file(path, text.encode("utf-8"), overwrite=overwrite and extension(path) == "mlx")


@dataclass(frozen=True)
class MeshFacts:
    """The properties of the mesh for which a script is exported."""

    diagonal: float  # of its bounding box
    mean_edge: float  # the mean length of its edges; of a point cloud, the mean distance to the nearest neighbour
    closed: bool  # whether every edge has two faces


def export_script(
    script: Script, *, mesh: MeshFacts | None = None, lengths: Sequence[Mapping[str, Length]] = ()
) -> tuple[str, tuple[str, ...]]:
    """The script for MeshLab's desktop and plain pymeshlab, and one sentence for each filter that was replaced.

    A filter of a plugin is replaced by the equivalent filter of MeshLab that it declares. Settings, tags, guards and the unit are
    left out, as MeshLab ignores them.

    `mesh` is needed for relative lengths, and for filters that have an equivalent only on closed meshes. `lengths` has, for each
    step, lengths in mesh units by Python parameter name; in MeshLab's own filters they replace the lengths computed from `mesh`.
    Raises `ScriptError`, which names all steps whose filter has no equivalent, or whose length needs a mesh.
    """
    whole = script.with_defaults()
    size = MeshFacts(NOMINAL_DIAGONAL, NOMINAL_EDGE, closed=False) if mesh is None else mesh
    closed, steps, replaced, problems = size.closed, list[Step](), list[str](), list[Problem]()
    for number, step in enumerate(whole.steps, 1):
        plain, why_not = (step, "") if step.filter.is_builtin else _equivalent(step, closed=closed, has_mesh=mesh is not None)
        closed = closed and FilterClass.SMOOTHING in step.filter.classes  # any other step may open the mesh or make a selection
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
    """The step with the equivalent filter of MeshLab, and ""; or the step itself, and why MeshLab has no equivalent."""
    equivalent = None if step.filter.equivalent is None else step.filter.equivalent(step.values)
    why = f"is a filter of {step.filter.origin}, which MeshLab lacks; MeshLab alone cannot run this step"
    if equivalent is None:
        return step, why
    builtin = find_filter(equivalent.filter)
    if equivalent.closed_only and not closed:
        open_mesh = "and this one is open, or an earlier step may open it or make a selection"
        unknown = "say with --for MESH which mesh the script is for"
        return step, f"{why}: {builtin.name!r} does the same only on closed meshes, {open_mesh if has_mesh else unknown}"
    return Step(builtin, builtin.with_defaults(equivalent.values), step.line), ""
