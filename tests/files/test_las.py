"""LAS and LAZ files: all dimensions, the reference system, and coordinates to the step of the file."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest

from pymeshfair.files.errors import InputError, OutputError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.outputs import MadeFrom, check_output
from pymeshfair.mesh_data import MeshData, moved

from ..running.runs import session_report
from .round_trips import assert_same, read, save
from .surveys import scan

WKT = 'PROJCS["x",GEOGCS["y",UNIT["degree",0.0174532925199433]],UNIT["%s",%s],AXIS["X",EAST],AXIS["Y",NORTH]]'


@pytest.mark.parametrize(("form", "extension"), [(1, "las"), (2, "las"), (3, "laz"), (6, "las"), (7, "laz"), (8, "laz")])
def test_every_dimension_is_kept(tmp_path: Path, form: int, extension: str) -> None:
    """Each dimension is an attribute of its name and type, and each point is written with the bytes that it had."""
    path, output = tmp_path / f"in.{extension}", tmp_path / f"out.{extension}"
    source = scan(path, form=form) if form != 2 else coloured(path)
    mesh = read_file(path).mesh
    np.testing.assert_array_equal(mesh.vertices, np.stack([source.x, source.y, source.z], axis=1))
    for name in set(source.point_format.dimension_names) - {"X", "Y", "Z", "red", "green", "blue"}:
        np.testing.assert_array_equal(mesh.vertex_attributes[name], source[name])
        assert mesh.vertex_attributes[name].dtype == np.asarray(source[name]).dtype
    assert save(mesh, output) == ()
    found = laspy.read(output)
    assert found.points.array.tobytes() == source.points.array.tobytes()
    assert found.header.version == source.header.version
    np.testing.assert_array_equal(found.header.scales, source.header.scales)
    np.testing.assert_array_equal(found.header.offsets, source.header.offsets)
    assert [v.record_data for v in found.header.vlrs if v.record_id == 7] == [b"kept"]
    kept = np.arange(len(mesh.vertices)) % 3 == 0
    save(mesh.part(kept), tmp_path / f"part.{extension}")
    assert laspy.read(tmp_path / f"part.{extension}").points.array.tobytes() == source.points.array[kept].tobytes()


def coloured(path: Path) -> Any:
    """A cloud with colours of 16 bits."""
    header = laspy.LasHeader(point_format=2, version="1.2")
    header.vlrs.append(laspy.VLR("somebody", 7, "a note", b"kept"))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.random.default_rng(1).random((3, 90)) * 100
    cloud.red, cloud.green, cloud.blue = np.random.default_rng(2).integers(0, 1 << 16, (3, 90))
    cloud.write(path)
    return cloud


def test_colours_that_a_step_changed(tmp_path: Path) -> None:
    """Points that keep their colour keep its 16 bits; others get the level; a format without colours becomes one with them."""
    source = coloured(tmp_path / "a.las")
    mesh = read_file(tmp_path / "a.las").mesh
    levels = np.array(mesh.vertex_attributes["colors"])
    np.testing.assert_array_equal(levels[:, 0], np.rint(np.asarray(source.red) / 257))
    levels[:7, :3] = [1, 2, 3]
    assert save(mesh.with_attributes({"colors": levels}), tmp_path / "b.laz") == ()
    found = laspy.read(tmp_path / "b.laz")
    np.testing.assert_array_equal(found.red[7:], source.red[7:])
    np.testing.assert_array_equal(found.blue[:7], np.full(7, 3 * 257))
    scan(tmp_path / "c.las", form=1)
    plain = read_file(tmp_path / "c.las").mesh
    colors = np.full((len(plain.vertices), 4), 255, np.uint8)
    assert save(plain.with_attributes({"colors": colors}), tmp_path / "d.las") == ()
    again = read_file(tmp_path / "d.las").mesh
    np.testing.assert_array_equal(again.vertex_attributes["colors"], colors)
    assert laspy.read(tmp_path / "d.las").point_format.id == 3
    for name in plain.vertex_attributes:
        np.testing.assert_array_equal(again.vertex_attributes[name], plain.vertex_attributes[name])


def test_a_mesh_of_no_file(tmp_path: Path) -> None:
    """Attributes of any type are dimensions; the step of the coordinates is fine enough; the same mesh gives the same bytes."""
    rng = np.random.default_rng(1)
    attributes: dict[str, Any] = {
        "normals": rng.random((50, 3)),
        "scalars": rng.random(50),
        "label": np.arange(50, dtype=np.int16),
        "flow": rng.random((50, 3)),
        "intensity": np.arange(50, dtype=np.uint16),
        "colors": np.full((50, 4), 255, np.uint8),
    }
    mesh = MeshData(vertices=rng.random((50, 3)) * 20 + [5e5, 5.4e6, 300], vertex_attributes=attributes)
    notes = save(mesh, tmp_path / "a.laz", resolution=0.02)
    assert notes == (f"a.laz: its scale is 1e-05, and its offset 500000 5.4e+06 {np.floor(mesh.vertices[:, 2].min()):g}",)
    again = read_file(tmp_path / "a.laz").mesh
    assert np.abs(again.vertices - mesh.vertices).max() <= 1e-3 * 0.02
    for name, values in attributes.items():
        np.testing.assert_array_equal(again.vertex_attributes[name], values)
    save(mesh, tmp_path / "b.laz", resolution=0.02)
    assert (tmp_path / "a.laz").read_bytes() == (tmp_path / "b.laz").read_bytes()
    with pytest.raises(OutputError, match="need more than the 32 bits of the format"):
        save(mesh, tmp_path / "c.laz", resolution=1e-9)


def test_numbers_that_a_dimension_cannot_hold(tmp_path: Path) -> None:
    """An intensity from 0 to 1 becomes one of 16 bits; other numbers beside the format's range get a dimension of their own."""
    rng = np.random.default_rng(2)
    attributes: dict[str, Any] = {
        "intensity": rng.random(50),
        "classification": np.arange(250, 300, dtype=np.int32),
        "user_data": np.arange(50, dtype=np.float64),
        "point_source_id": np.arange(50) / 2.0,
    }
    notes = save(MeshData(vertices=rng.random((50, 3)), vertex_attributes=attributes), tmp_path / "a.las", resolution=0.02)
    assert any("its intensity from 0 to 1 is stored as whole numbers from 0 to 65535" in note for note in notes)
    assert any("'classification' cannot hold numbers from 250 to 299: they are in 'classification_'" in note for note in notes)
    assert any("'point_source_id' cannot hold fractions from 0 to 24.5: they are in" in note for note in notes)
    again = read_file(tmp_path / "a.las").mesh.vertex_attributes
    np.testing.assert_array_equal(again["intensity"], np.rint(attributes["intensity"] * 65535))
    np.testing.assert_array_equal(again["classification_"], attributes["classification"])
    np.testing.assert_array_equal(again["user_data"], attributes["user_data"])


def test_attributes_with_the_names_of_coordinates_are_no_coordinates(tmp_path: Path) -> None:
    """They get dimensions of their own, and the points stay where they are."""
    values = np.arange(50)
    names = ("X", "y", "bit_fields", "classification_flags")
    mesh = MeshData(vertices=np.random.default_rng(3).random((50, 3)), vertex_attributes=dict.fromkeys(names, values))
    save(mesh, tmp_path / "a.las", resolution=0.02)
    again = read_file(tmp_path / "a.las").mesh
    assert np.abs(again.vertices - mesh.vertices).max() <= 1e-3 * 0.02
    for name in names:
        np.testing.assert_array_equal(again.vertex_attributes[f"{name}_"], values)


def test_moved_points_get_a_finer_step_where_they_need_one(tmp_path: Path) -> None:
    """The scale of the file stays if it moves no point by a share of the distance of points that shows."""
    scan(tmp_path / "a.las", form=6)
    mesh = read_file(tmp_path / "a.las").mesh
    other = moved(mesh, mesh.vertices + 1e-4)
    assert save(other, tmp_path / "b.las", resolution=1.0) == ()
    (note,) = save(other, tmp_path / "c.las", resolution=0.05)
    assert "its scale is 0.0001" in note
    assert np.abs(read_file(tmp_path / "c.las").mesh.vertices - other.vertices).max() <= 5e-5


@pytest.mark.parametrize(("unit", "factor", "expected"), [("metre", "1", "m"), ("US survey foot", "0.3048006096", "ft")])
def test_units_of_reference_systems(tmp_path: Path, unit: str, factor: str, expected: str) -> None:
    """A projected system says the unit, one of angles none; the system is kept in LAS files and named for others."""
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr(WKT % (unit, factor)))
    header.global_encoding.wkt = True
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.random.default_rng(1).random((3, 9))
    cloud.write(tmp_path / "a.las")
    mesh = read_file(tmp_path / "a.las").mesh
    assert mesh.unit == expected
    save(mesh, tmp_path / "b.laz")
    assert WKT % (unit, factor) in [getattr(v, "string", "") for v in laspy.read(tmp_path / "b.laz").header.vlrs]
    assert save(mesh, tmp_path / "c.ply") == ("c.ply does not hold these contents of a.las: its coordinate reference system",)


def test_the_unit_of_the_ellipsoid_is_not_that_of_the_coordinates(tmp_path: Path) -> None:
    """In the second version of the text the ellipsoid, in metres, precedes the coordinates, in feet."""
    ellipsoid = 'ELLIPSOID["GRS 1980",6378137,298.257222101,LENGTHUNIT["metre",1]]'
    axes = 'CS[Cartesian,2],AXIS["easting",east],AXIS["northing",north],LENGTHUNIT["US survey foot",0.3048006096]'
    header = laspy.LasHeader(point_format=6, version="1.4")
    system = laspy.vlrs.known.WktCoordinateSystemVlr(f'PROJCRS["x",BASEGEOGCRS["y",DATUM["z",{ellipsoid}]],{axes}]')
    header.vlrs.append(system)
    header.global_encoding.wkt = True
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.random.default_rng(1).random((3, 9))
    cloud.write(tmp_path / "a.las")
    assert read_file(tmp_path / "a.las").mesh.unit == "ft"


def test_a_format_that_keeps_the_unit_of_a_cloud_is_named(tmp_path: Path) -> None:
    """A LAS file keeps the unit of a LAS file; .3mf, which holds no clouds, and .glb, which rounds surveys, are not named."""
    system = laspy.vlrs.known.WktCoordinateSystemVlr(WKT % ("foot", "0.3048"))
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.vlrs.append(system)
    header.global_encoding.wkt = True
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.random.default_rng(1).random((3, 9))
    cloud.write(tmp_path / "a.las")
    report = session_report(tmp_path / "a.las", tmp_path / "b.ply")
    assert report["warnings"][-1] == "b.ply does not hold the unit of a.las, ft; .las keeps it"


def test_what_is_no_whole_file_is_refused(tmp_path: Path) -> None:
    """A file that ends too early, one that declares too much, and one of another kind are refused in words."""
    scan(tmp_path / "a.las", form=3)
    scan(tmp_path / "b.laz", form=3)
    whole, packed = (tmp_path / "a.las").read_bytes(), (tmp_path / "b.laz").read_bytes()
    declares = whole[:107] + b"\xff\xff\xff\x7f" + whole[111:]
    for name, data in (("c.las", whole[: len(whole) // 2]), ("d.laz", packed[: len(packed) // 2]), ("e.las", declares)):
        with pytest.raises(InputError):
            read(tmp_path / name, data)
    with pytest.raises(InputError, match="does not begin with 'LASF'"):
        read(tmp_path / "f.laz", b"not at all")
    for name, data in (("h.las", whole), ("i.laz", packed)):
        with pytest.raises(InputError, match="declares 4,294,967,295 variable length records, and there is room for"):
            read(tmp_path / name, data[:100] + b"\xff" * 4 + data[104:])
    # The record that says how it is compressed: in a way that ends lazrs by a panic.
    at = packed.index(b"laszip encoded") + 52
    unknown = packed[:at] + b"\x01\x00" + packed[at + 2 : at + 12] + b"\xff" * 4 + packed[at + 16 :]
    with pytest.raises(InputError, match="lazrs cannot decompress it"):
        read(tmp_path / "g.laz", unknown)


def test_without_the_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command that installs it is named, before any work; COPC files are not written."""
    scan(tmp_path / "a.las", form=3)
    with pytest.raises(OutputError, match=r"COPC files are read and not written; name the output \.laz"):
        check_output(tmp_path / "b.copc.laz", MadeFrom(tmp_path / "a.las", ""), overwrite=False)
    monkeypatch.setitem(sys.modules, "laspy", None)
    command = r"python -m pip install 'pymeshfair\[las\]'"
    with pytest.raises(InputError, match=command):
        read_file(tmp_path / "a.las")
    with pytest.raises(OutputError, match=command):
        check_output(tmp_path / "b.laz", MadeFrom(tmp_path / "a.las", ""), overwrite=False)
    with pytest.raises(OutputError, match=command):
        save(MeshData(vertices=np.eye(3)), tmp_path / "c.las")


def test_records_of_copc_are_left_out(tmp_path: Path) -> None:
    """A COPC file is read as the LAZ file that it is; what is written has another order, and does not say that it is COPC."""
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.vlrs.append(laspy.VLR("copc", 1, "info", bytes(160)))
    header.vlrs.append(laspy.VLR("somebody", 7, "a note", b"kept"))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.random.default_rng(1).random((3, 9))
    cloud.write(tmp_path / "a.copc.laz")
    mesh = read_file(tmp_path / "a.copc.laz").mesh
    assert save(mesh, tmp_path / "b.laz") == ()
    assert [v.user_id for v in laspy.read(tmp_path / "b.laz").header.vlrs] == ["somebody"]
    np.testing.assert_array_equal(read_file(tmp_path / "b.laz").mesh.vertices, mesh.vertices)


def test_the_same_cloud(tmp_path: Path) -> None:
    """What is read, written and read again is the same mesh."""
    scan(tmp_path / "a.laz", form=7)
    mesh = read_file(tmp_path / "a.laz").mesh
    save(mesh, tmp_path / "b.las")
    assert_same(read_file(tmp_path / "b.las").mesh, mesh)


def test_whole_numbers_that_a_declared_dimension_cannot_hold_widen_it(tmp_path: Path) -> None:
    """Labels of 8 bits that became 300 are read back as 300, and labels that still fit keep their type."""
    path, output = tmp_path / "in.las", tmp_path / "out.las"
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.add_extra_dims([laspy.ExtraBytesParams("label", "u1"), laspy.ExtraBytesParams("part", "u1")])
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.random.default_rng(0).uniform(size=(3, 4))
    cloud.label = cloud.part = np.arange(4, dtype=np.uint8)
    cloud.write(path)
    mesh = read_file(path).mesh
    numbers = {"label": np.array([1, 2, 300, -4], np.int32), "part": np.array([3, 2, 1, 255], np.int32)}
    save(replace(mesh, vertex_attributes={**mesh.vertex_attributes, **numbers}), output)
    found = laspy.read(output)
    for name, values in numbers.items():
        np.testing.assert_array_equal(found[name], values)
    assert found["part"].dtype == np.uint8


def test_dark_points_that_are_left_stay_dark(tmp_path: Path) -> None:
    """The points of a cloud of 16-bit colours whose numbers are up to 255 are nearly black, also without the others."""
    header = laspy.LasHeader(point_format=2, version="1.2")
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = np.eye(3)
    cloud.red, cloud.green, cloud.blue = [[200, 100, 60000]] * 3
    cloud.write(tmp_path / "a.las")
    mesh = read_file(tmp_path / "a.las").mesh
    save(mesh.part(np.array([True, True, False])), tmp_path / "b.las")
    colors = read_file(tmp_path / "b.las").mesh.vertex_attributes["colors"]
    np.testing.assert_array_equal(colors, mesh.vertex_attributes["colors"][:2])


def test_a_column_titled_scalars_stays_beside_the_scalars(tmp_path: Path) -> None:
    """The column of a text and the scalars that a step computes have a dimension each."""
    mesh = read(tmp_path / "a.txt", "x y z scalars\n1 2 3 0.5\n4 5 6 0.25\n")
    save(mesh.with_attributes({"scalars": np.array([7.5, 8.5])}), tmp_path / "a.las")
    found = laspy.read(tmp_path / "a.las")
    assert (found["scalars"].tolist(), found["scalars_"].tolist()) == ([7.5, 8.5], [0.5, 0.25])


def test_an_attribute_named_like_a_channel_stays_beside_the_colours(tmp_path: Path) -> None:
    """It gets a dimension of its own, as one named like a coordinate does."""
    colors = np.full((2, 4), 255, np.uint8)
    mesh = MeshData(vertices=np.eye(3)[:2], vertex_attributes={"colors": colors, "red": np.array([7, 8], np.int32)})
    save(mesh, tmp_path / "a.las")
    found = laspy.read(tmp_path / "a.las")
    assert (found["red"].tolist(), found["red_"].tolist()) == ([65535, 65535], [7, 8])


@pytest.mark.parametrize("names", [("red", "green", "blue"), ("NormalX", "NormalY", "NormalZ")])
def test_attributes_with_all_names_of_channels_are_not_read_as_these(tmp_path: Path, names: tuple[str, str, str]) -> None:
    """Colours of 12 bits, as in a text, are no colours of 8; beside colours or normals that a step made, they stay, too."""
    numbers = np.array([[4095, 0, 7], [300, 1, 2]], np.int32)
    channels = dict(zip(names, numbers.T, strict=True))
    made: dict[str, Any] = {"colors": np.full((2, 4), 255, np.uint8), "normals": np.eye(3)[:2]}
    for path, more in ((tmp_path / "a.las", {}), (tmp_path / "b.las", made)):
        save(MeshData(vertices=np.eye(3)[:2], vertex_attributes={**channels, **more}), path)
        found = read_file(path).mesh.vertex_attributes
        np.testing.assert_array_equal(np.stack([found[f"{name}_"] for name in names], axis=1), numbers)
        assert {name for name in made if name in found} == more.keys()
