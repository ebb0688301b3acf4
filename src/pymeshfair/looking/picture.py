"""A picture of several meshes from one camera, side by side."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from PIL import Image

from ..declaration import Floats
from ..errors import MeshError, ParameterError
from ..filters.inspection import Limits, reflection_stripes
from ..mesh_data import MeshData
from .annotation import BAR_STRIP, TITLE_STRIP, draw_color_bar, draw_scale_bar, write_title
from .camera import Camera, close_up, fitting_camera, view_rows
from .coloring import COLORINGS, OTHERS, Numbers, check_coloring, in_unit, numbers_of
from .shading import CLAY, Scene, render, texture_of

#: the share of a panel's width that a scale bar takes at most
_SCALE_BAR = 0.25


@dataclass(frozen=True)
class Appearance:
    """The settings of a picture."""

    color: str = "plain"  # one of `pymeshfair.looking.coloring.COLORINGS` or `OTHERS`
    azimuth: float = 0.0  # see `view_rows`
    elevation: float = 0.0  # see `view_rows`
    up: str = "y"  # the upright axis, "y" or "z"
    centre: tuple[float, float, float] | None = None  # (x, y, z) of a close-up; None for the whole
    extent: float = 0.0  # the shorter side of a close-up, in mesh units
    width: int = 640  # of a panel, in pixels
    height: int = 640  # of a panel, in pixels
    stripes: float = 8.0  # of reflection lines, all round
    titles: bool = True  # whether every panel has a title
    label: str = ""  # the text at the colour bar; the words of the coloring if it is empty
    columns: int = 4  # panels beside each other; more go below
    limits: Limits | None = None  # the ends of the colour bar; those of the numbers if it is None
    tolerance: float = 0.0  # distances up to it have one colour; 0 for none
    unit: str = ""  # of the scan, or empty

    def camera(self, clouds: Sequence[Floats]) -> Camera:
        """The one camera for all meshes."""
        rows = view_rows(self.azimuth, self.elevation, self.up)
        aspect = self.width / self.height
        if self.centre is None:
            return fitting_camera(clouds, rows, aspect)
        return close_up(np.asarray(self.centre, dtype=np.float64), self.extent, rows, aspect)


def draw_meshes(
    meshes: Sequence[MeshData],
    titles: Sequence[str],
    appearance: Appearance,
    *,
    numbers: Sequence[Numbers | None] | None = None,
) -> Image.Image:
    """Draw meshes side by side, all from one camera, with one scale bar and one colour bar.

    Args:
        meshes: at least one; the first is the reference of displacements.
        titles: one for each.
        appearance: how.
        numbers: those that colour each mesh; measured if it is None.

    Raises:
        ParameterError: an unknown coloring, or a picture without extent.
        MeshError: no mesh has the numbers to be coloured by.
    """
    check_coloring(appearance.color)
    if min(appearance.width, appearance.height) < 64 or max(appearance.width, appearance.height) > 8192:
        raise ParameterError("a panel has from 64 to 8192 pixels each way")
    camera = appearance.camera([mesh.vertices for mesh in meshes])
    scenes, bar = _scenes(meshes, appearance, camera, numbers)
    columns = min(len(meshes), appearance.columns)
    rows = math.ceil(len(meshes) / columns)
    strip = TITLE_STRIP if appearance.titles else 0
    cell = strip + appearance.height
    size = (columns * appearance.width, rows * cell + (BAR_STRIP if bar else 0))
    picture = Image.new("RGB", size, "white")
    for k, (scene, title) in enumerate(zip(scenes, titles, strict=True)):
        left, top = k % columns * appearance.width, k // columns * cell
        panel = render(scene, camera, appearance.width, appearance.height)
        picture.paste(Image.fromarray(panel), (left, top + strip))
        if strip:
            write_title(picture, title, left, top, appearance.width)
    draw_scale_bar(picture, 14, cell - 10, appearance.width / camera.width, _SCALE_BAR * appearance.width, appearance.unit)
    if bar is not None:
        coloring = COLORINGS[appearance.color]
        colors = partial(coloring.colors, tolerance=appearance.tolerance)
        draw_color_bar(picture, rows * cell + 4, bar, colors, appearance.label or in_unit(coloring.label, appearance.unit))
    return picture


def _scenes(
    meshes: Sequence[MeshData],
    appearance: Appearance,
    camera: Camera,
    numbers: Sequence[Numbers | None] | None,
) -> tuple[list[Scene], Limits | None]:
    """The scene of each panel, and the limits of the colour bar if there is one."""
    bare = [Scene(m.vertices, m.faces, m.edges, normals=m.vertex_attributes.get("normals")) for m in meshes]
    if appearance.color in OTHERS:
        return [_painted(s, m, appearance, camera) for s, m in zip(bare, meshes, strict=True)], None
    if numbers is None:
        numbers = numbers_of(appearance.color, meshes)
    coloring = COLORINGS[appearance.color]
    limits = appearance.limits or coloring.limits_for([n for n in numbers if n is not None])
    return [
        s if n is None else replace(s, colors=coloring.colors(n.values, limits, appearance.tolerance), by_face=n.by_face)
        for s, n in zip(bare, numbers, strict=True)
    ], limits


def _painted(scene: Scene, mesh: MeshData, appearance: Appearance, camera: Camera) -> Scene:
    if appearance.color == "reflection":
        if not len(scene.faces):
            raise MeshError(f"{mesh.label} has no faces that could reflect anything")
        _, up, eye = camera.rows

        def paint(normals: Floats) -> Floats:
            bright = reflection_stripes(normals, view=eye, direction=up, stripes=appearance.stripes)
            return np.repeat(0.08 + 0.84 * bright[:, None], 3, axis=1)

        return replace(scene, paint=paint)
    if appearance.color == "own":
        if (texture := texture_of(mesh, CLAY)) is not None:
            return replace(scene, texture=texture)
        if mesh.has_vertex_colors:
            return replace(scene, colors=mesh.vertex_colors[:, :3])
        if mesh.has_face_colors:
            return replace(scene, colors=mesh.face_colors[:, :3], by_face=True)
        raise MeshError(f"{mesh.label} has no colours of its own")
    return scene
