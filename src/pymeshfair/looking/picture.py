"""Draws several meshes side by side, with titles, a scale bar, and a colour bar for a measure.

One camera with a parallel projection draws all meshes, so that lengths can be measured in the picture.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ..declaration import Floats, Ints
from ..errors import MeshError, ParameterError, hint
from ..filters.geometry import vector_lengths
from ..filters.inspection import (
    Limits,
    Surface,
    diverging_colors,
    gaussian_curvature,
    mean_curvature,
    reflection_stripes,
    robust_limits,
    sequential_colors,
    symmetric_limits,
    triangle_shapes,
)
from ..filters.mesh import bounding_box, mask_of
from ..mesh_data import MeshData
from .comparison import rounding_of, same_elements
from .shading import Camera, Scene, render, rotated, texture_of

#: the colour of numbers within the tolerance; the position on the colour map (0 middle, 1 end) of numbers just beyond it
_WITHIN, _BAND = (0.86, 0.90, 0.84), 0.3


@dataclass(frozen=True, eq=False)
class Numbers:
    """Numbers of one mesh."""

    values: Floats  # (n,) of vertices, or (m,) of faces
    by_face: bool = False


@dataclass(frozen=True)
class Coloring:
    """A measure that is drawn as colours."""

    label: str  # the text at the colour bar
    #: computes the numbers from a mesh and the reference mesh; None if the mesh has no such numbers
    of: Callable[[MeshData, MeshData], Numbers | None]
    diverging: bool  # whether it has the diverging colour map
    limits: Limits | None = None  # the ends of the colour bar; None to compute them
    reason: str = "the meshes have none"  # why the meshes may have no such numbers

    def limits_for(self, numbers: Sequence[Numbers]) -> Limits:
        if self.limits is not None:
            return self.limits
        values = np.concatenate([n.values for n in numbers])
        return symmetric_limits(values) if self.diverging else robust_limits(values)

    def colors(self, values: Floats, limits: Limits, tolerance: float = 0.0) -> Floats:
        """Returns (k, 3) RGB colours from 0 to 1 of (k,) numbers; if diverging, numbers within the tolerance have one colour."""
        if not self.diverging:
            return sequential_colors(values, limits)[:, :3]
        if not tolerance > 0.0:
            return diverging_colors(values, limits)[:, :3]
        high = max(limits.high, -limits.low)
        share = np.clip((np.abs(values) - tolerance) / max(high - tolerance, 1e-12 * tolerance), 0.0, 1.0)
        colors = diverging_colors(np.sign(values) * (_BAND + (1.0 - _BAND) * share), Limits(-1.0, 1.0))[:, :3]
        return np.where((np.abs(values) <= tolerance)[:, None], _WITHIN, colors)


def in_unit(label: str, unit: str | None) -> str:
    """Replaces mesh units in a label by the unit of the scan, if there is one."""
    return re.sub("mesh units?", unit, label) if unit else label


def _distance(mesh: MeshData, reference: MeshData) -> Numbers | None:
    if mesh is reference:
        return None
    distances = Surface.of(reference.vertices, reference.faces).nearest(mesh.vertices).signed
    return Numbers(np.where(np.abs(distances) <= rounding_of(mesh, reference), 0.0, distances))


def _displacement(mesh: MeshData, reference: MeshData) -> Numbers | None:
    if mesh is reference or not same_elements(mesh, reference):
        return None
    return Numbers(vector_lengths(mesh.vertices - reference.vertices))


def _scalar(mesh: MeshData, reference: MeshData) -> Numbers | None:
    if mesh.has_vertex_scalars:
        return Numbers(mesh.vertex_scalars)
    return Numbers(mesh.face_scalars, by_face=True) if mesh.has_face_scalars and len(mesh.faces) else None


def _of_surface(measure: Callable[[Floats, Ints], Floats], *, by_face: bool = False) -> Callable[..., Numbers | None]:
    return lambda mesh, _: Numbers(measure(mesh.vertices, mesh.faces), by_face) if len(mesh.faces) else None


COLORINGS: Mapping[str, Coloring] = {
    "curvature": Coloring("mean curvature (1 / mesh unit)", _of_surface(mean_curvature), diverging=True),
    "gaussian": Coloring("Gaussian curvature (1 / squared mesh unit)", _of_surface(gaussian_curvature), diverging=True),
    "distance": Coloring(
        "distance from the first surface (mesh units, outwards above 0)",
        _distance,
        diverging=True,
        reason="it takes a second mesh, whose distance from the surface of the first is shown",
    ),
    "displacement": Coloring(
        "displacement of the vertices (mesh units)",
        _displacement,
        diverging=False,
        reason="it takes a second mesh with the vertex count and the faces of the first; 'distance' compares any two surfaces",
    ),
    "shape": Coloring(
        "triangle shape (1: equilateral)", _of_surface(triangle_shapes, by_face=True), diverging=False, limits=Limits(0.0, 1.0)
    ),
    "scalar": Coloring("scalar", _scalar, diverging=False),
}


OTHERS = ("plain", "own", "reflection")  # colorings without numbers: clay, the colours of the mesh itself, and reflection lines


def check_coloring(name: str) -> None:
    """Raises `ParameterError` with the nearest name if there is no such coloring."""
    names = [*OTHERS, *COLORINGS]
    if name not in names:
        raise ParameterError(f"{name!r} is no coloring; " + hint(name, names))


def numbers_of(coloring: str, meshes: Sequence[MeshData]) -> list[Numbers | None]:
    """Returns the numbers of each mesh; the first mesh is the reference."""
    numbers = [COLORINGS[coloring].of(mesh, meshes[0]) for mesh in meshes]
    if not any(numbers):
        raise MeshError(f"nothing to colour by {coloring}: {COLORINGS[coloring].reason}")
    return numbers


#: azimuth and elevation in degrees of the named views
VIEWS = {
    "front": (0.0, 0.0),
    "back": (180.0, 0.0),
    "right": (90.0, 0.0),
    "left": (-90.0, 0.0),
    "top": (0.0, 90.0),
    "bottom": (0.0, -90.0),
    "iso": (35.0, 25.0),
}
_MARGIN = 0.03  # the margin on every side, as a share of the picture


def view_angles(text: str) -> tuple[float, float]:
    """Returns azimuth and elevation in degrees of ``"front"``, ``"iso"`` ... or ``"AZ,EL"``."""
    if text in VIEWS:
        return VIEWS[text]
    try:
        azimuth, elevation = (float(part) for part in text.split(","))
    except ValueError:
        allowed = f"write {', '.join(VIEWS)} or AZIMUTH,ELEVATION in degrees"
        raise ParameterError(f"{text!r} is no view; {hint(text, VIEWS, allowed)}") from None
    if not (math.isfinite(azimuth) and -90.0 <= elevation <= 90.0):
        raise ParameterError(f"{text!r} is no view: the azimuth must be finite, and the elevation from -90 to 90 degrees")
    return azimuth, elevation


def view_rows(azimuth: float, elevation: float, up: str = "y") -> Floats:
    """Returns the (3, 3) directions to the right, upwards and to the eye; `up` is the upright axis, "y" or "z".

    The eye moves `azimuth` degrees to the right around `up`, and `elevation` degrees up. If both angles are 0, it looks
    along -z if y is up, and along +y if z is up.
    """
    a, e = math.radians(azimuth), math.radians(elevation)
    eye = np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    right = np.array([math.cos(a), 0.0, -math.sin(a)])
    rows = np.array([right, np.cross(eye, right), eye])
    if up == "y":
        return rows
    if up == "z":
        return np.asarray(rows @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))
    raise ParameterError(f"{up!r} is no upright axis: it is y or z")


def fitting_camera(clouds: Sequence[Floats], rows: Floats, aspect: float) -> Camera:
    """Returns a camera whose window contains all points of (n, 3) clouds; `aspect` is width / height of the window."""
    points = np.concatenate(clouds)
    # Relative to one of the points, since large coordinates lose digits in the rotation.
    low, high = bounding_box(rotated(points - points[0], rows))
    width, height = (high - low)[:2] / (1.0 - 2.0 * _MARGIN)
    height = max(float(height), float(width) / aspect) or 1.0
    return Camera(rows, points[0] + (low + high) / 2 @ rows, height * aspect, height)


_SCALE_BAR = 0.25  # the longest scale bar, as a share of the width of a panel


@dataclass(frozen=True)
class Appearance:
    """The settings of a picture."""

    color: str = "plain"  # one of `COLORINGS` or `OTHERS`
    azimuth: float = 0.0  # this and the next two: see `view_rows`
    elevation: float = 0.0
    up: str = "y"
    centre: tuple[float, float, float] | None = None  # of a close-up; None to show all
    extent: float = 0.0  # the shorter side of a close-up, in mesh units
    width: int = 640  # of a panel, in pixels
    height: int = 640
    stripes: float = 8.0  # see `reflection_stripes`
    titles: bool = True
    label: str = ""  # the text at the colour bar; empty for the label of the coloring
    columns: int = 4  # the most panels in a row
    limits: Limits | None = None  # see `Coloring`
    tolerance: float = 0.0  # see `Coloring.colors`
    unit: str = ""  # of the scan

    def camera(self, clouds: Sequence[Floats]) -> Camera:
        rows, aspect = view_rows(self.azimuth, self.elevation, self.up), self.width / self.height
        if self.centre is None:
            return fitting_camera(clouds, rows, aspect)
        height = self.extent / min(aspect, 1.0)
        return Camera(rows, np.asarray(self.centre, dtype=np.float64), height * aspect, height)


def draw_meshes(
    meshes: Sequence[MeshData], titles: Sequence[str], appearance: Appearance, *, numbers: Sequence[Numbers | None] | None = None
) -> Image.Image:
    """Draws meshes side by side with one camera, one scale bar and one colour bar.

    The first mesh is the reference of distances and displacements. `numbers` are as from `numbers_of`; None computes them.
    """
    check_coloring(appearance.color)
    if min(appearance.width, appearance.height) < 64 or max(appearance.width, appearance.height) > 8192:
        raise ParameterError(f"a panel has from 64 to 8192 pixels each way, not {appearance.width} x {appearance.height}")
    cells = [m.faces if len(m.faces) else m.edges for m in meshes]
    drawn = [mask_of(c, len(m.vertices)) if len(c) else ... for m, c in zip(meshes, cells, strict=True)]
    camera = appearance.camera([m.vertices[chosen] for m, chosen in zip(meshes, drawn, strict=True)])
    scenes, bar = _scenes(meshes, appearance, camera, numbers)
    columns = min(len(meshes), appearance.columns)
    rows = math.ceil(len(meshes) / columns)
    strip = TITLE_STRIP if appearance.titles else 0
    cell = strip + appearance.height
    picture = Image.new("RGB", (columns * appearance.width, rows * cell + (BAR_STRIP if bar else 0)), "white")
    for k, (scene, title) in enumerate(zip(scenes, titles, strict=True)):
        left, top = k % columns * appearance.width, k // columns * cell
        picture.paste(Image.fromarray(render(scene, camera, appearance.width, appearance.height)), (left, top + strip))
        if strip:
            draw = ImageDraw.Draw(picture)
            font, title = _fitting(draw, title, appearance.width - 12)
            draw.text((left + appearance.width / 2, top + TITLE_STRIP / 2), title, fill=INK, font=font, anchor="mm")
    draw_scale_bar(picture, 14, cell - 10, appearance.width / camera.width, _SCALE_BAR * appearance.width, appearance.unit)
    if bar is not None:
        coloring = COLORINGS[appearance.color]
        colors = partial(coloring.colors, tolerance=appearance.tolerance)
        draw_color_bar(picture, rows * cell + 4, bar, colors, appearance.label or in_unit(coloring.label, appearance.unit))
    return picture


def _scenes(
    meshes: Sequence[MeshData], appearance: Appearance, camera: Camera, numbers: Sequence[Numbers | None] | None
) -> tuple[list[Scene], Limits | None]:
    scenes = [Scene(m.vertices, m.faces, m.edges, normals=m.vertex_attributes.get("normals")) for m in meshes]
    if appearance.color in OTHERS:
        return [_painted(s, m, appearance, camera) for s, m in zip(scenes, meshes, strict=True)], None
    numbers = numbers_of(appearance.color, meshes) if numbers is None else numbers
    coloring = COLORINGS[appearance.color]
    limits = appearance.limits or coloring.limits_for([n for n in numbers if n is not None])
    return [
        s if n is None else replace(s, colors=coloring.colors(n.values, limits, appearance.tolerance), by_face=n.by_face)
        for s, n in zip(scenes, numbers, strict=True)
    ], limits


def _painted(scene: Scene, mesh: MeshData, appearance: Appearance, camera: Camera) -> Scene:
    if appearance.color == "reflection":
        if not len(scene.faces):
            raise MeshError(f"{mesh.label} has no faces for reflection lines")
        _, up, eye = camera.rows

        def paint(normals: Floats) -> Floats:
            bright = reflection_stripes(normals, view=eye, direction=up, stripes=appearance.stripes)
            return np.repeat(0.08 + 0.84 * bright[:, None], 3, axis=1)

        return replace(scene, paint=paint)
    if appearance.color == "own":
        if (texture := texture_of(mesh)) is not None:
            return replace(scene, texture=texture)
        if mesh.has_vertex_colors:
            return replace(scene, colors=mesh.vertex_colors[:, :3])
        if mesh.has_face_colors and len(mesh.faces):
            return replace(scene, colors=mesh.face_colors[:, :3], by_face=True)
        raise MeshError(f"{mesh.label} has no colours of its own")
    return scene


INK = (40, 44, 52)
TITLE_STRIP, BAR_STRIP = 34, 58  # heights in pixels of the strips for titles and for the colour bar
#: sizes of fonts in pixels: of titles, of other texts, and the smallest; a text that is too long for the smallest is shortened
_TITLE_SIZE, _SMALL, _SMALLEST = 17, 14, 10


def draw_scale_bar(picture: Image.Image, left: int, bottom: int, pixels_per_unit: float, most: float, unit: str = "") -> None:
    """Draws a bar of `round_length` mesh units, at most `most` pixels long, with its length above it."""
    length = round_length(most / pixels_per_unit)
    end = left + length * pixels_per_unit
    draw = ImageDraw.Draw(picture)
    # A white frame, since a close-up may be dark there.
    draw.rectangle((left - 2, bottom - 6, end + 2, bottom + 2), fill="white")
    draw.rectangle((left, bottom - 4, end, bottom), fill=INK)
    words, font = f"{number(length)} {unit}".strip(), ImageFont.load_default(_SMALL)
    draw.text((left, bottom - 9), words, fill=INK, font=font, anchor="ls", stroke_width=2, stroke_fill="white")


def draw_color_bar(
    picture: Image.Image, top: int, limits: Limits, colors: Callable[[Floats, Limits], Floats], label: str
) -> None:
    """Draws a colour bar half as wide as the picture, with numbers at its ends and its label."""
    width = picture.width // 2
    left = (picture.width - width) // 2
    low, high = limits
    row_colors = colors(np.linspace(low, high, width), limits) if high > low else colors(np.full(width, low), limits)
    row = np.asarray(np.rint(255.0 * row_colors), dtype=np.uint8)
    picture.paste(Image.fromarray(np.broadcast_to(row, (14, width, 3)).copy()), (left, top + 4))
    draw = ImageDraw.Draw(picture)
    draw.rectangle((left - 1, top + 3, left + width, top + 18), outline=INK)
    font = ImageFont.load_default(_SMALL)
    draw.text((left - 8, top + 11), number(low), fill=INK, font=font, anchor="rm")
    draw.text((left + width + 8, top + 11), number(high), fill=INK, font=font, anchor="lm")
    font, label = _fitting(draw, label, picture.width - 12, _SMALL)
    draw.text((picture.width / 2, top + 24), label, fill=INK, font=font, anchor="ma")


def round_length(most: float) -> float:
    """Returns the largest number that is 1, 2 or 5 times a power of ten and at most `most`, which is above 0."""
    power = 10.0 ** math.floor(math.log10(most))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= most * (1.0 + 1e-12))


def number(value: float) -> str:
    """Returns a number as text with three significant digits."""
    return f"{value + 0.0:.3g}"


def _fitting(draw: ImageDraw.ImageDraw, text: str, width: int, size: int = _TITLE_SIZE) -> tuple[Any, str]:
    """Returns a font in which the text is at most `width` wide, and the text, without its middle if no font fits."""
    text = text.replace("\n", " ")
    for pixels in range(size, _SMALLEST - 1, -1):
        font = ImageFont.load_default(pixels)
        if draw.textlength(text, font) <= width:
            return font, text
    length, short = len(text), text
    while length > 2 and draw.textlength(short, font) > width:
        length -= 1
        short = f"{text[: (length + 1) // 2]}...{text[len(text) - length // 2 :]}"
    return font, short
