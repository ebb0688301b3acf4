"""Compares denoisers on noisy meshes whose truth is known.

    python benchmarks/denoising.py FOLDER [--pairs a,b] [--methods text,text] [--tuned] [-o OUT] [--gallery]

FOLDER holds NAME_noisy and NAME_truth files of any format, with the same vertices and faces in the same order. Without --tuned
each method runs once, with its default settings; with it, the settings with the least MAD are searched per mesh against the
truth, as papers do, and named. Beside the measures are what others reach on the pairs that papers use. OUT gets denoising.md and
denoising.json, and with --gallery a picture a mesh. Needs the `bench` extra; methods whose package is missing are skipped.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import mean

import numpy as np
from denoising_findings import chest
from denoising_methods import METHODS, Method, Settings
from denoising_metrics import Errors, Floats, NoisyPair, errors, used_alone
from denoising_pairs import read_mesh

from pymeshfair.looking.picture import Appearance

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
from panels import Panel, draw_panels, save_picture

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


@dataclasses.dataclass(frozen=True)
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


def as_markdown(results: Sequence[Result], *, tuned: bool) -> str:
    """A table a measure, methods down and pairs across; the ratios to the published values; the settings that were found."""
    parts = [f"# Denoising, {'settings searched per mesh against the truth' if tuned else 'default settings'}", ""]
    for title, (measure, digits) in MEASURES.items():
        parts += [*table(title, {(r.method, r.pair): measure(r) for r in results}, digits), ""]
    values = {(r.method, r.pair): r.errors.mad / best_published(r.pair)[0] for r in results if best_published(r.pair)[1]}
    if values:
        known = {pair: best_published(pair) for _, pair in values}
        parts += table("MAD over the best published value", values, 2)
        parts += ["", *(f"* {pair}: {value:.2f}, {name}" for pair, (value, name) in known.items()), ""]
    found = [f"* {r.pair}, {r.method} (of {r.trials}): {r.settings}" for r in results if r.settings]
    return "\n".join([*parts, *(["## Settings found", "", *found, ""] if found else [])])


def best_published(pair: str) -> tuple[float, str]:
    """The least MAD of a paper's method, or of MeshLab's tuned Taubin filter where there is none, and whose it is."""
    values = [(of[pair], name) for name, of in PAPERS.items() if pair in of]
    return min(values) if values else (TAUBIN[pair], "MeshLab Taubin") if pair in TAUBIN else (np.nan, "")


def table(title: str, values: dict[tuple[str, str], float], digits: int) -> list[str]:
    """One measure by method and pair, with its mean and the worst over the pairs."""
    methods, pairs = (list(dict.fromkeys(names)) for names in zip(*values, strict=True))
    lines = [f"## {title}", "", f"| | {' | '.join(pairs)} | mean | worst |", "|---|" + "---:|" * (len(pairs) + 2)]
    for method in methods:
        row = [values[method, pair] for pair in pairs]
        lines.append(f"| {method} | " + " | ".join(f"{value:.{digits}f}" for value in (*row, mean(row), max(row))) + " |")
    return lines


def read_pairs(folder: Path, names: Sequence[str]) -> Iterator[NoisyPair]:
    """The pairs of a folder in the order of their names; those with one of the given names, if any are given.

    Without the vertices that no face uses: some denoisers cannot have them.
    """
    found = {path.stem.removesuffix("_noisy"): path for path in sorted(folder.iterdir()) if path.stem.endswith("_noisy")}
    missing = [name for name in names if name not in found]
    if missing or not found:
        raise SystemExit(f"{folder}: no {', '.join(missing) or 'NAME'}_noisy file; there are {', '.join(found) or 'none'}")
    for name in names or found:
        truths = list(folder.glob(f"{name}_truth.*"))
        if not truths:
            raise SystemExit(f"{folder}: no {name}_truth file")
        noisy, faces = read_mesh(found[name])
        truth, true_faces = read_mesh(truths[0])
        if not np.array_equal(faces, true_faces):
            raise SystemExit(f"{name}: the faces of the noisy mesh are not those of the truth, number by number")
        yield NoisyPair(name, *used_alone(faces, noisy, truth))


def measure(method: Method, pair: NoisyPair, *, tuned: bool) -> tuple[Result, Floats]:
    """The best of the method's settings on the pair, and the mesh that it gave."""
    trials = (method.settings, *(method.trials if tuned or method.tuned_always else ()))

    def tried(settings: Settings) -> tuple[Result, Floats]:
        start = time.perf_counter()
        vertices = method.run(pair.noisy, pair.faces, **settings)
        seconds = time.perf_counter() - start
        found = settings if len(trials) > 1 else {}
        return Result(pair.name, method.name, errors(vertices, pair.truth, pair.faces), seconds, found, len(trials)), vertices

    return min(map(tried, trials), key=lambda found: found[0].errors.mad)


def warm_up(method: Method) -> str:
    """Compile what the method compiles, so that the first mesh's time is not that of the compiler; a word if it cannot run."""
    shape = chest(6)
    try:
        method.run(shape.noisy, shape.faces, **method.settings)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def paint_pair(path: Path, pair: NoisyPair, meshes: Sequence[tuple[Result, Floats]]) -> None:
    """The noisy mesh, what each method made of it, and the truth."""
    shown = [("noisy", pair.noisy), *((f"{r.method}, MAD {r.errors.mad:.2f}", v) for r, v in meshes), ("truth", pair.truth)]
    panels = [Panel(title, vertices, pair.faces) for title, vertices in shown]
    save_picture(path, draw_panels(panels, Appearance(azimuth=-33.0, elevation=25.0, up="z", width=260, height=260)))


def main() -> int:
    """Run, print and save."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--pairs", default="", help="names, with commas; all of the folder by default")
    parser.add_argument("--methods", default="", help="parts of names, with commas; all by default")
    parser.add_argument("--tuned", action="store_true", help="search the settings per mesh against the truth")
    parser.add_argument("--gallery", action="store_true", help="draw every result, next to the tables")
    parser.add_argument("-o", "--output", type=Path, help="the folder for the tables and pictures")
    options = parser.parse_args()
    wanted = [part.lower() for part in options.methods.split(",") if part]
    methods = []
    for method in METHODS:
        if method.only_tuned and not options.tuned:
            continue
        if not wanted or any(part in method.name.lower() for part in wanted):
            problem = warm_up(method)
            print(f"skipped {method.name}: {problem}", file=sys.stderr) if problem else methods.append(method)
    results: list[Result] = []
    for pair in read_pairs(options.folder, [name for name in options.pairs.split(",") if name]):
        results.append(Result(pair.name, "noisy", errors(pair.noisy, pair.truth, pair.faces), 0.0, {}, 0))
        painted = []
        for method in methods:
            result, vertices = measure(method, pair, tuned=options.tuned)
            print(f"{pair.name:16} {method.name:34} MAD {result.errors.mad:6.2f} {result.seconds:6.2f} s", flush=True)
            results.append(result)
            painted.append((result, vertices))
        if options.output and options.gallery:
            paint_pair(options.output / f"{pair.name}.png", pair, painted)
    table = as_markdown(results, tuned=options.tuned)
    print(table)
    if options.output:
        options.output.mkdir(parents=True, exist_ok=True)
        (options.output / "denoising.md").write_text(table, encoding="utf-8")
        document = json.dumps([dataclasses.asdict(result) for result in results], indent=1)
        (options.output / "denoising.json").write_text(document, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
