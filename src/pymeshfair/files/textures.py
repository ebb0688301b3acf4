"""Textures beside an output: byte for byte those of the input, in the output's folder alone, never over a file that no run wrote.

MeshLab itself writes where a material file points (``../evil.png`` lands above the output), encodes unchanged images anew, over
their source if that is where the output goes, and writes a placeholder for a texture that does not exist.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .announced import Announced
from .errors import OutputError
from .provenance import recorded_digest, sha256_of
from .writing import StagedFile

#: the name under which MeshLab keeps its placeholder for a texture that it did not find
PLACEHOLDER = "dummy.png"
#: the kinds of image that MeshLab writes
_ENCODED = frozenset((".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"))


@dataclass(frozen=True)
class TexturePlan:
    """What to do about the textures of a mesh.

    Attributes:
        files: those to put in place with the output.
        reused: those that are already in place.
        new_names: the names that MeshLab writes into the output, and what must stand there instead.
        missing: the textures that the input names and that do not exist.
    """

    files: tuple[StagedFile, ...]
    reused: tuple[Path, ...]
    new_names: Mapping[str, str]
    missing: tuple[str, ...]


def stage_textures(
    images: Mapping[str, Any],
    announced: Announced,
    output: Path,
    stage: Path,
    *,
    changed: bool,
    record: Mapping[str, Any] | None,
    own: bool = False,
) -> TexturePlan:
    """Write the textures of a mesh to the staging folder.

    Args:
        images: the textures of the mesh by name, from pymeshlab's ``Mesh.textures()``.
        announced: what the input named.
        output: the file that will name them.
        stage: the staging folder.
        changed: whether a step may have painted on textures that came with the input.
        record: the provenance of the former output, if that is to be replaced.
        own: whether every name begins with that of the output.
    """
    known = {t.given: t for t in announced.textures}
    missing = tuple(t.name for t in announced.textures if t.file is None)
    unread = [t for t in announced.textures if t.given not in images]
    files: list[StagedFile] = []
    reused: list[Path] = []
    new_names: dict[str, str] = {}
    for number, (name, image) in enumerate(images.items()):
        texture = unread[0] if name == PLACEHOLDER and unread else known.get(name)
        meant = name if texture is None else texture.name
        if texture is not None and texture.file is None:
            new_names[name] = _file_name(meant)
            continue
        staged = stage / f"texture-{number}{Path(_file_name(meant)).suffix or '.png'}"
        if texture is not None and texture.file is not None and not changed:
            shutil.copyfile(texture.file, staged)
        else:
            if staged.suffix.lower() not in _ENCODED:
                staged = staged.with_suffix(".png")
                meant += ".png"
            image.save(str(staged))
        name_there = f"{output.name}-{_file_name(meant)}" if own else _file_name(meant)
        target, in_place = _free_target(output, name_there, staged, record, {f.target for f in files})
        new_names[name] = target.name
        if in_place:
            reused.append(target)
        else:
            files.append(StagedFile(staged, target))
    changes = {old: new for old, new in new_names.items() if old != new}
    return TexturePlan(tuple(files), tuple(reused), changes, missing)


def _file_name(name: str) -> str:
    """The last part of a texture's path, without characters that file systems refuse."""
    last = re.sub(r'[\x00-\x1f<>:"|?*]', "_", name.replace("\\", "/").rpartition("/")[2]).strip()
    return last if last.strip(".") else "texture.png"


def _free_target(output: Path, name: str, staged: Path, record: Mapping[str, Any] | None, taken: set[Path]) -> tuple[Path, bool]:
    """Where a texture is to be written, and whether an identical file is there already."""
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


def rename_in_materials(path: Path, new_names: Mapping[str, str]) -> None:
    """Give textures other names in a material file that MeshLab wrote."""
    lines = path.read_bytes().split(b"\n")
    changed = {b"map_Kd " + os.fsencode(old): b"map_Kd " + os.fsencode(new) for old, new in new_names.items()}
    path.write_bytes(b"\n".join(changed.get(line.rstrip(), line) for line in lines))


def rename_in_ply(path: Path, header_size: int, new_names: Mapping[str, str]) -> None:
    """Give textures other names in the header of a PLY file."""
    fresh = path.with_name(f"{path.name}.renamed")
    with path.open("rb") as source, fresh.open("xb") as target:
        lines = source.read(header_size).split(b"\n")
        word = b"comment TextureFile "
        changed = {word + os.fsencode(old): word + os.fsencode(new) for old, new in new_names.items()}
        target.write(b"\n".join(changed.get(line.rstrip(), line) for line in lines))
        shutil.copyfileobj(source, target, 1 << 20)
    fresh.replace(path)
