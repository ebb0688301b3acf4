"""Pictures: what is in front, from where, in which colours."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from pymeshfair.errors import MeshError, ParameterError
from pymeshfair.filters.inspection import Limits, Surface
from pymeshfair.looking.comparison import compare, state_of
from pymeshfair.looking.picture import (
    COLORINGS,
    VIEWS,
    Appearance,
    draw_meshes,
    fitting_camera,
    numbers_of,
    round_length,
    view_angles,
    view_rows,
)
from pymeshfair.looking.shading import DepthBuffer, Scene, draw_triangles, render
from pymeshfair.mesh_data import MeshData, Texture
from pymeshfair.report.comparison_page import comparison_page
from pymeshfair.report.scene import pack_scene, shown_mesh
from pymeshfair.running.measuring import measure
from pymeshfair.running.read import ReadMesh
from tests.commands.command_line import document, invoke, run_process
from tests.meshes import cube, grid, icosphere, sample, sample_path

NO_EDGES = np.empty((0, 2), dtype=np.int32)


def mesh_of(vertices: Any, faces: Any, **more: Any) -> MeshData:
    """A mesh with this label."""
    return MeshData(vertices=vertices, faces=faces, label="mesh.ply", **more)


def pixels(mesh: MeshData, **appearance: Any) -> np.ndarray:
    """The pixels of a picture of one mesh without a title."""
    return np.asarray(draw_meshes([mesh], ["x"], Appearance(titles=False, **{"width": 128, "height": 128, **appearance})))


def test_every_pixel_shows_the_nearest_triangle() -> None:
    """Compared with a ray through the middle of every pixel, intersected with every triangle."""
    rng = np.random.default_rng(5)
    screen = np.column_stack([rng.uniform(-5, 45, 60), rng.uniform(-5, 35, 60), rng.normal(size=60)])
    faces = rng.integers(0, 60, (40, 3)).astype(np.int32)
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    buffer = DepthBuffer(np.full((30, 40), -1, np.int32), np.full((30, 40), -np.inf))
    draw_triangles(screen, faces, *buffer)
    for row in range(30):
        for column in range(40):
            found, depth = -1, -np.inf
            for f, (a, b, c) in enumerate(screen[faces]):
                system = np.column_stack([b - a, c - a])[:2]
                s, t = np.linalg.solve(system, [column + 0.5 - a[0], row + 0.5 - a[1]])
                z = a[2] + s * (b - a)[2] + t * (c - a)[2]
                if min(s, t, 1 - s - t) >= 0 and z > depth:
                    found, depth = f, z
            assert buffer.elements[row, column] == found
            if found >= 0:
                assert buffer.depths[row, column] == pytest.approx(depth, abs=1e-9)


def test_a_surface_has_no_cracks() -> None:
    """A rectangle of 20,000 triangles fills every pixel of its outline, however small they are."""
    vertices, faces = grid(100, 100, 0.37)
    buffer = DepthBuffer(np.full((50, 50), -1, np.int32), np.full((50, 50), -np.inf))
    draw_triangles(vertices * [1.2, 1.2, 1.0], faces, *buffer)
    covered = buffer.elements >= 0
    expected = np.arange(50) + 0.5 < 37 * 1.2
    np.testing.assert_array_equal(covered, expected[:, None] & expected)


@pytest.mark.parametrize("view", VIEWS)
def test_views_show_their_side(view: str) -> None:
    """The side of a cube that looks to the eye is the one of the view's name."""
    towards = {
        "front": [0, 0, 1],
        "back": [0, 0, -1],
        "right": [1, 0, 0],
        "left": [-1, 0, 0],
        "top": [0, 1, 0],
        "bottom": [0, -1, 0],
    }
    rows = view_rows(*VIEWS[view])
    np.testing.assert_allclose(rows @ rows.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(rows) == pytest.approx(1.0)
    if view in towards:
        np.testing.assert_allclose(rows[2], towards[view], atol=1e-15)
        z_up = view_rows(*VIEWS[view], up="z")
        np.testing.assert_allclose(z_up[2], np.array(towards[view])[[0, 2, 1]] * [1, -1, 1], atol=1e-15)


def test_camera_holds_every_vertex_and_lengths_to_scale() -> None:
    """All points are within the window, and a length across is as many pixels as the camera says."""
    vertices, _ = sample("bunny.obj")
    camera = fitting_camera([vertices, vertices + 1.0], view_rows(30.0, 20.0), 1.5)
    for points in (vertices, vertices + 1.0):
        screen = camera.screen(points, 300, 200)
        assert screen[:, 0].min() > 0
        assert screen[:, 0].max() < 300
        assert screen[:, 1].min() > 0
        assert screen[:, 1].max() < 200
    ends = camera.screen(np.array([camera.centre, camera.centre + 0.1 * camera.rows[0]]), 300, 200)
    assert ends[1, 0] - ends[0, 0] == pytest.approx(0.1 * 300 / camera.width)
    x, y, z = vertices[7].tolist()
    near = Appearance(centre=(x, y, z), extent=0.2, width=200, height=100).camera([vertices])
    np.testing.assert_allclose(near.screen(vertices[7:8], 200, 100)[0, :2], [100, 50])
    assert (near.width, near.height) == (0.4, 0.2)


def test_a_vertex_without_a_face_does_not_shrink_the_picture() -> None:
    """It is not drawn, so the camera need not hold it; survey coordinates with one at the origin made a picture of one dot."""
    vertices, faces = icosphere(2)
    stray = mesh_of(np.vstack([vertices, [[1e4, 1e4, 1e4]]]), faces)
    np.testing.assert_array_equal(pixels(stray), pixels(mesh_of(vertices, faces)))


def test_far_from_the_origin_the_picture_is_the_same() -> None:
    """At UTM coordinates, given ones that can be moved exactly, hardly a pixel changes."""
    vertices, faces = sample("bunny.obj")
    vertices = np.round(vertices * 2.0**18) / 2.0**18
    near, far = pixels(mesh_of(vertices, faces)), pixels(mesh_of(vertices + np.array([5e5, 5.5e6, 300.0]), faces))
    assert np.mean(np.abs(near.astype(int) - far).max(axis=2) > 2) < 1e-3


def test_colours_are_those_of_the_bar() -> None:
    """A plate seen from the front whose scalar grows to the right grows lighter to the right; both sides of the bar are told."""
    vertices, faces = grid(20, 20)
    shown = pixels(mesh_of(vertices, faces, vertex_attributes={"scalars": vertices[:, 0]}), color="scalar")
    row = shown[64, 8:120].astype(float).sum(axis=1)
    assert (np.diff(row[::8]) > 0).all()
    assert shown.shape[0] > 128


def test_distance_is_measured_from_the_first() -> None:
    """The first mesh is plain, the grown one orange; within a tolerance it is pale, and colours begin apart from that."""
    vertices, faces = icosphere(3)
    meshes = [mesh_of(vertices, faces), mesh_of(1.1 * vertices, faces)]
    drawn = np.asarray(draw_meshes(meshes, ["a", "b"], Appearance("distance", width=100, height=100)), dtype=int)
    middle = drawn[34 + 50, [50, 150]]
    assert np.ptp(middle[0]) < 30
    assert middle[1, 0] - middle[1, 2] > 60
    values, ends = np.array([-0.06, -0.05, 0.0, 0.05, 0.06]), Limits(-1.0, 1.0)
    low, *within, high = COLORINGS["distance"].colors(values, ends, 0.05)
    assert (within[0] == within[1]).all()
    assert (within[1] == within[2]).all()
    assert np.abs(low - within[0]).max() > 0.2
    assert np.abs(high - within[0]).max() > 0.2


def test_the_colour_bar_of_distances_ends_beyond_rounding_errors() -> None:
    """If hardly a place moved its ends are the largest distance; they were rounding errors of the others."""
    vertices, faces = icosphere(3)
    turned = vertices @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0] + 10.0
    halved: Any = trimesh.Trimesh(turned, faces, process=False).subdivide()
    finer = halved.vertices + np.where(np.arange(len(halved.vertices)) == 0, 0.01, 0.0)[:, None]
    assert np.unique(Surface.of(turned, faces).nearest(finer).signed).size > 2
    meshes = [mesh_of(turned, faces), mesh_of(np.asarray(finer), halved.faces.astype(np.int32))]
    numbers = [n for n in numbers_of("distance", meshes) if n is not None]
    assert COLORINGS["distance"].limits_for(numbers).high > 1e-3
    compared = compare(*(state_of(ReadMesh(Path(m.label), m, measure(m), ())) for m in meshes))
    page = comparison_page(compared, title="", subtitle="", numbers={}).decode()
    assert json.loads(page.partition("data-scene-header>")[2].partition("</script>")[0])["colorings"]["distance"]["high"] > 1e-3


def test_inner_sides_look_different() -> None:
    """A surface that is seen from inside is told apart by its colour."""
    vertices, faces = icosphere(3)
    outside, inside = pixels(mesh_of(vertices, faces)), pixels(mesh_of(vertices, faces[:, ::-1].copy()))
    assert outside[64, 64, 2] > outside[64, 64, 0]
    assert inside[64, 64, 0] > inside[64, 64, 2]


def test_clouds_and_polylines_are_drawn() -> None:
    """A point is a dot and an edge a line, with no faces at all."""
    corner = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]])
    none = np.empty((0, 3), dtype=np.int32)
    dots = pixels(mesh_of(corner, none))
    lines = pixels(mesh_of(corner, none, edges=np.array([[0, 1], [1, 2]], dtype=np.int32)))
    # Above the scale bar there is the third point, and most of the edge to it.
    assert 3 <= np.count_nonzero((dots[:90] < 200).all(axis=2)) < 20
    assert np.count_nonzero((lines[:90] < 200).all(axis=2)) > 80


def test_normals_that_are_not_finite_are_drawn_as_none() -> None:
    """Their points are drawn, and packed for the viewer, as with normals of 0, without a warning of the arithmetic."""
    vertices, _ = icosphere(3)
    drawn, packed = [], []
    for number in (np.nan, np.inf, 0.0):
        normals = np.where(np.arange(len(vertices))[:, None] % 3, vertices, number)
        mesh = mesh_of(vertices, np.empty((0, 3), np.int32), vertex_attributes={"normals": normals})
        drawn.append(pixels(mesh).tobytes())
        packed.append(pack_scene([shown_mesh("scan", mesh)], {}).body)
    assert len(set(drawn)) == len(set(packed)) == 1


def test_a_cloud_has_no_numbers_of_faces() -> None:
    """Measures of surfaces are refused for a cloud; one that had faces before shows the colours of its points."""
    levels = np.tile(np.array([255, 0, 0, 255], np.uint8), (2, 1))
    none: dict[str, Any] = {"colors": levels[:0], "scalars": np.empty(0), "wedge_texture_coordinates": np.empty((0, 3, 2))}
    cloud = MeshData(vertices=np.eye(3)[:2], face_attributes=none, textures=(Texture("a.png", None),))
    for color in ("curvature", "gaussian", "shape", "scalar", "own"):
        with pytest.raises(MeshError, match=r"none|no colours"):
            pixels(cloud, color=color)
    seen = pixels(cloud.with_attributes({"colors": levels}), color="own")
    assert (seen[..., 0] > seen[..., 1]).any()


def test_rendering_is_the_same_every_time() -> None:
    """The same scene gives the same bytes."""
    vertices, faces = sample("bunny.obj")
    camera = fitting_camera([vertices], view_rows(20, 10), 1.0)
    first, second = (render(Scene(vertices, faces, NO_EDGES), camera, 100, 100) for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_scale_bars_have_round_lengths() -> None:
    """1, 2 or 5 times a power of ten, the largest that fits."""
    assert [round_length(x) for x in (0.99, 1.0, 1.99, 2.0, 4.0, 5.0, 77.0)] == pytest.approx([0.5, 1, 1, 2, 2, 5, 50])


@pytest.mark.parametrize("by_corner", [True, False])
def test_the_own_colours_of_a_textured_mesh_are_those_of_its_texture(tmp_path: Path, by_corner: bool) -> None:
    """Red above green on the left, blue on the right, as the image is; an image that is not there is named."""
    vertices, faces = grid(4, 4, spacing=0.25)
    Image.fromarray(np.array([[[255, 0, 0], [0, 0, 255]], [[0, 255, 0], [0, 0, 255]]], dtype=np.uint8)).save(tmp_path / "t.png")
    where = (
        {"face_attributes": {"wedge_texture_coordinates": vertices[faces][:, :, :2], "texture": np.zeros(len(faces), np.int32)}}
        if by_corner
        else {"vertex_attributes": {"texture_coordinates": vertices[:, :2]}}
    )
    mesh = mesh_of(vertices, faces, textures=(Texture("t.png", tmp_path / "t.png"),), **where)
    shown = pixels(mesh, color="own").astype(int)
    seen = np.argwhere(shown.min(axis=2) < 200)
    (top, left), (bottom, right) = seen.min(axis=0), seen.max(axis=0)
    quarters = [(3 * top + bottom) // 4, (top + 3 * bottom) // 4], [(3 * left + right) // 4, (left + 3 * right) // 4]
    assert [shown[row, column].argmax() for row in quarters[0] for column in quarters[1]] == [0, 2, 1, 2]
    lost = replace(mesh, textures=(Texture("t.png", None),))
    with pytest.raises(MeshError, match=r"the texture 't.png' of mesh.ply cannot be drawn"):
        pixels(lost, color="own")


def test_faces_without_a_texture_have_their_own_colour(tmp_path: Path) -> None:
    """Of a mesh with a green image, as of an OBJ file with two materials, the faces that have none are red, as they say."""
    vertices, faces = grid(4, 4, spacing=0.25)
    Image.new("RGB", (2, 2), "green").save(tmp_path / "t.png")
    red = np.tile(np.array([255, 0, 0, 255], np.uint8), (len(faces), 1))
    number = np.where(np.arange(len(faces)) < len(faces) // 2, 0, -1).astype(np.int32)
    looks = {"wedge_texture_coordinates": vertices[faces][:, :, :2], "texture": number, "colors": red}
    mesh = mesh_of(vertices, faces, textures=(Texture("t.png", tmp_path / "t.png"),), face_attributes=looks)
    shown = pixels(mesh, color="own").astype(int).reshape(-1, 3)
    strongest = shown[np.ptp(shown, axis=1) > 40].argmax(axis=1)
    assert set(strongest) == {0, 1}
    assert 0.4 < (strongest == 0).mean() < 0.6


def test_texture_coordinates_that_are_not_finite_count_as_0(tmp_path: Path) -> None:
    """Files have NaN where a program knew no place of the texture; the picture is drawn all the same."""
    vertices, faces = grid(4, 4, spacing=0.25)
    Image.new("RGB", (2, 2), "red").save(tmp_path / "t.png")
    for value in (np.nan, np.inf, -np.inf):
        uv = {"texture_coordinates": np.full((len(vertices), 2), value)}
        mesh = mesh_of(vertices, faces, textures=(Texture("t.png", tmp_path / "t.png"),), vertex_attributes=uv)
        assert (pixels(mesh, color="own")[..., 1] < 200).any()


def test_what_cannot_be_shown_is_refused() -> None:
    """Unknown names, views and numbers that no mesh has are refused with what there is."""
    vertices, faces = cube()
    with pytest.raises(ParameterError, match="did you mean 'curvature'"):
        pixels(mesh_of(vertices, faces), color="curvatur")
    with pytest.raises(MeshError, match="it takes a second mesh"):
        pixels(mesh_of(vertices, faces), color="displacement")
    with pytest.raises(MeshError, match="has no colours of its own"):
        pixels(mesh_of(vertices, faces), color="own")
    with pytest.raises(ParameterError, match="did you mean 'front'"):
        view_angles("fron")
    with pytest.raises(ParameterError, match="from -90 to 90"):
        view_angles("0,100")
    assert view_angles("30,-20") == (30.0, -20.0)


def test_a_title_of_two_lines_is_one_line() -> None:
    """A file name may have a line break, too."""
    first, second = (draw_meshes([mesh_of(*cube())], [title], Appearance(width=64, height=64)) for title in ("a\nb", "a b"))
    assert first.tobytes() == second.tobytes()


def test_the_command_needs_no_display(tmp_path: Path) -> None:
    """Without DISPLAY, on one thread, a picture of two meshes is written, with titles and the size that was asked for."""
    bare = dict.fromkeys(("DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR"), "") | {"NUMBA_NUM_THREADS": "1"}
    bunny, target = sample_path("bunny.obj"), tmp_path / "out.png"
    done = run_process("picture", bunny, bunny, "-o", target, "--size", "160x120", "--view", "iso", "--json", environment=bare)
    assert done.returncode == 0, done.stderr
    assert document(done.stdout)["width"] == 320
    with Image.open(target) as drawn:
        assert drawn.size == (320, 154)
        seen = np.asarray(drawn)
    assert (seen[34:, :160] < 128).any()
    # The scale bar stands in the first panel alone.
    np.testing.assert_array_equal(seen[40:110, :160], seen[40:110, 160:])


def test_nothing_of_opengl_is_loaded(tmp_path: Path) -> None:
    """What draws loads neither pymeshlab, nor OpenGL, nor matplotlib."""
    program = (
        "import sys, pymeshfair.looking.picture, pymeshfair.report.comparison_page, pymeshfair.tuning.server\n"
        "wrong = {'pymeshlab', 'matplotlib', 'OpenGL', 'vtk'} & {name.split('.')[0] for name in sys.modules}\n"
        "maps = open('/proc/self/maps').read() if sys.platform == 'linux' else ''\n"
        "sys.exit(bool(wrong) or 'libGL' in maps)"
    )
    assert subprocess.run([sys.executable, "-c", program], timeout=120, env=dict(os.environ)).returncode == 0


def test_wrong_command_lines_are_refused(tmp_path: Path) -> None:
    """Sizes, titles and close-ups that cannot be, and options without effect, are usage errors, before any picture is written."""
    bunny = sample_path("bunny.obj")
    for wrong, words in (
        (["-o", tmp_path / "x.png", "--size", "big"], "WIDTHxHEIGHT"),
        (["-o", tmp_path / "x.png", "--title", "a", "--title", "b"], "2 titles for 1 meshes"),
        (["-o", tmp_path / "x.png", "--zoom", "vertex=99999999,1%"], "N below the"),
        (["-o", tmp_path / "x.png", "--zoom", "vertex=-1,1%"], "N below the"),
        (["-o", tmp_path / "x.png", "--zoom", "0,0,0,0"], "above 0"),
        (["-o", tmp_path / "x.png", "--zoom", "nan,0,0,1"], "write X,Y,Z,SIZE"),
        (["-o", tmp_path / "x.png", "--limits", "-1,1"], "--limits: --color plain does not show it"),
        (["-o", tmp_path / "x.png", "--color", "shape", "--tolerance", "0.1"], "--tolerance: --color shape does not show it"),
        (["-o", tmp_path / "x.png", "--color", "curvature", "--tolerance", "1"], "--color curvature does not show it"),
        (["-o", tmp_path / "x.png", "--color", "curvature", "--limits=-1mm,1mm", "--unit", "m"], "curvature shows no lengths"),
        (["-o", tmp_path / "x.png", "--color", "scalar", "--stripes", "30"], "--stripes: --color scalar does not show it"),
    ):
        result = invoke("picture", bunny, *map(str, wrong))
        assert result.exit_code == 2, wrong
        assert words in result.stderr
    assert not list(tmp_path.iterdir())


def test_close_ups_have_the_unit_of_the_scan(tmp_path: Path) -> None:
    """On a scan in cm a close-up of 5 mm is one of half a mesh unit."""
    for name, size in (("length", "5mm"), ("number", "0.5")):
        out = ("-o", str(tmp_path / f"{name}.png"), "--size", "64x64")
        result = invoke("picture", sample_path("bunny.obj"), *out, "--unit", "cm", "--zoom", f"0,0,0,{size}")
        assert result.exit_code == 0, result.stderr
    assert (tmp_path / "length.png").read_bytes() == (tmp_path / "number.png").read_bytes()
