"""From where meshes are seen: one parallel projection for all of them, so that lengths can be read off a picture."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..declaration import Floats, nearest
from ..errors import ParameterError
from ..filters.mesh import bounding_box

#: azimuth and elevation in degrees of each view that has a name
VIEWS = {
    "front": (0.0, 0.0),
    "back": (180.0, 0.0),
    "right": (90.0, 0.0),
    "left": (-90.0, 0.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
    "iso": (35.0, 25.0),
}
#: the share of a picture that is left free on every side
_MARGIN = 0.03


@dataclass(frozen=True)
class Camera:
    """A parallel projection."""

    rows: Floats  # (3, 3) the directions to the right, upwards and to the eye
    centre: Floats  # (3,) the point of space that is in the middle of the picture
    width: float  # of the window, in mesh units
    height: float  # of the window, in mesh units

    def screen(self, vertices: Floats, columns: int, rows: int) -> Floats:
        """(n, 3) pixels from the left, pixels from the top, and nearness in mesh units, in a picture of columns x rows pixels."""
        scale = np.array([columns / self.width, -rows / self.height, 1.0])
        seen = turned(vertices - self.centre, scale[:, None] * self.rows)
        seen += [columns / 2, rows / 2, 0.0]
        return seen


def turned(vectors: Floats, rows: Floats) -> Floats:
    """(n, 3) vectors in the directions of the rows; for so few columns faster than a product of matrices."""
    return np.asarray(np.einsum("ij,kj->ik", vectors, rows))


def view_angles(text: str) -> tuple[float, float]:
    """Azimuth and elevation in degrees of ``"front"``, ``"iso"`` ... or ``"AZ,EL"``."""
    if text in VIEWS:
        return VIEWS[text]
    try:
        azimuth, elevation = (float(part) for part in text.split(","))
    except ValueError:
        near = nearest(text, VIEWS)
        hint = f"did you mean {near!r}?" if near else f"it takes {', '.join(VIEWS)} or AZIMUTH,ELEVATION in degrees"
        raise ParameterError(f"{text!r} is no view; {hint}") from None
    if not (math.isfinite(azimuth) and -90.0 <= elevation <= 90.0):
        raise ParameterError(f"{text!r} is no view: the elevation is from -90 to 90 degrees")
    return azimuth, elevation


def view_rows(azimuth: float, elevation: float, up: str = "y") -> Floats:
    """(3, 3) the directions to the right, upwards and to the eye.

    Args:
        azimuth: degrees by which the eye goes to the right round the upright axis; at 0 it looks along -z if y is up, along +y if
            z is up.
        elevation: degrees by which it goes up.
        up: the upright axis, "y" as scanners have it, or "z".
    """
    a, e = math.radians(azimuth), math.radians(elevation)
    eye = np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    right = np.array([math.cos(a), 0.0, -math.sin(a)])
    rows = np.array([right, np.cross(eye, right), eye])
    if up == "y":
        return rows
    if up == "z":
        return np.asarray(rows @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
    raise ParameterError(f"{up!r} is no upright axis: it is y or z")


def fitting_camera(clouds: Sequence[Floats], rows: Floats, aspect: float) -> Camera:
    """The camera in whose window, `aspect` times as wide as high, all finite points of (n, 3) clouds are."""
    # About one of the points, as coordinates far from the origin lose digits when they are turned.
    origin = next(points[0] for points in clouds if len(points))
    ends = [bounding_box(turned(points - origin, rows)) for points in clouds if len(points)]
    low, high = np.min([low for low, _ in ends], axis=0), np.max([high for _, high in ends], axis=0)
    width, height = (high - low)[:2] / (1.0 - 2.0 * _MARGIN)
    height = max(float(height), float(width) / aspect) or 1.0
    return Camera(rows, origin + (low + high) / 2 @ rows, height * aspect, height)


def close_up(point: Floats, size: float, rows: Floats, aspect: float) -> Camera:
    """The camera around a (3,) point; `size` is the shorter side of its window, in mesh units."""
    height = size if aspect >= 1.0 else size / aspect
    return Camera(rows, point, height * aspect, height)
