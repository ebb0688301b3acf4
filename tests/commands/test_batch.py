"""`pymeshfair batch`: what it checks, what it writes, what it says, and how it ends."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import pytest

from pymeshfair.running.verify import verify_output
from tests.batch.batches import contents, journal_of, results_of_run, write_recipe, write_scan, write_scans

from .command_line import document, invoke, run_process


def batch(*arguments: str | Path) -> dict[str, Any]:
    """The document of a batch that ends well."""
    done = run_process("batch", *arguments, "--json")
    assert done.returncode == 0, done.stderr
    return document(done.stdout)


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """With a report: six scans, of which one is torn, one noisier than the others, and one has a name that is HTML."""
    folder = tmp_path_factory.mktemp("reported")
    scans = write_scans(folder / "scans", 3, subdivisions=3)
    write_scan(scans / "<b>bold&.ply", 9, subdivisions=3)
    write_scan(scans / "noisy.ply", 3, subdivisions=3, noise=0.03)
    torn = write_scan(scans / "torn.ply", 5)
    torn.write_bytes(torn.read_bytes()[:-50])
    done = run_process("batch", write_recipe(folder / "recipe.mlx"), scans, "-o", folder / "out", "--report")
    assert done.returncode == 1, done.stderr
    return folder, {"stdout": done.stdout, "stderr": done.stderr}


@pytest.mark.slow
def test_results_are_those_of_run(reported: tuple[Path, dict[str, Any]]) -> None:
    """Byte for byte, meshes and provenance, the times and the number of threads aside."""
    folder, _ = reported
    expected = results_of_run(folder / "recipe.mlx", folder / "scans", folder / "run", only=["scan001.ply", "noisy.ply"])
    found = contents(folder / "out")
    assert {name: found[name] for name in expected} == expected
    assert len(expected) == 4


def test_a_batch_tells_what_it_did(reported: tuple[Path, dict[str, Any]]) -> None:
    """A row a scan on stdout and in batch.csv; the failure and its reason on stderr; one line a scan in the journal."""
    folder, said = reported
    with (folder / "out" / "batch.csv").open(newline="", encoding="utf-8") as file:
        rows = {Path(row["input"]).name: row for row in csv.DictReader(file)}
    assert [rows[name]["status"] for name in ("scan000.ply", "<b>bold&.ply", "torn.ply")] == ["done", "done", "failed"]
    assert rows["scan000.ply"]["vertices_after"] == "642"
    assert 0.0 < float(rows["scan000.ply"]["displacement_rms_in_edges"]) < 1.0
    assert rows["noisy.ply"]["far_in"] != ""
    assert rows["scan000.ply"]["far_in"] == ""
    assert "5 of 6 scans done, 1 failed" in said["stdout"]
    assert re.search(r"^noisy\.ply +done .*far from the others", said["stdout"], re.MULTILINE)
    assert re.search(r"error: .*torn\.ply", said["stderr"])
    assert "[6/6]" in said["stderr"]
    assert len(journal_of(folder / "out")) == 6


def test_the_page_of_a_batch(reported: tuple[Path, dict[str, Any]]) -> None:
    """Failures first, outliers marked, each scan linked to a page of its own, names never as markup."""
    folder, _ = reported
    page = (folder / "out" / "batch.html").read_text("utf-8")
    names = re.findall(r'<th scope="row" data-value="([^"]*)">', page)
    assert names[:2] == ["torn.ply", "noisy.ply"]
    assert len(names) == 6
    assert "&lt;b&gt;bold&amp;.ply" in names
    assert "<b>bold" not in page
    assert 'class="number far"' in page
    links = re.findall(r'<a href="(reports/[^"]+)"', page)
    assert "reports/%3Cb%3Ebold%26.ply.html" in links
    assert len(list((folder / "out" / "reports").glob("*.html"))) == len(links) == 5
    assert "http:" not in page.replace("http://www.w3.org", "")


def test_a_resumed_report_takes_what_is_there(reported: tuple[Path, dict[str, Any]]) -> None:
    """Pages of scans that have not changed are not drawn again, and the page has all of them."""
    folder, _ = reported
    pages = {page: page.stat().st_mtime_ns for page in (folder / "out" / "reports").glob("*.html")}
    done = run_process("batch", folder / "recipe.mlx", folder / "scans", "-o", folder / "out", "--report", "--resume", "--json")
    assert document(done.stdout)["counts"]["resumed"] == 5
    assert {page: page.stat().st_mtime_ns for page in (folder / "out" / "reports").glob("*.html")} == pages
    assert (folder / "out" / "batch.html").read_text("utf-8").count('<a href="reports/') == 5


def test_a_dry_run_changes_nothing(tmp_path: Path) -> None:
    """It tells what would be done with every scan, and every problem, and makes not even the folder."""
    scans = write_scans(tmp_path / "scans", 2)
    (scans / "empty.ply").write_bytes(b"")
    done = run_process(
        "batch", "smooth_taubin", scans, "-o", tmp_path / "out", "--name", "{stem}_clean.ply", "--dry-run", "--json"
    )
    assert done.returncode == 1
    found = document(done.stdout)
    assert [Path(s["output"]).name for s in found["scans"]] == ["empty_clean.ply", "scan000_clean.ply", "scan001_clean.ply"]
    assert [s["state"] for s in found["scans"]] == ["cannot be done", "to do", "to do"]
    assert "it is empty" in found["scans"][0]["problem"]
    assert "error: scan 1: cannot read" in done.stderr
    assert found["steps"] == ["Taubin Smooth"]
    assert not (tmp_path / "out").exists()
    (scans / "empty.ply").unlink()
    shown = invoke("batch", "smooth_taubin", scans, "-o", tmp_path / "out", "--dry-run")
    assert shown.exit_code == 0
    assert "2 of 2 scans to do" in shown.stdout


def test_the_folder_of_outputs_may_be_named_from_below(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """``-o ../out`` is the folder beside the working folder."""
    write_scan(tmp_path / "scan.ply", 1)
    (tmp_path / "deep").mkdir()
    monkeypatch.chdir(tmp_path / "deep")
    shown = invoke("batch", "smooth_taubin", "../scan.ply", "-o", "../out", "--dry-run", "--json")
    assert shown.exit_code == 0, shown.stderr
    assert [scan["output"] for scan in document(shown.stdout)["scans"]] == [str(tmp_path / "out" / "scan.ply")]


@pytest.mark.parametrize(
    ("out", "name", "problem"),
    [
        ("new/deep", "{stem}.foo", "'.foo' is no format"),
        ("new/deep", "x" * 300 + ".ply", "255 are the most"),
        ("scan.ply/deep", "", "the folder .*scan.ply is no folder"),
    ],
)
def test_a_dry_run_sees_what_cannot_be_written_to_a_new_folder(tmp_path: Path, out: str, name: str, problem: str) -> None:
    """An output that cannot be written is a problem whether its folder is there or not."""
    scan = write_scan(tmp_path / "scan.ply", 1)
    shown = invoke("batch", "smooth_taubin", scan, "-o", tmp_path / out, "--name", name, "--dry-run", "--json")
    assert shown.exit_code == 1
    (found,) = document(shown.stdout)["scans"]
    assert found["state"] == "cannot be done"
    assert re.search(problem, found["problem"])


def test_advice_at_the_end_works(tmp_path: Path) -> None:
    """After --stop the scans that are left need --resume without --stop; a broken limit needs an option that batch has."""
    scans = write_scans(tmp_path / "scans", 2)
    options = ("--max-displacement", "0.0001", "--stop", "--jobs", "1")
    done = run_process("batch", "smooth_taubin", scans, "-o", tmp_path / "out", *options)
    assert "The same command with --resume and without --stop cleans those that are left." in done.stdout
    assert "--keep-broken also writes scans that break a limit" in done.stdout
    assert "--map" not in done.stderr


def test_a_sample_leaves_the_rest(tmp_path: Path) -> None:
    """Of four scans two are cleaned, one of each size."""
    scans = tmp_path / "scans"
    scans.mkdir()
    for k in range(4):
        write_scan(scans / f"{k}.ply", k, subdivisions=1 + k // 2)
    found = batch("smooth_taubin", scans, "-o", tmp_path / "out", "--sample", "2")
    assert found["counts"] == {"scans": 4, "done": 2, "broken": 0, "failed": 0, "resumed": 0, "left": 2}
    assert {int(Path(s["input"]).stem) // 2 for s in found["scans"]} == {0, 1}
    shown = run_process("batch", "smooth_taubin", scans, "-o", tmp_path / "again", "--sample", "2")
    assert "The same command with --resume and without --sample cleans those that are left." in shown.stdout


@pytest.mark.slow
def test_limits_hold_for_every_scan(tmp_path: Path) -> None:
    """A scan that goes beyond a limit is not written and named; --keep-broken writes it, and it is not done for all that."""
    scans = write_scans(tmp_path / "scans", 2)
    recipe = write_recipe(tmp_path / "recipe.mlx")
    refused = run_process("batch", recipe, scans, "-o", tmp_path / "a", "--max-displacement", "0.0001")
    assert refused.returncode == 1
    assert not list((tmp_path / "a").glob("*.ply"))
    assert "max_displacement: vertex" in refused.stderr
    kept = run_process("batch", recipe, scans, "-o", tmp_path / "b", "--max-displacement", "0.0001", "--keep-broken", "--json")
    assert kept.returncode == 1
    assert document(kept.stdout)["counts"]["broken"] == 2
    assert len(list((tmp_path / "b").glob("*.ply"))) == 2
    resumed = run_process("batch", recipe, scans, "-o", tmp_path / "b", "--max-displacement", "0.0001", "--resume", "--json")
    assert document(resumed.stdout)["counts"]["failed"] == 2


@pytest.mark.slow
def test_stop_ends_at_the_first_failure(tmp_path: Path) -> None:
    """Scans behind it are left, and --resume without --stop does them."""
    scans = write_scans(tmp_path / "scans", 3)
    (scans / "scan000.ply").write_bytes(b"ply\n")
    stopped = run_process("batch", "smooth_taubin", scans, "-o", tmp_path / "out", "--stop", "--jobs", "1", "--json")
    assert stopped.returncode == 1
    counts = document(stopped.stdout)["counts"]
    assert counts["failed"] == 1
    assert counts["left"] >= 1
    resumed = run_process("batch", "smooth_taubin", scans, "-o", tmp_path / "out", "--resume", "--json")
    assert document(resumed.stdout)["counts"] | {"resumed": 0} == {
        "scans": 3,
        "done": 2,
        "broken": 0,
        "failed": 1,
        "resumed": 0,
        "left": 0,
    }


@pytest.mark.slow
def test_textures_of_one_name_do_not_meet(tmp_path: Path) -> None:
    """Two scans whose textures have one name each keep their own, whichever was first; made again from their provenance, too."""
    from PIL import Image

    for k, color in enumerate(("red", "blue")):
        folder = tmp_path / f"in{k}"
        folder.mkdir()
        Image.new("RGB", (4, 4), color).save(folder / "texture.png")
        (folder / "m.mtl").write_text("newmtl m\nmap_Kd texture.png\n")
        lines = ["mtllib m.mtl", "v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1", "vt 0 0", "vt 1 0", "vt 0 1", "usemtl m"]
        (folder / f"scan{k}.obj").write_text("\n".join([*lines, "f 1/1 3/3 2/2", "f 1/1 2/2 4/3", ""]))
    batch("smooth_taubin", tmp_path / "in0", tmp_path / "in1", "-o", tmp_path / "out")
    for k in range(2):
        image = tmp_path / "out" / f"scan{k}.obj-texture.png"
        assert image.read_bytes() == (tmp_path / f"in{k}" / "texture.png").read_bytes()
        assert f"map_Kd {image.name}" in (tmp_path / "out" / f"scan{k}.obj.mtl").read_text()
        assert verify_output(tmp_path / "out" / f"scan{k}.obj").verdict == "identical"


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("nothing", "x.ply", "-o", "out"), 2, "there is no recipe 'nothing'"),
        (("smooth_taubin", "*.ply", "-o", "out"), 2, "no file fits the pattern"),
        (("smooth_taubin", "x.ply", "y/x.ply", "-o", "out"), 2, "files would be overwritten"),
        (("smooth_taubin", "x.ply", "-o", "out", "--memory", "2"), 2, "less than the 100 MB"),
        (("smooth_taubin", "x.ply", "-o", "out", "--set", "1.nothing=2"), 2, "nothing"),
        (("smooth_taubin", "", "-o", "out"), 2, "an INPUT is empty"),
        (("smooth_taubin", "x.ply", "-o", "out", "--timeout", "nan"), 2, "must be above 0 seconds"),
        (("smooth_taubin", "x.ply", "-o", "out", "--no-measures", "--require", "manifold"), 2, "limits need measures"),
        (("smooth_taubin", "x.ply", "-o", "out", "--jobs", "2", "--scheduler", "tcp://x:1"), 2, "--jobs"),
    ],
)
def test_wrong_usage_begins_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], code: int, message: str
) -> None:
    """The message says what, and the folder is not even made."""
    monkeypatch.chdir(tmp_path)
    done = invoke("batch", *arguments)
    assert done.exit_code == code
    assert message in done.stderr
    assert not (tmp_path / "out").exists()


def test_the_summary_is_that_of_the_file(tmp_path: Path) -> None:
    """--json prints what batch.json holds."""
    found = batch("smooth_taubin", write_scan(tmp_path / "a.ply", 1), "-o", tmp_path / "out")
    assert json.loads((tmp_path / "out" / "batch.json").read_text("utf-8")) == found
    assert found["scans"][0]["digests"]["output"]
