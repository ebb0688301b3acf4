"""Reflection lines: the surface as if polished, in a hall of parallel lamps."""

import numpy as np
from numpy.typing import ArrayLike

from ..checks import FilterInputError, check_positive
from ..mesh import Floats

#: The share of a stripe's period over which bright turns into dark.
_SOFTNESS = 0.25


def reflection_stripes(normals: Floats, *, view: ArrayLike, direction: ArrayLike, stripes: float = 8.0) -> Floats:
    """(n,) the brightness of each place of a polished surface, from 0 to 1.

    The lamps are infinitely far and parallel to `direction`, evenly spread round it. The eye is infinitely far in the direction
    `view`. It sees at a normal n the light that comes from r = 2 (n . v) n - v, which lies in a lamp or between two according to
    the angle of r about `direction`. Lines that bend sharply show a jump of the normals, which shading hardly shows; lines that
    are smooth but not evenly spread show curvature that changes.

    Args:
        normals: (n, 3) unit normals; 0 gives 0.5.
        view: (3,) from the surface to the eye.
        direction: (3,) along the lamps.
        stripes: how many lamps there are all round; larger shows smaller defects.

    Raises:
        FilterInputError: a direction without length, or stripes that are not above 0.
    """
    stripes = check_positive("stripes", stripes)
    eye, axis = _unit("view", view), _unit("direction", direction)
    reflected = 2.0 * (normals @ eye)[:, None] * normals - eye
    # Two directions across the lamps; angles are counted from the first.
    first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    angles = np.arctan2(reflected @ second, reflected @ first)
    brightness = 0.5 + 0.5 * np.clip(np.cos(round(stripes) * angles) / _SOFTNESS, -1.0, 1.0)
    brightness[~normals.any(axis=1)] = 0.5
    return np.asarray(brightness)


def _unit(name: str, direction: ArrayLike) -> Floats:
    vector = np.asarray(direction, dtype=np.float64)
    length = float(np.linalg.norm(vector)) if vector.shape == (3,) else np.nan
    if not 0.0 < length < np.inf:
        raise FilterInputError(f"{name} {vector.tolist()} is no direction: it takes three finite numbers, not all of them 0")
    return vector / length
