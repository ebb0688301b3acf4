"""The transfer functions of spectral filters."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.spectral.problem import ORDERS, RESPONSES, Response, band_pass, enhance, low_pass

OMEGA = np.linspace(0.0, 50.0, 5001)


@pytest.mark.parametrize("order", ORDERS)
def test_low_pass_halves_the_detail_size(order: int) -> None:
    """F(2 pi / detail_size) is 1/2 to rounding, whatever the order."""
    response = low_pass(0.7, order=order)
    assert response(np.array([2.0 * math.pi / 0.7]))[0] == pytest.approx(0.5, abs=1e-15 * order)


def test_low_pass_falls_from_one_to_nothing() -> None:
    """F falls from 1 at 0 to 0, never rises, and is below a tolerance beyond `last_frequency`."""
    response = low_pass(1.0)
    values = response(OMEGA)
    assert values[0] == 1.0
    assert (np.diff(values) <= 0.0).all()
    assert response(np.array([np.inf]))[0] == 0.0
    last = response.last_frequency(1e-6)
    assert response(np.array([last]))[0] == pytest.approx(1e-6, rel=1e-9)
    assert last / (2.0 * math.pi) == pytest.approx(2.113, abs=1e-3)


def test_higher_orders_are_steeper() -> None:
    """At the cutoff the slope of F is -n ln 2 / omega_c: twice the order, twice as steep."""
    step = 1e-6
    around = 2.0 * math.pi * np.array([1.0 - step, 1.0 + step])
    for order in (1, 2, 4):
        below, above = low_pass(1.0, order=order)(around)
        assert (above - below) / (2.0 * step) == pytest.approx(-order * math.log(2.0), rel=1e-6)


def test_a_band_is_the_difference_of_two_low_passes() -> None:
    """Band pass plus the low pass of its long end is the low pass of its short end, except for the mean, which it keeps."""
    band, short, long = band_pass(0.5, 2.0), low_pass(0.5), low_pass(2.0)
    np.testing.assert_allclose(band.profile(OMEGA) + long(OMEGA), short(OMEGA), atol=1e-15)
    assert band(np.zeros(1))[0] == 1.0
    assert band.profile(np.zeros(1))[0] == 0.0
    ends = band(2.0 * math.pi / np.array([0.5, 2.0]))
    np.testing.assert_allclose(ends, 0.5, atol=0.003)


def test_enhance_keeps_long_and_short_waves() -> None:
    """1 for the longest and the shortest waves, near the gain in the middle of a wide band, no change at a gain of 1."""
    response = enhance(0.1, 10.0, gain=3.0)
    assert response(np.zeros(1))[0] == 1.0
    assert response.profile(np.zeros(1))[0] == pytest.approx(1.0, abs=1e-15)
    assert response(np.array([1e6]))[0] == 1.0
    assert response(np.array([2.0 * math.pi]))[0] == pytest.approx(3.0, abs=1e-3)
    assert (enhance(0.1, 10.0, gain=1.0)(OMEGA) == 1.0).all()


@pytest.mark.parametrize("name", list(RESPONSES))
def test_a_unit_of_length_changes_nothing(name: str) -> None:
    """A mesh of half the size has twice the frequencies: F is that of half the wavelengths."""
    sizes = (0.5,) if name == "low_pass" else (0.5, 2.0)
    response = {**RESPONSES}[name](*sizes)  # type: ignore[index]
    halved = {**RESPONSES}[name](*(0.5 * size for size in sizes))  # type: ignore[index]
    np.testing.assert_allclose(halved(2.0 * OMEGA), response(OMEGA), rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: low_pass(0.0), "detail_size is 0.0"),
        (lambda: low_pass(math.nan), "detail_size is nan"),
        (lambda: low_pass(1.0, order=0), "order is 0: it must be a whole number from 1 to 8"),
        (lambda: band_pass(2.0, 1.0), "largest_size 1.0 is not above detail_size 2.0"),
        (lambda: enhance(1.0, math.inf), "largest_size is inf"),
        (lambda: enhance(1.0, 2.0, gain=math.inf), "gain is inf"),
    ],
)
def test_wrong_parameters_are_named(call: Callable[[], Response], said: str) -> None:
    """The message names the parameter and its value."""
    with pytest.raises(FilterInputError, match=said):
        call()
