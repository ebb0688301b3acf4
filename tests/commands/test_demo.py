"""`pymeshfair demo` is the first thing that anyone runs."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from pymeshfair.commands.run import sample_scan
from pymeshfair.files.outputs import MadeFrom, check_output
from pymeshfair.recipe import load_recipe

from .command_line import invoke, run_process


def test_demo_cleans_the_range_map_and_names_what_to_try_next(tmp_path: Path) -> None:
    """The scan of 85,849 vertices comes out in fewer pieces; the demo can be run again."""
    folder = tmp_path / "new" / "demo"
    done = run_process("demo", "-o", folder)
    assert done.returncode == 0, done.stderr
    written = folder / "face_clean.ply"
    assert {p.name for p in folder.iterdir()} == {"face.ply", written.name, f"{written.name}.provenance.json"}
    assert (folder / "face.ply").read_bytes() == sample_scan().read_bytes()
    assert str(written) in done.stdout
    before, after = re.search(r"^vertices +([\d,]+) +([\d,]+)", done.stdout, re.MULTILINE).groups()  # type: ignore[union-attr]
    assert before == "85,849"
    assert 0.9 * 85_849 < int(after.replace(",", "")) < 85_849
    before, after = re.search(r"^components +([\d,]+) +([\d,]+)", done.stdout, re.MULTILINE).groups()  # type: ignore[union-attr]
    assert int(after.replace(",", "")) < int(before.replace(",", ""))
    provenance = json.loads((folder / f"{written.name}.provenance.json").read_text("utf-8"))
    assert provenance
    made_from = MadeFrom(sample_scan(), load_recipe("clean_range_map").digest)
    check_output(written, made_from, overwrite=False)  # so a second demo may replace the result of the first


def test_commands_to_try_next_can_be_copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each command that the demo proposes is one that pymeshfair reads, with files that exist."""
    from pymeshfair.commands import run as demo

    jobs = []
    folder = tmp_path / "a folder"
    with monkeypatch.context() as patched:
        patched.setattr(demo, "carry_out", lambda job, carry, **options: jobs.append(job))
        done = invoke("demo", "-o", folder)
    assert done.exit_code == 0
    assert jobs[0].input == sample_scan()
    proposed = [shlex.split(line) for line in done.stderr.splitlines() if line.startswith("  pymeshfair ")]
    assert [words[1] for words in proposed] == ["info", "run", "list"]
    for words in proposed:
        if words[1] != "run":
            assert invoke(*words[1:]).exit_code == 0
        else:
            assert Path(words[3]).read_bytes() == sample_scan().read_bytes()
            checked = invoke(*words[1:], "--timeout", "0.001")  # read and checked, then stopped
            assert checked.exit_code == 1
            assert "the run was given" in checked.stderr


def test_a_file_of_the_user_is_no_sample(tmp_path: Path) -> None:
    """A face.ply that is not the sample is refused with a way out, since the commands to try next would work on it."""
    (tmp_path / "face.ply").write_text("mine", encoding="utf-8")
    done = invoke("demo", "-o", tmp_path)
    assert done.exit_code == 1
    assert f"cannot write {tmp_path / 'face.ply'}: another file has this name; name another folder with --output" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["face.ply"]


def test_a_folder_that_cannot_be_made_is_a_message(tmp_path: Path) -> None:
    """A file in the way of the folder ends with 1 and names it."""
    (tmp_path / "demo").write_text("a file", encoding="utf-8")
    done = invoke("demo", "-o", tmp_path / "demo")
    assert done.exit_code == 1
    assert done.stderr.startswith(f"error: cannot write {tmp_path / 'demo'}: ")


def test_a_pymeshlab_without_its_samples_is_a_message(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A pymeshlab from elsewhere than PyPI may lack the scan; the message says so."""
    from pymeshfair.commands import run as demo

    monkeypatch.setattr(demo, "_SCAN", Path("nowhere.ply"))
    done = invoke("demo", "-o", tmp_path)
    assert done.exit_code == 1
    assert "came without its samples" in done.stderr
