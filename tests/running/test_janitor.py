"""A supervisor that is killed while it puts a result in place or tidies up: its worker tidies up for it."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from pymeshfair.files.provenance import read_provenance, recorded_digest, sha256_of
from pymeshfair.files.writing import StagedFile, stage_file
from pymeshfair.running.job import Job, RunResult
from pymeshfair.running.supervise import run_job

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
    target = Path(result.provenance).parents[2] / "report.html"
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
