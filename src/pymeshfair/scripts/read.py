"""Reads .mlx scripts, and says everything that is wrong with one before any mesh is opened.

MeshLab ignores what it does not understand. Here unknown elements, names, types and values are problems; comments and unknown
attributes are not. A hostile file costs little: entities and document type subsets are refused where they begin, and size,
depth and number of steps have limits.
"""

from __future__ import annotations

import codecs
import stat
from pathlib import Path
from typing import Any
from xml.parsers import expat

from ..declaration import Filter, nearest
from ..errors import UnknownNameError
from ..meshlab.renamed import renamed_filter
from ..registry import find_filter
from .parameters import read_value
from .problems import Problem, ScriptError, shortened
from .script import Script, Step, clean_comment

MOST_BYTES = 5_000_000
MOST_LEVELS = 64
MOST_FILTERS = 1000
#: Reading ends after this many problems; whoever wrote that many has one cause to find.
MOST_PROBLEMS = 100

_ENCODINGS = frozenset({"utf-8", "utf8", "utf-16", "us-ascii", "ascii"})


def read_script(path: str | Path) -> Script:
    """The script in a file.

    Raises:
        ScriptError: the file cannot be read or its contents are wrong; lists every problem.
    """
    file = Path(path)
    try:
        if not stat.S_ISREG(file.stat().st_mode):
            raise ScriptError([Problem(file=str(path), message="is not a file")])
        with file.open("rb") as stream:
            data = stream.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise ScriptError([Problem(file=str(path), message=f"cannot be read: {reason}")]) from error
    return parse_script(data, str(path), path=file)


def parse_script(data: bytes, name: str, *, path: Path | None = None) -> Script:
    """The script that the bytes of an .mlx file spell; `name` stands for the file in messages.

    Raises:
        ScriptError: something is wrong; lists every problem.
    """
    reader = _Reader(name)
    reader.read(data)
    if reader.problems:
        raise ScriptError(reader.problems)
    return Script(tuple(reader.steps), clean_comment("\n\n".join(reader.comments)), path)


def _today(name: str | None) -> str:
    """What the filter of an ``<xmlfilter>`` is called today, as the end of a sentence."""
    renamed = renamed_filter(name or "")
    return "" if renamed is None else f"; the filter is called {renamed.name!r} now"


class _EndedError(Exception):
    """Nothing more can be learned from the file."""


class _Reader:
    def __init__(self, name: str) -> None:
        self.name = name
        self.problems: list[Problem] = []
        self.steps: list[Step] = []
        self.comments: list[str] = []
        self._filters = 0
        self._open: list[str] = []
        self._filter: Filter | None = None
        self._filter_name: str | None = None
        self._filter_line = 0
        self._values: dict[str, Any] = {}
        self._parser = expat.ParserCreate("utf-8")
        self._parser.buffer_text = True
        self._parser.XmlDeclHandler = self._declaration
        self._parser.StartDoctypeDeclHandler = self._document_type
        self._parser.EntityDeclHandler = self._entity
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text
        self._parser.CommentHandler = self._comment

    def read(self, data: bytes) -> None:
        """Collect `steps` and `problems`."""
        if len(data) > MOST_BYTES:
            self.problems.append(
                Problem(file=self.name, message=f"is larger than {MOST_BYTES / 1e6:.0f} MB, the most for a script")
            )
            return
        try:
            self._parser.Parse(self._utf8(data), True)
        except _EndedError:
            return
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            self.problems.append(Problem(file=self.name, line=error.lineno, message=f"is not well-formed XML: {reason}"))
            return
        if not self._filters and not self.problems:
            self._problem("the script has no <filter>, so it would do nothing")

    def _utf8(self, data: bytes) -> bytes:
        utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        try:
            text = data.decode("utf-16" if utf16 else "utf-8-sig")
        except UnicodeDecodeError as error:
            line = None if utf16 else data.count(b"\n", 0, error.start) + 1
            self.problems.append(
                Problem(
                    file=self.name,
                    line=line,
                    message=f"is not {'UTF-16' if utf16 else 'UTF-8'} text (byte {data[error.start]:#04x}); save it as UTF-8",
                )
            )
            raise _EndedError from error
        return text.encode("utf-8")

    def _problem(
        self,
        message: str,
        *,
        parameter: str | None = None,
        suggestion: str | None = None,
        outside: bool = False,
        lines_ago: int = 0,
    ) -> None:
        """Note a problem some lines before where the parser is; `outside` if it does not concern the filter that is open."""
        self.problems.append(
            Problem(
                file=self.name,
                line=self._parser.CurrentLineNumber - lines_ago,
                filter=None if outside else self._filter_name,
                parameter=parameter,
                message=message,
                suggestion=suggestion,
            )
        )
        if len(self.problems) >= MOST_PROBLEMS:
            self.problems.append(Problem(file=self.name, message=f"has more problems; only the first {MOST_PROBLEMS} are listed"))
            raise _EndedError

    def _fatal(self, message: str) -> None:
        self._problem(message, outside=True)
        raise _EndedError

    # ------------------------------------------------------------------------------------------- expat's handlers

    def _declaration(self, version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None and encoding.lower() not in _ENCODINGS:
            self._fatal(f"says that it is written in {shortened(encoding)!r}; save it as UTF-8")

    def _document_type(self, name: str, system: str | None, public: str | None, has_subset: int) -> None:
        if system is not None or public is not None or has_subset:
            self._fatal("has a document type with entities or an external subset; write <!DOCTYPE FilterScript> and nothing else")
        if name != "FilterScript":
            self._problem(f"has the document type {shortened(name)!r}", suggestion="FilterScript")

    def _entity(self, *_: object) -> None:
        self._fatal("declares an entity, which no script needs")

    def _comment(self, text: str) -> None:
        if not self._filters:
            self.comments.append(text)

    def _text(self, text: str) -> None:
        if not text.isspace():
            self._problem(
                f"the text {shortened(text.strip())!r} means nothing here; values belong in attributes",
                lines_ago=text.lstrip().count("\n"),
            )

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._open.append(tag)
        depth = len(self._open)
        if depth > MOST_LEVELS:
            self._fatal(f"nests elements more than {MOST_LEVELS} deep")
        if depth == 1:
            if tag != "FilterScript":
                self._fatal(f"is no filter script: it begins with <{shortened(tag)}> instead of <FilterScript>")
        elif self._open[1:-1] and self._open[1] == "xmlfilter":
            pass  # said once, at the xmlfilter itself
        elif depth == 2:
            self._start_in_script(tag, attributes)
        elif depth == 3 and tag == "Param" and self._open[1] == "filter":
            if self._filter is not None:
                self._param(self._filter, attributes)
        else:
            self._unknown_element(tag, "Param" if self._open[1] == "filter" and depth == 3 else None)

    def _end(self, tag: str) -> None:
        self._open.pop()
        if len(self._open) == 1:
            if self._filter is not None:
                values = {p.name: self._values[p.name] for p in self._filter.parameters if p.name in self._values}
                self.steps.append(Step(self._filter, values, self._filter_line))
            self._filter, self._filter_name, self._values = None, None, {}

    # ------------------------------------------------------------------------------------------------- what they mean

    def _unknown_element(self, tag: str, expected: str | None) -> None:
        meant = expected if expected and nearest(tag, [expected]) else None
        self._problem(f"the element <{shortened(tag)}> is unknown here; MeshLab would ignore it", suggestion=meant)

    def _start_in_script(self, tag: str, attributes: dict[str, str]) -> None:
        if tag not in ("filter", "xmlfilter"):
            self._unknown_element(tag, "filter")
            return
        self._filters += 1
        if self._filters > MOST_FILTERS:
            self._fatal(f"has more than {MOST_FILTERS} filters")
        self._filter_line = self._parser.CurrentLineNumber
        self._filter_name = name = attributes.get("name")
        if tag == "xmlfilter":
            self._problem(f"<xmlfilter> is of MeshLab 2016, which alone can run it{_today(name)}", suggestion="filter")
        elif name is None:
            self._problem("<filter> has no name; MeshLab would fail there")
        else:
            self._filter = self._known_filter(name)

    def _known_filter(self, name: str) -> Filter | None:
        try:
            found = find_filter(name)
        except UnknownNameError as error:
            renamed = renamed_filter(name)
            if renamed is not None:
                self._problem(f"MeshLab has renamed this filter to {renamed.name!r}{renamed.note}", suggestion=renamed.name)
            else:
                near = error.suggestion
                self._problem("there is no filter of that name", suggestion=find_filter(near).name if near else None)
            return None
        if found.name != name:
            self._problem("that is the filter's name in Python; scripts use the one in MeshLab's menus", suggestion=found.name)
            return None
        return found

    def _param(self, known: Filter, attributes: dict[str, str]) -> None:
        name = attributes.get("name")
        if name is None:
            self._problem("<Param> has no name; MeshLab would drop it")
            return
        parameter = next((p for p in known.parameters if p.xml_name == name), None)
        if parameter is None:
            in_python = next((p.xml_name for p in known.parameters if p.name == name), None)
            names = [p.xml_name for p in known.parameters]
            allowed = f"it has {', '.join(names)}" if names else "it has none"
            near = in_python or nearest(name, names)
            self._problem(f"the filter has no such parameter; {allowed}", parameter=name, suggestion=near)
            return
        if parameter.name in self._values:
            self._problem("is given twice; MeshLab would take the last", parameter=name)
            return
        value, complaints = read_value(parameter, attributes, filter_name=known.python_name)
        self._values[parameter.name] = value
        for message, suggestion in complaints:
            self._problem(message, parameter=name, suggestion=suggestion)
