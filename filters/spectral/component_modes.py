"""The lowest modes of one connected surface: by slicing its spectrum, or as a dense matrix where that is exact enough."""

from __future__ import annotations

import numpy as np

from ..checks import ConvergenceError
from ..execution import Progress, abandonable
from ..libraries import blas, sparse
from ..linear_solvers import ShiftedFactors, nested_dissection
from ..mesh import Floats
from .columnwise import groups, sparse_product
from .spectrum_slicing import lowest_modes

#: The matrix is dense up to this many vertices, and up to the limit if more than one in `_DENSE_SHARE` modes is asked for.
_DENSE, _DENSE_SHARE, _DENSE_LIMIT = 600, 8, 4000
#: Dense matrices of at most this many rows are solved without a thread of their own.
_AT_ONCE = 200
#: A dense solver is exact to rounding of the highest eigenvalue. If that exceeds this, in the unit in which the first ones are of
#: the order of 1, they drown. Slicing, whose factors are exact row by row, then finds up to one in `_SLICED_SHARE` modes.
_TOO_GRADED, _SLICED_SHARE = 1e10, 2
#: The largest residuals that are accepted as rounding, and the largest deviation of modes from orthonormality.
_LARGEST_FLOOR = 1e-6


def component_modes(
    part: sparse.csr_matrix, area: Floats, count: int, tolerance: float, progress: Progress
) -> tuple[Floats, Floats]:
    """The lowest modes of one component, with the residuals checked, in a unit of area in which the component has 4 pi.

    Args:
        part: S of the component, (n, n).
        area: (n,) the diagonal of its M.
        count: how many, from 1 to n.
        tolerance: see `lowest_eigenpairs`.
        progress: called several times a second; may raise to stop.

    Returns:
        kappa, (count,), and V, (n, count), the first column of which is constant.

    Raises:
        ConvergenceError: the tolerance is not reached.
    """
    unit = area.sum() / (4.0 * np.pi)
    root = np.sqrt(area / unit)
    n = len(root)
    if count == 1:
        return np.zeros(1), np.full((n, 1), 1.0 / np.sqrt(area.sum()), order="F")
    # Symmetric, so that its rows are its columns.
    data = part.data / (np.repeat(root, np.diff(part.indptr)) * root[part.indices])
    operator = sparse.csc_matrix((data, part.indices, part.indptr), shape=part.shape)
    kernel = root / np.linalg.norm(root)
    # The largest sum of a column is a bound of the highest eigenvalue.
    highest = float(np.bincount(part.indices, np.abs(data), n).max())
    dense = n <= _DENSE or (n <= _DENSE_LIMIT and count * _DENSE_SHARE > n)
    sliceable = count * _SLICED_SHARE + 20 <= n
    found = None
    if dense and not (sliceable and highest > _TOO_GRADED):
        found = _by_dense_matrix(operator, kernel, count, progress)
        if sliceable and not found.good(tolerance, 0.0):
            found = None
    if found is None:
        found = _by_slicing(operator, kernel, count, tolerance, highest, progress)
    if not found.good(tolerance, highest):
        raise ConvergenceError(
            f"the {count} lowest modes of a component of {n} vertices cannot be told from rounding: mode "
            f"{int(found.residuals.argmax())} has a residual of {found.residuals.max():.3g} of its eigenvalue, "
            f"{tolerance:.3g} was asked for, and the highest eigenvalue is {highest / found.kappa[1]:.3g} times the first: "
            "triangles differ too much in size or shape; take fewer modes, filter without eigenvectors, or remesh"
        )
    order = np.argsort(found.kappa, kind="stable")
    kappa, vectors = found.kappa[order], found.vectors[:, order]
    random = np.random.default_rng(0).normal(size=n)
    random[:] = np.where(random @ vectors[:, 0] < 0.0, -random, random)
    signs = np.where(random @ vectors < 0.0, -1.0, 1.0)
    vectors *= signs
    vectors /= root[:, None]
    vectors /= np.sqrt(unit)
    return kappa / unit, vectors


class _Checked:
    """Orthonormal vectors, the first of which spans the kernel, with their Rayleigh quotients and what these are off by.

    Attributes:
        vectors: (n, count).
        kappa: (count,) the quotients.
        residuals: (count,) |A x - kappa x| as a share of kappa.
    """

    def __init__(self, operator: sparse.csc_matrix, kernel: Floats, vectors: Floats, progress: Progress) -> None:
        """Measures the vectors, which it may overwrite; the first is set to the kernel."""
        count = vectors.shape[1]
        self.vectors = np.asfortranarray(vectors)
        self.vectors[:, 0] = kernel
        self.kappa, rest = np.empty(count), np.empty(count)
        for group in groups(count, progress, 0.99):
            some = self.vectors[:, group]
            applied = sparse_product(operator, some)
            self.kappa[group] = np.einsum("ij,ij->j", some, applied) / np.einsum("ij,ij->j", some, some)
            rest[group] = np.linalg.norm(applied - some * self.kappa[group], axis=0)
        self.kappa[0] = 0.0
        self.least = max(float(self.kappa[1]), float(np.finfo(float).tiny))
        self.residuals = rest / np.maximum(self.kappa, self.least)
        # V^T V w = w for a random w if V^T V = I.
        weights = np.random.default_rng(1).normal(size=count) / np.sqrt(count)
        again = blas.dgemv(1.0, self.vectors, blas.dgemv(1.0, self.vectors, weights), trans=1)
        self._deviation = float(np.abs(again - weights).max())

    def good(self, tolerance: float, highest: float) -> bool:
        """Whether the residuals are within the tolerance, or within rounding if that is larger, up to a limit."""
        floor = min(4e-15 * highest / self.least, _LARGEST_FLOOR)
        return bool(self.residuals.max() <= max(tolerance, floor) and self._deviation <= _LARGEST_FLOOR)


def _by_dense_matrix(operator: sparse.csc_matrix, kernel: Floats, count: int, progress: Progress) -> _Checked:
    def solved() -> Floats:  # by numpy, since it lets other threads run
        return np.asarray(np.linalg.eigh(operator.toarray())[1])

    progress(0.0)
    vectors = solved() if len(kernel) <= _AT_ONCE else abandonable(solved, progress, 0.5)
    return _Checked(operator, kernel, vectors[:, :count], progress)


def _by_slicing(
    operator: sparse.csc_matrix, kernel: Floats, count: int, tolerance: float, highest: float, progress: Progress
) -> _Checked:
    places = nested_dissection(operator)
    dissected = sparse.csc_matrix(operator[places][:, places])
    _, ordered = lowest_modes(dissected, kernel[places], count, tolerance=tolerance, progress=progress)
    vectors = np.empty_like(ordered)
    vectors[places] = ordered
    found = _Checked(operator, kernel, vectors, progress)
    if not found.good(tolerance, highest):
        # Products at tiny triangles have rounding of high frequencies only, which hardly affects the modes: measure it in the
        # energy norm.
        factors = ShiftedFactors(dissected, -found.least, progress, 0.99)
        for group in groups(count, progress, 0.99):
            some = np.asfortranarray(found.vectors[places, group])
            rest = sparse_product(dissected, some) - some * found.kappa[group]
            energy = np.einsum("ij,ij->j", rest, factors.solve(np.asfortranarray(rest)))
            share = np.sqrt(np.maximum(energy, 0.0) / np.maximum(found.kappa[group], found.least))
            found.residuals[group] = np.minimum(found.residuals[group], share)
    return found
