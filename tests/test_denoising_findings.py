"""What is said about kernels and normals, on small shapes of our own; docs/denoising.md has the whole tables."""

from __future__ import annotations

import functools

import pytest
from denoising_findings import Shape, best, bumpy_ball, chest

from pymeshfair.filters.robust import KernelName


@functools.cache
def box() -> Shape:
    """1,728 faces, a third of them at edges."""
    return chest(12)


@functools.cache
def at_features(kernel: KernelName, *, by_vertices: bool = False) -> float:
    """The error at edges with the kernel's best scale, degrees."""
    return box().mad_at_features(best(box(), kernel, by_vertices=by_vertices)[0])


@functools.cache
def on_ball(kernel: KernelName) -> float:
    """The error on the smooth shape with the kernel's best scale, degrees."""
    return bumpy_ball(4).mad(best(bumpy_ball(4), kernel)[0])


@pytest.mark.parametrize(
    ("better", "worse"),
    [("l1", "l2"), *(pytest.param(name, "huber", marks=pytest.mark.slow) for name in ("truncated_l1", "truncated_l2", "tukey"))],
)
def test_kernels_that_keep_edges(better: KernelName, worse: KernelName) -> None:
    """L1 leaves less than half of L2's error at features, and kernels that are cut off of that of Huber's, which never is."""
    assert at_features(better) < at_features(worse) / 2


@pytest.mark.slow
@pytest.mark.parametrize("kernel", ["huber", "lorentzian", "gaussian"])
@pytest.mark.parametrize("sharp", ["truncated_l2", "tukey"])
def test_soft_kernels_suit_smooth_shapes(kernel: KernelName, sharp: KernelName) -> None:
    """Huber's, Lorentz's and Gauss's kernels leave less error on the bumpy ball than those that are cut off."""
    assert on_ball(kernel) < on_ball(sharp)


def test_normals_of_faces_beat_those_of_vertices() -> None:
    """At edges the normals of vertices are means across the edge: their error there is more than twice as large."""
    assert at_features("truncated_l1") < at_features("truncated_l1", by_vertices=True) / 2
