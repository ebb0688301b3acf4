"""Writes .mlx scripts that MeshLab, pymeshlab and `read_script` read alike, number by number.

MeshLab itself writes six digits and its attributes in random order; here numbers read back exactly, and the same script is
always the same bytes. An exported script needs nothing but MeshLab: its own filters, every parameter, lengths in mesh units.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..declaration import Bool, Color, Enum, FileOpen, FilterClass, Float, Length, Matrix, Parameter, Percentage, Point
from ..errors import PymeshfairError
from ..files.formats import extension
from ..files.writing import write_file
from ..registry import find_filter
from .guards import ATTRIBUTES as GUARDS
from .guards import NO_GUARDS
from .problems import Problem, ScriptError
from .script import SETTING_ATTRIBUTES, Script, Step

#: The bounding-box diagonal that absolute values are written for unless a mesh is given: "1%" then reads as 1 of 100.
NOMINAL_DIAGONAL = 100.0
#: The mean edge that goes with it, as of a scan with 400 samples across.
NOMINAL_EDGE = 0.25

#: characters that no XML document can hold, not even escaped
_UNWRITABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


#: the escapes in an attribute of XML; xml.sax.saxutils would do the same, and import http for it
_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})


def format_script(
    script: Script, *, diagonal: float = NOMINAL_DIAGONAL, mean_edge: float = NOMINAL_EDGE, known_mesh: bool = True
) -> str:
    """The text of the .mlx file, ending with a newline.

    Every parameter is written, in declared order, except a built-in filter's that is neither given nor known without a mesh (the
    number of triangles to decimate to, another layer): MeshLab then takes its default on the mesh that the step meets.

    Args:
        script: the script.
        diagonal: bounding-box diagonal of the mesh that the absolute values next to ``relative=`` are meant for; pymeshfair
            reads the relative value, MeshLab the absolute one.
        mean_edge: mean edge length of that mesh.
        known_mesh: write default lengths too. Without it MeshLab takes its own on the mesh that a step meets, as it does when
            a script does not give them.

    Raises:
        PymeshfairError: a text holds what XML cannot, such as a control character.
    """
    return "".join(f"{line}\n" for line in _lines(script.with_defaults(lengths=known_mesh), diagonal, mean_edge))


def _lines(script: Script, diagonal: float, mean_edge: float) -> Iterator[str]:
    yield "<!DOCTYPE FilterScript>"
    if script.comment:
        yield f"<!--\n{_comment(script.comment)}\n-->"
    unit = {"unit": script.unit} if script.unit else {}
    yield _element("FilterScript", unit | {GUARDS[name]: text for name, text in script.guards.texts().items()}, ">")
    for setting in script.settings:
        yield "  " + _element(
            "setting", {name: text for name in SETTING_ATTRIBUTES if (text := getattr(setting, name)) or name == "default"}
        )
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


def param_attributes(parameter: Parameter, value: Any, *, diagonal: float, mean_edge: float) -> dict[str, str]:
    """The attributes of the ``<Param>`` that gives a checked value, in the order in which they are written."""
    written = {"type": parameter.xml_type, "name": parameter.xml_name}
    value = parameter.to_number(value)
    if isinstance(parameter, Bool):
        written["value"] = "true" if value else "false"
    elif isinstance(parameter, Float):
        written["value"] = number_text(value)
        if parameter.minimum is not None and parameter.maximum is not None:
            least = min(parameter.minimum, parameter.minimum if parameter.automatic is None else parameter.automatic)
            written |= {"min": number_text(least), "max": number_text(parameter.maximum)}
    elif isinstance(parameter, Percentage):
        value = value if isinstance(value, Length) else Length(value)
        amount = value.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge)
        written |= {"value": number_text(amount), "min": number_text(min(0.0, amount)), "max": number_text(max(diagonal, amount))}
        if value.unit != "absolute":
            written["relative"] = f"{number_text(value.amount)}{'%' if value.unit == 'percent' else 'edge'}"
    elif isinstance(parameter, Enum):
        written |= {"value": str(parameter.choices.index(value)), "enum_cardinality": str(len(parameter.choices))}
        written |= {f"enum_val{i}": word for i, word in enumerate(parameter.choices)}
    elif isinstance(parameter, Point):
        written |= dict(zip("xyz", map(number_text, value), strict=True))
    elif isinstance(parameter, Color):
        written |= dict(zip("rgba", map(str, value), strict=True))
    elif isinstance(parameter, Matrix):
        written |= {f"val{i}": number_text(x) for i, x in enumerate(x for row in value for x in row)}
    else:
        written["value"] = str(value)
        if isinstance(parameter, FileOpen):
            written["exts_cardinality"] = "0"
    return written


def number_text(number: float) -> str:
    """The shortest text that reads back as the same number: 0.1, 10, 1e-05."""
    return repr(float(number)).removesuffix(".0")


def _quoted(text: str) -> str:
    _check_writable(text)
    escaped = text.translate(_ESCAPES)
    if '"' in escaped and "'" not in escaped:
        return f"'{escaped}'"
    return '"' + escaped.replace('"', "&quot;") + '"'


def _comment(text: str) -> str:
    _check_writable(text)
    if "--" in text or text.endswith("-"):
        raise PymeshfairError("the head comment of a script cannot contain '--' or end with '-': XML does not allow it")
    return text


def _check_writable(text: str) -> None:
    if unwritable := _UNWRITABLE.search(text):
        raise PymeshfairError(f"the text {text[:80]!r} cannot be written to a script: XML has no {unwritable.group()!r}")


def write_script(
    script: Script,
    path: str | Path,
    *,
    diagonal: float = NOMINAL_DIAGONAL,
    mean_edge: float = NOMINAL_EDGE,
    overwrite: bool = False,
) -> None:
    """Write the script as `format_script` does; the file appears whole or not at all.

    With `overwrite` an existing file is replaced if its name ends with .mlx.

    Raises:
        OutputError: it cannot or must not be written; what was at `path` before is untouched.
        PymeshfairError: a text holds what XML cannot.
    """
    target = Path(path)
    text = format_script(script, diagonal=diagonal, mean_edge=mean_edge)
    write_file(target, text.encode("utf-8"), overwrite=overwrite and extension(target) == "mlx")


@dataclass(frozen=True)
class MeshFacts:
    """The sizes of the mesh that a script is exported for."""

    diagonal: float  # of its bounding box
    mean_edge: float  # the mean length of its edges; of a point cloud, the mean distance to the nearest neighbour
    closed: bool  # whether every edge has two faces


def export_script(
    script: Script, *, mesh: MeshFacts | None = None, lengths: Sequence[Mapping[str, Length]] = ()
) -> tuple[str, tuple[str, ...]]:
    """The script for MeshLab's desktop and plain pymeshlab.

    A filter of a plugin is replaced where it declares that one of MeshLab's does the same. Settings, tags, limits and the
    unit, which mean nothing there, are left out.

    Args:
        script: the steps.
        mesh: the mesh that the script is for. Without it relative lengths cannot be mesh units, and a script that has any is
            refused, as is one with a filter that has an equal on closed meshes alone.
        lengths: by step, lengths in mesh units by Python parameter name, in place of relative ones; what is not there is
            relative to `mesh`.

    Raises:
        ScriptError: MeshLab alone cannot do what a step does, or a length is relative and no mesh is given; lists all of them.
        PymeshfairError: a text holds what XML cannot.
    """
    whole = script.with_defaults()
    closed, steps, replaced = mesh is not None and mesh.closed, list[Step](), list[str]()
    problems: list[Problem] = []
    for number, step in enumerate(whole.steps, 1):
        plain = step if step.filter.is_builtin else _equivalent(step, closed=closed)
        if plain is None:
            problems.append(script.problem(step, _why_not(step, has_mesh=mesh is not None)))
            continue
        problems += _relative_lengths(script, plain) if mesh is None else ()
        if plain is not step:
            replaced.append(f"step {number}, {step.filter.name!r}, is MeshLab's {plain.filter.name!r}, which does the same")
        if plain is step and number <= len(lengths):
            plain = plain.with_checked(lengths[number - 1])
        steps.append(plain if mesh is None else plain.in_mesh_units(diagonal=mesh.diagonal, mean_edge=mesh.mean_edge))
        closed = closed and FilterClass.SMOOTHING in step.filter.classes  # any other step may open the mesh, or select
    if problems:
        raise ScriptError(problems)
    bare = (replace(step, tag="", settings={}) for step in steps)
    size = MeshFacts(NOMINAL_DIAGONAL, NOMINAL_EDGE, closed=False) if mesh is None else mesh
    plain_script = replace(whole.with_steps(bare), guards=NO_GUARDS, unit="")
    return format_script(plain_script, diagonal=size.diagonal, mean_edge=size.mean_edge), tuple(replaced)


def _equivalent(step: Step, *, closed: bool) -> Step | None:
    """The step with MeshLab's filter that does the same; None if there is none."""
    equivalent = None if step.filter.equivalent is None else step.filter.equivalent(step.values)
    if equivalent is None or (equivalent.closed_only and not closed):
        return None
    own = find_filter(equivalent.filter)
    return Step(own, own.with_defaults(equivalent.values), step.line)


def _why_not(step: Step, *, has_mesh: bool) -> str:
    message = f"is a filter of {step.filter.origin}, which MeshLab lacks; MeshLab alone cannot run this step"
    equivalent = None if step.filter.equivalent is None else step.filter.equivalent(step.values)
    if equivalent is None:
        return message
    name = find_filter(equivalent.filter).name
    return f"{message}: {name!r} does the same on closed meshes alone, " + (
        "and this one is open, or a step before may open it or select" if has_mesh else "say with --for MESH which mesh it is for"
    )


def _relative_lengths(script: Script, step: Step) -> Iterator[Problem]:
    for name, length in step.relative_lengths.items():
        why = f"is {length}, which depends on the size of the mesh; say with --for MESH which mesh the script is for"
        yield script.problem(step, why, parameter=step.filter.parameter(name).xml_name)
