"""Reads a mesh file of any format as a `MeshData`, and finds the files that it names.

Scans are not trusted, and the files that they name are copied beside the output. So a name may lead only to a regular file in
or below the folder of the mesh, after links are resolved, unless the user allows others. A texture's content must be an image.
"""

import os
import re
import stat
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO, TypeAlias

import numpy as np

from ..filters.mesh import bounding_box
from ..mesh_data import MeshData
from ..places import counted
from .errors import ContentsError, InputError, reason_of
from .formats import READABLE, UNCHECKED, extension, listed, load_function

IMAGES = ("PNG", "JPEG", "BMP", "GIF", "TIFF", "PPM", "XBM", "XPM", "WEBP")  # formats that MeshLab reads, in Pillow's names
LARGEST_IMAGE = 1 << 28  # pixels of the largest texture, 16,384 x 16,384, which take 1 GB of memory
#: an image of more than `_SMALL_IMAGE` pixels (128 MB in memory) may have at most `_PIXELS_A_BYTE` pixels per byte of its file
_SMALL_IMAGE, _PIXELS_A_BYTE = 1 << 25, 256


class References:
    """Finds the files that a mesh file names, relative to its folder; `allow_outside` permits names that lead out of it."""

    def __init__(self, mesh: Path, *, allow_outside: bool = False) -> None:
        self.mesh = mesh
        self._folder = mesh.parent.resolve()
        self._allow_outside = allow_outside

    def find(self, name: str) -> Path | None:
        """Returns the path of a named file, without resolving links, or None if there is no such file."""
        if "\0" in name or not name.strip():
            return None
        path = self.mesh.parent / name
        if not os.path.lexists(path):
            return None
        check_regular(path, self.mesh)
        if not (self._allow_outside or path.resolve().is_relative_to(self._folder)):
            raise InputError(
                self.mesh,
                f"it names the file {quoted(name)}, which is outside its folder; put it beside the mesh, or take a command that "
                "has --allow-outside: run, batch, verify, info, compare or picture",
            )
        return path

    def find_image(self, name: str) -> Path | None:
        """Finds an image by its name, else by the last part of the name, since names may be paths of another computer."""
        path = self.find(name) or self.find(name.replace("\\", "/").rpartition("/")[2])
        if path is not None:
            check_image(path, self.mesh, path.name)
        return path


def check_regular(path: Path, mesh: Path) -> None:
    """Refuses a path that is no readable regular file; `mesh` is the input: `path` itself, or a file that names `path`."""
    named = "" if path == mesh else f"{quoted(str(path))}, which it names, "
    try:
        mode = path.stat().st_mode
    except OSError as error:
        reason = "there is no such file" if isinstance(error, FileNotFoundError) else reason_of(error)
        raise InputError(mesh, f"it names {quoted(str(path))}: {reason}" if named else reason) from error
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "a pipe" if stat.S_ISFIFO(mode) else "a device or a socket"
        raise InputError(mesh, f"{named or 'it '}is {kind} and no file")
    if not os.access(path, os.R_OK):
        raise InputError(mesh, f"{named or 'it '}cannot be read without permission")


def check_image(source: Path | BinaryIO, mesh: Path, name: str) -> None:
    """Refuses a texture whose content is no image, a damaged PNG, or an image with too many pixels."""
    from PIL import Image, UnidentifiedImageError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow warns above a limit of its own
            with Image.open(source, formats=IMAGES) as image:
                width, height = image.size
                image.verify()  # if a checksum of a PNG is wrong, MeshLab would write its "dummy.png" instead of the image
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError) as error:
        why = f"is no image that MeshLab reads ({', '.join(IMAGES)}), is damaged, or is too large"
        raise InputError(mesh, f"the texture {quoted(name)} {why}") from error
    size = source.stat().st_size if isinstance(source, Path) else source.seek(0, os.SEEK_END)
    most = min(LARGEST_IMAGE, max(_SMALL_IMAGE, _PIXELS_A_BYTE * size))
    if width * height > most:
        why = f"has {width:,} x {height:,} pixels; a file of {size:,} bytes may have {most:,} at most"
        raise InputError(mesh, f"the texture {quoted(name)} {why}")


def quoted(name: str, length: int = 80) -> str:
    """Quotes a name from a file for a message: shortened, and with control characters escaped."""
    return repr(name if len(name) <= length else f"{name[:length]}...")


#: the warning about a text that ends within a line
NO_END = "its last line has no line end: the file, and its last number, may be cut short"


@dataclass(frozen=True, eq=False)
class Reading:
    """A mesh file that was read."""

    mesh: MeshData
    doubts: tuple[str, ...] = ()  # warnings for the user, one sentence each
    side_files: tuple[Path, ...] = ()  # files that belong to the mesh file; `read_file` adds the images of textures


def unended(text: bytes) -> tuple[str, ...]:
    """Returns `NO_END` if a text ends within a line, else nothing."""
    return () if text.endswith((b"\n", b"\r", b"\x1a")) else (NO_END,)


MOST_TEXTURES = 1000  # of one mesh
#: Reads a mesh file and the files it names. Raises `ContentsError` if it is damaged, has another format or needs a package that
#: is missing; `InputError` if it names a file that must not be opened; `OSError` if it cannot be read.
Reader: TypeAlias = Callable[[Path, References], Reading]
#: the first bytes of a text in UTF-16, and the formats whose readers accept this encoding
_UTF_16, _ANY_ENCODING = re.compile(rb"\xff\xfe[\t-~]\0|\xfe\xff\0[\t-~]"), ("gltf", "dae", "x3d")


def check_input(path: Path) -> None:
    """Refuses a path that cannot be a mesh file, without opening it."""
    check_regular(path, path)
    if path.stat().st_size == 0:
        raise InputError(path, "it is empty")
    if extension(path) not in (*READABLE, *UNCHECKED):
        what = f"{path.suffix!r} is no format for meshes" if path.suffix else "it has no extension that says the format"
        raise InputError(path, f"{what}; a run reads {listed((*READABLE, *UNCHECKED))}")
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(path, "its name is not valid UTF-8, and cannot be written into records; rename it") from None


def read_file(path: Path, *, allow_outside: bool = False, unchecked: Callable[[Path], Reading] | None = None) -> Reading:
    """Reads a mesh file, or refuses it with an `InputError`; `unchecked` reads the formats of `UNCHECKED`."""
    check_input(path)
    kind = extension(path)
    if kind in UNCHECKED and unchecked is None:
        raise InputError(
            path,
            f"only MeshLab's own reader understands .{kind} files, and it does not check their contents; "
            f"save the mesh as .ply or .obj, or give --unchecked if you trust the file",
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
        raise InputError(path, reason_of(error)) from error


def check_magic(path: Path) -> None:
    """Refuses a file whose first bytes do not fit its format, before reading all of it."""
    with path.open("rb") as file:
        head = file.read(4096)
    if extension(path) not in _ANY_ENCODING and _UTF_16.match(head):
        raise ContentsError("it is a text in UTF-16; save it as UTF-8")
    if (begin := READABLE[extension(path)].begin) is not None and not re.match(begin[0], head.decode("latin-1")):
        raise ContentsError(f"it does not begin with {begin[1]}")


@contextmanager
def unchanged(path: Path) -> Iterator[None]:
    """Refuses a file that another program changes while the context is open."""
    before = path.stat()
    yield
    after = path.stat()
    if (before.st_size, before.st_mtime_ns, before.st_ino) != (after.st_size, after.st_mtime_ns, after.st_ino):
        raise InputError(path, "it changed while it was read")


def completed(path: Path, reading: Reading) -> Reading:
    """Adds label and counts of the file, and leaves out vertices that are not finite; refuses a mesh without vertices."""
    mesh = reading.mesh
    source = mesh.source
    assert source is not None
    n, m, e = len(mesh.vertices), len(mesh.faces), len(mesh.edges)
    mesh = replace(mesh, source=replace(source, side_files=reading.side_files, vertices=n, faces=m, edges=e), label=path.name)
    doubts = list(reading.doubts)
    if not np.isfinite(mesh.vertices).all():
        mesh = mesh.part(np.asarray(np.isfinite(mesh.vertices).all(axis=1)))
        vertices = counted(n - len(mesh.vertices), "vertex", "vertices")
        cells = counted(m - len(mesh.faces), "face")
        cells += f" and {counted(e - len(mesh.edges), 'edge')}" * (e > len(mesh.edges))
        doubts.append(f"left out: {vertices} with a coordinate that is not finite, and {cells} with such a vertex")
    if not len(mesh.vertices):
        raise InputError(path, "no vertex could be read from it")
    low, high = bounding_box(mesh.vertices)
    if len(mesh.vertices) > 1 and (low == high).all():
        doubts.append(f"all its {len(mesh.vertices):,} vertices are at one place")
    return replace(reading, mesh=mesh, doubts=tuple(doubts))
