"""The header of PLY files: read, checked against the size of the file, and written with other elements."""

from __future__ import annotations

from pathlib import Path

import pytest

from pymeshfair.files.errors import ContentsError
from pymeshfair.files.ply_tables import parse_header, read_header, row_type

from ..running.runs import BONE, RANGE_MAP, element, ply_bytes, xyz

HEADER = b"ply\nformat ascii 1.0\ncomment TextureFile a b.png\nelement vertex 3\nproperty float x\nend_header\n0\n1\n2\n"


def test_header_is_read() -> None:
    """Format, comments, elements, properties with lists, and the size of the header are read as written."""
    data = b"ply\r\nformat binary_big_endian 1.0\r\ncomment  two words \r\nelement vertex 0\r\nproperty int8 a\r\n"
    data += b"element face 1\r\nproperty list uint8 int32 vertex_indices\r\nend_header\r\n\0"
    header = parse_header(data)
    assert header.format == "binary_big_endian"
    assert header.comments == ("two words",)
    assert header.size == len(data) - 1
    assert [(e.name, e.count) for e in header.elements] == [("vertex", 0), ("face", 1)]
    assert str(element(header, "face").properties[0]) == "list int vertex_indices"


def test_textures_are_found() -> None:
    """A TextureFile comment names a texture, blanks included."""
    assert parse_header(HEADER).textures == ("a b.png",)


def test_samples_of_the_wheel(tmp_path: Path) -> None:
    """The sizes that real headers declare fit their files to the byte."""
    for path, vertices, faces in ((BONE, 1872, 3022), (RANGE_MAP, 85849, 166259)):
        header = read_header(path)
        assert (element(header, "vertex").count, element(header, "face").count) == (vertices, faces)
        rows = sum(e.count * row_type(e, "<", {p.name: 0 for p in e.properties}).itemsize for e in header.elements) + 12 * faces
        assert header.size + rows == path.stat().st_size


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "does not begin with 'ply'"),
        (b"solid x", "does not begin with 'ply'"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\n", "no end"),
        (b"ply\nelement vertex 1\nproperty float x\nend_header\n", "no format"),
        (b"ply\nformat ascii 1.0\nelement vertex -1\nend_header\n", "line 3"),
        (b"ply\nformat ascii 1.0\nelement vertex 99999999999999999999999x\nend_header\n", "line 3"),
        (b"ply\nformat ascii 1.0\nproperty float x\nend_header\n", "line 3"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n", "line 4"),
        (b"ply\nformat binary_middle_endian 1.0\nend_header\n", "line 2"),
    ],
)
def test_bad_headers_are_refused(data: bytes, reason: str) -> None:
    """A header that is broken is refused with the reason and, where there is one, the line."""
    with pytest.raises(ContentsError, match=reason):
        parse_header(data)


@pytest.mark.parametrize("count", [10_000_000, 10**30])
def test_declarations_beyond_the_file_are_refused(tmp_path: Path, count: int) -> None:
    """A small file that declares millions of vertices is refused from its header, by the bytes that they would take."""
    path = tmp_path / "bomb.ply"
    path.write_bytes(ply_bytes(xyz(), faces=()).replace(b"element vertex 4", f"element vertex {count}".encode()))
    with pytest.raises(ContentsError, match=f"declares {count:,} of 'vertex', which take at least {24 * count:,} bytes"):
        read_header(path)


def test_text_files_are_held_to_their_size_too(tmp_path: Path) -> None:
    """An ascii file of n values has at least n digits and n - 1 blanks; one that declares one row more is refused."""
    path = tmp_path / "text.ply"
    path.write_bytes(HEADER[:-1])
    assert element(read_header(path), "vertex").count == 3
    path.write_bytes(HEADER[:-1].replace(b"vertex 3", b"vertex 4"))
    with pytest.raises(ContentsError, match="declares 4"):
        read_header(path)
