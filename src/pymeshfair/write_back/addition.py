"""Carries out the part of an `Edit` that adds vertices and faces, and gives them what the edit leaves open."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Edit, Floats, Ints
from ..errors import MeshError
from ..mesh_data import Texture
from ..mesh_data.continuation import continued_face_colors, continued_texture, continued_vertex_colors, find_donors, read_pixels
from .arrays import read_array
from .attributes import ELEMENTS, bring_in, check_names, clear_beyond
from .growth import check_growable, grow
from .workbench import Workbench

TRIANGULATED = "the mesh had polygons and no triangle; it has triangles alone now"


def add_elements(bench: Workbench, mesh: Any, edit: Edit) -> tuple[Edit, tuple[str, ...]]:
    """Add the edit's vertices and faces to the current layer, which has faces and no matrix.

    Returns:
        An edit of the larger mesh that says all that remains to be written, coordinates and selection among it, and sentences
        about what could not be kept.

    Raises:
        MeshError: the mesh has elements that MeshLab would not keep, or attributes that it cannot compute with.
    """
    check_growable(mesh)
    check_names(bench, mesh)
    vertices = read_array(mesh, "vertices") if edit.vertices is None else edit.vertices
    faces = read_array(mesh, "faces")
    added_vertices = np.empty((0, 3)) if edit.added_vertices is None else edit.added_vertices
    added_faces = np.empty((0, 3), dtype=np.int32) if edit.added_faces is None else edit.added_faces
    points = np.concatenate([vertices, added_vertices])
    uv = mesh.vertex_tex_coord_matrix() if mesh.has_vertex_tex_coord() else None
    wedges = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2) if mesh.has_wedge_tex_coord() else None
    selection = {element: read_array(mesh, f"{element}_selection") for element in ELEMENTS}
    may_give = np.ones(len(faces), dtype=np.bool_) if wedges is None else _textured(bench, mesh, wedges, faces, added_faces)
    donors = find_donors(points, faces, added_faces, len(vertices), may_give)

    remaining: dict[str, Any] = {"vertices": points, "added_vertices": None, "added_faces": None}
    for element, of in zip(ELEMENTS, (donors.vertices, donors.faces), strict=True):
        chosen = np.append(selection[element], np.zeros(len(of), dtype=np.bool_))
        remaining[f"{element}_selection"] = chosen if (given := getattr(edit, f"{element}_selection")) is None else given
        if getattr(edit, f"{element}_scalars") is None and getattr(mesh, f"has_{element}_scalar")():
            before = read_array(mesh, f"{element}_scalars")
            remaining[f"{element}_scalars"] = np.concatenate([before, before[of]])
    if edit.vertex_colors is None and mesh.has_vertex_color():
        before = read_array(mesh, "vertex_colors")
        remaining["vertex_colors"] = continued_vertex_colors(before, added_faces, donors.vertices)
    if edit.face_colors is None and mesh.has_face_color():
        before = read_array(mesh, "face_colors")
        remaining["face_colors"] = continued_face_colors(before, faces, added_faces, len(vertices), donors.faces)
    shown = None
    if wedges is not None and len(added_faces):
        # Which of several images an index means pymeshlab does not tell.
        image = next(iter(mesh.textures().values())) if mesh.texture_number() == 1 else None
        shown = continued_texture(_pixels(image), wedges, faces, added_faces, may_give, donors.faces)

    seed, triangulated = grow(bench, mesh, len(added_vertices), added_faces, may_give)
    clear_beyond(bench, mesh, "vertex", len(vertices))
    clear_beyond(bench, mesh, "face", len(faces))
    if wedges is not None:
        write_wedge_uv(bench, mesh, wedges, np.empty((0, 2)) if shown is None else shown, seed)
        if uv is None:  # MeshLab has given it some on the way
            uv = np.zeros((len(vertices), 2))
            uv[faces.ravel()[::-1]] = wedges.reshape(-1, 2)[::-1]
    if uv is not None:
        write_vertex_uv(bench, mesh, np.concatenate([uv, uv[donors.vertices]]))
    return replace(edit, **remaining), (TRIANGULATED,) if triangulated else ()


def _textured(bench: Workbench, mesh: Any, wedges: Floats, faces: Ints, added_faces: Ints) -> Bools:
    """(m,) the faces that have the texture which most vertices of the rim have, and finite texture coordinates."""
    finite: Bools = np.all(np.isfinite(wedges), axis=(1, 2), out=np.empty(len(wedges), dtype=np.bool_))
    candidates: list[Bools] = [finite]
    if mesh.texture_number() > 1:
        candidates = []
        for index in range(mesh.texture_number()):
            bench.apply("compute_selection_by_condition_per_face", condselect=f"ti=={index}")
            candidates.append(np.logical_and(finite, read_array(mesh, "face_selection")))
    used = np.unique(added_faces)
    shares = [np.isin(used, faces[those]).sum() + those.any() for those in candidates]
    best = candidates[int(np.argmax(shares))]
    everywhere: Bools = np.ones(len(faces), dtype=np.bool_)
    return best if best.any() else everywhere


def _pixels(image: Any) -> NDArray[np.uint8] | None:
    """(height, width, 3) the pixels of pymeshlab's image, from the top; None if it has none."""
    if image is None or not (image.width() and image.height()):
        return None
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "texture.ppm"
        image.save(str(file))
        return read_pixels(Texture("", file)) if file.exists() else None


def write_vertex_uv(bench: Workbench, mesh: Any, uv: Floats) -> None:
    """Make the texture coordinates of the vertices these, (n, 2)."""
    if np.array_equal(mesh.vertex_tex_coord_matrix(), uv, equal_nan=True):
        return
    u, v = bring_in(bench, mesh, "vertex", list(uv.T))
    bench.apply("compute_texcoord_by_function_per_vertex", u=u, v=v, onselected=False)
    if not np.array_equal(mesh.vertex_tex_coord_matrix(), uv, equal_nan=True):
        raise MeshError(f"MeshLab did not take the texture coordinates of {mesh.label()!r} exactly; please report this mesh")


def write_wedge_uv(bench: Workbench, mesh: Any, wedges: Floats, uv: Floats, seed: int) -> None:
    """Give added faces one place of the texture each, and the seed its own again."""
    old = len(wedges)
    columns = np.concatenate([np.zeros((old, 2)), uv])
    bench.apply("compute_selection_by_condition_per_face", condselect=f"fi>={old}||fi=={seed}")
    u, v = bring_in(bench, mesh, "face", list(columns.T))
    own = np.where(np.isfinite(wedges[seed]), wedges[seed], 0.0)
    expressions = {
        f"{axis}{corner}": f"fi=={seed}?{float(own[corner, column])!r}:{name}"
        for corner in range(3)
        for column, (axis, name) in enumerate((("u", u), ("v", v)))
    }
    bench.apply("compute_texcoord_by_function_per_wedge", **expressions, onselected=True)
    written = mesh.wedge_tex_coord_matrix().reshape(-1, 3, 2)
    if not np.array_equal(written, np.concatenate([wedges, np.repeat(uv[:, None], 3, axis=1)]), equal_nan=True):
        raise MeshError(f"MeshLab did not take the texture coordinates of {mesh.label()!r} exactly; please report this mesh")
