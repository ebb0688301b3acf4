"""Files for other disks, full disks and a working folder that is gone: all that was asked for is written, or nothing."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from pymeshfair.files.errors import OutputError
from pymeshfair.files.writing import StagedFile, place
from tests.running.runs import BONE, names_in

from .command_line import COMMAND, invoke, run_process


@pytest.mark.parametrize("kept", [True, False], ids=["within limits", "beyond a limit"])
@pytest.mark.slow
def test_a_map_and_a_report_go_to_another_disk(mounted: Callable[[str], Path], kept: bool, tmp_path: Path) -> None:
    """Both are there, and nothing else; where the run breaks a limit and so writes no output, the map alone."""
    disk, output = mounted("20m"), tmp_path / "out.ply"
    limit = ["--max-displacement", "1edge" if kept else "0"]
    files: list[str | Path] = ["--map", disk / "map.ply", "--report", disk / "report.html"]
    done = run_process("run", "smooth_taubin", BONE, "-o", output, *files, *limit)
    assert done.returncode == (0 if kept else 1), done.stderr
    assert output.exists() is kept
    assert names_in(disk) == ({"map.ply", "report.html"} if kept else {"map.ply"})


@pytest.mark.slow
@pytest.mark.parametrize("what", ["--map", "--report"])
def test_a_full_disk_for_a_map_or_a_report_leaves_no_output(mounted: Callable[[str], Path], what: str, tmp_path: Path) -> None:
    """The run fails in words, and the output is not written either; what was there is there still."""
    disk, output = mounted("40k"), tmp_path / "out.ply"
    target = disk / ("map.ply" if what == "--map" else "report.html")
    target.write_bytes(b"former")
    done = run_process("run", "smooth_taubin", BONE, "-o", output, what, target, "--overwrite")
    assert done.returncode == 1
    assert f"cannot write {target}: " in done.stderr
    assert "no space left on device" in done.stderr
    assert "Errno" not in done.stderr
    assert names_in(tmp_path) == {disk.name}
    assert names_in(disk) == {target.name}
    assert target.read_bytes() == b"former"


@pytest.mark.slow
def test_a_full_disk_for_the_report_of_a_comparison(mounted: Callable[[str], Path]) -> None:
    """It fails in words."""
    disk = mounted("40k")
    done = run_process("compare", BONE, BONE, "--report", disk / "report.html")
    assert done.returncode == 1
    assert done.stderr.endswith(f"error: cannot write {disk / 'report.html'}: no space left on device\n")
    assert not names_in(disk)


def test_a_full_disk_for_a_batch(mounted: Callable[[str], Path], tmp_path: Path) -> None:
    """A scan that does not fit fails in words, alone; so does the batch if its own files do not fit."""
    disk = mounted("60k")
    done = run_process("batch", "smooth_taubin", BONE, "-o", disk)
    assert done.returncode == 1
    assert "the disk is full" in done.stderr
    assert "Errno" not in done.stderr
    assert "Traceback" not in done.stderr
    assert not (disk / BONE.name).exists()


def test_files_on_two_disks_are_placed_together_or_not_at_all(mounted: Callable[[str], Path], tmp_path: Path) -> None:
    """If the last of them cannot be placed, what was on both disks is there again, and nothing else."""
    disk, stage = mounted("1m"), tmp_path / "stage"
    (stage / "old").mkdir(parents=True)
    for name in ("map", "mesh"):
        (stage / name).write_bytes(b"new")
    (disk / "map.ply").write_bytes(b"former map")
    (tmp_path / "mesh.ply").mkdir()
    files = [StagedFile(stage / "map", disk / "map.ply"), StagedFile(stage / "mesh", tmp_path / "mesh.ply")]
    with pytest.raises(OutputError, match=r"cannot write .*mesh\.ply: cannot put it in place"):
        place(files, stage)
    assert (disk / "map.ply").read_bytes() == b"former map"
    assert names_in(disk) == {"map.ply"}
    (tmp_path / "mesh.ply").rmdir()
    (stage / "map").write_bytes(b"new")
    place(files, stage)
    assert (disk / "map.ply").read_bytes() == (tmp_path / "mesh.ply").read_bytes() == b"new"
    assert names_in(disk) == {"map.ply"}


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "smooth_taubin", BONE, "-o", "{}/out.ply"),
        ("run", "smooth_taubin", "scan.ply", "-o", "out.ply"),
        ("batch", "smooth_taubin", BONE, "-o", "{}/out"),
        ("upgrade", "old.mlx", "-o", "new.mlx"),
        ("demo",),
    ],
    ids=lambda arguments: " ".join(map(str, arguments[:1])),
)
def test_a_working_folder_that_is_gone(arguments: tuple[str, ...], tmp_path: Path) -> None:
    """Every command says so before it does anything."""
    folder = tmp_path / "folder"
    folder.mkdir()
    words = [str(word).format(tmp_path) for word in arguments]
    script = 'cd "$1" && rmdir "$1" && shift && exec "$@"'
    done = subprocess.run(["sh", "-c", script, "sh", folder, *COMMAND, *words], capture_output=True, text=True)
    assert done.returncode == 1
    assert "error: the working folder does not exist any more; change to another one" in done.stderr
    assert "Errno" not in done.stderr
    assert not names_in(tmp_path)


def test_a_working_folder_that_goes_during_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The output was written, so the run ends with 0."""
    from pymeshfair.commands import run

    folder = tmp_path / "folder"
    folder.mkdir()
    monkeypatch.chdir(folder)
    shown = run._show

    def show(result: object) -> None:
        shutil.rmtree(folder)
        shown(result)  # type: ignore[arg-type]

    monkeypatch.setattr(run, "_show", show)
    done = invoke("run", "smooth_taubin", BONE, "-o", tmp_path / "out.ply")
    assert done.exit_code == 0, done.stderr
    assert str(tmp_path / "out.ply.provenance.json") in done.stdout
