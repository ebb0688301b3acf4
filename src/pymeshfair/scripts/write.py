"""Writes .mlx scripts that MeshLab, pymeshlab and `read_script` read alike, number by number.

MeshLab itself writes six digits and its attributes in random order; here numbers read back exactly, and the same script is
always the same bytes. An exported script needs nothing but MeshLab: its own filters, every parameter, lengths in mesh units.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from ..declaration import Length
from ..errors import PymeshfairError
from ..files.formats import extension
from ..files.writing import write_file
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


def export_script(
    script: Script, *, lengths: Sequence[Mapping[str, Length]] | None = None, diagonal: float = NOMINAL_DIAGONAL
) -> str:
    """The script for MeshLab's desktop and plain pymeshlab, without settings, tags, limits and unit, which mean nothing there.

    `lengths` has, for a mesh of that diagonal, the relative lengths of each step in mesh units by Python parameter name.

    Raises:
        ScriptError: MeshLab lacks a filter, or a length is relative and no lengths are given; lists all of them.
    """
    whole, steps, problems = script.with_defaults(), list[Step](), list[Problem]()
    for index, step in enumerate(whole.steps):
        plain = step.with_checked({} if lengths is None else lengths[index])
        steps.append(replace(plain, tag="", settings={}))
        if not step.filter.is_builtin:
            why = f"is a filter of {step.filter.origin}, which MeshLab lacks; MeshLab alone cannot run this step"
            problems.append(script.problem(step, why))
            continue
        for name, length in plain.relative_lengths.items():
            why = f"is {length}, which depends on the size of the mesh; say with --for MESH which mesh the script is for"
            problems.append(script.problem(plain, why, parameter=plain.filter.parameter(name).xml_name))
    if problems:
        raise ScriptError(problems)
    return format_script(replace(whole.with_steps(steps), guards=NO_GUARDS, unit=""), diagonal=diagonal)
