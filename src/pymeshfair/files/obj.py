"""Reads OBJ files with their materials, and checks every line; writes them with materials, groups and objects.

If a mesh needs the same lines as its file has, the text of the file is written with new numbers, otherwise a new text.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..filters.geometry import unit_vectors, vertex_normals_by_angle
from ..filters.mesh import Floats, Ints, Longs, mask_of
from ..mesh_data import MeshData, Source, Texture
from ..mesh_data.mesh_data import source_ids
from .errors import ContentsError, InputError
from .inputs import Reading, References, quoted, unended
from .outputs import Writing
from .polygons import LARGEST_FACE, are_equal, edges_of, numbered, outlines, triangulated
from .tokens import (
    AFTER_SLASH,
    EMPTY,
    INTEGER,
    Tokens,
    changed_words,
    is_number,
    joined,
    numbers_of,
    patched,
    refuse,
    rows,
    runs,
    tokenise,
    word,
)

#: the keywords of the format, by the contents of their lines
_LINES = {
    **{"vertices": "v", "texture coordinates": "vt", "normals": "vn", "faces": "f", "polylines": "l", "point elements": "p"},
    **{"groups": "g", "objects": "o", "smoothing groups": "s mg", "uses of materials": "usemtl", "material files": "mtllib"},
    **{"uses of maps": "usemap", "map files": "maplib", "parameter space vertices": "vp param"},
    "curves": "curv curv2 cstype deg bmat step parm trim hole scrv sp end con",
    "surfaces": "surf ctech stech cdc cdp bzp bsp res",
    "display attributes": "bevel c_interp d_interp lod shadow_obj trace_obj call csh",
}
_KEYWORDS = {keyword: what for what, words in _LINES.items() for keyword in words.split()}
_CODES = {int(word(k.encode())): what for k, what in _KEYWORDS.items() if len(k) <= 8}
STATES = (b"o", b"g", b"s", b"mg", b"usemtl")  # keywords of state lines, which apply to all faces after them
#: for each keyword in `STATES`, the line that ends its state; empty if the format has no such line
_ENDS = (b"", b"g default\n", b"s off\n", b"mg off\n", b"")
#: contents that a new text keeps (`_STATES`), and those that it leaves out: lines (`_OTHERS`), parts of lines (`_UNWRITTEN`)
_STATES = ("groups", "objects", "smoothing groups")
_OTHERS: tuple[str, ...] = ("comments", "point elements", "parameter space vertices", "curves", "surfaces")
_OTHERS += ("uses of maps", "map files", "display attributes")
_UNWRITTEN = ("third texture coordinates", "weights of vertices")
#: a comment that has more than number signs and blanks, except "#MRGB", the colours of ZBrush
_COMMENT = re.compile(rb"(?<!\S)#(?!MRGB )[#\t ]*[^#\s][^\r\n]*")
_OF_FACES = ("wedge_texture_coordinates", "texture", "colors", "polygon")  # the face attributes that an OBJ file holds
_VERTEX = (3, 4, 6, 7)  # how many numbers a vertex may have: a position, then nothing, a weight, a colour, or colour and opacity
_GREY = (192, 192, 192, 255)  # the colour that faces without a material have in MeshLab
_LEVELS = "the colours of its vertices go above 1: they are read as levels from 0 to 255, not as shares from 0.0 to 1.0"
#: the most bytes of a material file, and the most materials of a mesh; a city with a texture for each house has thousands
MATERIAL_LIMIT, MOST_MATERIALS = 16 << 20, 20_000
_NUMBERS = {"Ka": 3, "Kd": 3, "Ks": 3, "d": 1, "Tr": 1, "Ns": 1, "illum": 1}  # how many numbers follow a keyword of a material
#: the options of a texture map, with values; the name of its file follows them
_OPTIONS = re.compile(r"(?:-(?:(?:blendu|blendv|boost|bm|cc|clamp|imfchan|texres) \S+|mm \S+ \S+|[ost](?: [-+.\deE]+){0,3}) )*")
#: the share level / 255 of each colour level, rounded up at the sixth decimal: 255 x share, rounded or truncated, is the level
_SHARES = np.ceil(np.arange(256) / 255 * 1e6) / 1e6
_IMAGE = re.compile(r"map_(?!aat\b)\w+|bump|disp|decal|refl|norm", re.IGNORECASE)


@dataclass
class Material:
    """A material: its colour, as levels from 0 to 255, and its texture."""

    color: tuple[int, ...] = (255, 255, 255, 255)
    texture: str | None = None


@dataclass
class Materials:
    """The contents of all material files of a mesh."""

    named: dict[str, Material] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)  # of the files
    #: for each line with an image, by its index in `lines`: the words before the name of the image, and this name
    images: dict[int, tuple[str, str]] = field(default_factory=dict)
    others: dict[str, None] = field(default_factory=dict)  # keywords and options that are not read

    @property
    def textures(self) -> list[str]:
        return list(dict.fromkeys(m.texture for m in self.named.values() if m.texture))

    def text(self, names: Mapping[str, str]) -> bytes:
        """The files joined into one, with images renamed by `names`, and without textures that have no name there."""
        lines, gone = list(self.lines), set(self.textures) - names.keys()
        for number, (before, name) in self.images.items():
            if name in gone or names.get(name, name) != name:
                lines[number] = "" if name in gone else f"{before} {names[name]}"
        return "".join(f"{line}\n" for line in lines).encode("utf-8", "surrogateescape")

    def read(self, path: Path, mesh: Path) -> None:
        with path.open("rb") as file:
            data = file.read(MATERIAL_LIMIT + 1)
        if len(data) > MATERIAL_LIMIT or b"\0" in data:
            what = "is no text" if b"\0" in data else f"has more than {MATERIAL_LIMIT:,} bytes"
            raise InputError(mesh, f"the material file {quoted(path.name)} {what}")
        material: Material | None = None
        for line in re.split(r"\r\n|\n|\r", joined(data).decode("utf-8", "surrogateescape").removesuffix("\n")):
            keyword, _, rest = " ".join(re.sub(r"(^|\s)#.*", "", line).split()).partition(" ")
            if keyword == "newmtl":
                material = self.named.setdefault(rest, Material())
                if len(self.named) > MOST_MATERIALS:
                    raise InputError(mesh, f"the material file {quoted(path.name)} has more than {MOST_MATERIALS:,} materials")
            elif keyword:
                self._take(material, keyword, rest)
            self.lines.append(line)

    def _take(self, material: Material | None, keyword: str, rest: str) -> None:
        numbers = rest.split()[: _NUMBERS.get(keyword, 0)]
        if _IMAGE.fullmatch(keyword):
            name = _OPTIONS.sub("", rest, count=1)
            options, name = rest.removesuffix(name), name.strip('" ')
            if name:
                self.images[len(self.lines)] = (f"{keyword} {options}".strip(), name)
            if material is None or keyword.lower() != "map_kd":
                self.others[keyword] = None
                return
            material.texture = name or None
            if options:
                self.others[f"{keyword} {options}".strip()] = None
        elif material is None or keyword not in _NUMBERS or len(numbers) < _NUMBERS[keyword] or not all(map(is_number, numbers)):
            self.others[keyword] = None
        elif keyword == "Kd":
            shares = np.nan_to_num(np.clip(np.array(numbers, np.float32), 0, 1)).astype(np.float64)
            material.color = (*(255.0 * shares).astype(np.uint8).tolist(), 255)  # truncated, as in MeshLab
        elif keyword == "d" and float(numbers[0]) < 1.0:
            self.others[f"d {numbers[0]}"] = None


@dataclass(frozen=True, eq=False)
class ObjDocument:
    """The data of an OBJ file that the writer needs."""

    data: bytes
    tokens: Tokens  # without `kinds`, `values` and `first`
    mesh: MeshData
    width: int  # how many numbers the line of a vertex has; 0 if three of them are a colour in levels
    normals: Floats  # (k, 3) on the ``vn`` lines
    #: (m, 3) index of the normal of each triangle corner, -1 for none; None if no corner has a normal
    corner_normals: Longs | None
    states: Longs  # (m, 5) for each triangle the last line before it with each keyword in `STATES`, -1 for none
    materials: Materials
    lost: tuple[str, ...]  # names of contents that a new text cannot have


class _Corners(NamedTuple):
    lines: Longs  # (p,) the line of each face or polyline
    lengths: Longs  # (p,) its corner count
    indices: Longs  # (c, 3) the indices of vertices, texture coordinates and normals, -1 for none


def read_obj(path: Path, references: References) -> Reading:
    """Reads an OBJ file and its materials."""
    data = path.read_bytes()
    if b"\0" in data[:4096]:
        raise ContentsError("it is no text")
    tokens = tokenise(data, slashes=True, joins=True)
    counts = _counts(tokens)
    counts["comments"] = len(_COMMENT.findall(data)) if b"#" in data else 0
    notes: dict[str, None] = {}
    width, vertices, colors, levels = _vertices(tokens, data, notes)
    normals = _rows(tokens, "vn", (3,))[2]
    coordinate_lines, coordinate_counts, coordinates = _rows(tokens, "vt", (2, 3))
    if numbers_of(tokens, coordinate_lines[coordinate_counts == 3], 3, 1).any():
        notes["third texture coordinates"] = None
    corners = _corners(tokens, "f", 3, "face", counts, notes)
    lines = _corners(tokens, "l", 2, "polyline", counts, notes)
    places, row, attributes = triangulated(vertices, corners.indices[:, 0], corners.lengths)
    indices = corners.indices[places]
    bare = (indices[:, :, 1] < 0).all(axis=1)
    if not bare.all():
        attributes["wedge_texture_coordinates"] = np.append(coordinates, [[0.0, 0.0]], axis=0)[indices[:, :, 1]]
        pairs = np.add.reduceat(corners.indices[:, 1] >= 0, np.cumsum(corners.lengths) - corners.lengths, dtype=np.int64)
        if bare_faces := int((pairs == 0).sum()):
            notes[f"faces without texture coordinates, which get 0 0 ({bare_faces:,})"] = None
        if partly := int(((pairs > 0) & (pairs < corners.lengths)).sum()):
            notes[f"faces with texture coordinates only at some corners ({partly:,})"] = None
    elif len(coordinates):
        notes[f"texture coordinates that no face names ({len(coordinates):,})"] = None
    uses = lines_of(tokens, b"usemtl")
    names = [_words_after_keyword(tokens, k) for k in uses.tolist()]
    materials, files = _materials(path, tokens, names, references, notes)
    numbers = {name: k for k, name in enumerate(materials.textures)}
    use = (np.searchsorted(uses, corners.lines) - 1)[row]
    if len(indices) and any(name in materials.named for name in names):
        shades: list[tuple[int, ...]] = [_GREY]
        for name in names:  # an unknown material does not change the colour
            shades.append(materials.named[name].color if name in materials.named else shades[-1])
        attributes["colors"] = np.array([*shades[1:], shades[0]], np.uint8)[use]
    if numbers and not bare.all():
        of_use = [numbers.get(materials.named[n].texture or "", -1) if n in materials.named else -1 for n in names]
        # In a file with one texture and no usemtl line, all faces with texture coordinates have the texture.
        of_use.append(0 if not names and len(numbers) == 1 else -1)
        attributes["texture"] = np.where(bare, -1, np.array(of_use)[use]).astype(np.int32)
    vertex_normals, corner_normals = _normals(len(vertices), normals, indices, notes)
    vertex_attributes = {name: values for name, values in (("colors", colors), ("normals", vertex_normals)) if values is not None}
    images, doubts = list[Texture](), list[str]()
    for name in sorted({name for _, name in materials.images.values()} - set(materials.textures)):
        try:
            images.append(Texture(name, references.find_image(name)))
        except InputError as error:  # noqa: PERF203
            doubts.append(f"{error.reason}; it is not copied")
    mesh = MeshData(
        vertices=vertices,
        faces=indices[:, :, 0].astype(np.int32),
        edges=edges_of(lines.indices[:, 0], lines.lengths),
        vertex_attributes=vertex_attributes,
        face_attributes=attributes,
        keeps_normals=vertex_normals is not None and len(indices) > 0,
        textures=tuple(Texture(name, references.find_image(name)) for name in materials.textures),
    )
    states, others = (tuple(f"{what} ({n:,})" for what in kind if (n := counts[what])) for kind in (_STATES, _OTHERS))
    document = ObjDocument(
        data,
        replace(tokens, kinds=tokens.kinds[:0].copy(), values=np.empty(0), first=np.empty(0, np.int64)),
        mesh,
        0 if levels else width,
        normals,
        corner_normals,
        _states(tokens, corners.lines)[row],
        materials,
        (*others, *(note for note in notes if note in _UNWRITTEN)),
    )
    source = Source(path, "obj", document, (*states, *others, *notes), images=tuple(images))
    doubts = [*unended(data), *((_LEVELS,) if levels else ()), *doubts]
    return Reading(replace(mesh, source=source), tuple(doubts), tuple(files))


def _counts(tokens: Tokens) -> Counter[str]:
    """Counts lines by their contents (`_LINES`); refuses a line without a keyword of the format."""
    counts = Counter[str]()
    for code, number in zip(*(a.tolist() for a in np.unique(tokens.keywords, return_counts=True)), strict=True):
        if (what := _CODES.get(code)) is not None:
            counts[what] += number
            continue
        for k in np.flatnonzero(tokens.keywords == np.uint64(code)).tolist():
            what = _KEYWORDS.get(re.split(rb"[ \t/]", tokens.line(k).lstrip(b" \t"))[0].decode("latin-1"))
            refuse(tokens, np.array([k]), np.array([what is None]), "begins with no keyword of the format")
            counts[str(what)] += 1
    return counts


def lines_of(tokens: Tokens, keyword: bytes) -> Longs:
    """Returns the lines that begin with a keyword."""
    return np.flatnonzero(tokens.keywords == word(keyword))


def _rows(tokens: Tokens, keyword: str, widths: tuple[int, ...]) -> tuple[Longs, Longs, Floats]:
    """Returns the lines of a keyword; for each, its count of numbers (one of `widths`) and its first `widths[0]` numbers."""
    lines = lines_of(tokens, keyword.encode())
    counts = tokens.lengths[lines] - 1
    refuse(tokens, lines, ~np.isin(counts, widths), f"has {{}} values and not {' or '.join(map(str, widths))}", counts)
    return lines, counts, numbers_of(tokens, lines, 1, widths[0])


def _vertices(tokens: Tokens, data: bytes, notes: dict[str, None]) -> tuple[int, Floats, NDArray[np.uint8] | None, bool]:
    """Returns the count of numbers per vertex, coordinates, colours, and whether colours are levels."""
    lines, counts, vertices = _rows(tokens, "v", _VERTEX)
    width = int(counts[0]) if len(lines) else 3
    refuse(tokens, lines, counts != width, f"has {{}} values, while the vertices before it have {width}", counts)
    extra = numbers_of(tokens, lines, 4, width - 3)
    if width == 4 and (extra != 1).any():
        notes["weights of vertices"] = None
    if b"#MRGB " in data:  # ZBrush writes colours in comments: 8 hexadecimal digits of mask and colour per vertex
        masks = bytes.fromhex(b"".join(re.findall(rb"(?m)^#MRGB ((?:[0-9a-fA-F]{8})+)", data)).decode())
        if len(masks) == 4 * len(lines):
            painted = np.frombuffer(masks, np.uint8).reshape(-1, 4)[:, [1, 2, 3, 0]].copy()
            painted[:, 3] = 255
            return width, vertices, painted, False
    if width < 6:
        return width, vertices, None, False
    is_outside, top = ~((extra >= 0) & (extra <= 1)).all(axis=1), 1.0
    if is_outside.any():
        if width == 7 or not ((extra >= 0) & (extra <= 255) & (extra == np.rint(extra))).all():
            raise ContentsError(f"the colour of its vertex {int(np.argmax(is_outside)) + 1:,} is not from 0.0 to 1.0")
        top = 255.0
    colors = np.full((len(lines), 4), 255, np.uint8)
    colors[:, : width - 3] = np.rint(extra / top * 255.0)
    return width, vertices, colors, top > 1.0


def _corners(tokens: Tokens, keyword: str, least: int, what: str, counts: Mapping[str, int], notes: dict[str, None]) -> _Corners:
    """Parses indices ``vertex/texture coordinate/normal`` on lines: 1 is the first of its kind, -1 the last before the line."""
    chosen = tokens.keywords == word(keyword.encode())
    lines = np.flatnonzero(chosen)
    mask = np.repeat(chosen, tokens.lengths)
    mask[tokens.first[lines]] = False
    kinds, values = tokens.kinds[mask], tokens.values[mask]
    line_of = np.repeat(lines, tokens.lengths[lines] - 1)
    follows = kinds >= AFTER_SLASH
    kinds = kinds & (AFTER_SLASH - 1)
    slots = follows.astype(np.int8)
    slots[1:] += follows[1:] & follows[:-1]
    strange = (kinds != INTEGER) & ~((kinds == EMPTY) & (slots > 0))
    strange[2:] |= follows[2:] & follows[1:-1] & follows[:-2]  # three slashes
    refuse(tokens, line_of, strange, "has something else than whole numbers, joined by slashes")
    per_line = np.bincount(line_of[slots == 0], minlength=len(tokens.numbers))[lines]
    refuse(tokens, lines, per_line < least, f"is a {what} of fewer than {least} vertices")
    refuse(tokens, lines, (keyword == "f") & (per_line > LARGEST_FACE), f"is a face of more than {LARGEST_FACE:,} vertices")
    corner = np.cumsum(slots == 0) - 1
    indices = np.full((int(per_line.sum()), 3), -1, np.int64)
    for slot, (kind, name) in enumerate((("v", "vertex"), ("vt", "texture coordinate"), ("vn", "normal"))):
        is_named = (slots == slot) & (kinds == INTEGER)
        if not is_named.any() or (slot and keyword == "l"):
            continue
        if slot and not counts[_KEYWORDS[kind]]:
            notes[f"indices of {_KEYWORDS[kind]}, which the file does not have"] = None
            continue
        index, line = values[is_named], line_of[is_named]
        so_far = np.cumsum(tokens.keywords == word(kind.encode()))[line]
        index = np.where(index < 0, index + so_far, index - 1)
        refuse(tokens, line, (index < 0) | (index >= so_far), f"names a {name} that is not among those before it")
        indices[corner[is_named], slot] = index
    return _Corners(lines, per_line, indices)


def _normals(count: int, normals: Floats, indices: Longs, notes: dict[str, None]) -> tuple[Floats | None, Longs | None]:
    """Returns the normals of vertices, and the index of the normal of each triangle corner.

    As in MeshLab, vertices have normals if the file has as many normals as vertices. Without faces they are in the order of the
    vertices. With faces a vertex has the normal of its last corner, and a vertex of no face has 0. But if at each corner the
    normal has the number of the vertex, the normals are in the order of the vertices, too.
    """
    of_corners = indices[:, :, 2]
    if not len(normals):
        return None, None
    if len(normals) != count:
        named = bool((of_corners >= 0).any())
        notes["normals of corners" if named else f"normals that no face names ({len(normals):,})"] = None
        return None, of_corners if named else None
    if not len(indices):
        return normals, None
    of_corners = np.where(of_corners < 0, indices[:, :, 0], of_corners)
    if (of_corners == indices[:, :, 0]).all():
        return normals, of_corners
    vertex_normals = np.zeros((count, 3))
    vertex_normals[indices[:, :, 0].ravel()] = normals[of_corners.ravel()]
    if not np.array_equal(vertex_normals[indices[:, :, 0]], normals[of_corners], equal_nan=True):
        notes["normals of corners"] = None
    return vertex_normals, of_corners


def _materials(
    path: Path, tokens: Tokens, names: Sequence[str], references: References, notes: dict[str, None]
) -> tuple[Materials, list[Path]]:
    libraries = list(dict.fromkeys(_words_after_keyword(tokens, k) for k in lines_of(tokens, b"mtllib").tolist()))
    # Some programs do not name the material file, which then has the name of the mesh.
    files, missing = _material_files(libraries or ([path.with_suffix(".mtl").name] if names else []), references)
    for name in missing if libraries else ():
        notes[f"the material file {Path(name).name}, which does not exist"] = None
    if names and not files:
        notes[f"uses of materials ({len(names):,}), as there is no material file"] = None
    materials = Materials()
    for file in files:
        before = set(materials.others)
        materials.read(file, path)
        if others := [word for word in materials.others if word not in before]:
            notes[f"{', '.join(others)} of the material file {file.name}"] = None
    if files and (unknown := set(names) - set(materials.named)):
        notes[f"uses of the material {quoted(min(unknown))}, which its material files do not have"] = None
    return materials, files


def _words_after_keyword(tokens: Tokens, k: int) -> str:
    text = re.sub(rb"(^|[ \t])#.*", b"", tokens.line(k))
    return " ".join(text.decode("utf-8", "surrogateescape").split()[1:])


def _states(tokens: Tokens, faces: Longs) -> Longs:
    """Returns (p, 5) the last line of each keyword in `STATES` before each face, -1 for none."""
    states = np.full((len(faces), len(STATES)), -1, np.int64)
    for k, keyword in enumerate(STATES):
        lines = lines_of(tokens, keyword)
        states[:, k] = np.append(lines, -1)[np.searchsorted(lines, faces) - 1]
    return states


def _material_files(names: Sequence[str], references: References) -> tuple[list[Path], list[str]]:
    """Returns the named files, and names without a file. An ``mtllib`` line has one name, perhaps with blanks, or several."""
    paths: dict[Path, None] = {}
    missing = []
    for name in names:
        parts = [single] if (single := references.find(name)) else [references.find(part) for part in name.split()]
        if parts and all(parts):
            paths |= dict.fromkeys(path for path in parts if path)
        else:
            missing.append(name)
    return list(paths), missing


def write_obj(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Writes a mesh."""
    document = mesh.document(ObjDocument)
    normals, of_corners = _normals_to_write(mesh, document)
    if document is not None and document.materials.lines:
        writing.materials.append(document.materials.text(writing.textures))
    if document is not None and (text := _patched_text(mesh, document, normals, of_corners, writing)) is not None:
        target.write(text)
        return ()
    notes = [f"contents that cannot be rewritten are left out: {'; '.join(document.lost)}"] if document and document.lost else []
    if of_corners is not None and mesh.keeps_normals and not np.array_equal(of_corners, mesh.faces):
        own = mesh.vertex_normals
        if number := int(own[~mask_of(mesh.faces, len(own))].any(axis=1).sum()):
            if (of_corners >= 0).all() and np.array_equal(normals[of_corners], own[mesh.faces], equal_nan=True):
                normals, of_corners = own, mesh.faces.astype(np.int64)
            else:
                notes.append(f"normals of vertices that no face uses ({number:,}) are left out")
    states, texts = _states_to_write(mesh, document, writing, notes)
    if writing.materials:
        target.write(b"mtllib %s\n" % writing.material_file.encode("utf-8", "surrogateescape"))
    columns = list(mesh.vertices.T)
    if (colors := mesh.vertex_attributes.get("colors")) is not None:
        columns += [_SHARES[level] for level in colors.T[:3]]
    target.writelines(rows("v" + " %r" * len(columns), columns))
    pairs, of_wedges = _texture_coordinates(mesh)
    is_of_vertices = of_wedges is not None and "wedge_texture_coordinates" not in mesh.face_attributes
    if is_of_vertices and (number := int((~mask_of(mesh.faces, len(mesh.vertices))).sum())):
        notes.append(f"texture coordinates of vertices that no face uses ({number:,}) are left out")
    for keyword, table in (("vt", pairs), ("vn", normals)):
        target.writelines(rows(keyword + " %r" * table.shape[1], list(table.T)))
    if len(mesh.faces):
        target.writelines(_face_lines(mesh, of_wedges, of_corners, states, texts, notes))
    target.writelines(rows("l %r %r", list(mesh.edges.T + 1)))
    return tuple(notes)


def _normals_to_write(mesh: MeshData, document: ObjDocument | None) -> tuple[Floats, Longs | None]:
    """Returns (k, 3) normals, and (m, 3) their index at each corner; None for a cloud or a mesh without normals.

    If vertices moved or faces are new, corners that share vertex and former normal share a mean of face normals: creases stay.
    """
    vertex_normals = mesh.vertex_attributes.get("normals")
    if not len(mesh.faces):
        return (np.empty((0, 3)) if vertex_normals is None else vertex_normals), None
    if document is None or document.corner_normals is None or document.mesh.keeps_normals != mesh.keeps_normals:
        return (mesh.vertex_normals, mesh.faces.astype(np.int64)) if mesh.keeps_normals else (np.empty((0, 3)), None)
    former = document.mesh
    rows = slice(None) if mesh.vertex_ids is None else mesh.vertex_ids
    unmoved = np.array_equal(mesh.vertices, former.vertices[rows]) and (mesh.vertex_ids is None or (mesh.vertex_ids >= 0).all())
    before = former.vertex_attributes.get("normals")
    if (vertex_normals is not None and mesh.keeps_normals) and (  # normals in a file may have any length
        before is None or not np.allclose(unit_vectors(vertex_normals), unit_vectors(before[rows]), 0.0, 1e-7, equal_nan=True)
    ):
        return vertex_normals, mesh.faces.astype(np.int64)
    ids = source_ids(mesh.face_ids, len(mesh.faces))
    normal_indices = np.where(ids[:, None] < 0, -1, document.corner_normals[ids])
    if unmoved and (ids >= 0).all():
        return document.normals, normal_indices
    firsts, groups = numbered(np.stack([mesh.faces.ravel(), normal_indices.ravel()], axis=1))
    groups = groups.reshape(-1, 3)
    return vertex_normals_by_angle(mesh.vertices[mesh.faces.ravel()[firsts]], groups.astype(np.int32)), groups


def _patched_text(
    mesh: MeshData, document: ObjDocument, normals: Floats, of_corners: Longs | None, writing: Writing
) -> bytes | None:
    """Returns the text of the file with new numbers and material file; None if the mesh needs other lines than the file has."""
    former = document.mesh
    colors, before = mesh.vertex_attributes.get("colors"), former.vertex_attributes.get("colors")
    painted = not are_equal(colors, before)
    if (
        not (mesh.vertex_ids is None and mesh.face_ids is None and mesh.edge_ids is None)
        or not (np.array_equal(mesh.faces, former.faces) and np.array_equal(mesh.edges, former.edges))
        or not all(are_equal(mesh.face_attributes.get(name), former.face_attributes.get(name)) for name in _OF_FACES)
        or ("texture_coordinates" in mesh.vertex_attributes and "wedge_texture_coordinates" not in mesh.face_attributes)
        or [texture.name for texture in mesh.textures] != [texture.name for texture in former.textures]
        or mesh.keeps_normals != former.keeps_normals
        or (painted and (colors is None or document.width != (3 if before is None else 6)))
        or (line_normals := _line_normals(document, normals, of_corners)) is None
    ):
        return None
    tokens, vertices = document.tokens, lines_of(document.tokens, b"v")
    new, differs = list(mesh.vertices.T), [a != b for a, b in zip(mesh.vertices.T, former.vertices.T, strict=True)]
    cuts = []
    if painted and colors is not None:
        shares = [_SHARES[level] for level in colors.T[:3]]
        if before is not None:
            cuts.append(changed_words(tokens, vertices, [4, 5, 6], shares, [(colors != before).any(axis=1)] * 3))
        else:
            ends = np.repeat(tokens.spans(vertices, [3])[:, 0, 1:], 2, axis=1)  # empty spans after the coordinates
            cuts.append((ends, [b" %r %r %r" % row for row in zip(*(s.tolist() for s in shares), strict=True)]))
            differs[2] = np.ones(len(vertices), np.bool_)
    cuts.insert(0, changed_words(tokens, vertices, [1, 2, 3], new, differs))
    if line_normals is not document.normals:
        changes = [a != b for a, b in zip(line_normals.T, document.normals.T, strict=True)]
        cuts.append(changed_words(tokens, lines_of(tokens, b"vn"), [1, 2, 3], list(line_normals.T), changes))
    if document.materials.lines:
        lines, bom = lines_of(tokens, b"mtllib").tolist(), 3 * document.data.startswith(b"\xef\xbb\xbf")
        named = b"mtllib " + writing.material_file.encode("utf-8", "surrogateescape") + b"\n" * (not lines)
        places = [(start := int(tokens.starts[k]), start + len(tokens.line(k))) for k in lines] or [(bom, bom)]
        cuts.append((np.array(places, np.int64), [named, *([b""] * (len(places) - 1))]))
    spans, texts = np.concatenate([where for where, _ in cuts]), [text for _, each in cuts for text in each]
    order = np.argsort(spans[:, 0], kind="stable")
    return patched(document.data, spans[order], [texts[k] for k in order.tolist()])


def _line_normals(document: ObjDocument, normals: Floats, of_corners: Longs | None) -> Floats | None:
    """Returns the new normals of the ``vn`` lines; None if a line would need several, or a corner lacks a line."""
    if of_corners is None or document.corner_normals is None:  # a cloud, or no corner has a normal
        return normals if len(normals) == len(document.normals) else document.normals
    is_numbered_alike = len(normals) == len(document.normals) and np.array_equal(of_corners, document.corner_normals)
    if normals is document.normals or is_numbered_alike:
        return normals
    pairs = np.stack([document.corner_normals.ravel(), of_corners.ravel()], axis=1)
    line, normal = pairs[numbered(pairs)[0]].T
    line_normals = document.normals.copy()
    line_normals[line] = normals[normal]
    fits = np.allclose(line_normals[line], normals[normal], rtol=0.0, atol=1e-9, equal_nan=True)
    return line_normals if fits and line.min() >= 0 else None


def _texture_coordinates(mesh: MeshData) -> tuple[Floats, Longs | None]:
    """Returns (k, 2) texture coordinates, and (m, 3) their index at each corner, -1 for none."""
    wedges = mesh.face_attributes.get("wedge_texture_coordinates")
    if wedges is None:
        of_vertices = mesh.vertex_attributes.get("texture_coordinates")
        return (np.empty((0, 2)), None) if of_vertices is None else (of_vertices, mesh.faces.astype(np.int64))
    textured = np.ones(len(wedges), np.bool_)
    if (numbers := mesh.face_attributes.get("texture")) is not None:
        textured = (numbers >= 0) | wedges.any(axis=(1, 2))
    pairs = wedges[textured].reshape(-1, 2)
    firsts, indices = numbered(pairs)
    of_corners = np.full((len(wedges), 3), -1, np.int64)
    of_corners[textured] = indices.reshape(-1, 3)
    return pairs[firsts], of_corners


def _looks(mesh: MeshData) -> Longs:
    """Returns (m, 4) texture number, red, green and blue; -1 for a missing value."""
    looks = np.full((len(mesh.faces), 4), -1, np.int64)
    is_whole = bool(mesh.textures) and "texture_coordinates" in mesh.vertex_attributes
    looks[:, 0] = mesh.face_attributes.get("texture", 0 if is_whole else -1)
    if (colors := mesh.face_attributes.get("colors")) is not None:
        looks[:, 1:] = colors[:, :3]
    return looks


def _states_to_write(
    mesh: MeshData, document: ObjDocument | None, writing: Writing, notes: list[str]
) -> tuple[Longs, dict[int, bytes]]:
    """Returns (m, 5) the lines of `STATES` that apply to each face, -1 for none, and the texts of these lines.

    Faces with another texture or colour than in the file get new materials, which are added to the material file.
    """
    looks = _looks(mesh)
    states = np.full((len(looks), len(STATES)), -1)
    names, texts = set[str](), dict[int, bytes]()
    if document is not None:
        names = set(document.materials.named)
        ids = _with_neighbours(mesh.faces, source_ids(mesh.face_ids, len(looks)))
        states[ids >= 0] = document.states[ids[ids >= 0]]
        numbers = {texture.name: number for number, texture in enumerate(mesh.textures)}
        former = np.append(_looks(document.mesh), [[-1] * 4], axis=0)[ids]
        former[:, 0] = np.array([*(numbers.get(t.name, -2) for t in document.mesh.textures), -1])[former[:, 0]]
        states[(looks != former).any(axis=1), -1] = -1
        texts = {k: document.tokens.line(k) + b"\n" for k in np.unique(states[states >= 0]).tolist()}
    new = states[:, -1] < 0
    if (number := len(numbered(looks[new])[0])) + len(names) > MOST_MATERIALS:
        notes.append(f"colours of faces are left out: with their {number:,} materials there are over {MOST_MATERIALS:,}")
        looks[:, 1:] = -1
    new &= np.logical_or.accumulate(~new | (looks >= 0).any(axis=1))  # before the first material, faces without a look need none
    firsts, kinds = numbered(looks[new])
    first = max(texts, default=-1) + 1
    states[new, -1] = first + kinds
    unused = (name for number in count() if (name := f"material_{number}") not in names)
    for k, (name, (number, *color)) in enumerate(zip(unused, looks[new][firsts].tolist(), strict=False), first):
        definition = f"newmtl {name}\n"
        if color[0] >= 0:
            definition += "Kd {!r} {!r} {!r}\n".format(*_SHARES[color].tolist())
        if 0 <= number < len(mesh.textures):
            texture = mesh.textures[number].name
            definition += f"map_Kd {writing.textures.get(texture, texture)}\n"
        writing.materials.append(definition.encode("utf-8", "surrogateescape"))
        texts[k] = b"usemtl %s\n" % name.encode()
    return states, texts


def _with_neighbours(faces: Ints, ids: Longs) -> Longs:
    """Returns (m,) `ids` of faces in the file; a new face gets the id of an old face that it is connected to, else -1."""
    ids, of_vertices, before = ids.copy(), np.full(int(faces.max(initial=-1)) + 1, -1), -1
    while before != (before := len(new := np.flatnonzero(ids < 0))):
        of_vertices[faces[ids >= 0]] = ids[ids >= 0, None]
        ids[new] = of_vertices[faces[new]].max(axis=1)
    return ids


def _face_lines(
    mesh: MeshData, of_wedges: Longs | None, of_normals: Longs | None, states: Longs, texts: dict[int, bytes], notes: list[str]
) -> Iterator[bytes]:
    """Yields the lines of faces, with a state line before each change of material, group or object."""
    indices = [index for index in (mesh.faces, of_wedges, of_normals) if index is not None]
    if (polygon := mesh.face_attributes.get("polygon")) is not None:  # triangles are joined where all indices agree
        of_corners = numbered(np.stack([index.ravel() for index in indices], axis=1))[1].reshape(-1, 3)
    shape = outlines(mesh.faces if polygon is None else of_corners.astype(np.int32), polygon, [states])
    notes += shape.notes
    corners = [index.ravel()[shape.places] + 1 for index in indices]
    form = "%d" if len(corners) == 1 else "%d//%d" if of_wedges is None else "/".join(["%d"] * len(corners))
    corner_words = [form % row for row in zip(*(c.tolist() for c in corners), strict=True)]
    for k in np.flatnonzero((np.array(corners) == 0).any(axis=0)).tolist():  # a corner without texture coordinates or normal
        corner_words[k] = re.sub(r"/0\b", "/", corner_words[k]).rstrip("/")
    lines = [f"f {' '.join(run)}\n" for run in runs(corner_words, shape.lengths)]
    states = states[shape.triangles]
    starts = np.flatnonzero(np.append(True, (states[1:] != states[:-1]).any(axis=1)))
    current = [-1] * states.shape[1]
    for start, end in zip(starts.tolist(), [*starts[1:].tolist(), len(lines)], strict=True):
        state = states[start].tolist()
        yield from (texts[now] if now >= 0 else end for now, was, end in zip(state, current, _ENDS, strict=True) if now != was)
        current = state
        yield "".join(lines[start:end]).encode("ascii")
