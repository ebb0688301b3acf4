"""Correlated noise, which neighbours share: rounded coordinates, depth cameras with filters of their own, maps fused from these.

Held-out vertices say nothing of it: what predicts them predicts their noise too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..evidence import Choice, Scores, measured, tuned
from ..execution import Progress, ignore_progress
from ..geometry import edge_lengths, mean_edge_length, roughness, seen_from_one_side
from ..libraries import optimize, sparse
from ..mesh import Floats, Ints, NormalisedMesh
from ..topology import BorderPolicy, edges
from .candidates import CORRELATED, Setting, SettingsTried
from .noise_level import AVERAGED, CLIP, FourthOrder, NoiseEstimate, ring_means
from .rounding import Rounding, rounding_of
from .scan import NONE_HELD, Scan

# Widths and scales of a `noise_field`, to tell that noise is shared, and to know its covariance: maps share it over one width.
_TELL, _KNOW = ((0, 2), (1, 4)), [((0, width), (1, 2, 4)) for width in (2, 3, 4)]
# Fused maps share noise over five edges and more; on faces seen aslant, the calmest, they have less of it.
_KNOW_FUSED = [((0, 1, 4, 16, 64), (1, 2, 4, 8, 16, 32), 1.0 / 3.0)]
# Residuals of vertices three edges from the border are whole enough; patches are wide enough for forty rounds.
_WIDE: dict[str, Any] = {"patches": (8, 2500), "rings": 3}


def setting_of_rounded(
    mesh: NormalisedMesh, rounding: Rounding, other: Setting, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> Choice[Setting] | None:
    """The setting for rounded coordinates, and what speaks for it; None if the `other`, which leaves them rounded, is better.

    The `rounding` is undone first, see `Rounding.undone`. Of the settings that is taken whose product of roughness and of how far
    vertices are out of their steps is the least [reginska1996]. The other is better where details are as fine as the steps.
    Vertices that may not move are no evidence.
    """
    undone = rounding.undone(mesh.points, mesh.cells, mesh.movable)
    scan, origin = Scan.sampled(undone, mesh.cells, mesh.movable, **_WIDE)
    tried = SettingsTried(scan, border=border, of=CORRELATED, rounding="undo")
    here, rounded = undone[origin], mesh.points[origin]
    unit = mean_edge_length(here, scan.faces)

    def measures(result: Floats) -> tuple[float, float]:
        """How far vertices are out of their steps, and the product."""
        left = rounding.left(result, rounded, scan.normals)[scan.scored]
        out = float(np.sqrt((left**2).mean())) if len(left) else 0.0
        return out, roughness(result, scan.faces) * (out + tuned.OUT_OF_STEP)

    results = tried(scan.points, NONE_HELD)
    found = measured(results, tried.labels, lambda _, result: measures(here + unit * (result - scan.points)), progress)
    out, products = np.array(found).T
    best = int(products.argmin())
    if measures(other.apply(rounded, scan.faces, border=border, movable=scan.movable))[1] <= products[best]:
        return None
    return Scores(out * rounding.step / unit, products - products[best], np.zeros(len(out)), best).choice(tried.labels)


def setting_of_shared(
    mesh: NormalisedMesh, noise: NoiseEstimate, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> Choice[Setting] | None:
    """The setting for noise that neighbours share, and what speaks for it; None if they do not, or nothing is known of it.

    The covariance of the noise is measured where the mesh is calm, for `Scan.choose_by_risk`. The noise is that of
    `estimate_noise`; vertices that may not move are no evidence.
    """
    shared, on_lines = _shared(mesh.points, mesh.cells, noise)
    if shared == 0.0:
        return None
    scan, _ = Scan.sampled(mesh.points, mesh.cells, mesh.movable, **_WIDE, progress=progress)
    tried = SettingsTried(scan, border=border, of=CORRELATED)
    fields = [noise_field(scan, *parts) for parts in (_KNOW if on_lines else _KNOW_FUSED)]
    field = min(fields, key=lambda field: field.misfit).heights
    # Many rounds move what is beside the border, which has to count.
    found = replace(scan, rings=1).choose_by_risk(tried, tried.labels, field)
    return found if found is None or on_lines else scan.few_flipped(tried, tried.labels, found)


def shared_noise(points: Floats, faces: Ints, noise: NoiseEstimate) -> float:
    """The standard deviation of noise that neighbours share, along the normals or the axis of rounding; 0 if they do not.

    The mesh has (n, 3) points, a mean edge of 1, (m, 3) triangles, and the noise of `estimate_noise`.
    """
    rounding = rounding_of(points, faces)
    if rounding is not None:
        return rounding.step / float(np.sqrt(12.0))
    return _shared(points, faces, noise)[0]


def on_lines_of_sight(points: Floats, faces: Ints) -> bool:
    """Whether the vertices are pixels, evenly spaced but along the view: differences of fourth order are along it alone."""
    fourth = FourthOrder.of(faces, len(points))
    residuals = fourth.differences(points)[fourth.inner]
    squares = np.linalg.eigvalsh(residuals.T @ residuals)
    return bool(squares[-1] > tuned.ON_LINES * squares.sum())


def _shared(points: Floats, faces: Ints, noise: NoiseEstimate) -> tuple[float, bool]:
    """The deviation of the noise if neighbours share it; and whether it is along lines of sight, rather than of a fused map."""
    if noise.level == 0.0 or seen_from_one_side(points, faces) <= tuned.FACING:
        return 0.0, False
    on_lines, lengths = on_lines_of_sight(points, faces), edge_lengths(points, edges(faces))
    # A level set cuts off corners.
    if not on_lines and np.mean(lengths < 0.25 * lengths.mean()) <= tuned.CUT_OFF:
        return 0.0, False
    scan, _ = Scan.sampled(points, faces, rings=3)
    if not on_lines and scan.is_surface:
        return 0.0, False
    variances = noise_field(scan, *_TELL).variances
    own, total = float(variances[0]), float(variances.sum())
    shared = np.sqrt(own) >= max(tuned.OWN, 0.5 * noise.level) and own < 0.5 * total
    return (float(np.sqrt(total)) if shared else 0.0), on_lines


class NoiseField(NamedTuple):
    """A sum of noises that was fitted to a surface."""

    variances: Floats  # (k,) of the parts, in squared units of the points; 0 if no vertex counts
    heights: Floats  # (n,) one such noise along the normals, the same for the mesh moved, turned or renumbered
    misfit: float = 0.0  # the norm of the relative errors of what differences leave


def noise_field(scan: Scan, widths: Sequence[int], scales: Sequence[int], calmest: float = tuned.CALMEST) -> NoiseField:
    """Fit a sum of noises to what differences of several widths leave of a surface.

    With W the mean over the one-ring and twice the weight of its neighbours, (I + 2 U) / 3, the residuals of scale m are those of
    (I - W^m)^2. Their squares, averaged over some rings, have a least part where the surface is calm, the share `calmest` of the
    vertices. Every part of the noise, smoothed over as many steps as its width says, 0 first, and made with a variance of 1 on
    the same mesh, has such numbers of its own; the variances are the non-negative sum of these that is nearest to what was seen,
    relatively.
    """
    points, scored = scan.points, scan.scored
    nothing = NoiseField(np.zeros(len(widths)), np.zeros(len(points)))
    if not scored.any():
        return nothing
    means = ring_means(edges(scan.faces), len(points), 2.0 / 3.0) + sparse.identity(len(points), format="csr") / 3.0

    def smoothed(values: Floats, times: int) -> Floats:
        for _ in range(times):
            values = means @ values
        return values

    def residuals(values: Floats, scale: int) -> Floats:
        first = values - smoothed(values, scale)
        return first - smoothed(first, scale)

    def calm(heights: Floats) -> float:
        """The mean square that this share of the vertices stays below."""
        clipped = np.where(scored, np.minimum(heights**2, CLIP * np.median(heights[scored] ** 2)), 0.0)
        sums, weights = (smoothed(values, AVERAGED)[scored] for values in (clipped, scored.astype(np.float64)))
        return float(np.quantile(sums / weights, calmest))

    seen = np.array([calm(np.einsum("ij,ij->i", residuals(points, scale), scan.normals)) for scale in scales])
    if seen.min() <= 0.0:
        return nothing
    # Random numbers are made of the distances from the middle.
    distances = np.linalg.norm(points - points[scored].mean(axis=0), axis=1)
    parts = [smoothed((distances * (997.0 + 137.7 * width)) % 1.0 - 0.5, width) for width in widths]
    parts = [part / (float(np.sqrt((part[scored] ** 2).mean())) or 1.0) for part in parts]
    made = np.array([[calm(residuals(part, scale)) for part in parts] for scale in scales])
    variances, misfit = optimize.nnls(made / seen[:, None], np.ones(len(scales)))
    heights = np.sum([np.sqrt(variance) * part for variance, part in zip(variances, parts, strict=True)], axis=0)
    return NoiseField(variances, heights, misfit)
