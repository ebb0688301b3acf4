"""What a mesh file and the files that it names say, before MeshLab reads any of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .references import Texture

#: of a text that ends within a line
NO_END = "its last line has no end: if the file was cut short, so was perhaps its last number"


def unended(text: bytes) -> tuple[str, ...]:
    """The doubt about a text that ends within a line: its last number may be the beginning of a longer one."""
    return () if text.endswith((b"\n", b"\r", b"\x1a")) else (NO_END,)


@dataclass(frozen=True)
class Announced:
    """What the input and the files that it names say about the mesh.

    Attributes:
        vertices: how many are declared, or None if the format does not say.
        faces: how many polygons are declared, or None.
        triangles: how many triangles these polygons make, or None if that is not known.
        normals: whether it has vertex normals.
        radii: whether its vertices have radii.
        vertex_texture: whether its vertices, not only the corners of its faces, have texture coordinates.
        not_kept: what it has and MeshLab does not keep, in words.
        doubts: what makes one doubt that it is whole, in sentences.
        side_files: the existing files that belong to it.
        textures: the textures that it names.
        points: (n, 3) the coordinates that it declares, in order, or None where they were not read.
        precision: by what share of its amount MeshLab may read one of them otherwise.
        vertex_attributes: by name what its vertices have that MeshLab does not read and that is kept as custom attributes.
        face_attributes: the same of its faces.
        reading: what MeshLab is given to read in place of the file, with everything that it names; None is the file itself.
    """

    vertices: int | None = None
    faces: int | None = None
    triangles: int | None = None
    normals: bool = False
    radii: bool = False
    vertex_texture: bool = False
    not_kept: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    side_files: tuple[Path, ...] = ()
    textures: tuple[Texture, ...] = ()
    points: NDArray[np.float64] | None = None
    precision: float = 1e-14
    vertex_attributes: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    face_attributes: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    reading: Path | None = None
