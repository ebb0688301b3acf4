"""Checks edits, and applies them to meshes; keeps attributes, and continues them into added elements.

An edit adds (a, 3) vertices and (b, 3) faces, with indices below n + a, to a mesh of n vertices and m faces. Colours and textures
of added elements continue those around them. Scalars and vertices' texture coordinates come from a near old element, the donor.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Edit, Floats, Ints, Layer, NewLayer
from ..errors import MeshError
from ..filters.geometry import vertex_normals_by_angle
from ..filters.libraries import spatial
from ..filters.mesh import mask_of
from ..filters.topology import connected_components
from .mesh_data import MeshData, read_pixels, sampled, source_ids

_WIDTHS = {"vertices": 3, "added_vertices": 3, "vertex_normals": 3, "face_normals": 3, "vertex_colors": 4, "face_colors": 4}
_FLAGS = ("vertex_selection", "face_selection", "delete_vertices", "delete_faces")
_NUMBERS = (*_WIDTHS, "vertex_scalars", "face_scalars")
#: Added faces show the texture of old faces within this number of rings.
_RINGS = 4
#: Barycentric coordinates of the texture samples of a face: its centroid, and half way from there to each corner.
_WITHIN = np.array([[2, 2, 2], [4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6.0


def checked_edit(edit: Any, layer: Layer) -> Edit:
    """Returns the edit with the array types of `Edit`; callers put the name of the filter before the text of a `MeshError`."""
    if not isinstance(edit, Edit):
        raise MeshError(f"gave back {type(edit).__name__} instead of an Edit")
    changes: dict[str, Any] = {}
    rows = {"vertex": len(layer.vertices), "face": len(layer.faces)}
    if edit.vertices is not None:
        changes["vertices"] = _checked("vertices", edit.vertices, rows["vertex"])
    if edit.added_vertices is not None:
        changes["added_vertices"] = _checked("added_vertices", edit.added_vertices, len(np.atleast_1d(edit.added_vertices)))
        rows["vertex"] += len(changes["added_vertices"])
    if edit.added_faces is not None:
        changes["added_faces"] = _checked_faces(np.asarray(edit.added_faces), rows["vertex"])
        rows["face"] += len(changes["added_faces"])
    if adds(edit) and not len(layer.faces):
        raise MeshError(
            f"gave back elements to add to {layer.label!r}, which has no faces; MeshLab adds only to meshes that have faces; "
            "return them as a new layer"
        )
    for name in (*_NUMBERS, *_FLAGS):
        value = getattr(edit, name)
        if value is not None and name not in changes:
            per_face = name == "delete_faces" or name.startswith("face_")
            changes[name] = _checked(name, value, rows["face" if per_face else "vertex"])
    return replace(edit, **changes, new_layers=tuple(map(_checked_layer, edit.new_layers)))


def _checked_layer(layer: NewLayer) -> NewLayer:
    rows, of = len(np.atleast_1d(layer.vertices)), f" of the new layer {layer.label!r}"
    given = [name for name in ("vertices", "vertex_normals", "vertex_scalars") if getattr(layer, name) is not None]
    arrays: dict[str, Any] = {name: _checked(name, getattr(layer, name), rows, of) for name in given}
    return replace(layer, **arrays)


def _checked_faces(faces: NDArray[Any], vertices: int) -> NDArray[np.int32]:
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu":
        raise MeshError(f"gave back added_faces of shape {faces.shape} and type {faces.dtype}; they must be (b, 3) whole numbers")
    wrong = ((faces < 0) | (faces >= vertices) | (faces == np.roll(faces, 1, axis=1))).any(axis=1)
    if wrong.any():
        first = int(wrong.argmax())
        raise MeshError(
            f"gave back {int(wrong.sum())} added_faces that are no three different indices from 0 to {vertices - 1}, "
            f"first in row {first}: {faces[first].tolist()}"
        )
    return faces.astype(np.int32, copy=False)


def _checked(name: str, value: Any, rows: int, of: str = "") -> NDArray[Any]:
    """Returns an array of an edit in its declared type; refuses a wrong type, shape or value. `of` follows `name` in messages."""
    dtype = np.bool_ if name in _FLAGS else np.float64
    array = np.asarray(value)
    if array.dtype != dtype and (name in _FLAGS or not np.issubdtype(array.dtype, np.number)):
        raise MeshError(f"gave back {name}{of} of type {array.dtype}; they must be {np.dtype(dtype)}")
    array = array.astype(dtype, copy=False)
    shape = (rows, _WIDTHS[name]) if name in _WIDTHS else (rows,)
    if array.shape != shape:
        raise MeshError(f"gave back {name}{of} of shape {array.shape}; this mesh needs {shape}")
    if name in _NUMBERS and not np.isfinite(array).all():
        bad = ~np.isfinite(array.reshape(rows, -1)).all(axis=1)
        raise MeshError(f"gave back {name}{of} with NaN or infinity in {bad.sum()} of {rows} rows, first in row {bad.argmax()}")
    if name.endswith("colors") and not ((array >= 0.0) & (array <= 1.0)).all():
        raise MeshError(f"gave back {name}{of} outside 0 to 1, from {array.min():g} to {array.max():g}")
    return array


def adds(edit: Edit) -> bool:
    """Whether the edit adds vertices or faces to the layer."""
    return any(value is not None and len(value) > 0 for value in (edit.added_vertices, edit.added_faces))


def removes(edit: Edit) -> bool:
    """Whether the edit removes vertices or faces of the layer."""
    return any(x is not None and x.any() for x in (edit.delete_vertices, edit.delete_faces))


def apply_edit(mesh: MeshData, edit: Edit) -> MeshData:
    """Returns the mesh after a checked edit, without the edit's new layers; `Edit` describes the attributes of added elements."""
    if adds(edit):
        mesh = with_additions(mesh, edit)
    if edit.vertices is not None:
        mesh = moved(mesh, np.concatenate([edit.vertices, mesh.vertices[len(edit.vertices) :]]))
    for element in ("vertex", "face"):
        for name in ("selection", "scalars", "normals", "colors"):
            if (values := getattr(edit, f"{element}_{name}")) is not None:
                mesh = mesh.with_attributes(**{element: {name: as_levels(values) if name == "colors" else values}})
    if not removes(edit):
        return mesh
    check_deletable(edit, mesh.edges, mesh.label)
    kept = np.ones(len(mesh.vertices), np.bool_) if edit.delete_vertices is None else ~edit.delete_vertices
    return mesh.part(kept, None if edit.delete_faces is None else ~edit.delete_faces)


def moved(mesh: MeshData, vertices: Floats) -> MeshData:
    """Returns the mesh with other coordinates. If it has faces and a vertex moves, normals are computed anew when needed."""
    if len(mesh.faces) and not np.array_equal(mesh.vertices, vertices):
        mesh = mesh.with_attributes({"normals": _loose_normals(mesh, vertices, mesh.faces)}, {"normals": None})
    return replace(mesh, vertices=vertices)


def _loose_normals(mesh: MeshData, vertices: Floats, faces: Ints) -> Floats | None:
    """Returns new normals, in which old vertices of no face keep theirs; None if no such vertex has one."""
    normals = mesh.vertex_attributes.get("normals")
    if normals is None:
        return None
    loose = ~mask_of(faces, len(vertices))[: len(mesh.vertices)]
    if not normals[loose].any():
        return None
    computed = vertex_normals_by_angle(vertices, faces)
    computed[: len(loose)][loose] = normals[loose]
    return computed


def as_layer(layer: NewLayer) -> MeshData:
    """Converts a new layer of a filter to a mesh."""
    n = len(layer.vertices)
    for name in ("faces", "edges"):
        cells = getattr(layer, name)
        if cells is not None and len(cells) and not (np.min(cells) >= 0 and np.max(cells) < n):
            raise MeshError(f"the new layer {layer.label!r} has {name} that name vertices outside 0 to {n - 1}")
    attributes = {"normals": layer.vertex_normals, "scalars": layer.vertex_scalars}
    faces = np.empty((0, 3), np.int32) if layer.faces is None else layer.faces
    edges = np.empty((0, 2), np.int32) if layer.edges is None else layer.edges
    return MeshData(
        vertices=layer.vertices,
        faces=faces,
        edges=edges,
        vertex_attributes={name: values for name, values in attributes.items() if values is not None},
        label=layer.label,
        vertex_ids=np.full(n, -1),
        face_ids=np.full(len(faces), -1),
        edge_ids=np.full(len(edges), -1),
    )


def as_levels(colors: Floats) -> NDArray[np.uint8]:
    """Converts colours from 0 to 1 to levels from 0 to 255."""
    return np.rint(np.asarray(colors) * 255.0).astype(np.uint8)


def check_deletable(edit: Edit, edges: Ints, label: str) -> None:
    """Refuses to delete end points of the (e, 2) edges."""
    if edit.delete_vertices is not None and (lost := edit.delete_vertices[edges].any(axis=1)).any():
        raise MeshError(
            f"the {int(lost.sum())} edges of {label!r} that end in vertices to be deleted would lose an end; "
            "select these vertices instead, and build a new polyline from the vertices that are not selected"
        )


def texture_donors(mesh: MeshData) -> Bools:
    """Returns the (m,) mask of faces that have texture coordinates; of all faces if none has."""
    wedges = mesh.face_attributes.get("wedge_texture_coordinates", np.zeros((len(mesh.faces), 3, 2)))
    donors = np.asarray(np.isfinite(wedges).all(axis=(1, 2)))
    return donors if donors.any() else ~donors


def with_additions(mesh: MeshData, edit: Edit) -> MeshData:
    """Returns the mesh with added vertices and faces; only the faces of `texture_donors` give them scalars and textures."""
    added_vertices = np.empty((0, 3)) if edit.added_vertices is None else edit.added_vertices
    added_faces: Ints = np.empty((0, 3), np.int32) if edit.added_faces is None else edit.added_faces
    points = np.concatenate([mesh.vertices if edit.vertices is None else edit.vertices, added_vertices])
    may_donate, textures = texture_donors(mesh), mesh.face_attributes.get("texture", np.zeros(len(mesh.faces), np.int32))
    of_vertices, of_faces = _find_donors(points, mesh.faces, added_faces, len(mesh.vertices), may_donate, textures)

    vertex: dict[str, NDArray[Any]] = {}
    for name, values in mesh.vertex_attributes.items():
        if name == "colors":
            continued = np.concatenate([values, values[of_vertices]]) / 255.0
            vertex[name] = as_levels(_harmonic(continued, added_faces, np.arange(len(points)) < len(values)))
        elif name in ("scalars", "texture_coordinates"):
            vertex[name] = np.concatenate([values, values[of_vertices]])
        elif name != "normals":
            vertex[name] = _extended(values, len(added_vertices))
    if (normals := _loose_normals(mesh, points, np.concatenate([mesh.faces, added_faces]))) is not None:
        vertex["normals"] = normals
    face: dict[str, NDArray[Any]] = {}
    for name, values in mesh.face_attributes.items():
        if name == "colors":
            shades = values / 255.0
            blend = _blend(shades, mesh.faces, added_faces, shades[of_faces])
            face[name] = as_levels(np.concatenate([shades, blend]))
        elif name in ("scalars", "texture"):
            face[name] = np.concatenate([values, values[of_faces]])
        elif name == "wedge_texture_coordinates":
            coordinates = np.empty((len(added_faces), 2))
            for number in np.unique(textures[of_faces]):
                image = read_pixels(mesh.textures[number]) if 0 <= number < len(mesh.textures) else None
                donors, here = may_donate & (textures == number), textures[of_faces] == number
                coordinates[here] = _continued_texture(image, values, mesh.faces, added_faces[here], donors, of_faces[here])
            face[name] = np.concatenate([values, np.repeat(coordinates[:, None], 3, axis=1)])
        elif name != "normals":
            face[name] = _extended(values, len(added_faces), -1 if name == "polygon" else 0)
    return replace(
        mesh,
        vertices=points,
        faces=np.concatenate([mesh.faces, added_faces]),
        vertex_attributes=vertex,
        face_attributes=face,
        vertex_ids=_extended(source_ids(mesh.vertex_ids, len(mesh.vertices)), len(added_vertices), -1),
        face_ids=_extended(source_ids(mesh.face_ids, len(mesh.faces)), len(added_faces), -1),
    )


def _extended(values: NDArray[Any], count: int, fill: int = 0) -> NDArray[Any]:
    return np.concatenate([values, np.full((count, *values.shape[1:]), fill, values.dtype)])


def _find_donors(
    points: Floats, faces: Ints, added_faces: Ints, old: int, may_donate: Bools, textures: Ints
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Returns (a,) the rim vertex nearest to each added vertex, (b,) a donor at the rim vertex nearest to each added centroid.

    The first `old` points are the old vertices; donors are the old faces in the (m,) mask `may_donate`. A patch is a component of
    the added faces. It gets the one of the (m,) `textures` whose donors share the most vertices with it. The rim of a texture is
    all vertices that its donors share with the patches that get it. For a patch that touches no donor, and for an added vertex of
    no face, all vertices of donors are the rim.
    """
    patches, count = connected_components(added_faces, len(points))
    numbers, kinds = np.unique(textures, return_inverse=True)
    corners = np.flatnonzero(np.repeat(may_donate, 3))
    pairs, first = np.unique(faces.ravel()[corners] * np.int64(len(numbers)) + kinds[corners // 3], return_index=True)
    vertices, kind = np.divmod(pairs, len(numbers))
    touched = np.zeros((count + 1, len(numbers)), np.int64)  # the last row: vertices without a patch (number -1)
    np.add.at(touched, (patches[vertices], kind), 1)
    touched[-1] = 0
    kind_at = np.where(touched.any(axis=1), touched.argmax(axis=1), -1)[patches]
    # Squares of distances must neither overflow nor vanish; a power of two leaves every digit as it is.
    points = np.ldexp(points, -np.frexp(np.abs(points).max())[1])
    places = np.concatenate([points[old:], points[added_faces].mean(axis=1)])
    wanted = np.concatenate([kind_at[old:], kind_at[added_faces[:, 0]]])
    nearest = np.empty(len(places), np.intp)
    for number in np.unique(wanted):
        rim = np.flatnonzero((number < 0) | ((kind == number) & (kind_at[vertices] == number)))
        _, row = spatial.cKDTree(points[vertices[rim]]).query(places[wanted == number])
        nearest[wanted == number] = rim[row]
    of_vertices, of_faces = np.split(nearest, [len(points) - old])
    return vertices[of_vertices], corners[first[of_faces]] // 3


def _continued_texture(
    pixels: NDArray[np.uint8] | None, wedges: Floats, faces: Ints, added_faces: Ints, may_donate: Bools, donors: NDArray[np.intp]
) -> Floats:
    """Returns (b, 2) one texture coordinate for each added face, at the centroid of an old face with a fitting colour.

    The image, (height, width, 3) `pixels`, has no pixels for added faces. So an added face shows the colour of one near old face:
    the one most similar to a blend of the colours around. Without an image or a near old face, it shows the colour of its donor.
    Corners of old faces are not used, since pixels of other charts may show there.
    `wedges` are the (m, 3, 2) texture coordinates at corners, `donors` the (b,) donors of added faces, all in `may_donate`.
    """
    centroids = wedges.mean(axis=1).astype(np.float32).astype(np.float64)  # MeshLab stores single precision
    old = int(faces.max()) + 1
    near = mask_of(added_faces[added_faces < old], old)
    for _ in range(_RINGS - 1):
        near[faces[near[faces].any(axis=1)]] = True
    donor_faces = np.flatnonzero(near[faces].any(axis=1) & may_donate)
    if pixels is None or len(donor_faces) == 0:
        return np.asarray(centroids[donors])
    samples = np.stack([sampled(pixels, np.einsum("c,fcd->fd", w, wedges[donor_faces])) for w in _WITHIN], axis=1)
    mean = samples.mean(axis=1)
    nearest = np.searchsorted(donor_faces, donors)
    blend = _blend(mean, faces[donor_faces], added_faces, mean[np.minimum(nearest, len(donor_faces) - 1)])
    # The search has six dimensions: colour, and half the contrast of each channel, so that uniform faces are preferred.
    contrast = np.abs(samples - samples[:, :1]).max(axis=1)
    _, chosen = spatial.cKDTree(np.concatenate([samples[:, 0], 0.5 * contrast], axis=1)).query(np.pad(blend, ((0, 0), (0, 3))))
    return np.asarray(centroids[donor_faces[chosen]])


def _blend(of_faces: Floats, faces: Ints, added_faces: Ints, fallback: Floats) -> Floats:
    """Returns (b, k) values for added faces: continued from the vertices of `faces`, which have the mean of faces around them."""
    count = int(max(faces.max(initial=-1), added_faces.max(initial=-1))) + 1
    spread = of_faces
    for _ in range(2):  # the second pass averages over two rings, so that fine patterns of the texture become their mean
        sums, number = np.zeros((count, of_faces.shape[1])), np.zeros(count)
        for corner in faces.T:
            np.add.at(sums, corner, spread)
            np.add.at(number, corner, 1.0)
        values = sums / np.maximum(number, 1.0)[:, None]
        spread = values[faces].mean(axis=1)
    values[number == 0.0] = np.nan
    corners = _harmonic(values, added_faces, number > 0.0)[added_faces].mean(axis=1)
    return np.where(np.isfinite(corners), corners, fallback)


def _harmonic(values: Floats, added_faces: Ints, fixed: Bools) -> Floats:
    """Returns the values; those that are not `fixed` become harmonic on the added faces (`harmonic_values`)."""
    from ..filters.diffusion import harmonic_values

    vertices, index = np.unique(added_faces, return_inverse=True)
    continued = values.copy()
    continued[vertices] = harmonic_values(index.reshape(-1, 3), values[vertices], fixed[vertices])
    return continued
