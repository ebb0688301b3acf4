"""A supervisor that is killed while it puts a result in place or tidies up: its worker tidies up for it."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from pymeshfair.files.provenance import read_provenance, recorded_digest, sha256_of

from .runs import names_in
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
