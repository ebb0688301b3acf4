"""Chooses a smoother and its amount for a scan, by prediction of held-out vertices or points and by estimated risk."""

from .clouds import Projection, chosen_projection
from .smoothers import DETAIL_SIZES, PASSES, SMOOTHERS, Smoother, Smoothing, chosen_amount, compare_smoothers

__all__ = [
    "DETAIL_SIZES",
    "PASSES",
    "SMOOTHERS",
    "Projection",
    "Smoother",
    "Smoothing",
    "chosen_amount",
    "chosen_projection",
    "compare_smoothers",
]
