"""Reads a mesh file, whatever its format, as a `MeshData`; finds the files that it names.

A scan comes from anywhere, and what it names is copied beside the output. So a name leads only to regular files in the
folder of the mesh, links resolved, and a texture is an image by its content.
"""

import os
import re
import stat
import warnings
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO, TypeAlias

import numpy as np

from ..filters.mesh import bounding_box
from ..mesh_data import MeshData
from .errors import ContentsError, InputError
from .formats import READABLE, UNCHECKED, extension, listed, load_function

#: the kinds of image that MeshLab reads, in Pillow's names
IMAGES = ("PNG", "JPEG", "BMP", "GIF", "TIFF", "PPM", "XBM", "XPM", "WEBP")
#: pixels of the largest texture, 16,384 x 16,384: as pixels in memory it takes 1 GB
LARGEST_IMAGE = 1 << 28
#: above so many pixels, 128 MB in memory, a file has at least a byte for so many of them, unless it is of one colour
_SMALL_IMAGE, _PIXELS_A_BYTE = 1 << 25, 256


class References:
    """Finds what one mesh file names, relative to its folder; with `allow_outside` names may lead out of that."""

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


#: of a text that ends within a line
NO_END = "its last line has no end: if the file was cut short, so was perhaps its last number"


@dataclass(frozen=True, eq=False)
class Reading:
    """A mesh file that was read."""

    mesh: MeshData
    doubts: tuple[str, ...] = ()  # sentences that the user should read about it
    side_files: tuple[Path, ...] = ()  # the files that belong to it; of a reader, without the images of textures


def unended(text: bytes) -> tuple[str, ...]:
    """The doubt about a text that ends within a line: its last number may be the beginning of a longer one."""
    return () if text.endswith((b"\n", b"\r", b"\x1a")) else (NO_END,)


MOST_TEXTURES = 1000
#: Reads a file and what it names. Raises `ContentsError` if the file is damaged or none of its format, or a package is missing;
#: `InputError` if it names a file that must not be opened; `OSError` if it cannot be read.
Reader: TypeAlias = Callable[[Path, References], Reading]
#: the first bytes of a text in UTF-16, and the formats that may be in it
_UTF_16, _ANY_ENCODING = re.compile(rb"\xff\xfe[\t-~]\0|\xfe\xff\0[\t-~]"), ("gltf", "dae", "x3d")


def check_input(path: Path, formats: Collection[str] = (*READABLE, *UNCHECKED)) -> None:
    """Refuse a path that is no mesh file of one of the formats, by its name and kind, without opening it."""
    check_regular(path, path)
    if path.stat().st_size == 0:
        raise InputError(path, "it is empty")
    if extension(path) not in formats:
        what = f"{path.suffix!r} is no format for meshes" if path.suffix else "it has no extension that says the format"
        raise InputError(path, f"{what}; a run reads {listed(formats)}")
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(path, "its name is not valid UTF-8, and cannot be written into records; rename it") from None


def read_file(path: Path, *, allow_outside: bool = False, unchecked: Callable[[Path], Reading] | None = None) -> Reading:
    """Read a mesh file, or refuse it with an `InputError`; `unchecked` reads a format that nothing here understands."""
    check_input(path)
    kind = extension(path)
    if kind in UNCHECKED and unchecked is None:
        raise InputError(
            path,
            f"nothing but MeshLab's own reader understands .{kind} files, and that believes whatever they say; "
            f"save it as .ply or .obj, or give --unchecked if you trust it",
        )
    try:
        with unchanged(path):
            if kind in UNCHECKED and unchecked is not None:
                return completed(path, unchecked(path))
            check_magic(path)
            read: Reader = load_function(READABLE[kind].reader)
            reading = read(path, References(path, allow_outside=allow_outside))
            source, textures = reading.mesh.source, reading.mesh.textures
            if len(textures) > MOST_TEXTURES:
                raise ContentsError(f"it names {len(textures):,} textures; {MOST_TEXTURES:,} are the most")
            images = (t.image for t in (*textures, *(source.images if source else ())) if isinstance(t.image, Path))
            return completed(path, replace(reading, side_files=(*reading.side_files, *images)))
    except ContentsError as error:
        raise InputError(path, str(error)) from error
    except OSError as error:
        raise InputError(path, (error.strerror or str(error)).lower()) from error


def check_magic(path: Path) -> None:
    """Refuse a file that begins as none of its format does, before all of it is read."""
    with path.open("rb") as file:
        head = file.read(4096)
    if extension(path) not in _ANY_ENCODING and _UTF_16.match(head):
        raise ContentsError("it is a text in UTF-16; save it as UTF-8")
    begin = READABLE[extension(path)].begin
    if begin is not None and not re.match(begin[0], head.decode("latin-1")):
        raise ContentsError(f"it does not begin with {begin[1]}")


@contextmanager
def unchanged(path: Path) -> Iterator[None]:
    """Refuse a file that another program writes to while the context lasts."""
    before = path.stat()
    yield
    after = path.stat()
    if (before.st_size, before.st_mtime_ns, before.st_ino) != (after.st_size, after.st_mtime_ns, after.st_ino):
        raise InputError(path, "it changed while it was read")


def completed(path: Path, reading: Reading) -> Reading:
    """The reading with a label and counts, and without vertices that are not finite, which nothing can compute with."""
    mesh = reading.mesh
    source = mesh.source
    assert source is not None
    n, m, e = len(mesh.vertices), len(mesh.faces), len(mesh.edges)
    source = replace(source, side_files=reading.side_files, vertices=n, faces=m, edges=e)
    mesh = replace(mesh, source=source, label=path.name)
    doubts = list(reading.doubts)
    if not np.isfinite(mesh.vertices).all():
        mesh = mesh.part(np.asarray(np.isfinite(mesh.vertices).all(axis=1)))
        vertices = _counted(n - len(mesh.vertices), "vertex", "vertices")
        faces = _counted(m - len(mesh.faces), "face", "faces")
        doubts.append(f"left out: {vertices} with a coordinate that is not finite, and {faces} with such a vertex")
    if not len(mesh.vertices):
        raise InputError(path, "no vertex could be read from it")
    low, high = bounding_box(mesh.vertices)
    if len(mesh.vertices) > 1 and (low == high).all():
        doubts.append(f"all its {len(mesh.vertices):,} vertices are at one place")
    return replace(reading, mesh=mesh, doubts=tuple(doubts))


def _counted(number: int, one: str, many: str) -> str:
    return f"{number:,} {one if number == 1 else many}"
