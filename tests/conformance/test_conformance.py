"""Files that are right are read right, or refused or named in words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pymeshfair.files.errors import InputError
from pymeshfair.files.inputs import read_file
from pymeshfair.mesh_data import MeshData

from . import made_3mf, made_dae, made_gltf, made_scenes
from .solids import Made, facts

FILES = {made.name: made for source in (made_gltf, made_dae, made_scenes, made_3mf) for made in source.made()}


def read(folder: Path, made: Made) -> MeshData:
    """What is read of a file."""
    path = folder / made.name
    path.write_bytes(made.data)
    for name, data in made.beside.items():
        (folder / name).write_bytes(data)
    return read_file(path).mesh


@pytest.mark.parametrize("name", FILES)
def test_files_are_read_right(tmp_path: Path, name: str) -> None:
    """Area, volume, box, and everything else that is known of the file are as it was made; else it is refused by name."""
    made = FILES[name]
    try:
        mesh = read(tmp_path, made)
    except InputError as error:
        if not names(made, error.reason):
            raise
        return
    assert mesh.source is not None
    try:
        check(mesh, made)
    except AssertionError:
        if not names(made, " ".join(mesh.source.extras)):
            raise


def names(made: Made, text: str) -> bool:
    """Whether a text names what the file may be read without."""
    return any(word.lower() in text.lower() for word in made.named)


def check(mesh: MeshData, made: Made) -> None:
    """Whether a mesh is what the file was made of."""
    found = facts([(mesh.vertices, mesh.faces)])
    size = (
        found["area"] ** 0.5 if made.high is None or made.low is None else float(np.linalg.norm(np.subtract(made.high, made.low)))
    )
    for name in ("area", "volume"):
        expected = getattr(made, name)
        if expected is not None:
            np.testing.assert_allclose(found[name], expected, rtol=made.tolerance, atol=made.tolerance, err_msg=name)
    for name in ("low", "high"):
        if getattr(made, name) is not None:
            np.testing.assert_allclose(found[name], getattr(made, name), atol=made.tolerance * size, err_msg=name)
    more = dict(made.more)
    for name, values in (("vertices", mesh.vertices), ("faces", mesh.faces), ("edges", mesh.edges)):
        if name in more:
            assert len(values) == more[name], name
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)[:, None]
    if "colour" in more:
        colors = mesh.face_attributes.get("colors")
        colors = mesh.vertex_attributes["colors"][mesh.faces].mean(axis=1) if colors is None else colors
        np.testing.assert_allclose((colors * area).sum(axis=0)[:3] / area.sum(), more["colour"], atol=1.0)
    if "uv" in more:
        wedges = mesh.face_attributes["wedge_texture_coordinates"].mean(axis=1)
        np.testing.assert_allclose((wedges * area).sum(axis=0) / area.sum(), more["uv"], atol=2e-3)
        assert (mesh.face_attributes["texture"] == 0).all()
    if "image" in more:
        (texture,) = mesh.textures
        assert isinstance(texture.image, Path | bytes)
    if "normal" in more:
        assert np.allclose(mesh.vertex_normals, more["normal"], atol=1e-6)
    if "unit" in more:
        assert mesh.unit == more["unit"]
    if "named" in more:
        assert mesh.source is not None
        assert more["named"] in " ".join(mesh.source.extras)
