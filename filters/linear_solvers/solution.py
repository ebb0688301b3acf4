"""What a solver gives: the solution, how good it is and what gave it."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from ..mesh import Floats

Method: TypeAlias = Literal["jacobi", "multigrid", "cholesky"]


@dataclass(frozen=True, eq=False)
class Solution:
    """The solution of A x = b and how good it is.

    Attributes:
        values: x, of the shape of b.
        error: an estimate of the energy norm sqrt(e^T A e) of the error e, over all columns; not estimated, 0, by "cholesky".
        backward_error: |r| / (|A| |x| + |b|) for r = b - A x, after scaling A to unit diagonal so that large rows hide nothing: x
            solves exactly a system that differs by this share. The largest over the groups of columns solved for together.
        iterations: products with the matrix.
        method: what gave x.
    """

    values: Floats
    error: float
    backward_error: float
    iterations: int
    method: Method
