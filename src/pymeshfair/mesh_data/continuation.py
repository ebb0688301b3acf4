"""Colours and textures continued into added elements, so that a filling looks like its surroundings; pixels of textures.

To n vertices and the (m, 3) `faces` are added a vertices and the (b, 3) `added_faces`, whose indices are from 0 to n + a - 1. For
each added element `of` has an old one, whose value it takes where none can be continued.
"""

import io
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Floats, Ints
from ..filters.libraries import spatial
from .mesh_data import Texture

#: Added faces show the texture of old ones that are at most so many rings away from them.
_RINGS = 4
#: Where a face's texture is looked at, as shares of its corners: its middle, and half way from there to each corner.
_WITHIN = np.array([[2, 2, 2], [4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6.0


class Donors(NamedTuple):
    """The old elements whose values added ones take where the edit has none."""

    vertices: NDArray[np.intp]  # (a,) for each added vertex the old one
    faces: NDArray[np.intp]  # (b,) for each added face the old one


def find_donors(points: Floats, faces: Ints, added_faces: Ints, old: int, may_give: Bools) -> Donors:
    """For an added vertex the nearest old vertex that added faces use, for an added face an old face next to its centre.

    That is one at the nearest of these vertices. If added faces use no old vertex, all old vertices of faces may give. `points`
    are the (n + a, 3) vertices, `old` is n, and `may_give`, (m,), marks the faces that may be donors, with their vertices; at
    least one.
    """
    givers = np.flatnonzero(may_give)
    at, first = np.unique(faces[givers], return_index=True)  # the first corner at each vertex
    rim = np.isin(at, added_faces[added_faces < old])
    if rim.any():
        at, first = at[rim], first[rim]
    # Squares of distances must neither overflow nor vanish; a power of two leaves every digit as it is.
    points = np.ldexp(points, -np.frexp(np.abs(points).max())[1])
    tree = spatial.cKDTree(points[at])
    _, near_vertex = tree.query(points[old:])
    _, near_face = tree.query(points[added_faces].mean(axis=1))
    return Donors(at[near_vertex], givers[first[near_face] // 3])


def faces_with_most_used_texture(faces: Ints, added_faces: Ints, wedges: Floats, textures: Ints | None) -> Bools:
    """(m,) the faces that have the texture which most vertices of the rim have, and finite texture coordinates.

    `wedges` are the (m, 3, 2) texture coordinates at their corners, `textures` the (m,) numbers; None if there is one alone.
    """
    finite: Bools = np.all(np.isfinite(wedges), axis=(1, 2), out=np.empty(len(wedges), np.bool_))
    numbers = np.zeros(len(faces), np.int32) if textures is None else textures
    candidates = [finite & (numbers == number) for number in np.unique(numbers)]
    used = np.unique(added_faces)
    shares = [np.isin(used, faces[those]).sum() + those.any() for those in candidates]
    best = candidates[int(np.argmax(shares))]
    return best if best.any() else np.ones(len(faces), np.bool_)


def continued_vertex_colors(before: Floats, added_faces: Ints, of: NDArray[np.intp]) -> Floats:
    """(n + a, 4) the (n, 4) colours and, for added vertices, the mean of their neighbours' in added faces.

    One whose faces touch no old vertex has the colour of that in `of`, (a,).
    """
    values = np.concatenate([before, before[of]])
    return _harmonic(values, added_faces, np.arange(len(values)) < len(before))


def continued_face_colors(before: Floats, faces: Ints, added_faces: Ints, vertices: int, of: NDArray[np.intp]) -> Floats:
    """(m + b, 4) the (m, 4) colours, and for added faces a blend of the colours of the faces around; `vertices` is n.

    One that is connected with no old face has the colour of that in `of`, (b,).
    """
    used = np.zeros(vertices, dtype=np.bool_)
    used[faces] = True
    return np.concatenate([before, _blend(before, faces, added_faces, used, before[of])])


def continued_texture(
    pixels: NDArray[np.uint8] | None, wedges: Floats, faces: Ints, added_faces: Ints, may_give: Bools, of: NDArray[np.intp]
) -> Floats:
    """(b, 2) for each added face a place of the texture, well inside an old face, whose colour continues those around.

    The image has no pixels for added faces. So an added face shows one colour: of the old faces near the added ones, that
    of the middle of the one whose colour is nearest to a blend of the colours around. Without an image, (height, width, 3)
    `pixels`, it is the middle of a neighbour, never its corner, where the image may show what lies beside its charts.

    `wedges` are the (m, 3, 2) texture coordinates at the corners, `may_give` marks the faces that may give theirs.
    """
    middles = wedges.mean(axis=1).astype(np.float32).astype(np.float64)  # as MeshLab keeps them
    old = int(faces.max()) + 1
    near = np.zeros(old, dtype=np.bool_)
    near[added_faces[added_faces < old]] = True
    for _ in range(_RINGS - 1):
        near[faces[near[faces].any(axis=1)]] = True
    givers = np.flatnonzero(near[faces].any(axis=1) & may_give)
    if pixels is None or len(givers) == 0:
        return np.asarray(middles[of])
    shown = np.stack([sampled(pixels, np.einsum("c,fcd->fd", w, wedges[givers])) for w in _WITHIN], axis=1)
    mean = shown.mean(axis=1)
    used = np.zeros(old, dtype=np.bool_)
    used[faces[givers]] = True
    nearest = np.searchsorted(givers, of)
    wanted = _blend(mean, faces[givers], added_faces, used, mean[np.minimum(nearest, len(givers) - 1)])
    # Of faces with much the same middle, one whose colour is the same all over is not mistaken for an edge of the picture.
    unlike = np.abs(shown - shown[:, :1]).max(axis=1)
    _, chosen = spatial.cKDTree(np.concatenate([shown[:, 0], 0.5 * unlike], axis=1)).query(np.pad(wanted, ((0, 0), (0, 3))))
    return np.asarray(middles[givers[chosen]])


def read_pixels(texture: Texture) -> NDArray[np.uint8] | None:
    """(height, width, 3) the pixels of a texture, from the top; None if it is no image that can be read."""
    from PIL import Image, UnidentifiedImageError

    if texture.image is None:
        return None
    try:
        with Image.open(io.BytesIO(texture.image) if isinstance(texture.image, bytes) else texture.image) as image:
            return np.asarray(image.convert("RGB"))
    except (UnidentifiedImageError, Image.DecompressionBombError, OSError, ValueError, SyntaxError):
        return None


def sampled(pixels: NDArray[np.uint8], uv: Floats) -> Floats:
    """(k, 3) the nearest pixels to (k, 2) texture coordinates, from 0 to 1; the image repeats itself, NaN counts as 0."""
    height, width = pixels.shape[:2]
    u, v = np.nan_to_num(uv).T
    column = np.minimum((u % 1.0 * width).astype(np.intp), width - 1)
    row = np.minimum(((1.0 - v) % 1.0 * height).astype(np.intp), height - 1)
    return np.asarray(pixels[row, column] / 255.0)


def _blend(of_faces: Floats, faces: Ints, added_faces: Ints, fixed: Bools, otherwise: Floats) -> Floats:
    """(b, k) for each added face the mean of its corners, where values at `fixed` vertices are means of the faces there."""
    count = max(len(fixed), int(added_faces.max(initial=-1)) + 1)
    sums, number = np.zeros((count, of_faces.shape[1])), np.zeros(count)
    for _ in range(2):  # the second time over two rings, so that a fine pattern of the texture counts as its mean
        at_vertices = sums / np.maximum(number, 1.0)[:, None]
        spread = of_faces if not number.any() else at_vertices[faces].mean(axis=1)
        sums, number = np.zeros_like(sums), np.zeros_like(number)
        for corner in faces.T:
            np.add.at(sums, corner, spread)
            np.add.at(number, corner, 1.0)
    values = sums / np.maximum(number, 1.0)[:, None]
    held = np.zeros(count, dtype=np.bool_)
    held[: len(fixed)] = fixed
    values[~held] = np.nan
    corners = _harmonic(values, added_faces, held)[added_faces].mean(axis=1)
    return np.where(np.isfinite(corners), corners, otherwise)


def _harmonic(values: Floats, added_faces: Ints, fixed: Bools) -> Floats:
    """The values, those that are not `fixed` from `harmonic_values` on the added faces."""
    from ..filters.fairing import harmonic_values

    used, index = np.unique(added_faces, return_inverse=True)
    continued = values.copy()
    continued[used] = harmonic_values(index.reshape(-1, 3), values[used], fixed[used])
    return continued
