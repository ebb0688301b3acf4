"""The settings with which the denoising benchmark runs our normal filtering, and those that it tries on each mesh when tuned."""

from __future__ import annotations

import itertools
from typing import Any, TypeAlias

from pymeshfair.filters.denoising import NormalFilterMethod
from pymeshfair.filters.denoising.face_neighbourhoods import Neighborhood
from pymeshfair.filters.robust import KernelName

Settings: TypeAlias = dict[str, Any]


def combinations(**values: tuple[Any, ...]) -> tuple[Settings, ...]:
    """Every combination of the values."""
    return tuple(dict(zip(values, chosen, strict=True)) for chosen in itertools.product(*values.values()))


#: the widths of the kernels that were found to suit sharp and smooth shapes
SHARP: Settings = {
    "method": "bilateral",
    "range_kernel": "truncated_l1",
    "neighborhood": "two_ring",
    "range_sigma": 1.0,
    "range_floor": 0.0,
    "space_sigma": 2.5,
    "outer_iterations": 20,
    "normal_iterations": 1,
    "vertex_iterations": 10,
}
SMOOTH: Settings = SHARP | {
    "range_kernel": "huber",
    "neighborhood": "vertex",
    "range_sigma": 0.1,
    "space_sigma": 1.5,
    "outer_iterations": 10,
}

#: the settings of two papers
ZHENG: Settings = {"range_sigma": 0.35, "normal_iterations": 20, "vertex_iterations": 10}
ZHENG_TRIALS = combinations(range_sigma=(0.25, 0.35, 0.45), normal_iterations=(10, 20, 40))
GUIDED: Settings = ZHENG | {"method": "guided", "neighborhood": "two_ring"}
GUIDED_TRIALS: tuple[Settings, ...] = (GUIDED | {"range_sigma": 0.25}, GUIDED | {"normal_iterations": 40})


def family(
    method: NormalFilterMethod,
    kernel: KernelName,
    neighborhood: Neighborhood,
    sigmas: tuple[float, ...],
    widths: tuple[float, ...],
    schedules: tuple[tuple[int, int], ...],
    floors: tuple[float, ...] = (0.0,),
) -> tuple[Settings, ...]:
    """All combinations of the scales, floors, widths, and schedules of outer and vertex iterations that suit a filter."""
    fixed: Settings = {"method": method, "range_kernel": kernel, "neighborhood": neighborhood, "normal_iterations": 1}
    return tuple(
        fixed
        | {"range_sigma": sigma, "range_floor": floor, "space_sigma": width, "outer_iterations": outer, "vertex_iterations": fit}
        for sigma, floor, width, (outer, fit) in itertools.product(sigmas, floors, widths, schedules)
    )


#: what has won on some mesh, and its nearest relatives; from sharp to smooth
OUR_TRIALS = (
    # Sharp edges; the more noise, the more rounds. Deviations are measured on averaged normals where the noise is impulsive or
    # turns faces over.
    *family("bilateral", "truncated_l1", "two_ring", (1.0,), (2.5,), ((20, 10), (30, 5), (60, 3)), floors=(0.03, 0.06)),
    *family("averaged", "truncated_l1", "two_ring", (0.25, 0.36), (2.5,), ((20, 10), (30, 10)), floors=(0.03,)),
    *family("averaged", "truncated_l2", "two_ring", (0.15, 0.25), (2.5,), ((20, 10), (40, 10))),
    # The steps of depth cameras, which only wide kernels and many rounds smooth away.
    *family("averaged", "gaussian", "two_ring", (0.25, 0.4), (2.5,), ((40, 20),)),
    # Smooth with a few edges.
    *family("bilateral", "lorentzian", "vertex", (0.12, 0.25), (1.5,), ((10, 4), (20, 2))),
    # Smooth and detailed; the finer the details, the smaller the neighbourhood and the fewer the steps of the vertices.
    *family("averaged", "huber", "two_ring", (0.05,), (1.0, 2.0), ((5, 5), (7, 4)), floors=(0.0, 0.1)),
    *family("averaged", "huber", "vertex", (0.05,), (1.0,), ((7, 4), (10, 3))),
    *family("bilateral", "huber", "vertex", (0.1, 0.2), (1.5,), ((5, 5), (10, 3))),
    *family("bilateral", "huber", "edge", (0.2, 0.6), (2.5,), ((10, 4), (16, 2))),
)
TAUBIN_STEPS = (2, 3, 5, 7, 10, 15, 20, 30, 40, 60, 80, 120)
