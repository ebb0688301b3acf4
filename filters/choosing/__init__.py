"""Which smoother suits a scan, and how much of it: by vertices that it has not seen."""

from .amounts import DETAIL_SIZES, PASSES, Smoother, chosen_amount
from .smoothers import SMOOTHERS, Smoothing, compare_smoothers

__all__ = ["DETAIL_SIZES", "PASSES", "SMOOTHERS", "Smoother", "Smoothing", "chosen_amount", "compare_smoothers"]
