"""What a batch shows while it goes on."""

from __future__ import annotations

from pathlib import Path

import pytest

from pymeshfair.batch.outcomes import Outcome
from pymeshfair.batch.plan import RequestedScan, Scan, plan_scans
from pymeshfair.commands.batch import BatchBar, BatchLines
from pymeshfair.recipe import load_recipe

MEASURES = {"mean_edge": 2.0, "mean_spacing": None}


@pytest.fixture
def scans(tmp_path: Path) -> list[Scan]:
    """Three scans."""
    return plan_scans([RequestedScan(tmp_path / f"{name}.ply") for name in "abc"], load_recipe("smooth_taubin"), tmp_path / "out")


def outcomes(scans: list[Scan]) -> list[Outcome]:
    """One that moved by half an edge with a warning, one by a quarter, and one that failed, whose error rings the bell."""
    first, second, third = ((str(scan.input), str(scan.output)) for scan in scans)
    return [
        Outcome(*first, "done", 1.5, before=MEASURES, displacement={"rms": 1.0, "largest": 2.0}, warnings=("w",)),
        Outcome(*second, "done", 0.5, before=MEASURES, displacement={"rms": 0.5, "largest": 1.0}),
        Outcome(*third, "failed", 0.1, error={"message": "torn\a"}),
    ]


def test_lines_count_the_scans(scans: list[Scan], capsys: pytest.CaptureFixture[str]) -> None:
    """One line a scan on stderr, with its number, how far it moved or why it failed, and a page that could not be made."""
    with BatchLines() as show:
        show.begin(3)
        for scan, outcome in zip(scans, outcomes(scans), strict=True):
            show.outcome(scan, outcome)
        show.page(scans[0], "")
        show.page(scans[1], "no room")
    assert capsys.readouterr().err.splitlines() == [
        "[1/3] a.ply: 1.50 s, moved by 0.5 edges, 1 warning",
        "[2/3] b.ply: 0.50 s, moved by 0.25 edges",
        "[3/3] c.ply: failed: torn\\x07",
        "b.ply: no page: no room",
    ]


def test_the_bar_counts_failures(scans: list[Scan], capsys: pytest.CaptureFixture[str]) -> None:
    """How many have failed; failures are said above the bar, and stay there."""
    with BatchBar() as show:
        show.begin(3)
        for scan, outcome in zip(scans, outcomes(scans), strict=True):
            show.outcome(scan, outcome)
        (task,) = show._bar.tasks
        assert (task.completed, task.total) == (3, 3)
        assert task.description == "1 failed or broken"
    assert "c.ply: failed: torn\\x07" in capsys.readouterr().err
