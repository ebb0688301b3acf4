"""Manifold harmonics: the lowest modes of a surface, to be computed once, kept and reused."""

import os
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_choice, check_whole_number
from ..execution import Progress, ignore_progress
from ..libraries import one_blas_thread
from ..mesh import Floats
from .eigenpairs import lowest_eigenpairs
from .problem import SpectralOperator, spectral_problem

_FORMAT = "manifold harmonics 1"


@dataclass(frozen=True, eq=False)
class ManifoldHarmonics:
    """The k lowest modes of a surface of n vertices, orthonormal: V^T M V = I [vallet2008].

    A function f on the surface is a sum of modes, as a sound is one of sines, with the coefficients c = V^T M f. The sum V c of
    the lowest modes only is f after a low pass.

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
        return np.sqrt(np.maximum(self.eigenvalues, 0.0))

    def transform(self, values: ArrayLike) -> Floats:
        """The coefficients V^T M f, (k,) or (k, d), of (n,) or (n, d) values."""
        f = self._of_vertices(values)
        # One thread, for one order of summation.
        with one_blas_thread():
            return np.asarray(self.modes.T @ (f * (self.mass if f.ndim == 1 else self.mass[:, None])))

    def inverse(self, coefficients: ArrayLike) -> Floats:
        """The sum of modes V c, (n,) or (n, d), for (k,) or (k, d) coefficients; for fewer, of the first modes."""
        c = np.asarray(coefficients, dtype=np.float64)
        if c.ndim not in (1, 2) or len(c) > len(self.eigenvalues):
            raise FilterInputError(
                f"coefficients have shape {c.shape}: they are one, or a row, for at most {len(self.eigenvalues)} modes"
            )
        with one_blas_thread():
            return np.asarray(self.modes[:, : len(c)] @ c)

    def filter(
        self, values: ArrayLike, response: Callable[[Floats], Floats], *, rest: Literal["keep", "drop"] = "drop"
    ) -> Floats:
        """Multiplies every mode of the values by the response at its frequency.

        Args:
            values: (n,) or (n, d). Those at vertices that are part of no surface come back as they are.
            response: F, called with (k,) frequencies in radians per mesh unit; returns (k,) factors: 1 keeps, 0 removes.
            rest: the part of the values that the k modes do not span: "keep" leaves it as it is, "drop" removes it.
        """
        check_choice("rest", rest, ("keep", "drop"))
        f = self._of_vertices(values)
        factors = np.asarray(response(self.frequencies), dtype=np.float64)
        if factors.shape != self.eigenvalues.shape or not np.isfinite(factors).all():
            raise FilterInputError(f"the response must give {len(self.eigenvalues)} finite factors, one a mode")
        change = factors - 1.0 if rest == "keep" else factors
        coefficients = self.transform(f)
        made = self.inverse(coefficients * (change if f.ndim == 1 else change[:, None]))
        untouched = self.mass == 0.0
        if rest == "keep":
            made = f + made
        made[untouched] = f[untouched]
        return made

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a .npz file, whole or not at all."""
        target = Path(path)
        part = target.with_name(f".{target.name}.{os.getpid()}.part")
        try:
            with part.open("wb") as file:
                np.savez(file, format=_FORMAT, modes=self.modes, eigenvalues=self.eigenvalues, mass=self.mass)
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> "ManifoldHarmonics":
        """Reads what `save` wrote.

        Raises:
            FilterInputError: not such a file.
        """
        try:
            with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as data:
                if str(data["format"]) != _FORMAT:
                    raise FilterInputError(f"{path} holds {str(data['format'])!r}, not {_FORMAT!r}")
                harmonics = ManifoldHarmonics(data["modes"], data["eigenvalues"], data["mass"])
        except (KeyError, ValueError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:
            if isinstance(error, FilterInputError):
                raise
            raise FilterInputError(f"{path} is no file of manifold harmonics: {error}") from error
        if harmonics.modes.ndim != 2 or harmonics.modes.shape != (*harmonics.mass.shape, *harmonics.eigenvalues.shape):
            raise FilterInputError(f"{path} is damaged: its arrays do not fit together")
        return harmonics

    def _of_vertices(self, values: ArrayLike) -> Floats:
        f = np.asarray(values, dtype=np.float64)
        if f.ndim not in (1, 2) or len(f) != len(self.mass):
            raise FilterInputError(f"values have shape {f.shape}: they are one, or a row, for each of {len(self.mass)} vertices")
        return f


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
    return ManifoldHarmonics(problem.on_mesh(modes), eigenvalues, problem.on_mesh(problem.mass))


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
    last = len(problem.mass) - problem.n_components
    if len(problem.mass) == 0:
        raise FilterInputError(f"mode {mode} does not exist: no triangle of this mesh has an area")
    if mode > last:
        raise FilterInputError(f"mode {mode} does not exist: this mesh has modes 0 to {last}")
    area = float(problem.mass.sum())
    if mode == 0:
        progress(1.0)
        return OneHarmonic(problem.on_mesh(np.ones(len(problem.mass))), 0.0, 1.0, problem.n_components)
    kappa, modes = lowest_eigenpairs(problem, mode, constants=False, progress=progress)
    shape = modes[:, -1]
    component = problem.components[np.abs(shape).argmax()]
    share = float(problem.mass[problem.components == component].sum()) / area
    return OneHarmonic(problem.on_mesh(shape * np.sqrt(area)), float(kappa[-1]), share, problem.n_components)
