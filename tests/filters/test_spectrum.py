"""The spectrum of a shape against sums over all its modes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import eigh

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.spectral.problem import spectral_problem
from pymeshfair.filters.spectral.spectrum import Spectrum, energy_quadrature, spectrum
from tests.meshes import AWKWARD, Floats, Mesh, area, icosphere, noisy, sample, torus, two_spheres, with_caps


def all_modes(mesh: Mesh) -> tuple[Floats, Floats]:
    """Frequencies and energies of all modes but the constant one of a connected mesh, by a dense eigensolver."""
    problem = spectral_problem(*mesh)
    kappa, modes = eigh(problem.dirichlet.toarray(), np.diag(problem.mass))
    along = modes.T @ (problem.mass[:, None] * mesh[0])
    return np.sqrt(np.maximum(kappa[1:], 0.0)), (along**2).sum(axis=1)[1:] / problem.mass.sum()


def below(found: Spectrum, index: int) -> float:
    """The energy below a band."""
    return float(found.band_energies[:index].sum())


@pytest.mark.parametrize("modes", [0, 30])
def test_bands_hold_the_energy_of_their_modes(modes: int) -> None:
    """The energy up to each frequency is that of all modes there; a node may fall beside an edge by a sixth of an octave."""
    mesh = noisy(torus(32, 16), 0.03)
    omega, energy = all_modes(mesh)
    found = spectrum(*mesh, modes=modes)
    for index, edge in enumerate(found.band_edges[1:-1], start=1):
        lower, upper = (float(energy[omega <= edge * factor].sum()) for factor in (2 ** (-1 / 6), 2 ** (1 / 6)))
        assert lower * 0.99 <= below(found, index) <= upper * 1.01


@pytest.mark.parametrize("subdivisions", [3, 5])
def test_a_quadrature_of_few_steps_is_exact_for_powers(subdivisions: int) -> None:
    """Six steps give <v, (M^-1 S)^k v>_M up to k = 11, to rounding, on a mesh of one block of rows and on one of three."""
    problem = spectral_problem(*noisy(icosphere(subdivisions), 0.01))
    values = np.random.default_rng(0).normal(size=(len(problem.mass), 3))
    kappa, weights = energy_quadrature(problem, values, 6, progress=lambda _: None)
    assert len(kappa) == len(weights) == 3 * 6
    applied = values
    for power in range(12):
        exact = float((problem.mass[:, None] * values * applied).sum())
        assert float(weights @ kappa**power) == pytest.approx(exact, rel=1e-11)
        applied = (problem.dirichlet @ applied) / problem.mass[:, None]


def test_the_last_band_has_the_shortest_waves_of_equilateral_triangles() -> None:
    """All waves shorter than half an edge are in the band of those that are as long, here beside slivers of next to no area."""
    vertices, faces = with_caps(1e-3)
    edge = math.sqrt(2.0 / math.sqrt(3.0) * area(vertices, faces) / len(vertices))
    edges = spectrum(vertices, faces, modes=0, operator="cotangent").band_edges
    assert edges[-2] <= 2.0 * math.pi / (0.5 * edge) <= edges[-1]


def test_single_modes_are_exact() -> None:
    """Frequencies and energies of the lowest modes are those of the dense eigensolver."""
    mesh = noisy(torus(24, 12), 0.05)
    omega, energy = all_modes(mesh)
    found = spectrum(*mesh, modes=20)
    np.testing.assert_allclose(found.frequencies, omega[:20], rtol=1e-3)  # slivers have a little more mass
    assert found.energies.sum() == pytest.approx(energy[:20].sum(), rel=1e-3)
    np.testing.assert_allclose(found.wavelengths, 2 * math.pi / found.frequencies)


@pytest.mark.parametrize("modes", [0, 1, 10, 10_000])
def test_energies_add_up_to_the_mean_squared_distance(modes: int) -> None:
    """Parseval: for a unit sphere 1, whatever is computed by modes and what by the quadrature."""
    found = spectrum(*icosphere(2), modes=modes)
    assert found.energy == pytest.approx(1.0, rel=1e-12)
    assert found.band_energies.sum() == pytest.approx(1.0, rel=1e-9)


def test_a_sphere_lies_at_its_first_frequency() -> None:
    """Its coordinates are the three modes of l = 1, of frequency sqrt(2) / r and energy r^2 / 3 each."""
    found = spectrum(*icosphere(3, 2.0), modes=3)
    np.testing.assert_allclose(found.frequencies, math.sqrt(2) / 2.0, rtol=0.01)
    np.testing.assert_allclose(found.energies, 4.0 / 3.0, rtol=0.01)
    assert found.area == pytest.approx(16 * math.pi, rel=0.02)


def test_noise_is_seen_at_high_frequencies() -> None:
    """White noise of deviation s has an energy of s^2, shared out evenly among 2,562 modes, on a sphere that has none there.

    Its part along the normals, that is: moved along the surface, vertices give another triangulation of it and no waves. The
    first 100 modes of a unit sphere are below the frequency 10.
    """
    clean, rough = spectrum(*icosphere(4), modes=10), spectrum(*noisy(icosphere(4), 0.01), modes=10)
    assert rough.band_energies[rough.band_edges[:-1] > 10.0].sum() == pytest.approx(1e-4, rel=0.15)
    assert clean.band_energies[clean.band_edges[:-1] > 10.0].sum() < 1e-6


def test_units_scale() -> None:
    """A mesh that is 8 times as large has frequencies of an eighth and 64 times the energy, band by band."""
    vertices, faces = noisy(torus(), 0.03)
    plain, large = spectrum(vertices, faces, modes=10), spectrum(8.0 * vertices, faces, modes=10)
    np.testing.assert_allclose(large.frequencies * 8.0, plain.frequencies, rtol=1e-7)
    np.testing.assert_allclose(large.band_edges * 8.0, plain.band_edges, rtol=1e-12)
    np.testing.assert_allclose(large.band_energies, 64.0 * plain.band_energies, rtol=1e-6)


def test_bands_of_different_meshes_have_the_same_edges() -> None:
    """All are whole powers of 2^(1/3)."""
    for mesh in (icosphere(2), torus(), two_spheres()):
        powers = 3 * np.log2(spectrum(*mesh, modes=5).band_edges)
        np.testing.assert_allclose(powers, np.round(powers), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "name", [n for n in AWKWARD if n not in ("empty", "only faces that name a vertex twice", "all in one point")]
)
def test_awkward_meshes_have_a_finite_spectrum(name: str) -> None:
    """Numbers are finite and add up."""
    found = spectrum(*AWKWARD[name](), modes=5)
    assert np.isfinite(found.band_energies).all()
    assert np.isfinite(found.frequencies).all()
    assert len(found.band_edges) < 100
    assert found.band_energies.sum() == pytest.approx(found.energy, rel=1e-6)


def test_slivers_do_not_blur_the_spectrum() -> None:
    """A torus some of whose triangles are next to nothing has the bands of the torus, within a percent of the energy there."""
    vertices, faces = noisy(torus(48, 24), 0.02)
    a, b, c = vertices[faces[0]]
    added = a + 1e-5 * (b - a) + 1e-6 * (c - a)
    i, j, k = faces[0]
    new = np.array([[i, j, len(vertices)], [j, k, len(vertices)], [k, i, len(vertices)]], dtype=np.int32)
    slim = np.concatenate([vertices, [added]]), np.concatenate([faces[1:], new])
    plain, found = spectrum(vertices, faces, modes=20), spectrum(*slim, modes=20, operator="cotangent")
    edges = [e for e in plain.band_edges[1:-3] if e in found.band_edges]
    assert len(edges) > 5
    for edge in edges:
        one, other = (below(s, int(np.flatnonzero(s.band_edges == edge)[0])) for s in (plain, found))
        assert other == pytest.approx(one, rel=0.02)


def test_the_result_repeats_and_progress_is_told() -> None:
    """Two calls give the same bits; the share rises to 1; an exception of the receiver comes out."""
    mesh = noisy(icosphere(2), 0.02)
    told: list[float] = []
    first, second = spectrum(*mesh, modes=10, progress=told.append), spectrum(*mesh, modes=10)
    assert first.band_energies.tobytes() == second.band_energies.tobytes()
    assert first.energies.tobytes() == second.energies.tobytes()
    assert told[-1] == 1.0
    assert told == sorted(told)

    def stop(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        spectrum(*mesh, modes=0, progress=stop)


@pytest.mark.slow
def test_a_scan_falls_off() -> None:
    """On the bunny the large parts hold nearly all of the energy, a millionth is left at the finest waves."""
    found = spectrum(*sample("bunny.obj"), modes=10)
    assert found.band_energies[:5].sum() > 0.95 * found.energy
    assert found.band_energies[-3] < 1e-6 * found.energy


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"modes": -1}, "modes is -1: it must be a whole number of at least 0"),
        ({"steps": 0}, "steps is 0: it must be a whole number of at least 1"),
        ({"operator": "uniform"}, "operator 'uniform' is not one of"),
    ],
)
def test_parameters_are_checked(options: dict[str, int], message: str) -> None:
    """What is out of range is named."""
    with pytest.raises(FilterInputError, match=message):
        spectrum(*icosphere(1), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "message"), [("empty", "no triangles"), ("all in one point", "no triangle of the mesh has an area")]
)
def test_what_is_no_surface_is_refused(name: str, message: str) -> None:
    """The message says what is missing."""
    with pytest.raises(FilterInputError, match=message):
        spectrum(*AWKWARD[name]())
