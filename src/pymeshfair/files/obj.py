"""Scans an OBJ file and its material files before MeshLab opens them.

MeshLab opens whatever ``mtllib`` names, a device or a pipe included, and drops groups, maps and whatever else it does not know
without a word.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

#: bytes; a longer file is no material file
MATERIAL_LIMIT = 16 << 20
_CHUNK = 16 << 20
#: the first two bytes of a line that begins with a keyword of interest, and what it counts as
_KEYWORDS = {
    **dict.fromkeys((b"v ", b"v\t"), "vertices"),
    **dict.fromkeys((b"f ", b"f\t", b"q "), "faces"),
    b"vt": "texture coordinates",
    b"vn": "normals",
    **dict.fromkeys((b"g ", b"g\t"), "groups"),
    **dict.fromkeys((b"o ", b"o\t"), "objects"),
    **dict.fromkeys((b"s ", b"s\t"), "smoothing groups"),
    **dict.fromkeys((b"p ", b"p\t"), "point elements"),
    **dict.fromkeys((b"l ", b"l\t"), "polylines"),
    b"us": "uses of materials",
    b"vp": "parameter space vertices",
    b"cu": "curves",
    b"su": "surfaces",
}


@dataclass(frozen=True)
class ObjContents:
    """What is in an OBJ file.

    Attributes:
        counts: lines by what they are; see `_KEYWORDS`.
        material_files: what the ``mtllib`` lines name, as written there.
    """

    counts: Counter[str]
    material_files: tuple[str, ...]


def scan_obj(path: Path) -> ObjContents:
    """Count the lines of an OBJ file by their keywords."""
    counts: Counter[str] = Counter()
    material_files: dict[str, None] = {}
    for chunk in whole_lines(path):
        data = np.frombuffer(chunk, dtype=np.uint8)
        starts = np.flatnonzero(data[:-2] == ord("\n")) + 1
        pairs, numbers = np.unique(data[starts].astype(np.uint16) << 8 | data[starts + 1], return_counts=True)
        for pair, number in zip(pairs.tolist(), numbers.tolist(), strict=True):
            if what := _KEYWORDS.get(pair.to_bytes(2, "big")):
                counts[what] += number
        for match in re.finditer(rb"\nmtllib[ \t]+([^\r\n]+)", chunk):
            material_files[match[1].decode("utf-8", "surrogateescape").strip()] = None
    return ObjContents(counts, tuple(material_files))


def count_triangles(path: Path) -> int:
    """How many triangles the polygons of a file make, a polygon of k corners k - 2."""
    return sum(
        max(len(match[1].split()) - 2, 0) for chunk in whole_lines(path) for match in re.finditer(rb"\nf[ \t]+([^\r\n]+)", chunk)
    )


def whole_lines(path: Path) -> Iterator[bytes]:
    """The file in pieces of whole lines, each with a line feed before and after; a continued line stays whole."""
    rest = b"\n"
    with path.open("rb") as file:
        while block := file.read(_CHUNK):
            whole, feed, tail = (rest + block).rpartition(b"\n")
            while whole.endswith((b"\\", b"\\\r")):
                whole, feed, before = whole.rpartition(b"\n")
                tail = before + b"\n" + tail
            if not whole:
                rest += block
                continue
            yield whole + feed
            rest = b"\n" + tail
    yield rest + b"\n"


def material_paths(path: Path, contents: ObjContents) -> list[Path]:
    """The material files that MeshLab will open for an OBJ file, existing or not."""
    if contents.material_files:
        return [path.parent / name for name in contents.material_files]
    return [path.with_suffix(".mtl")] if contents.counts["uses of materials"] else []


@dataclass(frozen=True)
class Materials:
    """What is in a material file: the textures that MeshLab reads, and the keywords that it ignores."""

    textures: tuple[str, ...]
    ignored: tuple[str, ...]


_READ_KEYWORDS = {"newmtl", "ka", "kd", "ks", "d", "tr", "ns", "illum"}


def read_materials(path: Path) -> Materials:
    """Read a material file as MeshLab does: a texture is the only word after ``map_Kd``."""
    textures: dict[str, None] = {}
    ignored: dict[str, None] = {}
    with path.open("rb") as file:
        text = file.read(MATERIAL_LIMIT).decode("utf-8", "surrogateescape")
    for line in text.splitlines():
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0] == "map_Kd" and len(words) == 2:
            textures[words[1]] = None
        elif words[0].lower() not in _READ_KEYWORDS:
            ignored[" ".join(words) if words[0] == "map_Kd" else words[0]] = None
    return Materials(tuple(textures), tuple(ignored))
