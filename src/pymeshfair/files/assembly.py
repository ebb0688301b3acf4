"""Parts of a scene, each placed by a matrix, as one mesh; polygons with values at their corners as such a part."""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..filters.geometry import unit_vectors, vertex_normals_by_angle
from ..filters.topology import proper_faces
from ..mesh_data import MeshData, Source, Texture
from .errors import ContentsError
from .indices import check_range
from .inputs import Reading
from .polygons import triangulated
from .references import References

#: placements, and vertices and faces of all of them together, of one file
MOST_PLACED, MOST_ELEMENTS = 100_000, 100_000_000
_DEEPEST = 200
#: units of length in metres
METRES = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048}
#: values for a part without an attribute that another part has
_DEFAULTS = {"colors": 255, "texture": -1, "polygon": -1}


class Assembly:
    """Collects the parts of a scene.

    Attributes:
        textures: of all parts.
        lost: contents of the scene that a mesh cannot have, in words, each once.
    """

    def __init__(self) -> None:
        self.textures: list[Texture] = []
        self.lost: dict[str, None] = {}
        self._parts: list[tuple[MeshData, NDArray[np.float64]]] = []
        self._numbers: dict[str, int] = {}
        self._open: set[Hashable] = set()
        self._entered = self._elements = 0

    def __bool__(self) -> bool:
        """Whether anything was placed."""
        return bool(self._parts)

    @contextmanager
    def within(self, part: Hashable) -> Iterator[None]:
        """Within a part of the scene. Parts are counted: ten nested groups of ten make 10^10 placements."""
        self._entered += 1
        if part in self._open:
            raise ContentsError("a part of it is a part of itself")
        if len(self._open) == _DEEPEST:
            raise ContentsError(f"its parts are more than {_DEEPEST} levels deep")
        if self._entered > MOST_PLACED:
            raise ContentsError(f"it places more than {MOST_PLACED:,} parts")
        self._open.add(part)
        yield
        self._open.discard(part)

    def polygons(
        self,
        vertices: NDArray[np.float64],
        corners: NDArray[np.int64],
        lengths: NDArray[np.int64],
        what: str,
        of_corners: Mapping[str, NDArray[Any]],
        of_polygons: Mapping[str, NDArray[Any] | None],
    ) -> MeshData:
        """A part made of polygons; what of it a mesh cannot hold is added to `lost`.

        Args:
            vertices: (n, 3) coordinates.
            corners: (c,) indices of vertices, those of one polygon after those of another.
            lengths: (p,) how many corners each polygon has.
            what: the corners in a message.
            of_corners: ``normals`` (c, 3), ``colors`` (c, 3) or (c, 4) from 0 to 1, ``wedge_texture_coordinates`` (c, 2); normals
                and colours become those of vertices if they are the same at all corners there, else colours those of faces if
                possible. A row of nan is no value.
            of_polygons: attributes of polygons, (p, ...). If ``texture`` is -1 in all, there are no texture coordinates either.
        """
        check_range(corners, 0, len(vertices), what)
        if (lengths < 3).any():
            k = int(np.argmax(lengths < 3))
            raise ContentsError(f"{what}: face {k + 1:,} has {lengths[k]} corners")
        places, of_polygon, face = triangulated(vertices[corners], np.arange(len(corners)), lengths)
        rows = np.arange(len(lengths)) if of_polygon is None else of_polygon
        is_bare = "texture" in of_polygons and bool(np.all(np.asarray(of_polygons["texture"]) < 0))
        left_out = ("texture", "wedge_texture_coordinates") if is_bare else ()
        face |= {name: v[rows] for name, v in of_polygons.items() if v is not None and name not in left_out}
        vertex: dict[str, NDArray[Any]] = {}
        for name, values in of_corners.items():
            if name in left_out or np.isnan(values).all():
                continue
            if name == "wedge_texture_coordinates":
                face[name] = np.nan_to_num(values[places])
            elif (own := _of_vertices(values, corners, len(vertices))) is not None:
                vertex[name] = levels(own) if name == "colors" else np.nan_to_num(own)
            elif name == "colors" and ((all_levels := levels(values)[places]) == all_levels[:, :1]).all():
                face["colors"] = all_levels[:, 0]
            else:
                self.lost[f"{'colours' if name == 'colors' else name} that differ at one vertex from face to face"] = None
        faces = corners[places].astype(np.int32)
        return MeshData(vertices=vertices, faces=faces, vertex_attributes=vertex, face_attributes=face)

    def place(self, part: MeshData, matrix: NDArray[np.float64]) -> None:
        """Add a part, placed by a (4, 4) matrix."""
        self._elements += len(part.vertices) + len(part.faces)
        if self._elements > MOST_ELEMENTS:
            raise ContentsError(f"its parts have more than {MOST_ELEMENTS:,} vertices and faces, each time that they are placed")
        self._parts.append((part, matrix))

    def texture(self, name: str, references: References) -> int:
        """The number of the texture of that name in the folder of the mesh."""
        return self.add_texture(name, lambda: references.find_image(name))

    def add_texture(self, name: str, image: Callable[[], Path | bytes | None]) -> int:
        """The number of the texture of a name; its image is loaded once."""
        if name not in self._numbers:
            self._numbers[name] = len(self.textures)
            self.textures.append(Texture(name, image()))
        return self._numbers[name]

    def reading(self, path: Path, format: str, extras: Iterable[str], unit: str | None = None) -> Reading:
        """All parts as one mesh, in the order in which they were placed; `extras` are contents besides those in `lost`."""
        source = Source(path, format, extras=(*extras, *self.lost))
        return Reading(replace(self._mesh(), unit=unit, source=source))

    def _mesh(self) -> MeshData:
        parts = [_placed(*part) for part in self._parts] or [MeshData(vertices=np.empty((0, 3)))]
        self._parts.clear()
        if any("normals" in p.vertex_attributes for p in parts):
            for k, part in enumerate(parts):
                if "normals" not in part.vertex_attributes:
                    parts[k] = part.with_attributes({"normals": vertex_normals_by_angle(part.vertices, part.faces)})
        starts = np.cumsum([0, *(len(p.vertices) for p in parts)])
        first = 0
        for k, part in enumerate(parts):
            if (own := part.face_attributes.get("polygon")) is not None:
                parts[k] = part.with_attributes(face={"polygon": np.where(own < 0, -1, own + first).astype(np.int32)})
                first += int(own.max(initial=-1)) + 1
        vertex = _joined([p.vertex_attributes for p in parts], [len(p.vertices) for p in parts])
        return MeshData(
            vertices=np.concatenate([p.vertices for p in parts]),
            faces=np.concatenate([p.faces + start for p, start in zip(parts, starts, strict=False)]),
            edges=np.concatenate([p.edges + start for p, start in zip(parts, starts, strict=False)]),
            vertex_attributes=vertex,
            face_attributes=_joined([p.face_attributes for p in parts], [len(p.faces) for p in parts]),
            keeps_normals="normals" in vertex,
            textures=tuple(self.textures),
        )


def triangles_of(corners: NDArray[np.int64], lengths: NDArray[np.int64], *, fans: bool) -> NDArray[np.int64]:
    """(t, 3) which of the corners of strips or fans, one after another, make their triangles, without collapsed ones."""
    counts = np.maximum(lengths - 2, 0)
    first = np.repeat(np.cumsum(lengths) - lengths, counts)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    odd = 0 if fans else step % 2
    places = np.stack([first if fans else first + step + odd, first + step + 1 - odd, first + step + 2], axis=1)
    return np.asarray(places[proper_faces(corners[places])])


def turn(axis: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """(3, 3) the rotation by an angle in radians about an axis of any length; none about an axis of none."""
    x, y, z = axis / (np.linalg.norm(axis) or 1.0)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def turned_over(part: MeshData) -> MeshData:
    """The part with its faces seen from the other side."""
    wedges = part.face_attributes.get("wedge_texture_coordinates")
    turned = replace(part, faces=part.faces[:, [0, 2, 1]])
    return turned if wedges is None else turned.with_attributes(face={"wedge_texture_coordinates": wedges[:, [0, 2, 1]]})


def levels(colors: NDArray[np.float64]) -> NDArray[np.uint8]:
    """(n, 4) colours as levels, of (n, 3) or (n, 4) shares from 0 to 1; nan is 1."""
    whole = np.full((len(colors), 4), 255, np.uint8)
    whole[:, : colors.shape[1]] = np.rint(255.0 * np.clip(np.nan_to_num(colors, nan=1.0), 0.0, 1.0))
    return whole


def unit_of(metres: float) -> str | None:
    """The unit of so many metres, if it is a usual one."""
    return next((unit for unit, length in METRES.items() if abs(metres - length) <= 1e-6 * length), None)


def _of_vertices(values: NDArray[np.float64], corners: NDArray[np.int64], count: int) -> NDArray[np.float64] | None:
    """(count, k) the values of corners as those of their vertices, nan where there is none; None if they differ at one."""
    present = ~np.isnan(values).any(axis=1)
    own = np.full((count, values.shape[1]), np.nan)
    own[corners[present]] = values[present]
    return own if (own[corners[present]] == values[present]).all() else None


def _placed(part: MeshData, matrix: NDArray[np.float64]) -> MeshData:
    if (matrix == np.eye(4)).all():
        return part
    turn = matrix[:3, :3]
    with np.errstate(all="ignore"):
        placed = replace(part, vertices=part.vertices @ turn.T + matrix[:3, 3])
        largest = np.abs(turn).max() or 1.0
        a, b, c = turn / largest
        side = np.sign(np.dot(a, np.cross(b, c)))
        if (normals := part.vertex_attributes.get("normals")) is not None:
            cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)]) * (side or 1.0)
            placed = placed.with_attributes({"normals": unit_vectors(normals @ cofactors.T)})
    return turned_over(placed) if side < 0 else placed


def _joined(attributes: Sequence[Mapping[str, NDArray[Any]]], counts: Sequence[int]) -> dict[str, NDArray[Any]]:
    """The attributes of all parts, one after another; a part that has none of a name gets its default."""
    joined = {}
    for name in dict.fromkeys(name for own in attributes for name in own):
        like = next(own[name] for own in attributes if name in own)
        missing = _DEFAULTS.get(name, 0)
        joined[name] = np.concatenate(
            [
                own[name] if name in own else np.full((count, *like.shape[1:]), missing, like.dtype)
                for own, count in zip(attributes, counts, strict=True)
            ]
        )
    return joined
