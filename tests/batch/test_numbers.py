"""What lies far from the others."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from pymeshfair.batch.outcomes import FAR, Outcome, Summary, outliers, robust_z
from pymeshfair.running.job import Job


def outcome(name: str, *, rms: float = 0.1, area: float = 1.0, status: str = "done") -> Outcome:
    """Of a scan of mean edge 2 and area 10."""
    before = {"mean_edge": 2.0, "mean_spacing": None, "area": 10.0, "roughness": 5.0}
    if status == "failed":
        return Outcome(name, name, "failed", 1.0, error={"message": "broken"})
    return Outcome(
        name, name, "done", 1.0, before=before, after={**before, "area": 10.0 * area}, displacement={"rms": rms, "largest": rms}
    )


def test_robust_z_is_the_usual_one_of_normal_numbers() -> None:
    """Of many normal numbers it is the distance from the mean in standard deviations, within what their number allows."""
    numbers = np.random.default_rng(5).normal(loc=3.0, scale=0.7, size=20_000)
    found = np.array(robust_z(numbers.tolist()), dtype=np.float64)
    np.testing.assert_allclose(found, (numbers - 3.0) / 0.7, atol=0.15)


def test_robust_z_of_equal_numbers() -> None:
    """Where all are the same none is far; where more than half are, the mean deviation tells the one that is not."""
    assert robust_z([2.0] * 9) == [None] * 9
    found = robust_z([2.0] * 9 + [3.0])
    assert found[:9] == [0.0] * 9
    assert found[9] == pytest.approx(1.0 / (1.253314 * 0.1))


def test_robust_z_leaves_out_what_is_not_known() -> None:
    """None and infinity take no part, and of fewer than five numbers none is far."""
    assert robust_z([1.0, 2.0, 3.0, 100.0]) == [None] * 4
    found = robust_z([1.0, 2.0, None, 3.0, float("inf"), 4.0, 100.0])
    assert found[2] is None
    assert found[4] is None
    assert found[6] is not None
    assert found[6] > FAR


def test_outliers_say_in_what() -> None:
    """One scan that moved ten times as far and one that lost a third of its area are marked, the others are not."""
    scans = [outcome(f"{k}", rms=0.1 + 0.001 * k, area=1.0 + 0.001 * k) for k in range(10)]
    scans += [outcome("far", rms=1.0), outcome("lost", area=0.67), outcome("failed", status="failed")]
    assert outliers(scans) == [()] * 10 + [("displacement",), ("area",), ()]


def test_failures_come_first_then_what_moved_most() -> None:
    """The order of the page and of the short table."""
    scans = [outcome("a", rms=0.1), outcome("b", rms=0.3), outcome("c", status="failed")]
    summary = Summary(scans, len(scans), cast("Job", None), started="", finished="", seconds=0.0)
    assert [o.input for o, _, _ in summary.worst_first] == ["c", "b", "a"]


def test_numbers_that_json_cannot_hold_end_no_batch() -> None:
    """Of a scan whose area overflows, which documents hold as a text, the change of the area is unknown and not far."""
    scans = [outcome(f"{k}", rms=0.1 + 0.001 * k) for k in range(6)]
    huge = {"mean_edge": "inf", "mean_spacing": None, "area": "inf", "roughness": 5.0}
    scans.append(Outcome("huge", "huge", "done", 1.0, before=huge, after=huge, displacement={"rms": "inf", "largest": 1.0}))
    assert outliers(scans) == [()] * 7
