"""Polylines of OBJ files: of ``l 1 2 3`` MeshLab reads the first edge alone, and of ``l -2 -1`` one between no vertices."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from pathlib import Path

from ..errors import PymeshfairError
from .obj import whole_lines

# A backslash at its end continues a line.
_LINE = re.compile(rb"\nl[ \t]+((?:\\\r?\n|[^\r\n])+)")
_CONTINUED = re.compile(rb"\\\r?\n")
_VERTEX = re.compile(rb"\nv[ \t]")


class PolylineError(PymeshfairError, ValueError):
    """A polyline names no vertex of the file; the message gives it."""


@dataclass(frozen=True)
class Polylines:
    """The polylines of a file.

    Attributes:
        edges: how many edges they have.
        misread: of how many of them MeshLab would read other edges.
    """

    edges: int
    misread: int


def scan_polylines(path: Path, n_vertices: int) -> Polylines:
    """Check the polylines of a file that has so many vertices.

    Raises:
        PolylineError: one of them names a vertex that is not there; MeshLab would read past the end of its array.
    """
    edges = misread = before = 0
    for chunk in whole_lines(path):
        at = 0
        for match in _LINE.finditer(chunk):
            before += len(_VERTEX.findall(chunk, at, match.start()))
            at = match.start()
            named = _vertices(match[1], before, n_vertices)
            edges += len(named) - 1
            misread += len(named) != 2 or b"-" in match[1]
        before += len(_VERTEX.findall(chunk, at))
    return Polylines(edges, misread)


def write_single_edges(source: Path, target: Path, n_vertices: int) -> None:
    """Write a copy of a file that has each edge in a line of its own and names no material file.

    Raises:
        PolylineError: see `scan_polylines`.
    """
    before = 0
    with target.open("xb") as file:
        for chunk in whole_lines(source):
            at = 0
            for match in _LINE.finditer(chunk):
                before += len(_VERTEX.findall(chunk, at, match.start()))
                file.write(_without_materials(chunk[at : match.start()]))
                named = _vertices(match[1], before, n_vertices)
                file.write(b"".join(b"\nl %d %d" % pair for pair in itertools.pairwise(named)))
                at = match.end()
            before += len(_VERTEX.findall(chunk, at))
            file.write(_without_materials(chunk[at:]))


def _without_materials(lines: bytes) -> bytes:
    return re.sub(rb"\n(mtllib|usemtl)[^\r\n]*", b"", lines)


def _vertices(words: bytes, before: int, n_vertices: int) -> list[int]:
    """The vertices of a line, counted from 1; negative ones count back from the last vertex before it."""
    named = []
    words = _CONTINUED.sub(b" ", words)
    for word in words.split(b"#")[0].split():
        try:
            number = int(word.split(b"/")[0])
        except ValueError:
            number = 0
        number += before + 1 if number < 0 else 0
        if not 1 <= number <= n_vertices:
            shown = words.decode("ascii", "replace").strip()[:60]
            raise PolylineError(f"its polyline 'l {shown}' names a vertex that is not one of its {n_vertices:,}")
        named.append(number)
    return named
