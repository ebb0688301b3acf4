"""Converts meshes between MeshLab and trimesh, Open3D or PyVista, and describes what is lost."""

import importlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from ..declaration import Floats, Ints
from ..filters.geometry import unit_vectors
from ..mesh_data import as_levels
from ..meshlab.base import ForeignMeshError
from ..write_back import Workbench, custom_attributes

Values: TypeAlias = dict[str, NDArray[Any]]
#: names of values that stand for MeshLab's scalar, normals (which MeshLab computes from the faces), and colours
_SCALAR, _NORMALS, _COLORS = "scalar", ("normals", "normal"), ("rgb", "rgba", "colors")
#: names of variables in MeshLab's expressions, which an attribute of the same name would hide
_VARIABLES = frozenset(
    ("x", "y", "z", "nx", "ny", "nz", "r", "g", "b", "a", "q", "rad", "vi", "fi", "vsel", "fsel", "vtu", "vtv", "ti")
)


@dataclass(eq=False)
class Arrays:
    """The arrays of a mesh that is converted between packages."""

    vertices: Floats  # (n, 3) coordinates
    faces: Ints = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int32))  # (m, 3) triangles
    edges: Ints = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int32))  # (k, 2) edges that belong to no face
    normals: Floats | None = None  # (n, 3) of the vertices, or None; with faces MeshLab computes its own
    colors: Floats | None = None  # (n, 4) of the vertices, from 0 to 1
    face_colors: Floats | None = None  # (m, 4)
    uv: Floats | None = None  # (n, 2) texture coordinates of the vertices
    of_vertices: Values = field(default_factory=dict)  # each (n,) or (n, 3)
    of_faces: Values = field(default_factory=dict)  # each (m,) or (m, 3)
    lost: list[str] = field(default_factory=list)  # sentences on contents that the other package cannot hold

    def omit(self, reason: str, **contents: Any) -> None:
        """Notes in `lost` the reason and the names of those contents that are not empty, with spaces for underscores."""
        lost = [name.replace("_", " ") for name, content in contents.items() if content is not None and len(content)]
        if lost:
            self.lost.append(f"{reason} the {', '.join(lost)}")

    def rgba(self, colors: Any, count: int) -> Floats | None:
        """Returns (count, 4) RGBA from 0 to 1; None for another number of colours and, with a note, for colours out of range."""
        values = np.asarray(colors)
        if values.ndim != 2 or len(values) != count or count == 0:
            return None
        scaled = values / (255.0 if values.dtype.kind in "ui" or values.max() >= 2.0 else 1.0)
        if not (scaled.min() >= -1e-6 and scaled.max() <= 1.0 + 1e-6):
            self.lost.append("the colours are not taken, since they are neither from 0 to 1 nor from 0 to 255: scale them")
            return None
        scaled = np.clip(scaled, 0.0, 1.0)
        return np.ascontiguousarray(scaled if scaled.shape[1] == 4 else np.column_stack([scaled[:, :3], np.ones(count)]))


def as_meshlab(arrays: Arrays) -> Any:
    """Returns a `pymeshlab.Mesh`; of `of_vertices` and `of_faces` it has only the scalars, see `custom_values`."""
    scalars = [values.get(_SCALAR) for values in (arrays.of_vertices, arrays.of_faces)]
    optional = {
        "v_normals_matrix": arrays.normals if not len(arrays.faces) else None,
        "v_color_matrix": arrays.colors,
        "f_color_matrix": arrays.face_colors,
        "v_tex_coords_matrix": arrays.uv,
        "edge_matrix": arrays.edges,
        **{f"{of}_scalar_array": _numbers(s) for of, s in zip("vf", scalars, strict=True) if s is not None and s.ndim == 1},
    }
    existing = {name: values for name, values in optional.items() if values is not None and len(values)}
    return pymeshlab.Mesh(arrays.vertices, arrays.faces, **existing)


def custom_values(arrays: Arrays) -> dict[tuple[str, str], Floats]:
    """Returns (n,) or (m,) custom attributes by element and name; raises `ForeignMeshError` for values of another length."""
    found: dict[tuple[str, str], Floats] = {}
    for element, values, rows in (("vertex", arrays.of_vertices, arrays.vertices), ("face", arrays.of_faces, arrays.faces)):
        taken: set[str] = set()
        for name, array in values.items():
            if array.shape[:1] != (len(rows),):
                raise ForeignMeshError(
                    f"the {element} values {name!r} have the shape {array.shape}, but there must be a row for each {element} of "
                    f"the mesh, {len(rows):,}: correct them, or leave them out"
                )
            if (name == _SCALAR and array.ndim == 1) or name.lower() in _NORMALS:
                continue
            if array.dtype.kind not in "fiub" or array.shape[1:] not in ((), (3,)):
                arrays.lost.append(f"MeshLab does not take the {element} values {name!r} of shape {array.shape}")
                continue
            # MeshLab's expressions would read freed memory from an attribute of vectors
            columns = {name: array} if array.ndim == 1 else {f"{name}_{axis}": array[:, i] for i, axis in enumerate("xyz")}
            found |= {(element, _attribute_name(key, taken)): _numbers(column) for key, column in columns.items()}
    return found


def of_meshlab(mesh: Any, bench: Workbench) -> Arrays:
    """Returns the arrays of the current layer, `mesh`; the images of textures stay out: pymeshlab only saves them to files."""
    layer = bench.current()
    placed = layer.without_matrix()
    arrays = Arrays(placed.vertices.copy(), placed.faces.copy(), placed.edges.copy())
    if placed.vertex_normals.any():
        arrays.normals = unit_vectors(placed.vertex_normals)  # MeshLab's normals are no unit vectors
    if layer.matrix is not None:
        arrays.lost.append("the layer's matrix was applied to its coordinates, as other packages do not hold it")
    if (placed.vertex_colors < 1.0).any():  # in a mesh from arrays, MeshLab has white vertices and scalars of 0
        arrays.colors = placed.vertex_colors.copy()
    if len(arrays.faces) and placed.has_face_colors:
        arrays.face_colors = placed.face_colors.copy()
    if mesh.has_vertex_tex_coord():
        arrays.uv = mesh.vertex_tex_coord_matrix()
    if placed.vertex_scalars.any():
        arrays.of_vertices[_SCALAR] = placed.vertex_scalars.copy()
    if len(arrays.faces) and placed.has_face_scalars:
        arrays.of_faces[_SCALAR] = placed.face_scalars.copy()
    for element, name, values in custom_attributes(bench.meshset, mesh):
        (arrays.of_vertices if element == "vertex" else arrays.of_faces)[name] = values
    if mesh.has_wedge_tex_coord() or mesh.texture_number():
        arrays.lost.append("the texture stays in MeshLab: save the mesh to a file to keep it")
    return arrays


def _attribute_name(name: str, taken: set[str]) -> str:
    """Returns a name that MeshLab's expressions accept and, in lower case, is not in `taken`; adds it there."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    plain = plain if re.match(r"[A-Za-z]", plain) else f"a_{plain}"
    while plain in _VARIABLES or plain.lower() in taken:
        plain += "_"
    taken.add(plain.lower())
    return plain


def to_trimesh(arrays: Arrays) -> Any:
    """Returns a `trimesh.Trimesh`; without faces a `trimesh.path.Path3D` of the edges; of points alone a `trimesh.PointCloud`."""
    trimesh = importlib.import_module("trimesh")
    colors = None if arrays.colors is None else as_levels(arrays.colors)
    if len(arrays.faces):
        visuals: dict[str, Any] = {"vertex_colors": colors}
        if colors is not None:
            others = {"texture_coordinates": arrays.uv, "colours_of_faces": arrays.face_colors}
            arrays.omit("a mesh of trimesh with colours of vertices cannot hold", **others)
        elif arrays.uv is not None:
            visuals = {"visual": trimesh.visual.TextureVisuals(uv=arrays.uv)}
            arrays.omit("a mesh of trimesh with texture coordinates cannot hold", colours_of_faces=arrays.face_colors)
        elif arrays.face_colors is not None:
            visuals = {"face_colors": as_levels(arrays.face_colors)}
        arrays.omit("a mesh of trimesh cannot hold", edges=arrays.edges)
        result = trimesh.Trimesh(arrays.vertices, arrays.faces, process=False, **visuals)
        result.vertex_attributes.update(arrays.of_vertices)
        result.face_attributes.update(arrays.of_faces)
        return result
    absent = {"normals": arrays.normals, "texture_coordinates": arrays.uv, "values_of_vertices": arrays.of_vertices}
    arrays.omit("a mesh of trimesh without faces cannot hold", **absent)
    if not len(arrays.edges):
        return trimesh.PointCloud(arrays.vertices, colors=colors)
    arrays.omit("a mesh of trimesh with edges alone cannot hold", colours=colors)
    path = importlib.import_module("trimesh.path")
    return path.Path3D(entities=[path.entities.Line(edge) for edge in arrays.edges], vertices=arrays.vertices, process=False)


def to_open3d(arrays: Arrays) -> Any:
    """Returns an `open3d.geometry.TriangleMesh`, or a `PointCloud` if there are no faces, with vertex normals and colours."""
    o3d = importlib.import_module("open3d")
    cloud = not len(arrays.faces)
    result = o3d.geometry.PointCloud() if cloud else o3d.geometry.TriangleMesh()
    colors = None if arrays.colors is None else arrays.colors[:, :3]
    rows: dict[str, Any] = {"points" if cloud else "vertices": arrays.vertices}
    rows |= {name if cloud else f"vertex_{name}": values for name, values in (("normals", arrays.normals), ("colors", colors))}
    for name, values in rows.items():
        if values is not None:
            setattr(result, name, o3d.utility.Vector3dVector(values))
    if not cloud:
        result.triangles = o3d.utility.Vector3iVector(arrays.faces)
    arrays.omit(
        "a mesh of Open3D cannot hold",
        edges=arrays.edges,
        opacity=() if arrays.colors is None else np.flatnonzero(arrays.colors[:, 3] < 1.0),
        texture_coordinates=arrays.uv,
        colours_of_faces=arrays.face_colors,
        values_of_vertices=arrays.of_vertices,
        values_of_faces=arrays.of_faces,
    )
    return result


def to_pyvista(arrays: Arrays) -> Any:
    """Returns a `pyvista.PolyData` with triangles and lines, normals, colours (``RGBA``), texture coordinates and all values."""
    pyvista = importlib.import_module("pyvista")
    parts = {"lines": (2, arrays.edges), "faces": (3, arrays.faces)}
    cells = {name: np.insert(rows, 0, size, axis=1).ravel() for name, (size, rows) in parts.items() if len(rows)}
    result = pyvista.PolyData(arrays.vertices, **cells)
    if arrays.normals is not None:
        result.point_data["Normals"] = arrays.normals
    for of_elements, colors in ((arrays.of_vertices, arrays.colors), (arrays.of_faces, arrays.face_colors)):
        if colors is not None:
            of_elements["RGBA"] = as_levels(colors)
    result.point_data.update(arrays.of_vertices)
    if arrays.uv is not None:
        result.active_texture_coordinates = arrays.uv
    for name, values in arrays.of_faces.items():  # the cells of lines precede those of faces, and get 0
        result.cell_data[name] = np.concatenate([np.zeros((len(arrays.edges), *values.shape[1:]), values.dtype), values])
    return result


def arrays_of(mesh: Any) -> Arrays:
    """Returns the arrays of a mesh of trimesh, Open3D or PyVista; raises `ForeignMeshError` for other objects."""
    if hasattr(mesh, "to_legacy"):  # a tensor mesh of Open3D
        arrays, kept = arrays_of(mesh.to_legacy()), {"positions", "normals", "colors", "indices", "texture_uvs"}
        for part in ("point", "vertex", "triangle"):
            names = {name for name, _ in getattr(mesh, part, {}).items()} - (kept - {"colors"} if part == "triangle" else kept)
            arrays.omit(f"MeshLab does not take {', '.join(sorted(names))},", **{f"{part}_values_of_Open3D": names})
        return arrays
    if hasattr(mesh, "GetPointData"):
        return _of_pyvista(mesh)
    if hasattr(mesh, "geometry") and hasattr(mesh, "graph"):
        return _of_scene(mesh)
    if hasattr(mesh, "vertices") and (hasattr(mesh, "faces") or hasattr(mesh, "colors")):
        return _of_trimesh(mesh)
    if hasattr(mesh, "triangles") or (hasattr(mesh, "points") and hasattr(mesh, "normals")):
        return _of_open3d(mesh)
    kind = f"{type(mesh).__module__}.{type(mesh).__qualname__}"
    raise ForeignMeshError(f"add_mesh takes a pymeshlab.Mesh, or a mesh or cloud of trimesh, Open3D or PyVista, got a {kind}")


def _of_scene(scene: Any) -> Arrays:
    parts = scene.dump()
    if len({type(part) for part in parts}) != 1:
        why = "parts of several kinds: add each of scene.dump() by itself" if parts else "no geometry"
        raise ForeignMeshError(f"the scene has {why}")
    arrays = _of_trimesh(parts[0] if len(parts) == 1 else scene.to_geometry())
    if len(parts) > 1:
        arrays.lost.append(f"the {len(parts)} parts of the scene became one mesh, without their names")
    return arrays


def _of_trimesh(mesh: Any) -> Arrays:
    points = _numbers(mesh.vertices)
    arrays = Arrays(np.pad(points, ((0, 0), (0, 3 - points.shape[1]))))  # a Path may be two-dimensional
    arrays.omit("MeshLab does not take", unit_of_the_mesh=getattr(mesh, "units", None))
    if hasattr(mesh, "vertex_nodes"):  # a Path
        arrays.omit("MeshLab does not take", colours_of_the_path=mesh.colors)
        arrays.edges = _indices(mesh.vertex_nodes)
        if any(type(entity).__name__ not in ("Line", "Text") for entity in mesh.entities):
            # curves become short edges, and equal ends one vertex
            runs = [run for entity in mesh.entities if len(run := entity.discrete(arrays.vertices, scale=mesh.scale))]
            places = np.concatenate(runs)
            starts = np.delete(np.arange(len(places)), np.cumsum([len(run) for run in runs]) - 1)
            first, number = importlib.import_module("trimesh").grouping.unique_rows(places / mesh.scale)
            arrays.vertices, arrays.edges = places[first], _indices(number[np.column_stack([starts, starts + 1])])
        return arrays
    if not hasattr(mesh, "faces"):  # a PointCloud
        arrays.colors = arrays.rgba(getattr(mesh, "colors", ()), len(arrays.vertices))
        return arrays
    arrays.faces = _indices(mesh.faces)
    visual: Any = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    if kind == "vertex":
        arrays.colors = arrays.rgba(visual.vertex_colors, len(arrays.vertices))
    elif kind == "face":
        arrays.face_colors = arrays.rgba(visual.face_colors, len(arrays.faces))
    elif kind == "texture" and getattr(visual, "uv", None) is not None:
        arrays.uv = _numbers(visual.uv)
        material = getattr(visual, "material", None)
        if any(getattr(material, name, None) is not None for name in ("image", "baseColorTexture")):
            arrays.lost.append("the texture is left out, since MeshLab takes no image from memory; its coordinates are kept")
    arrays.of_vertices = _values(getattr(mesh, "vertex_attributes", None))
    arrays.of_faces = _values(getattr(mesh, "face_attributes", None))
    return arrays


def _of_open3d(mesh: Any) -> Arrays:
    cloud = not hasattr(mesh, "triangles")
    arrays = Arrays(_numbers(mesh.points if cloud else mesh.vertices))
    arrays.colors = arrays.rgba(mesh.colors if cloud else mesh.vertex_colors, len(arrays.vertices))
    if not cloud:
        arrays.faces = _indices(mesh.triangles)
        contents = {"texture": getattr(mesh, "textures", ()), "texture_coordinates": getattr(mesh, "triangle_uvs", ())}
        arrays.omit("of the Open3D mesh MeshLab does not take", **contents)
    elif len(mesh.normals) == len(arrays.vertices) > 0:
        arrays.normals = _numbers(mesh.normals)
    return arrays


def _of_pyvista(mesh: Any) -> Arrays:
    fields = mesh.field_data.keys()
    if not hasattr(type(mesh), "regular_faces"):  # of a mesh with quads the property raises an error
        mesh = mesh.cast_to_polydata() if hasattr(mesh, "cast_to_polydata") else mesh.extract_surface()
    lines, edges = np.asarray(mesh.lines), [np.zeros((0, 2), dtype=np.int32)]
    while len(lines):
        count = int(lines[0])
        edges.append(np.column_stack([lines[1:count], lines[2 : count + 1]]))
        lines = lines[count + 1 :]
    others, last, pieces = mesh.n_lines + mesh.n_verts, mesh.n_cells - mesh.n_strips, []
    # VTK's triangulation mixes up the values of several kinds of cells. Cells of points and lines come first, strips last.
    for kind, start, end in (("faces", others, last), ("strips", last, mesh.n_cells)):
        piece = mesh
        if 0 < end - start < mesh.n_cells:
            piece = importlib.import_module("pyvista").PolyData(mesh.points, **{kind: getattr(mesh, kind)})
            piece.cell_data.update({name: values[start:end] for name, values in mesh.cell_data.items()})
        pieces += [piece.triangulate()] if start < end else []
    faces = np.concatenate([np.empty((0, 3), np.int64), *(piece.regular_faces for piece in pieces)])
    arrays = Arrays(_numbers(mesh.points), _indices(faces), _indices(np.concatenate(edges)))
    of_cells, arrays.of_vertices = _values(mesh.cell_data), _values(mesh.point_data)
    if pieces:
        arrays.of_faces = {name: np.concatenate([piece.cell_data[name] for piece in pieces]) for name in of_cells}
    if others and of_cells:
        arrays.lost.append(f"values of line and point cells are not taken: {', '.join(sorted(of_cells))}")
    if (uv := mesh.active_texture_coordinates) is not None:
        arrays.uv = _numbers(uv)
        arrays.of_vertices = {n: a for n, a in arrays.of_vertices.items() if a.shape != uv.shape or (a != uv).any()}
    if (normals := _pop(arrays.of_vertices, _NORMALS, (3,))) is not None:
        arrays.normals = _numbers(normals)
    arrays.colors = arrays.rgba(_pop(arrays.of_vertices, _COLORS, (3, 4)), len(arrays.vertices))
    arrays.face_colors = arrays.rgba(_pop(arrays.of_faces, _COLORS, (3, 4)), len(arrays.faces))
    arrays.omit("MeshLab does not take", field_data_of_PyVista=fields)
    return arrays


def _pop(values: Values, names: Sequence[str], columns: Sequence[int]) -> NDArray[Any] | None:
    name = next((n for n, a in values.items() if n.lower() in names and a.ndim == 2 and a.shape[1] in columns), None)
    return None if name is None else values.pop(name)


def _numbers(values: Any) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float64)


def _indices(values: Any) -> Ints:
    return np.ascontiguousarray(values, dtype=np.int32)


def _values(values: Any) -> Values:
    return {str(name): np.asarray(array) for name, array in values.items()} if hasattr(values, "items") else {}
