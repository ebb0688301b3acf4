"""Taubin's pair of steps: the transfer function, what it keeps and what it damps."""

from __future__ import annotations

import math
import re
from typing import get_args

import numpy as np
import pytest
import scipy.sparse.linalg
from hypothesis import given
from hypothesis import strategies as st

from pymeshfair.filters import topology
from pymeshfair.filters.checks import FilterInputError, UnstableStepError
from pymeshfair.filters.diffusion.explicit import (
    TaubinOperator,
    explicit_smoothing,
    largest_stable_step,
    mu_of_pass_band,
    taubin_fairing,
    transfer_function,
)
from pymeshfair.filters.geometry import roughness
from pymeshfair.filters.operators import build_laplacian, uniform_laplacian
from pymeshfair.filters.topology import BORDER_POLICIES, BorderPolicy
from tests.meshes import AWKWARD, diagonal, grid, icosphere, noisy, sample, tetrahedron, torus, tube, volume


def test_the_filter_is_its_transfer_function_in_the_eigenbasis() -> None:
    """Every coefficient of a noisy torus in the eigenbasis of the uniform operator is multiplied by f(k), to rounding."""
    vertices, faces = noisy(torus(12, 8), 0.1)
    laplacian = uniform_laplacian(faces, len(vertices))
    root = np.sqrt(laplacian.mass)
    values, basis = np.linalg.eigh(-laplacian.stiffness.toarray() / np.outer(root, root))
    found = taubin_fairing(vertices, faces, step=0.4, mu=-0.45, iterations=6)
    factors = transfer_function(values, step=0.4, mu=-0.45, iterations=6)
    np.testing.assert_allclose(
        basis.T @ (root[:, None] * found), factors[:, None] * (basis.T @ (root[:, None] * vertices)), atol=1e-12
    )


def test_the_transfer_function_is_that_of_the_paper() -> None:
    """f(0) = 1, f(k_PB) = 1, f(1/step) = 0, and with mu = 0 it is the response of explicit steps."""
    band = 1 / 0.5 + 1 / -0.53
    f = transfer_function([0.0, band, 2.0, 0.3], step=0.5, mu=-0.53, iterations=10)
    np.testing.assert_allclose(f, [1.0, 1.0, 0.0, ((1 - 0.15) * (1 + 0.159)) ** 10], atol=1e-14)
    np.testing.assert_allclose(transfer_function(0.3, step=0.5, mu=0.0, iterations=4), 0.85**4)


def test_a_pass_band_stands_for_mu() -> None:
    """Mu = 1 / (k_PB - 1/step), and a filter given k_PB moves every vertex as one given that mu."""
    mu = mu_of_pass_band(0.1, 0.5)
    assert mu == pytest.approx(-1 / 1.9)
    assert 1 / 0.5 + 1 / mu == pytest.approx(0.1)
    mesh = noisy(icosphere(1), 0.1)
    assert taubin_fairing(*mesh, pass_band=0.1).tobytes() == taubin_fairing(*mesh, mu=mu).tobytes()


def test_a_hundred_steps_keep_the_volume_of_a_sphere_as_predicted() -> None:
    """On 2,562 vertices 100 pairs (0.5, -0.53) change the volume by under 3 %: f(k)^3 with k of the three lowest modes.

    The sphere's coordinates lie in the space of the three lowest modes but for a share eps in the norm of the masses, 2 %, whose
    modes are damped; a relative change of positions by eps changes the volume by 3 eps at most, to first order.
    """
    vertices, faces = icosphere(4)
    laplacian = uniform_laplacian(faces, len(vertices))
    masses = scipy.sparse.diags_array(laplacian.mass)
    start = np.ones(len(vertices))
    values, modes = scipy.sparse.linalg.eigsh(-laplacian.stiffness, M=masses, k=4, sigma=-1e-3, v0=start)
    rest = vertices - modes[:, 1:] @ (modes[:, 1:].T @ (masses @ vertices))
    eps = math.sqrt((masses @ rest**2).sum() / (masses @ vertices**2).sum())
    found = taubin_fairing(vertices, faces, iterations=100)
    change = volume(found, faces) / volume(vertices, faces)
    assert abs(change - 1) < 0.03
    predicted = float(transfer_function(values[1:].mean(), step=0.5, mu=-0.53, iterations=100)) ** 3
    assert change == pytest.approx(predicted, rel=3 * eps)
    # The prediction is far from trivial: the modes of the next degree grow, too, by four times as much.
    assert predicted > 1.02


def test_noise_goes_and_the_shape_stays() -> None:
    """On a noisy sphere the noise in the radius falls to 2/5 and less while the mean radius changes by under 1 %."""
    vertices, faces = noisy(icosphere(4), 0.02)
    radii = [np.linalg.norm(p, axis=1) for p in (vertices, taubin_fairing(vertices, faces, iterations=20))]
    assert radii[1].std() < 0.4 * radii[0].std()
    assert radii[1].mean() == pytest.approx(radii[0].mean(), rel=0.01)


@pytest.mark.parametrize("operator", get_args(TaubinOperator))
@pytest.mark.parametrize("border", BORDER_POLICIES)
def test_it_is_an_explicit_step_and_one_back(operator: TaubinOperator, border: BorderPolicy) -> None:
    """Three pairs are three times p + step L p, then p + mu L p with the weights of the moment, for every policy, with a mask."""
    vertices, faces = noisy(tube(), 0.03)
    movable = np.arange(len(vertices)) % 5 > 0
    found = taubin_fairing(vertices, faces, operator=operator, iterations=3, border=border, movable=movable)
    expected = vertices
    for _ in range(3):
        for step in (0.5, -0.53):
            unit = explicit_smoothing(
                expected,
                faces,
                operator=operator,
                step=1.0,
                iterations=1,
                border=border,
                movable=movable,
            )
            expected = expected + step * (unit - expected)
    np.testing.assert_allclose(found, expected, atol=1e-13)
    assert found[~movable].tobytes() == vertices[~movable].tobytes()


@given(st.floats(1.001, 3.0), st.floats(0.1, 2.0))
def test_the_largest_stable_step_is_where_the_finest_mode_is_turned_over(ratio: float, eigenvalue: float) -> None:
    """At the largest stable step f(k) = -1 for the largest eigenvalue, and no eigenvalue below it comes out below -1."""
    step = largest_stable_step(-ratio, eigenvalue)
    k = np.linspace(0.0, eigenvalue, 101)
    f = transfer_function(k, step=step, mu=-ratio * step, iterations=1)
    assert f[-1] == pytest.approx(-1.0)
    assert f.min() >= -1.0 - 1e-12


def test_a_pair_that_makes_the_finest_detail_grow_is_an_error() -> None:
    """(1, -1.06) is refused with the largest stable step named; a closed mesh, whose spectrum ends at 3/2, allows longer ones."""
    closed, open_mesh = noisy(icosphere(2), 0.05), noisy(grid(), 0.05)
    named = {}
    for name, mesh in (("closed", closed), ("open", open_mesh)):
        with pytest.raises(UnstableStepError, match="makes the finest detail grow: take a step of at most") as caught:
            taubin_fairing(*mesh, step=1.0, mu=-1.06)
        named[name] = caught.value.largest_stable
    assert named["closed"] == pytest.approx(largest_stable_step(-1.06, 1.5))
    assert named["open"] == pytest.approx(largest_stable_step(-1.06, 2.0))
    for name, mesh in (("closed", closed), ("open", open_mesh)):
        step = named[name] * (1 - 1e-9)
        found = taubin_fairing(*mesh, step=step, mu=-1.06 * step, iterations=300)
        assert diagonal(found) < 1.5 * diagonal(mesh[0])


@pytest.mark.parametrize("step", [0.05, 0.25])
def test_a_pass_band_beyond_all_frequencies_is_an_error(step: float) -> None:
    """With a short step and the default mu no detail is damped and all grow: the message gives a mu that damps them."""
    mesh = noisy(icosphere(2), 0.05)
    assert transfer_function(2.0, step=step, mu=-0.53, iterations=1) > 1.0
    with pytest.raises(FilterInputError, match="makes all details grow: take a mu nearer to -step, for example") as caught:
        taubin_fairing(*mesh, step=step)
    example = re.search(r"for example (\S+) \(pass_band=(\S+)\)$", str(caught.value))
    assert example is not None
    assert float(example[1]) == pytest.approx(mu_of_pass_band(float(example[2]), step), rel=1e-3)
    smooth = taubin_fairing(*mesh, step=step, mu=float(example[1]), iterations=1000)
    assert roughness(smooth, mesh[1]) < 1.1 * roughness(*icosphere(2)) < 0.7 * roughness(*mesh)


@pytest.mark.parametrize("operator", get_args(TaubinOperator))
@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_meshes_come_out_finite(name: str, operator: TaubinOperator) -> None:
    """Ten pairs: no NaN, no vertex beyond the diagonal, and what no triangle uses keeps every bit."""
    vertices, faces = AWKWARD[name]()
    unused = ~topology.referenced_vertices(faces, len(vertices))
    found = taubin_fairing(vertices, faces, operator=operator)
    assert np.isfinite(found).all()
    if len(vertices):
        assert np.linalg.norm(found / 2 - vertices / 2, axis=1).max() <= diagonal(vertices / 2)
    assert found[unused].tobytes() == vertices[unused].tobytes()


@pytest.mark.parametrize("name", ["caps", "thin caps", "caps without area", "needles", "edges without length"])
@pytest.mark.parametrize("operator", get_args(TaubinOperator))
def test_slivers_do_not_make_spikes(name: str, operator: TaubinOperator) -> None:
    """On a sphere with sliver triangles, down to height 0, every vertex stays within 1 % of the sphere, as on one without."""
    healthy = np.linalg.norm(taubin_fairing(*icosphere(3), operator=operator), axis=1)
    assert np.abs(healthy - 1).max() < 0.0125
    found = np.linalg.norm(taubin_fairing(*AWKWARD[name](), operator=operator), axis=1)
    # The vertices in the middle of an edge of 0.15 lie 0.003 inside the sphere to begin with.
    assert np.abs(found - 1).max() < 0.0125 + 0.003


def test_a_real_range_map_is_smoothed_where_it_is_used() -> None:
    """face000: all finite, the 667 unreferenced vertices untouched, nothing moved by more than a hundredth of the diagonal."""
    vertices, faces = sample("rangemaps/face000.ply")
    found = taubin_fairing(vertices, faces)
    still = ~topology.referenced_vertices(faces, len(vertices))
    assert found[still].tobytes() == vertices[still].tobytes()
    assert 0 < np.abs(found - vertices).max() < 0.01 * diagonal(vertices)


def test_progress_is_told_after_every_pair() -> None:
    """Four pairs report four times."""
    told: list[float] = []
    taubin_fairing(*icosphere(1), iterations=4, progress=told.append)
    assert told == [0.25, 0.5, 0.75, 1.0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"operator": "robust"}, "operator 'robust' is not one of 'uniform', 'inverse_length', 'cotangent'"),
        ({"step": 0.0}, "step is 0.0: it must be finite and above 0"),
        ({"step": float("nan")}, "step is nan: it must be finite and above 0"),
        ({"mu": -0.5}, "mu is -0.5: it must be below -step, -0.5, as the step back is the longer one, for example -0.53"),
        ({"mu": 0.53}, "mu is 0.53: it must be below -step"),
        ({"mu": float("nan")}, "mu is nan: it must be below -step"),
        ({"pass_band": 0.0}, "pass_band is 0.0: it must be above 0, below 1/step = 2"),
        ({"pass_band": 2.0}, "pass_band is 2.0: it must be above 0"),
        ({"pass_band": float("nan")}, "pass_band is nan: it must be above 0"),
        ({"iterations": -3}, "iterations is -3"),
        ({"border": "loose"}, "border 'loose' is not one of"),
    ],
)
def test_parameters_are_checked(options: dict[str, object], message: str) -> None:
    """What is out of range is an error that names the parameter, the value and what is allowed."""
    with pytest.raises(FilterInputError, match=message):
        taubin_fairing(*tetrahedron(), **options)  # type: ignore[arg-type]


def test_weights_that_depend_on_the_shape_are_computed_for_every_step() -> None:
    """Two pairs of cotangent steps are not two pairs with the matrix of the input."""
    mesh = noisy(icosphere(1), 0.1)
    matrix = build_laplacian(*mesh, "cotangent").matrix()
    frozen = mesh[0]
    for step in (0.5, -0.53) * 2:
        frozen = frozen + step * (matrix @ frozen)
    assert np.abs(taubin_fairing(*mesh, operator="cotangent", iterations=2) - frozen).max() > 1e-3
