"""How long curves of a million vertices take, and how exact long implicit steps on them are: ``python benchmarks/curves.py``."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from pymeshfair.filters.curves import curve_smoothing

CASES: tuple[dict[str, Any], ...] = (
    {"method": "explicit", "weights": "uniform", "iterations": 10},
    {"method": "explicit", "weights": "inverse_length", "iterations": 10},
    {"method": "taubin", "weights": "uniform", "iterations": 10},
    {"method": "implicit", "weights": "uniform", "time_step": 1e6, "iterations": 1},
    {"method": "implicit", "weights": "inverse_length", "detail_size": 0.01, "iterations": 1},
    {"method": "implicit", "weights": "inverse_length", "detail_size": 0.01, "iterations": 10},
)


def main() -> None:
    """Print the best of three of each case, along the curve and in no order, and the errors against the Fourier transform."""
    n = 1_000_000
    angles, at = 2 * np.pi * np.arange(n) / n, np.arange(n)
    random = np.random.default_rng(0)
    points = np.column_stack([np.cos(angles), np.sin(angles), 0.1 * np.sin(3 * angles)]) + random.normal(scale=1e-5, size=(n, 3))
    edges = np.column_stack([at, np.roll(at, -1)]).astype(np.int32)
    order = random.permutation(n)
    number = np.argsort(order).astype(np.int32)
    for case in CASES:
        seconds = [best_of_three(points, edges, case), best_of_three(points[order], number[edges], case)]
        print(f"{seconds[0]:6.2f} s, in no order {seconds[1]:6.2f} s: {case}")
    k = 2 * np.sin(np.pi * np.arange(n // 2 + 1) / n) ** 2
    for t in (1.0, 1e4, 1e8, 1e12, 1e20):
        smooth = curve_smoothing(points, edges, method="implicit", time_step=t, iterations=1)
        exact = np.fft.irfft(np.fft.rfft(points, axis=0) / (1 + t * k)[:, None], n=n, axis=0)
        print(f"t = {t:8.0e}: largest error {np.abs(smooth - exact).max():.1e} of a curve of diameter 2")


def best_of_three(points: Any, edges: Any, case: dict[str, Any]) -> float:
    """Seconds, after the kernels have been compiled."""
    curve_smoothing(points[:10], np.array([[0, 1]], dtype=np.int32), **case)
    seconds = []
    for _ in range(3):
        started = time.perf_counter()
        curve_smoothing(points, edges, **case)
        seconds.append(time.perf_counter() - started)
    return min(seconds)


if __name__ == "__main__":
    main()
