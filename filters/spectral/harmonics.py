"""Manifold harmonics: one mode of a surface, to look at."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_whole_number
from ..execution import Progress, ignore_progress
from ..mesh import Floats
from ..operators import SurfaceOperatorName
from .eigenpairs import lowest_eigenpairs
from .problem import spectral_problem


@dataclass(frozen=True, eq=False)
class OneHarmonic:
    """A mode, of mean square 1 over the whole surface.

    Attributes:
        values: (n,) at the vertices; 0 on other components and at vertices that are part of no surface.
        eigenvalue: kappa, in one over squared mesh units.
        share_of_area: of the components where it is not 0, in the area of all.
        n_components: how many components the surface has.
    """

    values: Floats
    eigenvalue: float
    share_of_area: float
    n_components: int


def one_harmonic(
    vertices: ArrayLike,
    faces: ArrayLike,
    mode: int,
    *,
    operator: SurfaceOperatorName = "auto",
    progress: Progress = ignore_progress,
) -> OneHarmonic:
    """Mode 0 is constant on the whole surface, mode k the k-th wave by rising frequency over all components [vallet2008].

    Where several waves have one frequency, as on a sphere, a mode is one of their combinations, the same in every run.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        mode: its number, from 0. Larger has shorter waves.
        operator: see `spectral_problem`.
        progress: called with the share that is done; may raise to stop.

    Raises:
        FilterInputError: not a mesh, or no such mode.
        ConvergenceError: the modes cannot be computed.
    """
    mode = check_whole_number("mode", mode)
    problem = spectral_problem(vertices, faces, operator=operator)
    if len(problem.mass) == 0:
        raise FilterInputError(f"mode {mode} does not exist: no triangle of this mesh has an area")
    if mode > problem.n_waves:
        raise FilterInputError(f"mode {mode} does not exist: this mesh has modes 0 to {problem.n_waves}")
    area = float(problem.mass.sum())
    if mode == 0:
        progress(1.0)
        return OneHarmonic(problem.on_mesh(np.ones(len(problem.mass))), 0.0, 1.0, problem.n_components)
    kappa, modes = lowest_eigenpairs(problem, mode, constants=False, progress=progress)
    shape = modes[:, -1]
    component = problem.components[np.abs(shape).argmax()]
    share = float(problem.mass[problem.components == component].sum()) / area
    return OneHarmonic(problem.on_mesh(shape * np.sqrt(area)), float(kappa[-1]), share, problem.n_components)
