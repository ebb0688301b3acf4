"""M-estimators and the robust statistics made of them."""

from .m_estimators import KERNEL_CODES, KERNEL_NAMES, KernelName, exponential, kernel_code, kernel_weight, psi, rho, weigh, weight
from .statistics import SIGMA_IN_DEVIATIONS, Line, robust_deviation, robust_line, robust_mean

__all__ = [
    "KERNEL_CODES",
    "KERNEL_NAMES",
    "SIGMA_IN_DEVIATIONS",
    "KernelName",
    "Line",
    "exponential",
    "kernel_code",
    "kernel_weight",
    "psi",
    "rho",
    "robust_deviation",
    "robust_line",
    "robust_mean",
    "weigh",
    "weight",
]
