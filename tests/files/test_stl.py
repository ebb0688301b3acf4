"""STL files: corners as vertices, colours of facets by both conventions, heads, and binary files that all programs read."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from pymeshfair.files.inputs import read_file
from pymeshfair.mesh_data import MeshData
from tests.meshes import icosphere

from .round_trips import assert_same, meshlab, read, save

MAGICS = b"COLOR=\x10\x20\x30\xff,MATERIAL=\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01\x01"
OF_MESHLAB = b"COLOR=\x7f\x7f\x7f MATERIAL=\x7f\x7f\x7f \x7f\x7f\x7f \x7f\x7f\x7f"


def binary(corners: np.ndarray, bits: list[int], head: bytes = b"") -> bytes:
    """A file of (m, 3, 3) corners, with these two bytes after each facet."""
    rows = np.zeros(len(corners), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("bits", "<u2")])
    rows["v"], rows["bits"] = corners, bits
    return head.ljust(80) + struct.pack("<I", len(rows)) + rows.tobytes()


def sphere(radius: float = 1.0) -> np.ndarray:
    """(m, 3, 3) the corners of a sphere of 80 triangles, as a file has them."""
    vertices, faces = icosphere(1)
    return (vertices * radius).astype(np.float32)[faces]


def text_of(corners: np.ndarray) -> str:
    """The facets as a text."""
    facets = ["".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in facet) for facet in corners.astype(float).tolist()]
    return "solid ball\n" + "".join(f"facet normal 0 0 0\nouter loop\n{f}endloop\nendfacet\n" for f in facets) + "endsolid\n"


@pytest.mark.parametrize("kind", ["text", "binary"])
def test_equal_corners_are_one_vertex(tmp_path: Path, kind: str) -> None:
    """Vertices and faces are those of MeshLab, in its order, and the volume is that of the ball."""
    corners = sphere()
    corners[0, 0] *= [-0.0, 1, 1]  # 0 and -0 are the same place
    path = tmp_path / "a.stl"
    mesh = read(path, text_of(corners) if kind == "text" else binary(corners, [0] * 80))
    theirs, _meshes = meshlab(path)
    np.testing.assert_array_equal(mesh.vertices, theirs.vertex_matrix())
    np.testing.assert_array_equal(mesh.faces, theirs.face_matrix())
    assert mesh.face_attributes.keys() == set()


#: the head, what stands behind a facet, and its colour
COLORS = (
    (b"", 0x8000 | 31 << 10, (255, 0, 0)),
    (b"", 0x8000 | 31 | 10 << 5, (0, 82, 255)),
    (b"", 31 << 10, (255, 255, 255)),
    (MAGICS, 31, (255, 0, 0)),
    (MAGICS, 31 << 10 | 10 << 5, (0, 82, 255)),
    (MAGICS, 0x8000 | 31, (16, 32, 48)),
    (OF_MESHLAB, 0x8000 | 31, (255, 0, 0)),
)


@pytest.mark.parametrize(("head", "bits", "color"), COLORS)
def test_colours_of_facets(tmp_path: Path, head: bytes, bits: int, color: tuple[int, ...]) -> None:
    """Magics begins with red, VisCAM with blue, and the highest bit means that a facet has none of its own, or has one.

    What is written again has the same head and the same bits, and no others where a facet has the colour of the head.
    """
    data = binary(sphere()[:2], [bits, 0x8000 if not head else 0], head)
    mesh = read(tmp_path / "a.stl", data)
    assert mesh.face_attributes["colors"][0].tolist() == [*color, 255]
    if head or bits & 0x8000:
        assert save(mesh, tmp_path / "b.stl") == ()
        found = (tmp_path / "b.stl").read_bytes()
        assert found[:84] == data[:84]
        expected = 0x8000 if color == (16, 32, 48) else bits
        assert found[84 + 48 : 84 + 50] == expected.to_bytes(2, "little")


def test_other_bits_are_named(tmp_path: Path) -> None:
    """What stands behind a facet and is no colour is in no output, and is said."""
    mesh = read(tmp_path / "a.stl", binary(sphere(), list(range(80)), b"made on Monday"))
    assert mesh.source is not None
    assert mesh.source.extras == ("its head 'made on Monday'", "the data after 79 of its facets, which is no colour")
    for name in ("b.stl", "b.ply"):
        assert "after 79 of its facets" in " ".join(save(mesh, tmp_path / name))


def test_what_is_written_is_read_everywhere(tmp_path: Path) -> None:
    """MeshLab, trimesh and we read the same facets, and the colours within a step of the format."""
    vertices, faces = icosphere(2)
    vertices = vertices.astype(np.float32).astype(np.float64)
    colors = np.random.default_rng(1).integers(0, 256, (len(faces), 4), np.uint8)
    colors[:, 3] = 255
    mesh = MeshData(vertices=vertices, faces=faces, face_attributes={"colors": colors})
    path = tmp_path / "a.stl"
    assert save(mesh, path) == ("a.stl: colours of faces are rounded to 32 levels",)
    again, (theirs, _meshes), other = read_file(path).mesh, meshlab(path), trimesh.load_mesh(path)
    np.testing.assert_array_equal(again.vertices[again.faces], vertices[faces])
    np.testing.assert_array_equal(theirs.vertex_matrix(), again.vertices)
    np.testing.assert_array_equal(theirs.face_matrix(), again.faces)
    assert np.abs(again.face_attributes["colors"] - colors.astype(float)).max() <= 4
    assert np.abs(255 * theirs.face_color_matrix()[:, :3] - colors[:, :3]).max() <= 12  # it makes 248 of 31
    np.testing.assert_allclose(other.volume, float(trimesh.Trimesh(vertices, faces).volume), rtol=1e-6)
    assert save(again, tmp_path / "b.stl") == ()
    assert (tmp_path / "b.stl").read_bytes() == path.read_bytes()
    assert_same(read_file(tmp_path / "b.stl").mesh, again)


def test_a_text_becomes_binary(tmp_path: Path) -> None:
    """Its name becomes the head, unless the file would then begin as a text does."""
    mesh = read(tmp_path / "a.stl", text_of(sphere()))
    assert save(mesh, tmp_path / "b.stl") == ()
    assert (tmp_path / "b.stl").read_bytes()[:80].rstrip() == b"ball"
    mesh = read(tmp_path / "c.stl", text_of(sphere()).replace("solid ball", "solid solid"))
    save(mesh, tmp_path / "d.stl")
    assert not (tmp_path / "d.stl").read_bytes().startswith(b"solid")


def test_a_backslash_ends_the_name_of_a_solid(tmp_path: Path) -> None:
    """The next line stays a line of its own."""
    mesh = read(tmp_path / "a.stl", text_of(sphere()).replace("ball", "C:\\scans\\", 1))
    assert len(mesh.faces) == 80
    assert mesh.source is not None
    assert mesh.source.extras == ("its head 'C:\\\\scans\\\\'",)


@pytest.mark.parametrize("name", ["solid part", 90 * "x"])
def test_a_head_that_no_binary_file_can_have_is_named(tmp_path: Path, name: str) -> None:
    """A name that makes a binary file look like a text, or that is too long for one, is left out with a note."""
    mesh = read(tmp_path / "a.stl", text_of(sphere()).replace("ball", name, 1))
    assert save(mesh, tmp_path / "b.stl") == (f"b.stl does not hold these contents of a.stl: its head {name[:60]!r}",)
    assert read_file(tmp_path / "b.stl").mesh.source is not None
