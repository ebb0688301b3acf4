"""The hidden folder in which an output is made."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pymeshfair.files.errors import OutputError
from pymeshfair.files.writing import STAGE_PREFIX, output_lock, remove_folder, staging_folder

from .runs import names_in

locks = pytest.mark.skipif(sys.platform == "win32", reason="there are no such locks")


def test_it_goes_with_everything_in_it(tmp_path: Path) -> None:
    """The folder is hidden, beside the output, and gone afterwards, also after an exception."""
    staging = staging_folder(tmp_path / "out.ply")
    folder = staging.__enter__()
    assert folder.parent == tmp_path
    assert folder.name.startswith(STAGE_PREFIX)
    (folder / "new" / "out.ply").touch()
    assert not staging.__exit__(RuntimeError, RuntimeError(), None)
    assert names_in(tmp_path) == set()
    remove_folder(folder)


def test_it_needs_a_folder(tmp_path: Path) -> None:
    """A folder that vanished after the first check is an error about the output."""
    with pytest.raises(OutputError, match="cannot make a temporary folder"), staging_folder(tmp_path / "gone" / "out.ply"):
        pass


ABANDON = """
import os, sys
from pathlib import Path
from pymeshfair.files.writing import staging_folder
with staging_folder(Path(sys.argv[1])) as stage:
    (stage / "new" / "half").write_bytes(b"half")
    os._exit(1)
"""


@locks
def test_an_abandoned_one_goes_with_the_next_run(tmp_path: Path) -> None:
    """What a process left behind that died at once is removed by the next run there; other hidden folders are not."""
    subprocess.run([sys.executable, "-c", ABANDON, tmp_path / "out.ply"], check=False)
    assert len(names_in(tmp_path)) == 1
    (tmp_path / f"{STAGE_PREFIX}mine").mkdir()
    with staging_folder(tmp_path / "other.ply") as stage:
        assert names_in(tmp_path) == {stage.name, f"{STAGE_PREFIX}mine"}
    assert names_in(tmp_path) == {f"{STAGE_PREFIX}mine"}


def test_one_without_a_lock_goes_after_an_hour(tmp_path: Path) -> None:
    """A folder that has no lock may be just coming or going; after an hour it is not."""
    for name, age in (("young", 60), ("old", 7200)):
        folder = tmp_path / f"{STAGE_PREFIX}{name}"
        (folder / "new").mkdir(parents=True)
        then = time.time() - age
        os.utime(folder, (then, then))
    with staging_folder(tmp_path / "out.ply"):
        pass
    assert names_in(tmp_path) == {f"{STAGE_PREFIX}young"}


def test_one_without_a_lock_goes_with_the_next_run_of_its_output(tmp_path: Path) -> None:
    """A process that dies before it locks its folder leaves one that the next run of the same output removes."""
    with staging_folder(tmp_path / "out.ply") as stage:
        pass
    stage.mkdir()
    with output_lock(tmp_path / "other.ply"):
        assert stage.exists()
    with output_lock(tmp_path / "out.ply"):
        assert not stage.exists()


@locks
def test_one_that_is_in_use_stays(tmp_path: Path) -> None:
    """Another run in the same folder does not touch it, as long as the process lives that made it; then it does."""
    with staging_folder(tmp_path / "a.ply") as one, staging_folder(tmp_path / "b.ply"):
        assert one.exists()
    folder = tmp_path / f"{STAGE_PREFIX}orphan"
    folder.mkdir()
    (folder / "lock").touch()
    with staging_folder(tmp_path / "c.ply"):
        assert not folder.exists()
