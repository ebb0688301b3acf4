"""Noise that neighbours share: rounded coordinates, depth cameras with filters of their own, maps that are fused from these.

Held-out vertices say nothing of it: what predicts them predicts their noise too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..evidence import (
    Choice,
    Sample,
    Trial,
    choose_by_risk,
    far_from_border,
    noise_field,
    roughness,
    run_to_last,
    sample_of,
    starts_of,
)
from ..execution import Progress, ignore_progress, part_of
from ..geometry import edge_lengths, mean_edge_length, seen_from_one_side
from ..mesh import Bools, Floats, Ints, NormalisedMesh
from ..topology import BorderPolicy, edges
from .candidates import SettingsTried
from .noise_level import NoiseEstimate, differences_of_fourth_order, estimate_noise, inner_vertices, smooth_normals
from .relaxation import direction_for
from .repertoire import CORRELATED, STRONG, Setting, settings
from .rounding import Rounding, RoundingPolicy, rounding_of

# A map is seen from one side: the mean of its normals is longer than this. Of noisy maps it is 0.5 and more.
_FACING = 0.4
# The vertices of a depth map lie on lines of sight, and so do their residuals: this share of their squares and more is along one
# direction. Maps of lenses of up to 45 degrees have 0.9 and more, other meshes with noise, terrain among them, up to 0.6.
_ON_LINES = 0.75
# A fused map is a level set in a grid of cubes, which cuts off corners anywhere: 7 to 10 % of its edges are shorter than a
# quarter of the mean; of other meshes, uneven ones among them, at most 3 %, and up to 5.5 % of a fused map that was decimated.
_SHORT, _CUT_OFF = 0.25, 0.06
# Noise is shared if so large a part of its variance is, and if vertices have so much of their own, in mean edges: details of a
# surface without noise look the same. Depth maps have 0.033 and more, maps of a laser scanner without noise up to 0.012; most
# fused maps have 0.02 and more, and a fused scan that was smoothed by one Laplacian step up to 0.015.
_SHARED, _OWN, _OWN_FUSED = 0.5, 0.03, 0.02
# And so much of what all have: less is uneven noise, whose quietest places tell nothing of the others. Depth maps have 0.74 and
# more, fused ones 0.57, independent noise that grows from nothing 0.42.
_EVEN = 0.5
# Noise of single vertices, and noise smoothed over so many steps, as seen by differences of so many: to tell that it is shared,
# and to know its covariance.
_TELL = (0, 2), (1, 4)
_WIDTHS, _SCALES = (0, 1, 2, 4), (1, 2, 4)
# Patches of large meshes, each wide enough for forty rounds.
_PATCHES, _FACES = 8, 2500
# Residuals of vertices so many edges from the border are whole enough.
_RINGS = 3
# How much the vertices are out of the steps of rounding counts on top of so many steps.
_OUT = 0.08


def correlated_setting(
    mesh: NormalisedMesh, noise: NoiseEstimate, *, border: BorderPolicy, progress: Progress = ignore_progress
) -> tuple[Setting, Choice[Setting] | None] | None:
    """How to denoise a mesh with noise that neighbours share, and what speaks for it; None if they do not.

    Rounding is undone first, see `Rounding.undone`, and of the settings that of the least product of roughness and of how far
    vertices are out of their steps is taken [reginska1996]. Otherwise the covariance of the noise is measured where the mesh is
    calm, and that setting is taken whose slopes are expected to be nearest to the truth, see `choose_by_risk`. Fused maps share
    it more widely than can be told from the surface, and get a strong setting.

    Args:
        mesh: the mesh; vertices that may not move are no evidence.
        noise: of `estimate_noise`.
        border: see `normal_filtering`.
        progress: called with the share that is done; may raise to stop.
    """
    rounding = rounding_of(mesh.points, mesh.cells)
    if rounding is not None:
        return _of_rounded(mesh, rounding, border, progress)
    if not _share_noise(mesh.points, mesh.cells, noise):
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


def neighbours_share_noise(points: Floats, faces: Ints, noise: NoiseEstimate) -> bool:
    """Whether the mesh has noise that neighbours share.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
        noise: of `estimate_noise`.
    """
    return rounding_of(points, faces) is not None or _share_noise(points, faces, noise)


def on_lines_of_sight(points: Floats, faces: Ints) -> bool:
    """Whether the vertices are pixels: differences of fourth order are along the view alone, the rest being evenly spaced."""
    pairs = edges(faces)
    residuals = differences_of_fourth_order(points, pairs)[inner_vertices(faces, pairs, len(points))]
    squares = np.linalg.eigvalsh(residuals.T @ residuals)
    return bool(squares[-1] > _ON_LINES * squares.sum())


def _share_noise(points: Floats, faces: Ints, noise: NoiseEstimate) -> bool:
    if noise.level == 0.0 or seen_from_one_side(points, faces) <= _FACING:
        return False
    on_lines = on_lines_of_sight(points, faces)
    if not on_lines and not _fused(points, faces):
        return False
    sample = sample_of(points, faces)
    normals, scored = smooth_normals(sample.points, sample.faces), far_from_border(sample.faces, len(sample.points), rings=_RINGS)
    widths, scales = _TELL
    field = noise_field(sample.points, sample.faces, normals=normals, scored=scored, widths=widths, scales=scales)
    least = max(_OWN if on_lines else _OWN_FUSED, _EVEN * noise.level)
    return field.own >= least and field.shared > _SHARED


def _fused(points: Floats, faces: Ints) -> bool:
    """Whether it is a level set, which cuts off corners."""
    lengths = edge_lengths(points, edges(faces))
    return bool(np.mean(lengths < _SHORT * lengths.mean()) > _CUT_OFF)


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


def _of_rounded(
    mesh: NormalisedMesh, rounding: Rounding, border: BorderPolicy, progress: Progress
) -> tuple[Setting, Choice[Setting] | None]:
    undone = rounding.undone(mesh.points, mesh.cells, mesh.movable)
    sample = _sample(undone, mesh.cells)
    tried, labels, _ = _tried(mesh, sample, border, "undo")
    scored = _scored(mesh, sample)
    here, rounded = undone[sample.origin], mesh.points[sample.origin]
    unit = mean_edge_length(here, sample.faces)
    every: Sequence[Setting] = [label for family in labels for label in family]
    out, rough = np.zeros(len(every)), np.zeros(len(every))

    def look(at: int, result: Floats) -> None:
        left = rounding.left(here + unit * (result - sample.points), rounded)[scored]
        out[at] = np.sqrt((left**2).mean()) if len(left) else 0.0
        rough[at] = roughness(result, sample.faces)

    families: Sequence[Iterator[Floats]] = tried(sample.points, np.empty(0, dtype=np.int32))
    run_to_last(families, starts_of(labels), np.ones(len(every), dtype=np.bool_), look, part_of(progress, 0.0, 1.0))
    products = rough * (out + _OUT)
    best = int(products.argmin())
    trials = tuple(
        Trial(label, float(error), float(product - products[best]), 0.0, None)
        for label, error, product in zip(every, out, products, strict=True)
    )
    return trials[best].label, Choice(trials[best], trials)
