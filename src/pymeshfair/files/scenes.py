"""What the readers of scenes share: XML within limits, numbers in texts, and the instances of a scene merged into one mesh."""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from ..filters.geometry import unit_vectors, vertex_normals_by_angle
from ..filters.mesh import Floats, Longs
from ..mesh_data import MeshData, Source, Texture
from ..mesh_data.mesh_data import Array
from .errors import ContentsError
from .inputs import Reading, References, quoted
from .polygons import triangulated
from .tokens import is_number

DEEPEST = 200  # the largest depth of nested elements or parts; usual scenes have about ten levels
_MOST_ELEMENTS = 500_000  # the largest number of elements of a tree; this many take two seconds and 300 MB
#: the largest number of parts that a scene places, groups included, and of vertices and faces of all instances together
MOST_PLACED, _MOST_MADE = 100_000, 100_000_000
NO_TEXTURE = "texture coordinates without a texture"
_DEFAULTS = {"colors": 255, "texture": -1, "polygon": -1}  # values of an attribute in parts that lack it; 0 for others


def parse_xml(
    data: bytes,
    start: Callable[[str, dict[str, str]], object],
    end: Callable[[str], object],
    text: Callable[[str], object] | None = None,
) -> None:
    """Calls `start` and `end` for elements (names without prefix), `text` for texts; refuses documents that declare entities."""
    depth = 0

    def begin(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > DEEPEST:
            raise ContentsError(f"it has elements more than {DEEPEST} levels deep")
        start(tag.rpartition(":")[2], attributes)

    def finish(tag: str) -> None:
        nonlocal depth
        depth -= 1
        end(tag.rpartition(":")[2])

    def refuse_subset(name: str, system: str | None, public: str | None, has_subset: int) -> None:
        if has_subset:
            raise ContentsError("it declares entities or a document type of its own, which no mesh needs")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartDoctypeDeclHandler = refuse_subset
    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = begin, finish, text
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise ContentsError(f"its line {error.lineno:,} is no XML: {expat.ErrorString(error.code)}") from None
    except ContentsError:
        raise
    except (LookupError, ValueError):
        raise ContentsError("it is written in an encoding that is not known; save it as UTF-8") from None


def read_tree(data: bytes) -> ElementTree.Element:
    """Parses a document into a tree."""
    builder = ElementTree.TreeBuilder()
    count = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > _MOST_ELEMENTS:
            raise ContentsError(f"it has more than {_MOST_ELEMENTS:,} elements")
        builder.start(tag, attributes)

    parse_xml(data, start, builder.end, builder.data)
    return builder.close()


def numbers(text: str, what: str, count: int | None = None) -> Floats:
    """Parses finite numbers separated by blanks, `count` of them if it is given; `what` names the text in messages."""
    words = text.split()
    try:
        if "_" in text or not "".join(words).isascii():  # Python would accept these in numbers
            raise ValueError
        values = np.array(words, dtype=np.float64)
    except ValueError:
        wrong_word = next(w for w in words if not is_number(w))
        raise ContentsError(f"{quoted(wrong_word, 30)} among {what} is no number; decimals are written with a point") from None
    if not np.isfinite(values).all():
        raise ContentsError(f"number {int(np.argmin(np.isfinite(values))) + 1:,} of {what} is not finite")
    if count is not None and len(values) != count:
        raise ContentsError(f"{what} has {len(values):,} numbers and not {count}")
    return values


def rows(text: str, width: int, what: str) -> Floats:
    """Parses the numbers of a text as rows, (n, width)."""
    values = numbers(text, what)
    if len(values) % width:
        raise ContentsError(f"{what} are {len(values):,} numbers, which is no multiple of {width}")
    return values.reshape(-1, width)


def indices(text: str, what: str) -> Longs:
    """Parses the whole numbers of a text."""
    values = numbers(text, what)
    whole = (values == np.rint(values)) & (np.abs(values) < 1 << 53)
    if not whole.all():
        raise ContentsError(f"number {int(np.argmin(whole)) + 1:,} of {what} is no whole number")
    return values.astype(np.int64)


def check_range(values: Longs, least: int, below: int, what: str) -> None:
    """Refuses indices that are not from `least` to `below` - 1."""
    if (wrong := (values < least) | (values >= below)).any():
        k = int(np.argmax(wrong))
        raise ContentsError(f"number {k + 1:,} of {what} is {values[k]}, which is no index into {below:,} values")


class Assembly:
    """Collects the instances of a scene, and merges them into one mesh."""

    def __init__(self, references: References) -> None:
        self.lost: dict[str, None] = {}  # names of contents that a mesh cannot hold, each once
        self._references = references
        self._textures: dict[str, tuple[int, Texture]] = {}
        self._parts: list[tuple[MeshData, Floats]] = []
        self._open: set[Hashable] = set()
        self._entered = self._made = 0

    @contextmanager
    def within(self, part: Hashable) -> Iterator[None]:
        """Enters a part of the scene; limits the number of parts, since ten levels of groups of ten make 10^10 instances."""
        self._entered += 1
        if part in self._open:
            raise ContentsError("one of its parts contains itself")
        if len(self._open) == DEEPEST:
            raise ContentsError(f"its parts are more than {DEEPEST} levels deep")
        if self._entered > MOST_PLACED:
            raise ContentsError(f"it places more than {MOST_PLACED:,} parts")
        self._open.add(part)
        yield
        self._open.discard(part)

    def polygons(
        self,
        vertices: Floats,
        corners: Longs,
        lengths: Longs,
        what: str,
        of_corners: Mapping[str, Array],
        of_polygons: Mapping[str, Array | None],
        of_vertices: Mapping[str, Array] | None = None,
    ) -> MeshData:
        """Makes a part from polygons, which are given as for `triangulated`; adds to `lost` what a mesh cannot hold.

        `of_corners` has ``normals`` (c, 3), ``colors`` (c, 3) or (c, 4) from 0 to 1, ``wedge_texture_coordinates`` (c, 2); NaN
        means no value. Normals and colours that agree at the corners of each vertex go to vertices; other colours go to faces if
        they agree in each face. `of_polygons` has (p, ...) values; if each ``texture`` is -1, texture coordinates are left out.
        `of_vertices` has (n, ...) values by the names of `of_corners`; vertices of no face take them.
        """
        check_range(corners, 0, len(vertices), what)
        if (lengths < 3).any():
            k = int(np.argmax(lengths < 3))
            raise ContentsError(f"{what}: face {k + 1:,} has {lengths[k]} corners")
        places, of_face, face = triangulated(vertices, corners, lengths)
        textures = of_polygons.get("texture")
        left_out = ("texture", "wedge_texture_coordinates") if textures is not None and (textures < 0).all() else ()
        face |= {name: v[of_face] for name, v in of_polygons.items() if v is not None and name not in left_out}
        vertex: dict[str, Array] = {}
        for name, values in of_corners.items():
            if np.isnan(values).all():
                continue
            if name in left_out:
                self.lost[NO_TEXTURE] = None
                continue
            if name == "wedge_texture_coordinates":
                face[name] = np.nan_to_num(values[places])
                continue
            has_value = ~np.isnan(values).any(axis=1)
            at_vertices = np.full((len(vertices), values.shape[1]), np.nan)
            if of_vertices is not None and name in of_vertices:
                at_vertices[:] = of_vertices[name]
            at_vertices[corners[has_value]] = values[has_value]
            if (at_vertices[corners[has_value]] == values[has_value]).all():
                vertex[name] = levels(at_vertices) if name == "colors" else np.nan_to_num(at_vertices)
            elif name == "colors" and ((all_levels := levels(values)[places]) == all_levels[:, :1]).all():
                face["colors"] = all_levels[:, 0]
            else:
                self.lost[f"{'colours' if name == 'colors' else name} that differ at one vertex from face to face"] = None
        return MeshData(vertices=vertices, faces=corners[places].astype(np.int32), vertex_attributes=vertex, face_attributes=face)

    def tinted(self, part: MeshData, shades: Sequence[Sequence[float]]) -> MeshData:
        """Multiplies vertex colours by the material colour in `shades`; a part with faces or several `shades` stays unchanged."""
        if all(shade == 1.0 for each in shades for shade in each):
            return part
        if len(part.faces) or len({tuple(each) for each in shades}) > 1:
            self.lost["colours of points and lines that share vertices with faces or other colours"] = None
            return part
        colors = part.vertex_attributes.get("colors", np.full((len(part.vertices), 4), 255, np.uint8))
        return part.with_attributes({"colors": levels(colors / 255.0 * shades[0])})

    def place(self, part: MeshData, matrix: Floats) -> None:
        """Adds a part, transformed by a (4, 4) matrix."""
        self._made += len(part.vertices) + len(part.faces)
        if self._made > _MOST_MADE:
            raise ContentsError(f"all instances of its parts together have more than {_MOST_MADE:,} vertices and faces")
        self._parts.append((part, matrix))

    def texture(self, name: str, load: Callable[[str], Path | bytes | None] | None = None) -> int:
        """Returns the number of a texture; a new one gets the path or bytes of its image from `load`, by default `find_image`."""
        if name not in self._textures:
            self._textures[name] = len(self._textures), Texture(name, (load or self._references.find_image)(name))
        return self._textures[name][0]

    def reading(self, path: Path, format: str, extras: Iterable[str], unit: str | None = None) -> Reading:
        """Merges all instances into one mesh, in their order; `extras` names lost contents besides `lost`."""
        return Reading(replace(self._mesh(), unit=unit, source=Source(path, format, extras=(*extras, *self.lost))))

    def _mesh(self) -> MeshData:
        parts = [_placed(*part) for part in self._parts] or [MeshData(vertices=np.empty((0, 3)))]
        self._parts.clear()
        has_normals = any("normals" in p.vertex_attributes for p in parts)
        first = 0
        for k, part in enumerate(parts):
            if has_normals and "normals" not in part.vertex_attributes:
                parts[k] = part.with_attributes({"normals": vertex_normals_by_angle(part.vertices, part.faces)})
            if (polygon := part.face_attributes.get("polygon")) is not None:
                parts[k] = parts[k].with_attributes(face={"polygon": np.where(polygon < 0, -1, polygon + first).astype(np.int32)})
                first += int(polygon.max(initial=-1)) + 1
        starts = np.cumsum([0, *(len(p.vertices) for p in parts[:-1])])
        return MeshData(
            vertices=np.concatenate([p.vertices for p in parts]),
            faces=np.concatenate([p.faces + start for p, start in zip(parts, starts, strict=True)]),
            edges=np.concatenate([p.edges + start for p, start in zip(parts, starts, strict=True)]),
            vertex_attributes=_joined([p.vertex_attributes for p in parts], [len(p.vertices) for p in parts]),
            face_attributes=_joined([p.face_attributes for p in parts], [len(p.faces) for p in parts]),
            keeps_normals=has_normals,
            textures=tuple(texture for _, texture in self._textures.values()),
        )


def affine_matrix(linear: Floats, move: Any = 0.0) -> Floats:
    """Returns the (4, 4) matrix of a (3, 3) map followed by a translation."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, move
    return matrix


def rotation(axis: Floats, angle: float) -> Floats:
    """Returns the (3, 3) rotation by an angle in radians about an axis of any length; a zero axis gives the identity."""
    x, y, z = axis / (np.linalg.norm(axis) or 1.0)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def with_reversed_faces(part: MeshData) -> MeshData:
    """Reverses the faces of a part."""
    wedges = part.face_attributes.get("wedge_texture_coordinates")
    turned = replace(part, faces=part.faces[:, [0, 2, 1]])
    return turned if wedges is None else turned.with_attributes(face={"wedge_texture_coordinates": wedges[:, [0, 2, 1]]})


def levels(colors: Floats) -> NDArray[np.uint8]:
    """Converts (n, 3) or (n, 4) colours in [0, 1] to (n, 4) levels in [0, 255]; NaN counts as 1."""
    result = np.full((len(colors), 4), 255, np.uint8)
    result[:, : colors.shape[1]] = np.rint(255.0 * np.clip(np.nan_to_num(colors, nan=1.0), 0.0, 1.0))
    return result


def _placed(part: MeshData, matrix: Floats) -> MeshData:
    if (matrix == np.eye(4)).all():
        return part
    linear = matrix[:3, :3]
    with np.errstate(all="ignore"):
        placed = replace(part, vertices=part.vertices @ linear.T + matrix[:3, 3])
        a, b, c = linear / (np.abs(linear).max() or 1.0)
        side = np.sign(np.dot(a, np.cross(b, c)))
        if (normals := part.vertex_attributes.get("normals")) is not None:
            cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)]) * (side or 1.0)
            placed = placed.with_attributes({"normals": unit_vectors(normals @ cofactors.T)})
    return with_reversed_faces(placed) if side < 0 else placed


def _joined(attributes: Sequence[Mapping[str, Array]], counts: Sequence[int]) -> dict[str, Array]:
    joined = {}
    for name in dict.fromkeys(name for of_part in attributes for name in of_part):
        like = next(of_part[name] for of_part in attributes if name in of_part)
        columns = [
            of_part[name] if name in of_part else np.full((count, *like.shape[1:]), _DEFAULTS.get(name, 0), like.dtype)
            for of_part, count in zip(attributes, counts, strict=True)
        ]
        joined[name] = np.concatenate(columns)
    return joined
