"""The cache of compiled kernels, and a notice when one is compiled."""

from .kernel_cache import ensure_kernel_cache, on_first_compilation

__all__ = [
    "ensure_kernel_cache",
    "on_first_compilation",
]
