"""The page of a batch in a browser: it sorts, by mouse and by keyboard, and asks the network for nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pymeshfair.batch.outcomes import Outcome, Summary
from pymeshfair.batch.page import write_page
from pymeshfair.recipe import load_recipe
from pymeshfair.running.job import Job


def outcome(folder: Path, name: str, seconds: float, rms: float | None) -> Outcome:
    """Of one scan; a failure where nothing moved."""
    if rms is None:
        return Outcome(f"/in/{name}", str(folder / name), "failed", seconds, error={"message": "<i>torn</i>"})
    measures = {"mean_edge": 1.0, "mean_spacing": None, "area": 1.0, "roughness": 3.0, "vertices": 10}
    moved = {"mean": rms, "rms": rms, "largest": rms}
    return Outcome(f"/in/{name}", str(folder / name), "done", seconds, before=measures, after=measures, displacement=moved)


def names(page: Any) -> list[str]:
    """The scans in the order in which they are shown."""
    found: list[str] = page.locator("table.scans tbody th").all_inner_texts()
    return found


def test_the_page_sorts(tmp_path: Path, page: Any, errors: list[str]) -> None:
    """Failures first; then by the column that was pressed, numbers as numbers, downwards, then upwards; unknown ones last."""
    outcomes = [outcome(tmp_path, *row) for row in (("a.ply", 9.0, 0.2), ("b.ply", 10.0, 0.1), ("c.ply", 1.0, None))]
    summary = Summary(
        outcomes, 3, Job(load_recipe("smooth_taubin"), tmp_path, tmp_path), started="then", finished="now", seconds=20.0
    )
    path = write_page(tmp_path, summary, {})
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(path.as_uri())
    assert names(page) == ["c.ply", "a.ply", "b.ply"]
    assert "<i>torn</i>" in page.locator("table.scans tbody tr").first.inner_text()
    page.get_by_role("button", name="seconds").click()
    assert names(page) == ["b.ply", "a.ply", "c.ply"]
    page.keyboard.press("Enter")
    assert names(page) == ["c.ply", "a.ply", "b.ply"]
    page.get_by_role("button", name="moved (edges)").click()
    page.get_by_role("button", name="moved (edges)").click()
    assert names(page) == ["b.ply", "a.ply", "c.ply"]
    assert page.locator("th[aria-sort]").count() == 1
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []
    assert errors == []
