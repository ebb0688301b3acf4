"""Writes ``batch.html``, which has a row for each scan, failures first; and a page for each cleaned scan, in a worker process."""

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
from ..places import without_folders
from ..processes.process import Pool
from ..processes.worker import Order
from ..report.comparison_page import Verdict
from ..report.page import render
from .outcomes import NUMBERS, Outcome, Row, Summary, area_change, digests_of, displacement_in_edges, write_text

PAGES = "reports"  # the folder of the pages of scans, within the folder of the batch
_BRAND = b'<p class="brand">pymeshfair</p>'  # a text that every page of a batch or a run has


def page_path(folder: Path, output: Path) -> Path:
    """Returns the path of the page of a scan: ``reports/scan.ply.html`` for ``scan.ply``."""
    relative = output.relative_to(folder)
    return folder / PAGES / relative.with_name(f"{relative.name}.html")


def draw(input: Path, output: Path, page: Path, *, memory: int | None, overwrite: bool, workers: Pool) -> None:
    """Writes the page of a cleaned scan, unless a page of the same run exists."""
    record = read_provenance(output)
    if record is None:
        raise InputError(output, "it has no provenance, so that its input is unknown")
    page.parent.mkdir(parents=True, exist_ok=True)
    former = page.read_bytes() if page.is_file() else b""
    if former and all(mark.encode() in former for mark in (*digests_of(record).values(), record["run"]["started"])):
        return
    check_target(page, ("html",), overwrite=overwrite or _BRAND in former)
    with staging_folder(page) as stage:
        new_page = stage / "new" / page.name
        order = Order.of(_draw, input, output, new_page, memory_limit=memory, if_lost=partial(clear_up, stage, page))
        with workers.lend() as worker:
            answer = worker.do(order)
        if answer.error is not None:
            raise answer.error
        place([StagedFile(new_page, page)], stage)


def _draw(input: Path, output: Path, page: Path) -> None:
    from ..report.comparison_page import run_page
    from ..running.read import read_mesh

    meshes = [read_mesh(path, allow_outside=True, unchecked=True) for path in (input, output)]
    record = read_provenance(output)
    assert record is not None
    page.write_bytes(run_page(record, *meshes))


NAME = "batch.html"
_EXAMPLES = 5  # the largest number of scans that are named for each kind of warning
#: the columns of numbers: the heading, the entry of `NUMBERS` whose outliers are marked, and the function that gives a number
_COLUMNS: tuple[tuple[str, str, Callable[[Outcome], float | None]], ...] = (
    ("moved (edges)", "displacement", displacement_in_edges),
    ("at most", "", lambda outcome: displacement_in_edges(outcome, "largest")),
    ("area %", "area", area_change),
    ("roughness before", "noise", NUMBERS["noise"]),
    ("after", "", lambda outcome: (outcome.after or {}).get("roughness")),
    ("vertices", "", lambda outcome: (outcome.after or {}).get("vertices")),
    ("seconds", "", lambda outcome: outcome.seconds),
)


def write_page(folder: Path, summary: Summary, pages: Mapping[str, str]) -> Path:
    """Writes ``batch.html``; `pages` has, for each output, the reason why it has no page, or "" if it has one."""
    recipe = summary.template.recipe
    text = render(
        "batch.html",
        scripts=("table.js",),
        title=f"{summary.planned:,} scans: {recipe.title}",
        subtitle=f"The recipe {recipe.name}; this batch ran from {summary.started} to {summary.finished}.",
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
        "broken": "were written although they break a limit",
        "resumed": "were cleaned by an earlier batch",
        "failed": "failed",
        "left": "were not started",
    }
    lines = [f"{counts[name]:,} {text}." for name, text in words.items() if counts[name]]
    outlying = sum(bool(far) for _, _, far in summary.rows)
    lines += [f"Scans with numbers far from those of the others: {outlying:,}."] if outlying else []
    bad = counts["failed"] or counts["broken"]
    text = f"{counts['done']:,} of {counts['scans']:,} scans were done."
    return Verdict("bad" if bad else "warn" if outlying or counts["left"] else "good", text, tuple(lines))


def warning_kinds(summary: Summary) -> list[dict[str, Any]]:
    """Returns for each kind of warning a text, the number of scans, and up to `_EXAMPLES` of their names; most frequent first.

    Warnings that differ only in numbers are of one kind.
    """
    occurrences: dict[str, list[tuple[str, str]]] = {}
    for outcome, label, _ in summary.rows:
        for text in without_folders(outcome.warnings, (Path(outcome.output).parent, Path(outcome.input).parent)):
            occurrences.setdefault(re.sub(r"[-+]?\d[\d.,e+-]*", "#", text), []).append((text, label))
    kinds = [(found[0][0], list(dict.fromkeys(label for _, label in found))) for _, found in sorted(occurrences.items())]
    entries = [{"text": text, "count": len(names), "names": names[:_EXAMPLES]} for text, names in kinds]
    return sorted(entries, key=lambda entry: -entry["count"])


def _row(folder: Path, row: Row, problem: str | None) -> dict[str, Any]:
    outcome, label, far = row
    errors = [outcome.error["message"]] if outcome.error else [breach["message"] for breach in outcome.breaches]
    errors += filter(None, (outcome.former, f"no page: {problem}" if problem else ""))
    return {
        "name": label,
        "status": outcome.status,
        "page": quote(page_path(folder, Path(outcome.output)).relative_to(folder).as_posix()) if problem == "" else None,
        "cells": [_cell(number_of(outcome), name in far) for _, name, number_of in _COLUMNS],
        **without_folders({"errors": errors, "warnings": outcome.warnings}, (folder, Path(outcome.input).parent)),
    }


def _cell(number: float | None, is_far: bool) -> dict[str, Any]:
    if number is None or not math.isfinite(number):
        return {"text": "-", "value": "", "far": is_far}
    return {"text": f"{number:,}" if isinstance(number, int) else f"{number:.3g}", "value": repr(number), "far": is_far}
