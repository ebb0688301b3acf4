"""One mode of a surface to look at, numbered such that every number above 0 is a wave."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError
from ..execution import Progress, ignore_progress
from ..mesh import Floats
from .eigenpairs import lowest_eigenpairs
from .problem import SpectralOperator, spectral_problem


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
    operator: SpectralOperator = "auto",
    progress: Progress = ignore_progress,
) -> OneHarmonic:
    """Mode 0 is constant on the whole surface, mode k the k-th wave by rising frequency over all components [vallet2008].

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        mode: which one, from 0. Larger has shorter waves.
        operator: see `spectral_problem`.
        progress: told the share that is done; may raise to stop.

    Raises:
        FilterInputError: not a mesh, or no such mode.
        ConvergenceError: the modes cannot be computed.
    """
    if mode != int(mode) or mode < 0:
        raise FilterInputError(f"mode is {mode}: it is a whole number of at least 0")
    problem = spectral_problem(vertices, faces, operator=operator)
    last = len(problem.mass) - problem.n_components
    if len(problem.mass) == 0:
        raise FilterInputError(f"mode {mode} does not exist: no triangle of this mesh has an area")
    if mode > last:
        raise FilterInputError(f"mode {mode} does not exist: this mesh has modes 0 to {last}")
    area = float(problem.mass.sum())
    values = np.zeros(problem.n_vertices)
    if mode == 0:
        values[problem.vertices] = 1.0
        progress(1.0)
        return OneHarmonic(values, 0.0, 1.0, problem.n_components)
    kappa, modes = lowest_eigenpairs(problem, int(mode), constants=False, progress=progress)
    shape = modes[:, -1]
    values[problem.vertices] = shape * np.sqrt(area)
    component = problem.components[np.abs(shape).argmax()]
    share = float(problem.mass[problem.components == component].sum()) / area
    return OneHarmonic(values, float(kappa[-1]), share, problem.n_components)
