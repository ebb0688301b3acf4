"""The interface to MeshLab: sends meshes as binary PLY files, applies MeshLab's filters, and reads arrays back.

Attributes that MeshLab cannot hold stay outside MeshLab, and return to the elements that still exist. A custom attribute in
MeshLab has the number of each vertex and face. A mesh that a filter creates has no numbers, so it gets none of these attributes.
"""

import re
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray
from PIL import Image

from .declaration import Filter, FilterClass
from .files.errors import ContentsError
from .files.inputs import Reading
from .files.ply_write import write_ply
from .files.polygons import numbered
from .filters.geometry import unit_vectors
from .filters.libraries import spatial
from .filters.mesh import scaled_to_unit
from .filters.topology import proper_faces
from .mesh_data import MeshData, Source, Texture
from .mesh_data.mesh_data import FACE_ATTRIBUTES, VERTEX_ATTRIBUTES, read_pixels, source_ids
from .meshlab.base import BASE
from .meshlab.builtin_filters import BuiltinFilters, constant_defaults
from .meshlab.facts import table
from .processes.worker import use_up
from .scripts import Script, Step, format_script
from .write_back.attributes import WORD, custom_attributes
from .write_back.workbench import Workbench, attributes_of, read_array, wedges_of

_ID = "pymeshfair_id"  # the custom attribute with the number of each element, from 1; 0 is a new element
_TEXTURE = "pymeshfair_texture"  # the custom attribute for texture numbers, which pymeshlab does not give otherwise
#: bits of MeshLab's PLY property "flags": the element is selected; the first, second or third edge is inside a polygon
_SELECTED, _FAUX = 0x20, (0x40000, 0x80000, 0x100000)


class Door:
    """A MeshLab mesh set whose layers have the caller's ids; `lost` has messages about data that MeshLab did not take."""

    def __init__(
        self,
        folder: Path,
        meshes: Mapping[int, MeshData],
        visible: Mapping[int, bool],
        current: int | None,
        *,
        verbose: bool = True,
    ) -> None:
        """Sends the layers to MeshLab; `folder` holds the exchanged files and must exist as long as the meshes."""
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._meshset, self.lost = Path(tempfile.mkdtemp(dir=folder)), BASE(verbose), list[str]()
        self._filters = BuiltinFilters(self._meshset, self._measured, verbose=verbose)
        self._bench = Workbench(self._meshset, verbose=verbose)
        self._ids: dict[int, int] = {}  # MeshLab's id by the caller's id
        self._sent = meshes
        self._names: dict[Texture, str] = {}  # the file name, in the folder, of each sent image
        self._painted = self._with_normals = self._with_face_normals = self._with_uv = False
        self._texts = set[str]()  # values of parameters, some of which name custom attributes
        for number, mesh in meshes.items():
            self._send(mesh)
            self._ids[number] = BASE.current_mesh_id(self._meshset)
            if count := int((~proper_faces(mesh.faces)).sum()):
                self.lost.append(f"MeshLab leaves out faces of {mesh.label} with a vertex twice ({count:,})")
            if not visible[number]:
                BASE.set_current_mesh_visibility(self._meshset, False)
        if current is not None:
            BASE.set_current_mesh(self._meshset, self._ids[current])

    def load(self, path: Path) -> tuple[MeshData, int]:
        """Lets MeshLab read a file; returns the mesh that is current in MeshLab then, and the number of meshes in the file."""
        options = {"load_in_a_single_layer": True} if path.suffix.lower() == ".3ds" else {}
        BASE.load_new_mesh(self._meshset, str(path), **options)
        return self._read(BASE.current_mesh(self._meshset), None), BASE.mesh_number(self._meshset)

    def apply(self, step: Step) -> tuple[dict[str, Any], dict[str, Any]]:
        """Applies a MeshLab filter; returns the values of all its parameters (lengths in mesh units), and the filter's report."""
        values = {**constant_defaults(step.filter), **_with_ids(step.filter, step.values, self._ids)}
        effective = self._filters.on_mesh(step.filter, values)
        parameters = _with_ids(step.filter, effective, {meshlab_id: number for number, meshlab_id in self._ids.items()})
        texts = {value for value in step.values.values() if isinstance(value, str)}
        for name in {word for text in texts for word in WORD.findall(text)}:
            self._send_custom(name)
        self._texts |= texts
        self._painted |= FilterClass.TEXTURE in step.filter.classes
        known = step.filter.python_name
        # by name, since MeshLab's class NORMAL also has filters that only turn faces or the whole mesh
        self._with_normals |= values.get("normaltransfer", "_normal_" in known and "per_face" not in known)
        self._with_face_normals |= "_normal_" in known and "per_face" in known
        self._with_uv |= known.startswith("compute_texcoord_") and known.endswith("_vertex")
        if known in table("unrepeatable")["leaves_state"]:
            use_up()
        return parameters, self._filters.apply(
            step.filter, values, lambda: format_script(Script((Step(step.filter, effective),)))
        )

    def counts(self) -> tuple[int, int]:
        mesh = BASE.current_mesh(self._meshset)
        return mesh.vertex_number(), mesh.face_number()

    def layers(self, next_id: int) -> tuple[list[int], int | None, dict[int, bool]]:
        """The ids of MeshLab's layers, new ones counted from `next_id`; the id of the current layer; which layers are visible."""
        numbers = {meshlab_id: number for number, meshlab_id in self._ids.items()}
        self._ids, visible = {}, {}
        for mesh in BASE.__iter__(self._meshset):
            number = numbers.get(mesh.id(), next_id)
            next_id = max(next_id, number + 1)
            self._ids[number] = mesh.id()
            visible[number] = bool(mesh.is_visible())
        current = BASE.current_mesh_id(self._meshset) if self._ids else None
        return list(self._ids), next((n for n, meshlab_id in self._ids.items() if meshlab_id == current), None), visible

    def fetch(self, number: int) -> MeshData:
        mesh = BASE.mesh(self._meshset, self._ids[number])
        current = BASE.current_mesh_id(self._meshset)
        BASE.set_current_mesh(self._meshset, mesh.id())
        try:
            return self._read(mesh, self._sent.get(number))
        finally:
            BASE.set_current_mesh(self._meshset, current)

    def _send(self, mesh: MeshData) -> None:
        """Sends a mesh as a PLY file, and sets the rest: label, element numbers, face normals, count of selected, matrix."""
        path = self._folder / "mesh.ply"
        names = [self._place(texture) for texture in mesh.textures]
        with path.open("xb") as file:
            write_ply(_for_meshlab(mesh, names), file)
        BASE.load_new_mesh(self._meshset, str(path))
        path.unlink()
        for texture in mesh.textures:
            if texture.image is None:  # so that filters that need the image say that it is missing
                (self._folder / self._names[texture]).unlink(missing_ok=True)
        layer = BASE.current_mesh(self._meshset)
        layer.set_label(mesh.label)
        layer.add_vertex_custom_scalar_attribute(np.arange(1.0, len(mesh.vertices) + 1.0), _ID)
        if len(mesh.faces):
            is_proper = proper_faces(mesh.faces)  # MeshLab's reader drops the others
            layer.add_face_custom_scalar_attribute(np.flatnonzero(is_proper) + 1.0, _ID)
            if "normals" in mesh.face_attributes:
                for axis, column in zip("xyz", mesh.face_normals[is_proper].T, strict=True):
                    layer.add_face_custom_scalar_attribute(np.ascontiguousarray(column), f"pymeshfair_{axis}")
                self._bench.apply("compute_normal_by_function_per_face", **{axis: f"pymeshfair_{axis}" for axis in "xyz"})
        if mesh.vertex_selection.any() or mesh.face_selection.any():
            for _ in range(2):  # inverting twice sets the number of selected elements, which filters need and readers do not set
                BASE.apply_filter(self._meshset, "apply_selection_inverse", invfaces=True, invverts=True)
        if mesh.matrix is not None:
            BASE.apply_filter(self._meshset, "set_matrix", transformmatrix=mesh.matrix, compose=False, freeze=False)

    def _place(self, texture: Texture) -> str:
        """Writes an image as PNG or BMP, which MeshLab always reads; a black pixel if none can be read. Returns its name."""
        if not (self._folder / self._names.get(texture, "none")).exists():
            image = texture.image.read_bytes() if isinstance(texture.image, Path) else texture.image or b""
            is_png = image.startswith(b"\x89PNG")
            target = self._folder / self._names.setdefault(texture, f"texture-{len(self._names)}.{'png' if is_png else 'bmp'}")
            if is_png:
                target.write_bytes(image)
            else:
                pixels = read_pixels(texture)
                Image.fromarray(np.zeros((1, 1, 3), np.uint8) if pixels is None else pixels).save(target)
        return self._names[texture]

    def _send_custom(self, name: str) -> None:
        """Sends a custom attribute, which an expression may name, to the current layer, if the sent mesh has it."""
        layer = BASE.current_mesh(self._meshset)
        sent = next((mesh for number, mesh in self._sent.items() if self._ids.get(number) == layer.id()), None)
        if sent is None:
            return
        for element in ("vertex", "face"):
            values = _custom(sent, element, name)
            ids = None if values is None else _numbers(layer, element, len(values))
            if values is not None and ids is not None and _attribute(layer, element, name) is None:
                getattr(layer, f"add_{element}_custom_scalar_attribute")(_of_old(values, ids), name)

    def _measured(self) -> Any:
        mesh = BASE.current_mesh(self._meshset)
        return MeshData(vertices=mesh.vertex_matrix(), faces=mesh.face_matrix(), edges=mesh.edge_matrix())

    def _read(self, mesh: Any, sent: MeshData | None) -> MeshData:
        """Reads a MeshLab mesh; elements of `sent` that still exist get back the attributes that MeshLab did not hold."""
        vertices, faces, edges = (read_array(mesh, name) for name in ("vertices", "faces", "edges"))
        of_vertices = None if sent is None else _numbers(mesh, "vertex", len(sent.vertices))
        of_faces = None if sent is None else _numbers(mesh, "face", len(sent.faces))
        if sent is not None and len(vertices) and (of_vertices is None or of_vertices.max() < 0):
            of_vertices, of_faces = _at_places(vertices, faces, sent)
        if of_vertices is None:
            sent, of_vertices = None, np.full(len(vertices), -1)
        before = MeshData(vertices=np.empty((0, 3))) if sent is None else sent
        if of_faces is None:
            of_faces = np.full(len(faces), -1)
        else:
            _drop_changed(of_faces, of_vertices, faces, before)
        vertex = _carried(before.vertex_attributes, of_vertices, VERTEX_ATTRIBUTES - {"radii"})
        face = _carried(before.face_attributes, of_faces, FACE_ATTRIBUTES - {"polygon", "texture"})
        if (face.get("polygon", np.empty(0)) >= 0).any() and max(map(len, mesh.polygonal_face_list())) == 3:
            del face["polygon"]  # MeshLab has triangulated the polygons
        keeps_normals = (before.keeps_normals or self._with_normals) and len(faces) > 0
        # skip the normals that MeshLab gives a new curve: a planar section sums them over the faces that it cuts
        has_point_normals = not len(faces) and (not len(edges) or "normals" in before.vertex_attributes)
        if keeps_normals or has_point_normals:
            normals = read_array(mesh, "vertex_normals")
            if (keeps_normals or normals.any()) and not np.isnan(normals).all():  # a mirror by MeshLab makes all normals NaN
                vertex["normals"] = _unit(normals, before.vertex_attributes.get("normals"), of_vertices)
        vertex |= attributes_of(mesh, "vertex")
        wedges = wedges_of(mesh)
        coordinates = before.vertex_attributes.get("texture_coordinates")
        if mesh.has_vertex_tex_coord() and (self._with_uv or coordinates is not None or wedges is None):
            uv = _as_sent(mesh.vertex_tex_coord_matrix(), coordinates, of_vertices)
            vertex["texture_coordinates"] = _continued(uv, coordinates, of_vertices, vertices)
        textures = before.textures
        if self._painted or (sent is None and mesh.texture_number()):
            textures = self._textures_of(mesh)
            face.pop("texture", None)
        if len(faces):
            face |= attributes_of(mesh, "face")
            if self._with_face_normals or "normals" in before.face_attributes:
                with self._bench.matrix_aside(mesh):
                    normals = read_array(mesh, "face_normals")
                face |= {} if np.isnan(normals).all() else {"normals": normals}
            if wedges is not None:
                coordinates = before.face_attributes.get("wedge_texture_coordinates")
                face["wedge_texture_coordinates"] = _as_sent(wedges, coordinates, of_faces)
                if textures:
                    face["texture"] = self._texture_numbers(mesh, len(faces))
        for element, name, values in custom_attributes(self._meshset, mesh, self._texts):
            attributes, ids = (vertex, of_vertices) if element == "vertex" else (face, of_faces)
            old = _custom(before, element, name)
            if old is None or not np.array_equal(_of_old(old, ids), values, equal_nan=True):  # equal ones keep type and digits
                attributes[name] = values
        return replace(
            before,
            vertices=vertices,
            faces=faces,
            edges=edges,
            vertex_attributes=vertex,
            face_attributes=face,
            keeps_normals=keeps_normals,
            textures=textures,
            matrix=np.array(mesh.transform_matrix()),
            label=mesh.label(),
            vertex_ids=_composed(before.vertex_ids, of_vertices, len(before.vertices)),
            face_ids=_composed(before.face_ids, of_faces, len(before.faces)),
            edge_ids=before.edge_ids if np.array_equal(edges, before.edges) else np.full(len(edges), -1),
        )

    def _textures_of(self, mesh: Any) -> tuple[Texture, ...]:
        """Returns the images of a mesh: the sent ones, and new files for those that MeshLab made or painted."""
        images, path = mesh.textures(), self._folder / "names.ply"
        names = list(images)
        if mesh.texture_number() > 1:  # pymeshlab lists images by name, a saved file by number
            BASE.save_current_mesh(self._meshset, str(path), save_textures=False)
            head = path.read_bytes().partition(b"end_header")[0].decode("utf-8", "surrogateescape")
            names = re.findall(r"(?m)^comment TextureFile (.*)$", head)
        textures: dict[str, Texture] = {}
        for name in dict.fromkeys(names):
            texture = self._texture(name, images[name])
            while texture.name in {other.name for other in textures.values()}:  # two layers may use the same name
                texture = replace(texture, name=f"{len(textures) + 1}-{texture.name}")
            textures[name] = texture
        return tuple(textures[name] for name in names)

    def _texture(self, name: str, image: Any) -> Texture:
        sent = next((texture for texture, placed in self._names.items() if placed == name), None)
        if sent is not None and (sent.image is None or not self._painted):
            return sent
        own = name if sent is None else sent.name
        if Path(own).suffix.lower() not in (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"):
            own += ".png"
        if not (image.width() and image.height()):
            return Texture(own, None)
        path = Path(tempfile.mkdtemp(dir=self._folder)) / f"texture{Path(own).suffix.lower()}"
        image.save(str(path.with_suffix(".png")))
        pixels = read_pixels(Texture(own, path.with_suffix(".png")))
        if sent is not None and np.array_equal(pixels, read_pixels(sent)):  # type: ignore[arg-type]
            return sent
        if path.suffix != ".png" and pixels is not None:  # pymeshlab may lack the format
            Image.fromarray(pixels).save(path)
        return Texture(own, path)

    def _texture_numbers(self, mesh: Any, count: int) -> NDArray[np.int32]:
        if mesh.texture_number() == 1:
            return np.zeros(count, np.int32)
        BASE.apply_filter(self._meshset, "compute_new_custom_scalar_attribute_per_face", name=_TEXTURE, expr="ti")
        return np.asarray(mesh.face_custom_scalar_attribute_array(_TEXTURE)).astype(np.int32)


def _with_ids(declared: Filter, values: Mapping[str, Any], ids: Mapping[int, int]) -> dict[str, Any]:
    """The values with layer ids replaced; an unknown id stays, and MeshLab refuses it."""
    return {**values, **{name: ids.get(number, number) for name, number in declared.layers(values).items()}}


def _custom(mesh: MeshData, element: str, name: str) -> NDArray[np.float64] | None:
    """A scalar custom attribute of a mesh, also one that only its file holds; None if there is none of that name."""
    attributes, ids = getattr(mesh, f"{element}_attributes"), getattr(mesh, f"{element}_ids")
    values, document = attributes.get(name), getattr(mesh.source, "document", None)
    if name not in (VERTEX_ATTRIBUTES if element == "vertex" else FACE_ATTRIBUTES) and values is not None and values.ndim == 1:
        return np.asarray(values, np.float64)
    values = document.custom(element).get(name) if document is not None and hasattr(document, "custom") else None
    return None if values is None else _of_old(values.astype(np.float64), source_ids(ids, len(values)))


def _numbers(mesh: Any, element: str, count: int) -> NDArray[np.int64] | None:
    """(n,) each element's number in the sent mesh, -1 for new ones; None if the numbers are lost or one is `count` or more."""
    marks = _attribute(mesh, element, _ID)
    if marks is None:
        return None
    numbers = np.where((marks >= 1.0) & (marks == np.rint(marks)), marks, 0.0).astype(np.int64) - 1
    return numbers if numbers.max(initial=-1) < count else None


def _at_places(vertices: Any, faces: Any, sent: MeshData) -> tuple[NDArray[np.int64] | None, NDArray[np.int64] | None]:
    """The numbers of the elements at the places of sent ones, if a filter lost the numbers; None if no vertex lies at one."""
    of_vertices, first = _first_equal(vertices, sent.vertices), _first_equal(sent.vertices, sent.vertices)
    if of_vertices.max() < 0:
        return None, None
    of_faces = _first_equal(np.sort(of_vertices[faces], axis=1), np.sort(first[sent.faces], axis=1))
    new, old = faces[of_faces >= 0], sent.faces[of_faces[of_faces >= 0]]
    order, place = np.argsort(of_vertices[new], axis=1), np.argsort(first[old], axis=1)
    # If sent vertices coincide, a vertex gets the number of the one that its sent face uses.
    of_vertices[np.take_along_axis(new, order, 1)] = np.take_along_axis(old, place, 1)
    return of_vertices, of_faces


def _first_equal(rows: NDArray[Any], among: NDArray[Any]) -> NDArray[np.int64]:
    """(n,) the first row of `among` that equals each of the (n, 3) rows, -1 if none does."""
    firsts, groups = numbered(np.concatenate([among, rows]))
    found = firsts[groups[len(among) :]]
    return np.where(found < len(among), found, -1)


def _attribute(mesh: Any, element: str, name: str) -> NDArray[np.float64] | None:
    try:
        values = np.ascontiguousarray(getattr(mesh, f"{element}_custom_scalar_attribute_array")(name))
    except pymeshlab.PyMeshLabException:
        return None
    count = mesh.vertex_number() if element == "vertex" else mesh.face_number()
    return values if values.shape == (count,) else None


def _drop_changed(of_faces: NDArray[np.int64], of_vertices: NDArray[np.int64], faces: Any, before: MeshData) -> None:
    """Sets a face's number to -1 unless its vertices are those of the sent face; sent vertices at one place count as the same."""
    old = np.flatnonzero(of_faces >= 0)
    place_of = np.append(numbered(before.vertices)[1], -1)  # the last one is that of new vertices
    corners, originals = np.sort(place_of[[of_vertices[faces[old]], before.faces[of_faces[old]]]], axis=2)
    of_faces[old[(corners != originals).any(axis=1)]] = -1


def _continued(values: NDArray[Any], sent: Any, ids: NDArray[np.int64], points: Any) -> NDArray[Any]:
    """Gives new points the value of the nearest old point, if no old value changed: then MeshLab left the new ones undefined."""
    new = ids < 0
    is_changed = sent is None or not np.array_equal(values[~new], sent[ids[~new]], equal_nan=True)
    if new.any() and not is_changed and np.isfinite(points).all():
        scaled, _ = scaled_to_unit(points)  # squares of distances must neither overflow nor vanish
        values[new] = values[~new][spatial.cKDTree(scaled[~new]).query(scaled[new])[1]]
    return values


def _as_sent(values: NDArray[Any], sent: Any, ids: NDArray[np.int64]) -> NDArray[Any]:
    """Restores the double precision of values that MeshLab returned unchanged in single precision."""
    if sent is None or not len(sent):
        return values
    before = sent[np.maximum(ids, 0)]
    with np.errstate(over="ignore"):
        same = values == before.astype(np.float32)
    return np.where(same & (ids >= 0).reshape(-1, *[1] * (values.ndim - 1)), before, values)


def _carried(attributes: Any, ids: NDArray[np.int64], in_meshlab: frozenset[str]) -> dict[str, Any]:
    """The attributes that are not `in_meshlab`, for elements with the old numbers `ids`; new ones get 0, or -1 as ``polygon``."""
    return {
        name: _of_old(values, ids, -1 if name == "polygon" else 0)
        for name, values in attributes.items()
        if name not in in_meshlab
    }


def _composed(first: NDArray[np.int64] | None, second: NDArray[np.int64], count: int) -> NDArray[np.int64] | None:
    """Returns first[second], the elements' indices in the source file; None if `first` is None and `second` changes nothing."""
    if first is None:
        return None if len(second) == count and np.array_equal(second, np.arange(len(second))) else second
    return _of_old(first, second, -1)


def _of_old(values: NDArray[Any], ids: NDArray[np.int64], new: int = 0) -> NDArray[Any]:
    """The values of old elements by their numbers `ids`; `new` where the number is -1."""
    return np.pad(values, [(0, 1), *[(0, 0)] * (values.ndim - 1)], constant_values=new)[ids]


def _unit(normals: NDArray[np.float64], sent: Any, ids: NDArray[np.int64]) -> NDArray[np.float64]:
    """Scales normals to length 1: some MeshLab filters leave sums of face normals. Keeps zeros and normals equal to `sent`."""
    lengths = np.linalg.norm(normals, axis=1)
    changed = True if sent is None or not len(sent) else (ids < 0) | (normals != sent[ids]).any(axis=1)
    scaled = changed & (lengths > 0)
    if np.abs(lengths[scaled] - 1.0).max(initial=0.0) <= 1e-6:
        return normals
    return np.where(scaled[:, None], unit_vectors(normals), normals)


def _faux(mesh: MeshData) -> NDArray[np.int32]:
    """(m,) MeshLab's flags of the edges that lie inside polygons."""
    polygon = mesh.face_attributes["polygon"]
    marks = np.zeros(len(polygon), np.int32)
    inner = np.flatnonzero(polygon >= 0)
    faces = mesh.faces[inner]
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
    keys = np.concatenate([np.repeat(polygon[inner], 3)[:, None], ends], axis=1)
    _, index, counts = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    marks[inner] = (counts[index.ravel()] == 2).reshape(-1, 3) @ np.array(_FAUX, np.int32)
    return marks


def _for_meshlab(mesh: MeshData, textures: list[str]) -> MeshData:
    """The part of a mesh that MeshLab reads, without faces that have a vertex twice; selections and polygons are flags."""
    of_vertices, of_faces, chosen = mesh.vertex_attributes, mesh.face_attributes, proper_faces(mesh.faces)
    vertex = {name: of_vertices[name] for name in ("normals", "texture_coordinates", "colors") if name in of_vertices}
    vertex |= {name: of_vertices[name].astype(np.float64) for name in ("scalars", "radii") if name in of_vertices}
    if "selection" in of_vertices:
        vertex["flags"] = mesh.vertex_selection * np.int32(_SELECTED)
    face = {name: of_faces[name] for name in ("scalars", "colors", "wedge_texture_coordinates") if name in of_faces}
    if "selection" in of_faces or "polygon" in of_faces:
        marks = mesh.face_selection * np.int32(_SELECTED)
        face["flags"] = marks | _faux(mesh) if "polygon" in of_faces else marks
    if "wedge_texture_coordinates" in of_faces and "texture" in of_faces:
        face["texnumber"] = of_faces["texture"]
    return MeshData(
        vertices=mesh.vertices,
        faces=mesh.faces[chosen],
        edges=mesh.edges,
        vertex_attributes=vertex,
        face_attributes={name: values[chosen] for name, values in face.items()},
        keeps_normals="normals" in vertex,
        textures=tuple(Texture(name, None) for name in textures),
    )


def load_unchecked(path: Path, folder: Path) -> Reading:
    """Reads a file with MeshLab's reader."""
    try:
        mesh, count = Door(folder, {}, {}, None, verbose=False).load(path)
    except Exception as error:  # pymeshlab raises several unrelated types
        raise ContentsError(f"MeshLab says: {' '.join(str(error).split('Error details:')[-1].split())}") from error
    doubts = (f"it holds {count} meshes; one is cleaned and written, the others are not",) if count > 1 else ()
    # No ids: all elements are in the order of the file.
    mesh = replace(mesh.without_matrix(), vertex_ids=None, face_ids=None, edge_ids=None)
    return Reading(replace(mesh, source=Source(path, path.suffix[1:].lower())), doubts)
