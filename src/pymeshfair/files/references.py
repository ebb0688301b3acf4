"""The files that a mesh file names: confined to its folder, and checked before anything opens them.

A scan comes from anywhere, and what it names is copied beside the output. So a name leads only to regular files in the folder
of the mesh, links resolved, and a texture is an image by its content.
"""

import os
import stat
import warnings
from pathlib import Path
from typing import BinaryIO

from .errors import InputError

#: the kinds of image that MeshLab reads, in Pillow's names
IMAGES = ("PNG", "JPEG", "BMP", "GIF", "TIFF", "PPM", "XBM", "XPM", "WEBP")
#: pixels of the largest texture, 16,384 x 16,384: as pixels in memory it takes 1 GB
LARGEST_IMAGE = 1 << 28
#: above so many pixels, 128 MB in memory, a file has at least a byte for so many of them, unless it is of one colour
_SMALL_IMAGE, _PIXELS_A_BYTE = 1 << 25, 256


class References:
    """Finds what one mesh file names.

    Args:
        mesh: the mesh file; names are relative to its folder.
        allow_outside: let names lead out of that folder.
    """

    def __init__(self, mesh: Path, *, allow_outside: bool = False) -> None:
        self.mesh = mesh
        self._folder = mesh.parent.resolve()
        self._allow_outside = allow_outside

    def find(self, name: str) -> Path | None:
        """The file of that name, links not resolved, or None if there is none."""
        if "\0" in name or not name.strip():
            return None
        path = self.mesh.parent / name
        if not os.path.lexists(path):
            return None
        check_regular(path, self.mesh)
        if not (self._allow_outside or path.resolve().is_relative_to(self._folder)):
            raise InputError(
                self.mesh,
                f"it names the file {shown(name)}, which is outside its folder; put it beside the mesh, or give --allow-outside",
            )
        return path

    def find_image(self, name: str) -> Path | None:
        """The image of that name or, as other systems write paths, of its last part beside the mesh; None if there is none."""
        last = name.replace("\\", "/").rpartition("/")[2]
        # A path of the scanner's machine means the file of that name beside the mesh.
        path = self.find(name) or self.find(last)
        if path is not None:
            check_image(path, self.mesh, path.name)
        return path


def check_regular(path: Path, mesh: Path) -> None:
    """Refuse a path that is no readable regular file; `mesh` is the input: the same path, or the file that names it."""
    named = "" if path == mesh else f"{shown(str(path))}, which it names, "
    try:
        mode = path.stat().st_mode
    except OSError as error:
        reason = "there is no such file" if isinstance(error, FileNotFoundError) else (error.strerror or str(error)).lower()
        raise InputError(mesh, f"{named}{reason}") from error
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "a pipe" if stat.S_ISFIFO(mode) else "a device or a socket"
        raise InputError(mesh, f"{named or 'it '}is {kind} and no file")
    if not os.access(path, os.R_OK):
        raise InputError(mesh, f"{named or 'it '}cannot be read for want of permission")


def check_image(source: Path | BinaryIO, mesh: Path, name: str) -> None:
    """Refuse a texture of that name that is no image by its content, or one of more than `LARGEST_IMAGE` pixels."""
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow's own idea of too large an image
            with Image.open(source, formats=IMAGES) as image:
                width, height = image.size
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError) as error:
        why = f"is no image that MeshLab reads ({', '.join(IMAGES)}), or too large a one"
        raise InputError(mesh, f"the texture {shown(name)} {why}") from error
    size = source.stat().st_size if isinstance(source, Path) else source.seek(0, os.SEEK_END)
    most = min(LARGEST_IMAGE, max(_SMALL_IMAGE, _PIXELS_A_BYTE * size))
    if width * height > most:
        why = f"has {width:,} x {height:,} pixels; in {size:,} bytes {most:,} are the most"
        raise InputError(mesh, f"the texture {shown(name)} {why}")


def shown(name: str, length: int = 80) -> str:
    """A name from a file as a message gives it: short, in quotes, and without a control character that a terminal would obey."""
    return repr(name if len(name) <= length else f"{name[:length]}...")
