"""Manifold harmonics: transform, inverse, filter, save and load."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.spectral.harmonics import ManifoldHarmonics, manifold_harmonics
from tests.meshes import AWKWARD, book, diagonal, icosphere, noisy, torus, two_spheres


@pytest.fixture(scope="module")
def ball() -> ManifoldHarmonics:
    """100 modes of a noisy sphere of 642 vertices."""
    return manifold_harmonics(*noisy(icosphere(3), 0.02), count=100)


@pytest.mark.slow
def test_all_modes_rebuild_the_mesh() -> None:
    """The inverse of the transform by all modes gives back a mesh of 2,000 vertices to 1e-9 of its diagonal."""
    vertices, faces = noisy(torus(50, 40), 0.01)
    harmonics = manifold_harmonics(vertices, faces, count=len(vertices))
    assert harmonics.modes.shape == (2000, 2000)
    assert np.abs(harmonics.inverse(harmonics.transform(vertices)) - vertices).max() < 1e-9 * diagonal(vertices)


def test_transform_finds_the_coefficients_of_a_sum_of_modes(ball: ManifoldHarmonics) -> None:
    """V^T M V = I: the transform undoes the inverse, for one function and for several; fewer coefficients are the first."""
    for shape in ((100,), (100, 3)):
        coefficients = np.random.default_rng(0).normal(size=shape)
        np.testing.assert_allclose(ball.transform(ball.inverse(coefficients)), coefficients, atol=1e-12)
    np.testing.assert_allclose(ball.inverse(np.eye(100)[:7, 6]), ball.modes[:, 6], rtol=1e-14)


def test_frequencies_are_roots_of_eigenvalues() -> None:
    """On a sphere of radius 2 the first frequency above 0 is sqrt(2) / 2, and the coordinates are its modes: wavelength 8.9."""
    vertices, faces = icosphere(4, 2.0)
    harmonics = manifold_harmonics(vertices, faces, count=9)
    np.testing.assert_allclose(harmonics.frequencies[1:4], np.sqrt(2.0) / 2.0, rtol=2e-3)
    energy = harmonics.transform(vertices) ** 2
    assert energy[1:4].sum() > 0.9999 * energy.sum()


@pytest.mark.parametrize("rest", ["keep", "drop"])
def test_filter_multiplies_modes_and_treats_the_rest(ball: ManifoldHarmonics, rest: Any) -> None:
    """Every coefficient is multiplied by the response; what modes do not span is kept or dropped, and 1 changes nothing."""
    values = np.random.default_rng(0).normal(size=(642, 3))
    made = ball.filter(values, lambda omega: 1.0 / (1.0 + omega), rest=rest)
    factors = 1.0 / (1.0 + ball.frequencies)
    np.testing.assert_allclose(ball.transform(made), factors[:, None] * ball.transform(values), atol=1e-12)
    outside = values - ball.inverse(ball.transform(values))
    left = made - ball.inverse(ball.transform(made))
    np.testing.assert_allclose(left, outside if rest == "keep" else 0.0 * outside, atol=1e-12)
    same = ball.filter(values[:, 0], np.ones_like, rest=rest)
    np.testing.assert_allclose(same, values[:, 0] - (0.0 if rest == "keep" else outside[:, 0]), atol=1e-12)


def test_vertices_of_no_surface_are_left_alone() -> None:
    """Modes are 0 at unreferenced vertices, and a filter gives their values back to the bit."""
    vertices, faces = AWKWARD["isolated vertices"]()
    harmonics = manifold_harmonics(vertices, faces, count=10)
    assert (harmonics.modes[[0, -1]] == 0.0).all()
    assert (harmonics.mass[[0, -1]] == 0.0).all()
    for rest in ("keep", "drop"):
        made = harmonics.filter(vertices, np.zeros_like, rest=rest)
        np.testing.assert_array_equal(made[[0, -1]], vertices[[0, -1]])


def test_every_component_keeps_its_centroid() -> None:
    """Dropping all but the constant modes collapses each of two spheres onto its own centre; a book has modes, too."""
    vertices, faces = two_spheres()
    harmonics = manifold_harmonics(vertices, faces, count=2)
    made = harmonics.filter(vertices, np.ones_like)
    np.testing.assert_allclose(made, np.repeat([[0.0, 0, 0], [5.0, 0, 0]], len(vertices) // 2, axis=0), atol=1e-12)
    assert manifold_harmonics(*book(), count=3).modes.shape == (5, 3)


def test_a_saved_object_comes_back_to_the_bit(ball: ManifoldHarmonics, tmp_path: Path) -> None:
    """All arrays, from a file without pickles that may have any name."""
    for name in ("modes.npz", "modes"):
        ball.save(tmp_path / name)
        again = ManifoldHarmonics.load(tmp_path / name)
        for field in ("modes", "eigenvalues", "mass"):
            np.testing.assert_array_equal(getattr(again, field), getattr(ball, field))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["modes", "modes.npz"]


def test_a_save_that_fails_leaves_the_old_file(ball: ManifoldHarmonics, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupted in the middle of writing, the former file is whole and nothing else is left."""
    target = tmp_path / "modes.npz"
    target.write_bytes(b"former")

    def full(file: Any, **_: Any) -> None:
        file.write(b"half")
        raise OSError("no space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="no space"):
        ball.save(target)
    assert target.read_bytes() == b"former"
    assert list(tmp_path.iterdir()) == [target]


def test_other_files_are_refused(ball: ManifoldHarmonics, tmp_path: Path) -> None:
    """Text, an archive of other arrays, a pickle, half a file: the message names the file."""
    ball.save(tmp_path / "whole.npz")
    whole = (tmp_path / "whole.npz").read_bytes()
    (tmp_path / "text.npz").write_text("modes")
    (tmp_path / "half.npz").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "empty.npz").write_bytes(b"")
    np.savez(tmp_path / "other.npz", a=np.ones(3))
    np.savez(tmp_path / "objects.npz", format=np.array(["x", {}], dtype=object))
    np.save(tmp_path / "array.npy", np.ones(3))
    misfit = {"modes": np.ones((3, 2)), "eigenvalues": np.ones(3), "mass": np.ones(3)}
    np.savez(tmp_path / "misfit.npz", format="manifold harmonics 1", **misfit)  # type: ignore[arg-type]
    for name in ("text.npz", "half.npz", "empty.npz", "other.npz", "objects.npz", "array.npy", "misfit.npz"):
        with pytest.raises(FilterInputError, match=name):
            ManifoldHarmonics.load(tmp_path / name)


def test_wrong_shapes_are_refused(ball: ManifoldHarmonics) -> None:
    """Values for other vertices, more coefficients than modes, a response of the wrong length, an unknown rest."""
    with pytest.raises(FilterInputError, match="642 vertices"):
        ball.transform(np.ones(641))
    with pytest.raises(FilterInputError, match="at most 100 modes"):
        ball.inverse(np.ones(101))
    with pytest.raises(FilterInputError, match="100 finite factors"):
        ball.filter(np.ones(642), lambda _: np.ones(3))
    with pytest.raises(FilterInputError, match="'keep', 'drop'"):
        ball.filter(np.ones(642), np.ones_like, rest="lose")  # type: ignore[arg-type]
