"""``batch.html``: one page with a row a scan, failures first."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ..report.comparison_page import Verdict
from ..report.page import render
from .drawing import page_path
from .journal import Outcome
from .numbers import area_change, displacement_in_edges, largest_in_edges, worst_first
from .summary import Summary, write_text

NAME = "batch.html"
#: so many scans, those that moved most, have pictures on the page
_PICTURES = 10
#: so many scans are named with each kind of warning
_EXAMPLES = 5
#: the head of each column of numbers, and in which of `pymeshfair.batch.numbers.QUESTIONS` it tells outliers
_COLUMNS = (
    ("moved (edges)", "displacement"),
    ("at most", ""),
    ("area %", "area"),
    ("roughness before", "noise"),
    ("after", ""),
    ("vertices", ""),
    ("seconds", ""),
)


def write_page(folder: Path, summary: Summary, made: Mapping[str, Mapping[str, Any]]) -> Path:
    """Write the page; `made` has of each output what `pymeshfair.batch.drawing.draw` gave back, ``"problem"``, or nothing."""
    told = {outcome.output: (name, far) for outcome, name, far in summary.rows}
    moved = sorted(summary.outcomes, key=lambda outcome: -(displacement_in_edges(outcome) or 0.0))
    pictured = {outcome.output for outcome in [o for o in moved if "source" in made.get(o.output, {})][:_PICTURES]}
    recipe = summary.template.recipe
    text = render(
        "batch.html",
        scripts=("table.js",),
        title=f"{summary.planned:,} scans: {recipe.title}",
        subtitle=f"The recipe {recipe.name}, to {folder}, from {summary.started} to {summary.finished}.",
        verdict=_verdict(summary),
        headers=("scan", "state", *(head for head, _ in _COLUMNS)),
        rows=[
            _row(folder, o, *told[o.output], made.get(o.output, {}), has_picture=o.output in pictured)
            for o in worst_first(summary.outcomes)
        ],
        warnings=warning_kinds(summary),
        made=f"Made by pymeshfair on {summary.finished}. This page needs no network.",
    )
    return write_text(folder / NAME, text)


def _verdict(summary: Summary) -> Verdict:
    counts = summary.counts
    told = f"{counts['done']:,} of {counts['scans']:,} scans were done in {summary.seconds:,.0f} s."
    lines = [
        f"{counts[name]:,} {words}."
        for name, words in (
            ("failed", "failed"),
            ("broken", "were written although they go beyond a limit"),
            ("left", "were not begun"),
            ("resumed", "had been done before"),
        )
        if counts[name]
    ]
    apart = sum(bool(far) for _, _, far in summary.rows)
    lines += [f"{apart:,} {'lies' if apart == 1 else 'lie'} far from the others."] if apart else []
    bad = counts["failed"] or counts["broken"]
    return Verdict("bad" if bad else "warn" if apart or counts["left"] else "good", told, tuple(lines))


def warning_kinds(summary: Summary) -> list[dict[str, Any]]:
    """The warnings of all scans by their kind, the most frequent first: a text, how many scans have it, and some of their names.

    Warnings are of one kind if they differ in numbers alone.
    """
    kinds: dict[str, dict[str, None]] = {}
    texts: dict[str, str] = {}
    for outcome, label, _ in summary.rows:
        for text in outcome.warnings:
            kind = re.sub(r"[-+]?\d[\d.,e+-]*", "#", text)
            texts.setdefault(kind, text)
            kinds.setdefault(kind, {})[label] = None
    ordered = sorted(kinds, key=lambda kind: (-len(kinds[kind]), kind))
    return [{"text": texts[kind], "count": len(kinds[kind]), "names": list(kinds[kind])[:_EXAMPLES]} for kind in ordered]


def _row(
    folder: Path, outcome: Outcome, label: str, far: Sequence[str], made: Mapping[str, Any], *, has_picture: bool
) -> dict[str, Any]:
    before, after = outcome.before or {}, outcome.after or {}
    numbers = (
        displacement_in_edges(outcome),
        largest_in_edges(outcome),
        area_change(outcome),
        before.get("roughness"),
        after.get("roughness"),
        after.get("vertices"),
        outcome.seconds,
    )
    drawn = "source" in made
    page = page_path(folder, Path(outcome.output)).relative_to(folder).as_posix()
    return {
        "name": label,
        "status": outcome.status,
        "picture": made if has_picture else None,
        "page": quote(page) if drawn else None,
        "cells": [_cell(number, bool(asked) and asked in far) for number, (_, asked) in zip(numbers, _COLUMNS, strict=True)],
        "errors": [
            *([outcome.error["message"]] if outcome.error else [breach["message"] for breach in outcome.breaches]),
            *([outcome.former] if outcome.former else []),
            *([f"no page: {made['problem']}"] if "problem" in made else []),
        ],
        "warnings": outcome.warnings,
    }


def _cell(number: float | None, far: bool) -> dict[str, Any]:
    if number is None or not math.isfinite(number):
        return {"text": "-", "value": "", "far": far}
    return {"text": f"{number:,}" if isinstance(number, int) else f"{number:.3g}", "value": repr(number), "far": far}
