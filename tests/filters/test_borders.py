"""Denoising at the border of open meshes, where everything that a vertex or a face sees lies to one side."""

from __future__ import annotations

import numpy as np
import pytest

from pymeshfair.filters.denoising import Outliers, denoised, normal_filtering
from pymeshfair.filters.denoising.face_neighbourhoods import Adjacency, Neighborhood
from pymeshfair.filters.denoising.impulses import replace_outlying
from pymeshfair.filters.denoising.normal_filter import NormalFilter, Weighting, weighted_normals
from pymeshfair.filters.denoising.preparation import outline_kept, relaxed
from pymeshfair.filters.diffusion.explicit import taubin_fairing
from pymeshfair.filters.geometry import CENTRE, NORMAL, face_normals, measure_faces
from pymeshfair.filters.mesh import normalised_mesh
from pymeshfair.filters.topology import BORDER_POLICIES, border_vertices
from tests.angles import mean_angle
from tests.meshes import Bools, Floats, irregular_grid, torus

FLAT, FACES = irregular_grid(30, 34)
BORDER = border_vertices(FACES, len(FLAT))
UP = np.tile([0.0, 0.0, 1.0], (len(FLAT), 1))
AT_BORDER = BORDER[FACES].any(axis=1)
SHEET = Adjacency.of(normalised_mesh(FLAT, FACES))


def _bowl(curvature: float) -> Floats:
    """The sheet bent to a paraboloid, in one unit of its edges, about 15 edges from its middle to its border."""
    points = np.array(FLAT - FLAT.mean(axis=0))
    points[:, 2] = 0.5 * curvature * (points[:, :2] ** 2).sum(axis=1)
    return points


@pytest.mark.parametrize(("kind", "rings"), [("edge", 1), ("vertex", 1), ("two_ring", 2), ("three_ring", 3)])
def test_the_faces_that_a_border_cuts_off_are_those_within_so_many_rings(kind: Neighborhood, rings: int) -> None:
    """A face is cut off if a border vertex is fewer than so many edges from one of its corners; none is on a closed mesh."""
    reached: Bools = BORDER.copy()
    for _ in range(rings - 1):
        sides = np.concatenate([FACES[:, [0, 1]], FACES[:, [1, 2]], FACES[:, [2, 0]]])
        ends = reached[sides]
        reached[sides[ends.any(axis=1)]] = True
    expected = np.flatnonzero(reached[FACES].any(axis=1))
    assert np.array_equal(SHEET.cut_off(kind, 2.0), expected)
    assert len(Adjacency.of(normalised_mesh(*torus())).cut_off(kind, 2.0)) == 0


def test_the_rim_of_a_patch_is_no_end_of_the_surface() -> None:
    """Where the mesh is cut out of a larger one, no face is cut off."""
    assert len(SHEET.cut_off("two_ring", 2.0)) > 0
    assert len(Adjacency.of(normalised_mesh(FLAT, FACES), ends=False).cut_off("two_ring", 2.0)) == 0


def test_normals_that_turn_evenly_are_reproduced_at_a_border() -> None:
    """The mean at a border face is off by how far they turn; with the trend by less than a fifth of that, for the ridge."""
    table = measure_faces(FLAT, FACES)
    normals = np.column_stack([0.005 * table[:, CENTRE] @ [[1.0, 0.3], [-0.2, 0.8], [0.0, 0.0]], np.ones(len(FACES))])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    which = SHEET.cut_off("two_ring", 2.0)
    weighting = Weighting.of(NormalFilter(range_kernel="huber", range_sigma=1.0), 2.0)
    plain, followed = (
        weighted_normals(normals, table, SHEET.around("two_ring"), weighting, cut_off=cut_off) for cut_off in (None, which)
    )
    assert mean_angle(followed[AT_BORDER], normals[AT_BORDER]) < 0.2 * mean_angle(plain[AT_BORDER], normals[AT_BORDER])
    others = np.setdiff1d(np.arange(len(FACES)), which)
    assert np.array_equal(followed[others], plain[others])


def test_where_normals_scatter_the_mean_stays() -> None:
    """Of a plane with independent normals half of the means at the border or more keep every bit: no trend is to be seen."""
    table = measure_faces(FLAT, FACES)
    normals = table[:, NORMAL] + 0.3 * np.random.default_rng(2).normal(size=(len(FACES), 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    which = SHEET.cut_off("two_ring", 2.0)
    weighting = Weighting.of(NormalFilter(range_kernel="huber", range_sigma=2.0), 2.0)
    plain, followed = (
        weighted_normals(normals, table, SHEET.around("two_ring"), weighting, cut_off=cut_off) for cut_off in (None, which)
    )
    assert np.mean((plain == followed).all(axis=1)[which]) >= 0.5


def test_noise_goes_at_the_border_of_a_bowl_nearly_as_well_as_inside() -> None:
    """After ten rounds faces at the border are off by less than two and a half times what those inside are."""
    true = _bowl(0.05)
    noisy = true.copy()
    noisy[:, 2] += 0.15 * np.random.default_rng(0).normal(size=len(true))
    found = normal_filtering(
        noisy, FACES, method="averaged", range_kernel="huber", neighborhood="two_ring", normal_iterations=1, outer_iterations=10
    )
    normals, wanted = face_normals(found, FACES), face_normals(true, FACES)
    inside = ~AT_BORDER
    assert mean_angle(normals[AT_BORDER], wanted[AT_BORDER]) < 2.5 * mean_angle(normals[inside], wanted[inside])


def test_a_spike_at_a_border_is_taken_away() -> None:
    """Vertices on the border of a plane that are off by an edge are found, and all are put back on it, to rounding."""
    spikes = np.flatnonzero(BORDER)[3::9]
    points = FLAT.copy()
    points[spikes, 2] += 1.0
    found, outlying = replace_outlying(points, FACES)
    assert outlying[spikes].all()
    assert np.abs(found[:, 2]).max() < 1e-9


@pytest.mark.parametrize("outliers", ["replace", "only"])
def test_a_fixed_border_keeps_its_spikes(outliers: Outliers) -> None:
    """Outliers at a border that is to stay keep every bit, those inside go; a border that may move loses them as well."""
    sheet, faces = irregular_grid(30, 33)
    border = border_vertices(faces, len(sheet))
    spikes = sheet.copy()
    spikes[::29] += np.array([0.5, 0.4, 1.0]) * np.ptp(sheet[:, 0]) / 30
    at = np.arange(len(sheet)) % 29 == 0
    for policy in BORDER_POLICIES:
        found = denoised(spikes, faces, outliers=outliers, border=policy)
        gone = np.abs(found - sheet)[:, 2] < 0.5 * np.abs(spikes - sheet)[:, 2]
        assert gone[at & ~border].mean() > 0.9
        if policy == "fixed":
            np.testing.assert_array_equal(found[border], spikes[border])
        else:
            assert gone[at & border].mean() > 0.5


def test_an_outline_goes_along_the_surface_as_far_as_the_others() -> None:
    """An outline that Taubin's steps move twice as far as the others keeps a quarter of its way; one as far as they all of it."""
    outline = np.arange(len(FLAT)) < 100
    for far, share in ((2.0, 0.25), (1.0, 1.0), (0.5, 1.0)):
        way = np.zeros_like(FLAT)
        way[:, 0], way[:, 2] = np.where(outline, far, 1.0), 0.3
        found = outline_kept(FLAT, FLAT + way, UP, outline)
        assert np.allclose((found - FLAT)[outline], [far * share, 0.0, 0.3])
        assert np.array_equal(found[~outline], (FLAT + way)[~outline])


def test_a_jagged_outline_stays_and_a_noisy_one_is_smoothed() -> None:
    """Of a plane without noise, its border jagged, the border moves less than a fifth of Taubin's way; with noise nearly all."""
    flat = FLAT - FLAT.mean(axis=0)
    faces = FACES[np.linalg.norm(flat[FACES].mean(axis=1), axis=1) < 11.0]
    even = np.round(flat)  # the regular grid that the irregular one was made of
    outline = border_vertices(faces, len(flat))
    noisy = flat + 0.3 * np.random.default_rng(1).normal(size=flat.shape)
    shares = []
    for points, triangles, rim in ((even, faces, outline), (noisy, FACES, BORDER)):
        fair = taubin_fairing(points, triangles, iterations=5)
        found = relaxed(points, triangles, iterations=5, direction="all", border="along", movable=None)
        shares.append(np.linalg.norm((found - points)[rim]) / np.linalg.norm((fair - points)[rim]))
        assert np.array_equal(found[~rim], fair[~rim])
    assert shares[0] < 0.2
    assert shares[1] > 0.8
