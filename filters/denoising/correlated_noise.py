"""Correlated noise, which neighbours share: rounded coordinates, depth cameras with filters of their own, maps fused from these.

Held-out vertices say nothing of it: what predicts them predicts their noise too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..evidence import (
    Choice,
    Sample,
    Scores,
    choose_by_risk,
    far_from_border,
    roughness,
    run_to_last,
    sample_of,
    starts_of,
    trials_of,
    tuned,
)
from ..execution import Progress, ignore_progress
from ..geometry import edge_lengths, mean_edge_length, seen_from_one_side
from ..libraries import optimize, sparse
from ..mesh import Bools, Floats, Ints, NormalisedMesh
from ..topology import BorderPolicy, edges
from .candidates import SettingsTried
from .noise_level import Agreement, NoiseEstimate, differences_of_fourth_order, estimate_noise, inner_vertices, smooth_normals
from .relaxation import direction_for
from .repertoire import CORRELATED, STRONG, Setting, settings
from .rounding import Rounding, RoundingPolicy, rounding_of

# Noise of single vertices, and noise smoothed over so many steps, as seen by differences of so many: to tell that it is shared,
# and to know its covariance.
_TELL = (0, 2), (1, 4)
_WIDTHS, _SCALES = (0, 1, 2, 4), (1, 2, 4)
# Patches of large meshes, each wide enough for forty rounds.
_PATCHES, _FACES = 8, 2500
# Residuals of vertices so many edges from the border are whole enough.
_RINGS = 3
# In the calmest part the surface hardly adds to residuals. Squares count up to so many times their median, and are averaged over
# so many rings.
_CLIP, _AVERAGED = 9.0, 4
# Random numbers are the fractions of so many times a length of the geometry, another multiple for every width.
_MULTIPLE, _STEP = 997.0, 137.7


def setting_of_rounded(
    mesh: NormalisedMesh, rounding: Rounding, other: Setting, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> Choice[Setting] | None:
    """The setting for rounded coordinates, and what speaks for it; None if another setting is better.

    Rounding is undone first, see `Rounding.undone`. Of the settings, and the other on the rounded surface, that of the least
    product of roughness and of how far vertices are out of their steps is taken [reginska1996].

    Args:
        mesh: the mesh; vertices that may not move are no evidence.
        rounding: of `rounding_of`.
        other: what is chosen where vertices are taken to have noise of their own. It is better where details are as fine as the
            steps.
        border: see `normal_filtering`.
        progress: called with the share that is done; may raise to stop.
    """
    undone = rounding.undone(mesh.points, mesh.cells, mesh.movable)
    sample = _sample(undone, mesh.cells)
    tried, labels, _ = _tried(mesh, sample, border, "undo")
    scored = _scored(mesh, sample)
    here, rounded = undone[sample.origin], mesh.points[sample.origin]
    unit = mean_edge_length(here, sample.faces)
    every: Sequence[Setting] = [label for family in labels for label in family]
    out, rough = np.zeros(len(every)), np.zeros(len(every))

    def measures(result: Floats) -> tuple[float, float]:
        left = rounding.left(result, rounded)[scored]
        return float(np.sqrt((left**2).mean())) if len(left) else 0.0, roughness(result, sample.faces)

    def look(at: int, result: Floats) -> None:
        out[at], rough[at] = measures(here + unit * (result - sample.points))

    families: Sequence[Iterator[Floats]] = tried(sample.points, np.empty(0, dtype=np.int32))
    run_to_last(families, starts_of(labels), np.ones(len(every), dtype=np.bool_), look, progress)
    products = rough * (out + tuned.OUT_OF_STEP)
    best = int(products.argmin())
    moves = None if mesh.movable is None else mesh.movable[sample.origin]
    out_of_step, roughness_of_it = measures(other.apply(rounded, sample.faces, border=border, movable=moves))
    if roughness_of_it * (out_of_step + tuned.OUT_OF_STEP) <= products[best]:
        return None
    scores = Scores(out, products - products[best], np.zeros(len(every)), best)
    trials = trials_of(every, np.arange(len(every), dtype=np.int32), scores)
    return Choice(trials[best], trials)


def setting_of_shared(
    mesh: NormalisedMesh, noise: NoiseEstimate, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> tuple[Setting, Choice[Setting] | None] | None:
    """How to denoise a mesh with noise that neighbours share, and what speaks for it; None if they do not.

    The covariance of the noise is measured where the mesh is calm, and that setting is taken whose slopes are expected to be
    nearest to the truth, see `choose_by_risk`. Fused maps share it more widely than can be measured beside the surface, and get a
    strong setting. Arguments as of `setting_of_rounded`; the noise is that of `estimate_noise`.
    """
    if _field_of_shared(mesh.points, mesh.cells, noise) is None:
        return None
    if not on_lines_of_sight(mesh.points, mesh.cells):
        return STRONG, None
    sample = _sample(mesh.points, mesh.cells)
    tried, labels, normals = _tried(mesh, sample, border)
    scored = _scored(mesh, sample)
    field = noise_field(sample.points, sample.faces, normals=normals, scored=scored, widths=_WIDTHS, scales=_SCALES)
    found = choose_by_risk(
        sample.points, sample.faces, tried, labels, normals=normals, scored=scored, noise=field.heights, progress=progress
    )
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
    field = _field_of_shared(points, faces, noise)
    return 0.0 if field is None else float(np.sqrt(field.variances.sum()))


def on_lines_of_sight(points: Floats, faces: Ints) -> bool:
    """Whether the vertices are pixels: differences of fourth order are along the view alone, the rest being evenly spaced."""
    pairs = edges(faces)
    residuals = differences_of_fourth_order(points, pairs)[inner_vertices(faces, pairs, len(points))]
    squares = np.linalg.eigvalsh(residuals.T @ residuals)
    return bool(squares[-1] > tuned.ON_LINES * squares.sum())


def _field_of_shared(points: Floats, faces: Ints, noise: NoiseEstimate) -> NoiseField | None:
    """The noise, roughly, if neighbours share it."""
    if noise.level == 0.0 or seen_from_one_side(points, faces) <= tuned.FACING:
        return None
    on_lines = on_lines_of_sight(points, faces)
    if not on_lines and not _fused(points, faces):
        return None
    sample = sample_of(points, faces)
    if not on_lines and Agreement.of(sample.points, sample.faces).is_surface:
        return None
    normals, scored = smooth_normals(sample.points, sample.faces), far_from_border(sample.faces, len(sample.points), rings=_RINGS)
    widths, scales = _TELL
    field = noise_field(sample.points, sample.faces, normals=normals, scored=scored, widths=widths, scales=scales)
    least = max(tuned.OWN, 0.5 * noise.level)
    return field if field.own >= least and field.shared > 0.5 else None


def _fused(points: Floats, faces: Ints) -> bool:
    """Whether it is a level set, which cuts off corners."""
    lengths = edge_lengths(points, edges(faces))
    return bool(np.mean(lengths < 0.25 * lengths.mean()) > tuned.CUT_OFF)


def _sample(points: Floats, faces: Ints) -> Sample:
    return sample_of(points, faces, patches=_PATCHES, size=_FACES)


def _scored(mesh: NormalisedMesh, sample: Sample) -> Bools:
    scored = far_from_border(sample.faces, len(sample.points), rings=_RINGS)
    return scored if mesh.movable is None else scored & mesh.movable[sample.origin]


def _tried(
    mesh: NormalisedMesh, sample: Sample, border: BorderPolicy, rounding: RoundingPolicy = "keep"
) -> tuple[SettingsTried, tuple[tuple[Setting, ...], ...], Floats]:
    """The settings on the sample, their labels, and the normals along which they are judged."""
    normals = smooth_normals(sample.points, sample.faces)
    direction = direction_for(estimate_noise(sample.points, sample.faces))
    tried = SettingsTried(
        sample.faces,
        normals,
        direction,
        border=border,
        movable=None if mesh.movable is None else mesh.movable[sample.origin],
        whole=len(sample.faces) == len(mesh.cells),
        of=CORRELATED,
    )
    return tried, settings(direction, of=CORRELATED, rounding=rounding), normals


class NoiseField(NamedTuple):
    """Noise as a sum of independent parts, part k smoothed over `widths[k]` steps.

    Attributes:
        widths: (k,) the steps; 0 is noise of the vertex alone, k smooths with a standard deviation of 2/3 sqrt(k) edges.
        variances: (k,) those of the parts, in squared units of the points.
        heights: (n,) one such noise along the normals.
    """

    widths: tuple[int, ...]
    variances: Floats
    heights: Floats

    @property
    def shared(self) -> float:
        """The share of the variance that is not of the vertex alone; 0 without noise."""
        total = float(self.variances.sum())
        return float(self.variances[np.array(self.widths) > 0].sum()) / total if total > 0.0 else 0.0

    @property
    def own(self) -> float:
        """The standard deviation of what is of the vertex alone."""
        return float(np.sqrt(self.variances[np.array(self.widths) == 0].sum()))


def noise_field(
    points: Floats, faces: Ints, *, normals: Floats, scored: Bools, widths: Sequence[int], scales: Sequence[int]
) -> NoiseField:
    """Fit a sum of noises to what differences of several widths leave of a surface.

    With W the mean over the one-ring and twice the weight of its neighbours, (I + 2 U) / 3, the residuals of scale m are those of
    (I - W^m)^2. Their squares, averaged over some rings, have a least part where the surface is calm. Every part of the noise,
    made with a variance of 1 on the same mesh, has such numbers of its own; the variances are the non-negative sum of these that
    is nearest to what was seen, relatively.

    Args:
        points: (n, 3) coordinates with a mean edge of 1.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.
        scored: (n,) the vertices that count.
        widths: the steps over which parts of the noise are smoothed.
        scales: the scales of the residuals.

    Returns:
        The noise; nothing if no vertex counts. The same for the mesh moved, turned or renumbered.
    """
    nothing = NoiseField(tuple(widths), np.zeros(len(widths)), np.zeros(len(points)))
    if not scored.any():
        return nothing
    means = _means(faces, len(points))
    seen = np.array([_calm(_residuals(points, means, scale, normals), means, scored) for scale in scales])
    if seen.min() <= 0.0:
        return nothing
    parts = [_unit_noise(points, means, scored, width) for width in widths]
    made = np.array([[_calm(_residuals(part, means, scale), means, scored) for part in parts] for scale in scales])
    variances, _ = optimize.nnls(made / seen[:, None], np.ones(len(scales)))
    heights = np.sum([np.sqrt(variance) * part for variance, part in zip(variances, parts, strict=True)], axis=0)
    return NoiseField(tuple(widths), variances, heights)


def _means(faces: Ints, n: int) -> sparse.csr_matrix:
    a, b = edges(faces).T
    rows, columns = np.concatenate([a, b]), np.concatenate([b, a])
    degrees = np.maximum(np.bincount(rows, minlength=n), 1)
    ring = sparse.csr_matrix((2.0 / 3.0 / degrees[rows], (rows, columns)), shape=(n, n))
    return ring + sparse.diags(np.where(np.bincount(rows, minlength=n) > 0, 1.0 / 3.0, 1.0), format="csr")


def _residuals(values: Floats, means: sparse.csr_matrix, scale: int, normals: Floats | None = None) -> Floats:
    for _ in range(2):
        smooth = values
        for _ in range(scale):
            smooth = means @ smooth
        values = values - smooth
    return values if normals is None else np.asarray(np.einsum("ij,ij->i", values, normals))


def _calm(residuals: Floats, means: sparse.csr_matrix, scored: Bools) -> float:
    """The mean square that a twentieth of the vertices stays below."""
    squares = residuals**2
    sums, weights = np.where(scored, np.minimum(squares, _CLIP * np.median(squares[scored])), 0.0), scored.astype(np.float64)
    for _ in range(_AVERAGED):
        sums, weights = means @ sums, means @ weights
    return float(np.quantile(sums[scored] / weights[scored], tuned.CALMEST))


def _unit_noise(points: Floats, means: sparse.csr_matrix, scored: Bools, width: int) -> Floats:
    """(n,) random numbers, smoothed, with a variance of 1; they are made of the distances from the middle of the mesh."""
    distances = np.linalg.norm(points - points[scored].mean(axis=0), axis=1)
    noise = (distances * (_MULTIPLE + _STEP * width)) % 1.0 - 0.5
    for _ in range(width):
        noise = means @ noise
    deviation = float(np.sqrt((noise[scored] ** 2).mean()))
    return np.asarray(noise / deviation if deviation > 0.0 else noise)
