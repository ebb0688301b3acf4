"""The energy of values against frequency, without modes: Gauss's quadrature by Lanczos's process [golub1969]."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..execution import Progress, ignore_progress
from ..libraries import linalg, sparse
from ..mesh import Floats
from .problem import SpectralProblem

#: The mass that may be added at slivers, as a share of the area.
_ADDED = 1e-4
_FEWEST_STEPS, _MOST_STEPS = 100, 600


def without_stiffest(problem: SpectralProblem) -> SpectralProblem:
    """The problem with more mass at the vertices of the highest S_ii / M_i, at most a ten-thousandth of the area in all.

    Slivers and tiny triangles have modes of far higher frequency than any wave of the surface, for which Lanczos's process would
    take as many more steps. The result bounds kappa up to a factor of about 2.
    """
    diagonal, mass = problem.dirichlet.diagonal(), problem.mass
    ratio = diagonal / mass
    stiffest = np.argsort(-ratio, kind="stable")
    # The bound at which the k stiffest vertices take all that may be added: sum over them of (S_ii / bound - M_i) = added.
    bounds = np.cumsum(diagonal[stiffest]) / (_ADDED * mass.sum() + np.cumsum(mass[stiffest]))
    # It rises with k as long as the next vertex is above it: the highest is that of all vertices above.
    bound = float(bounds.max(initial=0.0))
    if not bound > 0.0:
        return problem
    return replace(problem, mass=np.maximum(problem.mass, diagonal / bound))


def enough_steps(problem: SpectralProblem, kappa: float) -> int:
    """The steps that resolve bands of a third of an octave from kappa on, at most 600.

    The distance between nodes is pi / (2 steps) of the highest frequency: half a band at sqrt(kappa).
    """
    highest = 2.0 * float(np.max(problem.dirichlet.diagonal() / problem.mass))
    wanted = 12.0 * math.sqrt(highest / kappa) if kappa > 0.0 else math.inf
    return int(min(max(wanted, _FEWEST_STEPS), _MOST_STEPS))


def energy_quadrature(
    problem: SpectralProblem, values: Floats, steps: int, *, progress: Progress = ignore_progress
) -> tuple[Floats, Floats]:
    """Nodes kappa and weights w such that sum w f(kappa) = sum over columns of <v, f(M^-1 S) v>_M.

    The process of D = M^-1/2 S M^-1/2 that starts with M^1/2 v gives a tridiagonal matrix whose eigenvalues are the nodes. It is
    exact for polynomials f of degree 2 steps - 1. Its vectors are not orthogonalised again: rounding then repeats nodes and
    divides their weight among them, which does not change the energy of a band.

    Args:
        problem: of n rows.
        values: v, (n, d); columns have nodes of their own.
        steps: how many; more resolve frequencies more finely.
        progress: told the share that is done after each step; may raise to stop.

    Returns:
        (k,) nodes and (k,) weights of all columns; none if all values are 0.
    """
    root = np.sqrt(problem.mass)
    symmetric = sparse.csr_matrix(problem.dirichlet.multiply(1.0 / root[:, None]).multiply(1.0 / root[None, :]))
    start = root[:, None] * values
    norms = np.sqrt(np.einsum("ij,ij->j", start, start))
    present = norms > 0.0
    if not present.any():
        return np.empty(0), np.empty(0)
    now = start[:, present] / norms[present]
    steps = min(steps, len(now))
    diagonal, beside = np.zeros((steps, now.shape[1])), np.zeros((steps, now.shape[1]))
    before, length = np.zeros_like(now), np.zeros(now.shape[1])
    for step in range(steps):
        after = symmetric @ now - length * before
        diagonal[step] = np.einsum("ij,ij->j", after, now)
        after -= diagonal[step] * now
        length = np.sqrt(np.einsum("ij,ij->j", after, after))
        beside[step] = length
        before, now = now, after / np.where(length > 0.0, length, 1.0)
        progress((step + 1) / steps)
    nodes, weights = [], []
    for column, norm in enumerate(norms[present]):
        # An exhausted Krylov space ends with an entry that is pure rounding.
        ends = np.flatnonzero(beside[:, column] <= 1e-14 * np.abs(diagonal[:, column]).max())
        size = int(ends[0]) + 1 if len(ends) else steps
        # The QR iteration: what older versions of scipy take by themselves fails on graded matrices.
        kappa, vectors = linalg.eigh_tridiagonal(diagonal[:size, column], beside[: size - 1, column], lapack_driver="stev")
        nodes.append(np.maximum(kappa, 0.0))
        weights.append((norm * vectors[0]) ** 2)
    return np.concatenate(nodes), np.concatenate(weights)
