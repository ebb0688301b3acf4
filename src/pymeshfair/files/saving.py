"""Writes a mesh to the staging folder; contents that the format cannot hold are named in warnings.

Textures have the bytes of the input, lie in the folder of the output, and never replace a file that no run wrote.
"""

import os
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np

from ..mesh_data import MeshData, Texture
from ..operating_system import this_system
from .errors import ContentsError, OutputError
from .formats import WRITABLE, Format, attributes_of, extension, load_function
from .outputs import material_path
from .provenance import recorded_digest, sha256_of
from .writing import StagedFile, to_disk


def stage_textures(
    textures: Sequence[Texture], output: Path, stage: Path, *, record: Mapping[str, Any] | None, own: bool = False
) -> tuple[list[StagedFile], tuple[Path, ...], dict[str, str]]:
    """Write the textures of a mesh to the staging folder; with `own` every name begins with that of the output.

    Returns:
        Those to put in place with the output, those that are already in place, and by the names of the textures what they are
        called beside the output.
    """
    files: list[StagedFile] = []
    reused: list[Path] = []
    names: dict[str, str] = {}
    for number, texture in enumerate(textures):
        name = _file_name(texture.name)
        if texture.image is None:
            names[texture.name] = name
            continue
        staged = stage / f"texture-{number}{Path(name).suffix or '.png'}"
        if isinstance(texture.image, bytes):
            staged.write_bytes(texture.image)
        else:
            shutil.copyfile(texture.image, staged)
        this_system().flush(staged)
        target, in_place = _free_target(
            output, f"{output.name}-{name}" if own else name, staged, record, {f.target for f in files}
        )
        names[texture.name] = target.name
        if in_place:
            reused.append(target)
        else:
            files.append(StagedFile(staged, target))
    return files, tuple(reused), names


def _file_name(name: str) -> str:
    """The last part of a texture's path, without characters that file systems refuse."""
    last = re.sub(r'[\x00-\x1f<>:"|?*]', "_", name.replace("\\", "/").rpartition("/")[2]).strip()
    return last if last.strip(".") else "texture.png"


def _free_target(output: Path, name: str, staged: Path, record: Mapping[str, Any] | None, taken: set[Path]) -> tuple[Path, bool]:
    """The path of a texture to write, and whether an identical file is there already."""
    names = [name, f"{output.stem}-{name}", *(f"{output.stem}-{k}-{name}" for k in range(2, 100))]
    digest = sha256_of(staged)
    for target in (output.with_name(n) for n in names):
        if target in taken or target == output:
            continue
        if not os.path.lexists(target):
            return target, False
        if target.is_file() and not target.is_symlink():
            there = sha256_of(target)
            if there == digest:
                return target, True
            if there == recorded_digest(record, target):
                return target, False
    raise OutputError(output, f"no free name for the texture {name!r} beside it; clear the folder, or name another")


#: the shares of a mean edge by which rounding may move a vertex: above the first is a warning, above the second an error
WORTH_A_WARNING, DESTROYED = 1e-3, 0.5


@dataclass(frozen=True)
class Saved:
    """The files written to the staging folder."""

    output: StagedFile
    side_files: tuple[StagedFile, ...]  # its textures and material file
    reused: tuple[Path, ...]  # textures of the output that were in place already
    warnings: tuple[str, ...]  # contents of the mesh that the file does not hold


@dataclass(frozen=True)
class Writing:
    """Input of a writer besides the mesh."""

    resolution: Callable[[], float]  # gives the length that coordinates must be able to tell apart
    textures: Mapping[str, str]  # by the names of the textures their names beside the output
    material_file: str  # the name of the material file beside the output
    materials: list[bytes]  # takes the bytes of the material file, if there is one
    extension: str = ""  # of the output


#: Writes a mesh without a matrix to an open file. Returns, in words, what is left out or otherwise than in the file that the mesh
#: comes from. Raises `ContentsError` if the format cannot hold the mesh, or needs a package that is missing.
Writer: TypeAlias = Callable[[MeshData, BinaryIO, Writing], tuple[str, ...]]


def save_mesh(
    mesh: MeshData,
    output: Path,
    stage: Path,
    *,
    resolution: Callable[[], float],
    record: Mapping[str, Any] | None = None,
    own_texture_names: bool = False,
) -> Saved:
    """Write a mesh to the staging folder, and flush it to the disk.

    Args:
        mesh: the mesh, without a matrix.
        output: where the file will go.
        stage: the staging folder.
        resolution: gives the mean edge, or the mean distance of points, that coordinates must be able to tell apart.
        record: the provenance of the former output, if that is to be replaced.
        own_texture_names: whether the names of textures begin with that of the output.

    Raises:
        OutputError: it could not be written, or its format would destroy the mesh.
    """
    kind = WRITABLE[extension(output)]
    warnings = _check_precision(kind, mesh, resolution, output)
    present = attributes_of(mesh)
    if not len(mesh.faces) and "edges" in present - kind.holds:
        raise OutputError(output, "the mesh is made of edges, of which the format holds none; .ply and .obj keep them")
    if lost := kind.lost(present):
        warnings.append(f"{output.name} does not hold the {_joined(lost)} of the mesh; .ply keeps them")
    source = mesh.source
    if source is not None and source.extras and (source.format != kind.extension or source.document is None):
        warnings.append(f"{output.name} does not hold of {source.path.name}: {'; '.join(source.extras)}")
    side_files: list[StagedFile] = []
    reused: tuple[Path, ...] = ()
    names: Mapping[str, str] = {}
    images = source.images if source is not None and source.format == kind.extension else ()
    if (mesh.textures or images) and "textures" in kind.holds and kind.extension != "glb":
        every = (*mesh.textures, *images)
        side_files, reused, names = stage_textures(every, output, stage, record=record, own=own_texture_names)
        missing = [texture.name for texture in every if texture.image is None]
        warnings += [f"the texture {name!r} does not exist; the output names it all the same" for name in missing]
    writing = Writing(resolution, names, material_path(output).name, [], extension(output))
    staged = stage / output.name
    write: Writer = load_function(kind.writer)
    with staged.open("xb") as file:
        try:
            warnings += [f"{output.name}: {note}" for note in write(mesh, file, writing)]
        except ContentsError as error:
            raise OutputError(output, str(error)) from error
        to_disk(file)
    if writing.materials:
        beside = StagedFile(material_path(staged), material_path(output))
        with beside.staged.open("xb") as file:
            file.writelines(writing.materials)
            to_disk(file)
        side_files.append(beside)
    return Saved(StagedFile(staged, output), tuple(side_files), reused, tuple(warnings))


def _check_precision(kind: Format, mesh: MeshData, resolve: Callable[[], float], output: Path) -> list[str]:
    """Whether the format can tell the vertices apart; raise `OutputError` if not, warn if it is close."""
    if kind.rounding == 0.0 or not (resolution := resolve()):
        return []
    rounding = float(np.abs(mesh.vertices).max()) * kind.rounding
    if rounding < WORTH_A_WARNING * resolution:
        return []
    effect = f"rounds coordinates of this size by up to {rounding:.2g}, and the mean edge is {resolution:.2g}"
    if rounding > DESTROYED * resolution:
        raise OutputError(output, f"the format {effect}; .ply keeps every digit")
    return [f"{output.name} {effect}; .ply keeps every digit"]


def _joined(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
