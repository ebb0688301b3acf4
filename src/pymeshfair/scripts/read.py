"""Reads .mlx scripts, and lists all problems of a script before any mesh is opened.

MeshLab ignores what it does not understand. Here unknown elements, names, types and values are problems; comments and unknown
attributes are not. A hostile file costs little: entities and document type subsets are refused where they begin, and size,
depth and number of steps have limits.
"""

import codecs
import re
import stat
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.parsers import expat

from ..declaration import nearest
from ..declaration.units import check_unit
from ..errors import ParameterError
from .guards import ATTRIBUTES as GUARDS
from .guards import Guards
from .problems import MOST_PROBLEMS, Problem, ScriptError, shortened
from .script import Document, FilterElement, ParamElement, Script, Setting, clean_comment, read_setting
from .step_builder import build_script

MOST_BYTES = 5_000_000
MOST_LEVELS = 64
MOST_FILTERS = 1000
#: the attribute of ``<FilterScript>`` that names the unit of the scans
UNIT = "unit"
#: of one element
MOST_ATTRIBUTES = 100
#: characters of a name of a filter, a parameter or a type
LONGEST_NAME = 1000
#: the document type twice, as some old programs write it
SECOND_DOCUMENT_TYPE = re.compile(rb"\A(.*?<!DOCTYPE FilterScript>\s*)<!DOCTYPE FilterScript>", re.DOTALL)
_ENCODINGS = frozenset({"utf-8", "utf8", "utf-16", "us-ascii", "ascii"})


def excess(attributes: Mapping[str, str]) -> str | None:
    """The limit that an element exceeds by its attributes or its name, in words; None if it is within the limits."""
    if len(attributes) > MOST_ATTRIBUTES:
        return f"has an element of {len(attributes):,} attributes; {MOST_ATTRIBUTES} are the most"
    longest = max(len(attributes.get(key, "")) for key in ("name", "type"))
    return f"has a name of {longest:,} characters; {LONGEST_NAME:,} are the most" if longest > LONGEST_NAME else None


def read_script(path: str | Path) -> Script:
    """The script in a file.

    Raises:
        ScriptError: the file cannot be read or its contents are wrong; lists every problem.
    """
    return parse_script(read_bytes(path), str(path), path=Path(path))


def read_bytes(path: str | Path) -> bytes:
    """The contents of a file, at most one byte more than a script may have."""
    file = Path(path)
    try:
        if not stat.S_ISREG(file.stat().st_mode):
            raise ScriptError([Problem(file=str(path), message="is not a file")])
        with file.open("rb") as stream:
            return stream.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise ScriptError([Problem(file=str(path), message=f"cannot be read: {reason}")]) from error


def parse_script(data: bytes, name: str, *, path: Path | None = None) -> Script:
    """The script in the bytes of an .mlx file; `name` stands for the file in messages.

    Raises:
        ScriptError: something is wrong; lists every problem.
    """
    return build_script(parse_document(data, name), path)


def parse_document(data: bytes, name: str) -> Document:
    """The elements of a script and the problems of its structure; filters and parameters are not checked."""
    reader = _Reader(name)
    reader.read(data)
    comment = clean_comment("\n\n".join(reader.comments))
    problems, settings = tuple(reader.problems), tuple(reader.settings)
    return Document(name, tuple(reader.filters), comment, problems, reader.guards, settings, reader.unit)


class _EndedError(Exception):
    """Reading cannot continue; the problem is in the list."""


class _Reader:
    def __init__(self, name: str) -> None:
        self.name = name
        self.problems: list[Problem] = []
        self.filters: list[FilterElement] = []
        self.comments: list[str] = []
        self.guards = Guards()
        self.unit = ""
        self.settings: list[Setting] = []
        self._filter: FilterElement | None = None
        self._params: list[ParamElement] = []
        self._open: list[str] = []
        self._parser = expat.ParserCreate("utf-8")
        self._parser.buffer_text = True
        self._parser.XmlDeclHandler = self._declaration
        self._parser.StartDoctypeDeclHandler = self._document_type
        self._parser.EntityDeclHandler = lambda *_: self._fatal("declares an entity, which no script needs")
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text
        self._parser.CommentHandler = self._comment
        self._parser.ProcessingInstructionHandler = self._instruction

    def read(self, data: bytes) -> None:
        """Collect `filters` and `problems`."""
        if len(data) > MOST_BYTES:
            message = f"is larger than {MOST_BYTES / 1e6:.0f} MB, the most for a script"
            self.problems.append(Problem(file=self.name, message=message))
            return
        try:
            self._parser.Parse(self._utf8(data), True)
        except _EndedError:
            return
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            if SECOND_DOCUMENT_TYPE.search(data[: self._parser.ErrorByteIndex + 100]):
                reason = "a second <!DOCTYPE FilterScript>, which `pymeshfair upgrade` leaves out"
            self.problems.append(Problem(file=self.name, line=error.lineno, message=f"is not well-formed XML: {reason}"))
            return
        if not self.filters and not self.problems:
            self._problem("the script has no <filter>, so it would do nothing")

    def _utf8(self, data: bytes) -> bytes:
        utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        try:
            text = data.decode("utf-16" if utf16 else "utf-8-sig")
        except UnicodeDecodeError as error:
            line = None if utf16 else data.count(b"\n", 0, error.start) + 1
            message = f"is not {'UTF-16' if utf16 else 'UTF-8'} text (byte {data[error.start]:#04x}); save it as UTF-8"
            self.problems.append(Problem(file=self.name, line=line, message=message))
            raise _EndedError from error
        return text.encode("utf-8")

    def _problem(self, message: str, *, suggestion: str | None = None, outside: bool = False, lines_ago: int = 0) -> None:
        """Add a problem, `lines_ago` lines before the parser's line; `outside` if it does not concern the open filter."""
        line = self._parser.CurrentLineNumber - lines_ago
        filter = None if outside or self._filter is None else self._filter.name
        self.problems.append(Problem(file=self.name, line=line, filter=filter, message=message, suggestion=suggestion))
        if len(self.problems) > MOST_PROBLEMS:
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

    def _instruction(self, target: str, data: str) -> None:
        self._problem(f"the instruction <?{shortened(target)}?> means nothing here")

    def _comment(self, text: str) -> None:
        if self._filter is None and not self.filters:
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
        if reason := excess(attributes):
            self._fatal(reason)
        if depth == 1:
            if tag != "FilterScript":
                self._fatal(f"is no filter script: it begins with <{shortened(tag)}> instead of <FilterScript>")
            self._read_head(attributes)
        elif self._open[1] == "xmlfilter" and depth > 2:  # <xmlfilter> itself is reported once
            if depth == 3 and tag in ("Param", "xmlparam"):
                self._params.append(ParamElement(attributes, self._parser.CurrentLineNumber))
        elif depth == 2:
            self._start_in_script(tag, attributes)
        elif depth == 3 and tag == "Param" and self._open[1] == "filter":
            self._params.append(ParamElement(attributes, self._parser.CurrentLineNumber))
        else:
            self._unknown_element(tag, "Param" if self._open[1] == "filter" and depth == 3 else None)

    def _end(self, tag: str) -> None:
        self._open.pop()
        if len(self._open) == 1 and self._filter is not None:
            self.filters.append(replace(self._filter, params=tuple(self._params)))
            self._filter, self._params = None, []

    def _start_in_script(self, tag: str, attributes: dict[str, str]) -> None:
        line = self._parser.CurrentLineNumber
        if tag == "setting":
            setting, wrong, suggestion = read_setting(attributes, line)
            if setting is not None:
                self.settings.append(setting)
            if wrong is not None:
                self._problem(wrong, suggestion=suggestion)
        elif tag in ("filter", "xmlfilter"):
            if len(self.filters) == MOST_FILTERS:
                self._fatal(f"has more than {MOST_FILTERS} filters")
            self._filter = FilterElement(tag, attributes.get("name"), line, tag=attributes.get("tag", ""))
        else:
            self._unknown_element(tag, "filter")

    def _read_head(self, attributes: dict[str, str]) -> None:
        texts = {name: attributes[attribute] for name, attribute in GUARDS.items() if attribute in attributes}
        try:
            self.guards = Guards.parse(texts)
            self.unit = check_unit(attributes[UNIT]) if UNIT in attributes else ""
        except ParameterError as error:
            self._problem(str(error))
        for attribute in attributes:
            allowed = (*GUARDS.values(), UNIT)
            near = None if attribute in allowed else nearest(attribute, allowed)
            if near is not None:
                self._problem(f"<FilterScript> has no attribute {shortened(attribute)!r}", suggestion=near)

    def _unknown_element(self, tag: str, expected: str | None) -> None:
        meant = expected if expected and nearest(tag, [expected]) else None
        self._problem(f"the element <{shortened(tag)}> is unknown here; MeshLab would ignore it", suggestion=meant)
