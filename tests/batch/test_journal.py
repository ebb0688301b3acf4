"""The journal, and which scans are done already."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pymeshfair.batch.outcomes import BatchError, Journal, Outcome, read_journal
from pymeshfair.batch.plan import RequestedScan, Scan, job_of, plan_scans
from pymeshfair.batch.work import done_before
from pymeshfair.files.provenance import provenance_path
from pymeshfair.processes import environment
from pymeshfair.recipe import load_recipe
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from pymeshfair.running.verify import verify_output
from pymeshfair.scripts.guards import Guards
from tests.running.runs import SAMPLES

from .batches import write_scan


def test_torn_lines_are_passed_over(tmp_path: Path) -> None:
    """Half a line, as a killed batch leaves it, is not joined to the next; the last line counts; anew begins with a new scan."""
    with Journal(tmp_path, resume=True) as journal:
        journal.append(Outcome("in", "a", "failed", 1.0))
        journal.append(Outcome("in", "b", "done", 1.0))
    with journal.path.open("ab") as file:
        file.write(json.dumps(Outcome("in", "c", "done", 1.0).to_document()).encode()[:40])
    with Journal(tmp_path, resume=True) as journal:
        assert set(journal.before) == {"a", "b"}
        journal.append(Outcome("in", "a", "done", 2.0))
    found = read_journal(journal.path)
    assert {output: (o.status, o.seconds) for output, o in found.items()} == {"a": ("done", 2.0), "b": ("done", 1.0)}
    with Journal(tmp_path, resume=False) as journal:
        assert set(journal.before) == {"a", "b"}
        assert set(read_journal(journal.path)) == {"a", "b"}
        journal.append(Outcome("in", "d", "done", 1.0))
    assert set(read_journal(journal.path)) == {"d"}


@pytest.mark.skipif(sys.platform == "win32", reason="there is no limit of file sizes")
def test_a_line_that_does_not_fit_on_the_disk_is_an_error(tmp_path: Path) -> None:
    """The system writes what fits and calls that no error; nothing of the line stays, as a journal of half a line is nobody's."""
    import resource

    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    with Journal(tmp_path, resume=True) as journal:
        resource.setrlimit(resource.RLIMIT_FSIZE, (50, limits[1]))
        try:
            with pytest.raises(BatchError, match="the disk is full"):
                journal.append(Outcome("in", "a", "done", 1.0))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert not journal.path.stat().st_size


def test_one_batch_at_a_time(tmp_path: Path) -> None:
    """A journal is held as long as its batch lasts."""
    with Journal(tmp_path, resume=True), pytest.raises(BatchError, match="another batch is writing"):
        Journal(tmp_path, resume=False)
    with Journal(tmp_path, resume=True):
        pass


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Scan, Job]:
    """A folder with one scan, and what a run made of it."""
    folder = tmp_path_factory.mktemp("made")
    template = Job(load_recipe("smooth_taubin"), folder, folder)
    (scan,) = plan_scans([RequestedScan(write_scan(folder / "in.ply", 1))], template.recipe, folder, "out.ply")
    run_job(job_of(template, scan, threads=1, memory=None))
    return folder, scan, template


@pytest.fixture
def done(made: tuple[Path, Scan, Job]) -> Iterator[tuple[Scan, Job]]:
    """The same, to be spoilt."""
    folder, scan, template = made
    kept = {p: p.read_bytes() for p in folder.iterdir()}
    yield scan, template
    for path in folder.iterdir():
        path.unlink()
    for path, data in kept.items():
        path.write_bytes(data)


def test_what_is_there_whole_is_done(done: tuple[Scan, Job]) -> None:
    """The provenance beside an output is enough, and a journal that fits it adds what it tells besides.

    The place of the scan and broken limits are as they are now, not as in the journal.
    """
    scan, template = done
    outcome = done_before([scan], template, {})[1]
    assert outcome.status == "done"
    assert outcome.resumed
    assert outcome.displacement is not None
    told = replace(outcome, displacement={"rms": 0.5, "largest": 1.0}, resumed=False)
    assert done_before([scan], template, {told.output: told})[1].displacement == {"rms": 0.5, "largest": 1.0}
    moved = replace(told, input="elsewhere/scan.ply", status="broken", breaches=({"guard": "require"},))
    assert replace(done_before([scan], template, {told.output: moved})[1], resumed=False) == told
    other = replace(told, digests={**told.digests, "output": "0" * 64})
    assert done_before([scan], template, {other.output: other})[1].displacement == outcome.displacement


def other_version(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another version of numba is installed now."""
    true = environment._version
    monkeypatch.setattr(environment, "_version", lambda name: "0.1" if name == "numba" else true(name))


def test_a_changed_texture_of_a_further_layer_is_noticed(tmp_path: Path) -> None:
    """The files that a layer names count like the layer: the scan is not done, and `verify` names the texture."""
    for name in ("bunny10k_textured.obj", "bunny10k_textured.mtl", "TextureDouble_A.png"):
        shutil.copy(SAMPLES / name, tmp_path)
    template = Job(load_recipe("smooth_taubin"), tmp_path, tmp_path, others=(tmp_path / "bunny10k_textured.obj",))
    (scan,) = plan_scans([RequestedScan(write_scan(tmp_path / "in.ply", 1))], template.recipe, tmp_path, "out.ply")
    run_job(job_of(template, scan, threads=1, memory=None))
    assert list(done_before([scan], template, {})) == [scan.number]
    texture = tmp_path / "TextureDouble_A.png"
    texture.write_bytes(texture.read_bytes() + b"painted")
    assert done_before([scan], template, {}) == {}
    found = verify_output(scan.output)
    assert (found.verdict, found.findings) == ("input changed", (f"{texture} is not what it was (its SHA-256 is different)",))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda scan: write_scan(scan.input, 2),
        lambda scan: scan.output.write_bytes(scan.output.read_bytes()[:-1] + b"x"),
        lambda scan: scan.output.unlink(),
        lambda scan: provenance_path(scan.output).unlink(),
        lambda scan: provenance_path(scan.output).write_text("{}"),
        lambda scan: shutil.move(scan.input, scan.input.with_name("moved.ply")),
    ],
    ids=["another input", "a changed output", "no output", "no provenance", "another document", "no input"],
)
def test_what_has_changed_is_not_done(done: tuple[Scan, Job], spoil: Callable[[Scan], object]) -> None:
    """Whatever is not what the provenance says is done again."""
    scan, template = done
    spoil(scan)
    assert done_before([scan], template, {}) == {}


def test_another_recipe_limit_or_version_is_not_done(done: tuple[Scan, Job], monkeypatch: pytest.MonkeyPatch) -> None:
    """What would be made otherwise now is done again."""
    scan, template = done
    recipe = template.recipe.override(["1.stepsmoothnum=3"])
    assert done_before([replace(scan, recipe=recipe)], replace(template, recipe=recipe), {}) == {}
    assert done_before([scan], replace(template, guards=Guards.parse({"keep_sharp": "1%"})), {}) == {}
    other_version(monkeypatch)
    assert done_before([scan], template, {}) == {}


@pytest.mark.parametrize(
    "options", [{"keep_all": True}, {"unit": "mm"}, {"measures": False}], ids=lambda options: next(iter(options))
)
def test_what_was_made_without_an_option_is_not_done(done: tuple[Scan, Job], options: dict[str, Any]) -> None:
    """An option that the provenance does not have is not taken as given."""
    scan, template = done
    assert done_before([scan], replace(template, **options), {}) == {}


def test_what_has_moved_with_its_input_is_done(done: tuple[Scan, Job], tmp_path: Path) -> None:
    """What counts are the contents of the files, in whatever folder; they are no other input for a run either."""
    scan, template = done
    for path in scan.input.parent.iterdir():
        shutil.copy2(path, tmp_path)
    moved = replace(scan, input=tmp_path / scan.input.name, output=tmp_path / scan.output.name)
    shutil.move(scan.input, scan.input.with_name("gone.ply"))
    assert list(done_before([moved], template, {})) == [moved.number]
    run_job(job_of(template, moved, threads=1, memory=None))
    moved.output.write_bytes(b"")
    assert done_before([moved], template, {}) == {}
