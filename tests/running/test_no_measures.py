"""A run that measures nothing before and after."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import pytest

from pymeshfair.errors import ParameterError, StepFailedError
from pymeshfair.files.errors import OutputError
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from pymeshfair.running.verify import verify_output
from pymeshfair.scripts.guards import Guards
from tests.batch.batches import write_scans
from tests.commands.command_line import document, invoke, run_process

from .runs import BONE, SMOOTH, Given, names_in, ply_bytes, recipe_of, xyz


def test_the_output_is_the_same(tmp_path: Path) -> None:
    """Measures are looked at by nobody who computes: without them every byte of the output is the same."""
    with_them = run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "with.ply"))
    without = run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "without.ply", measures=False))
    assert without.output.read_bytes() == with_them.output.read_bytes()
    assert with_them.before


def test_the_record_says_that_none_were_taken(tmp_path: Path) -> None:
    """Nothing stands where measures would; an option of the record says why, and the output can be verified all the same."""
    result = run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply", measures=False))
    record = json.loads(result.provenance.read_text("utf-8"))
    assert record["measures"] == {"unit": None, "before": None, "after": None, "change": None, "traits": {}}
    assert record["options"] == {"no_measures": True}
    assert (result.before, result.after, result.change) == ({}, {}, {})
    assert verify_output(result.output, recorded=True).verdict == "identical"


def test_limits_are_refused(tmp_path: Path) -> None:
    """Limits of the job, or of the recipe, are refused before anything is done, by name."""
    job = Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply", measures=False, guards=Guards.parse({"max_displacement": "1%"}))
    with pytest.raises(ParameterError, match=r"max-displacement 1.0%; leave out --no-measures \(measures=False\), or the limits"):
        run_job(job)
    assert names_in(tmp_path) == set()


def test_a_map_needs_no_measures(tmp_path: Path) -> None:
    """The intervention map follows elements, not measures."""
    result = run_job(Job(recipe_of(SMOOTH), BONE, tmp_path / "out.ply", measures=False, map=tmp_path / "map.ply"))
    assert result.maps == (tmp_path / "map.ply",)


def test_a_mesh_that_the_format_would_destroy_is_refused_all_the_same(tmp_path: Path) -> None:
    """STL rounds to single precision: a tetrahedron of size 1 at 1e9 would be a point, and no output is written."""
    points = xyz()
    far = [(type_, name, [value + 1e9 for value in values]) for type_, name, values in points]
    source = tmp_path / "far.ply"
    source.write_bytes(ply_bytes(far))
    with pytest.raises(OutputError, match=r"are about 1\.1 apart"):
        run_job(Job(recipe_of(), source, tmp_path / "out.stl", measures=False))
    assert names_in(tmp_path) == {"far.ply"}


def test_coordinates_that_are_not_finite_are_refused_all_the_same(tmp_path: Path) -> None:
    """A step that puts vertices at infinity fails with and without measures alike."""
    thrown: Given = ("compute_coord_by_function", {"x": "x/0"})
    told = []
    for measures in (True, False):
        with pytest.raises(StepFailedError, match="not finite") as caught:
            run_job(Job(recipe_of(thrown), BONE, tmp_path / "out.ply", measures=measures))
        told.append(str(caught.value))
    assert told[0] == told[1]


@pytest.mark.slow
def test_the_command_shows_none(tmp_path: Path) -> None:
    """`run --no-measures` prints no table, `--json` has nothing in their places, and a report is refused in words."""
    plain = run_process("run", "smooth_taubin", BONE, "-o", tmp_path / "a.ply", "--no-measures")
    assert plain.returncode == 0, plain.stderr
    assert re.fullmatch(r"1 step in \d+\.\d s\. Written:\n(  .*\n){2}", plain.stdout)
    told = document(run_process("run", "smooth_taubin", BONE, "-o", tmp_path / "b.ply", "--no-measures", "--json").stdout)
    assert [told[part] for part in ("before", "after", "change")] == [None, None, None]
    refused = invoke("run", "smooth_taubin", BONE, "-o", tmp_path / "c.ply", "--no-measures", "--report", tmp_path / "c.html")
    assert refused.exit_code == 2
    assert "a report shows measures" in refused.output


@pytest.mark.slow
def test_a_batch_without_measures(tmp_path: Path) -> None:
    """Every scan is cleaned to the same bytes, its row has no numbers, and --resume knows it again; limits are refused."""
    scans = write_scans(tmp_path / "scans", 2)
    folders = {name: tmp_path / name for name in ("with", "without")}
    run_process("batch", "smooth_taubin", scans, "-o", folders["with"])
    done = run_process("batch", "smooth_taubin", scans, "-o", folders["without"], "--no-measures")
    assert done.returncode == 0, done.stderr
    for path in folders["with"].glob("*.ply"):
        assert (folders["without"] / path.name).read_bytes() == path.read_bytes()
    with (folders["without"] / "batch.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["status"] for row in rows] == ["done", "done"]
    assert {row[name] for row in rows for name in ("vertices_after", "displacement_rms", "area_change_percent")} == {""}
    again = run_process("batch", "smooth_taubin", scans, "-o", folders["without"], "--no-measures", "--resume", "--json")
    assert [scan["status"] for scan in document(again.stdout)["scans"] if scan["resumed"]] == ["done", "done"]
    refused = run_process("batch", "smooth_taubin", scans, "-o", tmp_path / "x", "--no-measures", "--require", "watertight")
    assert refused.returncode != 0
    assert "require watertight; leave out --no-measures" in refused.stderr
