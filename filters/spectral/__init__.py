"""Spectral filters: wavelengths of a surface removed, kept or amplified; modes and spectra."""

from .detail_enhancement import EnhancedDetails, enhance_details
from .eigenpairs import lowest_eigenpairs
from .harmonics import OneHarmonic, one_harmonic
from .problem import SpectralProblem, spectral_problem
from .responses import DEFAULT_ORDER, ORDERS, Response, ResponseName, band_pass, enhance, low_pass
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
