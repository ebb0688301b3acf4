"""Compares denoisers on noisy meshes whose truth is known.

    python benchmarks/denoising.py FOLDER [--pairs a,b] [--methods text,text] [--tuned] [-o OUT] [--gallery]

FOLDER holds NAME_noisy and NAME_truth files of any format, with the same vertices and faces in the same order. Without --tuned
each method runs once, with its default settings; with it, the settings with the least MAD are searched per mesh against the
truth, as papers do, and named. OUT gets denoising.md and denoising.json, and with --gallery a picture a mesh. Needs the `bench`
extra; methods whose package is missing are skipped.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from denoising_findings import chest
from denoising_holdouts import read_mesh
from denoising_methods import METHODS, Method
from denoising_metrics import Floats, NoisyPair, errors, used_alone
from denoising_table import Result, as_json, as_markdown
from denoising_trials import Settings

from pymeshfair.looking.panels import Panel, draw_panels, save_picture
from pymeshfair.looking.picture import Appearance


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
    if not method.is_there:
        return f"{method.needs} is not installed"
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
        (options.output / "denoising.json").write_text(as_json(results), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
