"""How near the setting that held-out vertices choose comes to the best of all that are tried, found with the truth at hand.

    python benchmarks/denoising_choice.py [--half looked_at|unseen|clean] [--scans FOLDER] [--only text,text] [--seeds N]
                                          [--ablations] [--without rule,rule] [--faces N] [--processes N]

Prints, for every noisy mesh of `denoising_pairs`, the mean angle to the true normals of the best setting, and over it those of
nothing, of the best number of Taubin's steps, and of the choice, in the mean and at worst; and the mean displacement of the
vertices in mean edges.
--seeds repeats the choice with other vertices held out.
--without switches rules of the method off, see `rules`. --ablations adds columns: the choice by all rules (full), and without
each of them. --faces meshes the shapes anew with about so many faces, so that a row takes a minute or two.
Seconds are of the processor, of one choice.
"clean" denoises meshes without noise and prints how far they are moved.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from denoising_holdouts import SAMPLES, taken
from denoising_metrics import Floats, NoisyPair, measured
from denoising_pairs import Maker, coarser, looked_at, made, smoothed_scans, unseen

from pymeshfair.filters.denoising import (
    Scan,
    Setting,
    SettingsTried,
    automatic,
    automatic_choice,
    candidates,
    denoise_automatically,
    impulses,
    replace_outlying,
)
from pymeshfair.filters.denoising.scan import NONE_HELD
from pymeshfair.filters.evidence import cross_validation, tuned
from pymeshfair.filters.evidence.held_out import without
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import one_rings

#: of a pair; "worst" is of the choice, over the seeds
COLUMNS = ("nothing", "Taubin", "choice", "worst", "moved", "best's")
#: fewer outliers than this share of the vertices change no mean angle
FEW = 0.01


def of_settings(pair: NoisyPair) -> dict[Setting, tuple[float, float]]:
    """The mean angle in degrees and the mean displacement in mean edges that each setting leaves, with outliers and without.

    Outliers are those that stand out; the choice then finds them anew, and may be better than all of these.
    """
    found: dict[Setting, tuple[float, float]] = {}
    calmed, outlying = replace_outlying(pair.noisy, pair.faces)
    scans = [Scan(pair.noisy, pair.faces), Scan(calmed, pair.faces, replaced=outlying)]
    for scan in scans if outlying.mean() > FEW else scans[:1]:
        tried = SettingsTried(scan, border="along", alone=scan.replaced is not None)
        for family, results in zip(tried.labels, tried(scan.points, NONE_HELD), strict=True):
            found |= {s: measured(result, pair.truth, pair.faces) for s, result in zip(family, results, strict=True)}
    return found


def rules() -> dict[str, list[tuple[Any, str, Any]]]:
    """For every rule of the method what is put in place of what, where, so that it is off."""
    return {
        "full": [],
        "clip": [(tuned, "CLIP", np.inf)],
        "quadrics": [(cross_validation, "put_where_expected", lambda p, f, _, held: without(p, one_rings(f, len(p)), held))],
        "flipped": [(tuned, "FLIPPED", 1.0)],
        "masks": [(tuned, "MASKS", 1)],
        "direction": [(candidates, "direction_for", lambda _: "all")],
        "all directions": [(candidates, "direction_for", lambda _: "normal")],
        "impulses": [(tuned, "IMPULSIVE", 1.0)],
        "uneven": [(automatic, "sizes_beside", lambda *_: (0.0, 0.0))],
        "flattening": [(impulses, "flattening", lambda _points, _moved, _faces, which: which)],
        "put back": [(impulses, "put_back_along", lambda vertices, *_: vertices)],
        "found again": [(impulses, "_LOOKS", 0)],
        "no noise": [(Scan, "clean", property(lambda scan: scan.noise.level < tuned.NO_NOISE))],
        "or nothing": [(Scan, "or_nothing", lambda _, choice: choice)],
        "designed": [(automatic, "is_designed", lambda *_: False)],
        "shared": [(automatic, "setting_of_shared", lambda *_, **__: None)],
        "rounding": [(automatic, "rounding_of", lambda *_: None)],
    }


@contextmanager
def left_out(names: Iterable[str]) -> Iterator[None]:
    """The method without some rules."""
    known, before = rules(), []
    for name in names:
        if name not in known:
            raise SystemExit(f"--without {name}: no such rule; there are {', '.join(known)}")
        for owner, key, other in known[name]:
            before.append((owner, key, vars(owner)[key]))
            setattr(owner, key, other)
    try:
        yield
    finally:
        for owner, key, value in reversed(before):
            setattr(owner, key, value)


def of_choice(pair: NoisyPair, found: dict[Setting, tuple[float, float]], seed: int) -> tuple[float, float]:
    """What the choice leaves."""
    setting = automatic_choice(pair.noisy, pair.faces, seed=seed).setting
    if setting in found and setting.outliers == "keep":
        return found[setting]
    return measured(setting.apply(pair.noisy, pair.faces), pair.truth, pair.faces)


class Row(NamedTuple):
    """A pair: the best angle, and over it those of the others, means over the seeds; see `COLUMNS`."""

    name: str
    faces: int
    best: float
    values: Floats
    seconds: float


def compared(rules_out: str, seeds: int, ablated: Sequence[str], pair: NoisyPair) -> Row:
    """The choice on a pair with as many sets of held-out vertices, without some rules, and without each of others."""
    with left_out(filter(None, rules_out.split(","))):
        found = of_settings(pair)
        best, its = min(found.values())
        taubin = min(angle for s, (angle, _) in found.items() if s.parameters is None and s.outliers == "keep")
        rows, seconds = [], 0.0
        for seed in range(seeds):
            start = time.process_time()
            angle, moved = of_choice(pair, found, seed)
            seconds += (time.process_time() - start) / seeds
            rows.append([found[Setting()][0] / best, taubin / best, angle / best, moved, its])
            for rule in ablated:
                with left_out([rule]):
                    rows[-1].append(of_choice(pair, found, seed)[0] / best)
    after = COLUMNS.index("worst")
    values = np.insert(np.nanmean(rows, axis=0), after, np.max(rows, axis=0)[after - 1])
    return Row(pair.name, len(pair.faces), best, values, seconds)


def contest(half: str, options: argparse.Namespace) -> None:
    """Print a row for every pair, and the means."""
    shapes = {"looked_at": looked_at, "unseen": unseen}[half](options.scans)
    if options.faces:
        shapes = tuple(shape._replace(make=partial(coarser, shape.make, options.faces)) for shape in shapes)
    pairs = made(shapes, [text for text in options.only.split(",") if text])
    ablated = list(rules()) if options.ablations else []
    print("mesh                faces   best " + " ".join(f"{name:>8}" for name in (*COLUMNS, *ablated)) + "     s")
    every = []
    with ProcessPoolExecutor(options.processes, mp_context=get_context("spawn")) as pool:
        for row in pool.map(partial(compared, options.without, options.seeds, ablated), pairs):
            every.append(row.values)
            shown = " ".join(f"{value:8.3f}" for value in row.values)
            print(f"{row.name:18} {row.faces:6} {row.best:6.2f} {shown} {row.seconds:5.1f}", flush=True)
    if not every:
        raise SystemExit("no mesh has such a name")
    for name, values in (("mean", np.mean(every, axis=0)), ("worst", np.max(every, axis=0))):
        print(f"{name:32} " + " ".join(f"{value:8.3f}" for value in values))


def clean_meshes(scans: Path | None) -> None:
    """Print how far meshes without noise are moved: samples, the shapes of both halves, and scans smoothed."""
    print("mesh                        faces  moved, mean edges")
    samples = [(path.stem, path) for path in sorted(SAMPLES.rglob("*")) if path.suffix in (".obj", ".ply")]
    meshes: list[tuple[str, Maker]] = [(f"sample {name}", partial(taken, path)) for name, path in samples]
    meshes += [(shape.name, shape.make) for shape in (*looked_at(scans), *unseen(scans))]
    meshes += smoothed_scans(scans)
    for name, make in meshes:
        vertices, faces = make()
        result, choice = denoise_automatically(vertices, faces)
        moved = np.linalg.norm(result - vertices, axis=1).mean() / mean_edge_length(vertices, faces)
        print(f"{name:26} {len(faces):6} {moved:7.4f} {choice.kind}", flush=True)


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--half", choices=("looked_at", "unseen", "clean"), default="looked_at")
    parser.add_argument("--scans", type=Path, help="a folder with angel.obj, rabbit.obj and iron.ply")
    parser.add_argument("--only", default="", help="parts of names, with commas; all by default")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--without", default="", help="rules of the method, with commas")
    parser.add_argument("--faces", type=int, default=0, help="mesh the shapes anew with about so many faces")
    parser.add_argument("--ablations", action="store_true", help="more columns: the choice without each rule")
    parser.add_argument("--processes", type=int, default=1, help="so many pairs at once")
    options = parser.parse_args()
    if options.half != "clean":
        contest(options.half, options)
        return 0
    with left_out(filter(None, options.without.split(","))):
        clean_meshes(options.scans)
    return 0


if __name__ == "__main__":
    sys.exit(main())
