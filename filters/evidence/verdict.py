"""Which of several settings the held-out vertices speak for."""

from typing import NamedTuple

import numpy as np

from ..mesh import Bools, Floats

#: What is within so many standard errors of the best is as good.
EQUAL = 1.0

# Deviations count up to so many times the least median deviation: outliers are no evidence.
_CLIP = 4.0
# But at least up to this, in mean edges: where most of a mesh is exact planes the median is 0, and would leave no evidence but
# of these planes.
_LEAST = 0.05


class Verdict(NamedTuple):
    """How well k candidates predict, in the unit of the deviations.

    Attributes:
        errors: (k,) the root mean square of the deviations of the held-out vertices, each clipped.
        excess: (k,) the mean of how much the squares exceed those of the best candidate.
        uncertainty: (k,) the standard error of `excess`.
        best: the candidate with the least error.
    """

    errors: Floats
    excess: Floats
    uncertainty: Floats
    best: int

    def within(self, standard_errors: float) -> Bools:
        """(k,) the candidates whose excess is at most that many of its standard errors."""
        return np.asarray(self.excess <= standard_errors * self.uncertainty)


def judge(deviations: Floats) -> Verdict:
    """Judge (k, h) deviations of k candidates at h held-out vertices, in mean edges.

    With m the least of the candidates' median |r|, the squares are q = min(|r|, max(4 m, 0.05))^2. The best candidate b has the
    least mean q; the excess of candidate k is the mean of q_k - q_b, vertex by vertex, and its standard error that of a mean of
    such differences.
    """
    sizes = np.abs(deviations)
    if sizes.shape[1] == 0:
        nothing = np.zeros(len(sizes))
        return Verdict(nothing, nothing, nothing, 0)
    squares = np.minimum(sizes, max(_LEAST, _CLIP * float(np.median(sizes, axis=1).min()))) ** 2
    means = squares.mean(axis=1)
    best = int(means.argmin())
    differences = squares - squares[best]
    uncertainty = differences.std(axis=1) / np.sqrt(sizes.shape[1])
    return Verdict(np.sqrt(means), differences.mean(axis=1), uncertainty, best)
