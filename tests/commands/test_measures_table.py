"""The table of before and after."""

from __future__ import annotations

import pytest

from pymeshfair.commands.display import show_measures

USUAL = ["vertices", "faces", "border edges", "components", "area", "mean edge", "roughness"]


def shown(before: dict[str, object], after: dict[str, object], capsys: pytest.CaptureFixture[str]) -> list[list[str]]:
    """The cells of the table's rows."""
    show_measures({"before": before, "after": after})
    return [[cell for cell in line.split("  ") if cell.strip()] for line in capsys.readouterr().out.splitlines()[2:]]


def test_usual_measures_are_always_there(capsys: pytest.CaptureFixture[str]) -> None:
    """The seven measures of the contract are shown in their order, a missing one as a dash."""
    rows = shown({"vertices": 1234567, "area": 0.123456789}, {"vertices": 0, "area": 12345678.9}, capsys)
    assert [row[0].strip().partition(" (")[0] for row in rows] == USUAL
    cells = {row[0].strip(): [cell.strip() for cell in row[1:]] for row in rows}
    assert cells["vertices"] == ["1,234,567", "0"]
    assert cells["area"] == ["0.123457", "1.23457e+07"]
    assert cells["faces"] == ["-", "-"]


def test_rare_measures_are_shown_where_they_say_something(capsys: pytest.CaptureFixture[str]) -> None:
    """Non-manifold edges are a row if one of the meshes has some; zeros in both are not."""
    names = [row[0].strip() for row in shown({"non_manifold_edges": 3, "degenerate_faces": 0}, {"degenerate_faces": 0}, capsys)]
    assert "non-manifold edges" in names
    assert "degenerate faces" not in names


def test_a_run_by_tiles_shows_what_it_measured(capsys: pytest.CaptureFixture[str]) -> None:
    """Of a mesh whose elements alone were counted, the table has no rows of dashes."""
    assert [row[0].strip() for row in shown({"vertices": 4, "faces": 2}, {"vertices": 4, "faces": 2}, capsys)] == USUAL[:2]


def test_measures_beyond_all_numbers_are_said(capsys: pytest.CaptureFixture[str]) -> None:
    """The area of a mesh that is 1e160 large is no number of double precision, and stands as the text that records give it."""
    rows = shown({"area": "inf"}, {"area": 2.0}, capsys)
    assert ["inf", "2"] in [[cell.strip() for cell in row[1:]] for row in rows]
