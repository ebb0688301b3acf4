"""Faces that a result leaves folded over: heights along normals do not tell of them, though their normals are all wrong."""

from collections.abc import Sequence

import numpy as np

from ..geometry import angles_between, face_normals
from ..mesh import Bools, Floats, Ints

# So large a share of the faces folded over is too much where others have less, though they predict worse.
_FEW = 0.008
#: So large a share is too much where others have less and predict as well.
FEW_AMONG_EQUALS = 0.003
# A vertex that has slid folds faces over, and others around it are off: the mean angle rises by 300 to 1900 degrees times the
# share of the faces folded over. Evening out takes details of a surface: 2 to 4 times the angle that it takes if it is repeated.
# On fourteen shapes with sparse noise it is worth that where these degrees times the share are more than the angle of the
# repetition; 340 to 540 tell the same ones apart.
_DEGREES = 425.0


def facing(points: Floats, faces: Ints, normals: Floats) -> Floats:
    """(m,) the cosines between the normals of the faces and the means of those at their corners; 0 of a face without area.

    Args:
        points: (n, 3) coordinates.
        faces: (m, 3) triangles.
        normals: (n, 3) unit normals of a smoothed copy.
    """
    means = normals[faces].sum(axis=1)
    lengths = np.linalg.norm(means, axis=1)
    return np.asarray(np.einsum("ij,ij->i", face_normals(points, faces), means) / np.where(lengths > 0.0, lengths, 1.0))


def folded_share(points: Floats, faces: Ints, normals: Floats) -> float:
    """The share of the faces that look away from the surface; the arguments are those of `facing`."""
    return float(np.mean(facing(points, faces, normals) < 0.0))


def upright(shares: Sequence[float], few: float = _FEW) -> Bools:
    """(k,) which results leave at most a few of the faces folded over, or no more than twice as many as the best does."""
    return np.asarray(np.asarray(shares) <= max(few, 2.0 * min(shares)))


def folds_cost_more(share: float, evened: Floats, again: Floats, faces: Ints) -> bool:
    """Whether faces folded over add more to the mean angle than evening the vertices out does.

    How far both results are apart does not tell which of them is off. Evening out once more what is even already does: nothing
    that slid is left there, only details are taken.

    Args:
        share: the share of the faces that one result leaves folded over and the other does not.
        evened: (n, 3) the other: vertices evened out.
        again: (n, 3) the same done to it once more.
        faces: (m, 3) triangles.
    """
    angles = np.degrees(angles_between(face_normals(evened, faces), face_normals(again, faces)))
    return _DEGREES * share > float(angles.mean())
