"""The parts of a report that need no browser: what is packed, decimated, charted and refused."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
import zlib
from dataclasses import asdict
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from pymeshfair.files.provenance import provenance_path
from pymeshfair.filters.geometry import face_normals
from pymeshfair.filters.inspection import Limits, mean_curvature
from pymeshfair.looking.comparison import compare, state_of
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import load_recipe
from pymeshfair.report.comparison_page import Verdict, _charts, _title, _verdict_of_run, run_page
from pymeshfair.report.page import histogram, round_numbers
from pymeshfair.report.scene import Marker, Scene, pack_scene, shown_mesh
from pymeshfair.running.guarding import _faults
from pymeshfair.running.measuring import measure
from pymeshfair.running.read import ReadMesh, read_mesh
from tests.commands.command_line import COMMAND, invoke
from tests.meshes import icosphere, torus
from tests.running.runs import RANGE_MAP


def unpacked(scene: Scene) -> list[dict[str, np.ndarray]]:
    """The arrays of each mesh, by plain loops over what the layout says."""
    body, at, meshes = zlib.decompress(scene.body), 0, []
    for mesh in scene.header["meshes"]:
        arrays = {}
        for array in mesh["arrays"]:
            size, count = array["bits"] // 8, array["rows"] * array["columns"]
            planes = np.frombuffer(body, np.uint8, size * count, at).reshape(size, count).astype(np.int64)
            at += size * count
            steps = sum(planes[b] << (8 * b) for b in range(size))
            if size == 4:
                values = np.cumsum((steps >> 1) ^ -(steps & 1)).reshape(array["rows"], array["columns"])
            else:
                values = (np.cumsum(steps.reshape(array["columns"], array["rows"]), axis=1) % (1 << array["bits"])).T
            arrays[array["name"]] = values
        meshes.append(arrays)
    assert at == len(body)
    return meshes


def test_what_is_packed_comes_back() -> None:
    """Faces exactly, coordinates to half a level of 65,535, normals to 0.06 degrees, numbers to half of 255 steps."""
    vertices, faces = torus()
    vertices = vertices + np.array([1000.0, -2000.0, 50.0])
    values = vertices[:, 0].copy()
    values[3] = np.nan
    shown = shown_mesh("before", MeshData(vertices=vertices, faces=faces), scalars={"curvature": values})
    limits = Limits(float(np.nanmin(values)), float(np.nanmax(values)))
    scene = pack_scene([shown], {"curvature": limits}, markers=[Marker((1000.0, -2000.0, 50.0), "middle", 0)])
    (found,) = unpacked(scene)
    np.testing.assert_array_equal(found["elements"], faces)
    half, centre = scene.header["half"], np.array(scene.header["centre"])
    places = (found["positions"] / 65535 * 2 - 1) * half + centre
    assert np.abs(places - vertices).max() <= half / 65535 * (1 + 1e-6)
    flat = found["normals"] / 4095 * 2 - 1
    normals = np.column_stack([flat, 1 - np.abs(flat).sum(axis=1)])
    below = normals[:, 2] < 0
    normals[below, :2] = (1 - np.abs(normals[below][:, [1, 0]])) * np.where(normals[below, :2] < 0, -1, 1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert np.degrees(np.linalg.norm(normals - shown.normals, axis=1).max()) < 0.06
    levels = found["scalar:curvature"][:, 0]
    assert levels[3] == 128
    told = limits.low + levels / 255 * (limits.high - limits.low)
    assert np.nanmax(np.abs(told - values)) <= (limits.high - limits.low) / 255 / 2 * (1 + 1e-9)
    np.testing.assert_allclose(scene.header["markers"][0]["place"], (np.array([1000.0, -2000.0, 50.0]) - centre) / half)


def test_large_meshes_are_decimated_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sphere of 20,480 faces keeps its place within a tenth of the coarse edges, and the numbers of the nearest vertices."""
    vertices, faces = icosphere(5)
    whole = shown_mesh("before", MeshData(vertices=vertices, faces=faces))
    assert not whole.decimated
    monkeypatch.setattr("pymeshfair.report.scene.MOST_FACES", 2000)
    monkeypatch.setattr("pymeshfair.report.scene.MOST_POINTS", 1000)
    far = vertices + np.array([5e5, 5e6, 0.0])
    shown = shown_mesh("after", MeshData(vertices=far, faces=faces), scalars={"displacement": vertices[:, 2].copy()})
    assert shown.decimated
    assert (shown.of_vertices, shown.of_faces) == (len(vertices), len(faces))
    assert 1900 <= len(shown.elements) <= 2000
    local = shown.vertices - [5e5, 5e6, 0.0]
    assert np.abs(np.linalg.norm(local, axis=1) - 1.0).max() < 0.01
    assert np.abs(shown.scalars["displacement"] - local[:, 2]).max() < 0.05
    cloud = shown_mesh("scan", MeshData(vertices=vertices))
    assert len(cloud.vertices) == 1000
    assert cloud.decimated


def test_histograms_count_everything() -> None:
    """The bars of each mesh add up to 100 %, with what lies beyond the limits in the last ones."""
    rng = np.random.default_rng(0)
    chart = histogram("x", "mm", {"before": rng.normal(size=999), "after": np.array([np.nan, 0.5, 9.0])}, -1.0, 1.0)
    assert chart is not None
    shares = np.array([[float(cell) for cell in row[1:]] for row in chart.rows])
    np.testing.assert_allclose(shares.sum(axis=0), 100.0, atol=0.3)
    assert shares[-1, 1] == 50.0
    assert "after 4.75" in chart.summary
    assert histogram("x", "mm", {"before": np.zeros(3)}, 0.0, 0.0) is None
    assert histogram("x", "mm", {"before": np.array([np.nan])}, 0.0, 1.0) is None


def test_very_large_meshes_are_thinned_before_they_are_decimated(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sphere of 81,920 faces becomes one of 2,000: all its faces look outwards, its vertices stay within 1 % of the radius."""
    vertices, faces = icosphere(6)
    numbers = {"distance": vertices[:, 2].copy()}
    monkeypatch.setattr("pymeshfair.report.scene.MOST_FACES", 2000)
    shown = shown_mesh("after", MeshData(vertices=7.0 * vertices + 100.0, faces=faces), scalars=numbers)
    assert 1500 < len(shown.elements) <= 2000
    local = (shown.vertices - 100.0) / 7.0
    np.testing.assert_allclose(np.linalg.norm(local, axis=1), 1.0, atol=0.01)
    outwards = np.einsum("ij,ij->i", face_normals(local, shown.elements), local[shown.elements].mean(axis=1))
    assert (outwards > 0.9).all()
    np.testing.assert_allclose(shown.scalars["distance"], local[:, 2], atol=0.05)


def test_a_far_vertex_does_not_end_the_report_of_a_very_large_mesh(monkeypatch: pytest.MonkeyPatch) -> None:
    """A vertex without a face, as at the origin of survey coordinates, is so many cells away that their numbers overflow."""
    vertices, faces = icosphere(6)
    monkeypatch.setattr("pymeshfair.report.scene.MOST_FACES", 2000)
    shown = shown_mesh("after", MeshData(vertices=np.vstack([vertices, [[1e7, 1e7, 1e7]]]), faces=faces))
    assert 1500 < len(shown.elements) <= 2000
    np.testing.assert_allclose(np.linalg.norm(shown.vertices[shown.elements], axis=2), 1.0, atol=0.01)


def test_a_vertex_without_a_face_does_not_shrink_the_view() -> None:
    """It is not shown, so the cube of the coordinates need not hold it."""
    vertices, faces = icosphere(2)
    cubes = []
    for points in (vertices, np.vstack([vertices, [[1e4, 1e4, 1e4]]])):
        header = pack_scene([shown_mesh("before", MeshData(vertices=points, faces=faces))], {}).header
        cubes.append((header["centre"], header["half"]))
    assert cubes[0] == cubes[1]


@pytest.mark.parametrize("most", [100_000, 2000])
def test_vertices_without_a_face_are_not_in_the_page(monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    """The body is that of the mesh without them, decimated or not; a mesh that lost only these is not called decimated."""
    monkeypatch.setattr("pymeshfair.report.scene.MOST_FACES", most)
    vertices, faces = icosphere(4)
    heights, unused = vertices[:, 2].copy(), np.full((5000, 3), 9.0)
    shown, of_all = (
        shown_mesh("before", MeshData(vertices=points, faces=corners), scalars={"curvature": points[:, 2].copy()})
        for points, corners in ((vertices, faces), (np.vstack([unused, vertices]), faces + len(unused)))
    )
    limits = {"curvature": Limits(heights.min(), heights.max())}
    assert pack_scene([of_all], limits).body == pack_scene([shown], limits).body
    assert (of_all.kept - len(unused) == shown.kept).all()
    assert of_all.decimated == shown.decimated == (most < len(faces))


def test_charts_count_vertices_that_have_a_value(tmp_path: Path) -> None:
    """Vertices without a face are not counted, nor are borders in the chart of curvatures, which are 0 there by convention."""
    vertices, faces = icosphere(3)
    cut = faces[vertices[faces].mean(axis=1)[:, 2] < 0.5]
    states = []
    for points in (vertices, np.vstack([vertices, np.full((500, 3), 9.0)])):
        mesh = MeshData(vertices=points, faces=cut)
        states.append(state_of(ReadMesh(tmp_path, mesh, measure(mesh), ())))
    compared = compare(*states)
    curvatures = {name: mean_curvature(mesh.vertices, cut) for name, mesh in compared.meshes.items()}
    distance, curvature, *_ = _charts(compared, Limits(-1.0, 1.0), curvatures, "mm")
    assert distance.summary == "Medians: after 0 (mm, outwards above 0)."
    assert curvature.summary == "Medians: before 1, after 1 (1 / mm)."
    assert curvature.rows[-1][1:] == ("100.00", "100.00")


def test_distances_are_charted_by_area(tmp_path: Path) -> None:
    """A plate of a thousand small faces and two large ones, moved by 1 at the large ones, has two thirds of its area at 1."""
    steps = np.linspace(0.0, 1.0, 23)
    x, y = (each.ravel() for each in np.meshgrid(steps, steps))
    i = np.arange(22 * 22) + np.arange(22 * 22) // 22
    small = np.concatenate([np.stack([i, i + 1, i + 24], 1), np.stack([i, i + 24, i + 23], 1)])
    large = np.array([[5.0, 0, 0], [7, 0, 0], [7, 1, 0], [5, 1, 0]])
    points = np.vstack([np.stack([x, y, 0.0 * x], 1), large])
    faces = np.vstack([small, len(x) + np.array([[0, 1, 2], [0, 2, 3]])]).astype(np.int32)
    moved = points + np.where(points[:, :1] > 4.0, [0.0, 0.0, 1.0], 0.0)
    meshes = [MeshData(vertices=each, faces=faces) for each in (points, moved)]
    compared = compare(*(state_of(ReadMesh(tmp_path, mesh, measure(mesh), ())) for mesh in meshes))
    distance, *_ = _charts(compared, Limits(-1.5, 1.5), {}, "mm")
    assert max(float(share) for _, share in distance.rows) == pytest.approx(66.67, abs=0.2)
    assert distance.summary == "Medians: after 1 (mm, outwards above 0)."


def test_marks_at_axes_are_round() -> None:
    """Multiples of 1, 2 or 5 times a power of ten, all within the axis."""
    assert round_numbers(-0.11, 0.12, 5) == pytest.approx([-0.1, -0.05, 0.0, 0.05, 0.1])
    assert round_numbers(0.0, 100.0, 4) == pytest.approx([0, 50, 100])


class Page(HTMLParser):
    """The elements of a page, and its text."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, Any]]] = []
        self.text = ""
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.mark.slow
def test_the_report_of_a_run_shows_what_broke(tmp_path: Path) -> None:
    """A run beyond its limit exits 1; its report names the limit, marks the vertex and shows steps and recipe."""
    vertices, faces = icosphere(3)
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "scan.ply")
    arguments = ("run", "smooth_taubin", tmp_path / "scan.ply", "-o", tmp_path / "out.ply", "--max-displacement", "0.00001")
    done = invoke(*arguments, "--report", tmp_path / "report.html")
    assert done.exit_code == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scan.ply"]
    done = invoke(*arguments, "--report", tmp_path / "report.html", "--keep-broken")
    assert done.exit_code == 1
    page = Page(tmp_path / "report.html")
    assert "The run went beyond a limit; the output was written all the same." in page.text
    assert "max_displacement: vertex" in page.text
    assert any("max_displacement, vertex" in (given.get("title") or "") for tag, given in page.elements if tag == "span")
    assert "<FilterScript" in page.text
    sources = [given.get("src") or given.get("href") or "" for _, given in page.elements]
    assert all(source == "" or source.startswith(("data:", "#")) for source in sources)


def test_a_report_names_no_folder_of_the_machine(tmp_path: Path) -> None:
    """Scan, recipe and output in three folders are named by their files alone."""
    for name in ("scans", "recipes", "out"):
        (tmp_path / name).mkdir()
    trimesh.Trimesh(*icosphere(1), process=False).export(tmp_path / "scans" / "scan.ply")
    (tmp_path / "recipes" / "own.mlx").write_text(load_recipe("smooth_taubin").text, encoding="utf-8")
    output, page = tmp_path / "out" / "o.ply", tmp_path / "out" / "o.html"
    done = invoke("run", tmp_path / "recipes" / "own.mlx", tmp_path / "scans" / "scan.ply", "-o", output, "--report", page)
    assert done.exit_code == 0, done.stderr
    text = page.read_text(encoding="utf-8")
    assert "own.mlx" in text
    assert str(tmp_path) not in text
    record = json.loads(provenance_path(output).read_text("utf-8"))
    record["warnings"] = [f"{tmp_path / 'scans' / 'scan.ply'} is old, 3 of 1/mm"]
    record["run"]["command"] = [f"{tmp_path}/bin/pymeshfair", "/scan.ply", f"-o{output}"]
    text = run_page(record, read_mesh(tmp_path / "scans" / "scan.ply"), read_mesh(output)).decode()
    assert str(tmp_path) not in text
    for shown in ("<li>scan.ply is old, 3 of 1/mm</li>", "&#34;pymeshfair&#34;,", "/&gt;"):
        assert shown in text


@pytest.mark.parametrize(("unit", "text"), [("mm", "2.0 mm"), (None, "2.0")])
def test_a_limit_that_was_kept_is_named_with_its_unit(unit: str | None, text: str) -> None:
    """A limit in mesh units has the unit of the scan in the verdict, and a number of handles has none."""
    record = {"steps": [], "run": {"seconds": 1.0}, "measures": {"unit": unit}}
    record["guards"] = {"limits": {"max_displacement": "2.0", "require": "genus=0"}}
    verdict = _verdict_of_run(record, Verdict("good", "", ()))
    assert verdict.text == f"Done, and every limit was kept: max displacement {text}, require genus=0."


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="there is no such signal")
@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_a_run_that_is_ended_at_its_report_leaves_nothing(number: str, tmp_path: Path, terminal_signals: None) -> None:
    """The output appears with its report, so neither is there, and nothing of the work."""
    command = [*COMMAND, "run", "smooth_taubin", str(RANGE_MAP), "-o", "out.ply", "--report", "report.html"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL) as process:
        while not list(tmp_path.glob(".pymeshfair-run-*/provenance.json")):
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(getattr(signal, number))
        assert process.wait(60) == (130 if number == "SIGINT" else -signal.SIGTERM)
    deadline = time.monotonic() + 20
    while any(tmp_path.iterdir()):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_clouds_have_a_report(tmp_path: Path) -> None:
    """Points without faces are compared, drawn and charted as far as that goes."""
    points = np.random.default_rng(1).normal(size=(300, 3))
    for name, cloud in (("a.xyz", points), ("b.xyz", points + np.array([0.1, 0, 0]))):
        np.savetxt(tmp_path / name, cloud)
    done = invoke("compare", tmp_path / "a.xyz", tmp_path / "b.xyz", "--report", tmp_path / "c.html", "--up", "z")
    assert done.exit_code == 0, done.stderr
    text = Page(tmp_path / "c.html").text
    assert "Distance from the mesh before." in text


def test_options_about_a_report_need_it(tmp_path: Path) -> None:
    """Without --report, sections, limits of its colours and the upright axis are refused before any mesh is opened."""
    for command in (["compare", "a.ply", "b.ply"], ["run", "smooth_taubin", "a.ply", "-o", str(tmp_path / "b.ply")]):
        for name, value in (("--up", "z"), ("--up", "y"), ("--limits", "-1,1"), ("--section", "z=1")):
            if command[0] == "run" and name != "--up":
                continue
            done = invoke(*command, name, value)
            assert done.exit_code == 2
            assert f"Invalid value for {name}: it is about the report: give --report, too" in done.stderr


def test_reports_that_cannot_be_written_are_refused_first(tmp_path: Path) -> None:
    """A wrong extension, a missing folder and an unknown axis are told before any mesh is opened."""
    for more, words, code in (
        (["--report", tmp_path / "x.pdf"], "'.pdf' is no format for it; name a file that ends with .html, .htm", 1),
        (["--report", tmp_path / "no" / "x.html"], "does not exist; make it first", 1),
        (["--report", tmp_path / "x.html", "--up", "x"], "is not one of 'y', 'z'", 2),
    ):
        done = invoke("compare", tmp_path / "missing.ply", tmp_path / "missing.ply", *map(str, more))
        assert done.exit_code == code, words
        assert words in done.stderr


def test_a_mark_without_a_vertex_names_the_kind_of_fault() -> None:
    """A fault for printing is many edges or faces, and its mark says which; a limit of movement names its vertex."""
    (breach,) = _faults(("border edge", "border edges"), np.eye(3), np.array([[0, 1], [1, 2]], np.int32))
    fault = asdict(breach)
    assert _title(fault) == "the written file has 2 border edges"
    assert _title({"guard": "max_displacement", "vertex": 7, "message": ""}) == "max_displacement, vertex 7"
