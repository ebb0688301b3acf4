"""What is written as GLB, 3MF and VRML is valid, comes back as it was, and is read alike by others."""

from __future__ import annotations

import json
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest
import trimesh

from pymeshfair.files.formats import attributes_of
from pymeshfair.files.inputs import read_file
from pymeshfair.files.outputs import Saved, save_mesh
from pymeshfair.mesh_data import MeshData, Texture, moved

from ..conformance.made_gltf import png
from ..conformance.solids import POINTS, TRIANGLES


def save(mesh: MeshData, folder: Path, name: str) -> tuple[Path, Saved]:
    """The written file."""
    stage = folder / f"stage-{name}"
    stage.mkdir()
    saved = save_mesh(mesh, folder / name, stage, resolution=lambda: 1.0)
    saved.output.staged.rename(folder / name)
    return folder / name, saved


def box(**more: Any) -> MeshData:
    """The box."""
    return MeshData(vertices=POINTS, faces=TRIANGLES, **more)


COLORS = np.array([[k * 30, 255 - k, k, 255] for k in range(8)], np.uint8)
FACE_COLORS = np.array([[k * 20, 0, 255 - k, 255] for k in range(12)], np.uint8)
NORMALS = (POINTS - POINTS.mean(axis=0)) / np.linalg.norm(POINTS - POINTS.mean(axis=0), axis=1, keepdims=True)
WEDGES = np.random.default_rng(5).random((12, 3, 2)).astype(np.float32).astype(np.float64)
MESHES: dict[str, MeshData] = {
    "plain": box(),
    "colours": box(vertex_attributes={"colors": COLORS}),
    "face colours": box(face_attributes={"colors": FACE_COLORS}),
    "normals": box(vertex_attributes={"normals": NORMALS}, keeps_normals=True),
    "opacities": box(vertex_attributes={"colors": np.column_stack([COLORS[:, :3], COLORS[:, 0]])}),
    "cloud": MeshData(vertices=POINTS, vertex_attributes={"colors": COLORS, "normals": NORMALS}),
    "edges": MeshData(vertices=POINTS, edges=np.array([[0, 1], [1, 3], [6, 7]])),
    "texture": box(
        face_attributes={"wedge_texture_coordinates": WEDGES, "texture": np.zeros(12, np.int32)},
        textures=(Texture("a.png", png()),),
    ),
    "two textures": box(
        face_attributes={"wedge_texture_coordinates": WEDGES, "texture": np.array([0, 1, -1] * 4, np.int32)},
        textures=(Texture("a.png", png()), Texture("b.png", png((1, 2, 3)))),
    ),
    "unit": box(unit="mm"),
}
HOLDS = {"glb": set(MESHES), "3mf": {"plain", "colours", "face colours", "opacities", "unit"}, "wrl": {"plain", "colours"}}


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, names in HOLDS.items() for name in sorted(names)])
def test_what_is_written_comes_back(tmp_path: Path, kind: str, name: str) -> None:
    """Our reader finds every attribute that the format holds, without a warning: triangle by triangle, in their order."""
    mesh = MESHES[name]
    path, saved = save(mesh, tmp_path, f"a.{kind}")
    assert saved.warnings == ()
    back = read_file(path).mesh
    factor = 0.001 if kind == "glb" and mesh.unit == "mm" else 1.0
    if kind == "3mf":
        assert back.unit == (mesh.unit or "mm")
    assert attributes_of(back) == attributes_of(mesh)
    if not len(mesh.faces):
        np.testing.assert_array_equal(back.vertices, mesh.vertices)
        np.testing.assert_array_equal(back.edges, mesh.edges)
    order = np.argsort(mesh.face_attributes.get("texture", np.zeros(len(mesh.faces))), kind="stable")
    if name == "face colours" and kind == "glb":
        order = np.lexsort(FACE_COLORS[:, ::-1].T)
    np.testing.assert_allclose(back.vertices[back.faces], factor * mesh.vertices[mesh.faces][order], rtol=1e-12)
    for attribute, values in mesh.vertex_attributes.items():
        found = back.vertex_attributes[attribute][back.faces if len(mesh.faces) else slice(None)]
        expected = values[mesh.faces] if len(mesh.faces) else values
        np.testing.assert_allclose(found, expected, atol=1e-6)
    for attribute, values in mesh.face_attributes.items():
        shown = back.face_attributes.get("texture", np.zeros(len(mesh.faces))) >= 0
        np.testing.assert_allclose(back.face_attributes[attribute][shown], values[order][shown], atol=1e-6)
    assert [t.image for t in back.textures] == [t.image for t in mesh.textures]


def test_seams_of_a_texture_do_not_cut_the_surface(tmp_path: Path) -> None:
    """A vertex that GLB splits for its texture coordinates is one vertex again, unless its copies differ in colours."""
    path, _ = save(MESHES["texture"], tmp_path, "a.glb")
    assert len(trimesh.load_mesh(path, process=False).vertices) == 36
    assert len(read_file(path).mesh.vertices) == 8
    colors = np.full((36, 4), 255, np.uint8)
    colors[0, 0] = 8
    soup = replace(MESHES["texture"], vertices=POINTS[TRIANGLES.ravel()], faces=np.arange(36, dtype=np.int32).reshape(-1, 3))
    path, _ = save(replace(soup, vertex_attributes={"colors": colors}), tmp_path, "b.glb")
    assert len(read_file(path).mesh.vertices) == 9


@pytest.mark.parametrize("name", ["_FEATURE_ID_0", "WEIGHTS_0"])
def test_copies_with_values_of_their_own_stay_apart(tmp_path: Path, name: str) -> None:
    """Copies of a vertex that differ in an attribute that is not read, as of touching parts or of bones, are not one vertex."""
    path, _ = save(MESHES["texture"], tmp_path, "a.glb")
    data = path.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    attributes[name] = attributes["TEXCOORD_0"]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary = data[20 + size :]
    whole = b"glTF" + struct.pack("<IIII", 2, 20 + len(text) + len(binary), len(text), 0x4E4F534A) + text + binary
    path.write_bytes(whole)
    assert len(read_file(path).mesh.vertices) == 36


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, names in HOLDS.items() for name in sorted(names)])
def test_meshlab_reads_it_alike(tmp_path: Path, kind: str, name: str) -> None:
    """MeshLab finds the same surface, colours, normals and texture coordinates in it, all that its reader of the format knows."""
    mesh = MESHES[name]
    if name == "edges":
        pytest.skip("MeshLab reads no edges of glTF")
    path, _ = save(mesh, tmp_path, f"a.{kind}")
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path), **({"usecolors": True} if kind == "3mf" else {}))
    if meshes.mesh_number() > 1:
        meshes.generate_by_merging_visible_meshes()
    meshes.apply_matrix_freeze()
    found = meshes.current_mesh()
    factor = 0.001 if kind == "glb" and mesh.unit == "mm" else 1.0
    np.testing.assert_allclose(found.bounding_box().min(), factor * POINTS.min(axis=0), rtol=1e-6)
    np.testing.assert_allclose(found.bounding_box().max(), factor * POINTS.max(axis=0), rtol=1e-6)
    assert found.face_number() == len(mesh.faces)
    if len(mesh.faces):
        np.testing.assert_allclose(meshes.get_geometric_measures()["surface_area"], factor**2 * 22.0, rtol=1e-5)
    places = found.vertex_matrix()
    nearest = np.argmin(np.linalg.norm(places[:, None] - factor * POINTS[None], axis=2), axis=1)
    if kind == "3mf" and "colors" in mesh.vertex_attributes:
        assert found.has_face_color()  # MeshLab has one colour a face of it
    elif "colors" in mesh.vertex_attributes:
        expected = mesh.vertex_attributes["colors"][nearest]
        np.testing.assert_array_equal(np.rint(255 * found.vertex_color_matrix()[:, :3]), expected[:, :3])
    if name == "face colours" and found.has_face_color():
        np.testing.assert_array_equal(np.rint(255 * found.face_color_matrix()), FACE_COLORS)
    if kind == "glb" and "normals" in mesh.vertex_attributes:
        np.testing.assert_allclose(found.vertex_normal_matrix(), NORMALS[nearest], atol=1e-6)
    if mesh.textures:
        wedges = found.wedge_tex_coord_matrix() if found.has_wedge_tex_coord() else found.vertex_tex_coord_matrix()
        ours = read_file(path).mesh.face_attributes["wedge_texture_coordinates"].reshape(-1, 2)
        used = ours[(ours != 0).any(axis=1)]
        distance = np.abs(used[:, None] - wedges[None]).max(axis=2).min(axis=1)
        assert distance.max() < 1e-6


@pytest.mark.parametrize("name", sorted(HOLDS["glb"] - {"edges"}))
def test_other_libraries_read_glb_alike(tmp_path: Path, name: str) -> None:
    """Trimesh finds the same area and volume in it."""
    path, _ = save(MESHES[name], tmp_path, "a.glb")
    scene: Any = trimesh.load(path, force="scene", process=False)
    parts = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh)]
    if len(MESHES[name].faces):
        joined: Any = trimesh.util.concatenate(parts)
        factor = 0.001 if MESHES[name].unit == "mm" else 1.0
        np.testing.assert_allclose([joined.area, joined.volume], [22 * factor**2, 6 * factor**3], rtol=1e-6)


@pytest.mark.parametrize("name", sorted(HOLDS["glb"]))
def test_glb_files_keep_the_rules_of_their_format(tmp_path: Path, name: str) -> None:
    """Lengths, alignment, bounds, unit normals, counts and references are as the specification demands."""
    data = save(MESHES[name], tmp_path, "a.glb")[0].read_bytes()
    magic, version, length, text_length, kind = struct.unpack_from("<4sIIII", data)
    assert (magic, version, length, kind, text_length % 4) == (b"glTF", 2, len(data), 0x4E4F534A, 0)
    document = json.loads(data[20 : 20 + text_length])
    size, kind = struct.unpack_from("<II", data, 20 + text_length)
    binary = data[28 + text_length :]
    assert (kind, size, size % 4) == (0x004E4942, len(binary), 0)
    assert document["buffers"] == [{"byteLength": size}]
    assert document["asset"]["version"] == "2.0"
    values = []
    for accessor in document["accessors"]:
        view = document["bufferViews"][accessor["bufferView"]]
        dtype = np.dtype({5121: "u1", 5125: "<u4", 5126: "<f4"}[accessor["componentType"]])
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        assert view["byteOffset"] % 4 == 0
        assert accessor["count"] * width * dtype.itemsize == view["byteLength"]
        assert view["byteOffset"] + view["byteLength"] <= size
        own = np.frombuffer(binary, dtype, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
        assert np.isfinite(own).all()
        if "min" in accessor:
            np.testing.assert_array_equal([own.min(axis=0), own.max(axis=0)], [accessor["min"], accessor["max"]])
        values.append(own)
    for primitive in document["meshes"][0]["primitives"]:
        counts = {len(values[k]) for k in primitive["attributes"].values()}
        assert len(counts) == 1
        assert "min" in document["accessors"][primitive["attributes"]["POSITION"]]
        if "indices" in primitive:
            assert values[primitive["indices"]].max() < min(counts)
        if "NORMAL" in primitive["attributes"]:
            np.testing.assert_allclose(np.linalg.norm(values[primitive["attributes"]["NORMAL"]], axis=1), 1, atol=1e-3)
        if "material" in primitive:
            assert primitive["material"] < len(document["materials"])
    for image in document.get("images", ()):
        assert image["mimeType"] == "image/png"
    assert document["scenes"][document["scene"]]["nodes"] == [0]


@pytest.mark.parametrize("suffix", ["glb", "obj", "ply"])
def test_normals_follow_vertices_that_move(tmp_path: Path, suffix: str) -> None:
    """A file with normals still has them after its vertices have moved: those of the new surface."""
    path, _ = save(MESHES["normals"], tmp_path, f"a.{suffix}")
    mesh = moved(read_file(path).mesh, POINTS * [1, 2, 3])
    back = read_file(save(mesh, tmp_path, f"b.{suffix}")[0]).mesh
    np.testing.assert_allclose(back.vertex_attributes["normals"], mesh.vertex_normals, atol=1e-6)


def test_wedges_split_only_the_vertices_that_need_it(tmp_path: Path) -> None:
    """A vertex with one texture coordinate stays one, and those that no face uses stay in their place."""
    wedges = np.repeat(np.arange(8)[:, None], 2, axis=1)[TRIANGLES] / 8.0
    mesh = MeshData(
        vertices=np.concatenate([POINTS, [[9.0, 9, 9]]]),
        faces=TRIANGLES,
        face_attributes={"wedge_texture_coordinates": wedges, "texture": np.zeros(12, np.int32)},
        textures=(Texture("a.png", png()),),
    )
    back = read_file(save(mesh, tmp_path, "a.glb")[0]).mesh
    np.testing.assert_array_equal(back.vertices, mesh.vertices)
    np.testing.assert_array_equal(back.faces, mesh.faces)


def test_what_glb_and_3mf_do_not_hold_is_said(tmp_path: Path) -> None:
    """Other kinds of images become PNG, missing ones are named, and a cloud is no 3MF file."""
    missing = box(textures=(Texture("gone.png", None),))
    assert "gone.png" in " ".join(save(missing, tmp_path, "a.glb")[1].warnings)
    both = box(vertex_attributes={"colors": COLORS}, face_attributes={"colors": FACE_COLORS})
    assert "colours of faces" in " ".join(save(both, tmp_path, "a.3mf")[1].warnings)
    with pytest.raises(Exception, match="only triangles"):
        save(MESHES["cloud"], tmp_path, "b.3mf")


@pytest.mark.parametrize("suffix", ["glb", "off", "ply"])
def test_a_moved_mesh_that_lost_all_faces_has_no_normals(tmp_path: Path, suffix: str) -> None:
    """Without faces no normals can be computed, so the cloud has none, and not the normals 0 0 0."""
    mesh = moved(replace(MESHES["normals"], keeps_normals=True), POINTS * [1, 2, 3])
    path, saved = save(mesh.part(np.ones(len(POINTS), np.bool_), np.zeros(len(mesh.faces), np.bool_)), tmp_path, f"a.{suffix}")
    assert "normals" not in read_file(path).mesh.vertex_attributes
    assert not saved.warnings


@pytest.mark.parametrize("number", [0.0, np.inf, np.nan])
def test_normals_without_a_direction_are_told(tmp_path: Path, number: float) -> None:
    """A GLB file may hold unit vectors alone, so that these normals become 0 0 1, and the others stay."""
    normals = np.where(np.arange(8)[:, None] == 3, [number, 0.0, 0.0], NORMALS)
    path, saved = save(box(vertex_attributes={"normals": normals}, keeps_normals=True), tmp_path, "a.glb")
    found = read_file(path).mesh.vertex_attributes["normals"]
    np.testing.assert_allclose(found, np.where(np.arange(8)[:, None] == 3, [0.0, 0.0, 1.0], NORMALS), atol=1e-6)
    assert [w for w in saved.warnings if "normals of length 0 or not finite are written as 0 0 1 (1)" in w]


def test_texture_coordinates_of_other_primitives_are_not_lost(tmp_path: Path) -> None:
    """Edges and faces without a texture share the coordinates of faces with one, which are read."""
    mesh = replace(MESHES["two textures"], edges=np.array([[0, 1]]))
    path, _saved = save(mesh, tmp_path, "a.glb")
    source = read_file(path).mesh.source
    assert source is not None
    assert not any("texture coordinates" in text for text in source.extras)


def test_texture_numbers_of_a_mesh_without_textures_make_none(tmp_path: Path) -> None:
    """A PLY file may number textures that it does not name; a GLB file of its mesh has the same faces."""
    path, saved = save(box(face_attributes={"texture": np.zeros(12, np.int32)}), tmp_path, "a.glb")
    np.testing.assert_array_equal(read_file(path).mesh.faces, TRIANGLES)
    assert not saved.warnings
