"""Libraries, each imported when it is first used: together they take half a second, and no filter uses them all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import cholespy
    import robust_laplacian
    import threadpoolctl
    from scipy import fft, linalg, optimize, sparse, spatial, special
    from scipy.linalg import blas
else:
    from .imported_when_used import ImportedWhenUsed

    blas = ImportedWhenUsed("scipy.linalg.blas")
    cholespy = ImportedWhenUsed("cholespy")
    fft = ImportedWhenUsed("scipy.fft")
    linalg = ImportedWhenUsed("scipy.linalg")
    optimize = ImportedWhenUsed("scipy.optimize")
    robust_laplacian = ImportedWhenUsed("robust_laplacian")
    sparse = ImportedWhenUsed("scipy.sparse")
    spatial = ImportedWhenUsed("scipy.spatial")
    special = ImportedWhenUsed("scipy.special")
    threadpoolctl = ImportedWhenUsed("threadpoolctl")


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """A context in which matrix products take one thread: with several their bits depend on how many there are."""
    blas.dgemm  # noqa: B018 - loads scipy's library, which the limit would miss if it were loaded later
    with threadpoolctl.threadpool_limits(limits=1, user_api="blas"):
        yield


__all__ = [
    "blas",
    "cholespy",
    "fft",
    "linalg",
    "one_blas_thread",
    "optimize",
    "robust_laplacian",
    "sparse",
    "spatial",
    "special",
    "threadpoolctl",
]
