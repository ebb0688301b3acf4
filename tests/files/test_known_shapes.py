"""A prism over an L, of known area, volume and box, in every format that is written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from pymeshfair.files.inputs import read_file
from pymeshfair.mesh_data import MeshData

from .round_trips import meshlab, read, save

#: an L of 4 x 3 without 2 x 2, 5 high: area 2 * 8 + 14 * 5, volume 40
FLOOR = [(0, 0), (4, 0), (4, 1), (2, 1), (2, 3), (0, 3)]
POINTS = [(x, y, z) for z in (0, 5) for x, y in FLOOR]
SIDES = [[k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6)]
POLYGONS = [[5, 4, 3, 2, 1, 0], [6, 7, 8, 9, 10, 11], *SIDES]
AREA, VOLUME, BOX = 86.0, 40.0, [[0, 0, 0], [4, 3, 5]]


def obj() -> str:
    """The shape as an OBJ file of polygons, counted forwards and backwards."""
    faces = [" ".join(str(i + 1 if k % 2 else i - 12) for i in p) for k, p in enumerate(POLYGONS)]
    return "".join(f"v {x} {y} {z}\n" for x, y, z in POINTS) + "".join(f"f {face}\n" for face in faces)


def off() -> str:
    """The shape as an OFF file of polygons."""
    rows = [f"{x} {y} {z}" for x, y, z in POINTS] + [f"{len(p)} {' '.join(map(str, p))}" for p in POLYGONS]
    return "\n".join(["OFF", "12 8 0", *rows, ""])


def assert_shape(vertices: np.ndarray, faces: np.ndarray) -> None:
    """Area, volume and box are those of the prism."""
    shape = trimesh.Trimesh(vertices, faces, process=False)
    np.testing.assert_allclose((shape.area, shape.volume), (AREA, VOLUME), rtol=1e-6)
    np.testing.assert_allclose(shape.bounds, BOX, rtol=1e-6)


@pytest.mark.parametrize("output", ["a.ply", "a.obj", "a.off", "a.stl"])
@pytest.mark.parametrize("source", ["b.obj", "b.off"])
def test_polygons_have_their_area(tmp_path: Path, source: str, output: str) -> None:
    """Concave polygons are read and written with their area; PLY, OBJ and OFF keep them, and MeshLab reads them so."""
    mesh = read(tmp_path / source, obj() if source == "b.obj" else off())
    assert_shape(mesh.vertices, mesh.faces)
    assert len(mesh.faces) == 20
    save(replace(mesh, source=None), tmp_path / output)
    again = read_file(tmp_path / output).mesh
    assert_shape(again.vertices, again.faces)
    if output != "a.stl":
        assert len(np.unique(again.face_attributes["polygon"])) == 8
    if output == "a.stl":  # trimesh reads no lists of different lengths, and cuts polygons as fans
        np.testing.assert_allclose(trimesh.load_mesh(tmp_path / output).volume, VOLUME, rtol=1e-6)
    if output != "a.off":  # in which MeshLab misreads polygons of more than four corners
        theirs, _meshes = meshlab(tmp_path / output)
        assert_shape(theirs.vertex_matrix(), theirs.face_matrix())


def test_a_half_is_a_half(tmp_path: Path) -> None:
    """Without the faces above, each format has the area of what is left."""
    mesh = read(tmp_path / "b.obj", obj())
    part = mesh.part(np.ones(12, np.bool_), mesh.face_attributes["polygon"] != 1)
    for name in ("a.ply", "a.obj", "a.off", "a.stl"):
        save(part, tmp_path / name)
        again = read_file(tmp_path / name).mesh
        np.testing.assert_allclose(trimesh.Trimesh(again.vertices, again.faces, process=False).area, AREA - 8, rtol=1e-6)


def test_an_empty_selection_is_refused_nowhere(tmp_path: Path) -> None:
    """A mesh without faces is a cloud in the formats that hold one."""
    cloud = MeshData(vertices=np.array(POINTS, float))
    for name in ("a.ply", "a.obj", "a.off", "a.xyz", "a.pts", "a.las"):
        save(cloud, tmp_path / name)
        np.testing.assert_allclose(read_file(tmp_path / name).mesh.vertices, POINTS, atol=1e-3)


def test_a_hole_that_a_bridge_joins_to_the_rim_stays_open(tmp_path: Path) -> None:
    """A polygon that names two vertices twice, a frame of 16 without 4, has the same area in OFF and in a scene."""
    points = [(0, 0), (4, 0), (4, 4), (0, 4), (1, 1), (1, 3), (3, 3), (3, 1)]
    places = "\n".join(f"{x} {y} 0" for x, y in points)
    corners = "0 1 2 3 0 4 5 6 7 4"
    geometry = f"IndexedFaceSet {{ coord Coordinate {{ point [ {places} ] }} coordIndex [ {corners} -1 ] }}"
    for name, text in (
        ("a.off", f"OFF\n8 1 0\n{places}\n10 {corners}\n"),
        ("a.wrl", f"#VRML V2.0 utf8\nShape {{ geometry {geometry} }}\n"),
    ):
        mesh = read(tmp_path / name, text)
        assert trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).area == 12.0, name


def test_blanks_of_other_scripts_separate_numbers(tmp_path: Path) -> None:
    """A no-break space between the numbers of a scene separates them, and no exception without a message follows."""
    geometry = "IndexedFaceSet { coord Coordinate { point [0 0 0, 1\u00a00 0, 0 1 0] } coordIndex [0 1 2 -1] }"
    mesh = read(tmp_path / "a.wrl", f"#VRML V2.0 utf8\nShape {{ geometry {geometry} }}\n")
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize("kind", ["ply", "obj"])
def test_polygons_that_a_step_drops_are_triangles(tmp_path: Path, kind: str) -> None:
    """A mesh whose triangles no longer form polygons is written as triangles over the same file."""
    save(read(tmp_path / "b.obj", obj()), tmp_path / f"a.{kind}")
    mesh = read_file(tmp_path / f"a.{kind}").mesh
    save(mesh.with_attributes(face={"polygon": None}), tmp_path / f"c.{kind}")
    again = read_file(tmp_path / f"c.{kind}").mesh
    assert "polygon" not in again.face_attributes
    np.testing.assert_array_equal(again.faces, mesh.faces)


def test_colours_of_vertices_and_of_materials_in_one_mesh(tmp_path: Path) -> None:
    """In COLLADA triangles without colours of their own keep their material's beside triangles that have some."""
    numbers = (
        '<float_array id="{0}a" count="{1}">{2}</float_array><technique_common><accessor source="#{0}a" count="{3}" stride="3"/>'
    )
    source = f'<source id="{{0}}">{numbers}</technique_common></source>'
    corner = '<input semantic="VERTEX" source="#v" offset="0"/>'
    geometry = (
        f"{source.format('p', 18, '0 0 0 1 0 0 0 1 0 0 0 1 1 0 1 0 1 1', 6)}{source.format('c', 3, '0 0 1', 1)}"
        '<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
        f'<triangles count="1">{corner}<input semantic="COLOR" source="#c" offset="1"/><p>0 0 1 0 2 0</p></triangles>'
        f'<triangles count="1" material="s">{corner}<p>3 4 5</p></triangles>'
    )
    look = "<profile_COMMON><technique><lambert><diffuse><color>1 0 0 1</color></diffuse></lambert></technique></profile_COMMON>"
    use = '<bind_material><technique_common><instance_material symbol="s" target="#m"/></technique_common></bind_material>'
    text = (
        f'<COLLADA><library_effects><effect id="e">{look}</effect></library_effects>'
        '<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>'
        f'<library_geometries><geometry id="g"><mesh>{geometry}</mesh></geometry></library_geometries><library_visual_scenes>'
        f'<visual_scene id="s"><node><instance_geometry url="#g">{use}</instance_geometry></node></visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )
    colors = read(tmp_path / "a.dae", text).vertex_attributes["colors"]
    np.testing.assert_array_equal(colors, np.repeat([[0, 0, 255, 255], [255, 0, 0, 255]], 3, axis=0))
