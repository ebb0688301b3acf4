"""Renders one panel: rasterises triangles or dots into a depth buffer, and shades its pixels with colours or textures."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..declaration import Bools, Floats, Ints
from ..errors import MeshError
from ..filters.compilation import compiled
from ..filters.geometry import face_normals, unit_vectors
from ..filters.inspection import mesh_normals
from ..filters.mesh import mask_of
from ..mesh_data import MeshData
from ..mesh_data.mesh_data import read_pixels, sampled

SUPERSAMPLING = 2  # the number of samples of a pixel in each direction
CLAY = np.array([0.72, 0.745, 0.78])  # the colour of a mesh without colours
_INSIDE = np.array([0.55, 0.36, 0.30])  # the colour that is mixed into the colours of the inner side of a surface
_BACKGROUND = 1.0
_LIGHT = np.array([-0.38, 0.48, 0.79])  # the direction to the light, behind the eye at the upper left
_LIGHT /= math.sqrt(float(_LIGHT @ _LIGHT))
_SHININESS = 40
_DOT = 1.1  # radius in pixels of the dots that draw clouds and polylines
_LONGEST = 20_000  # about the most dots of one edge; in a close-up an edge may reach far outside the picture
_CLAY_LIGHT = (0.20, 0.85, 0.32)  # shares of ambient, diffuse and specular light, for the faces of a mesh without colours
#: shares for dots, and for faces with colours, which must stay near the colours of the colour bar
_NUMBERS_LIGHT = (0.45, 0.58, 0.06)


@dataclass(frozen=True)
class Camera:
    """A parallel projection."""

    rows: Floats  # (3, 3) the directions to the right, upwards and to the eye
    centre: Floats  # (3,) the point in the middle of the picture
    width: float  # of the window, in mesh units
    height: float

    def screen(self, vertices: Floats, columns: int, rows: int) -> Floats:
        """Returns (n, 3): pixels from the left, pixels from the top, and nearness to the eye in mesh units."""
        scale = np.array([columns / self.width, -rows / self.height, 1.0])
        positions = rotated(vertices - self.centre, scale[:, None] * self.rows)
        positions += [columns / 2, rows / 2, 0.0]
        return positions


def rotated(vectors: Floats, rows: Floats) -> Floats:
    """Returns the (n, 3) dot products of vectors with `rows`; for three columns einsum is faster than a matrix product."""
    return np.asarray(np.einsum("ij,kj->ik", vectors, rows))


@dataclass(frozen=True, eq=False)
class Scene:
    """The contents of one panel: a mesh, a cloud, or polylines."""

    vertices: Floats  # (n, 3)
    faces: Ints  # (m, 3)
    edges: Ints  # (e, 2) of polylines, drawn if there are no faces
    colors: Floats | None = None  # (n, 3) colours of vertices, or (m, 3) of faces with `by_face`, from 0 to 1; None for clay
    by_face: bool = False
    normals: Floats | None = None  # (n, 3) of a cloud, for its shading
    texture: Sampler | None = None  # replaces `colors`
    #: replaces colours and light: computes (k, 3) colours from (k, 3) unit normals in mesh coordinates
    paint: Callable[[Floats], Floats] | None = None


def render(scene: Scene, camera: Camera, width: int, height: int) -> NDArray[np.uint8]:
    """Returns the (height, width, 3) pixels of a panel.

    Every triangle is drawn, with flat shading, so that noise is visible; a `paint` gets interpolated normals.
    """
    columns, rows = width * SUPERSAMPLING, height * SUPERSAMPLING
    buffer = DepthBuffer(np.full((rows, columns), -1, dtype=np.int32), np.full((rows, columns), -np.inf))
    screen = camera.screen(scene.vertices, columns, rows)
    if len(scene.faces):
        draw_triangles(screen, scene.faces, *buffer)
    else:
        points, owners = _dots(scene, screen)
        draw_dots(points, _DOT * SUPERSAMPLING, *buffer)
        seen = buffer.elements >= 0
        buffer.elements[seen] = owners[buffer.elements[seen]]
    seen = buffer.elements >= 0
    pixels = np.full((rows, columns, 3), _BACKGROUND, dtype=np.float32)
    if seen.any():
        shade = _shade_surface if len(scene.faces) else _shade_dots
        pixels[seen] = shade(scene, camera, screen, buffer, seen)
    averaged = pixels.reshape(height, SUPERSAMPLING, width, SUPERSAMPLING, 3).mean(axis=(1, 3))
    return np.asarray(np.rint(255.0 * np.clip(averaged, 0.0, 1.0)), dtype=np.uint8)


def _shade_surface(scene: Scene, camera: Camera, screen: Floats, buffer: DepthBuffer, seen: Bools) -> Floats:
    elements = buffer.elements[seen]

    def at_pixels(values: Floats) -> Floats:
        weights, corners = _weights(screen, scene.faces, elements, seen), scene.faces[elements]
        return np.asarray(sum(weights[:, k, None] * values[corners[:, k]] for k in range(3)))

    if scene.paint is not None:
        normals = unit_vectors(at_pixels(mesh_normals(scene.vertices, scene.faces)))
        # The inner side of a surface reflects, too.
        normals[normals @ camera.rows[2] < 0.0] *= -1.0
        return scene.paint(normals)
    in_front = mask_of(elements, len(scene.faces))
    rows = (np.cumsum(in_front) - 1)[elements]
    # Coordinates are relative to the middle of the picture, since normals of large coordinates lose digits.
    normals = face_normals(scene.vertices - camera.centre, scene.faces[in_front]) @ camera.rows.T
    if scene.texture is not None:
        colors = scene.texture(elements, _weights(screen, scene.faces, elements, seen))
    elif scene.colors is None:
        return np.asarray(_shade(normals, np.broadcast_to(CLAY, normals.shape), _CLAY_LIGHT)[rows])
    else:
        colors = scene.colors[elements] if scene.by_face else at_pixels(scene.colors)
    return _shade(normals, colors, _NUMBERS_LIGHT, rows)


def _shade_dots(scene: Scene, camera: Camera, screen: Floats, buffer: DepthBuffer, seen: Bools) -> Floats:
    points = buffer.elements[seen]
    colors = np.broadcast_to(CLAY, (len(points), 3)) if scene.colors is None else scene.colors[points]
    if scene.normals is not None and not len(scene.edges):
        normals = np.nan_to_num(scene.normals[points], posinf=0.0, neginf=0.0) @ camera.rows.T
        return _shade(np.where(normals[:, 2:] < 0.0, -normals, normals), colors, _NUMBERS_LIGHT)
    # Without normals the depth shows the shape: far points are paler.
    depths = screen[:, 2]
    far = (depths.max() - buffer.depths[seen]) / (np.ptp(depths) or 1.0)
    strength = (1.0 - 0.55 * far)[:, None]
    return np.asarray(_BACKGROUND + strength * ((0.8 if scene.colors is None else 1.0) * colors - _BACKGROUND))


def _shade(normals: Floats, colors: Floats, shares: tuple[float, float, float], rows: Ints | slice = slice(None)) -> Floats:
    """Returns (k, 3) shaded colours; `shares` are those of ambient, diffuse and specular light.

    The (m, 3) normals are in camera coordinates; surfaces that face away from the camera show their inner side. Colour i belongs
    to the normal ``rows[i]``.
    """
    inside = normals[:, 2:] < 0.0
    facing = np.where(inside, -normals, normals)
    halfway = _LIGHT + np.array([0.0, 0.0, 1.0])
    halfway /= math.sqrt(float(halfway @ halfway))
    diffuse, shine = np.clip(facing @ _LIGHT, 0.0, 1.0)[:, None], np.clip(facing @ halfway, 0.0, 1.0)[:, None] ** _SHININESS
    colors = np.where(inside[rows], 0.45 * colors + 0.55 * _INSIDE, colors) if inside.any() else colors
    ambient, scattered, specular = shares
    return np.asarray((ambient + scattered * diffuse[rows]) * colors + specular * shine[rows] * (1.0 - 0.5 * colors))


def _weights(screen: Floats, faces: Ints, elements: Ints, seen: Bools) -> Floats:
    """Returns the (k, 3) barycentric coordinates of the centres of the pixels in the mask `seen`."""
    rows, columns = np.nonzero(seen)
    x, y = columns + 0.5, rows + 0.5
    a, b, c = (screen[faces[elements, k], :2].T for k in range(3))
    u = (b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)
    v = (c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)
    w = (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x)
    return np.asarray(np.column_stack([u, v, w]) / (u + v + w)[:, None])


def _dots(scene: Scene, screen: Floats) -> tuple[Floats, Ints]:
    """Returns the dots that draw a cloud or polylines, and the vertex whose colour each dot has."""
    if not len(scene.edges):
        return screen, np.arange(len(screen), dtype=np.int32)
    start, end = screen[scene.edges[:, 0]], screen[scene.edges[:, 1]]
    counts = np.ceil(np.minimum(np.linalg.norm((end - start)[:, :2], axis=1), _LONGEST)).astype(np.int64) + 1
    edge = np.repeat(np.arange(len(counts)), counts)
    t = (np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)) / np.maximum(counts - 1, 1)[edge]
    owners = np.where(t < 0.5, scene.edges[edge, 0], scene.edges[edge, 1]).astype(np.int32)
    return start[edge] + t[:, None] * (end - start)[edge], owners


class DepthBuffer(NamedTuple):
    """The face or dot nearest to the eye at each of h x w pixels, row 0 at the top."""

    elements: Ints  # (h, w) its number; -1 for background
    depths: NDArray[np.float64]  # (h, w) its nearness to the eye; -inf for background


@compiled
def draw_triangles(screen: Floats, faces: Ints, elements: Ints, depths: Floats) -> None:
    """Draws triangles of either orientation into a `DepthBuffer`; at equal depth the face with the lower number stays.

    `screen` is as `Camera.screen` returns it.
    """
    height, width = elements.shape
    for f in range(faces.shape[0]):
        ax, ay, az = screen[faces[f, 0]]
        bx, by, bz = screen[faces[f, 1]]
        cx, cy, cz = screen[faces[f, 2]]
        doubled = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not (doubled != 0.0 and math.isfinite(doubled)):
            continue
        left = max(math.ceil(max(min(ax, bx, cx), 0.0) - 0.5), 0)
        right = min(math.floor(min(max(ax, bx, cx), float(width)) - 0.5), width - 1)
        top = max(math.ceil(max(min(ay, by, cy), 0.0) - 0.5), 0)
        bottom = min(math.floor(min(max(ay, by, cy), float(height)) - 0.5), height - 1)
        for row in range(top, bottom + 1):
            y = row + 0.5
            for column in range(left, right + 1):
                x = column + 0.5
                u = ((bx - x) * (cy - y) - (by - y) * (cx - x)) / doubled
                v = ((cx - x) * (ay - y) - (cy - y) * (ax - x)) / doubled
                w = ((ax - x) * (by - y) - (ay - y) * (bx - x)) / doubled
                if u >= 0.0 and v >= 0.0 and w >= 0.0:
                    depth = u * az + v * bz + w * cz
                    if depth > depths[row, column]:
                        depths[row, column] = depth
                        elements[row, column] = f


@compiled
def draw_dots(screen: Floats, radius: float, elements: Ints, depths: Floats) -> None:
    """Draws a disc for every point; `radius` is in pixels. See `draw_triangles`."""
    height, width = elements.shape
    for i in range(screen.shape[0]):
        x, y, z = screen[i]
        if not (x > -radius and x < width + radius and y > -radius and y < height + radius):
            continue
        for row in range(max(math.ceil(y - radius - 0.5), 0), min(math.floor(y + radius - 0.5), height - 1) + 1):
            for column in range(max(math.ceil(x - radius - 0.5), 0), min(math.floor(x + radius - 0.5), width - 1) + 1):
                dx, dy = column + 0.5 - x, row + 0.5 - y
                if dx * dx + dy * dy <= radius * radius and z > depths[row, column]:
                    depths[row, column] = z
                    elements[row, column] = i


Sampler = Callable[[Ints, Floats], Floats]  # returns (k, 3) colours from 0 to 1 of (k,) faces at (k, 3) barycentric coordinates


def texture_of(mesh: MeshData) -> Sampler | None:
    """Returns a sampler of the textures, with face colours or clay where a face has none; None without coordinates or images.

    The sampler takes the nearest pixel, and repeats images beyond their edges. An image that cannot be read raises `MeshError`.
    """
    corners = mesh.face_attributes.get("wedge_texture_coordinates")
    if corners is None and "texture_coordinates" in mesh.vertex_attributes:
        corners = mesh.vertex_attributes["texture_coordinates"][mesh.faces]
    if corners is None or not mesh.textures or not len(mesh.faces):
        return None
    of_faces = mesh.face_attributes.get("texture", np.zeros(len(mesh.faces), dtype=np.int32))
    images = []
    for texture in mesh.textures:
        pixels = read_pixels(texture)
        if pixels is None:
            why = "there is no such file" if texture.image is None else "it is no readable image"
            raise MeshError(f"the texture {texture.name!r} of {mesh.label} cannot be drawn: {why}")
        images.append(pixels)

    def sample(faces: Ints, weights: Floats) -> Floats:
        texture_points = np.einsum("ki,kij->kj", weights, corners[faces])
        colors = mesh.face_colors[faces, :3] if mesh.has_face_colors else np.broadcast_to(CLAY, (len(faces), 3)).copy()
        for number, pixels in enumerate(images):
            in_image = of_faces[faces] == number
            colors[in_image] = sampled(pixels, texture_points[in_image])
        return colors

    return sample
