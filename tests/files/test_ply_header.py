"""The header of PLY files, and what MeshLab drops of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pymeshlab
import pytest
from pymeshfair.files.ply_body import read_body
from pymeshfair.files.ply_losses import not_kept

from pymeshfair.files.ply import PlyError, parse_header, read_header

from .runs import BONE, RANGE_MAP, TETRAHEDRON, ply_bytes, xyz

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
    assert str(header.element("face").properties[0]) == "list int vertex_indices"
    assert header.element("nothing").count == 0


def test_textures_are_found() -> None:
    """A TextureFile comment names a texture, blanks included."""
    assert parse_header(HEADER).textures == ("a b.png",)


def test_samples_of_the_wheel(tmp_path: Path) -> None:
    """The sizes that real headers declare fit their files to the byte."""
    for path, vertices, faces in ((BONE, 1872, 3022), (RANGE_MAP, 85849, 166259)):
        header = read_header(path)
        assert (header.element("vertex").count, header.element("face").count) == (vertices, faces)
        rows = sum(e.count * e.smallest_row for e in header.elements) + 12 * faces
        assert header.size + rows == path.stat().st_size
        assert read_body(path, header, frozenset()).triangles == faces


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
    with pytest.raises(PlyError, match=reason):
        parse_header(data)


@pytest.mark.parametrize("count", [10_000_000, 10**30])
def test_declarations_beyond_the_file_are_refused(tmp_path: Path, count: int) -> None:
    """A small file that declares millions of vertices is refused from its header, by the bytes that they would take."""
    path = tmp_path / "bomb.ply"
    path.write_bytes(ply_bytes(xyz(), faces=()).replace(b"element vertex 4", f"element vertex {count}".encode()))
    with pytest.raises(PlyError, match=f"declares {count:,} of 'vertex', which take at least {24 * count:,} bytes"):
        read_header(path)


def test_text_files_are_held_to_their_size_too(tmp_path: Path) -> None:
    """An ascii file of n values has at least n digits and n - 1 blanks; one that declares one row more is refused."""
    path = tmp_path / "text.ply"
    path.write_bytes(HEADER[:-1])
    assert read_header(path).element("vertex").count == 3
    path.write_bytes(HEADER[:-1].replace(b"vertex 3", b"vertex 4"))
    with pytest.raises(PlyError, match="declares 4"):
        read_header(path)


def test_polygons_are_counted_as_triangles(tmp_path: Path) -> None:
    """A pentagon makes three triangles, a quad two, a triangle one; a list beyond the file is refused."""
    path = tmp_path / "polygons.ply"
    faces = [[0, 1, 2], [0, 1, 2, 3], [0, 1, 2, 3, 0]]
    path.write_bytes(ply_bytes(xyz(), faces, [("float", "quality", [0.0] * 3)]))
    assert read_body(path, read_header(path), frozenset()).triangles == 6
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(PlyError, match="'face' is cut short"):
        read_body(path, parse_header(path.read_bytes()), frozenset())


def properties_after_meshlab(data: bytes, folder: Path) -> set[str]:
    """The properties that are left when MeshLab has read and written a file, with everything that it can write."""
    (folder / "before.ply").write_bytes(data)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(folder / "before.ply"))
    meshes.save_current_mesh(str(folder / "after.ply"), save_vertex_normal=True, save_vertex_radius=True)
    header = read_header(folder / "after.ply")
    return {f"{e.name} {p.name}" for e in header.elements for p in e.properties}


VERTEX_CASES: list[list[tuple[str, str, Any]]] = [
    *([(t, "quality", 3)] for t in ("float", "double", "int", "uchar")),
    *([(t, c, 100) for c in ("red", "green", "blue")] for t in ("uchar", "ushort", "float")),
    *([(t, c, 0.5) for c in ("nx", "ny", "nz")] for t in ("float", "double")),
    *([(t, c, 0.5) for c in ("texture_u", "texture_v")] for t in ("float", "double")),
    *([(t, c, 0.5)] for t in ("float", "double") for c in ("intensity", "label", "gps_time", "u")),
    [("double", "confidence", 0.5)],
    [("list uchar float", "views", [1.0, 2.0])],
    [("uchar", "red", 1), ("uchar", "green", 2)],
]


@pytest.mark.parametrize("case", VERTEX_CASES, ids=lambda case: " ".join(f"{t}-{n}" for t, n, _ in case))
def test_losses_of_vertices_are_those_of_meshlab(tmp_path: Path, case: list[tuple[str, str, Any]]) -> None:
    """A vertex property is called lost exactly if it is gone after MeshLab has read and written the file."""
    data = ply_bytes([*xyz(), *((t, n, [v] * 4) for t, n, v in case)])
    kept = properties_after_meshlab(data, tmp_path)
    said = " ".join(not_kept(parse_header(data)))
    for _, name, _ in case:
        assert (f" {name}'" in said) == (f"vertex {name}" not in kept)


@pytest.mark.parametrize(
    "case",
    [
        [("float", "quality", 3.0)],
        [("double", "quality", 3.0)],
        [("int", "material_id", 3)],
        [("list uchar float", "texcoord", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])],
        [("list uchar double", "texcoord", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])],
        [(t, c, 7) for t in ("uchar",) for c in ("red", "green", "blue", "alpha")],
    ],
    ids=lambda case: " ".join(f"{t}-{n}" for t, n, _ in case),
)
def test_losses_of_faces_are_those_of_meshlab(tmp_path: Path, case: list[tuple[str, str, Any]]) -> None:
    """A face property is called lost exactly if it is gone after MeshLab has read and written the file."""
    data = ply_bytes(xyz(), TETRAHEDRON[1].tolist(), [(t, n, [v] * 4) for t, n, v in case])
    kept = properties_after_meshlab(data, tmp_path)
    said = " ".join(not_kept(parse_header(data)))
    for _, name, _ in case:
        assert (f" {name}'" in said) == (f"face {name}" not in kept)


def test_elements_and_comments_are_named() -> None:
    """A camera, an unknown element and comments are named; MeshLab's own comment, textures and empty elements are not."""
    head = "comment VCGLIB generated\ncomment TextureFile a.png\ncomment scanned by hand\nobj_info num_cols 512\n"
    head += "element camera 1\nproperty float focal\nelement anchor 0\nproperty int k"
    said = not_kept(parse_header(ply_bytes(xyz(), head=head, rows_before=b"\0\0\0\0")))
    assert said == ["element 'camera' (1)", "comment 'scanned by hand' and 1 more"]


def test_corruption_is_said() -> None:
    """An intensity that MeshLab turns into grey, and a confidence that it misreads, are called what they are."""
    data = ply_bytes([*xyz(), ("float", "intensity", [0.5] * 4), ("float", "confidence", [0.5] * 4)])
    grey, wrong = not_kept(parse_header(data))
    assert "shades of grey" in grey
    assert "wrong values" in wrong
