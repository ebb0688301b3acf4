"""The tables of the denoising benchmark, next to what others reach on the pairs that papers use."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import mean
from typing import Any

from denoising_metrics import Errors

#: the MAD in degrees that papers' methods reach: the first four tuned per mesh against the truth, by the C++ code of Zhang et al.
#: 2015 and an open one; NLLR (Li et al. 2018), GCN-Denoiser (Shen et al. 2022) and MeshTGV (Liu et al. 2021) by their authors'
#: meshes
PAPERS = {
    "Sun 2007": {"fandisk_n3": 3.62, "block_n4": 5.78, "sharpsphere_n3": 7.05, "twelve_i5": 6.72},
    "Zheng 2011": {"fandisk_n3": 3.38, "block_n4": 5.48, "sharpsphere_n3": 6.59, "twelve_i5": 6.92},
    "Zhang 2015": {"fandisk_n3": 2.56, "block_n4": 3.65, "sharpsphere_n3": 7.70, "twelve_i5": 3.25},
    "He & Schaefer 2013": {"fandisk_n3": 2.71},
    "NLLR": {"julius_n2": 6.10, "child_n3": 6.70},
    "GCN-Denoiser": {"fertility_n3": 4.01},
    "MeshTGV": {"kinect_cone": 7.23},
}
#: that of MeshLab's Taubin filter with the number of steps tuned, where no paper has a value
TAUBIN = {"fandisk_n7": 12.13, "bunny_n2": 5.80, "nicolo_n2": 6.15}


@dataclass(frozen=True)
class Result:
    """What one method made of one pair.

    Attributes:
        pair: the pair's name.
        method: the method's name.
        errors: how near to the truth it is.
        seconds: wall time of the run that counts.
        settings: those found by search; empty where nothing was searched.
        trials: how many settings were tried.
    """

    pair: str
    method: str
    errors: Errors
    seconds: float
    settings: dict[str, Any]
    trials: int


#: columns of numbers: the title, where a result has it, and how many digits are worth printing
MEASURES: dict[str, tuple[Callable[[Result], float], int]] = {
    "MAD, degrees": (lambda r: r.errors.mad, 2),
    "MAD by area, degrees": (lambda r: r.errors.mad_by_area, 2),
    "RMS, degrees": (lambda r: r.errors.rms, 2),
    "flips": (lambda r: r.errors.flips, 0),
    "distance, edges": (lambda r: r.errors.distance, 3),
    "displacement, edges": (lambda r: r.errors.displacement, 3),
    "seconds": (lambda r: r.seconds, 2),
}


def best_published(pair: str) -> tuple[float, str] | None:
    """The least MAD of a paper's method, or of MeshLab's tuned Taubin filter where there is none, and whose it is."""
    values = [(of[pair], name) for name, of in PAPERS.items() if pair in of]
    return min(values) if values else (TAUBIN[pair], "MeshLab Taubin") if pair in TAUBIN else None


def as_markdown(results: Sequence[Result], *, tuned: bool) -> str:
    """A table a measure, methods down and pairs across; the ratios to the published values; the settings that were found."""
    pairs, methods = (list(dict.fromkeys(values)) for values in zip(*((r.pair, r.method) for r in results), strict=True))
    parts = [f"# Denoising, {'settings searched per mesh against the truth' if tuned else 'default settings'}\n"]
    for title in MEASURES:
        parts += [f"## {title}\n", table(results, pairs, methods, title)]
        if title == "MAD, degrees":
            parts.append(ratios(results, pairs, methods))
    found = [f"* {r.pair}, {r.method} (of {r.trials}): {r.settings}" for r in results if r.settings]
    return "\n".join([*parts, *(["## Settings found\n", *found, ""] if found else [])])


def table(results: Sequence[Result], pairs: Sequence[str], methods: Sequence[str], title: str) -> str:
    """One measure, with its mean over the pairs."""
    measure, digits = MEASURES[title]
    values = {(r.method, r.pair): measure(r) for r in results}
    lines = _head(pairs, "mean")
    for method in methods:
        row = [values.get((method, pair)) for pair in pairs]
        known = [value for value in row if value is not None]
        lines.append(_row(method, [*row, mean(known) if known else None], digits))
    return "\n".join([*lines, ""])


def ratios(results: Sequence[Result], pairs: Sequence[str], methods: Sequence[str]) -> str:
    """MAD over the best published value, with mean and worst; where no paper has one, over MeshLab's tuned Taubin filter."""
    best = {pair: found for pair in pairs if (found := best_published(pair))}
    if not best:
        return ""
    values = {(r.method, r.pair): r.errors.mad for r in results}
    lines = ["## MAD over the best published value\n", *_head(best, "mean", "worst")]
    for method in methods:
        row = [values[method, pair] / best[pair][0] for pair in best if (method, pair) in values]
        if len(row) == len(best):
            lines.append(_row(method, [*row, mean(row), max(row)]))
    lines.append("| *best published* | " + " | ".join(f"{value:.2f} {name}" for value, name in best.values()) + " | | |")
    return "\n".join([*lines, ""])


def as_json(results: Sequence[Result]) -> str:
    """All results."""
    return json.dumps([dataclasses.asdict(result) for result in results], indent=1, default=str) + "\n"


def _head(columns: Iterable[str], *more: str) -> list[str]:
    names = ["", *columns, *more]
    return ["| " + " | ".join(names) + " |", "|---|" + "---:|" * (len(names) - 1)]


def _row(name: str, values: Sequence[float | None], digits: int = 2) -> str:
    return f"| {name} | " + " | ".join("" if value is None else f"{value:.{digits}f}" for value in values) + " |"
