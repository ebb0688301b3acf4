"""Reads COLLADA documents: the geometries of their scene as one mesh."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote
from xml.etree.ElementTree import Element

import numpy as np

from ..declaration.parameters import METRES
from ..filters.mesh import Floats, Longs
from ..mesh_data import MeshData
from ..mesh_data.mesh_data import Array
from .errors import ContentsError
from .inputs import Reading, References, quoted
from .polygons import edges_of, triangles_of
from .scenes import Assembly, affine_matrix, check_range, indices, levels, numbers, read_tree, rotation

_PRIMITIVES = ("triangles", "polylist", "polygons", "tristrips", "trifans", "lines", "linestrips")
_TRANSFORMS = {"matrix": 16, "bind_shape_matrix": 16, "rotate": 4, "scale": 3, "translate": 3}
#: elements that a mesh cannot hold
_LOST = ("animation", "controller", "camera", "light", "extra", "physics_model", "convex_mesh", "spline", "brep")
#: the parameters that are read, one letter each, by the semantic of an input
_PARAMETERS = {"VERTEX": "XYZ", "NORMAL": "XYZ", "TEXCOORD": "ST", "COLOR": "RGBA"}


def read_collada(path: Path, references: References) -> Reading:
    """Reads a COLLADA document."""
    root = read_tree(path.read_bytes())
    if root.tag != "COLLADA":
        raise ContentsError("it holds no COLLADA document")
    reader = _Reader(root, references)
    with np.errstate(all="ignore"):
        reader.read_scene()
    kinds = {part.tag for part in root.iter()}
    unit, axis = root.find("./asset/unit"), (root.findtext("./asset/up_axis") or "Y_UP").strip()
    metres = numbers(unit.get("meter", "1"), "the unit", 1)[0] if unit is not None else 1.0
    short = next((name for name, length in METRES.items() if abs(metres - length) <= 1e-6 * length), None)
    extras = [f"{kind}{'es' if kind.endswith('sh') else 's'}" for kind in _LOST if kind in kinds]
    extras += [f"its unit of {metres:g} m"] if short is None else []
    extras += [f"its upright axis {quoted(axis, 30)}"] if axis != "Y_UP" else []
    return reader.assembly.reading(path, "dae", extras, None if unit is None else short)


class _Look(NamedTuple):
    """How a material paints faces: colour, texture number, and set of texture coordinates."""

    colour: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    texture: int = -1
    coordinates: str = ""


class _Reader:
    def __init__(self, root: Element, references: References) -> None:
        self.assembly, self._root = Assembly(references), root
        self._ids: dict[str, Element | None] = {}
        for part in root.iter():
            if (name := part.get("id")) is not None:
                self._ids[name] = None if name in self._ids else part  # None if two elements share the id
        self._sources: dict[tuple[int, str], Floats] = {}
        self._geometries: dict[Any, MeshData] = {}

    def read_scene(self) -> None:
        instance = self._root.find("./scene/instance_visual_scene")
        if instance is None:
            raise ContentsError("it has no scene, so nothing in it is placed")
        for node in self._target(instance, "url", "visual_scene").iterfind("node"):
            self._visit(node, np.eye(4))
        if (count := sum(1 for _ in self._root.iter("visual_scene"))) > 1:
            self.assembly.lost[f"scenes besides the one that it shows ({count - 1})"] = None
        placed = {key[0] for key in self._geometries}
        if unused := sum(g.find("mesh") is not None and id(g) not in placed for g in self._root.iter("geometry")):
            self.assembly.lost[f"geometries that its scene does not place ({unused})"] = None

    def _target(self, part: Element, attribute: str, kind: str) -> Element:
        name = part.get(attribute, "")
        target = self._ids.get(name[1:]) if name.startswith("#") else None
        if target is None or target.tag != kind:
            raise ContentsError(f"the {attribute} of a {part.tag} of it is {quoted(name)}, which is no {kind} of the document")
        return target

    def _visit(self, node: Element, parent_matrix: Floats) -> None:
        matrix = parent_matrix
        for part in node:
            if part.tag in ("skew", "lookat"):
                raise ContentsError(f"a node of it is placed by a {part.tag}, which is not known here; save it with matrices")
            if part.tag in _TRANSFORMS:
                matrix = matrix @ _transform(part)
        with self.assembly.within(node):
            for part in node:
                if part.tag == "node":
                    self._visit(part, matrix)
                elif part.tag == "instance_node":
                    self._visit(self._target(part, "url", "node"), matrix)
                elif part.tag == "instance_geometry":
                    self._place(self._target(part, "url", "geometry"), part, matrix)
                elif part.tag == "instance_controller":
                    skin = self._target(part, "url", "controller").find("skin")
                    if skin is None:
                        raise ContentsError("its controller has no skin and is not known here; save it without controllers")
                    bound = _transform(bind) if (bind := skin.find("bind_shape_matrix")) is not None and bind.text else np.eye(4)
                    self._place(self._target(skin, "source", "geometry"), part, matrix @ bound)

    def _place(self, geometry: Element, instance: Element, matrix: Floats) -> None:
        mesh = geometry.find("mesh")
        if mesh is None:
            return  # a spline, or another element of `_LOST`
        bound = {m.get("symbol", ""): m for m in instance.iter("instance_material")}
        symbols = {p.get("material", "") for p in mesh if p.tag in _PRIMITIVES}
        looks = {symbol: self._look(bound[symbol]) for symbol in sorted(symbols) if symbol in bound}
        key = id(geometry), tuple(looks.items())
        if key not in self._geometries:
            self._geometries[key] = self._part(mesh, looks, geometry.get("id", ""))
        self.assembly.place(self._geometries[key], matrix)

    def _part(self, mesh: Element, looks: Mapping[str, _Look], name: str) -> MeshData:
        if (place := mesh.find("vertices/input[@semantic='POSITION']")) is None:
            raise ContentsError(f"its mesh {quoted(name)} has no positions")
        points = self._values(place, "VERTEX")
        corners, lengths, edges = [np.empty(0, np.int64)], [np.empty(0, np.int64)], [np.empty((0, 2), np.int64)]
        values: dict[str, list[Floats]] = {"normals": [], "colors": [], "wedge_texture_coordinates": []}
        part_looks, shades_of_lines = [_Look()], list[tuple[float, ...]]()  # `part_looks`: one for each item of `lengths`
        primitives = [p for p in mesh if p.tag in _PRIMITIVES and p.get("count") != "0"]
        has_faces = not all(p.tag.startswith("line") for p in primitives)
        for p in primitives:
            inputs = [(i, _offset(i)) for i in p.iterfind("input")]
            vertex_offset = next((offset for i, offset in inputs if i.get("semantic") == "VERTEX"), None)
            if vertex_offset is None:
                raise ContentsError(f"the {p.tag} of its mesh {quoted(name)} have no input of vertices")
            inputs += [(i, vertex_offset) for i in mesh.iterfind("vertices/input")]
            table, counts = _corners(p, 1 + max(offset for _, offset in inputs), vertex_offset)
            look = looks.get(p.get("material", ""), _Look())
            if p.tag.startswith("line"):
                check_range(table[:, vertex_offset], 0, len(points), f"the corners of its {p.tag}")
                edges.append(edges_of(table[:, vertex_offset], counts))
                shades_of_lines.append(look.colour)
                others = p.findall("input") if has_faces else [i for i, _ in inputs]  # faces keep the inputs of `vertices`
                if unread := {i.get("semantic", "") for i in others} - {"VERTEX", "POSITION"}:
                    self.assembly.lost[f"inputs {', '.join(sorted(unread))} of {p.tag}"] = None
                continue
            corners.append(table[:, vertex_offset])
            lengths.append(counts)
            for attribute, semantic in (("normals", "NORMAL"), ("colors", "COLOR"), ("wedge_texture_coordinates", "TEXCOORD")):
                matching = [(i, offset) for i, offset in inputs if i.get("semantic") == semantic]
                if semantic == "TEXCOORD" and look.coordinates:
                    matching = [(i, offset) for i, offset in matching if i.get("set", "0") == look.coordinates] or matching
                if len(matching) > 1:
                    self.assembly.lost[f"further inputs {semantic}"] = None
                column = np.full((len(table), len(_PARAMETERS[semantic])), np.nan)
                for i, offset in matching[:1]:
                    source = self._values(i, semantic)
                    check_range(table[:, offset], 0, len(source), f"the corners of its {p.tag}")
                    column[:, : source.shape[1]] = source[table[:, offset]]
                    column[:, source.shape[1] :] = 1.0
                values[attribute].append(column)
            part_looks.append(look)
        of_corners = {name: np.concatenate(each) for name, each in values.items() if each}
        counts = np.array([len(each) for each in lengths])
        of_polygons: dict[str, Array] = {"texture": np.repeat(np.array([look.texture for look in part_looks], np.int32), counts)}
        shades = np.repeat([look.colour for look in part_looks], counts, axis=0)
        if (is_bare := np.isnan(of_corners.get("colors", np.nan))).all() and (shades != 1.0).any():
            of_polygons["colors"] = levels(shades)
        elif (shades != 1.0).any():
            of_corners["colors"] = np.where(is_bare, np.repeat(shades, np.concatenate(lengths), axis=0), of_corners["colors"])
        what = f"the corners of its mesh {quoted(name)}"
        part = self.assembly.polygons(points, np.concatenate(corners), np.concatenate(lengths), what, of_corners, of_polygons)
        return self.assembly.tinted(replace(part, edges=np.concatenate(edges)), shades_of_lines)

    def _values(self, part: Element, semantic: str) -> Floats:
        source = self._target(part, "source", "source")
        key = id(source), semantic
        if key in self._sources:
            return self._sources[key]
        accessor = source.find("./technique_common/accessor")
        if accessor is None:
            raise ContentsError(f"its source {quoted(source.get('id', ''))} has no accessor")
        array = self._target(accessor, "source", "float_array")
        name = f"array {quoted(array.get('id', ''))}"
        values, declared = numbers(array.text or "", f"the {name}"), _whole(array, "count")
        if declared != len(values):
            raise ContentsError(f"its {name} declares {declared:,} numbers, but has {len(values):,}")
        count, stride, offset = (_whole(accessor, key, least) for key, least in (("count", None), ("stride", 1), ("offset", 0)))
        params = [p.get("name", "") for p in accessor.iterfind("param")]
        places = [k for k, p in enumerate(params) if p] or list(range(min(stride, len(values))))
        names = _PARAMETERS[semantic]
        if set(names[:3]) <= set(params):
            places = [params.index(p) for p in names if p in params]
        least = 3 if semantic != "TEXCOORD" else 2
        if max(places, default=0) >= stride:
            raise ContentsError(f"an accessor of its {name} selects value {max(places) + 1} of {stride}")
        if len(places) < least:
            raise ContentsError(f"an accessor of its {name} selects {len(places)} of {stride} values, but {least} are needed")
        if offset + count * stride > len(values) + stride - 1 - max(places):
            raise ContentsError(f"an accessor of its {name} needs more than its {len(values):,} numbers: {count:,} x {stride:,}")
        return self._sources.setdefault(key, values[offset + stride * np.arange(count)[:, None] + places[: len(names)]])

    def _look(self, instance: Element) -> _Look:
        if instance.get("target", "")[1:] not in self._ids:
            self.assembly.lost[f"the material {quoted(instance.get('target', ''))}, which is not there"] = None
            return _Look()
        effect_use = self._target(instance, "target", "material").find("instance_effect")
        effect = None if effect_use is None else self._target(effect_use, "url", "effect")
        diffuse = None if effect is None else effect.find("./profile_COMMON/technique/*/diffuse")
        if diffuse is None or effect is None:
            return _Look()
        if (texture := diffuse.find("texture")) is not None:
            sets = [b for b in instance.iterfind("bind_vertex_input") if b.get("semantic") == texture.get("texcoord")]
            number = self._texture(effect, texture.get("texture", ""))
            return _Look(texture=number, coordinates=sets[0].get("input_set", "0") if sets else "")
        text = diffuse.findtext("color")
        return _Look() if text is None else _Look(tuple(numbers(text, "a colour of it", 4).tolist()))

    def _texture(self, effect: Element, name: str) -> int:
        """Returns the number of a texture, -1 without an image; `name` leads to the image or to its sampler."""
        parameters = {p.get("sid", ""): p for p in effect.iter("newparam")}
        for _ in range(3):
            if (parameter := parameters.get(name)) is None:
                break
            source = next((p for p in parameter.iter() if p.tag in ("source", "init_from", "instance_image")), parameter)
            name = (source.text or "").strip() or source.get("url", "").removeprefix("#")
        image = self._ids.get(name)
        place = None if image is None else next((p for p in image.iter() if p.tag in ("init_from", "ref") and not len(p)), None)
        if place is None or not (place.text or "").strip():
            self.assembly.lost[f"the texture {quoted(name)}, which leads to no image"] = None
            return -1
        return self.assembly.texture(unquote(re.sub(r"\Afile:(//)?", "", (place.text or "").strip())))


def _transform(part: Element) -> Floats:
    v = numbers(part.text or "", f"a {part.tag} of a node of it", _TRANSFORMS[part.tag])
    match part.tag:
        case "translate":
            return affine_matrix(np.eye(3), v)
        case "scale":
            return affine_matrix(np.diag(v))
        case "rotate":
            return affine_matrix(rotation(v[:3], np.radians(v[3])))
    matrix = v.reshape(4, 4)
    if not np.allclose(matrix[3] / (matrix[3, 3] or 1.0), (0, 0, 0, 1), rtol=0, atol=1e-6):
        raise ContentsError("the last row of a matrix of it is not 0 0 0 1")
    return np.asarray(matrix / matrix[3, 3])


def _corners(p: Element, stride: int, vertex_offset: int) -> tuple[Longs, Longs]:
    """Returns (c, stride) indices of the corners of a primitive, and (p,) the corner count of each polygon or line."""
    kind, count = p.tag, _whole(p, "count")
    if p.find("ph") is not None:
        raise ContentsError("its polygons have holes, which are not known here; save it with triangles")
    lists = [indices(text.text or "", f"the corners of its {kind}") for text in p.iterfind("p")]
    table = np.concatenate([np.empty(0, np.int64), *lists])
    if kind in ("triangles", "lines"):
        size = 3 if kind == "triangles" else 2
        lengths = np.full(len(table) // (size * stride), size)
    elif kind == "polylist":
        lengths = indices(" ".join(c.text or "" for c in p.iterfind("vcount")), "the numbers of corners")
    else:
        lengths = np.array([len(corners) // stride for corners in lists], np.int64)
    if (lengths < 0).any():
        raise ContentsError(f"a number of corners of its {kind} is below 0")
    if len(lengths) != count:
        raise ContentsError(f"it declares {count:,} {kind}, but has {len(lengths):,}")
    if len(table) != int(lengths.sum()) * stride:
        raise ContentsError(f"its {count:,} {kind} take {int(lengths.sum()) * stride:,} indices, but {len(table):,} are there")
    table = table.reshape(-1, stride)
    if kind in ("tristrips", "trifans"):
        table = table[triangles_of(table[:, vertex_offset], lengths, fans=kind == "trifans").ravel()]
        lengths = np.full(len(table) // 3, 3)
    return table, lengths


def _whole(part: Element, name: str, least: int | None = None) -> int:
    """Parses a whole-number attribute of an element; `least` is its lower bound and its default; None: 0, and required."""
    text = part.get(name, "" if least is None else str(least))
    if not (text.isascii() and text.isdigit() and len(text) < 16) or int(text) < (least or 0):
        raise ContentsError(f"the {name} of a {part.tag} of it is {quoted(text)}, no whole number from {least or 0} to 10^15 - 1")
    return int(text)


def _offset(part: Element) -> int:
    text = part.get("offset", "0")
    if text not in map(str, range(32)):
        raise ContentsError(f"the offset of an input of it is {quoted(text)}, no whole number from 0 to 31")
    return int(text)
