"""Which smoother suits a scan, and how much of it: by vertices or points that it has not seen."""

from .amounts import DETAIL_SIZES, PASSES, Smoother, chosen_amount
from .clouds import Projection, chosen_projection
from .smoothers import SMOOTHERS, Smoothing, compare_smoothers

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
