"""Writes the mesh to the staging folder; what the format cannot keep is named in a warning."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..operating_system import this_system
from .announced import Announced
from .errors import OutputError
from .formats import ATTRIBUTES, WRITABLE, Format, extension
from .outputs import material_path
from .ply import PlyError, read_header
from .ply_edges import append_edges
from .textures import rename_in_materials, rename_in_ply, stage_textures
from .verification import TornFileError, verify_file
from .writing import StagedFile

#: the custom attribute by which a run follows elements; no file gets it
UNSAVED = "pymeshfair_origin"
#: the shares of a mean edge by which rounding may move a vertex: above the first a warning is given, above the second an error
WORTH_A_WARNING, DESTROYED = 1e-3, 0.5


@dataclass(frozen=True)
class Saved:
    """What was written to the staging folder.

    Attributes:
        output: the mesh file.
        side_files: its textures and material file.
        reused: textures of the output that were in place already.
        warnings: what the file does not hold of the mesh.
    """

    output: StagedFile
    side_files: tuple[StagedFile, ...]
    reused: tuple[Path, ...]
    warnings: tuple[str, ...]


def save_mesh(
    meshes: Any,
    announced: Announced,
    output: Path,
    stage: Path,
    *,
    resolution: Callable[[], float],
    changed: bool,
    began: Set[str],
    textures_changed: bool,
    record: Mapping[str, Any] | None,
    own_texture_names: bool = False,
) -> Saved:
    """Write the current mesh to the staging folder, check that it is whole there, and flush it to the disk.

    Args:
        meshes: the mesh set.
        announced: what the input was found to have.
        output: where the file will go; its name is that of the staged file, too, since MeshLab writes it into some files.
        stage: the staging folder.
        resolution: gives the mean edge, or the mean distance of points, that coordinates must be able to tell apart.
        changed: whether any step was taken.
        began: which of `ATTRIBUTES` the mesh had as it was read.
        textures_changed: whether a step may have painted on a texture.
        record: the provenance of the former output, if that is to be replaced.
        own_texture_names: whether the names of textures begin with that of the output.

    Raises:
        OutputError: MeshLab could not write the file, it is not whole, or its format would destroy the mesh.
    """
    mesh = meshes.current_mesh()
    kind = WRITABLE[extension(output)]
    warnings = _check_precision(kind, mesh, resolution, output)
    present = attributes_of(meshes, announced, began)
    if mesh.face_number() == 0 and "edges" in present - kind.holds:
        raise OutputError(output, "the mesh is made of edges, of which the format holds none; .ply and .obj keep them")
    options = dict(kind.options)
    holds = kind.holds
    if kind.extension == "off" and "vertex colours" in present:
        holds -= {"vertex normals"}  # MeshLab writes the colours before them, and every reader takes these for normals
    if "vertex normals" in kind.holds:
        options["save_vertex_normal"] = "vertex normals" in present & holds
        if "vertex normals" in present & holds and mesh.face_number() and changed:
            _normalise_normals(meshes)
    if "custom attributes" in kind.holds:
        options |= dict.fromkeys(_custom_attributes(meshes), True)
    staged = stage / output.name
    heard, meshes.on_note = meshes.on_note, lambda note: None  # what is lost is told below
    try:
        meshes.save_current_mesh(str(staged), save_textures=False, **options)
    except Exception as error:  # pymeshlab raises several unrelated types
        raise OutputError(output, f"MeshLab could not write it: {' '.join(str(error).split())}") from error
    finally:
        meshes.on_note = heard
    if kind.extension == "ply" and "edges" in present:
        try:
            append_edges(staged, mesh.edge_matrix(), mesh.vertex_number())
        except (PlyError, OSError) as error:
            raise OutputError(output, f"its edges could not be written: {error}") from error
    lost = [a for a in ATTRIBUTES if a in present - holds]
    if lost:
        warnings.append(f"{output.name} does not hold the {_joined(lost)} of the mesh; .ply keeps them")
    try:
        verify_file(staged, mesh.vertex_number(), mesh.face_number())
    except TornFileError as error:
        raise OutputError(output, f"what was written is not whole: {error}; is the disk full?") from error

    side_files: list[StagedFile] = []
    reused: tuple[Path, ...] = ()
    material = material_path(staged)
    if "textures" in present & kind.holds:
        plan = stage_textures(
            mesh.textures(), announced, output, stage, changed=textures_changed, record=record, own=own_texture_names
        )
        if kind.extension == "ply":
            rename_in_ply(staged, read_header(staged).size, plan.new_names)
        elif material.exists():
            rename_in_materials(material, plan.new_names)
        side_files += plan.files
        reused = plan.reused
        warnings += [f"the texture {name!r} does not exist; the output names it all the same" for name in plan.missing]
    if material.exists():
        side_files.append(StagedFile(material, material_path(output)))
    for file in (staged, *(f.staged for f in side_files)):
        this_system().flush(file)
    return Saved(StagedFile(staged, output), tuple(side_files), reused, tuple(warnings))


def attributes_of(meshes: Any, announced: Announced, began: Set[str] | None = None) -> set[str]:
    """Which of `ATTRIBUTES` the current mesh has; `began` are those it had as it was read, None while it is read."""
    mesh = meshes.current_mesh()
    has_faces, has_edges = mesh.face_number() > 0, mesh.edge_number() > 0
    if has_edges and not has_faces:
        # Normals of a curve count if the file gave them; those of MeshLab's sections are sums over the faces that were cut.
        normals = announced.normals and (began is None or ("edges" in began and "faces" not in began))
    else:
        normals = announced.normals or (not has_faces and bool(mesh.vertex_normal_matrix().any()))
    wedges = has_faces and mesh.has_wedge_tex_coord()
    present = {
        "faces": has_faces,
        "edges": has_edges,
        "vertex normals": normals,
        "vertex colours": mesh.has_vertex_color(),
        "vertex scalars": mesh.has_vertex_scalar(),
        # MeshLab computes texture coordinates of vertices and wedges together; where wedges have them, only the file's own count.
        "vertex texture coordinates": mesh.has_vertex_tex_coord() and (announced.vertex_texture or not wedges),
        "face colours": has_faces and mesh.has_face_color(),
        "face scalars": has_faces and mesh.has_face_scalar(),
        "wedge texture coordinates": wedges,
        "textures": mesh.texture_number() > 0,
        "custom attributes": bool(_custom_attributes(meshes)),
        "vertex opacities": mesh.has_vertex_color() and bool((mesh.vertex_color_matrix()[:, 3] != 1.0).any()),
        "face opacities": has_faces and mesh.has_face_color() and bool((mesh.face_color_matrix()[:, 3] != 1.0).any()),
        "vertex radii": announced.radii,
    }
    return {name for name, there in present.items() if there}


def _custom_attributes(meshes: Any) -> list[str]:
    """The parameters that save custom attributes, which MeshLab lists only among those of saving a PLY file."""
    return [name for name in meshes.filter_parameter_values("ply") if name.startswith("__ca_") and not name.endswith(UNSAVED)]


def _normalise_normals(meshes: Any) -> None:
    """Make normals unit vectors: MeshLab leaves sums of face normals after some filters."""
    lengths = np.linalg.norm(meshes.current_mesh().vertex_normal_matrix(), axis=1)
    if np.any(np.abs(lengths[lengths > 0] - 1) > 1e-6):
        meshes.apply_filter("apply_normal_normalization_per_vertex")


def _check_precision(kind: Format, mesh: Any, resolve: Callable[[], float], output: Path) -> list[str]:
    """Whether the format can tell the vertices apart; raise `OutputError` if not, warn if it is close."""
    if kind.rounding == (0.0, 0.0) or not (resolution := resolve()):
        return []
    relative, absolute = kind.rounding
    rounding = float(np.abs(mesh.vertex_matrix()).max()) * relative + absolute
    if rounding < WORTH_A_WARNING * resolution:
        return []
    told = f"rounds coordinates of this size by up to {rounding:.2g}, and the mean edge is {resolution:.2g}"
    if rounding > DESTROYED * resolution:
        raise OutputError(output, f"the format {told}; .ply keeps every digit")
    return [f"{output.name} {told}; .ply keeps every digit"]


def _joined(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
