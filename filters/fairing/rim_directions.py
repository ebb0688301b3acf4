"""Whether the parts behind two rims are turned alike: both the right way out, or both inside out."""

from typing import Literal, TypeAlias

import numpy as np

from ..mesh import Floats

Directions: TypeAlias = Literal["agree", "unclear", "disagree"]

# One way is clear when the neck bends less than this share of what it does the other way.
_CLEARLY = 0.5
# Rims nearer than this many of their mean radii are too wide for the line between their centres to say where a neck goes; then
# their planes decide, if the cosine between these is beyond the second.
_NEAR, _PARALLEL = 1.0, 0.7


def rim_directions(first: Floats, second: Floats) -> Directions:
    """Compares the necks there would be with the parts as they are, and with one of them turned over.

    The area vector of a rim, in the direction of the faces that would close it, points out of the part if that is the right way
    out, and into it otherwise. A neck leaves one part along it, and enters the other against it. Its axis is taken as the cubic
    between the centres, a unit apart, with these unit tangents s and t: of the chord d it bends by
    |s - d|^2 + (s - d) . (t - d) + |t - d|^2, a fourth of the integral of its squared second derivative.

    Args:
        first: (a, 3) the vertices of one rim, in the direction of the faces that would close it.
        second: (b, 3) those of the other.

    Returns:
        "agree": as they are, or both turned over, the neck bends less than half as much as with one of them turned over.
        "disagree": more than twice as much. "unclear": neither, or a rim without a plane.
    """
    centre = first.mean(axis=0)
    extent = float(max(np.abs(first - centre).max(), np.abs(second - centre).max()))
    if extent == 0.0:
        return "unclear"
    loops = (first - centre) / extent, (second - centre) / extent
    areas = [_area_vector(loop) for loop in loops]
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


def _area_vector(loop: Floats) -> Floats:
    """Half the sum of the cross products of neighbours: the area times the normal of a plane loop."""
    about = loop - loop.mean(axis=0)
    return np.asarray(0.5 * np.cross(about, np.roll(about, -1, axis=0)).sum(axis=0))
