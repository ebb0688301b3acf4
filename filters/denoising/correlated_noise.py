"""Correlated noise, which neighbours share: rounded coordinates, depth cameras with filters of their own, maps fused from these.

Held-out vertices say nothing of it: what predicts them predicts their noise too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..evidence import Choice, Scores, measured, tuned
from ..execution import Progress, ignore_progress
from ..geometry import edge_lengths, mean_edge_length, roughness, seen_from_one_side
from ..libraries import optimize, sparse
from ..mesh import Bools, Floats, Ints, NormalisedMesh
from ..topology import BorderPolicy, edges
from .candidates import CORRELATED, STRONG, Setting, SettingsTried
from .noise_level import AVERAGED, CLIP, FourthOrder, NoiseEstimate, ring_means
from .rounding import Rounding, rounding_of
from .scan import NONE_HELD, Scan

# Noise of single vertices, and noise smoothed over so many steps, as seen by differences of so many: to tell that it is shared,
# and to know its covariance.
_TELL = (0, 2), (1, 4)
_KNOW = (0, 1, 2, 4), (1, 2, 4)
# Patches of large meshes, each wide enough for forty rounds.
_WIDE = {"patches": 8, "size": 2500}
# Residuals of vertices so many edges from the border are whole enough.
_RINGS = 3
# Random numbers are the fractions of so many times a length of the geometry, another multiple for every width.
_MULTIPLE, _STEP = 997.0, 137.7


def setting_of_rounded(
    mesh: NormalisedMesh, rounding: Rounding, other: Setting, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> Choice[Setting] | None:
    """The setting for rounded coordinates, and what speaks for it; None if another setting is better.

    The `rounding` of `rounding_of` is undone first, see `Rounding.undone`. Of the settings, and the `other` on the rounded
    surface, that of the least product of roughness and of how far vertices are out of their steps is taken [reginska1996]. The
    other is what is chosen where vertices are taken to have noise of their own; it is better where details are as fine as the
    steps. Vertices that may not move are no evidence.
    """
    undone = rounding.undone(mesh.points, mesh.cells, mesh.movable)
    scan, origin = Scan.sampled(undone, mesh.cells, mesh.movable, **_WIDE, rings=_RINGS)
    tried = SettingsTried(scan, border=border, of=CORRELATED, rounding="undo")
    here, rounded = undone[origin], mesh.points[origin]
    unit = mean_edge_length(here, scan.faces)

    def measures(result: Floats) -> tuple[float, float]:
        """How far vertices are out of their steps, and the product."""
        left = rounding.left(result, rounded)[scan.scored]
        out = float(np.sqrt((left**2).mean())) if len(left) else 0.0
        return out, roughness(result, scan.faces) * (out + tuned.OUT_OF_STEP)

    results = tried(scan.points, NONE_HELD)
    found = measured(results, tried.labels, lambda _, result: measures(here + unit * (result - scan.points)), progress)
    out, products = np.array(found).T
    best = int(products.argmin())
    if measures(other.apply(rounded, scan.faces, border=border, movable=scan.movable))[1] <= products[best]:
        return None
    return Scores(out, products - products[best], np.zeros(len(out)), best).choice(tried.labels)


def setting_of_shared(
    mesh: NormalisedMesh, noise: NoiseEstimate, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> tuple[Setting, Choice[Setting] | None] | None:
    """How to denoise a mesh with noise that neighbours share, and what speaks for it; None if they do not.

    The covariance of the noise is measured where the mesh is calm, and that setting is taken whose slopes are expected to be
    nearest to the truth, see `Scan.choose_by_risk`. Fused maps share it more widely than can be measured beside the surface, and
    get a strong setting. The noise is that of `estimate_noise`; vertices that may not move are no evidence.
    """
    field, on_lines = _field_of_shared(mesh.points, mesh.cells, noise)
    if field is None or not on_lines:
        return None if field is None else (STRONG, None)
    scan, _ = Scan.sampled(mesh.points, mesh.cells, mesh.movable, **_WIDE, rings=_RINGS, progress=progress)
    tried = SettingsTried(scan, border=border, of=CORRELATED)
    found = scan.choose_by_risk(tried, tried.labels, noise_field(scan, *_KNOW).heights)
    return (STRONG, None) if found is None else (found.chosen.label, found)


def shared_noise(points: Floats, faces: Ints, noise: NoiseEstimate) -> float:
    """The standard deviation of noise that neighbours share, along the normals or the axis of rounding; 0 if they do not.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        noise: of `estimate_noise`.
    """
    rounding = rounding_of(points, faces)
    if rounding is not None:
        return float(np.median(np.diff(rounding.levels)) / np.sqrt(12.0))
    field, _ = _field_of_shared(points, faces, noise)
    return 0.0 if field is None else float(np.sqrt(field.variances.sum()))


def on_lines_of_sight(points: Floats, faces: Ints) -> bool:
    """Whether the vertices are pixels: differences of fourth order are along the view alone, the rest being evenly spaced."""
    fourth = FourthOrder.of(faces, len(points))
    residuals = fourth.differences(points)[fourth.inner]
    squares = np.linalg.eigvalsh(residuals.T @ residuals)
    return bool(squares[-1] > tuned.ON_LINES * squares.sum())


def _field_of_shared(points: Floats, faces: Ints, noise: NoiseEstimate) -> tuple[NoiseField | None, bool]:
    """The noise, roughly, if neighbours share it; and whether it is along lines of sight, rather than that of a fused map."""
    if noise.level == 0.0 or seen_from_one_side(points, faces) <= tuned.FACING:
        return None, False
    on_lines, lengths = on_lines_of_sight(points, faces), edge_lengths(points, edges(faces))
    # A level set cuts off corners.
    if not on_lines and np.mean(lengths < 0.25 * lengths.mean()) <= tuned.CUT_OFF:
        return None, False
    scan, _ = Scan.sampled(points, faces, rings=_RINGS)
    if not on_lines and scan.is_surface:
        return None, False
    field = noise_field(scan, *_TELL)
    shared = field.own >= max(tuned.OWN, 0.5 * noise.level) and field.shared > 0.5
    return (field if shared else None), on_lines


class NoiseField(NamedTuple):
    """Noise as a sum of independent parts, the first of the vertices alone, the others smoothed, see `noise_field`."""

    variances: Floats  # (k,) those of the parts, in squared units of the points
    heights: Floats  # (n,) one such noise along the normals

    @property
    def shared(self) -> float:
        """The share of the variance that is not of the vertex alone; 0 without noise."""
        total = float(self.variances.sum())
        return float(self.variances[1:].sum()) / total if total > 0.0 else 0.0

    @property
    def own(self) -> float:
        """The standard deviation of what is of the vertex alone."""
        return float(np.sqrt(self.variances[0]))


def noise_field(scan: Scan, widths: Sequence[int], scales: Sequence[int]) -> NoiseField:
    """Fit a sum of noises to what differences of several widths leave of a surface.

    With W the mean over the one-ring and twice the weight of its neighbours, (I + 2 U) / 3, the residuals of scale m are those of
    (I - W^m)^2. Their squares, averaged over some rings, have a least part where the surface is calm. Every part of the noise,
    made with a variance of 1 on the same mesh, has such numbers of its own; the variances are the non-negative sum of these that
    is nearest to what was seen, relatively.

    Args:
        scan: the surface.
        widths: the steps over which parts of the noise are smoothed, 0 first; k have a standard deviation of 2/3 sqrt(k) edges.
        scales: the scales of the residuals.

    Returns:
        The noise; nothing if no vertex counts. The same for the mesh moved, turned or renumbered.
    """
    points, scored = scan.points, scan.scored
    nothing = NoiseField(np.zeros(len(widths)), np.zeros(len(points)))
    if not scored.any():
        return nothing
    pairs = edges(scan.faces)
    alone = np.bincount(pairs.ravel(), minlength=len(points)) == 0
    means = ring_means(pairs, len(points), 2.0 / 3.0) + sparse.diags(np.where(alone, 1.0, 1.0 / 3.0), format="csr")
    along = [np.einsum("ij,ij->i", _residuals(points, means, scale), scan.normals) for scale in scales]
    seen = np.array([_calm(residuals, means, scored) for residuals in along])
    if seen.min() <= 0.0:
        return nothing
    parts = [_unit_noise(points, means, scored, width) for width in widths]
    made = np.array([[_calm(_residuals(part, means, scale), means, scored) for part in parts] for scale in scales])
    variances, _ = optimize.nnls(made / seen[:, None], np.ones(len(scales)))
    heights = np.sum([np.sqrt(variance) * part for variance, part in zip(variances, parts, strict=True)], axis=0)
    return NoiseField(variances, heights)


def _smoothed(values: Floats, means: sparse.csr_matrix, times: int) -> Floats:
    for _ in range(times):
        values = means @ values
    return values


def _residuals(values: Floats, means: sparse.csr_matrix, scale: int) -> Floats:
    for _ in range(2):
        values = values - _smoothed(values, means, scale)
    return values


def _calm(residuals: Floats, means: sparse.csr_matrix, scored: Bools) -> float:
    """The mean square that a twentieth of the vertices stays below: there the surface hardly adds to residuals."""
    squares = residuals**2
    clipped = np.where(scored, np.minimum(squares, CLIP * np.median(squares[scored])), 0.0)
    sums, weights = (_smoothed(values, means, AVERAGED)[scored] for values in (clipped, scored.astype(np.float64)))
    return float(np.quantile(sums / weights, tuned.CALMEST))


def _unit_noise(points: Floats, means: sparse.csr_matrix, scored: Bools, width: int) -> Floats:
    """(n,) random numbers, smoothed, with a variance of 1; they are made of the distances from the middle of the mesh."""
    distances = np.linalg.norm(points - points[scored].mean(axis=0), axis=1)
    noise = _smoothed((distances * (_MULTIPLE + _STEP * width)) % 1.0 - 0.5, means, width)
    deviation = float(np.sqrt((noise[scored] ** 2).mean()))
    return np.asarray(noise / deviation if deviation > 0.0 else noise)
