"""Reads the text of an OBJ file strictly, to its last word, before MeshLab does.

MeshLab takes ``f 1.7 2 3`` for ``f 1 2 3``, passes over faces whose indices name no vertex and lines whose keyword it does not
know, counts lines in one way and reads them in another, and sees one line in a file with the line ends of old Macs.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .obj_faces import Corners, corners_of
from .obj_values import ObjError, check_rows, fail, is_misspaced, normal_notes, texture_coordinate_notes
from .tokens import Tokens, joined, plain, tokenise, word

#: what the lines of the format's own keywords are
KEYWORDS = {
    **{"v": "vertices", "vt": "texture coordinates", "vn": "normals", "f": "faces", "l": "polylines", "p": "point elements"},
    **{"g": "groups", "o": "objects", "s": "smoothing groups", "mg": "smoothing groups"},
    **{"usemtl": "uses of materials", "mtllib": "material files", "usemap": "uses of maps", "maplib": "map files"},
    **dict.fromkeys(("vp", "param"), "parameter space vertices"),
    **dict.fromkeys(
        ("curv", "curv2", "cstype", "deg", "bmat", "step", "parm", "trim", "hole", "scrv", "sp", "end", "con"), "curves"
    ),
    **dict.fromkeys(("surf", "ctech", "stech", "cdc", "cdp", "bzp", "bsp", "res"), "surfaces"),
    **dict.fromkeys(("bevel", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj", "call", "csh"), "display attributes"),
}
_CODES = {int(word(k.encode())): what for k, what in KEYWORDS.items() if len(k) <= 8}
#: of how many numbers a vertex is made: its place, with a weight, with a colour, with a colour and its opacity
_VERTEX = (3, 4, 6, 7)
#: corners of the largest face; MeshLab's time grows with their square
LARGEST_FACE = 10_000


@dataclass
class ObjContents:
    """What is in an OBJ file.

    Attributes:
        counts: lines by what they are; see `KEYWORDS`.
        points: (n, 3) the vertices.
        material_files: what the ``mtllib`` lines name, as written there.
        triangles: how many triangles the polygons make, a polygon of k corners k - 2.
        bare_faces: faces without texture coordinates among others with them.
        partly_bare_faces: faces with texture coordinates at some corners alone.
        edges: how many edges the polylines have.
        notes: what MeshLab does not read of it, in words.
        text: what it says, in a form that MeshLab's reader understands alike.
        altered: whether that is not the file itself.
        corners: the (m, 3) indices of its faces in pieces, from 0; None if some are no triangles of vertices alone.
        colours: (n, k) what its vertices have besides places, in pieces.
        levels: whether its colours are whole numbers up to 255.
        exact: whether all numbers are right to the last bit.
        changes: lines of `text`, by their number from 1, that must be others for MeshLab.
    """

    counts: Counter[str] = field(default_factory=Counter)
    points: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    material_files: list[str] = field(default_factory=list)
    triangles: int = 0
    bare_faces: int = 0
    partly_bare_faces: int = 0
    edges: int = 0
    notes: list[str] = field(default_factory=list)
    text: bytes = b""
    altered: bool = False
    corners: list[NDArray[np.int64]] | None = field(default_factory=list)
    colours: list[NDArray[np.float64]] = field(default_factory=list)
    levels: bool = False
    exact: bool = True
    changes: dict[int, bytes] = field(default_factory=dict)


def read_obj(path: Path) -> ObjContents:
    """Read an OBJ file.

    Raises:
        ObjError: it is none, or says what cannot be.
        OSError: it cannot be read.
    """
    data = path.read_bytes()
    if b"\0" in data[:4096]:
        raise ObjError("it is no text")
    text = joined(data)
    pieces = list(tokenise(text, slashes=True))
    if any(piece.oddities for piece in pieces) or is_misspaced(pieces):
        text = plain(text)
        pieces = list(tokenise(text, slashes=True))
    contents = ObjContents(text=text, altered=text is not data, exact=all(piece.exact for piece in pieces))
    points: list[NDArray[np.float64]] = []
    width: list[int] = []
    before = Counter[str]()
    for piece in pieces:
        _count(piece, contents)
    for piece in pieces:
        points.append(_vertices(piece, width, contents))
        for note in (*texture_coordinate_notes(piece), *normal_notes(piece)):
            _note(contents, note)
        _faces(piece, before, contents)
        _polylines(piece, before, contents)
        for what in ("v", "vt", "vn"):
            before[what] += int((piece.keywords == word(what.encode())).sum())
    contents.points = np.concatenate(points) if points else contents.points
    _check_colours(contents, *width[:1] or (0,))
    return contents


def _count(piece: Tokens, contents: ObjContents) -> None:
    for code, number in zip(*(a.tolist() for a in np.unique(piece.keywords, return_counts=True)), strict=True):
        what = _CODES.get(code)
        if what is not None:
            contents.counts[what] += number
            continue
        for k in np.flatnonzero(piece.keywords == np.uint64(code)).tolist():
            what = KEYWORDS.get(re.split(rb"[ \t/]", piece.line(k).lstrip(b" \t"))[0].decode("latin-1"))
            if what is None:
                raise fail(piece, k, "begins with no keyword of the format")
            contents.counts[what] += 1
    for k in np.flatnonzero(piece.keywords == word(b"mtllib")).tolist():
        contents.material_files.append(piece.line(k)[6:].strip().decode("utf-8", "surrogateescape"))


def _vertices(piece: Tokens, width: list[int], contents: ObjContents) -> NDArray[np.float64]:
    lines, counts = check_rows(piece, "v", _VERTEX)
    if len(lines) == 0:
        return np.empty((0, 3))
    width[:] = width or [int(counts[0])]
    if (counts != width[0]).any():
        k = int(np.argmax(counts != width[0]))
        raise fail(piece, int(lines[k]), f"has {counts[k]} values, while the vertices before it have {width[0]}")
    first = piece.first[lines]
    if width[0] == 4 and (piece.values[first + 4] != 1).any():
        _note(contents, "weights of vertices")
    contents.colours.append(piece.values[first[:, None] + np.arange(4, width[0] + 1)])
    places: NDArray[np.float64] = piece.values[first[:, None] + np.arange(1, 4)]
    return places


def _note(contents: ObjContents, text: str) -> None:
    if text not in contents.notes:
        contents.notes.append(text)


def _check_colours(contents: ObjContents, width: int) -> None:
    """Refuse colours that are neither shares from 0 to 1 nor levels of 255: MeshLab takes what is above 1 for either."""
    if width < 6 or not contents.colours:
        return
    colours = np.concatenate(contents.colours)
    if (strange := ~((colours >= 0) & (colours <= 1)).all(axis=1)).any():
        contents.levels = width == 6 and bool(((colours >= 0) & (colours <= 255) & (colours == np.rint(colours))).all())
        if not contents.levels:
            raise ObjError(f"the colour of its vertex {int(np.argmax(strange)) + 1:,} is not from 0.0 to 1.0")


def _faces(piece: Tokens, before: Counter[str], contents: ObjContents) -> None:
    corners = corners_of(piece, "f")
    if len(corners.lines) == 0:
        return
    _check_corners(piece, corners, "face", 3)
    relative = _check_indices(piece, corners, before, contents)
    contents.triangles += int((corners.counts - 2).sum())
    if contents.corners is not None and (corners.counts == 3).all() and len(corners.slots) == len(corners.lines) * 3:
        contents.corners.append(corners.values.astype(np.int64).reshape(-1, 3) - 1)
    else:
        contents.corners = None
    contents.bare_faces += int((corners.texture_counts == 0).sum())
    contents.partly_bare_faces += int(((corners.texture_counts > 0) & (corners.texture_counts < corners.counts)).sum())
    if relative:
        contents.changes |= corners.absolute(piece)


def _polylines(piece: Tokens, before: Counter[str], contents: ObjContents) -> None:
    corners = corners_of(piece, "l")
    if len(corners.lines) == 0:
        return
    _check_corners(piece, corners, "polyline", 2)
    relative = _check_indices(piece, corners, before)
    contents.edges += int((corners.counts - 1).sum())
    if relative or (corners.counts != 2).any():
        contents.changes |= corners.single_edges(piece)


def _check_corners(piece: Tokens, corners: Corners, what: str, least: int) -> None:
    if corners.strange >= 0:
        raise fail(piece, corners.strange, "has something else than whole numbers, joined by slashes")
    for wrong, why in (
        (corners.counts < least, f"is a {what} of fewer than {least} vertices"),
        (corners.counts > LARGEST_FACE, f"is a {what} of more than {LARGEST_FACE:,} vertices"),
    ):
        if wrong.any():
            raise fail(piece, int(corners.lines[np.argmax(wrong)]), why)


def _check_indices(piece: Tokens, corners: Corners, before: Counter[str], contents: ObjContents | None = None) -> bool:
    """Refuse indices that name nothing read so far, and count negative ones from there; whether there were any.

    Without `contents` only those of vertices are looked at, as MeshLab does with polylines.
    """
    relative = False
    for keyword, slot, what in (("v", 0, "vertex"), ("vt", 1, "texture coordinate"), ("vn", 2, "normal")):
        chosen = corners.slots == slot
        values, lines = corners.values[chosen], corners.line_of[chosen]
        if len(values) == 0 or (slot and contents is None):
            continue
        if slot and contents is not None and not contents.counts[KEYWORDS[keyword]]:
            _note(contents, f"that its faces name {KEYWORDS[keyword]}, of which it has none")
            continue
        so_far = before[keyword] + np.cumsum(piece.keywords == word(keyword.encode()))[lines]
        negative = values < 0
        if negative.any():
            relative = True
            values = np.where(negative, values + so_far + 1, values)
            corners.values[chosen] = values
        wrong = ~((values >= 1) & (values <= so_far))
        if wrong.any():
            raise fail(piece, int(lines[np.argmax(wrong)]), f"names a {what} that is none of those before it")
    return relative
