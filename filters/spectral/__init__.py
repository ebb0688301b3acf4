"""Spectral filters, which remove, keep or amplify wavelengths of a surface; manifold harmonics; energy spectra."""

from .detail_enhancement import EnhancedDetails, enhance_details
from .eigenpairs import OneHarmonic, lowest_eigenpairs, one_harmonic
from .problem import (
    DEFAULT_ORDER,
    ORDERS,
    Response,
    ResponseName,
    SpectralProblem,
    band_pass,
    enhance,
    low_pass,
    spectral_problem,
)
from .spectral_filter import SpectralMethod, SpectralResult, spectral_filter
from .spectrum import Spectrum, spectrum

__all__ = [
    "DEFAULT_ORDER",
    "ORDERS",
    "EnhancedDetails",
    "OneHarmonic",
    "Response",
    "ResponseName",
    "SpectralMethod",
    "SpectralProblem",
    "SpectralResult",
    "Spectrum",
    "band_pass",
    "enhance",
    "enhance_details",
    "low_pass",
    "lowest_eigenpairs",
    "one_harmonic",
    "spectral_filter",
    "spectral_problem",
    "spectrum",
]
