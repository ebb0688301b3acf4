"""What each format keeps of a mesh that has everything: written, read again, and compared with the page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from pymeshfair.files.formats import ATTRIBUTES, READABLE, WRITABLE, attributes_of
from pymeshfair.files.inputs import read_file
from pymeshfair.files.ply import PlyDocument
from pymeshfair.mesh_data import MeshData, Texture

from .round_trips import meshlab, save

TRUST = Path(__file__).parents[2] / "docs" / "trust.md"
#: formats that are not those of another extension, without drawings, which are not read
FORMATS = [name for name, kind in WRITABLE.items() if kind.extension == name and name in READABLE]


def everything(folder: Path, *, cloud: int, corners: int) -> MeshData:
    """A square and two triangles beside it, or a cloud, with all attributes; texture coordinates of corners, or of vertices."""
    Image.new("RGB", (4, 4), (200, 10, 10)).save(folder / "skin.png")
    random = np.random.default_rng(0)
    n = 6
    vertex = {
        "normals": np.tile([0.0, 0.0, 1.0], (n, 1)),
        "colors": np.c_[random.integers(0, 255, (n, 3)), np.full(n, 100)].astype(np.uint8),
        "scalars": np.arange(n) + 0.5,
        "radii": np.arange(n) + 1.0,
        "height": np.linspace(0.0, 1.0, n),
    }
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], np.float64)
    if cloud:
        return MeshData(vertices=vertices, vertex_attributes=vertex)
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    face = {
        "colors": np.c_[random.integers(0, 255, (4, 3)), np.full(4, 90)].astype(np.uint8)[[0, 0, 2, 3]],  # the square has one
        "scalars": np.array([0.25, 0.25, 2.25, 3.25]),
        "texture": np.zeros(4, np.int32),
        "polygon": np.array([0, 0, -1, -1], np.int32),
    }
    if corners:
        face["wedge_texture_coordinates"] = random.integers(0, 8, (4, 3, 2)) / 8.0
        face["wedge_texture_coordinates"][1, :2] = face["wedge_texture_coordinates"][0, ::2]
    else:
        vertex["texture_coordinates"] = vertices[:, :2] / 2.0
    return MeshData(
        vertices=vertices,
        faces=faces,
        edges=np.array([[0, 3]]),
        vertex_attributes=vertex,
        face_attributes=face,
        keeps_normals=True,
        textures=(Texture("skin.png", folder / "skin.png"),),
    )


def kept(name: str, folder: Path) -> set[str]:
    """What is read again of meshes that have everything and were written in that format."""
    there: set[str] = set()
    meshes = [everything(folder, cloud=cloud, corners=corners) for cloud, corners in ((0, 1), (0, 0), (1, 0))]
    meshes.append(meshes[0].with_attributes(vertex={"colors": None}))
    for number, mesh in enumerate(meshes):
        path = folder / f"{number}" / f"all.{name}"
        path.parent.mkdir()
        if not len(mesh.faces) and name in ("stl", "3mf"):
            continue  # which hold no clouds
        warnings = " ".join(save(mesh, path))
        again = read_file(path).mesh
        had, has = attributes_of(mesh), attributes_of(again)
        if again.source is not None and isinstance(again.source.document, PlyDocument) and again.source.document.custom("vertex"):
            has.add("custom attributes")  # which are read when something asks for them
        if "wedge texture coordinates" in has - had:  # OBJ writes those of vertices at corners
            has = has - {"wedge texture coordinates"} | {"vertex texture coordinates"}
        assert has <= had
        for lost in had - has:
            element, _, what = lost.replace("opacities", "colours").partition(" ")  # which go with them
            names = (lost, f"{what} of {element}s", f"{what} of vertices", *(["height"] if what == "attributes" else []))
            assert any(words in warnings for words in names), (name, lost, warnings)
        there |= has
    return there


def table(folder: Path) -> str:
    """The lines of the page."""
    columns = {}
    for name in FORMATS:
        (folder / name).mkdir()
        columns[name] = kept(name, folder / name)
    lines = [f"| | {' | '.join(name.upper() for name in FORMATS)} |", f"|---|{'---|' * len(FORMATS)}"]
    lines += [f"| {a} | {' | '.join('yes' if a in columns[name] else '' for name in FORMATS)} |" for a in ATTRIBUTES]
    return "\n".join(lines)


def test_the_page_has_what_files_keep(tmp_path: Path) -> None:
    """Each format keeps what the page says; everything else is named when the file is written."""
    assert table(tmp_path) in TRUST.read_text("utf-8")


@pytest.mark.parametrize("name", ["ply", "obj", "off", "stl", "glb", "3mf", "wrl"])
def test_others_read_what_was_written(name: str, tmp_path: Path) -> None:
    """Pymeshlab and trimesh find the same surface in every format, with its colours where pymeshlab reads such."""
    mesh = replace(everything(tmp_path, cloud=0, corners=1), edges=np.empty((0, 2), np.int32))  # MeshLab's glTF has none
    path = tmp_path / f"out.{name}"
    save(mesh, path)
    theirs, _ = meshlab(path)
    assert theirs.face_number() == 4
    box = np.array([theirs.bounding_box().min(), theirs.bounding_box().max()])
    np.testing.assert_allclose(box, [[0, 0, 0], [2, 1, 0]], atol=1e-6)
    if name in ("ply", "obj", "off"):
        order = np.lexsort(theirs.vertex_matrix().T)
        expected = np.lexsort(mesh.vertices.T)
        found = np.round(theirs.vertex_color_matrix()[order, :3] * 255)
        np.testing.assert_array_equal(found, mesh.vertex_attributes["colors"][expected, :3])
    if name not in ("wrl", "3mf"):  # it does not read VRML, and 3MF with a further package alone
        surface = trimesh.load(path, force="mesh", process=False)
        assert isinstance(surface, trimesh.Trimesh)
        assert np.isclose(surface.area, 2.0)
