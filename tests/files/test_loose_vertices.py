"""Attributes of vertices that no face uses: each format keeps them, or its writer names them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pymeshfair.declaration import Edit
from pymeshfair.files.inputs import read_file
from pymeshfair.mesh_data import MeshData, apply_edit

from ..meshes import icosphere
from .round_trips import read, save

VERTICES, FACES = icosphere(1)
LOOSE = np.isin(np.arange(len(VERTICES) + 3), FACES, invert=True)


def with_loose_vertices() -> MeshData:
    """A ball and three vertices of no face, with different values at all vertices."""
    random = np.random.default_rng(4)
    vertices = np.concatenate([VERTICES, [[3.0, 0, 0], [0, 3.0, 0], [0, 0, 3.0]]])
    normals = random.normal(size=vertices.shape)
    attributes = {
        "colors": np.column_stack([random.integers(0, 255, vertices.shape), np.full(len(vertices), 255)]).astype(np.uint8),
        "normals": normals / np.linalg.norm(normals, axis=1, keepdims=True),
        "texture_coordinates": random.uniform(size=(len(vertices), 2)),
    }
    return MeshData(vertices=vertices, faces=FACES, vertex_attributes=attributes, keeps_normals=True)


@pytest.mark.parametrize(
    ("suffix", "kept", "named"),
    [
        (".ply", ("colors", "normals", "texture_coordinates"), ""),
        (".off", ("colors", "normals", "texture_coordinates"), ""),
        (".obj", ("colors", "normals"), "texture coordinates of vertices that no face uses (3) are left out"),
        (".glb", ("colors", "normals"), ""),
        (".wrl", ("colors",), "vertex normals"),
        (".3mf", (), "colours of vertices that no face uses (3) are left out"),
        (".xyz", ("normals",), "vertex colours"),
    ],
)
def test_each_format_keeps_them_or_names_them(tmp_path: Path, suffix: str, kept: tuple[str, ...], named: str) -> None:
    """What is read again is what was written, or a warning names it."""
    mesh = with_loose_vertices()
    warnings = save(mesh, tmp_path / f"a{suffix}")
    found = read_file(tmp_path / f"a{suffix}").mesh
    for name in kept:
        values, written = found.vertex_attributes[name][-3:], mesh.vertex_attributes[name][-3:]
        np.testing.assert_allclose(values, written, rtol=0.0, atol=1e-7, err_msg=name)
    assert named in " ".join(warnings)


@pytest.mark.parametrize("suffix", [".obj", ".ply"])
@pytest.mark.parametrize("change", ["faces", "vertices", "normals", "move"])
def test_normals_in_obj_files_stay_through_steps(tmp_path: Path, change: str, suffix: str) -> None:
    """Vertices of no face keep their normals in an OBJ file whose faces or vertices a step removes, turns or moves."""
    save(with_loose_vertices(), tmp_path / f"a{suffix}")
    mesh = read_file(tmp_path / f"a{suffix}").mesh
    first, n = np.arange(len(FACES)) < 2, len(mesh.vertices)
    edits = {
        "faces": Edit(delete_faces=first),
        "vertices": Edit(delete_vertices=np.arange(n) == 0),
        "normals": Edit(vertex_normals=-mesh.vertex_normals),
        "move": Edit(vertices=1.5 * mesh.vertices, delete_faces=first),
    }
    changed = apply_edit(mesh, edits[change])
    assert not any("normals" in warning for warning in save(changed, tmp_path / "b.obj"))
    found = read_file(tmp_path / "b.obj").mesh
    np.testing.assert_allclose(found.vertex_normals[-3:], changed.vertex_normals[-3:], rtol=0.0, atol=1e-7)
    assert not np.array_equal(changed.vertex_normals[-1], np.zeros(3))


def test_normals_that_an_obj_file_with_creases_cannot_hold_are_named(tmp_path: Path) -> None:
    """Where corners have normals of their own, a vertex of no face has none in the file, and a warning says so."""
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1", *(f"vn {k} 0 1" for k in range(4))]
    mesh = read(tmp_path / "a.obj", "\n".join([*lines, "f 1//2 2//1 3//3", "f 1//1 3//4 4//2", "f 2//3 3//3 4//4", ""]))
    thinner = apply_edit(mesh, Edit(delete_faces=np.array([False, True, True])))
    warnings = save(thinner, tmp_path / "b.obj")
    assert any("normals of vertices that no face uses (1) are left out" in warning for warning in warnings)


@pytest.mark.parametrize("suffix", [".las", ".xyz", ".pts"])
def test_clouds_get_the_normals_of_moved_meshes(tmp_path: Path, suffix: str) -> None:
    """The normals of a mesh whose vertices moved are computed before its points are written without the faces."""
    mesh = MeshData(vertices=VERTICES, faces=FACES, vertex_attributes={"normals": -VERTICES}, keeps_normals=True)
    moved = apply_edit(mesh, Edit(vertices=1.5 * VERTICES))
    warnings = save(moved, tmp_path / f"a{suffix}")
    normals = read_file(tmp_path / f"a{suffix}").mesh.vertex_attributes.get("normals")
    if normals is None:
        assert any("vertex normals" in warning for warning in warnings)
    else:
        np.testing.assert_allclose(normals, moved.vertex_normals, rtol=0.0, atol=1e-12)
