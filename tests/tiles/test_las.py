"""LAS and LAZ clouds by tiles: the probabilities of their coordinates, every dimension of what is kept as it was."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any, cast

import laspy
import numpy as np
import pytest

from pymeshfair.files.errors import ContentsError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.provenance import provenance_path
from pymeshfair.filters.outliers import local_outlier_probability
from pymeshfair.tiles.cloud import Cloud, do_step, write_cloud
from pymeshfair.tiles.sources import E57Cloud, LasCloud
from pymeshfair.tiles.workers import Tasks
from tests.commands.command_line import invoke
from tests.files.round_trips import save
from tests.files.test_e57 import survey
from tests.tiles.tiling import Here, loop


def scan(path: Path, *, form: int, count: int = 700) -> Any:
    """A hillside with some points above it, in the coordinates of a map, with all that a scanner says of a point."""
    random = np.random.default_rng(form)
    header = laspy.LasHeader(point_format=form, version="1.4" if form > 5 else "1.2")
    header.scales, header.offsets = [1e-3, 1e-3, 1e-4], [5e5, 5.4e6, 300.0]
    header.add_extra_dim(laspy.ExtraBytesParams("amplitude", "uint16"))
    header.vlrs.append(laspy.VLR("somebody", 7, "a note", b"kept"))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y = 5e5 + random.uniform(0, 50, count), 5.4e6 + random.uniform(0, 50, count)
    cloud.z = 300 + 0.2 * (cloud.x - 5e5) + random.normal(scale=0.02, size=count) + 9.0 * (random.random(count) < 0.03)
    for name, most in (
        ("intensity", 60000),
        ("classification", 20),
        ("return_number", 5),
        ("user_data", 200),
        ("amplitude", 9999),
    ):
        cloud[name] = random.integers(0, most, count)
    cloud.gps_time = np.arange(count) / 7.0
    cloud.write(path)
    return cloud


@pytest.mark.parametrize(("form", "extension"), [(1, "las"), (3, "laz"), (6, "las"), (7, "laz")])
def test_every_dimension_is_kept(form: int, extension: str, tmp_path: Path) -> None:
    """What is kept is what LoOP keeps, each point with the bytes it had, and the probability as the scalar that readers find."""
    source = scan(tmp_path / f"in.{extension}", form=form)
    points = np.stack([source.x, source.y, source.z], axis=1)
    expected = local_outlier_probability(points, neighbors=9, extent=2.0)
    cloud = Cloud(LasCloud(tmp_path / f"in.{extension}"), tmp_path)
    cloud, values, _ = do_step(
        cloud,
        loop(1, 9, 2.0, 0.7),
        cast("Tasks", Here()),
        10**6,
        progress=lambda _: None,
        most=100,
    )
    count = write_cloud(cloud, tmp_path / f"out.{extension}", 90)
    kept = expected <= 0.7
    assert count == np.count_nonzero(kept) == len(points) - values["selected_vertices"] < len(points)
    found = laspy.read(tmp_path / f"out.{extension}")
    for name in source.points.array.dtype.names:
        np.testing.assert_array_equal(found.points.array[name], source.points.array[name][kept])
    np.testing.assert_array_equal(found["scalars"], expected[kept])
    reading = read_file(tmp_path / f"out.{extension}")
    np.testing.assert_array_equal(reading.mesh.vertex_scalars, expected[kept])
    np.testing.assert_array_equal(found.header.scales, source.header.scales)
    np.testing.assert_array_equal(found.header.offsets, source.header.offsets)
    assert found.header.version == source.header.version
    assert [v.record_data for v in found.header.vlrs if v.record_id == 7] == [b"kept"]
    np.testing.assert_array_equal(found.header.maxs, points[kept].max(axis=0))


@pytest.mark.parametrize("options", [{}, {"scales": np.array([0.01]), "offsets": np.array([0.0])}], ids=["whole", "scaled"])
def test_probabilities_replace_whole_numbers(options: dict[str, Any], tmp_path: Path) -> None:
    """A dimension `scalars` of integers becomes one of real numbers, by tiles and in one piece in the same bytes."""
    source = scan(tmp_path / "plain.las", form=6)
    source.add_extra_dims([laspy.ExtraBytesParams("scalars", "u2", **options), laspy.ExtraBytesParams("echo", "u1")])
    source["scalars"], source["echo"] = np.arange(len(source)) % 600, np.arange(len(source)) % 3
    source.write(tmp_path / "in.las")
    expected = local_outlier_probability(np.stack([source.x, source.y, source.z], axis=1), neighbors=9, extent=2.0)
    cloud, pool = Cloud(LasCloud(tmp_path / "in.las"), tmp_path), cast("Tasks", Here())
    cloud, _, _ = do_step(cloud, loop(1, 9, 2.0, 0.7), pool, 10**6, progress=lambda _: None, most=100)
    write_cloud(cloud, tmp_path / "tiled.las", 1000)
    kept, mesh = expected <= 0.7, read_file(tmp_path / "in.las").mesh
    save(mesh.with_attributes({"scalars": expected}).part(kept), tmp_path / "whole.las")
    assert (tmp_path / "tiled.las").read_bytes() == (tmp_path / "whole.las").read_bytes()
    found = laspy.read(tmp_path / "tiled.las")
    np.testing.assert_array_equal(found["scalars"], expected[kept])
    np.testing.assert_array_equal(found["echo"], source["echo"][kept])
    save(mesh, tmp_path / "same.las")
    assert laspy.read(tmp_path / "same.las").points.array.tobytes() == source.points.array.tobytes()


def test_a_copc_file_is_cleaned(tmp_path: Path) -> None:
    """It becomes a LAZ file with the same points, without the octree that no longer fits; a name that promises one is refused."""
    scan(tmp_path / "plain.laz", form=7)
    cloud = laspy.read(tmp_path / "plain.laz")
    cloud.header.vlrs.insert(0, laspy.VLR("copc", 1, "copc info", struct.pack("<5d2Q2d11Q", *range(20))))
    cloud.header.evlrs = laspy.vlrs.vlrlist.VLRList([laspy.VLR("copc", 1000, "hierarchy", bytes(32))])
    cloud.write(tmp_path / "in.copc.laz")
    for name in ("plain", "in.copc"):
        done = invoke(
            "run", "remove_outliers", tmp_path / f"{name}.laz", "-o", tmp_path / f"of {name.replace('.', ' ')}.laz", "--tiles"
        )
        assert done.exit_code == 0, done.stderr
    cleaned = [laspy.read(tmp_path / f"of {name.replace('.', ' ')}.laz") for name in ("plain", "in.copc")]
    np.testing.assert_array_equal(cleaned[0].points.array, cleaned[1].points.array)
    assert not [record for record in cleaned[1].header.vlrs if record.user_id == "copc"]
    done = invoke("run", "remove_outliers", tmp_path / "plain.laz", "-o", tmp_path / "out.copc.laz", "--tiles")
    assert done.exit_code == 1
    assert "name the output .laz" in done.stderr


def test_the_unit_of_the_file_is_taken(tmp_path: Path) -> None:
    """That of its reference system is in the document and in the provenance, as in one piece; rows of surfaces are left out."""
    scan(tmp_path / "plain.laz", form=7)
    cloud = laspy.read(tmp_path / "plain.laz")
    cloud.header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr('PROJCS["x",UNIT["metre",1]]'))
    cloud.write(tmp_path / "in.laz")
    done = invoke("run", "remove_outliers", tmp_path / "in.laz", "-o", tmp_path / "out.laz", "--tiles", "--json")
    assert json.loads(done.stdout)["unit"] == "m"
    record = json.loads(provenance_path(tmp_path / "out.laz").read_text("utf-8"))
    assert record["input"]["unit"] == record["measures"]["unit"] == "m"
    done = invoke("run", "remove_outliers", tmp_path / "in.laz", "-o", tmp_path / "again.laz", "--tiles")
    assert "vertices" in done.stdout
    assert "area" not in done.stdout
    assert "border edges" not in done.stdout


def test_a_torn_file_is_refused(tmp_path: Path) -> None:
    """A file that ends before the points that its header declares is no cloud."""
    scan(tmp_path / "in.las", form=3)
    data = (tmp_path / "in.las").read_bytes()
    (tmp_path / "in.las").write_bytes(data[: len(data) // 2])
    with pytest.raises(ContentsError):
        list(LasCloud(tmp_path / "in.las").points(100))


def test_a_file_without_points_is_refused(tmp_path: Path) -> None:
    """By tiles as in one piece, before any step."""
    laspy.LasData(laspy.LasHeader(point_format=3, version="1.2")).write(tmp_path / "in.las")
    for options in ((), ("--tiles",)):
        done = invoke("run", "clean_point_cloud", tmp_path / "in.las", "-o", tmp_path / "out.las", *options)
        assert done.exit_code != 0
        assert "in.las: no vertex could be read from it" in " ".join(done.stderr.split())


def cleaned_both_ways(folder: Path, extension: str, warning: str) -> None:
    """An E57 file without its outliers, in one piece as "whole" and by tiles as "tiled"; both runs give the warning."""
    pytest.importorskip("pye57")
    survey(folder / "in.e57")
    for name, options in (("whole", ()), ("tiled", ("--tiles",))):
        done = invoke("run", "remove_outliers", folder / "in.e57", "-o", folder / f"{name}.{extension}", *options)
        assert done.exit_code == 0, done.stderr
        assert warning in " ".join(done.stderr.split())


def test_an_e57_file_becomes_what_it_becomes_in_one_piece(tmp_path: Path) -> None:
    """Both scans of an E57 file, placed, without what was not measured, with all fields: the PLY file of a run in one piece."""
    cleaned_both_ways(tmp_path, "ply", "points at which nothing was measured are left out")
    assert (tmp_path / "whole.ply").read_bytes() == (tmp_path / "tiled.ply").read_bytes()


def test_an_e57_file_that_begins_without_a_measured_point(tmp_path: Path) -> None:
    """It is rewritten with one header, though its first pieces have no point."""
    pye57 = pytest.importorskip("pye57")
    with pye57.E57(str(tmp_path / "in.e57"), mode="w") as file:
        places = {f"cartesian{axis}": np.arange(9.0) for axis in "XYZ"}
        file.write_scan_raw(places | {"cartesianInvalidState": np.array([1, 1, 1, 1, 1, 0, 0, 0, 0], np.int8)})
    E57Cloud(tmp_path / "in.e57").rewrite(tmp_path / "a.ply", 2, tmp_path / "out.ply")
    assert read_file(tmp_path / "a.ply").mesh.vertices[:, 0].tolist() == [5, 6, 7, 8]


@pytest.mark.parametrize("extension", ["ply", "laz"])
def test_the_losses_of_an_e57_file_are_told(extension: str, tmp_path: Path) -> None:
    """By tiles as in one piece, a run tells that its output has no places of the scanner, and which file lacks what."""
    pytest.importorskip("pye57")
    survey(tmp_path / "in.e57")
    told = []
    for options in ((), ("--tiles",)):
        done = invoke("run", "remove_outliers", tmp_path / "in.e57", "-o", tmp_path / f"out.{extension}", *options, "--overwrite")
        lines = [line for line in done.stderr.splitlines() if line.startswith("warning: ")]
        told.append({line for line in lines if "its scale is" not in line and "done by tiles" not in line})
    assert f"warning: out.{extension} does not hold these contents of in.e57: the scanner's positions (2)" in told[0]
    assert told[0] == told[1]


def test_an_e57_file_becomes_a_laz_file(tmp_path: Path) -> None:
    """The same points with the same fields as in one piece, places within the steps of the files, intensities in 16 bits."""
    cleaned_both_ways(tmp_path, "laz", "its intensity from 0 to 1 is stored as whole numbers from 0 to 65535")
    whole, tiled = (laspy.read(tmp_path / name) for name in ("whole.laz", "tiled.laz"))
    names, others = (set(file.point_format.dimension_names) for file in (whole, tiled))
    assert names == others
    for name in names - {"X", "Y", "Z", "scalars"}:
        np.testing.assert_array_equal(whole[name], tiled[name])
    assert whole.intensity.max() > 60_000
    np.testing.assert_allclose(whole.xyz, tiled.xyz, rtol=0, atol=0.5 * (whole.header.scales + tiled.header.scales).max() + 1e-12)
