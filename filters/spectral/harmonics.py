"""Manifold harmonics: the lowest modes of a surface, to use again and again."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..mesh import Floats
from ..progress import Progress, ignore_progress
from .eigenpairs import lowest_eigenpairs
from .problem import SpectralOperator, spectral_problem


@dataclass(frozen=True, eq=False)
class ManifoldHarmonics:
    """The k lowest modes of a surface of n vertices, orthonormal: V^T M V = I [vallet2008].

    A function on the surface is a sum of modes as a sound is one of sines: its coefficients are c = V^T M f, its low-pass filtered
    form V c.

    Attributes:
        modes: V, (n, k) float64, a mode a column. 0 at vertices that are part of no surface.
        eigenvalues: kappa, (k,) ascending from 0, in one over squared mesh units.
        mass: the diagonal of M, (n,), the area of each vertex in squared mesh units; 0 at vertices that are part of no surface.
    """

    modes: Floats
    eigenvalues: Floats
    mass: Floats

    @property
    def frequencies(self) -> Floats:
        """(k,) sqrt(kappa), in radians per mesh unit; 2 pi / frequency is a wavelength."""
        raise NotImplementedError

    def transform(self, values: ArrayLike) -> Floats:
        """The coefficients V^T M f, (k,) or (k, d), of (n,) or (n, d) values."""
        raise NotImplementedError

    def inverse(self, coefficients: ArrayLike) -> Floats:
        """The sum of modes V c, (n,) or (n, d), for (k,) or (k, d) coefficients; for fewer, of the first modes."""
        raise NotImplementedError

    def filter(
        self, values: ArrayLike, response: Callable[[Floats], Floats], *, rest: Literal["keep", "drop"] = "drop"
    ) -> Floats:
        """Multiplies every mode of the values by the response at its frequency.

        Args:
            values: (n,) or (n, d). Those at vertices that are part of no surface come back as they are.
            response: F, called with (k,) frequencies in radians per mesh unit, giving (k,) factors: 1 keeps, 0 takes out.
            rest: what becomes of the part of the values that the k modes do not span: "keep" leaves it as it is, "drop" takes it
                out.
        """
        raise NotImplementedError

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a .npz file, whole or not at all."""
        raise NotImplementedError

    @staticmethod
    def load(path: str | os.PathLike[str]) -> ManifoldHarmonics:
        """Reads what `save` wrote.

        Raises:
            FilterInputError: not such a file.
        """
        raise NotImplementedError


def manifold_harmonics(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    count: int,
    operator: SpectralOperator = "auto",
    progress: Progress = ignore_progress,
) -> ManifoldHarmonics:
    """The `count` lowest modes of a mesh.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        count: how many modes. More keep finer details; at most as many as there are vertices.
        operator: see `spectral_problem`.
        progress: called several times a second with the share that is done; may raise to stop.

    Raises:
        FilterInputError: not a mesh, or a parameter out of range.
        ConvergenceError: the modes cannot be computed.
    """
    problem = spectral_problem(vertices, faces, operator=operator)
    eigenvalues, modes = lowest_eigenpairs(problem, count, progress=progress)
    spread = np.zeros((problem.n_vertices, len(eigenvalues)), order="F")
    spread[problem.vertices] = modes
    mass = np.zeros(problem.n_vertices)
    mass[problem.vertices] = problem.mass
    return ManifoldHarmonics(spread, eigenvalues, mass)
