"""Textures beside an output: the input's own bytes, never outside the folder, never over a stranger's file."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pymeshlab
import pytest
from PIL import Image

from pymeshfair.files.inputs import read_file
from pymeshfair.files.provenance import sha256_of
from pymeshfair.mesh_data import MeshData, Texture
from pymeshfair.mesh_data.mesh_data import read_pixels
from pymeshfair.registry import find_filter
from pymeshfair.running.document import Document
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from pymeshfair.scripts.script import Step

from .runs import SAMPLES, SMOOTH, TETRAHEDRON, Given, names_in, ply_bytes, recipe_of, session_report, staged_files, xyz

Maker: TypeAlias = Callable[[Path, str], Path]
IMAGE = SAMPLES / "TextureDouble_A.png"


def textured_obj(folder: Path, texture: str) -> Path:
    """The textured bunny of the wheel with another name for its texture, in a folder of its own."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(SAMPLES / "bunny10k_textured.obj", folder / "bunny.obj")
    material = (SAMPLES / "bunny10k_textured.mtl").read_text()
    (folder / "bunny10k_textured.mtl").write_text(material.replace("TextureDouble_A.png", texture))
    return folder / "bunny.obj"


def textured_ply(folder: Path, texture: str) -> Path:
    """A textured tetrahedron, in a folder of its own."""
    folder.mkdir(parents=True, exist_ok=True)
    face = [("list uchar float", "texcoord", [[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]] * 4)]
    path = folder / "tetrahedron.ply"
    path.write_bytes(ply_bytes(xyz(), TETRAHEDRON[1].tolist(), face, head=f"comment TextureFile {texture}"))
    return path


def texture_named_in(path: Path) -> str:
    """The texture that plain pymeshlab finds in a mesh file."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    (name,) = meshes.current_mesh().textures()
    return str(name)


@pytest.mark.parametrize("make", [textured_obj, textured_ply])
@pytest.mark.parametrize("extension", ["obj", "ply"])
@pytest.mark.parametrize("way", ["../../evil.png", "absolute", "sub/t.png", "sub\\t.png"])
def test_no_texture_leaves_the_folder(tmp_path: Path, make: Maker, extension: str, way: str) -> None:
    """Wherever the input's texture lies, the output's lies beside the output, and the output names it there."""
    source = make(tmp_path / "a" / "b" / "in", str(tmp_path / "abs.png") if way == "absolute" else way)
    image = {
        "../../evil.png": tmp_path / "a" / "evil.png",
        "absolute": tmp_path / "abs.png",
        "sub/t.png": source.parent / "sub" / "t.png",
        "sub\\t.png": source.parent / "t.png",
    }[way]
    image.parent.mkdir(exist_ok=True)
    shutil.copy(IMAGE, image)
    output = tmp_path / "a" / "b" / "c" / f"out.{extension}"
    output.parent.mkdir()
    before = {p: sha256_of(p) for p in tmp_path.rglob("*") if p.is_file()}
    report = session_report(source, output, allow_outside=True)
    files = staged_files(report)
    assert {file.target.parent for file in report["staged"]} == {output.parent}
    assert files[image.name].read_bytes() == IMAGE.read_bytes()
    for path, digest in before.items():
        assert sha256_of(path) == digest
    stage = {p.parent for p in files.values()}
    assert {p for p in tmp_path.rglob("*") if p.is_file() and p not in before and p.parent not in stage} == set()
    for name, staged in files.items():
        staged.rename(output.with_name(name))
    assert texture_named_in(output) == image.name


def test_a_strangers_file_is_not_overwritten(tmp_path: Path) -> None:
    """Where a file of the texture's name stands already, the texture gets another name, and the output names that."""
    source = textured_obj(tmp_path / "in", "t.png")
    shutil.copy(IMAGE, tmp_path / "in" / "t.png")
    out = tmp_path / "out"
    out.mkdir()
    (out / "t.png").write_bytes(b"precious")
    (out / "bunny-t.png").mkdir()
    report = session_report(source, out / "bunny.obj")
    files = staged_files(report)
    assert set(files) == {"bunny.obj", "bunny.obj.mtl", "bunny-2-t.png"}
    assert "map_Kd bunny-2-t.png" in files["bunny.obj.mtl"].read_text()


def test_the_same_file_is_used_again(tmp_path: Path) -> None:
    """Beside the input, or where the texture lies already, nothing is written a second time."""
    source = textured_obj(tmp_path, "t.png")
    shutil.copy(IMAGE, tmp_path / "t.png")
    report = session_report(source, tmp_path / "clean.obj")
    assert set(staged_files(report)) == {"clean.obj", "clean.obj.mtl"}
    described = {Path(f["path"]): f["sha256"] for f in report["output"]["side_files"]}
    assert described[tmp_path / "t.png"] == sha256_of(IMAGE)


@pytest.mark.parametrize("names", [("t.png", "sub/t.png"), ("sub/t.png", "t.png")])
@pytest.mark.parametrize("folder", [".", "out"])
def test_a_second_run_confuses_no_images_of_one_name(tmp_path: Path, names: tuple[str, str], folder: str) -> None:
    """After two runs with two images of one name, the input's images are as before, and the output has both."""
    colors = dict(zip(names, ((250, 0, 0), (0, 250, 0)), strict=True))
    (tmp_path / "sub").mkdir()
    (tmp_path / "out").mkdir(exist_ok=True)
    for name, color in colors.items():
        Image.new("RGB", (4, 4), color).save(tmp_path / name)
    head = "\n".join(f"comment TextureFile {name}" for name in names)
    face: list[Any] = [("list uchar float", "texcoord", [[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]] * 4), ("int", "texnumber", [0, 1, 0, 1])]
    source, output = tmp_path / "in.ply", tmp_path / folder / "out.ply"
    source.write_bytes(ply_bytes(xyz(), TETRAHEDRON[1].tolist(), face, head=head))
    for _ in range(2):
        run_job(Job(recipe_of(SMOOTH), source, output))
        for mesh in (read_file(path).mesh for path in (source, output)):
            images = [read_pixels(texture) for texture in mesh.textures]
            assert [tuple(image[0, 0]) for image in images if image is not None] == list(colors.values())


@pytest.mark.parametrize("make", [textured_obj, textured_ply])
@pytest.mark.parametrize("extension", ["obj", "ply"])
def test_a_missing_texture_is_named_and_no_placeholder_written(tmp_path: Path, make: Maker, extension: str) -> None:
    """If the texture does not exist, the output still refers to it, a warning says so, and no dummy.png appears."""
    source = make(tmp_path / "in", "../gone/t.png")
    (tmp_path / "out").mkdir()
    report = session_report(source, tmp_path / "out" / f"m.{extension}")
    files = staged_files(report)
    assert set(files) - {"m.obj.mtl"} == {f"m.{extension}"}
    assert "the texture '../gone/t.png' does not exist; the output still refers to it" in report["warnings"]
    text = files["m.obj.mtl" if extension == "obj" else "m.ply"].read_bytes()
    assert b" t.png\n" in text
    assert b"dummy" not in text


def test_a_painted_texture_is_written_anew(tmp_path: Path) -> None:
    """After a filter that may paint on textures the output's texture is what the filter made of it."""
    source = textured_obj(tmp_path / "in", "t.png")
    shutil.copy(IMAGE, tmp_path / "in" / "t.png")
    (tmp_path / "out").mkdir()
    step = ("compute_texmap_from_color", {"textname": "painted.png", "textw": 64, "texth": 64})
    report = session_report(source, tmp_path / "out" / "b.obj", ("compute_color_transfer_face_to_vertex", {}), step)
    painted = [path for name, path in staged_files(report).items() if name.endswith(".png")]
    assert painted
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in painted)
    assert names_in(tmp_path / "out") == {"stage-b.obj"}


def test_layers_that_become_one_keep_their_images(tmp_path: Path) -> None:
    """Twelve layers, all but one with other images of one name, become a layer whose faces show their own image."""
    document = Document(tmp_path / "door")
    wedges = np.zeros((4, 3, 2))
    for k in range(12):
        Image.new("RGB", (2, 2), (k % 11, 0, 0)).save(tmp_path / f"{k}.png")
        texture = Texture("t.png", tmp_path / f"{k % 11}.png")
        attributes: dict[str, Any] = {"wedge_texture_coordinates": wedges, "texture": np.zeros(4, np.int32)}
        vertices, faces = TETRAHEDRON
        document.add(MeshData(vertices=vertices + 5.0 * k, faces=faces, face_attributes=attributes, textures=(texture,)))
    flatten = find_filter("generate_by_merging_visible_meshes")
    document.apply(Step(flatten, flatten.check({}), 0))
    mesh = document.current
    assert [t.name for t in mesh.textures] == ["t.png", *(f"{k}-t.png" for k in range(2, 12))]
    images = [read_pixels(mesh.textures[k]) for k in mesh.face_attributes["texture"]]
    layers = np.rint(mesh.vertices[mesh.faces[:, 0], 0] // 5.0).astype(int)
    assert [int(image[0, 0, 0]) for image in images if image is not None] == (layers % 11).tolist()


def test_a_jpeg_image_goes_through_steps_that_make_layers(tmp_path: Path) -> None:
    """The JPEG image of a copied layer is the input's, to the byte, and MeshLab takes colours from it."""
    source = textured_ply(tmp_path / "in", "t.jpg")
    Image.new("RGB", (8, 8), (250, 0, 0)).save(source.with_name("t.jpg"))
    (tmp_path / "out").mkdir()
    steps: list[Given] = [("compute_color_from_texture_per_vertex", {}), ("generate_copy_of_current_mesh", {})]
    report = session_report(source, tmp_path / "out" / "m.ply", *steps)
    assert staged_files(report)["t.jpg"].read_bytes() == source.with_name("t.jpg").read_bytes()
    colors = read_file(staged_files(report)["m.ply"]).mesh.vertex_attributes["colors"]
    np.testing.assert_allclose(colors, [[250, 0, 0, 255]] * 4, atol=4)


@pytest.mark.parametrize("make", [textured_obj, textured_ply])
def test_a_step_that_reads_the_picture_finds_it(tmp_path: Path, make: Maker) -> None:
    """Colours taken from the texture are those that plain pymeshlab takes, whatever the format of the input."""
    source = make(tmp_path, "t.png")
    shutil.copy(IMAGE, tmp_path / "t.png")
    output = tmp_path / "colored.ply"
    run_job(Job(recipe_of(("compute_color_from_texture_per_vertex", {})), source, output))
    plain, ours = pymeshlab.MeshSet(), pymeshlab.MeshSet()
    plain.load_new_mesh(str(source))
    plain.compute_color_from_texture_per_vertex()
    ours.load_new_mesh(str(output))
    np.testing.assert_array_equal(ours.current_mesh().vertex_color_matrix(), plain.current_mesh().vertex_color_matrix())
