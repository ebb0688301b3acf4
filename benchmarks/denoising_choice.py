"""How near the setting that held-out vertices choose comes to the best of all that are tried, found with the truth at hand.

    python benchmarks/denoising_choice.py [looked_at|unseen|clean|borders|sizes] [--scans FOLDER] [--only text,text] [--seeds N]
                                          [--ablations] [--without rule,rule] [--faces N] [--processes N]

looked_at, unseen: for every noisy mesh of that half of `denoising_pairs` the mean angle to the true normals of the best setting,
and over it those of nothing, of the best number of Taubin's steps, and of the choice, in the mean and at worst; and the mean
displacement of the vertices in mean edges. Pairs with a `rough_truth` are marked, and have means of their own. --seeds repeats
the choice with other vertices held out. --ablations adds columns: the choice by all rules (full), and without each of them.
--faces meshes the shapes anew with about so many faces, so that a row takes a minute or two. Seconds are of the processor, of
one choice.
clean: how far meshes without noise are moved.
borders: of noisy shapes cut open, the mean angles at faces with a vertex on the border, at those next to them, and at all others;
and how far border vertices are from their true places, in mean edges.
sizes: seconds and memory of meshes of 10,000 to 1,000,000 faces. Ends with 1 if that is more than asked, where seconds count if
both the clock and the processor passed them: on a busy machine the clock alone says too much.
--without switches rules of the method off, see `rules`.
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
from typing import Any

import numpy as np
from denoising_findings import chest
from denoising_metrics import Floats, Ints, NoisyPair, angles_to_truth, measured, used_alone
from denoising_pairs import SAMPLES, Maker, Shape, blobs, coarser, lens, looked_at, made, part, taken, terrain, torus, unseen
from diffusion import make_mesh, seconds
from peers.machine import peak, start_of_peak

from pymeshfair.filters.denoising import Scan, Setting, SettingsTried, automatic, candidates, impulses, replace_outlying, scan
from pymeshfair.filters.denoising.automatic import automatic_choice, denoise_automatically
from pymeshfair.filters.denoising.scan import NONE_HELD
from pymeshfair.filters.evidence import cross_validation, tuned
from pymeshfair.filters.evidence.held_out import put_at_means
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.topology import border_vertices, one_rings

#: of a pair; "worst" is of the choice, over the seeds
COLUMNS = ("nothing", "Taubin", "choice", "worst", "moved", "best's")
#: the worst that is asked of a pair
ASKED = 1.15
#: fewer outliers than this share of the vertices change no mean angle
FEW = 0.01
#: faces, and the seconds and megabytes that are asked for
SIZES, MEGABYTES = {10_000: 4.0, 100_000: 10.0, 1_000_000: 25.0}, 800.0


def of_settings(pair: NoisyPair) -> dict[Setting, tuple[float, float]]:
    """The mean angle in degrees and the mean displacement in mean edges that each setting leaves, with outliers and without.

    Outliers are those that stand out; the choice then finds them anew, and may be better than all of these.
    """
    found: dict[Setting, tuple[float, float]] = {}
    calmed, outlying = replace_outlying(pair.noisy, pair.faces)
    scans = [Scan(pair.noisy, pair.faces), Scan(calmed, pair.faces, replaced=outlying)]
    for one in scans if outlying.mean() > FEW else scans[:1]:
        tried = SettingsTried(one, border="along", alone=one.replaced is not None)
        for family, results in zip(tried.labels, tried(one.points, NONE_HELD), strict=True):
            found |= {s: measured(result, pair.truth, pair.faces) for s, result in zip(family, results, strict=True)}
    return found


def rough_truth(pair: NoisyPair) -> bool:
    """Whether the truth has so much noise of its own that a choice which takes all noise may miss what is asked.

    If t is what `Scan.surface_noise` says of the truth, where that is not clean, and s the noise that was added, the estimate of
    least error leaves t s / sqrt(t^2 + s^2), and one that takes all noise errs by t: sqrt(1 + t^2 / s^2) times as much.
    """
    truth, vertex = Scan.sampled(pair.truth, pair.faces)
    noise = (pair.noisy - pair.truth)[vertex] / mean_edge_length(pair.truth, pair.faces)
    heights = np.einsum("ij,ij->i", noise, truth.normals)
    added, own = np.median(np.abs(heights)) / tuned.MEDIAN_OF_NORMAL, 0.0 if truth.clean else truth.surface_noise
    return bool(np.hypot(added, own) > ASKED * added)


def rules() -> dict[str, list[tuple[Any, str, Any]]]:
    """For every rule of the method what is put in place of what, where, so that it is off."""
    return {
        "full": [],
        "clip": [(tuned, "CLIP", 1e9)],
        "quadrics": [(cross_validation, "put_where_expected", lambda p, f, _, held: put_at_means(p, one_rings(f, len(p)), held))],
        "flipped": [(tuned, "FLIPPED", 0.0)],
        "sets": [(tuned, "SETS", 1)],
        "direction": [(candidates, "direction_for", lambda _: "all")],
        "all directions": [(candidates, "direction_for", lambda _: "normal")],
        "impulses": [(tuned, "IMPULSIVE", 1.0)],
        "uneven": [(scan, "sizes_beside", lambda *_: (0.0, 0.0))],
        "flattening": [(impulses, "flattening", lambda _points, _moved, _faces, which: which)],
        "put back": [(impulses, "put_back_along", lambda vertices, *_: vertices)],
        "found again": [(impulses, "_SEARCHES", 0)],
        "no noise": [(Scan, "clean", property(lambda of: of.noise.level < tuned.NO_NOISE))],
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


def compared(rules_out: str, seeds: int, ablated: Sequence[str], pair: NoisyPair) -> tuple[Floats, str, bool]:
    """The choice on a pair with as many sets of held-out vertices, without some rules, and without each of others.

    Returns:
        The angles over the best, means over the seeds, see `COLUMNS`; the line that is printed; and whether `rough_truth`.
    """
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
    shown = " ".join(f"{value:8.3f}" for value in values)
    rough = rough_truth(pair)
    return values, f"{pair.name:18} {len(pair.faces):6} {best:6.2f} {shown} {seconds:5.1f}{' rough truth' * rough}", rough


def contest(only: Sequence[str], options: argparse.Namespace) -> None:
    """Print a row for every pair, and the means."""
    shapes = {"looked_at": looked_at, "unseen": unseen}[options.what](options.scans)
    if options.faces:
        shapes = tuple(shape._replace(make=partial(coarser, shape.make, options.faces)) for shape in shapes)
    pairs = made(shapes, only)
    ablated = list(rules()) if options.ablations else []
    print("mesh                faces   best " + " ".join(f"{name:>8}" for name in (*COLUMNS, *ablated)) + "     s")
    every: tuple[list[Floats], list[Floats]] = [], []
    with ProcessPoolExecutor(options.processes, mp_context=get_context("spawn")) as pool:
        for values, line, rough in pool.map(partial(compared, options.without, options.seeds, ablated), pairs):
            every[rough].append(values)
            print(line, flush=True)
    if not any(every):
        raise SystemExit("no mesh has such a name")
    for rows, kind in zip(every, ("", ", rough truth"), strict=True):
        for name, values in (("mean", np.mean(rows, axis=0)), ("worst", np.max(rows, axis=0))) if rows else ():
            print(f"{name + kind:32} " + " ".join(f"{value:8.3f}" for value in values))


def clean_meshes(scans: Path | None) -> None:
    """Print how far meshes without noise are moved: samples, and the shapes of both halves."""
    print("mesh                        faces  moved, mean edges")
    samples = [(path.stem, path) for path in sorted(SAMPLES.rglob("*")) if path.suffix in (".obj", ".ply")]
    meshes: list[tuple[str, Maker]] = [(f"sample {name}", partial(taken, path)) for name, path in samples]
    meshes += [(shape.name, shape.make) for shape in (*looked_at(scans), *unseen(scans))]
    for name, make in meshes:
        vertices, faces = make()
        result, choice = denoise_automatically(vertices, faces)
        moved = np.linalg.norm(result - vertices, axis=1).mean() / mean_edge_length(vertices, faces)
        print(f"{name:26} {len(faces):6} {moved:7.4f} {choice.kind}", flush=True)


def cut(make: Maker, normal: tuple[float, float, float], share: float) -> tuple[Floats, Ints]:
    """The faces of a shape on one side of a plane, which is so large a share of the size from the middle."""
    vertices, faces = make()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    heights = (vertices[faces].mean(axis=1) - (low + high) / 2.0) @ (np.array(normal) / np.linalg.norm(normal))
    points, faces = used_alone(faces[heights < share * (high - low).max()], vertices)
    return points, faces


#: shapes cut open by planes of these normals, so far from the middle
CUTS: dict[str, tuple[Maker, tuple[float, float, float], float]] = {
    "terrain": (terrain, (0.0, 0.0, 1.0), 1.0),
    "lens": (lens, (0.3, 1.0, 0.2), 0.15),
    "bunny": (partial(taken, SAMPLES / "bunny10k_textured.obj"), (1.0, 0.2, 0.1), 0.12),
    "cow": (partial(taken, SAMPLES / "cow.obj", edge=1.0), (0.1, 0.2, 1.0), 0.0),
    "bracket": (partial(part, True), (1.0, 0.3, 0.2), 0.2),
    "torus": (torus, (1.0, 0.3, 0.5), 0.2),
    "blobs": (blobs, (0.2, 1.0, 0.3), 0.1),
}


def borders(only: Sequence[str]) -> None:
    """Print the errors at the border, next to it and inside, and the displacement of border vertices."""
    print("mesh           border   next inside  displacement")
    for pair in made([Shape(name, "n1 n3 a2 i8", partial(cut, *values)) for name, values in CUTS.items()], only):
        faces, on_border = pair.faces, border_vertices(pair.faces, len(pair.truth))
        at_border = on_border[faces].any(axis=1)
        near = np.isin(faces, faces[at_border]).any(axis=1)
        result, _ = denoise_automatically(pair.noisy, faces)
        parts = (faces[which] for which in (at_border, near & ~at_border, ~near))
        angles = [angles_to_truth(result, pair.truth, of)[0].mean() for of in parts]
        moved = np.linalg.norm((result - pair.truth)[on_border], axis=1).mean() / mean_edge_length(pair.truth, faces)
        print(f"{pair.name:12} {angles[0]:8.2f} {angles[1]:6.2f} {angles[2]:6.2f}  {moved:12.3f}", flush=True)


def cost(vertices: Floats, faces: Ints) -> tuple[float, float, float]:
    """Seconds by the clock and of the processor of one `denoise` that compiles nothing, and the peak of the process in MB."""
    small = chest(8)
    denoise_automatically(small.noisy, small.faces)
    start_of_peak()
    return *seconds(lambda: denoise_automatically(vertices, faces)), peak()


def sizes() -> int:
    """Print the cost of each size, in a process of its own; 1 if it is more than asked."""
    passed = False
    for count, most in SIZES.items():
        with get_context("spawn").Pool(1) as pool:
            clock, processor, memory = pool.apply(cost, make_mesh(count // 2, "loop"))
        passed |= min(clock, processor) > most or memory > MEGABYTES
        told = f"{clock:6.1f} s, {processor:6.1f} s of the processor, {memory:5.0f} MB"
        print(f"{count:9,} faces: {told}; asked {most:.0f} s, {MEGABYTES:.0f} MB", flush=True)
    return int(passed)


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="?", choices=("looked_at", "unseen", "clean", "borders", "sizes"), default="looked_at")
    parser.add_argument("--scans", type=Path, help="a folder with angel.obj, rabbit.obj and iron.ply")
    parser.add_argument("--only", default="", help="parts of names, with commas; all by default")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--without", default="", help="rules of the method, with commas")
    parser.add_argument("--faces", type=int, default=0, help="mesh the shapes anew with about so many faces")
    parser.add_argument("--ablations", action="store_true", help="more columns: the choice without each rule")
    parser.add_argument("--processes", type=int, default=1, help="so many pairs at once")
    options = parser.parse_args()
    only = [text for text in options.only.split(",") if text]
    if options.what == "sizes":
        return sizes()
    if options.what in ("looked_at", "unseen"):
        contest(only, options)
        return 0
    with left_out(filter(None, options.without.split(","))):
        borders(only) if options.what == "borders" else clean_meshes(options.scans)
    return 0


if __name__ == "__main__":
    sys.exit(main())
