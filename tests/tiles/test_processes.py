"""``pymeshfair run --tiles`` as users meet it: the result of `run`, a killed worker, Ctrl-C, a full disk, refusals."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.errors import StepFailedError
from pymeshfair.files.ply_write import write_ply
from pymeshfair.files.provenance import provenance_path
from pymeshfair.filters.outliers import local_outlier_probability
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import Recipe
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from pymeshfair.tiles.course import run_by_tiles
from pymeshfair.tiles.sources import PlyFile
from tests.batch.batches import with_module
from tests.commands.command_line import COMMAND, fits, invoke, run_process
from tests.files.surveys import scan as survey
from tests.meshes import icosphere
from tests.running.runs import Given, recipe_of
from tests.tiles.test_clouds import uneven
from tests.tiles.tiling import children_of, kill, write_cloud, write_mesh

LOOP = """<!DOCTYPE FilterScript>
<FilterScript>
<filter name="Select Outliers by Probability (LoOP)">
<Param type="RichInt" name="neighbors" value="12"/>
</filter>
<filter name="Delete Selected Vertices"/>
</FilterScript>
"""
#: a sitecustomize module: each tile takes some seconds more, and says in a file that it has begun
SLOW = """
import os, time
import pymeshfair.tiles.cloud as outliers

def find(self, *cells, find=outliers.OutlierTiles.find):
    open(os.environ["BEGUN"], "a").close()
    time.sleep(float(os.environ["SLOW"]))
    return find(self, *cells)

outliers.OutlierTiles.find = find
"""
#: a sitecustomize module: each tile takes 700 MB and does not end
GREEDY = """
import time
import pymeshfair.tiles.cloud as outliers

def find(self, *cells):
    taken = b"1" * 700_000_000
    time.sleep(1000)

outliers.OutlierTiles.find = find
"""
#: a sitecustomize module: each tile ends its process, as the system does where memory is short
DEADLY = """
import os, signal
import pymeshfair.tiles.cloud as outliers

def find(self, *cells):
    os.kill(os.getpid(), signal.SIGKILL)

outliers.OutlierTiles.find = find
"""
#: with which there is one worker
LITTLE = ("--memory", "500MB")


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    """LoOP with deletion."""
    path = tmp_path / "loop.mlx"
    path.write_text(LOOP)
    return path


def started(recipe: Path, scan: Path, output: Path, *, slow: float) -> subprocess.Popen[str]:
    """The command, once a tile is under way."""
    begun = output.with_name("begun")
    environment = {**os.environ, **with_module(output.parent / "slow", SLOW), "BEGUN": str(begun), "SLOW": str(slow)}
    command = [*COMMAND, "run", recipe, scan, "-o", output, "--tiles", *LITTLE]
    process = subprocess.Popen(
        [str(word) for word in command], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8"
    )
    deadline = time.monotonic() + 100
    while not begun.exists() and time.monotonic() < deadline and process.poll() is None:
        time.sleep(0.02)
    assert begun.exists(), process.communicate()
    return process


def workers_of(process: subprocess.Popen[str]) -> list[int]:
    """The processes in which tiles are done."""
    return [p for p in children_of(process.pid) if b"pymeshfair.processes.worker" in Path(f"/proc/{p}/cmdline").read_bytes()]


def test_steps_say_by_tiles_what_they_say_in_one_piece(tmp_path: Path) -> None:
    """Notes and lengths in the reports of steps, and the refusal of cells without a size, do not depend on tiles."""
    cloud = write_cloud(tmp_path / "cloud.ply", uneven(5))
    ball = write_mesh(tmp_path / "ball.ply", *icosphere(3))
    selections: list[Given] = [
        ("compute_selection_by_stray_points_per_vertex", {}),
        ("meshing_remove_selected_vertices", {}),
        ("compute_selection_by_outlier_probability_per_vertex", {}),
        ("meshing_remove_selected_vertices", {}),
        ("compute_selection_by_grid_per_vertex", {"side": "1%"}),
    ]
    for scan, steps in ((cloud, selections), (ball, [("apply_coord_normal_filtering", {})])):
        reports = [run(Job(recipe_of(*steps), scan, tmp_path / "o.ply", overwrite=True)).steps for run in (run_job, run_by_tiles)]
        said, said_by_tiles = (
            [(s.messages, s.parameters) for s in report if "remove" not in s.python_name] for report in reports
        )
        assert said_by_tiles == said
        assert all(messages for messages, _ in said)
    script = recipe_of((selections[-1][0], {"side": "1e5"})).script
    superseded = Recipe("old", replace(script, comment="Old\n\nSuperseded: take another."))
    warnings = [run(Job(superseded, cloud, tmp_path / "old.ply", overwrite=True)).warnings for run in (run_job, run_by_tiles)]
    assert [text for text in warnings[1] if not text.startswith("done by tiles")] == list(warnings[0])
    assert len(warnings[0]) == 2
    for run in (run_job, run_by_tiles):
        with pytest.raises(StepFailedError, match="side is 0: nothing to do; give the side of a cell"):
            run(Job(recipe_of((selections[-1][0], {"side": "0"})), cloud, tmp_path / "none.ply"))


@pytest.mark.slow
def test_a_run_by_tiles_survives_a_killed_worker(recipe: Path, tmp_path: Path) -> None:
    """A worker that is killed in the middle of a tile costs a second try: the output is that of `run`, and can be verified."""
    points = uneven(5)
    scan, output, whole = write_cloud(tmp_path / "scan.ply", points), tmp_path / "out.ply", tmp_path / "whole.ply"
    process = started(recipe, scan, output, slow=1.5)
    (worker,) = workers_of(process)
    kill(worker)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert run_process("run", recipe, scan, "-o", whole).returncode == 0
    ours, theirs = (PlyFile(path).vertices for path in (output, whole))
    read, expected = ours.read(0, ours.element.count), theirs.read(0, theirs.element.count)
    for name in ("x", "y", "z", "quality", "number"):
        np.testing.assert_array_equal(read[name], expected[name])
    probability = local_outlier_probability(points, neighbors=12, extent=3.0)
    np.testing.assert_array_equal(read["number"], np.flatnonzero(probability <= 0.5))
    record, other = (json.loads(provenance_path(path).read_bytes()) for path in (output, whole))
    assert record["steps"][0]["values"] | {"mean_probability": 0} == other["steps"][0]["values"] | {"mean_probability": 0}
    assert record["input"] == other["input"]
    assert record["recipe"] == other["recipe"]
    assert record["tiles"]["memory_limit"] == 500_000_000
    assert record["run"]["peak_memory_bytes"] < 500_000_000
    assert "out.ply" in out
    again = run_process("verify", output)
    assert again.returncode == 0, again.stderr
    assert again.stdout.startswith(f"{output}: identical\n")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "said"),
    [
        (GREEDY, "a tile needs more memory than the run may use; allow it more"),
        (DEADLY, "each worker that tried a tile ended (the worker process ended with status -9), perhaps for lack of memory"),
    ],
    ids=["greedy", "deadly"],
)
def test_a_tile_that_no_worker_can_do_ends_the_run(recipe: Path, tmp_path: Path, program: str, said: str) -> None:
    """One that takes more than `--memory`, or ends every process that begins it, ends the run in words, and leaves nothing."""
    scan, output = write_cloud(tmp_path / "scan.ply", uneven(5)), tmp_path / "out.ply"
    environment = {**os.environ, **with_module(tmp_path / "module", program)}
    command = [str(word) for word in (*COMMAND, "run", recipe, scan, "-o", output, "--tiles", *LITTLE)]
    done = subprocess.run(command, env=environment, capture_output=True, encoding="utf-8", timeout=200)
    assert done.returncode == 1
    assert said in done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["loop.mlx", "module", "scan.ply"]


@pytest.mark.usefixtures("terminal_signals")
def test_ctrl_c_leaves_nothing(recipe: Path, tmp_path: Path) -> None:
    """Ctrl-C ends a run by tiles, its processes and its files; an output of a former run stays."""
    scan, output = write_cloud(tmp_path / "scan.ply", uneven(5)), tmp_path / "out.ply"
    process = started(recipe, scan, output, slow=1000)
    there = children_of(process.pid)
    began = time.monotonic()
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130
    assert time.monotonic() - began < 20
    assert not [p for p in there if Path(f"/proc/{p}/cmdline").exists() and Path(f"/proc/{p}/cmdline").read_bytes()]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["begun", "loop.mlx", "scan.ply", "slow"]


@pytest.mark.parametrize("is_filled_later", [False, True])
def test_a_full_disk_is_named(recipe: Path, tmp_path: Path, is_filled_later: bool) -> None:
    """Without the room for the work nothing is begun; where it goes meanwhile nothing is written, and the message says so."""
    folder = tmp_path / "small"
    folder.mkdir()
    size = "20m" if is_filled_later else "500k"
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], capture_output=True, text=True)
    if mounted.returncode:
        pytest.skip(f"no file system can be mounted: {mounted.stderr}")
    try:
        scan = write_cloud(tmp_path / "scan.ply", uneven(5, 10_000))
        if is_filled_later:
            process = started(recipe, scan, folder / "out.ply", slow=2)
            with contextlib.suppress(OSError):
                (folder / "filler").write_bytes(bytes(30_000_000))
            _, err = process.communicate(timeout=100)
            assert "the temporary files cannot be written: no space left on device" in err
            assert sorted(p.name for p in folder.iterdir()) == ["begun", "filler", "slow"]
        else:
            done = run_process("run", recipe, scan, "-o", folder / "out.ply", "--tiles", *LITTLE)
            err = done.stderr
            assert done.returncode == 1
            assert "the work needs 0.000879 GB, and the disk of" in err
            assert list(folder.iterdir()) == []
    finally:
        subprocess.run(["umount", folder], check=True)


def test_steps_that_need_the_whole_are_named(tmp_path: Path) -> None:
    """A recipe with a step that cannot be done by tiles is refused before anything is done, with the step and the reason."""
    scan = write_cloud(tmp_path / "scan.ply", uneven(5))
    done = invoke("run", "clean_point_cloud", scan, "-o", tmp_path / "out.ply", "--tiles", "--set", "smooth=3")
    assert done.exit_code == 2
    assert "Bilateral Projection of Points" in done.stderr
    assert "cannot be done by tiles" in done.stderr
    assert not (tmp_path / "out.ply").exists()


def test_clean_point_cloud_by_tiles_keeps_the_points_of_one_piece(tmp_path: Path) -> None:
    """By tiles the recipe keeps the same points with the same probabilities, and gives them normals of the same directions."""
    points = uneven(5)
    scan = write_cloud(tmp_path / "scan.ply", np.concatenate([points, points[:50]]))
    done = invoke("run", "clean_point_cloud", scan, "-o", tmp_path / "tiled.ply", "--tiles", "--json")
    whole = invoke("run", "clean_point_cloud", scan, "-o", tmp_path / "whole.ply")
    assert (done.exit_code, whole.exit_code) == (0, 0), done.stderr + whole.stderr
    report = json.loads(done.stdout)
    assert len(report["steps"]) == 7
    assert report["steps"][0]["values"]["removed_vertices"] == 50
    files = [PlyFile(tmp_path / name) for name in ("tiled.ply", "whole.ply")]
    tiled, one = (file.vertices.read(0, len(file)) for file in files)
    for name in ("number", "quality", "x", "y", "z"):
        np.testing.assert_array_equal(tiled[name], one[name])
    # Where many points lie in one plane or at one place, which neighbours are the nearest is a matter of rounding.
    agree = np.abs(sum(tiled[name] * one[name] for name in ("nx", "ny", "nz")))
    assert np.mean(agree > 1 - 1e-9) > 0.9


def test_messages_and_values_of_steps_are_those_of_one_piece(tmp_path: Path) -> None:
    """Steps have the messages and values of one piece, but no drift, which needs the whole mesh; removed points are counted."""
    points = uneven(5)
    copies = np.repeat(np.add(points.max(axis=0), [[5.0, 0, 0], [0, 9.0, 0]]), 30, axis=0)
    cloud = write_cloud(tmp_path / "cloud.ply", np.concatenate([points, points[:50], copies]))
    vertices, faces = icosphere(3)
    mesh = write_mesh(tmp_path / "mesh.ply", vertices + np.random.default_rng(1).normal(scale=0.02, size=vertices.shape), faces)
    stray: Given = ("compute_selection_by_stray_points_per_vertex", {})
    delete: Given = ("meshing_remove_selected_vertices", {})
    fixed: Given = ("apply_coord_normal_filtering", {"choice": "fixed", "outer_iterations": 2})
    chosen: Given = ("apply_coord_normal_filtering", {})
    smooth: Given = ("apply_coord_taubin_smoothing", {"stepsmoothnum": 3})
    for scan, steps in (
        (cloud, [stray, delete, ("meshing_remove_duplicate_vertices", {}), stray, delete]),
        (mesh, [fixed, chosen, smooth]),
    ):
        whole = run_job(Job(recipe_of(*steps), scan, tmp_path / "whole.ply", overwrite=True))
        tiled = run_by_tiles(Job(recipe_of(*steps), scan, tmp_path / "tiled.ply", overwrite=True), most=150)
        for by_tiles, one in zip(tiled.steps, whole.steps, strict=True):
            assert by_tiles.messages == one.messages
            assert {n: v for n, v in by_tiles.values.items() if n != "removed_vertices"} == {
                n: v for n, v in one.values.items() if n != "drift"
            }


@pytest.mark.parametrize("iterations", [0, 5])
def test_normals_of_a_mesh_follow_its_vertices(iterations: int, tmp_path: Path) -> None:
    """A mesh whose file has vertex normals gets by tiles those of the moved surface: the file is that of a run in one piece.

    Vertices of no face keep their normals, and where nothing moves all vertices keep theirs.
    """
    vertices, faces = icosphere(3)
    rough = vertices + np.random.default_rng(2).normal(scale=0.02, size=vertices.shape)
    rough, vertices = (np.concatenate([points, points[:2] / 2]) for points in (rough, vertices))
    mesh = MeshData(vertices=rough, faces=faces, vertex_attributes={"normals": vertices}, keeps_normals=True)
    with (tmp_path / "scan.ply").open("xb") as file:
        write_ply(mesh, file)
    step = f'<filter name="Taubin Fairing"><Param type="RichInt" name="iterations" value="{iterations}"/></filter>'
    (tmp_path / "fair.mlx").write_text(f"<!DOCTYPE FilterScript>\n<FilterScript>{step}</FilterScript>")
    for name, options in (("whole.ply", ()), ("tiled.ply", ("--tiles",))):
        done = invoke("run", tmp_path / "fair.mlx", tmp_path / "scan.ply", "-o", tmp_path / name, *options)
        assert done.exit_code == 0, done.stderr
    assert (tmp_path / "tiled.ply").read_bytes() == (tmp_path / "whole.ply").read_bytes()


@pytest.mark.parametrize("scale", [1.0, 1e200])
def test_a_run_by_tiles_prints_the_document_of_a_run(scale: float, recipe: Path, tmp_path: Path) -> None:
    """With --json the document has the form of its schema, of any size of scan; measures that tiles do not know are null."""
    scan = write_cloud(tmp_path / "scan.ply", scale * uneven(5))
    tiled, whole = (
        invoke("run", recipe, scan, "-o", tmp_path / f"out{len(options)}.ply", "--json", *options)
        for options in (("--tiles",), ())
    )
    assert (tiled.exit_code, whole.exit_code) == (0, 0), tiled.stderr + whole.stderr
    read, other = json.loads(tiled.stdout), json.loads(whole.stdout)
    assert fits(read, "run")
    for name in ("before", "after"):
        assert read[name]["vertices"] == other[name]["vertices"]
        assert read[name]["diagonal"] == pytest.approx(other[name]["diagonal"], rel=1e-12)
        assert read[name]["area"] is None


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--max-displacement", "1edge"), "limits, an intervention map"),
        (("--memory", "300MB"), "300 MB are too little"),
        (("--report", "report.html"), "--tiles makes no report"),
        (("--with", "other.ply"), "further layers"),
        (("--keep-all",), "--keep-all need the whole mesh"),
    ],
)
def test_what_needs_the_whole_is_refused(recipe: Path, tmp_path: Path, options: tuple[str, ...], said: str) -> None:
    """Limits, layers and reports, which need all of a mesh, are refused, and so is too little memory."""
    scan = write_cloud(tmp_path / "scan.ply", uneven(5))
    done = invoke("run", recipe, scan, "-o", tmp_path / "out.ply", "--tiles", *options)
    assert done.exit_code == 2
    assert said in " ".join(done.stderr.replace("│", " ").split())


def test_inputs_that_cannot_be_cut_are_refused(recipe: Path, tmp_path: Path) -> None:
    """The input itself, a mesh in place of a cloud, points at NaN and other formats are refused with what tiles can take."""
    vertices, faces = icosphere(1)
    mesh, scan = write_mesh(tmp_path / "mesh.ply", vertices, faces), write_cloud(tmp_path / "scan.ply", uneven(5))
    las, text, points = tmp_path / "scan.las", tmp_path / "scan.xyz", uneven(5)
    survey(las, form=3)
    points[7, 1] = np.nan
    broken = write_cloud(tmp_path / "broken.ply", points)
    text.write_bytes(b"0 0 0\n1 0 0\n")
    for arguments, said in (
        ((scan, "-o", scan), "it is the input"),
        ((scan, "-o", tmp_path / "out.las"), "a .ply file can become .ply, not .las"),
        ((scan, "-o", tmp_path / "out.laz"), "a .ply file can become .ply, not .laz"),
        ((las, "-o", tmp_path / "out.ply"), "a .las file can become .las, .laz, not .ply"),
        ((broken, "-o", tmp_path / "out.ply"), f"error: cannot read {broken}: point 7 is ["),
        ((text, "-o", tmp_path / "out.ply"), "by tiles the recipe reads .ply, .las, .laz, .e57, not .xyz"),
    ):
        done = invoke("run", recipe, *arguments, "--tiles")
        assert done.exit_code == 1
        assert said in done.stderr
    done = invoke("run", recipe, mesh, "-o", tmp_path / "out.ply", "--tiles")
    assert "it has 80 rows of element 'face'; by tiles, the recipe takes only clouds" in done.stderr
