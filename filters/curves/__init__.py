"""Smoothing of polylines."""

from .curve_smoothing import CURVE_BORDERS, CURVE_METHODS, CURVE_WEIGHTS, CurveBorder, CurveMethod, CurveWeights, curve_smoothing

__all__ = [
    "CURVE_BORDERS",
    "CURVE_METHODS",
    "CURVE_WEIGHTS",
    "CurveBorder",
    "CurveMethod",
    "CurveWeights",
    "curve_smoothing",
]
