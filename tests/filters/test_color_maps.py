"""Colour maps."""

from __future__ import annotations

import numpy as np

from pymeshfair.filters.inspection import (
    Limits,
    diverging_colors,
    robust_limits,
    sequential_colors,
    symmetric_limits,
)

#: what is left of red, green and blue light to those who lack the cones for green [machado2009], and for red
BLINDNESS = {
    "deuteranopia": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    "protanopia": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
}


def lightness(colors: np.ndarray) -> np.ndarray:
    """CIE L* of gamma-coded colours."""
    linear = np.where(colors[:, :3] <= 0.04045, colors[:, :3] / 12.92, ((colors[:, :3] + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    return np.asarray(116 * np.cbrt(luminance) - 16)


def test_sequential_map_grows_lighter_all_the_way() -> None:
    """Every step is lighter than the one before, so that the map can be read in grey."""
    values = np.linspace(0, 1, 256)
    assert (np.diff(lightness(sequential_colors(values, Limits(0, 1)))) > 0).all()


def test_diverging_map_is_lightest_and_colourless_in_the_middle() -> None:
    """From the middle of the limits both ways it grows darker, and the middle has hardly any colour."""
    values = np.linspace(-1, 1, 257)
    colors = diverging_colors(values, Limits(-1, 1))
    light = lightness(colors)
    assert light.argmax() == 128
    assert (np.diff(light[:129]) > 0).all()
    assert (np.diff(light[128:]) < 0).all()
    assert np.ptp(colors[128, :3]) < 0.01


def test_signs_can_be_told_apart_without_red_or_green() -> None:
    """To the colour-blind, x and -x differ clearly in blue against red and green, from a fifth of the limit on."""
    for matrix in BLINDNESS.values():
        for x in (0.2, 0.5, 1.0):
            low, high = diverging_colors(np.array([-x, x]), Limits(-1, 1))[:, :3] @ matrix.T
            assert (low[2] - low[0]) - (high[2] - high[0]) > 0.2


def test_limits_leave_out_the_wild_ones() -> None:
    """One value in a thousand that is a million times as large does not change the limits by more than the others spread."""
    values = np.linspace(-1.0, 1.0, 1001)
    wild = np.append(values, 1e6)
    assert abs(symmetric_limits(wild).high - 0.98) < 0.01
    assert np.allclose(robust_limits(wild), robust_limits(values), atol=0.01)


def test_limits_of_hardly_anything() -> None:
    """Zeros, a single spike among them, nothing and no numbers have limits, too; colours are finite."""
    for values in (np.zeros(5), np.array([0.0] * 99 + [3.0]), np.empty(0), np.full(3, np.nan), np.array([-1e308, 1e308])):
        for limits, colors in ((symmetric_limits(values), diverging_colors), (robust_limits(values), sequential_colors)):
            assert np.isfinite(limits).all()
            assert limits.low <= limits.high
            assert np.isfinite(colors(values, limits)).all()
    assert symmetric_limits(np.array([0.0] * 99 + [3.0])) == (-3.0, 3.0)
    assert robust_limits(np.array([0.0] * 999 + [3.0])) == (0.0, 3.0)
