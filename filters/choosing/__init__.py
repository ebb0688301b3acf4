"""Which smoother suits a scan, and how much of it: by vertices or points that it has not seen."""

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
