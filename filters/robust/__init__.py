"""M-estimators and the robust statistics made of them."""

from .m_estimators import KERNEL_CODES, KERNEL_NAMES, REDESCENDING, KernelName, kernel_code, kernel_weight, weight
from .statistics import MAD_TO_DEVIATION, SIGMA_IN_DEVIATIONS, mad_scale, robust_line, robust_mean

__all__ = [
    "KERNEL_CODES",
    "KERNEL_NAMES",
    "MAD_TO_DEVIATION",
    "REDESCENDING",
    "SIGMA_IN_DEVIATIONS",
    "KernelName",
    "kernel_code",
    "kernel_weight",
    "mad_scale",
    "robust_line",
    "robust_mean",
    "weight",
]
