"""E57 files: all scans and fields, placed by their poses; what is damaged, and what would be written, is refused."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pymeshfair.files.errors import InputError
from pymeshfair.files.inputs import read_file
from tests.commands.command_line import document, invoke

pye57 = pytest.importorskip("pye57")


def survey(path: Path, count: int = 2000) -> list[dict[str, Any]]:
    """Two scans of a wall, with intensities, colours and the rows of the scanner; some points were not measured."""
    random = np.random.default_rng(3)
    scans = []
    with pye57.E57(str(path), mode="w") as file:
        for k, place in enumerate(([10.0, 0.0, 2.0], [-5.0, 3.0, 2.0])):
            scan: dict[str, Any] = {
                "cartesianX": random.uniform(0, 5, count),
                "cartesianY": random.uniform(0, 5, count),
                "cartesianZ": random.normal(scale=0.005, size=count),
                "intensity": random.uniform(0, 1, count).astype(np.float32),
                "rowIndex": random.integers(0, 500, count).astype(np.uint16),
                "columnIndex": random.integers(0, 500, count).astype(np.uint16),
                "cartesianInvalidState": (random.random(count) < 0.1).astype(np.int8),
            }
            scan |= {name: random.integers(0, 256, count).astype(np.uint8) for name in ("colorRed", "colorGreen", "colorBlue")}
            turn = np.array([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]) if k else np.array([1.0, 0.0, 0.0, 0.0])
            file.write_scan_raw(scan, rotation=turn, translation=np.array(place))
            scans.append(scan)
    return scans


def test_all_scans_and_fields_are_read(tmp_path: Path) -> None:
    """Points lie where pye57's own reader puts them; fields are attributes, and what was not measured is left out and named."""
    scans = survey(tmp_path / "in.e57")
    reading = read_file(tmp_path / "in.e57")
    mesh = reading.mesh
    with pye57.E57(str(tmp_path / "in.e57")) as file:
        theirs = [file.read_scan(k, intensity=True, colors=True) for k in range(2)]
    places = np.concatenate([np.stack([s[f"cartesian{axis}"] for axis in "XYZ"], axis=1) for s in theirs])
    np.testing.assert_allclose(mesh.vertices, places, rtol=0, atol=1e-12)
    kept = [scan["cartesianInvalidState"] == 0 for scan in scans]
    for name in ("intensity", "rowIndex", "columnIndex"):
        np.testing.assert_array_equal(
            mesh.vertex_attributes[name], np.concatenate([s[name][k] for s, k in zip(scans, kept, strict=True)])
        )
    np.testing.assert_array_equal(mesh.vertex_attributes["colors"][:, 0], np.concatenate([s["colorRed"] for s in theirs]))
    np.testing.assert_array_equal(mesh.vertex_attributes["scan"], np.repeat([0, 1], [k.sum() for k in kept]))
    assert mesh.unit == "m"
    missing = sum(int((~k).sum()) for k in kept)
    assert reading.doubts == (f"{missing:,} points at which nothing was measured are left out",)


def test_commands_take_an_e57_file(tmp_path: Path) -> None:
    """`info` measures it and `run` cleans it; an output of the format is refused."""
    scans = survey(tmp_path / "in.e57")
    done = invoke("info", tmp_path / "in.e57", "--json")
    assert done.exit_code == 0, done.stderr
    count = sum(int((scan["cartesianInvalidState"] == 0).sum()) for scan in scans)
    assert f'"vertices": {count}' in done.stdout
    done = invoke("run", "remove_outliers", tmp_path / "in.e57", "-o", tmp_path / "out.laz", "--json")
    assert done.exit_code == 0, done.stderr
    assert document(done.stdout)["after"]["vertices"] <= count
    assert "its" in done.stderr
    done = invoke("run", "remove_outliers", tmp_path / "in.e57", "-o", tmp_path / "out.e57")
    assert done.exit_code == 1
    assert "out.e57" in done.stderr


@pytest.mark.parametrize("cut", [40, 2000, 30_000])
def test_damaged_files_are_refused(tmp_path: Path, cut: int) -> None:
    """A file that ends too early, or in which a byte has changed, is no cloud; it stays where it is."""
    survey(tmp_path / "in.e57")
    data = bytearray((tmp_path / "in.e57").read_bytes())
    (tmp_path / "torn.e57").write_bytes(data[:cut])
    data[cut] ^= 0xFF
    (tmp_path / "changed.e57").write_bytes(data)
    for name in ("torn.e57", "changed.e57"):
        with pytest.raises(InputError):
            read_file(tmp_path / name)
        assert (tmp_path / name).exists()


def test_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without pye57 the message names the extra that installs it."""
    survey(tmp_path / "in.e57", 10)
    monkeypatch.setitem(sys.modules, "pye57", None)
    with pytest.raises(InputError, match=r"pymeshfair\[e57\]"):
        read_file(tmp_path / "in.e57")


def test_scans_without_colours_beside_others_are_named(tmp_path: Path) -> None:
    """The points of a scan without colours become white if another scan has colours, and this is said."""
    places = {f"cartesian{axis}": np.arange(3.0) for axis in "XYZ"}
    colors = {f"color{name}": np.full(3, 9, np.uint8) for name in ("Red", "Green", "Blue")}
    with pye57.E57(str(tmp_path / "in.e57"), mode="w") as file:
        file.write_scan_raw(places | colors)
        file.write_scan_raw(places)
    assert read_file(tmp_path / "in.e57").doubts == ("1 of its 2 scans have no colours, and are white",)


def written(path: Path, fields: dict[str, Any], turn: tuple[float, ...]) -> None:
    """A scan of any fields, among them those of the extension for normals, turned by a quaternion."""
    from pye57 import libe57

    with pye57.E57(str(path), mode="w") as file:
        image = file.image_file
        image.extensionsAdd("nor", "http://www.libe57.org/E57_NOR_surface_normals.txt")
        nodes = {name: libe57.StructureNode(image) for name in ("scan", "pose", "rotation", "translation", "prototype")}
        for name, number in zip("wxyz", turn, strict=True):
            nodes["rotation"].set(name, libe57.FloatNode(image, number))
        for name in "xyz":
            nodes["translation"].set(name, libe57.FloatNode(image, 1.0))
        nodes["scan"].set("pose", nodes["pose"])
        for name in ("rotation", "translation"):
            nodes["pose"].set(name, nodes[name])
        buffers = libe57.VectorSourceDestBuffer()
        for name, values in fields.items():
            nodes["prototype"].set(name, libe57.FloatNode(image, 0.0, libe57.E57_DOUBLE))
            buffers.append(libe57.SourceDestBuffer(image, name, values, len(values), True, True))
        points = libe57.CompressedVectorNode(image, nodes["prototype"], libe57.VectorNode(image, True))
        nodes["scan"].set("guid", libe57.StringNode(image, "a"))
        nodes["scan"].set("points", points)
        file.data3d.append(nodes["scan"])
        writer = points.writer(buffers)
        writer.write(len(values))
        writer.close()


def test_normals_turn_with_their_scan_and_single_colours_stay(tmp_path: Path) -> None:
    """Normals lie as the pose of the scan turns them; one channel of a colour is an attribute by its name."""
    fields = {f"cartesian{axis}": np.arange(3.0) for axis in "XYZ"} | {"colorRed": np.array([7.0, 8.0, 9.0])}
    fields |= {f"nor:normal{axis}": np.full(3, float(axis == "X")) for axis in "XYZ"}
    written(tmp_path / "in.e57", fields, (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)))
    mesh = read_file(tmp_path / "in.e57").mesh
    np.testing.assert_allclose(mesh.vertices[2], [-1.0, 3.0, 3.0], atol=1e-12)
    np.testing.assert_allclose(mesh.vertex_attributes["normals"], np.tile([0.0, 1.0, 0.0], (3, 1)), atol=1e-12)
    assert mesh.vertex_attributes["colorRed"].tolist() == [7, 8, 9]
    assert mesh.vertex_attributes.keys() == {"normals", "colorRed"}
