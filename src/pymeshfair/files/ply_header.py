"""The header of a PLY file: read, checked against the size of the file, and written with other counts and types."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .errors import ContentsError

#: numpy's names of the types
KINDS: Mapping[str, str] = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4"},
    "float64": "f8",
}
#: the bytes of a value of each type, under both of its names
SIZES: Mapping[str, int] = {name: int(kind[1]) for name, kind in KINDS.items()}
_PLAIN_NAMES = {"uint8": "uchar", "int32": "int", "uint32": "uint", "float32": "float", "float64": "double"}
FORMATS = ("ascii", "binary_little_endian", "binary_big_endian")
#: bytes; longer than any header that a program writes, so that a hostile file cannot fill the memory
HEADER_LIMIT = 1 << 26
#: the most elements and properties of a header
MOST_DECLARED = 1_000
_END = re.compile(rb"[\r\n]end_header(\r\n|\n|\r)")


@dataclass(frozen=True)
class PlyProperty:
    """One property of an element; `count_type` is the type of a list's length, None if it is no list."""

    name: str
    type: str
    count_type: str | None = None

    def __str__(self) -> str:
        return f"{'' if self.count_type is None else 'list '}{self.type} {self.name}"


@dataclass(frozen=True)
class PlyElement:
    """One kind of element, such as ``vertex``, and how many of it are declared."""

    name: str
    count: int
    properties: tuple[PlyProperty, ...] = ()

    @property
    def smallest_row(self) -> int:
        """The fewest bytes that one element takes in a binary file; lists may be empty."""
        return sum(SIZES[p.count_type or p.type] for p in self.properties)


@dataclass(frozen=True)
class PlyHeader:
    """A PLY header."""

    format: str  # one of `FORMATS`
    elements: tuple[PlyElement, ...]  # in the order of the file
    comments: tuple[str, ...]  # the words after ``comment`` and ``obj_info``
    size: int  # its length in bytes, including the end of its last line
    text: bytes  # its bytes

    @property
    def byte_order(self) -> str:
        """Of a binary file: ``"<"`` for little-endian, ``">"`` for big-endian."""
        return ">" if self.format == "binary_big_endian" else "<"

    def element(self, name: str) -> PlyElement:
        """The element of that name; one with a count of 0 if the file does not declare it."""
        return next((e for e in self.elements if e.name == name), PlyElement(name, 0))

    @property
    def textures(self) -> tuple[str, ...]:
        """The texture files that it names, as written there."""
        words = (comment.split(maxsplit=1) for comment in self.comments)
        return tuple(w[1].strip() for w in words if len(w) == 2 and w[0].lower() == "texturefile")


def read_header(path: Path) -> PlyHeader:
    """The header of a PLY file, its names checked, and its counts against the size of the file."""
    with path.open("rb") as file:
        data = file.read(1 << 16)
        if _END.search(data) is None:
            data += file.read(HEADER_LIMIT)
        file_size = file.seek(0, 2)
    header = parse_header(data)
    _check_size(header, file_size)
    if len({element.name for element in header.elements}) != len(header.elements):
        raise ContentsError("it declares an element twice")
    for element in header.elements:
        if len({p.name for p in element.properties}) != len(element.properties):
            raise ContentsError(f"its element {element.name!r} has a property twice")
    return header


def parse_header(data: bytes) -> PlyHeader:
    """The header that these bytes begin with."""
    if not data.startswith(b"ply"):
        raise ContentsError("it does not begin with 'ply'")
    end = _END.search(data)
    if end is None:
        raise ContentsError(f"its header has no end within {min(len(data), HEADER_LIMIT):,} bytes")
    # A carriage return alone ends the lines of files from old Macs.
    lines = data[: end.start()].decode("utf-8", "surrogateescape").replace("\r\n", "\n").replace("\r", "\n").split("\n")[1:]
    format_, comments, elements = "", [], []
    if sum(line.lstrip().startswith(("property", "element")) for line in lines) > MOST_DECLARED:
        raise ContentsError(f"its header declares more than {MOST_DECLARED:,} elements and properties")
    for number, line in enumerate(lines, 2):
        match line.split():
            case ["format", word, "1.0"] if word in FORMATS and not format_:
                format_ = word
            case ["comment" | "obj_info" as keyword, *_]:
                comments.append(line.strip()[len(keyword) :].strip())
            case ["element", name, count] if count.isascii() and count.isdigit():
                elements.append(PlyElement(name, int(count)))
            case ["property", "list", count_type, type_, name] if elements and count_type in SIZES and type_ in SIZES:
                elements.append(_extended(elements.pop(), PlyProperty(name, _plain(type_), _plain(count_type))))
            case ["property", type_, name] if elements and type_ in SIZES:
                elements.append(_extended(elements.pop(), PlyProperty(name, _plain(type_))))
            case []:
                pass
            case _:
                raise ContentsError(f"line {number} of its header is {line.strip()[:80]!r}")
    if not format_:
        raise ContentsError("its header names no format (ascii, binary_little_endian or binary_big_endian)")
    return PlyHeader(format_, tuple(elements), tuple(comments), end.end(), data[: end.end()])


def _extended(element: PlyElement, new: PlyProperty) -> PlyElement:
    return PlyElement(element.name, element.count, (*element.properties, new))


def _plain(type_: str) -> str:
    return _PLAIN_NAMES.get(type_, type_)


def _check_size(header: PlyHeader, file_size: int) -> None:
    """Refuse counts that the rest of the file cannot hold: a value in a text takes at least a digit and a separator."""
    left = file_size - header.size
    for element in header.elements:
        if element.count and not element.properties:
            raise ContentsError(f"its header declares {element.count:,} of {element.name[:40]!r}, which have no properties")
        row = 2 * len(element.properties) if header.format == "ascii" else element.smallest_row
        needed = element.count * row - (header.format == "ascii")
        if needed > left:
            raise ContentsError(
                f"its header declares {element.count:,} of {element.name!r}, which take at least {needed:,} bytes, "
                f"but only {max(left, 0):,} follow"
            )
        left -= needed


def header_bytes(header: PlyHeader, elements: Sequence[PlyElement], textures: Mapping[str, str] | None = None) -> bytes:
    """The header with these elements and the new names of textures by their old ones; all other lines as they were."""
    missing = {e.name: e for e in elements}
    left: dict[str, PlyProperty] = {}  # properties of the element that are not declared yet
    is_kept, end = True, "\n"
    lines: list[str] = []
    for raw in header.text.splitlines(keepends=True):
        new: str | None = raw.rstrip(b"\r\n").decode("utf-8", "surrogateescape")
        words, end = str(new).split(), raw[len(raw.rstrip(b"\r\n")) :].decode()
        if words[:1] in (["element"], ["end_header"]):
            lines += [_declaration(p) + end for p in left.values()]
            left, is_kept = {}, True
        match words:
            case ["end_header"]:
                break
            case ["element", name, count]:
                element = missing.pop(name, None)
                is_kept = element is not None
                if element is not None:
                    left = {p.name: p for p in element.properties}
                    new = new if int(count) == element.count else f"element {name} {element.count}"
            case ["property", *types, name] if is_kept:
                p = left.pop(name, None)
                same = p is not None and _declaration(p).split() == ["property", *map(_plain, types), name]
                new = new if same else None if p is None else _declaration(p)
            case ["comment", word, _, *_] if word.lower() == "texturefile" and textures:
                name = str(new).split(maxsplit=2)[2].strip()
                new = f"comment {word} {textures[name]}" if textures.get(name, name) != name else new
        if is_kept and new is not None:
            lines.append(new + end)
    for element in missing.values():
        lines += [f"element {element.name} {element.count}{end}", *(_declaration(p) + end for p in element.properties)]
    return "".join((*lines, "end_header", end)).encode("utf-8", "surrogateescape")


def _declaration(p: PlyProperty) -> str:
    return f"property {p.type} {p.name}" if p.count_type is None else f"property list {p.count_type} {p.type} {p.name}"
