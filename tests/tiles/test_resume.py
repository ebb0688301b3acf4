"""A run by tiles that was killed goes on with the tiles that are missing, to the same bytes."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from pymeshfair.files.errors import OutputError
from pymeshfair.files.provenance import provenance_path
from pymeshfair.files.writing import WORK_PREFIX
from pymeshfair.running.job import Event, Job, StepStarted
from pymeshfair.tiles import workers
from pymeshfair.tiles.course import run_by_tiles
from tests.batch.batches import with_module
from tests.commands.command_line import COMMAND, invoke
from tests.meshes import icosphere
from tests.running.runs import Given, recipe_of
from tests.tiles.test_clouds import uneven
from tests.tiles.test_processes import LITTLE, LOOP
from tests.tiles.tiling import children_of, write_cloud, write_mesh

MOVES = """<!DOCTYPE FilterScript>
<FilterScript>
<filter name="Taubin Fairing"><Param type="RichInt" name="iterations" value="3"/></filter>
<filter name="Normal Filtering"><Param type="RichInt" name="outer_iterations" value="2"/>
<Param type="RichEnum" name="choice" value="1" enum_cardinality="2" enum_val0="held_out"
enum_val1="fixed"/></filter>
</FilterScript>
"""
#: a sitecustomize module: small tiles, each of which takes a moment and adds a line to a file when it begins
SMALL = """
import os, time
import pymeshfair.tiles.plan as memory
memory.cloud_points = lambda tile, neighbors, **more: 300
memory.surface_vertices = lambda tile, each, rings: 400
import pymeshfair.tiles.mesh as mesh
import pymeshfair.tiles.cloud as outliers

def slow(cls, name):
    method = getattr(cls, name)
    def replaced(self, *arguments):
        with open(os.environ["BEGUN"], "a") as file:
            file.write(f"{name} {arguments}\\n")
        time.sleep(float(os.environ["SLOW"]))
        return method(self, *arguments)
    setattr(cls, name, replaced)
    replaced.__name__ = name

slow(outliers.OutlierTiles, "find")
slow(outliers.OutlierTiles, "finish")
slow(mesh.MeshTiles, "move")
slow(mesh.FilteringTiles, "round")
"""


@pytest.mark.parametrize("resume", [False, True])
def test_a_disk_that_is_full_at_once_leaves_no_folder(resume: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder of temporary files goes with the run that could not fill it, unless a resumed run is to find it."""

    def full(folder: Path) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(workers, "in_use", full)
    with pytest.raises(OutputError, match="No space left"), workers.work_folder(tmp_path / "out.ply", {}, resume=resume):
        pass
    assert len(list(tmp_path.iterdir())) == resume


def lines(path: Path) -> list[str]:
    """The lines of a file, none of one that is not there."""
    return path.read_text().splitlines() if path.exists() else []


def run_small(folder: Path, *arguments: str | Path, begun: str, slow: float = 0.0) -> subprocess.Popen[str]:
    """The command with small tiles, whose beginnings are noted in a file."""
    environment = {**os.environ, **with_module(folder / "module", SMALL), "BEGUN": str(folder / begun), "SLOW": str(slow)}
    command = [str(word) for word in (*COMMAND, "run", *arguments, "--tiles", *LITTLE)]
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", start_new_session=True
    )


def kill_after(process: subprocess.Popen[str], path: Path, count: int) -> None:
    """Kill a run, as ``kill -9`` does, when so many tiles have begun; its workers end with it."""
    workers: list[int] = []
    deadline = time.monotonic() + 100
    while len(lines(path)) < count and time.monotonic() < deadline and process.poll() is None:
        workers = children_of(process.pid) or workers
        time.sleep(0.01)
    assert process.poll() is None, process.communicate()
    process.send_signal(signal.SIGKILL)
    process.communicate()
    while any(Path(f"/proc/{worker}").exists() for worker in workers) and time.monotonic() < deadline:
        time.sleep(0.01)


def work_folders(folder: Path) -> list[Path]:
    """The folders of runs by tiles."""
    return list(folder.glob(f"{WORK_PREFIX}*"))


@pytest.fixture(params=["cloud", pytest.param("mesh", marks=pytest.mark.slow)])
def case(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, Path]:
    """A recipe and a scan of some twenty tiles."""
    recipe = tmp_path / "recipe.mlx"
    if request.param == "cloud":
        recipe.write_text(LOOP)
        return recipe, write_cloud(tmp_path / "scan.ply", uneven(5, 5000))
    recipe.write_text(MOVES)
    return recipe, write_mesh(tmp_path / "scan.ply", *icosphere(4))


def test_a_killed_run_goes_on_to_the_same_bytes(case: tuple[Path, Path], tmp_path: Path) -> None:
    """Killed twice with ``kill -9`` and resumed, it does each tile once, but for the two that were under way."""
    recipe, scan = case
    whole, output = tmp_path / "whole.ply", tmp_path / "out.ply"
    process = run_small(tmp_path, recipe, scan, "-o", whole, begun="once")
    _, err = process.communicate(timeout=200)
    assert process.returncode == 0, err
    total = len(lines(tmp_path / "once"))
    assert total >= 15
    for share in (0.3, 0.7):
        process = run_small(tmp_path, recipe, scan, "-o", output, "--resume", begun="begun", slow=0.05)
        kill_after(process, tmp_path / "begun", int(share * total))
        assert len(work_folders(tmp_path)) == 1
    process = run_small(tmp_path, recipe, scan, "-o", output, "--resume", begun="begun")
    _, err = process.communicate(timeout=200)
    assert process.returncode == 0, err
    assert output.read_bytes() == whole.read_bytes()
    assert len(lines(tmp_path / "begun")) <= total + 2
    assert set(lines(tmp_path / "begun")) == set(lines(tmp_path / "once"))
    first, second = (json.loads(provenance_path(path).read_bytes()) for path in (whole, output))
    assert first["steps"] == second["steps"]
    assert first["measures"] == second["measures"]
    assert not work_folders(tmp_path)


def test_a_resumed_run_says_what_the_whole_run_says(tmp_path: Path) -> None:
    """Stopped after its first step and resumed, it does not take the probabilities of that step for those of the scan."""

    def stop(event: Event) -> None:
        if isinstance(event, StepStarted) and event.index == 3:
            raise RuntimeError("stopped")

    loop: Given = ("compute_selection_by_outlier_probability_per_vertex", {"neighbors": 12})
    recipe = recipe_of(loop, ("meshing_remove_selected_vertices", {}), ("compute_normal_for_point_clouds", {}))
    job = Job(recipe, write_cloud(tmp_path / "scan.ply", uneven(5)), tmp_path / "out.ply", overwrite=True)
    whole = run_by_tiles(job)
    with pytest.raises(RuntimeError, match="stopped"):
        run_by_tiles(job, stop, resume=True)
    resumed = run_by_tiles(job, resume=True)
    assert [step.messages for step in resumed.steps] == [step.messages for step in whole.steps]


@pytest.mark.parametrize("case", ["cloud"], indirect=True)
@pytest.mark.slow
def test_the_files_of_another_run_are_not_used(case: tuple[Path, Path], tmp_path: Path) -> None:
    """After the scan was changed a resumed run begins anew, says why, and gives what a new run gives."""
    recipe, scan = case
    output = tmp_path / "out.ply"
    process = run_small(tmp_path, recipe, scan, "-o", output, begun="begun", slow=0.05)
    kill_after(process, tmp_path / "begun", 5)
    write_cloud(scan, uneven(6, 5000))
    process = run_small(tmp_path, recipe, scan, "-o", output, "--resume", begun="again")
    _, err = process.communicate(timeout=200)
    assert process.returncode == 0, err
    assert "the files of the former run are not used, since it differs in the input" in " ".join(err.split())
    process = run_small(tmp_path, recipe, scan, "-o", tmp_path / "new.ply", begun="new")
    process.communicate(timeout=200)
    assert process.returncode == 0
    assert output.read_bytes() == (tmp_path / "new.ply").read_bytes()
    assert len(lines(tmp_path / "again")) == len(lines(tmp_path / "new"))


@pytest.mark.parametrize("case", ["cloud"], indirect=True)
@pytest.mark.slow
def test_doctor_names_what_killed_runs_left(case: tuple[Path, Path], tmp_path: Path) -> None:
    """The folder stays where other runs clean up, is named by doctor, and removed by it when asked; one in use is not."""
    recipe, scan = case
    output = tmp_path / "out.ply"
    process = run_small(tmp_path, recipe, scan, "-o", output, begun="begun", slow=0.05)
    kill_after(process, tmp_path / "begun", 5)
    assert invoke("run", "smooth_taubin", write_mesh(tmp_path / "m.ply", *icosphere(1)), "-o", tmp_path / "n.ply").exit_code == 0
    (left,) = work_folders(tmp_path)
    told = invoke("doctor", tmp_path).stdout
    assert left.name in told
    assert "--resume" in told
    assert left.exists()
    process = run_small(tmp_path, recipe, scan, "-o", tmp_path / "other.ply", begun="other", slow=100)
    while not lines(tmp_path / "other"):
        time.sleep(0.05)
    try:
        assert len(work_folders(tmp_path)) == 2
        invoke("doctor", tmp_path, "--remove")
        assert len(work_folders(tmp_path)) == 1
        assert not left.exists()
    finally:
        process.kill()
        process.communicate()
