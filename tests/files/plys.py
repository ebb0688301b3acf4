"""PLY files of any types, for tests: made row by row with `struct`, independently of the product's reader and writer."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

CODES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}


@dataclass
class Element:
    """An element: its properties as (type, name), and its rows; a list is typed ``list uchar int``."""

    name: str
    properties: Sequence[tuple[str, str]]
    rows: Sequence[Sequence[Any]]
    positions: set[int] = field(default_factory=set)


def ply_file(elements: Sequence[Element], encoding: str = "binary_little_endian", head: Sequence[str] = ()) -> bytes:
    """The bytes of a PLY file."""
    lines = ["ply", f"format {encoding} 1.0", *head]
    for element in elements:
        lines.append(f"element {element.name} {len(element.rows)}")
        lines += [f"property {type_} {name}" for type_, name in element.properties]
    data = "\n".join([*lines, "end_header", ""]).encode()
    for element in elements:
        for row in element.rows:
            data += _row(element.properties, row, encoding)
    return data


def _row(properties: Sequence[tuple[str, str]], row: Sequence[Any], encoding: str) -> bytes:
    if encoding == "ascii":
        words = []
        for (type_, _), value in zip(properties, row, strict=True):
            words += [str(len(value)), *map(_word, value)] if type_.startswith("list") else [_word(value)]
        return " ".join(words).encode() + b"\n"
    order = "<" if encoding == "binary_little_endian" else ">"
    data = b""
    for (type_, _), value in zip(properties, row, strict=True):
        if type_.startswith("list"):
            _, count, item = type_.split()
            data += struct.pack(f"{order}{CODES[count]}{len(value)}{CODES[item]}", len(value), *value)
        else:
            data += struct.pack(order + CODES[type_], value)
    return data


def _word(value: Any) -> str:
    return repr(value)
