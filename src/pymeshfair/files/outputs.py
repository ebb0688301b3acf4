"""Checks the output files before a run, and writes the resulting mesh to the staging folder.

Textures keep the bytes of the input and go to the folder of the output; a .glb file contains its own. A texture replaces a file
only if a former run to this output wrote that file, and the file has not changed since.
"""

import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, BinaryIO, TypeAlias

import numpy as np

from ..mesh_data import MeshData, Texture
from .errors import ContentsError, OutputError
from .formats import MISSING_LASPY, WRITABLE, Format, attributes_of, extension, load_function
from .provenance import provenance_path, read_provenance, recorded_digest, sha256_of
from .writing import OVERWRITE, StagedFile, check_kind, check_place, stage_file, to_disk, undo_killed


@dataclass(frozen=True)
class MadeFrom:
    """The sources of an output. Runs with equal sources may replace each other's files."""

    input: Path
    recipe: str  # the SHA-256 digest of the recipe
    others: tuple[Path, ...] = ()  # the files of further layers
    unit: str | None = None  # the unit that the user gave

    def differs(self, record: Mapping[str, Any] | None) -> str | None:
        """Returns why a provenance record is not from a run with these sources, or None if it is."""
        if record is None:
            return "no provenance says that a run wrote it"
        source = Path(str(record["input"].get("path")))
        if not same_file(source, self.input) and record["input"].get("sha256") != sha256_of(self.input):
            return f"was made from another input, {source}"
        others = [Path(str(other.get("path"))) for other in record["input"].get("others", ())]
        if len(others) != len(self.others) or not all(map(same_file, others, self.others)):
            return "was made with other layers"
        if (record.get("recipe", {}).get("sha256"), record.get("options", {}).get("unit")) != (self.recipe, self.unit):
            return "was made by another recipe, or with other settings"
        return None


def check_output(output: Path, made_from: MadeFrom, *, overwrite: bool, makes_folder: bool = False) -> None:
    """Refuses an output that cannot be written; without `overwrite` also a file that was changed or has other sources."""
    check_kind(output, tuple(WRITABLE))
    if output.name.lower().endswith(".copc.laz"):
        raise OutputError(output, "COPC files are read and not written; name the output .laz")
    if extension(output) in ("las", "laz") and find_spec("laspy") is None:
        raise OutputError(output, MISSING_LASPY)
    files = [output, provenance_path(output), *([material_path(output)] if extension(output) == "obj" else [])]
    existing = [path for path in files if check_place(path, makes_folder=makes_folder)]
    if overwrite:
        return
    if output in existing and output.samefile(made_from.input):
        raise OutputError(output, f"it is the input; {OVERWRITE}")
    _check_former(existing, output, made_from)


def check_maps(maps: Sequence[Path], output: Path, made_from: MadeFrom, *, overwrite: bool) -> None:
    """Refuses maps of a run's changes as `check_output` does; the run's input and output cannot be maps."""
    existing = []
    for path in maps:
        check_kind(path, ("ply",))
        existing += [path] if check_place(path) else []
        if path == output or same_file(path, made_from.input):
            raise OutputError(path, "it is the input or the output of the run; name another file for the map")
    if not overwrite:
        _check_former(existing, output, made_from)


def _check_former(existing: Sequence[Path], output: Path, made_from: MadeFrom) -> None:
    """Refuses to replace files whose bytes no run with the same sources wrote; before that, undoes the moves of killed runs."""
    record = read_provenance(output)
    for path in existing:
        reason, digest = made_from.differs(record), recorded_digest(record, path)
        if reason is None and not path.name.endswith(".provenance.json") and sha256_of(path) != digest:
            reason = "has been changed since a run wrote it" if digest else "is not from the last run that wrote the output"
        if reason and undo_killed(path.parent):
            _check_former([*filter(os.path.lexists, existing)], output, made_from)
            return
        if reason:
            raise OutputError(path, f"it exists and {reason}; {OVERWRITE}")


def same_file(one: Path, other: Path) -> bool:
    """Returns whether two paths lead to one file."""
    return one == other or (one.exists() and other.exists() and one.samefile(other))


def material_path(output: Path) -> Path:
    """Returns the path of the material file beside an OBJ file."""
    return output.with_name(f"{output.name}.mtl")


def stage_textures(
    textures: Sequence[Texture], output: Path, stage: Path, *, record: Mapping[str, Any] | None, own_texture_names: bool = False
) -> tuple[list[StagedFile], tuple[Path, ...], dict[str, str]]:
    """Writes textures to the staging folder; with `own_texture_names` their names begin with the name of the output.

    Returns the files to put in place, the textures already in place, and by texture name the file name beside the output.
    """
    files: list[StagedFile] = []
    reused: list[Path] = []
    names: dict[str, str] = {}
    comments = r"|(?<!\S)#" if extension(output) == "obj" else ""  # "#" begins a comment in OBJ files
    for number, texture in enumerate(textures):
        last = re.sub(r'[\x00-\x1f<>:"|?*]' + comments, "_", texture.name.replace("\\", "/").rpartition("/")[2]).strip()
        name = names[texture.name] = last if last.strip(".") else "texture.png"
        if texture.image is None:
            continue
        staged = stage / f"texture-{number}{Path(name).suffix or '.png'}"
        stage_file(staged, output, texture.image.read_bytes() if isinstance(texture.image, Path) else texture.image)
        wished = f"{output.name}-{name}" if own_texture_names else name
        images = [t.image for t in textures if isinstance(t.image, Path)]
        target, in_place = _free_target(output, wished, staged, record, {*reused, *(f.target for f in files)}, images)
        names[texture.name] = target.name
        reused += [target] if in_place else []
        files += [] if in_place else [StagedFile(staged, target)]
    return files, tuple(reused), names


def _free_target(
    output: Path, name: str, staged: Path, record: Mapping[str, Any] | None, taken: set[Path], images: Sequence[Path]
) -> tuple[Path, bool]:
    digest = sha256_of(staged)
    for before in ("", f"{output.stem}-", *(f"{output.stem}-{k}-" for k in range(2, 100))):
        target = output.with_name(before + name)
        if target in taken or target == output:
            continue
        if not os.path.lexists(target):
            return target, False
        if target.is_file() and not target.is_symlink():
            former_digest = sha256_of(target)
            if former_digest == digest:
                return target, True
            if former_digest == recorded_digest(record, target) and not any(same_file(target, image) for image in images):
                return target, False
    raise OutputError(output, f"no free name for the texture {name!r} in its folder; clear the folder, or name another output")


WORTH_A_WARNING, DESTROYED = 1e-3, 0.5  # limits of the rounding of vertices, as shares of the resolution, see `save_mesh`


@dataclass(frozen=True)
class Saved:
    """The files written to the staging folder."""

    output: StagedFile
    side_files: tuple[StagedFile, ...]  # its textures and material file
    reused: tuple[Path, ...]  # textures of the output that were in place already
    warnings: tuple[str, ...]  # on contents left out, rounded coordinates and missing textures


@dataclass(frozen=True)
class Writing:
    """Input of a writer besides the mesh."""

    resolution: Callable[[], float]  # returns the length that coordinates must resolve
    textures: Mapping[str, str]  # by texture name, the file name beside the output
    material_file: str  # the name of the material file beside the output
    materials: list[bytes]  # the writer appends the bytes of the material file, if any
    extension: str = ""  # of the output


#: Writes a mesh, whose `matrix` is None, to a file. Returns notes on contents left out or unlike those of the source file.
#: Raises `ContentsError` if the format cannot hold the mesh, or needs a package that is missing.
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
    """Writes a mesh, whose `matrix` is None, to the staging folder, for `output`, and flushes it to the disk.

    `resolution` returns the mean edge, or the mean distance of points; `record` is the provenance of the replaced output.
    """
    kind = WRITABLE[extension(output)]
    warnings = _check_precision(kind, mesh, resolution, output)
    present = attributes_of(mesh)
    if "faces" not in kind.holds and mesh.writes_normals:  # computed from the faces, which the format cannot hold
        mesh = mesh.with_attributes({"normals": mesh.vertex_normals})
    if not len(mesh.faces) and "edges" in present - kind.holds:
        raise OutputError(output, "the mesh is made of edges, which the format cannot hold; .ply and .obj keep them")
    if lost := kind.lost(present):
        words = " and ".join(filter(None, (", ".join(lost[:-1]), lost[-1])))
        warnings.append(f"{output.name} does not hold the {words} of the mesh; .ply keeps them")
    source = mesh.source
    if source is not None and source.extras and (source.format != kind.extension or source.document is None):
        warnings.append(without_extras(output, source.path, source.extras))
    images = source.images if source is not None and source.format == kind.extension else ()
    every = (*mesh.textures, *images) if "textures" in kind.holds and kind.extension != "glb" else ()
    side_files, reused, names = stage_textures(every, output, stage, record=record, own_texture_names=own_texture_names)
    warnings += [f"the texture {t.name!r} does not exist; the output still refers to it" for t in every if t.image is None]
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
        side_files.append(stage_file(material_path(staged), material_path(output), b"".join(writing.materials)))
    return Saved(StagedFile(staged, output), tuple(side_files), reused, tuple(warnings))


def without_extras(output: Path, source: Path, extras: Sequence[str]) -> str:
    """Returns the warning that an output lacks contents of its input."""
    return f"{output.name} does not hold these contents of {source.name}: {'; '.join(extras)}"


def _check_precision(kind: Format, mesh: MeshData, resolve: Callable[[], float], output: Path) -> list[str]:
    if kind.rounding == 0.0 or not (resolution := resolve()):
        return []
    rounding = float(np.abs(mesh.vertices).max()) * kind.rounding
    if rounding < WORTH_A_WARNING * resolution:
        return []
    effect = f"rounds coordinates of this size by up to {rounding:.2g}, and vertices are about {resolution:.2g} apart"
    if rounding > DESTROYED * resolution:
        raise OutputError(output, f"the format {effect}; .ply keeps every digit")
    return [f"{output.name} {effect}; .ply keeps every digit"]
