"""Textures beside an output: the bytes of the input, in the folder of the output, never over a file that no run wrote."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..mesh_data import Texture
from ..operating_system import this_system
from .errors import OutputError
from .provenance import recorded_digest, sha256_of
from .writing import StagedFile


@dataclass(frozen=True)
class TexturePlan:
    """What to do about the textures of a mesh.

    Attributes:
        files: those to put in place with the output.
        reused: those that are already in place.
        names: by the names of the textures what they are called beside the output.
        missing: the names of the textures that do not exist.
    """

    files: tuple[StagedFile, ...]
    reused: tuple[Path, ...]
    names: Mapping[str, str]
    missing: tuple[str, ...]


def stage_textures(
    textures: Sequence[Texture], output: Path, stage: Path, *, record: Mapping[str, Any] | None, own: bool = False
) -> TexturePlan:
    """Write the textures of a mesh to the staging folder.

    Args:
        textures: of the mesh.
        output: the file that will name them.
        stage: the staging folder.
        record: the provenance of the former output, if that is to be replaced.
        own: whether every name begins with that of the output.
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
    missing = tuple(texture.name for texture in textures if texture.image is None)
    return TexturePlan(tuple(files), tuple(reused), names, missing)


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
