"""``batch.html``, one page with a row a scan, failures first; and the page of each scan, made in a process of its own."""

import math
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ..files.errors import InputError
from ..files.provenance import read_provenance
from ..files.writing import StagedFile, check_target, clear_up, place, staging_folder
from ..processes.process import Pool
from ..processes.worker import Order
from ..report.comparison_page import Verdict
from ..report.page import render
from .outcomes import (
    QUESTIONS,
    Outcome,
    Row,
    Summary,
    area_change,
    digests_of,
    displacement_in_edges,
    largest_in_edges,
    write_text,
)

#: the folder of pages, in that of the batch
PAGES = "reports"
#: what every page has
_BRAND = b'<p class="brand">pymeshfair</p>'


def page_path(folder: Path, output: Path) -> Path:
    """The path of the page of a scan: ``reports/scan.ply.html`` in the folder of the batch, for its output ``scan.ply``."""
    place = output.relative_to(folder)
    return folder / PAGES / place.with_name(f"{place.name}.html")


def draw(input: Path, output: Path, page: Path, *, memory: int | None, overwrite: bool, workers: Pool) -> None:
    """Write the page of a scan that was done. Nothing is drawn if a page with the digests of its files is there."""
    record = read_provenance(output)
    if record is None:
        raise InputError(output, "no provenance says what it was made from")
    page.parent.mkdir(parents=True, exist_ok=True)
    former = page.read_bytes() if page.is_file() else b""
    if former and all(digest.encode() in former for digest in digests_of(record).values()):
        return
    check_target(page, ("html",), overwrite=overwrite or _BRAND in former)
    with staging_folder(page) as stage:
        made = stage / "new" / page.name
        order = Order.of(_draw, input, output, made, memory_limit=memory, if_lost=partial(clear_up, stage, page))
        with workers.lend() as worker:
            answer = worker.do(order)
        if answer.error is not None:
            raise answer.error
        place([StagedFile(made, page)], stage)


def _draw(input: Path, output: Path, page: Path) -> None:
    from ..report.comparison_page import run_page
    from ..running.read import read_mesh

    meshes = [read_mesh(path, allow_outside=True, unchecked=True) for path in (input, output)]
    record = read_provenance(output)
    assert record is not None
    page.write_bytes(run_page(record, *meshes))


NAME = "batch.html"
#: so many scans are named with each kind of warning
_EXAMPLES = 5
#: of each column of numbers the head, in which of `QUESTIONS` it tells outliers, and its number of a scan
_COLUMNS: tuple[tuple[str, str, Callable[[Outcome], float | None]], ...] = (
    ("moved (edges)", "displacement", displacement_in_edges),
    ("at most", "", largest_in_edges),
    ("area %", "area", area_change),
    ("roughness before", "noise", QUESTIONS["noise"]),
    ("after", "", lambda outcome: (outcome.after or {}).get("roughness")),
    ("vertices", "", lambda outcome: (outcome.after or {}).get("vertices")),
    ("seconds", "", lambda outcome: outcome.seconds),
)


def write_page(folder: Path, summary: Summary, pages: Mapping[str, str]) -> Path:
    """Write the page; `pages` has of outputs why there is no page of them, empty if there is one."""
    recipe = summary.template.recipe
    text = render(
        "batch.html",
        scripts=("table.js",),
        title=f"{summary.planned:,} scans: {recipe.title}",
        subtitle=f"The recipe {recipe.name}, to {folder}, from {summary.started} to {summary.finished}.",
        verdict=_verdict(summary),
        headers=("scan", "state", *(head for head, _, _ in _COLUMNS)),
        rows=[_row(folder, row, pages.get(row[0].output)) for row in summary.worst_first],
        warnings=warning_kinds(summary),
        made=f"Made by pymeshfair on {summary.finished}. This page needs no network.",
    )
    return write_text(folder / NAME, text)


def _verdict(summary: Summary) -> Verdict:
    counts = summary.counts
    words = {
        "failed": "failed",
        "broken": "were written although they go beyond a limit",
        "left": "were not begun",
        "resumed": "had been done before",
    }
    lines = [f"{counts[name]:,} {text}." for name, text in words.items() if counts[name]]
    apart = sum(bool(far) for _, _, far in summary.rows)
    lines += [f"{apart:,} {'lies' if apart == 1 else 'lie'} far from the others."] if apart else []
    bad = counts["failed"] or counts["broken"]
    text = f"{counts['done']:,} of {counts['scans']:,} scans were done in {summary.seconds:,.0f} s."
    return Verdict("bad" if bad else "warn" if apart or counts["left"] else "good", text, tuple(lines))


def warning_kinds(summary: Summary) -> list[dict[str, Any]]:
    """The warnings of all scans by their kind, the most frequent first: a text, how many scans have it, and some of their names.

    Warnings are of one kind if they differ in numbers alone.
    """
    kinds: dict[str, list[tuple[str, str]]] = {}
    for outcome, label, _ in summary.rows:
        for text in outcome.warnings:
            kinds.setdefault(re.sub(r"[-+]?\d[\d.,e+-]*", "#", text), []).append((text, label))
    found = []
    for kind in sorted(kinds):
        names = list(dict.fromkeys(label for _, label in kinds[kind]))
        found.append({"text": kinds[kind][0][0], "count": len(names), "names": names[:_EXAMPLES]})
    return sorted(found, key=lambda one: -one["count"])


def _row(folder: Path, row: Row, problem: str | None) -> dict[str, Any]:
    outcome, label, far = row
    page = page_path(folder, Path(outcome.output)).relative_to(folder).as_posix()
    return {
        "name": label,
        "status": outcome.status,
        "page": quote(page) if problem == "" else None,
        "cells": [_cell(number_of(outcome), asked in far) for _, asked, number_of in _COLUMNS],
        "errors": [
            *([outcome.error["message"]] if outcome.error else [breach["message"] for breach in outcome.breaches]),
            *([outcome.former] if outcome.former else []),
            *([f"no page: {problem}"] if problem else []),
        ],
        "warnings": outcome.warnings,
    }


def _cell(number: float | None, far: bool) -> dict[str, Any]:
    if number is None or not math.isfinite(number):
        return {"text": "-", "value": "", "far": far}
    return {"text": f"{number:,}" if isinstance(number, int) else f"{number:.3g}", "value": repr(number), "far": far}
