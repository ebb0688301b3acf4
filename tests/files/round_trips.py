"""Files of a mesh, written and read again."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab

from pymeshfair.files.inputs import read_file
from pymeshfair.files.outputs import save_mesh
from pymeshfair.mesh_data import MeshData


def read(path: Path, data: bytes | str) -> MeshData:
    """The mesh of a file with these contents."""
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_file(path).mesh


def save(mesh: MeshData, output: Path, resolution: float = 1.0) -> tuple[str, ...]:
    """Write a mesh with all that belongs to it; the warnings."""
    stage = output.parent / f"stage of {output.name}"
    stage.mkdir(parents=True)
    saved = save_mesh(mesh, output, stage, resolution=lambda: resolution)
    for file in (*saved.side_files, saved.output):
        shutil.move(file.staged, file.target)
    return saved.warnings


def meshlab(path: Path) -> tuple[Any, Any]:
    """What plain pymeshlab reads, and the mesh set that holds it."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    return meshes.current_mesh(), meshes


def assert_same(found: MeshData, expected: MeshData) -> None:
    """Two meshes have the same elements, and attributes of the same names, values and types."""
    for name in ("vertices", "faces", "edges"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    for one, other in (
        (found.vertex_attributes, expected.vertex_attributes),
        (found.face_attributes, expected.face_attributes),
    ):
        assert one.keys() == other.keys()
        for name in one:
            if name != "polygon":
                np.testing.assert_array_equal(one[name], other[name], err_msg=name)
                assert one[name].dtype == other[name].dtype, name
            else:
                np.testing.assert_array_equal(one[name] >= 0, other[name] >= 0)
