"""Contests of what is assembled, solved and decomposed: operators, implicit steps, energies, modes."""

from __future__ import annotations

from typing import Any

import igl
import implicit
import numpy as np
import spectral
from scipy import sparse
from scipy.sparse.linalg import splu

from pymeshfair.filters.diffusion import implicit_fairing
from pymeshfair.filters.diffusion.implicit import time_step_of_detail_size
from pymeshfair.filters.fairing import bilaplacian_smoothing
from pymeshfair.filters.fairing.bilaplacian import weight_of_detail_size
from pymeshfair.filters.operators import laplace_beltrami
from pymeshfair.filters.spectral import lowest_eigenpairs, spectral_problem

from .contest import Contest, Floats, Peer, Preparation, Subject, Work

#: A direct solver's time and memory grow faster than the mesh.
_DIRECT = 2e5


def igl_matrices(subject: Subject) -> tuple[sparse.csc_matrix, sparse.csc_matrix]:
    """Libigl's stiffness and mass."""
    mass = igl.massmatrix(subject.vertices, subject.faces, igl.MASSMATRIX_TYPE_VORONOI)
    return igl.cotmatrix(subject.vertices, subject.faces), mass


def matrix_entries(result: Any) -> Floats:
    """The diagonals of stiffness and mass, and the stiffness applied to one fixed vector."""
    stiffness, mass = result if isinstance(result, tuple) else (result.stiffness, sparse.diags_array(result.mass))
    probe = np.random.default_rng(0).normal(size=stiffness.shape[0])
    return np.concatenate([stiffness.diagonal(), mass.diagonal() / mass.diagonal().mean(), stiffness @ probe])


def our_step(edges: float) -> Preparation:
    """An implicit step of (edges mean edges)^2."""
    return lambda s: lambda: implicit_fairing(s.vertices, s.faces, time_step=(edges * s.edge) ** 2)


def igl_step(edges: float) -> Preparation:
    """The same equations by libigl's matrices and scipy's spsolve."""
    return lambda s: lambda: implicit.by_libigl((s.vertices, s.faces), (edges * s.edge) ** 2)


def trimesh_step(subject: Subject) -> Work:
    """A step of 1 of trimesh's umbrella operator: another operator, the same kind of system."""
    return lambda: implicit.by_trimesh((subject.vertices, subject.faces), subject.edge**2)


def pyamg_step(t_of: Any) -> Preparation:
    """The same equations by libigl's matrices and PyAMG's smoothed aggregation, column by column."""

    def prepare(subject: Subject) -> Work:
        import pyamg

        def work() -> Any:
            stiffness, mass = igl_matrices(subject)
            t = t_of(subject)
            levels = pyamg.smoothed_aggregation_solver(sparse.csr_matrix(mass - t * stiffness))
            force = t * (stiffness @ subject.vertices)
            moves = [levels.solve(column, tol=1e-9, maxiter=300, accel="cg") for column in force.T]
            return subject.vertices + np.column_stack(moves)

        return work

    return prepare


def our_detail(edges: float) -> Preparation:
    """An implicit step that halves waves of so many edges."""
    return lambda s: lambda: implicit_fairing(s.vertices, s.faces, time_step=time_step_of_detail_size(edges * s.edge))


def our_energy(subject: Subject) -> Work:
    """The bi-Laplacian energy that halves waves of six edges."""
    return lambda: bilaplacian_smoothing(subject.vertices, subject.faces, detail_size=6.0 * subject.edge)


def igl_energy(subject: Subject) -> Work:
    """The same equations by libigl's matrices and SuperLU, once and without refinement."""

    def work() -> Any:
        stiffness, mass = igl_matrices(subject)
        weight = weight_of_detail_size(6.0 * subject.edge)
        inverse = sparse.diags_array(1.0 / mass.diagonal())
        matrix = sparse.csc_matrix(stiffness.T @ inverse @ stiffness + weight * mass)
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(weight * (mass @ subject.vertices))

    return work


def our_modes(count: int) -> Preparation:
    """The lowest modes from the matrices on."""

    def prepare(subject: Subject) -> Work:
        problem = spectral_problem(subject.vertices, subject.faces)
        return lambda: lowest_eigenpairs(problem, _modes(subject, count))

    return prepare


def their_modes(count: int) -> Preparation:
    """The same by scipy's eigsh about a shift just below 0."""

    def prepare(subject: Subject) -> Work:
        problem = spectral_problem(subject.vertices, subject.faces)
        return lambda: spectral.by_scipy(problem, _modes(subject, count))

    return prepare


def _modes(subject: Subject, count: int) -> int:
    return min(count, len(subject.vertices) // 20)


def frequencies(pairs: Any) -> Floats:
    """The eigenvalues but for the first, which is 0."""
    return np.asarray(pairs[0][1:])


_BY_DIAGONAL = (
    "Products with the matrix, scaled by its diagonal: 110 of them, 1.1 of 1.8 s, for 6 edges at a million. Multigrid takes 2.6 "
    "s for the same, factors more."
)
_MULTIGRID = (
    "Up to 50,000 vertices order and factors. Above, memory: multigrid's cycles read the matrices of all levels some twenty "
    "times, in rows whose columns lie far apart. At 100,000 factors take 0.86 of the time and 1.7 of the memory, which "
    "grows faster."
)

CONTESTS = (
    Contest(
        "cotangent and mass assembly",
        lambda s: lambda: laplace_beltrami(s.vertices, s.faces),
        "The triangles at a vertex: finding them, and a square root and a division for each.",
        {"libigl": Peer(lambda s: lambda: igl_matrices(s), "igl", agrees=1e-9, goal=5.0)},
        traffic=48 + 24 + 7 * 12 + 8,
        result=matrix_entries,
    ),
    *(
        Contest(
            f"implicit step, t of {edges:g} edge{'s' if edges > 1 else ''} squared",
            our_step(edges),
            _BY_DIAGONAL if edges < 3 else _MULTIGRID,
            {
                "libigl, spsolve": Peer(igl_step(edges), "igl", largest=_DIRECT, agrees=1e-8, goal=goal),
                **({"trimesh": Peer(trimesh_step, "trimesh", largest=_DIRECT)} if edges == 1 else {}),
            },
            sizes=(10_000, 100_000),
            orders=("scan",),
        )
        for edges, goal in ((1.0, 10.0), (3.0, 6.0), (10.0, 6.0))
    ),
    *(
        Contest(
            f"implicit step, detail of {edges:g} edge{'s' if edges > 1 else ''}",
            our_detail(edges),
            _BY_DIAGONAL if edges < 12 else _MULTIGRID,
            {
                "libigl, PyAMG": Peer(
                    pyamg_step(lambda s, edges=edges: time_step_of_detail_size(edges * s.edge)), "pyamg", agrees=1e-6
                )
            },
            sizes=(100_000, 1_000_000),
            orders=("scan",),
        )
        for edges in (1.0, 6.0, 20.0, 100.0)
    ),
    Contest(
        "bi-Laplacian energy, detail of 6 edges",
        our_energy,
        "Up to 150,000 vertices factors of half the order of the equations, and two solves for each of ten steps of conjugate "
        "gradients; above, four cycles of multigrid for each step. Factors at a million take 50 s of processor time on one core "
        "and 1.6 GB, against 62 s on all cores and 1.2 GB.",
        {"libigl, splu": Peer(igl_energy, "igl", largest=_DIRECT, agrees=1e-7, goal=5.0)},
        orders=("scan",),
    ),
    *(
        Contest(
            f"{count} lowest modes",
            our_modes(count),
            "Keeping hundreds of long vectors orthogonal, a third of a call, and passes over the factors for every eight of "
            "them, a quarter. Threads on the factors, from 20,000 vertices on, raised the ratio of 100 modes of 100,000 from 2.2 "
            "to 3.",
            {"eigsh": Peer(their_modes(count), "scipy", agrees=1e-7, goal=goal)},
            sizes=(size,),
            orders=("scan",),
            result=frequencies,
        )
        for count, size, goal in ((500, 10_000, 8.0), (100, 100_000, 4.0))
    ),
)
