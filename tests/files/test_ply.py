"""PLY files: every legal type is read right, and what has not changed is written as it was, byte for byte."""

from __future__ import annotations

import io
import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pymeshfair.declaration import Edit
from pymeshfair.files.errors import InputError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply_tables import header_bytes, parse_header
from pymeshfair.files.ply_write import write_ply
from pymeshfair.files.polygons import triangulated
from pymeshfair.filters.geometry import face_normals
from pymeshfair.mesh_data import MeshData, Texture, apply_edit, moved

from ..running.runs import BONE, RANGE_MAP, SAMPLES
from .plys import CODES, Element, ply_file
from .round_trips import save

ENCODINGS = ("ascii", "binary_little_endian", "binary_big_endian")
SQUARE = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]
PLACE = [("float", c) for c in "xyz"]


def read(tmp_path: Path, data: bytes, name: str = "mesh.ply") -> MeshData:
    """The mesh of a file with these bytes."""
    path = tmp_path / name
    path.write_bytes(data)
    return read_file(path).mesh


def written(mesh: MeshData) -> bytes:
    """The bytes that are written of a mesh."""
    target = io.BytesIO()
    write_ply(mesh, target)
    return target.getvalue()


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("type_", CODES)
def test_coordinates_of_every_type(tmp_path: Path, type_: str, encoding: str) -> None:
    """A coordinate is the number that stands there, whatever its type, its byte order and its place in the row."""
    rows = [[z, x, y, 7] for x, y, z in SQUARE]
    properties = [(type_, "z"), (type_, "x"), (type_, "y"), ("int", "label")]
    mesh = read(tmp_path, ply_file([Element("vertex", properties, rows)], encoding))
    np.testing.assert_array_equal(mesh.vertices, np.array(SQUARE, float))


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize(("count", "item"), list(itertools.product(CODES, CODES)))
def test_lists_of_every_type(tmp_path: Path, count: str, item: str, encoding: str) -> None:
    """Corners are read alike whatever the types of a list are, of equally long rows and of others."""
    for faces in ([[0, 1, 2], [0, 2, 3]], [[0, 1, 2], [0, 1, 2, 3]]):
        elements = [
            Element("vertex", PLACE, SQUARE),
            Element(
                "face", [("uchar", "kind"), (f"list {count} {item}", "vertex_indices"), ("int", "id")], [[1, f, 5] for f in faces]
            ),
        ]
        data = ply_file(elements, encoding)
        mesh = read(tmp_path, data)
        expected = [[0, 1, 2], [0, 2, 3]] if len(faces[1]) == 3 else [[0, 1, 2], [0, 1, 2], [0, 2, 3]]
        np.testing.assert_array_equal(mesh.faces, expected)
        assert written(mesh) == data


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_odd_elements_are_written_as_they_were(tmp_path: Path, encoding: str) -> None:
    """Cameras, lists, empty lists, comments, unknown properties and what pads a file: only moved coordinates differ."""
    elements = [
        Element("camera", [("float", "focal"), ("list uchar double", "distortion")], [[0.1, [1.0, 0.5]], [0.2, []]]),
        Element("vertex", [("float", "x"), ("short", "label"), ("float", "y"), ("double", "z")], [[0.5, 3, 0.1, 2.0]] * 4),
        Element("face", [("list uchar int", "vertex_index"), ("list uchar uchar", "marks"), ("float", "area")],
                [[[0, 1, 2], [1, 2], 0.3], [[0, 1, 2, 3], [], 0.1], [[3, 2, 1], [9], 7.0]]),
        Element("edge", [("int", "vertex1"), ("int", "vertex2"), ("double", "length")], [[0, 1, 0.7], [2, 3, 0.1]]),
        Element("material", [("uchar", "red")], [[7]]),
    ]  # fmt: skip
    head = ["comment one", "obj_info two  words", "comment TextureFile gone.png"]
    data = ply_file(elements, encoding, head) + (b"\n\n" if encoding == "ascii" else b"\0\0\0")
    mesh = read(tmp_path, data)
    assert written(mesh) == data
    assert mesh.source is not None
    assert mesh.source.document.custom("edge")["length"].tolist() == [0.7, 0.1]
    shift = np.array([1.0, 0.25, -3.0])
    other = written(moved(mesh, mesh.vertices + shift))
    elements[1].rows = [[1.5, 3, float(np.float32(0.1) + np.float32(0.25)), -1.0]] * 4
    expected = ply_file(elements, encoding, head) + (b"\n\n" if encoding == "ascii" else b"\0\0\0")
    if encoding == "ascii":
        expected = expected.replace(repr(elements[1].rows[0][2]).encode(), b"%.9g" % elements[1].rows[0][2])
    assert other == expected


@pytest.mark.parametrize("path", [BONE, RANGE_MAP, SAMPLES / "colored_airplane.ply"], ids=lambda p: p.stem)
def test_real_files_keep_every_byte_but_their_places(path: Path) -> None:
    """Of a file that MeshLab or a scanner wrote nothing changes but the coordinates of the vertices that moved."""
    mesh = read_file(path).mesh
    before = np.frombuffer(path.read_bytes(), np.uint8)
    assert written(mesh) == before.tobytes()
    vertices = mesh.vertices.copy()
    vertices[100:200] += 0.5
    after = np.frombuffer(written(moved(mesh, vertices)), np.uint8)
    assert len(after) == len(before)
    assert mesh.source is not None
    table = mesh.source.document.tables["vertex"]
    changed = np.flatnonzero(after != before) - table.bytes[0]
    row, place = np.divmod(changed, (table.bytes[1] - table.bytes[0]) // table.element.count)
    assert row.min() >= 100
    assert row.max() < 200
    assert place.max() < 3 * table.columns["x"].itemsize


def test_comments_outlive_the_element_before_them() -> None:
    """Of a header whose faces go, the lines of these go; a comment and the information after them stay."""
    elements = [Element("vertex", PLACE, [[0.0, 0.0, 0.0]]), Element("face", [("list uchar int", "vertex_indices")], [])]
    text = ply_file(elements, "ascii").replace(b"end_header", b"comment of the scanner\nobj_info station 7\nend_header")
    header = parse_header(text)
    kept = header_bytes(header, [e for e in header.elements if e.name == "vertex"])
    assert kept == text[: text.index(b"element face")] + b"comment of the scanner\nobj_info station 7\nend_header\n"


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_rows_follow_their_elements(tmp_path: Path, encoding: str) -> None:
    """After deletions and additions a property that nothing here knows is at the element that had it, and 0 at new ones."""
    points = [[x, y, 0.0] for y in range(3) for x in range(3)]
    quads = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]]
    elements = [
        Element(
            "vertex",
            [*PLACE, ("uchar", "label"), ("list uchar int", "views")],
            [[*p, k, [k] * (k % 3)] for k, p in enumerate(points)],
        ),
        Element(
            "face", [("list uchar int", "vertex_indices"), ("ushort", "material")], [[q, 10 + k] for k, q in enumerate(quads)]
        ),
    ]
    mesh = read(tmp_path, ply_file(elements, encoding))
    gone = np.zeros(9, np.bool_)
    gone[0] = True  # the first quad loses a triangle or two
    added = Edit(added_vertices=np.array([[5.0, 5.0, 0.0]]), added_faces=np.array([[2, 5, 9]], np.int32))
    again = read(
        tmp_path, written(apply_edit(apply_edit(mesh, added), Edit(delete_vertices=np.append(gone, False)))), "again.ply"
    )
    assert again.source is not None
    vertex, face = (again.source.document.tables[name] for name in ("vertex", "face"))
    assert vertex.numbers("label").tolist() == [*range(1, 9), 0]
    assert [len(row) for row in np.split(vertex.lists("views").values, np.cumsum(vertex.lists("views").lengths))][:9] == [
        *(k % 3 for k in range(1, 9)),
        0,
    ]
    lists = face.lists("vertex_indices")
    corners = [row.tolist() for row in np.split(lists.values, np.cumsum(lists.lengths))[:-1]]
    assert corners[-4:] == [[0, 1, 4, 3], [2, 3, 6, 5], [3, 4, 7, 6], [1, 4, 8]]
    assert face.numbers("material").tolist()[-4:] == [11, 12, 13, 0]
    np.testing.assert_array_equal(again.vertices, np.array([*points[1:], [5.0, 5.0, 0.0]]))


@pytest.mark.parametrize("attributes", [{}, {"scalars": np.arange(4.0)}])
def test_coordinates_become_double_where_float_is_too_coarse(tmp_path: Path, attributes: dict[str, Any]) -> None:
    """Near 4,500,000 a float has steps of half a metre: a vertex that moved by a centimetre is written in double precision.

    So it is if the vertices get a new property as well.
    """
    from pymeshfair.files.outputs import Writing

    data = ply_file([Element("vertex", PLACE, [[4_500_000.0 + x, y, z] for x, y, z in SQUARE])])
    mesh = read(tmp_path, data)
    target = io.BytesIO()
    mesh = mesh.with_attributes(attributes)
    (note,) = write_ply(moved(mesh, mesh.vertices + 1e-2), target, Writing(lambda: 2.0, {}, "", []))
    assert note == "coordinates are written as double, as float would round them"
    again = read(tmp_path, target.getvalue(), "again.ply")
    np.testing.assert_array_equal(again.vertices, mesh.vertices + 1e-2)


def test_a_mesh_without_a_file_is_written_whole(tmp_path: Path) -> None:
    """Everything that `MeshData` holds comes back to the bit, and MeshLab reads it alike."""
    rng = np.random.default_rng(5)
    mesh = MeshData(
        vertices=rng.normal(size=(4, 3)),
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        edges=np.array([[0, 3]]),
        keeps_normals=True,
        vertex_attributes={
            "normals": np.eye(4, 3) + np.array([0, 0, 1]),
            "colors": rng.integers(0, 256, (4, 4), np.uint8),
            "scalars": rng.normal(size=4),
            "radii": rng.random(4),
            "texture_coordinates": rng.random((4, 2)),
            "gps_time": rng.random(4),
        },
        face_attributes={
            "colors": rng.integers(0, 256, (2, 4), np.uint8),
            "scalars": rng.normal(size=2),
            "wedge_texture_coordinates": rng.random((2, 3, 2)).astype("f4").astype(float),
        },
    )
    again = read(tmp_path, written(mesh))
    for name in ("vertices", "faces", "edges"):
        np.testing.assert_array_equal(getattr(again, name), getattr(mesh, name))
    for attributes, expected in (
        (again.vertex_attributes, mesh.vertex_attributes),
        (again.face_attributes, mesh.face_attributes),
    ):
        for name, values in expected.items():
            if name != "gps_time":
                np.testing.assert_array_equal(attributes[name], values, err_msg=name)
    assert again.source is not None
    np.testing.assert_array_equal(again.source.document.custom("vertex")["gps_time"], mesh.vertex_attributes["gps_time"])
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(tmp_path / "mesh.ply"))
    there = meshes.current_mesh()
    np.testing.assert_array_equal(there.vertex_matrix(), mesh.vertices)
    np.testing.assert_array_equal(np.rint(255 * there.vertex_color_matrix()), mesh.vertex_attributes["colors"])
    np.testing.assert_array_equal(there.vertex_scalar_array(), mesh.vertex_attributes["scalars"])
    np.testing.assert_array_equal(there.face_scalar_array(), mesh.face_attributes["scalars"])
    np.testing.assert_array_equal(
        there.wedge_tex_coord_matrix().reshape(2, 3, 2), mesh.face_attributes["wedge_texture_coordinates"]
    )


def test_names_that_the_format_cannot_hold_are_changed(tmp_path: Path) -> None:
    """Attributes whose names have blanks or accents, or are those of other columns, are written under other names and told."""
    numbers = np.arange(3.0)
    attributes = {name: numbers + k for k, name in enumerate(("scalars", "Pulse width", "Pulse_width", "größe", "quality"))}
    target = io.BytesIO()
    notes = write_ply(MeshData(vertices=np.eye(3), vertex_attributes=attributes), target)
    again = read(tmp_path, target.getvalue())
    np.testing.assert_array_equal(again.vertex_scalars, numbers)
    assert again.source is not None
    custom = again.source.document.custom("vertex")
    assert {name: values[0] for name, values in custom.items()} == {
        "Pulse_width": 1.0,
        "Pulse_width_": 2.0,
        "gr_e": 3.0,
        "quality_": 4.0,
    }
    reason = "names in PLY are unique ASCII without blanks"
    assert notes == (
        f"the attribute 'Pulse width' is written as 'Pulse_width': {reason}",
        f"the attribute 'Pulse_width' is written as 'Pulse_width_': {reason}",
        f"the attribute 'größe' is written as 'gr_e': {reason}",
        f"the attribute 'quality' is written as 'quality_': {reason}",
    )


def test_whole_numbers_of_64_bits_are_written_as_double(tmp_path: Path) -> None:
    """Numbers within 32 bits stay integers, larger ones become double, and those above 2^53 are told, as they are rounded."""
    attributes = {
        "small": np.array([-5, 0, 7]),
        "stamp": np.arange(3) * 2**40 + 1,
        "big": np.full(3, 2**63 + 5, np.uint64),
        "deep": np.full(3, -(2**63)),
    }
    target = io.BytesIO()
    notes = write_ply(MeshData(vertices=np.eye(3), vertex_attributes=attributes), target)
    again = read(tmp_path, target.getvalue())
    assert again.source is not None
    custom = again.source.document.custom("vertex")
    assert {name: values.dtype.str for name, values in custom.items()} == {
        "small": "<i4",
        "stamp": "<f8",
        "big": "<f8",
        "deep": "<f8",
    }
    for name, values in attributes.items():
        np.testing.assert_array_equal(custom[name], values.astype(custom[name].dtype))
    words = "the whole numbers of {!r} are written as double, which rounds those above 2^53"
    assert notes == (words.format("big"), words.format("deep"))


def test_strips_and_grids_are_those_of_meshlab(tmp_path: Path) -> None:
    """Triangle strips and range images give the triangles that MeshLab makes of them, in its order."""
    rng = np.random.default_rng(2)
    points = rng.random((20, 3)).tolist()
    strip = [0, 1, 2, 3, -1, 4, 5, 6, -1, 7, 8, 9, 10, 11]
    grid = [[k] if rng.random() < 0.8 else [] for k in range(20)]
    files = {
        "strips.ply": ply_file(
            [Element("vertex", PLACE, points), Element("tristrips", [("list int int", "vertex_indices")], [[strip]])]
        ),
        "grid.ply": ply_file(
            [
                Element("vertex", PLACE, points),
                Element("range_grid", [("list uchar int", "vertex_indices")], [[g] for g in grid]),
            ],
            head=["obj_info num_cols 5", "obj_info num_rows 4"],
        ),
    }
    for name, data in files.items():
        mesh = read(tmp_path, data, name)
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(tmp_path / name))
        np.testing.assert_array_equal(mesh.faces, meshes.current_mesh().face_matrix())
        assert len(mesh.faces)
        assert written(mesh) == data


@given(st.integers(4, 12), st.integers(0, 10**6))
@settings(max_examples=100)
def test_triangles_of_a_polygon_cover_it(corners: int, seed: int) -> None:
    """Star-shaped polygons, most of them concave, have the area of their triangles, none of which is turned over."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * (np.arange(corners) + 0.8 * rng.random(corners)) / corners
    radii = rng.uniform(0.2, 1.0, corners)
    flat = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    faces, polygon, _ = triangulated(flat @ frame[:2] + rng.normal(size=3), np.arange(corners), np.array([corners]))
    assert isinstance(polygon, np.ndarray)
    assert polygon.tolist() == [0] * (corners - 2)
    x, y = flat.T
    area = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    a, b, c = (flat[faces[:, k]] for k in range(3))
    areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert areas.min() >= -1e-12
    assert areas.sum() == pytest.approx(area, rel=1e-12)


def test_colours_of_other_types_are_levels(tmp_path: Path) -> None:
    """Real colours are shares of 1, whole ones of more bits levels of their range; unchanged ones keep their type and bits."""
    for type_, top in (("float", 1.0), ("double", 1.0), ("ushort", 65535), ("uchar", 255)):
        values = [[0, 0.5 * top, top], [top, 0.2 * top, 0.1 * top]]
        if type_.startswith(("u",)):
            values = [[int(v) for v in row] for row in values]
        rows = [[0, 0, k, *row] for k, row in enumerate(values)]
        data = ply_file([Element("vertex", [*PLACE, *((type_, c) for c in ("red", "green", "blue"))], rows)])
        mesh = read(tmp_path, data, f"{type_}.ply")
        expected = np.rint(255 * np.array(values) / top)
        np.testing.assert_allclose(mesh.vertex_attributes["colors"][:, :3], expected, atol=1)
        assert written(mesh) == data
        other = np.full((2, 4), 255, np.uint8)
        again = read(tmp_path, written(mesh.with_attributes({"colors": other})), "again.ply")
        np.testing.assert_array_equal(again.vertex_attributes["colors"], other)


def test_new_colours_beside_a_foreign_alpha_are_opaque(tmp_path: Path) -> None:
    """A column `alpha` without colours is a number of its own; of colours that a step gives it is the opacity."""
    rows = [[*place, 7] for place in SQUARE]
    data = ply_file([Element("vertex", [*PLACE, ("uchar", "alpha")], rows)])
    mesh = read(tmp_path, data)
    colors = np.array([[10, 20, 30, 255]] * 4, dtype=np.uint8)
    assert mesh.source is not None
    assert np.array_equal(mesh.source.document.custom("vertex")["alpha"], [7] * 4)
    again = read(tmp_path, written(mesh.with_attributes({"colors": colors})), "again.ply")
    assert np.array_equal(again.vertex_attributes["colors"], colors)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_vertices_that_are_not_finite_are_left_out_by_name(tmp_path: Path, encoding: str) -> None:
    """They and their faces are said to be gone, and the rows of the others stay theirs."""
    rows = [[0.0, 0.0, 0.0, 1], [float("nan"), 0.0, 0.0, 2], [1.0, 0.0, 0.0, 3], [0.0, 1.0, 0.0, 4]]
    elements = [
        Element("vertex", [*PLACE, ("int", "label")], rows),
        Element("face", [("list uchar int", "vertex_indices")], [[[0, 2, 3]], [[0, 1, 2]]]),
    ]
    (tmp_path / "a.ply").write_bytes(ply_file(elements, encoding))
    reading = read_file(tmp_path / "a.ply")
    assert reading.doubts == ("left out: 1 vertex with a coordinate that is not finite, and 1 face with such a vertex",)
    again = read(tmp_path, written(reading.mesh))
    assert again.source is not None
    assert again.source.document.tables["vertex"].numbers("label").tolist() == [1, 3, 4]
    assert again.faces.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(("type_", "rows"), [("ushort", [[65535, 200, 0], [257, 0, 0]]), ("float", [[255, 1, 0], [1, 0, 0]])])
def test_a_dark_channel_is_dark(tmp_path: Path, type_: str, rows: list[list[int]]) -> None:
    """Red, green and blue share the value of full intensity, also where a channel has small numbers only."""
    properties = [*PLACE, *((type_, color) for color in ("red", "green", "blue"))]
    places: list[list[Any]] = [[0, 0, 0], [1, 0, 0]]
    data = ply_file([Element("vertex", properties, [[*place, *row] for place, row in zip(places, rows, strict=True)])])
    expected = np.array([[255, 1, 0, 255], [1, 0, 0, 255]], np.uint8)
    mesh = read(tmp_path, data)
    np.testing.assert_array_equal(mesh.vertex_attributes["colors"], expected)
    painted = read(tmp_path, written(mesh.with_attributes({"colors": expected[::-1]})), "painted.ply")
    np.testing.assert_array_equal(painted.vertex_attributes["colors"], expected[::-1])


def test_edges_that_are_left_out_are_counted(tmp_path: Path) -> None:
    """Edges that end at a vertex that is not finite are said to be gone."""
    edge = Element("edge", [("int", "vertex1"), ("int", "vertex2")], [[0, 1], [1, 2], [0, 2]])
    data = ply_file([Element("vertex", PLACE, [[0, 0, 0], [float("nan"), 0, 0], [1, 0, 0]]), edge])
    (tmp_path / "a.ply").write_bytes(data)
    words = "left out: 1 vertex with a coordinate that is not finite, and 0 faces and 2 edges with such a vertex"
    assert read_file(tmp_path / "a.ply").doubts == (words,)


@pytest.mark.parametrize("kind", ["triangles", "quad", "strip"])
def test_faces_that_are_turned_over_are_written_so(tmp_path: Path, kind: str) -> None:
    """Faces with the corners that they had, in another order, are not those of the file."""
    rows = {"triangles": [[[0, 1, 2]], [[0, 2, 3]]], "quad": [[[0, 1, 2, 3]]], "strip": [[[0, 1, 3, 2]]]}[kind]
    element = Element("tristrips" if kind == "strip" else "face", [("list int int", "vertex_indices")], rows)
    mesh = read(tmp_path, ply_file([Element("vertex", PLACE, SQUARE), element]))
    turned = replace(mesh, faces=mesh.faces[:, ::-1])
    again = read(tmp_path, written(turned), "again.ply")
    np.testing.assert_array_equal(face_normals(again.vertices, again.faces), -face_normals(mesh.vertices, mesh.faces))


def test_elements_that_name_deleted_faces_are_left_out(tmp_path: Path) -> None:
    """Numbers of faces are not those of the file any more, and this is said."""
    faces = Element("face", [("list uchar int", "vertex_indices")], [[[0, 1, 2]], [[0, 2, 3]]])
    part = Element("part", [("list uchar int", "face_indices")], [[[1]]])
    mesh = read(tmp_path, ply_file([Element("vertex", PLACE, SQUARE), faces, part]))
    assert b"element part 1" in written(mesh)
    target = io.BytesIO()
    (note,) = write_ply(apply_edit(mesh, Edit(delete_faces=np.array([True, False]))), target)
    assert note == "element 'part' (1), which names faces by their numbers, is left out"
    assert b"element part" not in target.getvalue()


def test_textures_that_steps_give_and_take_are_those_of_the_file(tmp_path: Path) -> None:
    """A file without textures gets two, and of two one is left, with the numbers of its faces."""
    faces = Element("face", [("list uchar int", "vertex_indices")], [[[0, 1, 2]], [[0, 2, 3]]])
    mesh = read(tmp_path, ply_file([Element("vertex", PLACE, SQUARE), faces]))
    both, one = (tuple(Texture(name, None) for name in names) for names in (("a.png", "b c.png"), ("d.png",)))
    of_faces: dict[str, Any] = {"wedge_texture_coordinates": np.zeros((2, 3, 2)), "texture": np.array([0, 1], np.int32)}
    painted = read(tmp_path, written(replace(mesh.with_attributes(face=of_faces), textures=both)), "painted.ply")
    assert painted.textures == both
    assert painted.face_attributes["texture"].tolist() == [0, 1]
    left = replace(painted.with_attributes(face={"texture": np.zeros(2, np.int32)}), textures=one)
    again = read(tmp_path, written(left), "again.ply")
    assert again.textures == one
    assert again.face_attributes["texture"].tolist() == [0, 0]


def test_deleted_faces_of_a_strip_are_gone(tmp_path: Path) -> None:
    """A mesh of triangle strips that loses all faces is written as a cloud."""
    strip = Element("tristrips", [("list int int", "vertex_indices")], [[[0, 1, 2, 3]]])
    mesh = read(tmp_path, ply_file([Element("vertex", PLACE, SQUARE), strip]))
    for kept in ([True] * 4, [True, False, False, True]):
        again = read(tmp_path, written(mesh.part(np.array(kept), np.zeros(2, np.bool_))), "again.ply")
        assert (len(again.vertices), len(again.faces)) == (sum(kept), 0)


def test_faces_without_the_only_texture_stay_without_it(tmp_path: Path) -> None:
    """Of a mesh with one texture, faces that do not show it are written so."""
    numbers = np.array([0, -1], np.int32)
    attributes: dict[str, Any] = {"wedge_texture_coordinates": np.zeros((2, 3, 2)), "texture": numbers}
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    vertices = np.array(SQUARE, float)
    mesh = MeshData(vertices=vertices, faces=faces, face_attributes=attributes, textures=(Texture("t.png", None),))
    np.testing.assert_array_equal(read(tmp_path, written(mesh)).face_attributes["texture"], numbers)


def test_texture_coordinates_of_polygons(tmp_path: Path) -> None:
    """The corners of the triangles of a polygon have the coordinates that the polygon's list gives its corners."""
    pairs: NDArray[Any] = np.arange(10.0).reshape(5, 2) / 16
    points: list[list[Any]] = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 0.5, 0], [0, 2, 0]]
    elements = [
        Element("vertex", PLACE, points),
        Element(
            "face",
            [("list uchar int", "vertex_indices"), ("list uchar float", "texcoord")],
            [[[0, 1, 2, 3, 4], pairs.ravel().tolist()]],
        ),
    ]
    data = ply_file(elements, head=["comment TextureFile t.png"])
    mesh = read(tmp_path, data)
    np.testing.assert_array_equal(mesh.face_attributes["wedge_texture_coordinates"], pairs[mesh.faces])
    assert written(mesh) == data


def test_what_a_text_says_twice_is_refused(tmp_path: Path) -> None:
    """Two names for the corners, an element or a property twice, an index that is no whole number: refused with the reason."""
    face = Element("face", [("list uchar int", "vertex_indices"), ("list uchar int", "vertex_index")], [[[0, 1, 2], [0, 1, 2]]])
    for elements, reason in (
        ([Element("vertex", PLACE, SQUARE), face], "have their corners twice"),
        ([Element("vertex", PLACE, SQUARE)] * 2, "declares an element twice"),
        ([Element("vertex", [*PLACE, ("float", "x")], [[*p, 0] for p in SQUARE])], "has a property twice"),
        ([Element("vertex", PLACE[:2], [[0, 0]])], "no numbers x, y and z"),
        (
            [Element("vertex", PLACE, SQUARE), Element("face", [("list uchar float", "vertex_indices")], [[[0, 1.5, 2]]])],
            "a number that is not whole",
        ),
    ):
        with pytest.raises(InputError, match=reason):
            read(tmp_path, ply_file(elements))


def test_faces_without_corners_are_kept(tmp_path: Path) -> None:
    """Rows of faces whose corners have no known name are no faces of the mesh, and are written as they were."""
    rows: list[list[Any]] = [[[0, 1, 2]], [[0, 2, 3]]]
    elements = [Element("vertex", PLACE, SQUARE), Element("face", [("list uchar int", "corners")], rows)]
    for encoding in ENCODINGS:
        data = ply_file(elements, encoding)
        mesh = read(tmp_path, data)
        assert not len(mesh.faces)
        assert written(mesh) == data
        moved_data = written(moved(mesh, mesh.vertices + 1))
        assert len(moved_data) == len(data)


@pytest.mark.parametrize("end", [b"", b"\n", b"\r\n\n"])
def test_faces_of_points_in_a_text(tmp_path: Path, end: bytes) -> None:
    """Faces and edges that points get begin on a line of their own, behind the lines of the points as they were."""
    data = ply_file([Element("vertex", PLACE, SQUARE)], "ascii").rstrip(b"\n") + end
    mesh = replace(read(tmp_path, data), faces=np.array([[0, 1, 2]], np.int32), edges=np.array([[2, 3]], np.int32))
    assert b"\n0 2 0\n3 0 1 2\n2 3\n" in written(mesh)
    np.testing.assert_array_equal(read(tmp_path, written(mesh)).faces, mesh.faces)


def test_polygons_of_other_formats_are_written(tmp_path: Path) -> None:
    """A polygon of a mesh that comes from no PLY file is a polygon in it; where corners have texture coordinates, triangles.

    MeshLab opens no polygons with such coordinates.
    """
    wedges = np.arange(18.0).reshape(3, 3, 2)
    mesh = MeshData(
        vertices=np.array([*SQUARE, [9, 9, 9]], float),
        faces=np.array([[0, 1, 2], [0, 2, 3], [0, 1, 4]]),
        face_attributes={"polygon": np.array([4, 4, -1])},
    )
    again = read(tmp_path, written(mesh))
    assert again.face_attributes["polygon"].tolist() == [0, 0, -1]
    np.testing.assert_array_equal(again.faces, mesh.faces)
    textured = read(tmp_path, written(mesh.with_attributes(face={"wedge_texture_coordinates": wedges})))
    np.testing.assert_array_equal(textured.faces, mesh.faces)
    np.testing.assert_array_equal(textured.face_attributes["wedge_texture_coordinates"], wedges)
    assert "polygon" not in textured.face_attributes


@pytest.mark.parametrize(("type_", "levels"), [("ushort", (200, 100, 60000)), ("float", (1, 0, 255))])
def test_dark_vertices_that_are_left_stay_dark(tmp_path: Path, type_: str, levels: tuple[int, ...]) -> None:
    """Vertices whose numbers are small in the range of the file are nearly black, also without the others."""
    properties = [*PLACE, *((type_, color) for color in ("red", "green", "blue"))]
    rows = [[k, 0, 0, level, level, level] for k, level in enumerate(levels)]
    mesh = read(tmp_path, ply_file([Element("vertex", properties, rows)]))
    again = read(tmp_path, written(mesh.part(np.array([True, True, False]))), "again.ply")
    np.testing.assert_array_equal(again.vertex_attributes["colors"], mesh.vertex_attributes["colors"][:2])


def test_faint_opacities_stay_faint(tmp_path: Path) -> None:
    """Among floats up to 255 opacities of 0 and 1 alone are no shares."""
    properties = [*PLACE, *(("float", channel) for channel in ("red", "green", "blue", "alpha"))]
    mesh = read(tmp_path, ply_file([Element("vertex", properties, [[k, 0, 0, 255, 3, 2, 200] for k in range(2)])]))
    colors = np.array([[255, 3, 2, 1], [7, 3, 2, 0]], np.uint8)
    again = read(tmp_path, written(mesh.with_attributes({"colors": colors})), "again.ply")
    np.testing.assert_array_equal(again.vertex_attributes["colors"], colors)


def test_custom_numbers_of_polygons_are_those_of_their_triangles(tmp_path: Path) -> None:
    """Both triangles of a square have its number, and the numbers of rows are none of triangles of a strip."""
    points = Element("vertex", PLACE, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]])
    faces = Element("face", [("list uchar int", "vertex_indices"), ("int", "part")], [[[0, 1, 2, 3], 7], [[1, 4, 2], 9]])
    mesh = read(tmp_path, ply_file([points, faces]))
    assert mesh.source is not None
    assert mesh.source.document.custom("face")["part"].tolist() == [7, 7, 9]
    strip = Element("tristrips", [("list int int", "vertex_indices")], [[[0, 1, 2]]])
    mesh = read(tmp_path, ply_file([points, Element("face", [("int", "part")], [[7]]), strip]), "strip.ply")
    assert mesh.source is not None
    assert (len(mesh.faces), mesh.source.document.custom("face")) == (1, {})


@pytest.mark.parametrize("extension", ["ply", "off"])
def test_each_triangle_of_a_polygon_keeps_its_colour(tmp_path: Path, extension: str) -> None:
    """Where a step colours the triangles of a square differently the square is written as triangles, and a message says so."""
    points = Element("vertex", PLACE, [[*place] for place in (*SQUARE, (9, 9, 9))])
    faces = Element("face", [("list uchar int", "vertex_indices"), ("int", "part")], [[[0, 1, 2, 3], 7], [[0, 1, 4], 8]])
    mesh = read(tmp_path, ply_file([points, faces]))
    colors = np.array([[1, 2, 3, 255], [4, 5, 6, 255], [4, 5, 6, 255]], np.uint8)
    warnings = save(mesh.with_attributes(face={"colors": colors}), tmp_path / f"b.{extension}")
    assert f"b.{extension}: polygons whose triangles have different values are written as triangles (1)" in warnings
    again = read_file(tmp_path / f"b.{extension}").mesh
    np.testing.assert_array_equal(again.faces, mesh.faces)
    np.testing.assert_array_equal(again.face_attributes["colors"], colors)
    if extension == "ply":
        assert again.source is not None
        assert again.source.document.custom("face")["part"].tolist() == [7, 7, 8]


def test_small_types_are_written_without_a_warning_of_numpy(tmp_path: Path) -> None:
    """Numbers of a byte or two, such as the scan angles of LAS files, become properties of the type that holds them."""
    values = {kind: np.array([np.iinfo(kind).min, np.iinfo(kind).max], kind) for kind in ("i1", "i2", "u1", "u2", "u4")}
    assert save(MeshData(vertices=np.eye(3)[:2], vertex_attributes=values), tmp_path / "a.ply") == ()
    document = read_file(tmp_path / "a.ply").mesh.source.document  # type: ignore[union-attr]
    for kind, expected in values.items():
        assert document.custom("vertex")[kind].tolist() == expected.tolist()


@pytest.mark.parametrize(("type_", "red"), [("ushort", 40001), ("float", 0.123456), ("double", 0.1)])
def test_vertices_that_are_not_painted_keep_every_bit_of_their_colours(tmp_path: Path, type_: str, red: float) -> None:
    """A step that paints one vertex of a file with deep colours leaves the numbers of the others as they are."""
    rows = [[k, 0, 0, red, 1 if type_ != "ushort" else 65535, 0] for k in range(2)]
    data = ply_file([Element("vertex", [*PLACE, *((type_, color) for color in ("red", "green", "blue"))], rows)])
    mesh = read(tmp_path, data)
    colors = mesh.vertex_attributes["colors"].copy()
    colors[1] = 7, 8, 9, 255
    again = read(tmp_path, written(mesh.with_attributes({"colors": colors})), "again.ply")
    np.testing.assert_array_equal(again.vertex_attributes["colors"], colors)
    (now, before) = (m.source.document.tables["vertex"].columns["red"] for m in (again, mesh))  # type: ignore[union-attr]
    assert now[0] == before[0]
