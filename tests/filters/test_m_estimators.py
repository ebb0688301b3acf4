"""The nine kernels against their closed forms, and the robust estimates against an independent minimisation."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from numpy.typing import NDArray

from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.robust import (
    KERNEL_CODES,
    KERNEL_NAMES,
    SIGMA_IN_DEVIATIONS,
    KernelName,
    exponential,
    kernel_weight,
    psi,
    rho,
    robust_deviation,
    robust_line,
    robust_mean,
    weigh,
    weight,
)

Floats = NDArray[np.float64]

#: the kernels whose psi tends to 0 for large deviations
REDESCENDING = {"truncated_l2", "truncated_l1", "lorentzian", "gaussian", "tukey", "hampel"}
#: the lecture's example: four samples near the line y = x, and a wild one
X = np.arange(1.0, 6.0)
Y = np.array([1.2, 1.9, 3.1, 4.0, 8.5])


def closed_form(name: KernelName, x: float, s: float) -> float:
    """The weight as the tables of the literature print it, for x > 0."""
    inside = x < s
    hampel = 1.0 if x <= s else s / x if x <= 2 * s else s * (4 * s - x) / (2 * s * x) if x < 4 * s else 0.0
    return {
        "l2": 2.0,
        "l1": 1 / x,
        "truncated_l2": 2.0 * inside,
        "truncated_l1": inside / x,
        "huber": 1 / s if inside else 1 / x,
        "lorentzian": 2 / (x**2 + 2 * s**2),
        "gaussian": math.exp(-(x**2) / s**2),
        "tukey": inside * 0.5 * (1 - (x / s) ** 2) ** 2,
        "hampel": hampel,
    }[name]


@njit(cache=False)
def compiled_weights(code: int, x: Floats, sigma: float) -> Floats:
    """What a compiled filter would do."""
    out = np.empty_like(x)
    for i in range(len(x)):
        out[i] = kernel_weight(code, x[i], sigma)
    return out


@pytest.mark.parametrize("sigma", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_weights_are_those_of_the_literature(name: KernelName, sigma: float) -> None:
    """Vectorised and compiled weights agree to the bit, and with the printed formulas to rounding, for both signs."""
    x = np.linspace(0.01, 5 * sigma, 137)
    expected = [closed_form(name, value, sigma) for value in x]
    np.testing.assert_allclose(weight(name, x, sigma), expected, rtol=1e-12, atol=1e-14)
    for signed in (x, -x):
        found = weight(name, signed, sigma)
        assert found.tobytes() == compiled_weights(KERNEL_CODES[name], signed, sigma).tobytes()
        assert found.tobytes() == weight(name, x, sigma).tobytes()


@pytest.mark.parametrize("floor", [0.0, 0.5])
@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_bilateral_weights_are_those_of_the_kernel_and_of_a_gaussian(name: KernelName, floor: float) -> None:
    """For any number of samples in a row, to the rounding of two products; what comes after them is not touched."""
    random = np.random.default_rng(3)
    for count in (0, 1, 3, 4, 16, 37, 100):
        weights, x, distances = random.random((3, 100)) * 3.0
        expected = weights.copy()
        expected[:count] *= (weight(name, np.maximum(x, floor), 1.2) * np.exp(-0.7 * distances))[:count]
        weigh(weights, KERNEL_CODES[name], 1.2, x * x, floor, distances, 0.7, count)
        np.testing.assert_allclose(weights, expected, rtol=1e-14, atol=0)


@given(st.floats(-708.0, 709.0))
def test_the_exponential_is_that_of_the_library(x: float) -> None:
    """To two units of the last digit, one more than what the library itself is allowed."""
    assert exponential(x) == pytest.approx(math.exp(x), rel=2.0**-51, abs=0.0)


def test_the_exponential_ends_where_numbers_do() -> None:
    """1 at 0, and 0 below the exponential of -708, minus infinity included."""
    assert exponential(0.0) == exponential(-0.0) == exponential(-1e-320) == 1.0
    assert exponential(-708.1) == exponential(-1e308) == exponential(-math.inf) == 0.0


@pytest.mark.parametrize("sigma", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_psi_is_the_derivative_of_rho(name: KernelName, sigma: float) -> None:
    """The difference of rho over each interval is the integral of psi, to the tolerance of the quadrature; rho(0) = 0."""
    knots = sigma * np.array([0.01, 0.4, 0.8, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0])  # between the places where psi may jump
    for start, end in itertools.pairwise(knots):
        inside = np.nextafter(start, end), np.nextafter(end, start)
        area, _ = scipy.integrate.quad(lambda x: float(psi(name, x, sigma)), *inside, epsabs=1e-13)
        difference = rho(name, end, sigma) - rho(name, start, sigma)
        assert difference == pytest.approx(area, abs=1e-10), (start, end)
    assert rho(name, 0.0, sigma) == 0.0


@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_rho_rises_and_weights_fall(name: KernelName) -> None:
    """Rho is even and never falls with |x|, the weight never rises and is never negative, psi is odd and x times the weight."""
    x = np.linspace(0.0, 12.0, 2401)
    assert (np.diff(rho(name, x, 2.0)) >= 0).all()
    weights = weight(name, x, 2.0)
    assert (np.diff(weights) <= 1e-15).all()
    assert (weights >= 0).all()
    assert (rho(name, -x, 2.0) == rho(name, x, 2.0)).all()
    assert (psi(name, x, 2.0) == x * weights).all()
    assert (psi(name, -x, 2.0) == -psi(name, x, 2.0)).all()


@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_redescending_kernels_forget_what_is_far(name: KernelName) -> None:
    """Far away psi of a redescending kernel is next to 0; of the others it is at least what it is at sigma."""
    far, near = (float(psi(name, x, 1.0)) for x in (1e6, 1.0))
    assert (far <= 1e-5) if name in REDESCENDING else (far >= near - 1e-12)


@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_weights_at_0_are_finite_and_greatest(name: KernelName) -> None:
    """A sample that fits exactly has a finite weight, no smaller than any other: 1 / |x| is bounded at 1e-6 sigma."""
    at_zero = float(weight(name, 0.0, 0.5))
    assert math.isfinite(at_zero)
    assert at_zero >= weight(name, [1e-9, 1e-3, 0.4], 0.5).max() > 0
    if name in ("l1", "truncated_l1"):
        assert at_zero == pytest.approx(2e6)


def test_the_printed_lorentzian_weight_is_its_psi() -> None:
    """2 x / (x^2 + 2 sigma^2) is the derivative of log(1 + x^2 / (2 sigma^2)), so psi; and it is 0 where a sample fits."""
    x = np.linspace(0.0, 4.0, 9)
    np.testing.assert_allclose(psi("lorentzian", x, 0.7), 2 * x / (x**2 + 2 * 0.7**2), rtol=1e-14)


def test_kernels_keep_the_shape_of_their_argument() -> None:
    """Scalars, matrices and strided arrays are taken element by element."""
    x = np.arange(12.0).reshape(3, 4)[:, ::2]
    assert weight("huber", x, 1.0).shape == (3, 2)
    assert weight("huber", 4.0, 1.0).shape == ()
    assert rho("huber", x, 1.0)[2, 1] == 10.0 - 0.5


def test_wrong_kernels_and_scales_are_refused() -> None:
    """The message names the kernel or the scale and what is allowed."""
    with pytest.raises(FilterInputError, match="kernel 'cauchy' is not one of 'l2', 'l1'"):
        weight("cauchy", 1.0, 1.0)  # type: ignore[arg-type]
    for sigma in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(FilterInputError, match=f"sigma is {sigma}: it must be finite and above 0"):
            rho("huber", 1.0, sigma)


# ------------------------------------------------------------------------------------------------------------------- estimates


@pytest.mark.parametrize("name", KERNEL_NAMES)
def test_a_robust_line_is_a_minimum(name: KernelName) -> None:
    """On the lecture's samples no line that an independent minimisation finds near the result costs less."""
    line = robust_line(X, Y, kernel=name, sigma=0.5)

    def cost(parameters: Floats) -> float:
        return float(rho(name, Y - parameters[0] * X - parameters[1], 0.5).sum())

    options = {"xatol": 1e-10, "fatol": 1e-14, "maxiter": 4000}
    best = scipy.optimize.minimize(cost, [line.slope, line.intercept], method="Nelder-Mead", options=options)
    # 1 / |x| is bounded, so that a minimum of |x| is met within 1e-6 sigma for each sample.
    assert cost(np.array(line)) <= best.fun + (5e-6 if "l1" in name else 1e-12)


def test_the_lecture_example_with_huber() -> None:
    """Huber's line is that of a minimisation from afar (the cost is convex); the wild sample pulls the plain fit up."""
    line = robust_line(X, Y, sigma=0.5)
    best = scipy.optimize.minimize(
        lambda p: float(rho("huber", Y - p[0] * X - p[1], 0.5).sum()),
        [-3.0, 10.0],
        method="Nelder-Mead",
        options={"xatol": 1e-10, "fatol": 1e-14, "maxiter": 4000},
    )
    np.testing.assert_allclose([line.slope, line.intercept], best.x, atol=1e-6)
    np.testing.assert_allclose([line.slope, line.intercept], [1.21, -0.35], atol=1e-9)  # by hand: two residuals at their bound
    np.testing.assert_allclose(robust_line(X, Y, kernel="l2"), [1.67, -1.27], atol=1e-12)
    np.testing.assert_allclose(robust_line(X, Y, kernel="tukey"), [0.96, 0.15], atol=0.01)  # the fit without the wild sample


def test_l2_is_the_mean_and_l1_the_median() -> None:
    """The two classical estimates are those of the two classical norms."""
    samples = np.random.default_rng(0).normal(size=101)
    assert robust_mean(samples, kernel="l2") == pytest.approx(samples.mean(), abs=1e-14)
    assert robust_mean(samples, kernel="l1") == pytest.approx(np.median(samples), abs=1e-6)


@pytest.mark.parametrize("name", [k for k in KERNEL_NAMES if k != "l2"])
def test_outliers_do_not_spoil_a_robust_mean(name: KernelName) -> None:
    """With 20 % of the samples 100 deviations off, the mean stays within half a deviation; the plain one is 20 off."""
    samples = np.random.default_rng(1).normal(size=1000)
    samples[::5] += 100.0
    assert abs(robust_mean(samples, kernel=name)) < 0.5
    assert robust_mean(samples, kernel="l2") > 19.0


@pytest.mark.parametrize("name", ["truncated_l2", "huber", "lorentzian", "gaussian", "tukey"])
def test_the_automatic_scale_is_95_percent_efficient(name: KernelName) -> None:
    """(E psi')^2 / E psi^2 of normal samples is 0.95 at that sigma: psi' by E[x psi], which equals it for normal x (Stein)."""
    x = np.linspace(-12.0, 12.0, 240_001)
    density = np.exp(-(x**2) / 2) / math.sqrt(2 * math.pi) * (x[1] - x[0])
    influence = psi(name, x, SIGMA_IN_DEVIATIONS[name])
    efficiency = float((x * influence * density).sum() ** 2 / (influence**2 * density).sum())
    assert efficiency == pytest.approx(0.95, abs=0.002)


def test_the_robust_deviation_is_that_of_normal_residuals() -> None:
    """Of normal residuals it is the standard deviation, to sampling error; a third of outliers does no more than double it."""
    residuals = np.random.default_rng(2).normal(0.0, 0.25, 100_000)
    assert robust_deviation(residuals) == pytest.approx(0.25, rel=0.01)
    residuals[::3] = 1e9
    assert robust_deviation(residuals) < 2.0 * 0.25  # the 3/4 quantile of the others is their median size times 1.7
    assert robust_deviation(-residuals) == robust_deviation(residuals)


def test_the_robust_deviation_of_mostly_exact_residuals_is_their_mean_size() -> None:
    """Where the median is 0 it says nothing, and the mean of the sizes is taken."""
    assert robust_deviation([0.0, 0.0, 0.0, -1.0]) == 0.25
    assert robust_deviation([0.0]) == 0.0


def test_estimates_move_and_scale_with_the_samples() -> None:
    """Shifting and scaling the samples shifts and scales mean, line and deviation."""
    assert robust_mean(Y * 4 + 7) == pytest.approx(robust_mean(Y) * 4 + 7, abs=1e-11)
    line, moved = robust_line(X, Y), robust_line(X * 2 + 1, Y * 6)
    np.testing.assert_allclose([moved.slope, moved.intercept], [3 * line.slope, 6 * line.intercept - 3 * line.slope], atol=1e-8)
    assert robust_deviation(4 * Y) == 4 * robust_deviation(Y)


@pytest.mark.parametrize("name", KERNEL_NAMES)
@pytest.mark.parametrize("unit", [1e-300, 1e-16, 1e15, 1e300])
def test_estimates_do_not_depend_on_the_unit(name: KernelName, unit: float) -> None:
    """The line does not depend on the unit of x, nor the mean on the unit of the samples, however long or short the unit is."""
    line, found = robust_line(X, Y, kernel=name), robust_line(X * unit, Y, kernel=name)
    np.testing.assert_allclose([found.slope * unit, found.intercept], line, rtol=1e-8)
    assert robust_mean(Y * unit, kernel=name) / unit == pytest.approx(robust_mean(Y, kernel=name), rel=1e-8)


def test_exact_samples_are_met_exactly() -> None:
    """Samples without deviation have no scale, and still a mean and a line."""
    assert robust_mean([2.0, 2.0, 2.0]) == 2.0
    np.testing.assert_allclose(robust_line(X, 3 * X - 1, kernel="tukey"), [3.0, -1.0], atol=1e-12)


def test_samples_that_define_nothing_are_refused() -> None:
    """No samples, values that are not finite, unequal lengths and a vertical line are errors that say so."""
    for call, message in (
        (lambda: robust_mean([]), "x is empty"),
        (lambda: robust_mean([1.0, math.nan]), "x has 1 values that are not finite"),
        (lambda: robust_line([1, 2], [1]), "x has 2 values and y 1"),
        (lambda: robust_line([1, 1], [1, 2]), "all 2 samples are at x = 1"),
        (lambda: robust_mean([1.0, 2.0], sigma=0.0), "sigma is 0.0: it must be finite and above 0"),
    ):
        with pytest.raises(FilterInputError, match=message):
            call()
