"""What MeshLab is given to read in place of a file that names others, or that its reader would understand otherwise than we do.

It lies in a folder of its own with the files that it names, each under a plain name: nothing that a mesh file says leads MeshLab
anywhere else.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from .errors import ContentsError, OutputError
from .references import References, Texture

#: textures of one mesh
MOST_TEXTURES = 1000


class Given:
    """The folder of what MeshLab is given.

    Args:
        folder: an existing one; files of these names must not be there yet.
        mesh: the input.
    """

    def __init__(self, folder: Path, mesh: Path) -> None:
        """See the class."""
        self.folder = folder
        self.path = folder / mesh.name

    def write(self, *parts: bytes | memoryview) -> Path:
        """Write what stands for the mesh file, and return its path."""
        return self.write_beside(self.path.name, *parts)

    def write_beside(self, name: str, *parts: bytes | memoryview) -> Path:
        """Write a file beside it, and return its path.

        Raises:
            OutputError: there is no room for it.
        """
        path = self.folder / name
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with path.open("xb") as file:
                for part in parts:
                    file.write(part)
        except OSError as error:
            raise OutputError(path, f"MeshLab needs a copy of the input there: {error.strerror or error}") from error
        return path

    def offer(self, suffix: str, parts: Sequence[bytes] | None) -> Path | None:
        """Write what MeshLab would read sooner than the file itself; None if there is nothing, or no room for it."""
        if parts is None:
            return None
        name = self.path.with_suffix(suffix).name
        try:
            return self.write_beside(name, *parts)
        except OutputError:
            with suppress(OSError):
                (self.folder / name).unlink()
            return None

    def link(self, textures: Iterable[Texture]) -> None:
        """Put the textures that exist beside it, under their given names."""
        self.folder.mkdir(parents=True, exist_ok=True)
        for texture in textures:
            if texture.file is None:
                continue
            link = self.folder / texture.given
            try:
                link.symlink_to(texture.file.resolve())
            except OSError:  # Windows, without the right to make links
                shutil.copyfile(texture.file, link)


def find_textures(names: Iterable[str], references: References) -> tuple[Texture, ...]:
    """The textures of these names, each with a plain one.

    Raises:
        ContentsError: they are too many.
        InputError: one of them must not be opened, or is no image.
    """
    found = []
    unique = list(dict.fromkeys(names))
    if len(unique) > MOST_TEXTURES:
        raise ContentsError(f"it names {len(unique):,} textures; {MOST_TEXTURES:,} are the most")
    for number, name in enumerate(unique):
        file = references.find_image(name)
        suffix = "" if file is None else file.suffix
        found.append(Texture(name, file, f"texture-{number}{suffix if suffix[1:].isalnum() and suffix.isascii() else '.png'}"))
    return tuple(found)
