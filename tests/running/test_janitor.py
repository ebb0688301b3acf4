"""A supervisor that is killed while it puts a result in place or tidies up: its worker tidies up for it."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pymeshfair.files.errors import OutputError
from pymeshfair.files.provenance import read_provenance, recorded_digest, sha256_of
from pymeshfair.files.writing import STAGE_PREFIX, StagedFile, check_target, stage_file, undo, undo_killed
from pymeshfair.running.job import Job, RunResult
from pymeshfair.running.supervise import run_job
from tests.meshes import icosphere
from tests.tiles.tiling import write_mesh

from .runs import BONE, SMOOTH, names_in, recipe_of
from .test_supervise import slowness

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGKILL")

#: ends itself in the middle of a function that a run calls near its end
PROGRAM = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from tests.running.runs import BONE, SMOOTH, recipe_of
from pymeshfair.files import writing
from pymeshfair.running import supervise
from pymeshfair.running.job import Job

def killed(*values, **more):
    os.kill(os.getpid(), signal.SIGKILL)

{where} = killed
supervise.run_job(Job(recipe_of(SMOOTH), BONE, Path({output!r}), overwrite=True))
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("where", "left"),
    [
        ("supervise.Report.record", set()),
        ("supervise.place", set()),
        ("writing.os.link", {"clean.ply"}),
        ("writing.shutil.rmtree", {"clean.ply", "clean.ply.provenance.json"}),
    ],
)
def test_nothing_is_left_behind(tmp_path: Path, where: str, left: set[str]) -> None:
    """Killed before the files are placed, meanwhile or after it: what is there is whole, and nothing else is there."""
    output = tmp_path / "clean.ply"
    if "link" in where:
        output.write_bytes(b"the former one")
    program = PROGRAM.format(tests=str(Path(__file__).parents[2]), output=str(output), where=where)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == -9, done.stderr
    deadline = time.monotonic() + 5 * slowness()
    while names_in(tmp_path) != left and time.monotonic() < deadline:
        time.sleep(0.02)
    assert names_in(tmp_path) == left
    if "clean.ply.provenance.json" in left:
        record = read_provenance(output)
        assert record is not None
        assert recorded_digest(record, output) == sha256_of(output)


#: a run with a report, which ends itself when the first `count` files are in place
KILLED = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from tests.running.runs import BONE, SMOOTH, recipe_of
from tests.running.test_janitor import report
from pymeshfair.running import supervise
from pymeshfair.running.job import Job

def place(files, stage, outdated=()):
    for path in outdated:
        path.unlink(missing_ok=True)
    for file in files[:{count}]:
        file.staged.replace(file.target)
    os.kill(os.getpid(), signal.SIGKILL)

supervise.place = place
supervise.run_job(Job(recipe_of(SMOOTH), BONE, Path({output!r})), also=report)
"""


def report(result: RunResult) -> list[StagedFile]:
    """The report of a run, which is in the folder of the output."""
    target = Path(result.provenance).parents[1] / "report.html"
    return [stage_file(result.output.with_name(target.name), target, b"a page")]


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("is_there", [False, True])
def test_a_run_that_was_killed_between_its_files_can_begin_again(tmp_path: Path, is_there: bool, count: int) -> None:
    """It knows the files that it has put in place, first or again, so that nobody has to ask to overwrite them.

    A report it does not know, so it comes after the output.
    """
    job = Job(recipe_of(SMOOTH), BONE, tmp_path / "clean.obj")
    if is_there:
        run_job(job)
    program = KILLED.format(tests=str(Path(__file__).parents[2]), output=str(job.output), count=count)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == -9, done.stderr
    assert not (tmp_path / "report.html").exists()
    deadline = time.monotonic() + 5 * slowness()
    while any(name.startswith(".") for name in names_in(tmp_path)) and time.monotonic() < deadline:
        time.sleep(0.02)  # while the worker tidies up
    run_job(job)
    record = read_provenance(job.output)
    assert record is not None
    assert recorded_digest(record, job.output) == sha256_of(job.output)


#: a run with a map and a report, which ends itself and its worker at the start of rename number `count`
KILLED_WITH_WORKER = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from tests.running.runs import SMOOTH, recipe_of
from tests.running.test_janitor import report
from tests.tiles.tiling import children_of
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job

replace, count = Path.replace, {count}

def counted(self, target):
    global count
    count -= (self.parent.name == "new" or self.name == "provenance.json") and target.parent.name == {folder!r}
    if count == 0:
        for process in (*children_of(os.getpid()), os.getpid()):
            os.kill(process, signal.SIGKILL)
    return replace(self, target)

Path.replace = counted
folder = Path({path!r})
run_job(Job(recipe_of(SMOOTH), folder / "scan.ply", folder / "clean.ply", map=folder / "map.ply"), also=report)
"""


def files_of(folder: Path) -> dict[str, bytes]:
    """The files of a folder that are not hidden, with what is in them."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")}


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("former", ["none", "same bytes", "other bytes"])
def test_a_run_that_was_killed_with_its_worker_can_begin_again(tmp_path: Path, former: str, count: int) -> None:
    """Whatever was in place, the next check puts the former files back, and the same run works without `overwrite`."""
    write_mesh(tmp_path / "scan.ply", *icosphere(1))
    job = Job(recipe_of(SMOOTH), tmp_path / "scan.ply", tmp_path / "clean.ply", map=tmp_path / "map.ply")
    if former != "none":
        run_job(job)
    if former == "other bytes":
        write_mesh(tmp_path / "scan.ply", *icosphere(2))
    before = files_of(tmp_path)
    texts = {"tests": str(Path(__file__).parents[2]), "path": str(tmp_path), "folder": tmp_path.name, "count": count}
    done = subprocess.run([sys.executable, "-c", KILLED_WITH_WORKER.format(**texts)], capture_output=True, text=True)
    assert done.returncode == -9, done.stderr
    assert undo_killed(tmp_path)
    assert files_of(tmp_path) == before
    run_job(job, also=report)
    record = read_provenance(job.output)
    assert record is not None
    assert recorded_digest(record, job.output) == sha256_of(job.output)


#: removes an outdated file, places three files, and ends itself at the start of rename number `count`
PLACING = """
import os, signal, sys
from pathlib import Path
from pymeshfair.files import writing

replace, count, folder = Path.replace, int(sys.argv[2]), Path(sys.argv[1])

def counted(self, target):
    global count
    count -= self.parent.name == "new"
    if count == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return replace(self, target)

Path.replace = counted
with writing.staging_folder(folder / "a") as stage:
    files = [writing.stage_file(stage / "new" / name, folder / name, b"new " + name.encode()) for name in "abc"]
    writing.place(files, stage, outdated=[folder / "old", folder / "gone"])
"""


@pytest.mark.parametrize("count", [1, 2, 3])
def test_files_of_a_killed_process_are_put_back(tmp_path: Path, count: int) -> None:
    """New files go, replaced and outdated ones come back, and what another program has put there since stays."""
    before = {"a": b"former a", "c": b"former c", "old": b"outdated"}
    for name, data in before.items():
        (tmp_path / name).write_bytes(data)
    done = subprocess.run([sys.executable, "-c", PLACING, str(tmp_path), str(count)], capture_output=True, text=True)
    assert done.returncode == -9, done.stderr
    assert not (tmp_path / "old").exists()
    (tmp_path / "c").unlink()
    (tmp_path / "c").write_bytes(b"of another program")
    with pytest.raises(OutputError, match="it exists"):
        check_target(tmp_path / "c", ("",), overwrite=False)
    assert files_of(tmp_path) == {**before, "c": b"of another program"}
    assert not undo_killed(tmp_path)


#: places three files in two folders, and ends itself at the start of the last rename
PLACING_IN_TWO_FOLDERS = """
import os, signal, sys
from pathlib import Path
from pymeshfair.files import writing

replace, folder = Path.replace, Path(sys.argv[1])

def counted(self, target):
    if target == folder / "other" / "b":
        os.kill(os.getpid(), signal.SIGKILL)
    return replace(self, target)

with writing.staging_folder(folder / "a") as stage:
    names = ["other/c", "a", "other/b"]
    files = [writing.stage_file(stage / "new" / str(k), folder / name, b"new") for k, name in enumerate(names)]
    Path.replace = counted
    writing.place(files, stage)
"""


@pytest.mark.parametrize("next_in", ["a", "other/c"])
def test_the_next_command_in_either_folder_puts_the_files_of_both_back(tmp_path: Path, next_in: str) -> None:
    """Each staging folder of a killed process lists the moves in all folders."""
    (tmp_path / "other").mkdir()
    for name in ("a", "other/b", "other/c"):
        (tmp_path / name).write_bytes(b"former")
    done = subprocess.run([sys.executable, "-c", PLACING_IN_TWO_FOLDERS, str(tmp_path)], capture_output=True, text=True)
    assert done.returncode == -9, done.stderr
    assert (tmp_path / "a").read_bytes() == (tmp_path / "other" / "c").read_bytes() == b"new"
    with pytest.raises(OutputError, match="it exists"):
        check_target(tmp_path / next_in, ("",), overwrite=False)
    assert files_of(tmp_path) == {"a": b"former"}
    assert files_of(tmp_path / "other") == {"b": b"former", "c": b"former"}


def test_a_list_of_moves_reaches_no_files_but_those_beside_its_folders(tmp_path: Path) -> None:
    """The list in a staging folder of a foreign archive removes no file of another folder, and a wrong one counts as none."""
    (tmp_path / "mine").mkdir()
    kept = tmp_path / "mine" / "kept"
    kept.write_bytes(b"kept")
    stage = tmp_path / f"{STAGE_PREFIX}foreign"
    stage.mkdir()
    for folder, name in ((kept.parent / "x", "kept"), (stage, "mine/kept"), (kept.parent / f"{STAGE_PREFIX}x", "kept")):
        (stage / "moves").write_text(json.dumps([[str(folder), name, kept.stat().st_ino]]))
        undo(stage)
        assert kept.exists()
    (stage / "moves").write_text("[1]")
    assert not undo(stage)
