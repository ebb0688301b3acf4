"""Texts that MeshLab is given as binary files, which it reads several times as fast."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from pymeshfair.files.inputs import inspect_input
from pymeshfair.files.tokens import joined_pieces, tokenise
from tests.meshes import icosphere


def test_numbers_of_ordinary_length_are_exact() -> None:
    """Up to 15 digits and 22 places they are those that Python reads; where one may not be, the piece says so."""
    rng = np.random.default_rng(3)
    words = [f"{value:.{digits}g}" for value in rng.normal(size=400) for digits in (3, 9, 15)]
    piece = joined_pieces(tokenise(" ".join(words).encode()))
    assert piece.exact
    np.testing.assert_array_equal(piece.values, [float(word) for word in words])
    for word in ("0.12345678901234567", "1e23", "1e-23", "12345678901234567890"):
        assert not joined_pieces(tokenise(word.encode())).exact


@pytest.mark.parametrize("name", ["a.obj", "a.off", "a.ply", "a.stl"])
def test_plain_texts_go_to_meshlab_as_binary_files(tmp_path: Path, name: str) -> None:
    """MeshLab reads the same vertices and faces to the bit, in the same order."""
    vertices, faces = icosphere(2)
    rows = [" ".join(f"{x:.6f}" for x in v) for v in vertices.tolist()]
    head = f"element vertex {len(vertices)}\n" + "".join(f"property float {c}\n" for c in "xyz")
    triangles = ["3 {} {} {}".format(*f) for f in faces.tolist()]
    texts = {
        "a.obj": "".join(f"v {row}\n" for row in rows) + "".join("f {} {} {}\n".format(*f) for f in (faces + 1).tolist()),
        "a.off": f"OFF\n{len(vertices)} {len(faces)} 0\n" + "\n".join([*rows, *triangles]),
        "a.ply": f"ply\nformat ascii 1.0\n{head}element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        + "\n".join([*rows, *triangles]),
        "a.stl": "solid\n"
        + "".join(
            "facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {rows[i]}\n" for i in f) + "endloop\nendfacet\n"
            for f in faces.tolist()
        )
        + "endsolid\n",
    }
    path = tmp_path / name
    path.write_text(texts[name])
    reading = inspect_input(path, tmp_path / "given").reading
    assert reading is not None
    assert b"\0" in reading.read_bytes()
    meshes = pymeshlab.MeshSet()
    for given in (path, reading):
        meshes.load_new_mesh(str(given))
    for array in ("vertex_matrix", "face_matrix"):
        np.testing.assert_array_equal(getattr(meshes.mesh(0), array)(), getattr(meshes.mesh(1), array)())


def test_colours_of_obj_vertices_keep_their_level(tmp_path: Path) -> None:
    """MeshLab rounds the colour 101/255 of a text down to 100/255; all 256 levels come through."""
    levels = np.arange(256) / 255
    lines = [f"v {k} {k * k} 0 {c:.6f} {c:.6f} {c:.6f}" for k, c in enumerate(levels)]
    path = tmp_path / "a.obj"
    path.write_text("\n".join([*lines, *(f"f {k} {k + 1} {k + 2}" for k in range(1, 255))]))
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(inspect_input(path, tmp_path / "given").reading))
    np.testing.assert_allclose(meshes.current_mesh().vertex_color_matrix()[:, 0], levels, atol=1e-9)
