"""Whether the parts behind two rims are oriented alike: both the right way out, or both inside out."""

from typing import Literal, TypeAlias

import numpy as np

from ..geometry import area_vector
from ..mesh import Floats

Directions: TypeAlias = Literal["agree", "unclear", "disagree"]

# One orientation is clear if the neck bends less than this share of what it would bend with the other.
_CLEARLY = 0.5
# If the centres are nearer than this many mean radii, the line between them does not give the direction of the neck.
_NEAR = 1.0
# Then the planes of the rims decide, if the cosine of the angle between their normals is beyond this.
_PARALLEL = 0.7


def rim_directions(first: Floats, second: Floats) -> Directions:
    """Compares the neck between the parts as they are with the neck after turning one of them over.

    The area vector of a rim, in the direction of the faces that would close it, points out of a part that is the right way out,
    and into one that is inside out. A neck leaves one part along this vector and enters the other against it. Its axis is taken
    as the cubic between the centres of the rims with these unit tangents s and t, scaled so that the chord d has length 1. The
    bending is |s - d|^2 + (s - d) . (t - d) + |t - d|^2, a fourth of the integral of its squared second derivative.

    Args:
        first: (a, 3) the vertices of one rim, in the direction of the faces that would close it.
        second: (b, 3) those of the other.

    Returns:
        "agree": as they are, or with both turned over, the neck bends less than half as much as with one of them turned over.
        "disagree": more than twice as much. "unclear": neither, or a rim whose area vector is 0.
    """
    centre = first.mean(axis=0)
    extent = float(max(np.abs(first - centre).max(), np.abs(second - centre).max()))
    if extent == 0.0:
        return "unclear"
    loops = (first - centre) / extent, (second - centre) / extent
    areas = [area_vector(loop) for loop in loops]
    sizes = [float(np.linalg.norm(area)) for area in areas]
    if min(sizes) == 0.0:
        return "unclear"
    out, into = areas[0] / sizes[0], -areas[1] / sizes[1]
    chord = loops[1].mean(axis=0) - loops[0].mean(axis=0)
    apart = float(np.linalg.norm(chord))
    if apart <= _NEAR * float(np.sqrt(np.array(sizes) / np.pi).mean()):
        same = float(out @ into)
        return "agree" if same > _PARALLEL else "disagree" if same < -_PARALLEL else "unclear"
    chord /= apart
    alike = min(_bending(out, into, chord), _bending(-out, -into, chord))
    opposite = min(_bending(out, -into, chord), _bending(-out, into, chord))
    if alike <= _CLEARLY * opposite:
        return "agree"
    return "disagree" if opposite <= _CLEARLY * alike else "unclear"


def _bending(start: Floats, end: Floats, chord: Floats) -> float:
    a, b = start - chord, end - chord
    return float(a @ a + a @ b + b @ b)
