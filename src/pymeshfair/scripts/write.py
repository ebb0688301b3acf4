"""Writes .mlx scripts that MeshLab, pymeshlab and `read_script` read alike, number by number.

MeshLab itself writes six digits and its attributes in random order; here numbers read back exactly, and the same script is
always the same bytes.
"""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..declaration import Bool, Color, Enum, FileOpen, Float, Length, Matrix, Parameter, Percentage, Point
from ..errors import PymeshfairError
from ..files.formats import extension
from ..files.writing import write_file
from .guards import ATTRIBUTES as GUARDS
from .script import SETTING_ATTRIBUTES, Script

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
        given = [p for p in step.filter.parameters if p.name in step.values]
        named = {"name": step.filter.name} | ({"tag": step.tag} if step.tag else {})
        yield "  " + _element("filter", named, ">" if given else "/>")
        for parameter in given:
            attributes = param_attributes(parameter, step.values[parameter.name], diagonal=diagonal, mean_edge=mean_edge)
            if parameter.name in step.settings:
                attributes["setting"] = step.settings[parameter.name]
            yield "    " + _element("Param", attributes)
        if given:
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
    if found := _UNWRITABLE.search(text):
        raise PymeshfairError(f"the text {text[:80]!r} cannot be written to a script: XML has no {found.group()!r}")


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
