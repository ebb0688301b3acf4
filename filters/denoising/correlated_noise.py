"""Chooses settings for noise that neighbours share, as in rounded coordinates, filtered depth maps and meshes fused from maps.

Cross-validation fails for such noise: neighbours share the noise of a held-out vertex, so they predict the noise, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from ..evidence import Choice, measured, tuned
from ..execution import Progress, ignore_progress, part_of
from ..geometry import angles_between, edge_lengths, face_normals, mean_edge_length, roughness, seen_from_one_side
from ..libraries import optimize, sparse
from ..mesh import Floats, Ints, NormalisedMesh
from ..topology import BorderPolicy, edges, face_adjacency
from .candidates import CORRELATED, Setting, SettingsTried
from .noise_level import AVERAGED, CLIP, FourthOrder, NoiseEstimate, is_designed, ring_means
from .rounding import Rounding, rounding_of
from .scan import NONE_HELD, Scan

# Widths and scales for `noise_field`: to detect shared noise; to fit it; and to fit it on solids where its presence is in doubt.
_DETECT, _FIT = ((0, 2), (1, 4)), [((0, width), (1, 2, 4)) for width in (2, 3, 4)]
_FIT_IN_DOUBT = [((0, width), (1, 2, 4, 8, 16), tuned.CALMEST, (16,)) for width in (1, 2, 3)]  # last: `surface` of `noise_field`
# Widths, scales and `calmest` to fit the noise of fused maps. This noise is correlated over five edges or more. The calmest
# parts of a fused map were seen at a slant and have too little noise, so `calmest` is larger than `tuned.CALMEST`.
_FIT_FUSED = [((0, 1, 4, 16, 64), (1, 2, 4, 8, 16, 32), 1.0 / 3.0)]
_FLATTER = 7.0  # removing shared noise makes designed parts 8 to 30 times flatter; rough surfaces get up to 6.6 times flatter
_FAR = 8  # smoothing steps over which levels of noise are averaged, to compare them between places
# Sampling of scans: residuals are accurate three edges away from a border, patches are large enough for forty filter iterations.
_WIDE: dict[str, Any] = {"patches": (8, 2500), "rings": 3}


def setting_of_rounded(
    mesh: NormalisedMesh, rounding: Rounding, other: Setting, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> Choice[Setting] | None:
    """Chooses the setting for rounded coordinates; None if `other`, a setting that keeps the rounding, is better.

    The `rounding` is undone first, see `Rounding.undone`. Of the results with the least distance from the rounded vertices,
    within one standard error, the flattest is chosen (`Scan.flattest`). If the steps of the rounding differ, as those of a depth
    camera do, distances up to the noise of the mesh and of the rounding are allowed [morozov1966].

    `other` is better if its result has the smaller estimated error. It is also better if its result is at least as flat, and
    is more than 1.2 standard deviations of the noise from the rounded vertices, or less than half of one from the chosen result.
    """
    undone = rounding.undone(mesh.points, mesh.cells, mesh.movable)
    scan, origin = Scan.sampled(undone, mesh.cells, mesh.movable, **_WIDE)
    tried = SettingsTried(scan, border=border, of=CORRELATED, rounding="undo")
    smooth, rounded = undone[origin], mesh.points[origin]
    unit = mean_edge_length(smooth, scan.faces)
    variance, others, limit = (rounding.step / unit) ** 2 / 12.0, 0.0, 0.0
    if not rounding.equal_steps:
        others = noise_field(replace(scan, points=scan.points + (rounded - smooth) / unit), *_DETECT, 0.5).variances.sum()
        limit = float(np.sqrt(variance + others))
    counted = np.flatnonzero(scan.scored if scan.scored.any() else np.ones_like(scan.scored)).astype(np.int32)
    axes, deviations, normals = np.transpose(rounding.directions), rounding.deviations(rounded[counted]), scan.normals[counted]

    def measures(_: int, result: Floats) -> tuple[Floats, float]:
        points = smooth + unit * (result - scan.points)
        return variance * np.mean(((points - rounded)[counted] @ axes / deviations) ** 2, axis=1), roughness(points, scan.faces)

    squares, flatness = zip(*measured(tried(scan.points, NONE_HELD), tried.labels, measures, progress), strict=True)
    choice = scan.flattest(counted, squares, flatness, tried.labels, limit)
    chosen, kept = (s.apply(rounded, scan.faces, border=border, movable=scan.movable) for s in (choice.chosen.label, other))
    # Mean squares along the normals: if errors and noise are uncorrelated, `of_chosen` is the squared error of `chosen` plus the
    # variance of the noise, and `between` the sum of the squared errors of `chosen` and `kept`.
    moves = chosen - rounded, kept - rounded, chosen - kept
    of_chosen, of_kept, between = (np.mean(np.einsum("ij,ij->i", each[counted], normals) ** 2) for each in moves)
    noise = np.mean(((normals @ axes * deviations) ** 2).sum(axis=1)) + others * unit**2
    has_smaller_error = between < 2.0 * (of_chosen - noise)
    has_more_noise, results_agree = of_kept > tuned.LARGER**2 * noise, between < 0.25 * noise
    is_flatter = roughness(kept, scan.faces) <= flatness[choice.trials.index(choice.chosen)]
    return None if has_smaller_error or (is_flatter and (has_more_noise or results_agree)) else choice


def setting_of_shared(
    mesh: NormalisedMesh, noise: NoiseEstimate, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> Choice[Setting] | None:
    """Chooses the setting for noise that neighbours share; None without such noise, or if no filter improves the mesh.

    The covariance of the noise, for `Scan.choose_by_risk`, is measured where the mesh is calm. `noise` is from `estimate_noise`.
    If such noise is in doubt, the choice must halve the root mean square error of edge vectors.
    """
    shared, fits, in_doubt = _shared(mesh.points, mesh.cells, noise)
    if shared == 0.0:
        return None
    scan, _ = Scan.sampled(mesh.points, mesh.cells, mesh.movable, **_WIDE, progress=progress)
    tried = SettingsTried(scan, border=border, of=CORRELATED)
    field = min((noise_field(scan, *arguments) for arguments in fits), key=lambda field: field.misfit)
    # Vertices near the border count, too, since many rounds of filtering move them.
    choice = replace(scan, rings=1).choose_by_risk(tried, tried.labels, field.heights)
    if choice is None or choice.chosen.label == Setting():
        return None
    # Squared errors include the variance v of the noise in the data: 2 v for doing nothing, v + v / 4 for half the error.
    halves = choice.chosen.error**2 < (1.0 + 0.25) / 2.0 * choice.trials[0].error ** 2
    return choice if halves or not in_doubt else None


def setting_by_balls(
    scan: Scan, tried: SettingsTried, choice: Choice[Setting], *, border: BorderPolicy
) -> Choice[Setting] | None:
    """Chooses the setting that best predicts held-out balls, see `Scan.choose`; None if `choice` leaves no shared noise.

    `choice` leaves such noise if more than half of the vertices are scored, and three things hold in comparison with the setting
    that predicts balls best: its error at balls is larger by over two standard errors; the median angle between adjacent faces is
    over 7 times as large; the ratio of the deciles of local differences is below 1.2 times that of smoothed white noise.
    """
    pairs, _ = face_adjacency(scan.faces)

    def result(setting: Setting, points: Floats = scan.points) -> Floats:
        return setting.apply(points, scan.faces, border=border, movable=scan.movable)

    def angle(points: Floats) -> float:
        return float(np.median(angles_between(*face_normals(points, scan.faces)[pairs.T])))

    label, last = choice.chosen.label, [family[-1] for family in tried.labels[1:]]
    left = result(label)
    enough = angle(left) / _FLATTER
    # Saves time: if none of the strongest settings makes the mesh flat enough, none does.
    strongest = (setting for setting in last if setting.relaxation == max(each.relaxation for each in last))
    if np.mean(scan.scored) <= 0.5 or not any(angle(result(setting)) < enough for setting in strongest):
        return None
    balls = scan.choose(tried, tried.labels, denoised=partial(result, label), progress=part_of(scan.progress, 0.5, 1.0))
    if balls is None or label in [trial.label for trial in balls.rivals]:
        return None
    at, flat = _Scales(scan), result(balls.chosen.label)
    noises = np.einsum("ij,ij->i", left - flat, scan.normals), at.noise(2)
    (low, high), (least, most) = (np.quantile(at.local_means(noise**2, _FAR), (0.1, 0.9)) for noise in noises)
    return balls if high * least < tuned.LARGER**2 * most * low and angle(flat) < enough else None


def shared_noise(points: Floats, faces: Ints, noise: NoiseEstimate) -> float:
    """Returns the standard deviation of shared noise along the normals, or of rounding along its axis; 0 in doubt.

    (n, 3) `points` have a mean edge of 1, `faces` are (m, 3) triangles, `noise` comes from `estimate_noise`.
    """
    rounding = rounding_of(points, faces)
    if rounding is not None:
        return rounding.step / float(np.sqrt(12.0))
    shared, _, in_doubt = _shared(points, faces, noise)
    return 0.0 if in_doubt else shared


def on_lines_of_sight(points: Floats, faces: Ints) -> bool:
    """Whether the noise (differences of fourth order) lies mainly along one line, as in a depth map along the line of sight."""
    fourth = FourthOrder.of(faces, len(points))
    residuals = fourth.differences(points)[fourth.inner]
    squares = np.linalg.eigvalsh(residuals.T @ residuals)
    return bool(squares[-1] > tuned.ON_LINES * squares.sum())


def _shared(points: Floats, faces: Ints, noise: NoiseEstimate) -> tuple[float, Sequence[tuple[Any, ...]], bool]:
    """Returns the standard deviation of shared noise (0: none), arguments of `noise_field` to try, and whether it is in doubt."""
    if noise.level < tuned.NO_NOISE:
        return 0.0, _FIT, False
    facing, lengths = seen_from_one_side(points, faces) > tuned.FACING, edge_lengths(points, edges(faces))
    on_lines, cut_off = facing and on_lines_of_sight(points, faces), np.mean(lengths < 0.25 * lengths.mean()) > tuned.CUT_OFF
    if on_lines or (facing and cut_off):
        scan, fits = Scan.sampled(points, faces, rings=3)[0], _FIT if on_lines else _FIT_FUSED
        independent, total = np.cumsum(noise_field(scan, *_DETECT).variances).tolist()
        enough = independent < 0.5 * total and np.sqrt(independent) >= max(tuned.INDEPENDENT, 0.5 * noise.level)
        return (float(np.sqrt(total)) if enough and (on_lines or not scan.is_surface) else 0.0), fits, False
    scan = Scan.sampled(points, faces, **_WIDE)[0]
    fall = 0.0 if cut_off or is_designed(points, faces) else fall_of_growth(scan)  # smoothing reaches less far on short edges
    if fall < tuned.IN_DOUBT:
        return 0.0, _FIT, False
    of_solids = _FIT[:2] if fall > 1.0 else _FIT_IN_DOUBT
    field = min((noise_field(scan, *arguments) for arguments in of_solids), key=lambda field: field.misfit)
    return float(np.sqrt(field.variances.sum())), of_solids, fall <= 1.0


class NoiseField(NamedTuple):
    """A model of the noise on a surface: a sum of white noises, each smoothed by a different number of steps."""

    variances: Floats  # (k,) variances of the parts, in squared units of the points; 0 if nothing can be measured
    heights: Floats  # (n,) a sample of the noise along the normals; moving, turning or renumbering does not change it
    misfit: float = 0.0  # norm of the relative errors of the measures of `noise_field`


def noise_field(
    scan: Scan, widths: Sequence[int], scales: Sequence[int], calmest: float = tuned.CALMEST, surface: tuple[int, ...] = ()
) -> NoiseField:
    """Fits the variances of several noises to residuals of the surface at several scales.

    The measure at a scale is the quantile `calmest` of local means of the clipped squared `_Scales.residuals`. White noise is
    smoothed by each width (a number of steps), scaled to variance 1, and measured in the same way. The variances are the
    non-negative weights with which the measures of the noises add up best to the measures of the surface. The widths `surface`
    are fitted, too, but left out of the result: they stand for the shape without noise.
    """
    nothing = NoiseField(np.zeros(len(widths)), np.zeros(len(scan.points)))
    if not scan.scored.any():
        return nothing
    at = _Scales(scan)

    def calm(heights: Floats) -> float:
        clipped = np.minimum(heights**2, CLIP * np.median(heights[scan.scored] ** 2))
        return float(np.quantile(at.local_means(clipped, AVERAGED), calmest))

    seen = np.array([calm(at.heights(scale)) for scale in scales])
    if seen.min() <= 0.0:
        return nothing
    parts = [at.noise(width) for width in (*widths, *surface)]
    made = np.array([[calm(at.residuals(part, scale)) for part in parts] for scale in scales])
    fitted, misfit = optimize.nnls(made / seen[:, None], np.ones(len(scales)))
    heights = np.sum([np.sqrt(variance) * part for variance, part in zip(fitted, parts[: len(widths)], strict=False)], axis=0)
    return NoiseField(fitted[: len(widths)], heights, misfit)


def fall_of_growth(scan: Scan) -> float:
    """Returns the growth of residuals from scale 2 to 4 over that from 4 to 8; 0 if they cannot be shared noise of even level.

    Levels are divided by those of white noise. If vertices share noise with those one or two rings away, the level grows from
    scale 1 to 4, but from 4 to 8 hardly more than from 2 to 4. On a curved surface the growth increases. An even level is about
    the same everywhere. The kurtosis at scale 2 must be nearer to 3 (normal distribution) than to 1.8 (uniform) or 6 (Laplace).
    """
    if not scan.scored.any():
        return 0.0
    at, scales = _Scales(scan), (1, 2, 4, 8)

    def measures(heights: Iterable[Floats]) -> list[Floats]:
        """By scale: lower quartile q of levels, its ratio to the quantile `CALMEST`, kurtosis at levels up to q."""
        rows = []
        for squares in (values**2 for values in heights):
            local = np.maximum(at.local_means(squares, _FAR), 1e-24)  # exact planes have 0
            quarter, calmest = np.quantile(local, (0.25, tuned.CALMEST))
            relative = (squares[scan.scored] / local)[local <= quarter]
            rows.append((np.sqrt(quarter), np.sqrt(quarter / calmest), (relative**2).mean() / relative.mean() ** 2))
        return list(np.array(rows).T)

    (level, spread, kurtosis), white = measures(map(at.heights, scales)), at.noise(0)
    level_of_white, spread_of_white, _ = measures(at.residuals(white, scale) for scale in scales)
    level = level / level_of_white
    is_even = (spread < tuned.LARGER * spread_of_white).all()
    is_shared = is_even and 1.8 * 3.0 < kurtosis[1] ** 2 < 3.0 * 6.0 and level[2] > tuned.LARGER * level[0]
    return float(level[2] ** 2 / (level[1] * level[3])) if is_shared else 0.0


@dataclass(frozen=True)
class _Scales:
    """Residuals of a scan at several scales: (I - W^m)^2 v for (n, ...) values v at scale m.

    A smoothing step W = (I + 2 U) / 3 averages a vertex and its neighbours, with U the mean over the one-ring.
    """

    scan: Scan

    @cached_property
    def step(self) -> sparse.csr_matrix:
        """(n, n) the matrix W."""
        means = ring_means(edges(self.scan.faces), len(self.scan.points), 2.0 / 3.0)
        return means + sparse.identity(means.shape[0], format="csr") / 3.0

    def smoothed(self, values: Floats, times: int) -> Floats:
        for _ in range(times):
            values = self.step @ values
        return values

    def residuals(self, values: Floats, scale: int) -> Floats:
        first = values - self.smoothed(values, scale)
        return np.asarray(first - self.smoothed(first, scale))

    def heights(self, scale: int) -> Floats:
        """Returns (n,) the residuals of the points along the normals."""
        return np.asarray(np.einsum("ij,ij->i", self.residuals(self.scan.points, scale), self.scan.normals))

    def local_means(self, values: Floats, times: int) -> Floats:
        """Returns the means of (n,) values around each scored vertex, over scored vertices with the weights of W^times."""
        counted = self.scan.scored
        sums, weights = (self.smoothed(part, times)[counted] for part in (np.where(counted, values, 0.0), counted.astype(float)))
        return np.asarray(sums / weights)

    def noise(self, width: int) -> Floats:
        """Returns (n,) white noise smoothed by `width` steps, of variance 1.

        Random numbers from the distance to the centroid do not depend on rotations and numbering.
        """
        points, scored = self.scan.points, self.scan.scored
        distances = np.linalg.norm(points - points[scored].mean(axis=0), axis=1)
        part = self.smoothed((distances * (997.0 + 137.7 * width)) % 1.0 - 0.5, width)
        return part / (float(np.sqrt((part[scored] ** 2).mean())) or 1.0)
