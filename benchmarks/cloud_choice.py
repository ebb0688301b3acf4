"""How near the setting of the bilateral projection that held-out points choose comes to the best, found with the truth at hand.

    python benchmarks/cloud_choice.py [--half looked_at|unseen] [--scans FOLDER] [--only text,text] [--seeds N]

Prints, for every noisy cloud of `cloud_pairs`, the root mean square distance to the true surface of the best of 169 settings with
the degree 1, in spacings; over it those of nothing, of the defaults, of CGAL's jet smoothing with 24 neighbours and with the best
of seven numbers of neighbours once to three times, and of the choice, for each seed of held-out points; what was chosen, and the
seconds of the processor that choosing took. Where the best is to do nothing all distances are in spacings.
"""

from __future__ import annotations

import argparse
import time
from itertools import islice
from pathlib import Path

import numpy as np
from cloud_pairs import LOOKED_AT, UNSEEN, CloudPair, Floats, clouds

from pymeshfair.filters.choosing import Projection, chosen_projection
from pymeshfair.filters.denoising import CloudKernels, bilateral_projection, estimated_range_sigma, projections

NEIGHBORS, SHARES, ITERATIONS = (6, 8, 12, 18, 27, 40, 60), (0.5, 1.0, 2.0, 4.0), 6
#: below it, in spacings, nothing is the best
EXACT = 1e-3


def errors_of_settings(pair: CloudPair) -> dict[tuple[int, float, int], float]:
    """The error that every setting leaves, by neighbours, share of the estimated range sigma and iterations; nothing first."""
    found = {(0, 0.0, 0): pair.error(pair.points)}
    points = pair.points / pair.spacing
    for k in NEIGHBORS:
        estimated = estimated_range_sigma(points, None, k, "gaussian")
        for share in SHARES:
            kernels = CloudKernels(range_sigma=share * estimated or None)
            for done, result in enumerate(islice(projections(points, None, k, kernels), ITERATIONS), start=1):
                found[k, share, done] = pair.error(result * pair.spacing)
    return found


def errors_of_jets(pair: CloudPair) -> dict[tuple[int, int], float]:
    """The error that CGAL's jet smoothing leaves, by neighbours and iterations; none if CGAL is not installed."""
    try:
        from CGAL.CGAL_Kernel import Point_3
        from CGAL.CGAL_Point_set_3 import Point_set_3
        from CGAL.CGAL_Point_set_processing_3 import jet_smooth_point_set
    except ImportError:
        return {}
    found = {}
    for k in sorted({*NEIGHBORS[1:], 24}):
        points = Point_set_3()
        for place in pair.points.tolist():
            points.insert(Point_3(*place))
        for done in range(1, 4):
            jet_smooth_point_set(points, k)
            found[k, done] = pair.error(np.array([[p.x(), p.y(), p.z()] for p in points.points()]))
    return found


def chosen_result(pair: CloudPair, seed: int) -> tuple[Projection, Floats, float]:
    """The choice, what it makes of the cloud, and the seconds that choosing took."""
    start = time.process_time()
    found = chosen_projection(pair.points, seed=seed)
    seconds = time.process_time() - start
    if found is None or not found.chosen.label.iterations:
        return Projection(), pair.points, seconds
    return found.chosen.label, bilateral_projection(pair.points, **found.chosen.label._asdict()), seconds


def main() -> None:
    """Print a line for every cloud, and the means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--half", choices=("looked_at", "unseen"), default="unseen")
    parser.add_argument("--scans", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--seeds", type=int, default=1)
    options = parser.parse_args()
    ratios: list[list[float]] = []
    print("cloud          best  nothing  default   jet 24 jet best   choice  neighbours x iterations, range sigma, degree      s")
    for pair in clouds(LOOKED_AT if options.half == "looked_at" else UNSEEN, scans=options.scans):
        if not any(text in pair.name for text in options.only.split(",")):
            continue
        errors = errors_of_settings(pair)
        best = min(errors.values())
        unit = best if best > EXACT else 1.0
        jets = errors_of_jets(pair)
        theirs = (jets.get((24, 1), np.nan), min(jets.values(), default=np.nan))
        for seed in range(options.seeds):
            setting, result, seconds = chosen_result(pair, seed)
            row = [errors[0, 0.0, 0] / unit, errors[18, 1.0, 2] / unit, *(e / unit for e in theirs), pair.error(result) / unit]
            if unit == best:
                ratios.append(row)
            told = f"{setting.neighbors} x {setting.iterations}, {setting.range_sigma / pair.spacing:.2f}, {setting.degree}"
            print(
                f"{pair.name:<12}{best:7.3f}" + "".join(f"{value:9.2f}" for value in row) + f"  {told:<40}{seconds:9.1f}",
                flush=True,
            )
    if ratios:
        for name, row in (("mean", np.mean(ratios, axis=0)), ("worst", np.max(ratios, axis=0))):
            print(f"{name:<19}" + "".join(f"{value:9.2f}" for value in row))


if __name__ == "__main__":
    main()
