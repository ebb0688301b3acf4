"""Colours of a surface from the images on it."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image, UnidentifiedImageError

from ..declaration import Floats, Ints
from ..errors import MeshError
from ..mesh_data import MeshData

#: gives (k, 3) colours from 0 to 1 of (k,) faces at (k, 3) barycentric coordinates
Sampler = Callable[[Ints, Floats], Floats]


def texture_of(mesh: MeshData, plain: Floats) -> Sampler | None:
    """What the images show at each place; None of a mesh without texture coordinates or images.

    The nearest texel is taken, and the image repeats itself beyond its edges.

    Args:
        mesh: the mesh.
        plain: (3,) the colour of faces without an image.

    Raises:
        MeshError: an image is not there, or is none.
    """
    corners = mesh.face_attributes.get("wedge_texture_coordinates")
    if corners is None and "texture_coordinates" in mesh.vertex_attributes:
        corners = mesh.vertex_attributes["texture_coordinates"][mesh.faces]
    if corners is None or not mesh.textures:
        return None
    of_faces = mesh.face_attributes.get("texture", np.zeros(len(mesh.faces), dtype=np.int32))
    images = [_pixels(mesh, texture.name, texture.image) for texture in mesh.textures]

    def sample(faces: Ints, weights: Floats) -> Floats:
        places = np.einsum("ki,kij->kj", weights, corners[faces])
        colors = np.broadcast_to(plain, (len(faces), 3)).copy()
        for number, image in enumerate(images):
            here = of_faces[faces] == number
            rows, columns = image.shape[:2]
            u, v = places[here].T % 1.0
            column, row = (u * columns).astype(np.int64) % columns, ((1.0 - v) * rows).astype(np.int64) % rows
            colors[here] = image[row, column] / 255.0
        return colors

    return sample


def _pixels(mesh: MeshData, name: str, image: Path | bytes | None) -> Floats:
    if image is None:
        raise MeshError(f"the texture {name!r} of {mesh.label} cannot be drawn: there is no such file")
    try:
        with Image.open(io.BytesIO(image) if isinstance(image, bytes) else image) as opened:
            return np.asarray(opened.convert("RGB"))
    except (OSError, UnidentifiedImageError) as error:
        raise MeshError(f"the texture {name!r} of {mesh.label} cannot be drawn: {error}") from error
