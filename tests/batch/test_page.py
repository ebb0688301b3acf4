"""The page of a batch tells the few from the many."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from pymeshfair.batch import page
from pymeshfair.batch.outcomes import Outcome, Summary
from pymeshfair.batch.page import warning_kinds, write_page
from pymeshfair.files.errors import InputError
from pymeshfair.recipe import load_recipe
from pymeshfair.running.job import Job


def summary_of(folder: Path, count: int) -> Summary:
    """Of so many scans, each of which moved more than the one before and has warnings."""
    measures = {"mean_edge": 1.0, "mean_spacing": None, "area": 1.0, "roughness": 3.0, "vertices": 10}
    outcomes = []
    for k in range(count):
        moved = {"mean": 0.1 * k, "rms": 0.1 * k, "largest": 0.1 * k}
        warnings = (f"{k + 1:,} faces have no area; 1.5e-{k} of the surface", "the texture is not there")[: 1 + (k % 4 == 0)]
        output = str(folder / f"{k:02}.ply")
        done = Outcome(f"/in/{k:02}.ply", output, "done", 1.0, before=measures, after=measures, displacement=moved)
        outcomes.append(replace(done, warnings=warnings))
    job = Job(load_recipe("smooth_taubin"), folder, folder)
    return Summary(outcomes, count, job, started="then", finished="now", seconds=20.0)


def test_warnings_are_grouped_by_kind(tmp_path: Path) -> None:
    """Those that differ in numbers alone are one, with how many scans have it; the most frequent come first."""
    summary = summary_of(tmp_path, 12)
    assert [(kind["count"], kind["names"]) for kind in warning_kinds(summary)] == [
        (12, ["00.ply", "01.ply", "02.ply", "03.ply", "04.ply"]),
        (3, ["00.ply", "04.ply", "08.ply"]),
    ]
    page = write_page(tmp_path, summary, {}).read_text("utf-8")
    assert "Warnings by kind" in page
    assert "04.ply and 7 more" in page


def test_pages_that_were_drawn_are_linked(tmp_path: Path) -> None:
    """The scan that moved most comes first; one without a page has none to follow, or the reason why."""
    summary = summary_of(tmp_path, 4)
    outputs = [outcome.output for outcome in summary.outcomes]
    page = write_page(tmp_path, summary, {outputs[0]: "", outputs[3]: "", outputs[1]: "no room"}).read_text("utf-8")
    assert re.findall(r'<a href="reports/(.*?).ply.html', page) == ["03", "00"]
    assert page.count("no page: no room") == 1


def test_the_page_of_a_batch_names_no_folders_and_tells_what_an_earlier_batch_wrote(tmp_path: Path) -> None:
    """Errors keep the names of files; scans written by an earlier batch count neither as the work nor as the time of this one."""
    summary = summary_of(tmp_path, 3)
    told = ("/in/00.ply is old",)
    first, second, third = (replace(outcome, resumed=True, warnings=told) for outcome in summary.outcomes)
    failed = Outcome.of_error(Path("/in/03.ply"), tmp_path / "03.ply", InputError(Path("/in/03.ply"), "it is empty"), 1.0, "")
    outcomes = (first, second, replace(third, status="broken"), failed)
    page = write_page(tmp_path, replace(summary, outcomes=outcomes, planned=4), {first.output: f"{tmp_path}/reports is full"})
    text = page.read_text("utf-8")
    for folder in (str(tmp_path), "/in/", "20 s"):
        assert folder not in text
    for words in ("cannot read 03.ply: it is empty", "no page: reports is full", "2 of 4 scans were done."):
        assert words in text
    for element in ("li", "td"):
        assert f"<{element}>00.ply is old</{element}>" in text
    lines = "1 were written although they break a limit.", "3 were cleaned by an earlier batch.", "1 failed."
    assert [text.index(line) for line in lines] == sorted(text.index(line) for line in lines)


def test_the_page_of_an_earlier_run_is_drawn_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A later run may write the same bytes and have broken a limit: its page is another one. The page of the same run stays."""
    digests = {part: {"sha256": f"{k}" * 64} for k, part in enumerate(("input", "recipe", "output"))}
    monkeypatch.setattr(page, "read_provenance", lambda _: {**digests, "run": {"started": "2026-11-28T08:00:00Z"}})
    arguments: Any = (Path("scan.ply"), tmp_path / "scan.ply", tmp_path / "scan.ply.html")
    options: Any = {"memory": None, "overwrite": True, "workers": Mock(**{"lend.side_effect": LookupError("drawn")})}
    marks = " ".join(part["sha256"] for part in digests.values())
    arguments[2].write_text(f"{marks} 2026-11-28T08:00:00Z", "utf-8")
    page.draw(*arguments, **options)
    arguments[2].write_text(f"{marks} 2026-11-28T07:00:00Z", "utf-8")
    with pytest.raises(LookupError, match="drawn"):
        page.draw(*arguments, **options)
