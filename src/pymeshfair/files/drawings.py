"""Writes curves as drawings: DXF of release 12, in space, and SVG, in the plane that they lie in."""

from collections.abc import Iterator
from typing import BinaryIO

import numpy as np

from ..mesh_data import MeshData
from .errors import ContentsError
from .outputs import Writing

#: curves that leave their plane by a greater share of their extent lose a coordinate in an SVG, with a note
_FLAT = 1e-6
#: the units of a mesh that SVG has too
_UNITS = ("mm", "cm", "in")


def polylines(edges: np.ndarray) -> Iterator[list[int]]:
    """The curves that (e, 2) edges make up, from end or fork to the next; a closed one ends with its first vertex."""
    at: dict[int, list[int]] = {}
    left, pairs = [True] * len(edges), edges.tolist()
    for number, ends in enumerate(pairs):
        for vertex in ends:
            at.setdefault(vertex, []).append(number)
    # Closed curves have no end: they come last, from any vertex.
    for start in sorted(at, key=lambda vertex: (len(at[vertex]) == 2, vertex)):
        for first in at[start]:
            curve, number = [start], first
            while left[number]:
                left[number] = False
                a, b = pairs[number]
                curve.append(b if a == curve[-1] else a)
                if len(at[curve[-1]]) != 2 or curve[-1] == start:
                    break
                number = next((other for other in at[curve[-1]] if left[other]), number)
            if len(curve) > 1:
                yield curve


def write_dxf(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Write curves as polylines in space, every digit of their coordinates."""
    lines = ["0", "SECTION", "2", "HEADER", "9", "$ACADVER", "1", "AC1009", "0", "ENDSEC", "0", "SECTION", "2", "ENTITIES"]
    for curve in _curves(mesh):
        is_closed = curve[0] == curve[-1]
        lines += ["0", "POLYLINE", "8", "0", "66", "1", "10", "0.0", "20", "0.0", "30", "0.0", "70", str(8 + is_closed)]
        for place in mesh.vertices[curve[: len(curve) - is_closed]].tolist():
            numbers = [word for k, c in enumerate(place) for word in (f"{k + 1}0", repr(c))]
            lines += ["0", "VERTEX", "8", "0", *numbers, "70", "32"]
        lines += ["0", "SEQEND", "8", "0"]
    target.write("\n".join([*lines, "0", "ENDSEC", "0", "EOF", ""]).encode("ascii"))
    return ()


def write_svg(mesh: MeshData, target: BinaryIO, writing: Writing) -> tuple[str, ...]:
    """Write curves as paths without the coordinate along which they extend least, upright, in mesh units."""
    curves = _curves(mesh)
    used = mesh.vertices[np.unique(mesh.edges)]
    sizes = np.ptp(used, axis=0)
    axis = int(sizes.argmin())
    flat = np.delete(mesh.vertices, axis, axis=1) * [1.0, -1.0]
    low, size = np.delete(used, axis, axis=1), np.delete(sizes, axis)
    left, top = low[:, 0].min(), -low[:, 1].max()
    unit = mesh.unit if mesh.unit in _UNITS else ""
    places = [("L".join(f"{x!r},{y!r}" for x, y in flat[c].tolist()), "Z" if c[0] == c[-1] else "") for c in curves]
    paths = "\n".join(f'<path d="M{line}{end}"/>' for line, end in places)
    target.write(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]:.9g}{unit}" height="{size[1]:.9g}{unit}" '
        f'viewBox="{left:.9g} {top:.9g} {size[0]:.9g} {size[1]:.9g}" overflow="visible">\n'
        f'<g fill="none" stroke="black" stroke-width="{1e-3 * size.max():.3g}">\n{paths}\n</g>\n</svg>\n'.encode("ascii")
    )
    if sizes[axis] <= _FLAT * sizes.max():
        return ()
    return (f"the coordinate {'xyz'[axis]} of the curves, which extends over {sizes[axis]:.3g}, is left out; .dxf keeps it",)


def _curves(mesh: MeshData) -> list[list[int]]:
    if not len(mesh.edges):
        raise ContentsError("a drawing holds curves, and the mesh has none: the recipe smooth_section cuts some")
    return list(polylines(mesh.edges))
