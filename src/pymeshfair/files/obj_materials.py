"""Reads the material files of an OBJ file, and writes one that MeshLab understands alike.

MeshLab takes the rest of a line with options for the name of a texture, forgets the first of two material files, and passes over
whatever else it does not know.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .errors import InputError
from .references import References, Texture, shown
from .tokens import joined, plain

#: material files are short; a longer one is something else
MATERIAL_LIMIT = 16 << 20
#: a mesh with a texture for every house of a city has thousands
MOST_MATERIALS = 20_000
#: how many numbers follow what MeshLab reads
_NUMBERS = {"Ka": 3, "Kd": 3, "Ks": 3, "d": 1, "Tr": 1, "Ns": 1, "illum": 1}
#: how many words follow each option of a map, at most; those of ``-o``, ``-s`` and ``-t`` are numbers and may be fewer
_OPTIONS = {"-blendu": 1, "-blendv": 1, "-boost": 1, "-bm": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-mm": 2, "-texres": 1}
_OPTIONS |= dict.fromkeys(("-o", "-s", "-t"), 3)


@dataclass
class Material:
    """One material: its name, the lines that MeshLab reads, and the texture that it names."""

    name: str
    lines: list[str] = field(default_factory=list)
    texture: str | None = None


@dataclass
class Materials:
    """What is in material files: the materials, and the words that MeshLab ignores."""

    materials: list[Material] = field(default_factory=list)
    ignored: dict[str, None] = field(default_factory=dict)

    @property
    def textures(self) -> list[str]:
        """The textures that they name, each once."""
        return list(dict.fromkeys(m.texture for m in self.materials if m.texture))


def find_material_files(names: Sequence[str], references: References) -> tuple[list[Path], list[str]]:
    """The files that ``mtllib`` lines mean, a name with blanks or several on a line, and the names that mean none.

    Raises:
        InputError: one of them must not be opened.
    """
    found: dict[Path, None] = {}
    missing = []
    for name in names:
        whole = references.find(name)
        each = [whole] if whole else [references.find(part) for part in name.split()]
        if each and all(each):
            found |= dict.fromkeys(path for path in each if path)
        else:
            missing.append(name)
    return list(found), missing


def read_materials(path: Path, mesh: Path) -> Materials:
    """Read a material file.

    Raises:
        InputError: it is too long, or no text.
    """
    with path.open("rb") as file:
        data = file.read(MATERIAL_LIMIT + 1)
    if len(data) > MATERIAL_LIMIT or b"\0" in data:
        what = "is no text" if b"\0" in data else f"has more than {MATERIAL_LIMIT:,} bytes"
        raise InputError(mesh, f"the material file {shown(path.name)} {what}")
    materials = Materials()
    for line in plain(joined(data)).decode("utf-8", "surrogateescape").split("\n"):
        keyword, _, rest = line.strip().partition(" ")
        if not keyword:
            continue
        if keyword == "newmtl":
            if len(materials.materials) == MOST_MATERIALS:
                raise InputError(mesh, f"the material file {shown(path.name)} has more than {MOST_MATERIALS:,} materials")
            materials.materials.append(Material(rest))
        elif not materials.materials or not _read(materials.materials[-1], keyword, rest, materials):
            materials.ignored[keyword] = None
    return materials


def _read(material: Material, keyword: str, rest: str, materials: Materials) -> bool:
    """Take a line of a material; whether MeshLab reads such lines."""
    if keyword == "map_Kd":
        options, material.texture = _parted(rest)
        if options:
            materials.ignored[f"{keyword} {' '.join(options)}"] = None
        return True
    words = rest.split()[: _NUMBERS.get(keyword, 0)]
    if keyword not in _NUMBERS or len(words) < _NUMBERS[keyword] or not all(map(_is_number, words)):
        return False
    material.lines.append(f"{keyword} {' '.join(words)}")
    return True


def _parted(rest: str) -> tuple[list[str], str | None]:
    """The options of a map and the name of its file, which may have blanks."""
    words = rest.split(" ")
    options: list[str] = []
    while words and words[0] in _OPTIONS:
        most, numeric = _OPTIONS[words[0]], words[0] in ("-o", "-s", "-t")
        options.append(words.pop(0))
        while most and words and (not numeric or _is_number(words[0])) and len(words) > 1:
            options.append(words.pop(0))
            most -= 1
    return options, " ".join(words).strip('" ') or None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def format_materials(materials: Sequence[Material], named: Callable[[str], Texture]) -> bytes:
    """The materials as one file, with each texture under the name that it is given to MeshLab by."""
    lines = []
    for material in materials:
        lines += [f"newmtl {material.name}", *material.lines]
        if material.texture:
            lines.append(f"map_Kd {named(material.texture).given}")
    return "\n".join([*lines, ""]).encode("utf-8", "surrogateescape")
