"""Checks that a file which MeshLab has just written is whole: MeshLab reports no error when the disk is full (.xyz)."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

from ..errors import PymeshfairError
from . import ply
from .formats import extension

#: the length of the lists that MeshLab writes into a PLY file
_LIST_LENGTHS = {"vertex_indices": 3, "texcoord": 6}


class TornFileError(PymeshfairError, ValueError):
    """The file is not whole; the message says what is missing."""


def verify_file(path: Path, vertices: int, faces: int) -> None:
    """Compare what a file holds with the mesh that was written to it.

    Raises:
        TornFileError: it holds less.
    """
    _VERIFY[extension(path)](path, vertices, faces)


def _verify_ply(path: Path, vertices: int, faces: int) -> None:
    try:
        header = ply.read_header(path)
    except ply.PlyError as error:
        raise TornFileError(str(error)) from error
    _compare((header.element("vertex").count, header.element("face").count), (vertices, faces))
    size = header.size
    for element in header.elements:
        lists = sum(_LIST_LENGTHS.get(p.name, 0) * ply.SIZES[p.type] for p in element.properties if p.count_type)
        size += element.count * (element.smallest_row + lists)
    if path.stat().st_size < size:
        raise TornFileError(f"it has {path.stat().st_size:,} bytes of {size:,}")


def _verify_obj(path: Path, vertices: int, faces: int) -> None:
    text = b"\n" + path.read_bytes()
    _compare((text.count(b"\nv "), text.count(b"\nf ")), (vertices, faces))
    _check_end(path, b"# End of File")


def _verify_off(path: Path, vertices: int, faces: int) -> None:
    with path.open("rb") as file:
        file.readline()
        counts = [int(word) for word in file.readline().split()]
        _compare((counts[0], counts[1]) if len(counts) == 3 else (0, 0), (vertices, faces))
        _compare_lines(sum(1 for _ in file), vertices + faces)
    _check_end(path, b"\n")


def _verify_stl(path: Path, vertices: int, faces: int) -> None:
    size = path.stat().st_size
    if size != 84 + 50 * faces:
        raise TornFileError(f"it has {size:,} bytes of {84 + 50 * faces:,}")


def _verify_xyz(path: Path, vertices: int, faces: int) -> None:
    with path.open("rb") as file:
        _compare_lines(sum(1 for _ in file), vertices)
    _check_end(path, b"\n")


def _verify_wrl(path: Path, vertices: int, faces: int) -> None:
    _check_end(path, b"}")


def _verify_3mf(path: Path, vertices: int, faces: int) -> None:
    try:
        with zipfile.ZipFile(path) as archive:
            broken = archive.testzip()
    except zipfile.BadZipFile as error:
        raise TornFileError(str(error).lower()) from error
    if broken is not None:
        raise TornFileError(f"its part {broken} is broken")


def _compare(found: tuple[int, int], expected: tuple[int, int]) -> None:
    if found != expected:
        raise TornFileError(f"it has {found[0]:,} vertices and {found[1]:,} faces of {expected[0]:,} and {expected[1]:,}")


def _compare_lines(found: int, expected: int) -> None:
    if found < expected:
        raise TornFileError(f"it has {found:,} of {expected:,} lines")


def _check_end(path: Path, expected: bytes) -> None:
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 256))
        end = file.read()
    if not (end.endswith(expected) or end.rstrip().endswith(expected)):
        raise TornFileError(f"its end is missing ({expected.decode().strip() or 'a line feed'})")


_VERIFY: dict[str, Callable[[Path, int, int], None]] = {
    "ply": _verify_ply,
    "obj": _verify_obj,
    "off": _verify_off,
    "stl": _verify_stl,
    "xyz": _verify_xyz,
    "wrl": _verify_wrl,
    "3mf": _verify_3mf,
}
