"""The material files of an OBJ file: colours and textures, and the same text with other names of images."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .errors import InputError
from .indices import is_number
from .references import References, shown
from .tokens import joined

#: material files are short; a longer one is something else
MATERIAL_LIMIT = 16 << 20
#: a mesh with a texture for every house of a city has thousands
MOST_MATERIALS = 20_000
#: the count of numbers after each keyword
_NUMBERS = {"Ka": 3, "Kd": 3, "Ks": 3, "d": 1, "Tr": 1, "Ns": 1, "illum": 1}
#: the largest count of words after each option of a map; those of ``-o``, ``-s`` and ``-t`` are numbers and may be fewer
_OPTIONS = {"-blendu": 1, "-blendv": 1, "-boost": 1, "-bm": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-mm": 2, "-texres": 1}
_OPTIONS |= dict.fromkeys(("-o", "-s", "-t"), 3)
_IMAGE = re.compile(r"map_(?!aat\b)\w+|bump|disp|decal|refl|norm", re.IGNORECASE)


@dataclass
class Material:
    """A material: its colour, levels from 0 to 255, and its texture."""

    color: tuple[int, ...] = (255, 255, 255, 255)
    texture: str | None = None


@dataclass
class Materials:
    """The contents of material files."""

    named: dict[str, Material] = field(default_factory=dict)  # the materials by their names
    lines: list[str] = field(default_factory=list)  # those of the files
    #: by line, for those with the name of an image, the words before it and the name
    images: dict[int, tuple[str, str]] = field(default_factory=dict)
    others: dict[str, None] = field(default_factory=dict)  # keywords and options besides a colour and its texture

    @property
    def textures(self) -> list[str]:
        """The textures that they name, each once."""
        return list(dict.fromkeys(m.texture for m in self.named.values() if m.texture))

    def text(self, names: Mapping[str, str]) -> bytes:
        """The files as one, with images under other names."""
        lines = list(self.lines)
        for number, (before, name) in self.images.items():
            if names.get(name, name) != name:
                lines[number] = f"{before} {names[name]}"
        return "".join(f"{line}\n" for line in lines).encode("utf-8", "surrogateescape")

    def read(self, path: Path, mesh: Path) -> None:
        """Add the contents of a material file."""
        with path.open("rb") as file:
            data = file.read(MATERIAL_LIMIT + 1)
        if len(data) > MATERIAL_LIMIT or b"\0" in data:
            what = "is no text" if b"\0" in data else f"has more than {MATERIAL_LIMIT:,} bytes"
            raise InputError(mesh, f"the material file {shown(path.name)} {what}")
        material: Material | None = None
        for line in re.split(r"\r\n|\n|\r", joined(data).decode("utf-8", "surrogateescape").removesuffix("\n")):
            keyword, _, rest = " ".join(re.sub(r"(^|\s)#.*", "", line).split()).partition(" ")
            if keyword == "newmtl":
                material = self.named.setdefault(rest, Material())
                if len(self.named) > MOST_MATERIALS:
                    raise InputError(mesh, f"the material file {shown(path.name)} has more than {MOST_MATERIALS:,} materials")
            elif keyword:
                self._take(material, keyword, rest)
            self.lines.append(line)

    def _take(self, material: Material | None, keyword: str, rest: str) -> None:
        numbers = rest.split()[: _NUMBERS.get(keyword, 0)]
        if _IMAGE.fullmatch(keyword):
            options, name = _parted(rest)
            if name:
                self.images[len(self.lines)] = (" ".join((keyword, *options)), name)
            if material is None or keyword.lower() != "map_kd":
                self.others[keyword] = None
                return
            material.texture = name
            if options:
                self.others[f"{keyword} {' '.join(options)}"] = None
        elif material is None or keyword not in _NUMBERS or len(numbers) < _NUMBERS[keyword] or not all(map(is_number, numbers)):
            self.others[keyword] = None
        elif keyword == "Kd":
            shares = np.nan_to_num(np.clip(np.array(numbers, np.float32), 0, 1)).astype(np.float64)
            material.color = (*(255.0 * shares).astype(np.uint8).tolist(), 255)  # not rounded, as in MeshLab
        elif keyword == "d" and float(numbers[0]) < 1.0:
            self.others[f"d {numbers[0]}"] = None


def find_material_files(names: Sequence[str], references: References) -> tuple[list[Path], list[str]]:
    """The files that ``mtllib`` lines mean, a name with blanks or several on a line, and the names that mean none."""
    paths: dict[Path, None] = {}
    missing = []
    for name in names:
        whole = references.find(name)
        each = [whole] if whole else [references.find(part) for part in name.split()]
        if each and all(each):
            paths |= dict.fromkeys(path for path in each if path)
        else:
            missing.append(name)
    return list(paths), missing


def _parted(rest: str) -> tuple[list[str], str | None]:
    """The options of a map and the name of its file, which may have blanks."""
    words = rest.split(" ")
    options: list[str] = []
    while words and words[0] in _OPTIONS:
        most, numeric = _OPTIONS[words[0]], words[0] in ("-o", "-s", "-t")
        options.append(words.pop(0))
        while most and words and (not numeric or is_number(words[0])) and len(words) > 1:
            options.append(words.pop(0))
            most -= 1
    return options, " ".join(words).strip('" ') or None
