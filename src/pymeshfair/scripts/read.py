"""Reads .mlx scripts, and lists the problems of a script, up to `MOST_PROBLEMS`, before any mesh is opened.

Unknown elements, names, types and values are problems, even where MeshLab ignores them; comments and most unknown attributes are
not. A hostile file costs little: entities and document type subsets are refused at once; size, depth and steps have limits.
"""

import codecs
import contextlib
import re
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any
from xml.parsers import expat

from ..declaration import Filter
from ..declaration.parameters import check_unit
from ..errors import ParameterError, UnknownNameError, nearest, plain_name, shortened
from ..meshlab.facts import Former, former_filter, former_parameters
from ..registry import all_filters, find_filter
from .guards import ATTRIBUTES as GUARDS
from .guards import NO_GUARDS, Guards
from .script import SETTING_ATTRIBUTES, Problem, Script, ScriptError, Setting, Step, checked_name, clean_comment
from .values import Complaint, parse_value, read_value

MOST_PROBLEMS = 100
MOST_BYTES = 5_000_000
MOST_LEVELS = 64
MOST_FILTERS = 1000
MOST_ATTRIBUTES = 100  # of one element
LONGEST_NAME = 1000  # of a filter, a parameter or a type, in characters
SLIP = 0.87  # the least similarity of a typo and a suggestion; ``Delete Selection`` and ``Dilate Selection`` are less similar
UNIT = "unit"  # the attribute of ``<FilterScript>`` that names the unit of the scans
#: a document type that is written twice, as by some old programs
SECOND_DOCUMENT_TYPE = re.compile(rb"\A(.*?<!DOCTYPE FilterScript>\s*)<!DOCTYPE FilterScript>", re.DOTALL)
_ENCODINGS = {False: ("utf-8", "utf8", "us-ascii", "ascii"), True: ("utf-16",)}  # by whether the bytes are UTF-16


@dataclass(frozen=True)
class ParamElement:
    """A ``<Param>`` or ``<xmlparam>``."""

    attributes: Mapping[str, str]  # as written
    line: int  # from 1


@dataclass(frozen=True)
class FilterElement:
    """A ``<filter>`` or ``<xmlfilter>``."""

    kind: str  # ``"filter"`` or ``"xmlfilter"``
    name: str | None  # its attribute ``name``
    line: int  # from 1
    tag: str = ""  # its attribute ``tag``
    params: list[ParamElement] = field(default_factory=list)


@dataclass
class Document:
    """The elements of a file as written, and the problems of its structure; filters and parameters are not checked yet."""

    name: str  # the name of the file, for messages
    filters: list[FilterElement] = field(default_factory=list)
    comment: str = ""  # the head comment
    later_comments: list[int] = field(default_factory=list)  # the lines of the comments that are not kept
    problems: list[Problem] = field(default_factory=list)
    guards: Guards = NO_GUARDS
    settings: list[Setting] = field(default_factory=list)
    unit: str = ""  # the unit of the scans that the script is for; may be empty


def read_script(path: str | Path) -> Script:
    """The script in a file; raise `ScriptError`, which lists the problems, if the file cannot be read or has problems."""
    return parse_script(read_bytes(path), str(path), path=Path(path))


def read_bytes(path: str | Path) -> bytes:
    """The contents of a file: at most `MOST_BYTES` + 1 bytes, enough for `parse_script` to refuse a larger file."""
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
    """The script in the bytes of an .mlx file, see `read_script`; messages call the file `name`."""
    return build_script(parse_document(data, name), path)


class _EndedError(Exception):
    """Reading cannot continue; the problem is already in the list."""


def parse_document(data: bytes, name: str) -> Document:
    """The elements of an .mlx file."""
    return _Reader(name).read(data)


class _Reader:
    def __init__(self, name: str) -> None:
        self._read = Document(name)
        self._comments: list[str] = []
        self._filter: FilterElement | None = None
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
        self._parser.ProcessingInstructionHandler = lambda target, data: self._problem(
            f"the instruction <?{shortened(target)}?> means nothing here"
        )

    def read(self, data: bytes) -> Document:
        with contextlib.suppress(_EndedError):
            self._parse(data)
            if not self._read.filters and not self._read.problems:
                self._problem("the script has no <filter>, so it would do nothing")
        self._read.comment = clean_comment("\n\n".join(self._comments))
        return self._read

    def _parse(self, data: bytes) -> None:
        if len(data) > MOST_BYTES:
            self._end_with(f"is larger than {MOST_BYTES / 1e6:.0f} MB, the most for a script", None)
        utf16 = self._utf16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        try:
            self._parser.Parse(data.decode("utf-16" if utf16 else "utf-8-sig").encode("utf-8"), True)
        except UnicodeDecodeError as error:
            wrong = f"is not {'UTF-16' if utf16 else 'UTF-8'} text (byte {data[error.start]:#04x}); save it as UTF-8"
            self._end_with(wrong, None if utf16 else data.count(b"\n", 0, error.start) + 1)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            if SECOND_DOCUMENT_TYPE.search(data[: self._parser.ErrorByteIndex + 100]):
                reason = "a second <!DOCTYPE FilterScript>, which `pymeshfair upgrade` leaves out"
            self._end_with(f"is not well-formed XML: {reason}", error.lineno)

    def _end_with(self, message: str, line: int | None) -> None:
        self._read.problems.append(Problem(file=self._read.name, line=line, message=message))
        raise _EndedError

    def _fatal(self, message: str) -> None:
        self._end_with(message, self._parser.CurrentLineNumber)

    def _problem(self, message: str, suggestion: str | None = None, *, lines_ago: int = 0) -> None:
        line, read = self._parser.CurrentLineNumber - lines_ago, self._read
        filter = None if self._filter is None else self._filter.name
        read.problems.append(Problem(file=read.name, line=line, filter=filter, message=message, suggestion=suggestion))
        if len(read.problems) > MOST_PROBLEMS:
            raise _EndedError

    def _declaration(self, version: str, encoding: str | None, standalone: int) -> None:
        if encoding is not None and encoding.lower() not in _ENCODINGS[self._utf16]:
            actual = "UTF-16" if self._utf16 else "UTF-8"
            self._fatal(f"says that it is written in {shortened(encoding)!r}, but is read as {actual}; save it as UTF-8")

    def _document_type(self, name: str, system: str | None, public: str | None, has_subset: int) -> None:
        if system is not None or public is not None or has_subset:
            self._fatal("has a document type with more than its name; write <!DOCTYPE FilterScript> and nothing else")
        if name != "FilterScript":
            self._problem(f"has the document type {shortened(name)!r}", "FilterScript")

    def _comment(self, text: str) -> None:
        if self._filter is None and not self._read.filters:
            self._comments.append(text)
        else:
            self._read.later_comments.append(self._parser.CurrentLineNumber)

    def _text(self, text: str) -> None:
        if not text.isspace():
            words = f"the text {shortened(text.strip())!r} means nothing here; values belong in attributes"
            self._problem(words, lines_ago=text.lstrip().count("\n"))

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._open.append(tag)
        depth, line = len(self._open), self._parser.CurrentLineNumber
        if depth > MOST_LEVELS:
            self._fatal(f"nests elements more than {MOST_LEVELS} deep")
        if len(attributes) > MOST_ATTRIBUTES:
            self._fatal(f"has an element of {len(attributes):,} attributes; {MOST_ATTRIBUTES} are the most")
        if (longest := max(len(attributes.get(key, "")) for key in ("name", "type"))) > LONGEST_NAME:
            self._fatal(f"has a name of {longest:,} characters; {LONGEST_NAME:,} are the most")
        if depth == 1:
            if tag != "FilterScript":
                self._fatal(f"is no filter script: it begins with <{shortened(tag)}> instead of <FilterScript>")
            self._read_head(attributes)
        elif depth == 2 and tag == "setting":
            self._read_setting(attributes, line)
        elif depth == 2 and tag in ("filter", "xmlfilter"):
            if len(self._read.filters) == MOST_FILTERS:
                self._fatal(f"has more than {MOST_FILTERS} filters")
            self._filter = FilterElement(tag, attributes.get("name"), line, attributes.get("tag", ""))
            for complaint in _slips(tag, attributes, ("name", "tag")):
                self._problem(*complaint)
        elif depth == 3 and self._filter and tag in ("Param", "xmlparam")[: 1 + (self._open[1] == "xmlfilter")]:
            self._filter.params.append(ParamElement(attributes, line))
        elif self._open[1] != "xmlfilter":  # an xmlfilter is one problem, whatever it contains
            expected = {("FilterScript",): ("filter", "setting"), ("FilterScript", "filter"): ("Param",)}
            suggestion = nearest(tag, expected.get(tuple(self._open[:-1]), ()))
            self._problem(f"the element <{shortened(tag)}> is unknown here; MeshLab would ignore it", suggestion)

    def _end(self, tag: str) -> None:
        self._open.pop()
        if len(self._open) == 1 and self._filter is not None:
            self._read.filters.append(self._filter)
            self._filter = None

    def _read_head(self, attributes: dict[str, str]) -> None:
        texts = {name: attributes[attribute] for name, attribute in GUARDS.items() if attribute in attributes}
        try:
            self._read.guards = Guards.parse(texts, GUARDS)
            self._read.unit = check_unit(attributes[UNIT]) if UNIT in attributes else ""
        except ParameterError as error:
            self._problem(str(error))
        for complaint in _slips("FilterScript", attributes, (*GUARDS.values(), UNIT), cutoff=0.6):
            self._problem(*complaint)

    def _read_setting(self, attributes: dict[str, str], line: int) -> None:
        missing = [name for name in ("name", "default") if name not in attributes]
        unknown = [name for name in attributes if name not in SETTING_ATTRIBUTES]
        if missing or unknown:
            wrong = f"no {missing[0]}" if missing else f"no attribute {shortened(unknown[0])!r}"
            self._problem(f"<setting> has {wrong}; it takes {', '.join(SETTING_ATTRIBUTES)}")
            return
        try:
            self._read.settings.append(Setting(**attributes, line=line))
        except ParameterError as error:
            self._problem(str(error))


def _slips(tag: str, attributes: Iterable[str], ours: Sequence[str], *, cutoff: float = 0.85) -> Iterator[Complaint]:
    """Complaints about attributes whose names are similar to `ours`; no attribute that MeshLab writes is so similar."""
    for attribute in attributes:
        if attribute not in ours and (near := nearest(attribute, ours, cutoff=cutoff)):
            yield f"<{tag}> has no attribute {shortened(attribute)!r}", near


def build_script(document: Document, path: Path | None = None) -> Script:
    """The script of a document; raise `ScriptError` if there are problems."""
    problems, steps = list(document.problems), list[Step]()
    for element in document.filters:
        step, problems_of_step = _step(element, partial(Problem, file=document.name, filter=element.name))
        steps += [] if step is None else [step]
        problems += problems_of_step
        if len(problems) > MOST_PROBLEMS:
            break
    if not problems:
        problems += _setting_problems(document, steps)
    problems.sort(key=lambda problem: problem.line or 0)
    if len(problems) > MOST_PROBLEMS:
        words = f"has more problems; only the first {MOST_PROBLEMS} are listed"
        problems[MOST_PROBLEMS:] = [Problem(file=document.name, message=words)]
    if problems:
        raise ScriptError(problems)
    return Script(tuple(steps), document.comment, path, document.guards, tuple(document.settings), document.unit)


def _step(element: FilterElement, complain: Callable[..., Problem]) -> tuple[Step | None, list[Problem]]:
    """The step of an element, or None if no step can be made, and its problems; `complain` makes a `Problem`."""
    name, line = element.name, element.line
    if element.kind == "xmlfilter":
        former = former_filter(name or "")
        today = f"; the filter is called {former.now!r} now" if former and former.now else ""
        words = f"<xmlfilter> is of MeshLab 2016, which alone can run it{today}; `pymeshfair upgrade` rewrites it"
        return None, [complain(message=words, line=line, suggestion="filter")]
    if name is None:
        return None, [complain(message="<filter> has no name; MeshLab would fail there", line=line)]
    try:
        declared = find_filter(name)
    except UnknownNameError as error:
        message, suggestion = _unknown(name, error.cause)
        return None, [complain(message=message, line=line, suggestion=suggestion)]
    if declared.name != name:
        message = "that is the filter's name in Python; scripts use the one in MeshLab's menus"
        return None, [complain(message=message, line=line, suggestion=declared.name)]
    problems: list[Problem] = []
    try:
        checked_name(element.tag or "none", "tag")
    except ParameterError as error:
        problems.append(complain(message=str(error), line=line))
    values: dict[str, Any] = {}
    for param in element.params:
        of_param = partial(complain, line=param.line, parameter=param.attributes.get("name"))
        problems += [of_param(message=message, suggestion=hint) for message, hint in _add_param(declared, param, values)]
    named = {param.attributes.get("name"): param.attributes.get("setting") for param in element.params}
    settings = {p.name: setting for p in declared.parameters if (setting := named.get(p.xml_name)) is not None}
    return Step(declared, declared.in_order(values), line, element.tag, settings), problems


def _unknown(name: str, cause: str | None) -> Complaint:
    former = former_filter(name)
    if former is not None:
        return _about_former(former), former.now
    if cause:
        return f"there is no filter of that name: {cause}", None
    near = nearest(name, [n for f in all_filters() for n in (f.name, f.python_name)], cutoff=SLIP)
    return "there is no filter of that name", near and find_filter(near).name


def same_but_case(name: str) -> str | None:
    """The filter's name that equals `name` apart from capital letters, spaces, underscores and hyphens, or None."""
    plain = plain_name(name)
    return next((f.name for f in all_filters() if plain_name(f.name) == plain), None)


def _about_former(former: Former) -> str:
    if former.idle:
        return "MeshLab has dropped this filter, which changed nothing; leave it out, or let `pymeshfair upgrade` do so"
    if former.now is None:
        advice = "; `pymeshfair upgrade` writes the one that is meant" if former.splits else ""
        return f"there is no such filter today: {former.note}{advice}"
    if former.invented:
        note = f": {former.note}" if former.note else ""
        return f"no MeshLab has had a filter of that name; {former.now!r} is the closest one{note}"
    sets = "".join(f"; give it the parameter {name} with the value {text}" for name, text in former.sets.items())
    return f"MeshLab has renamed this filter to {former.now!r}{sets}; `pymeshfair upgrade` rewrites it"


def _former_parameter_hint(former: Former, name: str) -> tuple[str, str | None]:
    """What became of an old parameter, as the end of a sentence, or ""; and the parameter to write instead, or None."""
    if name in former.renames:
        return f"it is called {former.renames[name]!r} now; `pymeshfair upgrade` rewrites it", former.renames[name]
    if name in former.turns:
        values = " and ".join(sorted({new for case in former.turns[name].values() for new in case}))
        return f"it is replaced by {values} now; `pymeshfair upgrade` rewrites it", None
    if name in {*former.drops, *former.loses}:
        return "MeshLab has dropped it; `pymeshfair upgrade` leaves it out", None
    return "", None


def _add_param(declared: Filter, param: ParamElement, values: dict[str, Any]) -> list[Complaint]:
    name = param.attributes.get("name")
    if name is None:
        return [("<Param> has no name; MeshLab would drop it", None)]
    parameter = next((p for p in declared.parameters if p.xml_name == name), None)
    if parameter is None:
        names = [p.xml_name for p in declared.parameters]
        hint, suggestion = _former_parameter_hint(former_parameters(declared.name), name)
        in_python = next((p.xml_name for p in declared.parameters if p.name == name), None)
        suggestion = suggestion or in_python or (None if hint else nearest(name, names, cutoff=SLIP))
        allowed = f"it has {', '.join(names)}" if names else "it has none"
        return [(f"the filter has no such parameter; {hint or allowed}", suggestion)]
    if parameter.name in values:
        return [("is given twice; MeshLab would take the last", None)]
    values[parameter.name], complaints = read_value(parameter, param.attributes, filter_name=declared.python_name)
    return [*complaints, *_slips("Param", param.attributes, ("relative", "setting"))]


def _setting_problems(document: Document, steps: Sequence[Step]) -> Iterator[Problem]:
    by_name: dict[str, Setting] = {}
    for setting in document.settings:
        if setting.name in by_name:
            yield Problem(file=document.name, line=setting.line, message=f"the setting {setting.name!r} is declared twice")
        by_name.setdefault(setting.name, setting)
    for step in steps:
        for parameter, name in step.settings.items():
            if (message := _disagreement(step, parameter, by_name.get(name), name)) is not None:
                problem = partial(Problem, file=document.name, line=step.line, filter=step.filter.name)
                suggestion = None if name in by_name else nearest(name, by_name)
                yield problem(parameter=step.filter.parameter(parameter).xml_name, message=message, suggestion=suggestion)
    used = {name for step in steps for name in step.settings.values()}
    for setting in by_name.values():
        if setting.name not in used:
            words = f"no step uses the setting {setting.name!r}; write setting={setting.name!r} in a <Param>, or leave it out"
            yield Problem(file=document.name, line=setting.line, message=words)


def _disagreement(step: Step, parameter: str, setting: Setting | None, name: str) -> str | None:
    if setting is None:
        return f"is set by {shortened(name)!r}, and the recipe has no setting of that name"
    try:
        value = parse_value(step.filter.parameter(parameter), setting.default)
    except ParameterError as error:
        return f"cannot take the default {shortened(setting.default)!r} of the setting {name!r}: {error}"
    if value != step.values[parameter]:
        text = shortened(str(step.values[parameter]))
        return f"is {text}, but the default of its setting {name!r} is {shortened(setting.default)}; MeshLab would take {text}"
    return None
