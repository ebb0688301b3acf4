"""The tables of the denoising benchmark, next to the published values."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import mean

from denoising_metrics import Errors
from denoising_published import MAD, SOURCES, best_published
from denoising_trials import Settings


@dataclass(frozen=True)
class Measure:
    """A column of numbers: its title, where a result has it, and how many digits are worth printing."""

    title: str
    of: Callable[[Result], float]
    digits: int


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
    settings: Settings
    trials: int

    def line(self) -> str:
        """The result in one line."""
        e = self.errors
        return (
            f"{self.pair:16} {self.method:34} MAD {e.mad:6.2f}  by area {e.mad_by_area:6.2f}  RMS {e.rms:6.2f}  "
            f"flips {e.flips:5}  distance {e.distance:.3f}  displacement {e.displacement:.3f}  {self.seconds:6.2f} s"
        )


MAD_MEASURE = Measure("MAD, degrees", lambda r: r.errors.mad, 2)
MEASURES = (
    MAD_MEASURE,
    Measure("MAD by area, degrees", lambda r: r.errors.mad_by_area, 2),
    Measure("RMS, degrees", lambda r: r.errors.rms, 2),
    Measure("flips", lambda r: r.errors.flips, 0),
    Measure("distance, edges", lambda r: r.errors.distance, 3),
    Measure("displacement, edges", lambda r: r.errors.displacement, 3),
    Measure("seconds", lambda r: r.seconds, 2),
)


def as_markdown(results: Sequence[Result], *, tuned: bool) -> str:
    """A table a measure, methods down and pairs across; the ratios to the published values; the settings that were found."""
    pairs, methods = (list(dict.fromkeys(values)) for values in zip(*((r.pair, r.method) for r in results), strict=True))
    parts = [f"# Denoising, {'settings searched per mesh against the truth' if tuned else 'default settings'}\n"]
    for measure in MEASURES:
        parts += [f"## {measure.title}\n", table(results, pairs, methods, measure)]
        if measure is MAD_MEASURE:
            parts += [published(pairs), ratios(results, pairs, methods)]
    found = [f"* {r.pair}, {r.method} (of {r.trials}): {r.settings}" for r in results if r.settings]
    return "\n".join([*parts, *(["## Settings found\n", *found, ""] if found else [])])


def table(results: Sequence[Result], pairs: Sequence[str], methods: Sequence[str], measure: Measure) -> str:
    """One measure, with its mean over the pairs."""
    values = {(r.method, r.pair): measure.of(r) for r in results}
    lines = _head(pairs, "mean")
    for method in methods:
        row = [values.get((method, pair)) for pair in pairs]
        known = [value for value in row if value is not None]
        lines.append(_row(method, [*row, mean(known) if known else None], measure.digits))
    return "\n".join([*lines, ""])


def published(pairs: Sequence[str]) -> str:
    """The MAD that others report, where they do."""
    if not any(pair in MAD for pair in pairs):
        return "No values are published for these pairs.\n"
    lines = ["Published and reference values, tuned per mesh unless said:\n", *_head(pairs)]
    for name in SOURCES:
        row = [MAD.get(pair, {}).get(name) for pair in pairs]
        if any(row):
            lines.append(_row(name, row))
    return "\n".join([*lines, "", *(f"* {name}: {source}." for name, source in SOURCES.items()), ""])


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
