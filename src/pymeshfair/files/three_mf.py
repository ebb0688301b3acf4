"""Reads 3MF archives, with limits against decompression bombs and paths out of the archive; writes 3MF."""

import io
import lzma
import re
import struct
import zipfile
import zlib
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import BinaryIO

import numpy as np

from ..filters.mesh import Floats, mask_of
from ..mesh_data import MeshData
from ..mesh_data.mesh_data import Array
from .errors import ContentsError
from .inputs import Reading, References, check_image, quoted
from .outputs import Writing
from .scenes import Assembly, affine_matrix, check_range, indices, levels, numbers, parse_xml, read_tree, rows

#: the most unpacked bytes: a multiple of the file size, plus a constant; meshes unpack to about 10 times the size
_MOST_TIMES, _BESIDES = 100, 1 << 24
_MOST_PARTS = 10_000
#: errors that `zipfile` raises for a damaged, encrypted or unknown archive
_BROKEN = (zipfile.BadZipFile, RuntimeError, EOFError, zlib.error, lzma.LZMAError, struct.error, ValueError, LookupError, OSError)
#: the elements that are read, and their attributes
_KNOWN = {
    **{"model": {"unit", "requiredextensions", "recommendedextensions"}, "object": {"id", "type", "pid", "pindex"}},
    **{"vertex": {"x", "y", "z"}, "triangle": {"v1", "v2", "v3", "pid", "p1", "p2", "p3"}},
    **{"component": {"objectid", "transform", "path"}, "item": {"objectid", "transform", "path"}},
    **{"basematerials": {"id"}, "base": {"displaycolor"}, "colorgroup": {"id"}, "color": {"color"}},
    **{"texture2d": {"id", "path", "contenttype"}, "texture2dgroup": {"id", "texid"}, "tex2coord": {"u", "v"}},
    **{name: set[str]() for name in ("resources", "build", "components", "mesh", "vertices", "triangles")},
}
_UNSAID = ("xmlns", "xml:", "UUID")  # beginnings and ends of the names of attributes that are ignored without a note
#: extensions that are read: materials, and models in several files
_SPACE = "http://schemas.microsoft.com/3dmanufacturing/"
_UNDERSTOOD = (f"{_SPACE}material/2015/02", f"{_SPACE}production/2015/06")
_CORE = f"{_SPACE}core/2015/02"
_UNITS = {"micron": "um", "millimeter": "mm", "centimeter": "cm", "inch": "in", "foot": "ft", "meter": "m"}


@dataclass
class _Object:
    """An object: coordinates and corner numbers as texts, attributes of triangles, and components."""

    properties: tuple[str, str]  # of triangles without their own: the id of the group, and the index in the group
    coordinates: list[str] = field(default_factory=list)
    corners: list[str] = field(default_factory=list)
    attributes: dict[int, dict[str, str]] = field(default_factory=dict)
    components: list[dict[str, str]] = field(default_factory=list)
    part: MeshData | None = None


@dataclass
class _Model:
    """A model file: objects, build items, resources by id (colours, texture coordinates, textures), counts of unread contents."""

    objects: dict[str, _Object] = field(default_factory=dict)
    items: list[dict[str, str]] = field(default_factory=list)
    colors: dict[str, list[str]] = field(default_factory=dict)
    coordinates: dict[str, tuple[str, list[str]]] = field(default_factory=dict)
    textures: dict[str, str] = field(default_factory=dict)
    unit: str = "millimeter"
    unread: Counter[str] = field(default_factory=Counter)
    _object: _Object = field(default_factory=lambda: _Object(("", "")))
    _group: list[str] = field(default_factory=list)
    _ignored_depth: int = 0

    def start(self, tag: str, qualified: dict[str, str]) -> None:
        if self._ignored_depth or tag not in _KNOWN:
            if not self._ignored_depth and qualified.get("name") != "Application":  # the metadata that names the writing program
                self.unread[f"elements {quoted(tag, 30)}"] += 1
            self._ignored_depth += 1
            return
        attributes = qualified
        if qualified.keys() - _KNOWN[tag]:
            attributes = {name.rpartition(":")[2]: value for name, value in qualified.items()}
            for name in qualified:
                if name.rpartition(":")[2] not in _KNOWN[tag] and not name.startswith(_UNSAID) and not name.endswith(_UNSAID):
                    self.unread[f"attributes {quoted(name, 30)} of the elements {tag!r}"] += 1
        try:
            match tag:
                case "vertex":
                    self._object.coordinates += (attributes["x"], attributes["y"], attributes["z"])
                case "triangle":
                    if len(attributes) > 3:
                        self._object.attributes[len(self._object.corners) // 3] = attributes
                    self._object.corners += (attributes["v1"], attributes["v2"], attributes["v3"])
                case "model":
                    self.unit = attributes.get("unit", self.unit)
                    for prefix in qualified.get("requiredextensions", "").split():
                        if (space := qualified.get(f"xmlns:{prefix}", prefix)) not in _UNDERSTOOD:
                            raise ContentsError(f"it needs the extension {quoted(space, 100)}, which is not known here")
                case "object":
                    if attributes["id"] in self.objects:
                        raise ContentsError(f"it has two objects with the id {quoted(attributes['id'], 30)}")
                    self._object = _Object((attributes.get("pid", ""), attributes.get("pindex", "0")))
                    self.objects[attributes["id"]] = self._object
                    if attributes.get("type", "model") != "model":
                        self.unread[f"the object type {quoted(attributes['type'], 30)}"] += 1
                case "component" | "item":
                    uses = self.items if tag == "item" else self._object.components
                    uses.append({"objectid": attributes["objectid"], **attributes})
                case "basematerials" | "colorgroup":
                    self._group = self.colors.setdefault(attributes["id"], [])
                case "base" | "color":
                    self._group.append(attributes["displaycolor" if tag == "base" else "color"])
                case "texture2d":
                    self.textures[attributes["id"]] = attributes["path"]
                case "texture2dgroup":
                    self._group = self.coordinates.setdefault(attributes["id"], (attributes["texid"], []))[1]
                case "tex2coord":
                    self._group.append(f"{attributes['u']} {attributes['v']}")
        except KeyError as error:
            raise ContentsError(f"a {tag} of it has no {error.args[0]}") from None

    def end(self, tag: str) -> None:
        self._ignored_depth = max(self._ignored_depth - 1, 0)


def read_3mf(path: Path, references: References) -> Reading:
    """Reads a 3MF file."""
    try:
        with zipfile.ZipFile(path) as archive:
            reader = _Reader(archive, path.stat().st_size, references)
            unit = reader.read_build()
    except ContentsError:
        raise
    except _BROKEN as error:
        raise ContentsError(f"its archive cannot be read ({str(error)[:80]})") from error
    extras = [f"its part {quoted(name)}" for name in sorted(reader.parts.keys() - reader.used)]
    unread = sum((model.unread for model in reader.models.values()), Counter[str]())
    extras += [f"{what} ({number:,})" for what, number in sorted(unread.items())]
    return reader.assembly.reading(path, "3mf", extras, unit)


class _Reader:
    def __init__(self, archive: zipfile.ZipFile, size: int, references: References) -> None:
        self.assembly = Assembly(references)
        self.parts: dict[str, zipfile.ZipInfo] = {}
        self.used: set[str] = set()
        self._archive, self._references = archive, references
        self._left, self._size = _MOST_TIMES * size + _BESIDES, size
        self.models: dict[str, _Model] = {}
        if len(archive.infolist()) > _MOST_PARTS:
            raise ContentsError(f"it holds {len(archive.infolist()):,} parts; {_MOST_PARTS:,} are the most")
        for entry in archive.infolist():
            name = entry.filename
            if name in self.parts or name.startswith("/") or "\\" in name or ".." in PurePosixPath(name).parts:
                raise ContentsError(f"its part {quoted(name)} is there twice, or its name is not allowed")
            if not entry.is_dir():
                self.parts[name] = entry
                self.used |= {name} if name.endswith((".rels", "[Content_Types].xml")) else set()

    def read_build(self) -> str:
        """Places the items of the build; returns the unit of the model."""
        relations = read_tree(self._part("_rels/.rels")).iter()
        parts = [relation.get("Target", "") for relation in relations if relation.get("Type", "").endswith("/3dmodel")]
        if len(parts) != 1:
            raise ContentsError(f"its relationships name {len(parts)} models and not 1")
        model = self._model(parts[0])
        if model.unit not in _UNITS:
            raise ContentsError(f"its unit is {quoted(model.unit, 30)}, which no 3MF file can have")
        with np.errstate(all="ignore"):
            for item in model.items:
                self._place(item, parts[0], np.eye(4))
        if not any(o.part for m in self.models.values() for o in m.objects.values()):
            raise ContentsError("it builds no mesh")
        return _UNITS[model.unit]

    def _part(self, name: str) -> bytes:
        if (entry := self.parts.get(name.removeprefix("/"))) is None:
            raise ContentsError(f"it holds no part {quoted(name)}")
        self.used.add(entry.filename)
        with self._archive.open(entry) as stream:
            data = stream.read(self._left + 1)  # the declared size is not trusted
        self._left -= len(data)
        if self._left < 0:
            raise ContentsError(f"its {self._size:,} bytes unpack to more than {_MOST_TIMES} times as many, which no mesh does")
        return data

    def _model(self, name: str) -> _Model:
        if name not in self.models:
            self.models[name] = _Model()
            parse_xml(self._part(name), self.models[name].start, self.models[name].end)
        return self.models[name]

    def _place(self, use: dict[str, str], model_name: str, parent_matrix: Floats) -> None:
        where = use.get("path", model_name)
        model = self._model(where)
        if use["objectid"] not in model.objects:
            raise ContentsError(f"it places the object {quoted(use['objectid'], 30)}, which is not there")
        item = model.objects[use["objectid"]]
        matrix = parent_matrix
        if "transform" in use:
            columns = numbers(use["transform"], "a transform of it", 12).reshape(4, 3)
            matrix = parent_matrix @ affine_matrix(columns[:3].T, columns[3])
        with self.assembly.within(id(item)):
            if item.part is None and (item.corners or item.coordinates):
                item.part = self._mesh(item, model, f"object {quoted(use['objectid'], 30)}")
            if item.part is not None:
                self.assembly.place(item.part, matrix)
            for component in item.components:
                self._place(component, where, matrix)

    def _mesh(self, item: _Object, model: _Model, what: str) -> MeshData:
        points = rows("\n".join(item.coordinates), 3, f"the coordinates of {what}")
        corners = indices("\n".join(item.corners), f"the corners of {what}")
        if len(points) * 3 != len(item.coordinates) or len(corners) != len(item.corners):
            raise ContentsError(f"a vertex or a triangle of {what} has a value that is no number")
        item.coordinates, item.corners = [], []
        count = len(corners) // 3
        colors, uvs = np.full((count, 3, 4), np.nan), np.full((count, 3, 2), np.nan)
        textures = np.full(count, -1, np.int32)
        group, number = item.properties
        properties = f"the properties of {what}"
        groups: dict[str, tuple[list[int], list[str]]] = {}
        for k in range(count) if group else item.attributes:
            attributes = item.attributes.get(k, {})
            first = attributes.get("p1", number)
            places, texts = groups.setdefault(attributes.get("pid", group), ([], []))
            places.append(k)
            texts += (first, attributes.get("p2", first), attributes.get("p3", first))
        for group, (places, texts) in groups.items():
            chosen = indices(" ".join(texts), properties)
            if group in model.colors:
                check_range(chosen, 0, len(model.colors[group]), properties)
                colors[places] = np.array([_color(c) for c in model.colors[group]])[chosen].reshape(-1, 3, 4)
            elif group in model.coordinates:
                image, pairs = model.coordinates[group]
                check_range(chosen, 0, len(pairs), properties)
                uvs[places] = rows(" ".join(pairs), 2, f"the texture coordinates of {what}")[chosen].reshape(-1, 3, 2)
                textures[places] = self.assembly.texture(model.textures.get(image, ""), self._image)
            elif group:
                self.assembly.lost[f"properties of triangles in its group {quoted(group, 30)}"] = None
        of_corners = {"wedge_texture_coordinates": uvs.reshape(-1, 2)}
        of_polygons: dict[str, Array | None] = {"texture": textures}
        if np.array_equal(colors, np.repeat(colors[:, :1], 3, axis=1), equal_nan=True):
            of_polygons["colors"] = None if np.isnan(colors).all() else levels(colors[:, 0])
        else:
            of_corners["colors"] = colors.reshape(-1, 4)
        return self.assembly.polygons(points, corners, np.full(count, 3), f"the corners of {what}", of_corners, of_polygons)

    def _image(self, name: str) -> bytes:
        data = self._part(name)
        check_image(io.BytesIO(data), self._references.mesh, name)
        return data


def _color(text: str) -> list[float]:
    if not re.fullmatch(r"#([0-9a-fA-F]{2}){3,4}", text):
        raise ContentsError(f"a colour of it is {quoted(text, 30)}, not #RRGGBB or #RRGGBBAA")
    return [level / 255 for level in (*bytes.fromhex(text[1:]), 255)[:4]]


_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default '
    'Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
_RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    f'<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="{_SPACE}2013/01/3dmodel"/></Relationships>'
)


def write_3mf(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Writes a mesh as the only object of a 3MF file, with every digit; the unit is the mesh's if 3MF has that unit, else mm."""
    if not len(mesh.faces):
        raise ContentsError("the format holds only triangles, and the mesh has none")
    vertex, face = (attributes.get("colors") for attributes in (mesh.vertex_attributes, mesh.face_attributes))
    notes = ["the colours of faces are left out, since vertices have colours"] if vertex is not None and face is not None else []
    loose = ~mask_of(mesh.faces, len(mesh.vertices))
    if vertex is not None and (count := int((vertex[loose] != 255).any(axis=1).sum())):
        notes.append(f"colours of vertices that no face uses ({count:,}) are left out")
    group, properties, chosen = "", "", np.empty((len(mesh.faces), 0), np.int64)
    if (levels_of := vertex if vertex is not None else face) is not None:
        shades, shade_of_element = np.unique(np.ascontiguousarray(levels_of).view(">u4").ravel(), return_inverse=True)
        colors = "".join(f'<m:color color="#{shade:08X}"/>' for shade in shades.tolist())
        group = f'<m:colorgroup id="2">{colors}</m:colorgroup>'
        chosen = shade_of_element[mesh.faces] if vertex is not None else shade_of_element.reshape(-1, 1)
        properties = ' pid="2" p1="{}" p2="{}" p3="{}"' if vertex is not None else ' pid="2" p1="{}"'
    row = f'<triangle v1="{{}}" v2="{{}}" v3="{{}}"{properties}/>\n'
    unit = next((name for name, short in _UNITS.items() if short == mesh.unit), "millimeter")
    points = "".join('<vertex x="{!r}" y="{!r}" z="{!r}"/>\n'.format(*place) for place in mesh.vertices.tolist())
    faces = "".join(row.format(*face) for face in np.concatenate([mesh.faces, chosen], axis=1).tolist())
    model = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<model unit="{unit}" xml:lang="en-US" xmlns="{_CORE}" '
        f'xmlns:m="{_UNDERSTOOD[0]}"><resources>{group}<object id="1" type="model"><mesh><vertices>\n{points}</vertices>'
        f'<triangles>\n{faces}</triangles></mesh></object></resources><build><item objectid="1"/></build></model>\n'
    )
    with zipfile.ZipFile(target, "w") as archive:
        for name, text in (("[Content_Types].xml", _TYPES), ("_rels/.rels", _RELATIONS), ("3D/3dmodel.model", model)):
            archive.writestr(zipfile.ZipInfo(name), text, zipfile.ZIP_DEFLATED)  # dated 1980, so bytes do not change with time
    return tuple(notes)
