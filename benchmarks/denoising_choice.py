"""How near the setting that held-out vertices choose comes to the best of all that are tried, found with the truth at hand.

    python benchmarks/denoising_choice.py [--half looked_at|unseen] [--scans FOLDER] [--only text,text] [--seeds N]
                                          [--without clip,quadric,masks]

Prints, for every noisy mesh of `denoising_pairs`, the mean angle to the true normals of the best setting, and over it those of
nothing, of the best number of Taubin's steps, of the choice, and of two simpler rules with the same evidence: the least error
of held-out vertices alone, and the flattest of those that are as good. --seeds repeats the choice with other vertices held out.
--without leaves a step of the method out: outliers are not clipped, held-out vertices are put at the mean of their neighbours,
or only one set is held out.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from denoising_metrics import Floats, Ints, angles_to_truth
from denoising_pairs import NoisyPair, looked_at, made, unseen

from pymeshfair.filters.denoising import Setting, SettingsTried, direction_for, estimate_noise, held_out_evidence, settings
from pymeshfair.filters.denoising.noise_level import smooth_normals
from pymeshfair.filters.evidence import Trial, choose, judge
from pymeshfair.filters.topology import OneRings

COLUMNS = ("nothing", "Taubin", "choice", "least error", "flattest")


def angles_of_settings(pair: NoisyPair) -> dict[Setting, float]:
    """The mean angle that each setting leaves, in degrees."""
    direction = direction_for(estimate_noise(pair.noisy, pair.faces))
    tried = SettingsTried(pair.faces, smooth_normals(pair.noisy, pair.faces), direction, border="along", movable=None)
    return {
        setting: float(angles_to_truth(result, pair.truth, pair.faces)[0].mean())
        for family, results in zip(settings(direction), tried(pair.noisy), strict=True)
        for setting, result in zip(family, results, strict=True)
    }


def by_rules(pair: NoisyPair, seed: int) -> list[Setting]:
    """What the method chooses, and two simpler rules."""
    direction = direction_for(estimate_noise(pair.noisy, pair.faces))
    evidence = held_out_evidence(pair.noisy, pair.faces, direction=direction, seed=seed)
    if evidence is None:
        return [Setting()] * 3

    def flatness(trial: Trial[Setting]) -> float:
        return np.inf if trial.flatness is None else trial.flatness

    least = min(evidence.trials, key=lambda trial: trial.error)
    return [evidence.chosen.label, least.label, min(evidence.trials, key=flatness).label]


def ring_means(points: Floats, rings: OneRings, normals: Floats, held: Ints) -> Floats:
    """The held-out vertices in the middle of their neighbours."""
    del normals
    result = points.copy()
    for i in held:
        result[i] = points[rings.neighbours[rings.offsets[i] : rings.offsets[i + 1]]].mean(axis=0)
    return result


def leave_out(step: str) -> None:
    """Change the method by one step."""
    rule = sys.modules[choose.__module__]
    if step == "clip":
        vars(sys.modules[judge.__module__])["_CLIP"] = np.inf
    elif step == "quadric":
        vars(rule)["without"] = ring_means
    elif step == "masks":
        vars(rule).update(_MASKS=1, _ENOUGH=0)
    else:
        raise SystemExit(f"--without {step}: it is clip, quadric or masks")


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--half", choices=("looked_at", "unseen"), default="looked_at")
    parser.add_argument("--scans", type=Path, help="a folder with angel.obj, rabbit.obj and iron.ply")
    parser.add_argument("--only", default="", help="parts of names, with commas; all by default")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--without", default="", help="steps of the method, with commas")
    options = parser.parse_args()
    for step in filter(None, options.without.split(",")):
        leave_out(step)
    shapes = {"looked_at": looked_at, "unseen": unseen}[options.half](options.scans)
    rows = []
    print("mesh                faces   best " + " ".join(f"{name:>11}" for name in COLUMNS) + "     s")
    for pair in made(shapes, [text for text in options.only.split(",") if text]):
        angles = angles_of_settings(pair)
        best = min(angles.values())
        taubin = min(angle for setting, angle in angles.items() if setting.parameters is None)
        for seed in range(options.seeds):
            start = time.perf_counter()
            chosen = by_rules(pair, seed)
            row = np.array([angles[Setting()], taubin, *(angles[setting] for setting in chosen)]) / best
            rows.append(row)
            shown = " ".join(f"{value:11.3f}" for value in row)
            seconds = time.perf_counter() - start
            print(f"{pair.name:18} {len(pair.faces):6} {best:6.2f} {shown} {seconds:5.1f}", flush=True)
    if not rows:
        raise SystemExit(f"no mesh has a name with {options.only}")
    for name, values in (("mean", np.mean(rows, axis=0)), ("worst", np.max(rows, axis=0))):
        print(f"{name:32} " + " ".join(f"{value:11.3f}" for value in values))
    return 0


if __name__ == "__main__":
    sys.exit(main())
