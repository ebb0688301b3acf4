"""Reads a mesh file, whatever its format, as a `MeshData`."""

import os
import re
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from ..filters.mesh import bounding_box
from ..mesh_data import MeshData
from .errors import ContentsError, InputError
from .formats import READABLE, UNCHECKED, extension, listed, load_function
from .references import References, check_regular

#: of a text that ends within a line
NO_END = "its last line has no end: if the file was cut short, so was perhaps its last number"


@dataclass(frozen=True, eq=False)
class Reading:
    """A mesh file that was read."""

    mesh: MeshData  # the mesh in it
    doubts: tuple[str, ...] = ()  # sentences that the user should read about it
    side_files: tuple[Path, ...] = ()  # the files that belong to it; of a reader, without the images of textures


def unended(text: bytes) -> tuple[str, ...]:
    """The doubt about a text that ends within a line: its last number may be the beginning of a longer one."""
    return () if text.endswith((b"\n", b"\r", b"\x1a")) else (NO_END,)


#: textures of one mesh
MOST_TEXTURES = 1000
#: Reads a file and what it names. Raises `ContentsError` if the file is none of its format, is damaged, declares or names what is
#: not there, or needs a package that is missing; `InputError` if it names a file that must not be opened; `OSError` if it cannot
#: be read.
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
    """Read a mesh file.

    Args:
        path: the file.
        allow_outside: let it name files outside its own folder.
        unchecked: reads a format that nothing here understands; None refuses it.

    Raises:
        InputError: it is damaged, lies, or names a file that must not be opened.
    """
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
        finite = np.all(np.isfinite(mesh.vertices), axis=1, out=np.empty(n, np.bool_))
        whole, mesh = mesh, mesh.part(finite)
        lost_vertices, lost_faces = len(whole.vertices) - len(mesh.vertices), len(whole.faces) - len(mesh.faces)
        doubts.append(
            f"left out: {_counted(lost_vertices, 'vertex', 'vertices')} with a coordinate that is not finite, and "
            f"{_counted(lost_faces, 'face', 'faces')} with such a vertex"
        )
    if not len(mesh.vertices):
        raise InputError(path, "no vertex could be read from it")
    low, high = bounding_box(mesh.vertices)
    if len(mesh.vertices) > 1 and (low == high).all():
        doubts.append(f"all its {len(mesh.vertices):,} vertices are at one place")
    return replace(reading, mesh=mesh, doubts=tuple(doubts))


def _counted(number: int, one: str, many: str) -> str:
    return f"{number:,} {one if number == 1 else many}"
