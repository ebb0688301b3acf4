"""Sections for pages: the outlines of two meshes in a plane, as SVG with a scale bar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..declaration import Floats
from ..looking.annotation import number, round_length
from ..looking.section import Plane, outline
from ..mesh_data import MeshData

#: of a section in its own units; a page scales it
_WIDTH, _HEIGHT, _MARGIN = 460, 320, 16


@dataclass(frozen=True)
class SectionChart:
    """What the template of a section draws.

    Attributes:
        title: which plane, and what goes to the right and upwards.
        before: the path of the outline of the first mesh.
        after: that of the second.
        bar: the length of the scale bar in the picture.
        bar_words: its length in mesh units, with the unit if it is known.
    """

    title: str
    before: str
    after: str
    bar: float
    bar_words: str
    width: int = _WIDTH
    height: int = _HEIGHT


def section_chart(before: MeshData, after: MeshData, plane: Plane, unit: str | None = None) -> SectionChart | None:
    """The section of both meshes; None if the plane cuts neither. `unit` is that of the scan, if it is known."""
    outlines = [outline(mesh, plane) for mesh in (before, after)]
    every = np.concatenate(outlines).reshape(-1, 2)
    if not len(every):
        return None
    low, high = every.min(axis=0), every.max(axis=0)
    room = np.array([_WIDTH - 2 * _MARGIN, _HEIGHT - 3 * _MARGIN])
    scale = float((room / np.maximum(high - low, 1e-300)).min())
    right, up = [axis for k, axis in enumerate("xyz") if k != plane.axis]
    paths = [_path(segments, low, scale) for segments in outlines]
    bar = round_length(0.25 * _WIDTH / scale)
    title = f"Section {plane}; {right} to the right, {up} upwards"
    return SectionChart(title, paths[0], paths[1], bar * scale, f"{number(bar)} {unit or ''}".strip())


def _path(segments: Floats, low: Floats, scale: float) -> str:
    places = (segments - low) * scale
    x, y = places[..., 0] + _MARGIN, _HEIGHT - 2 * _MARGIN - places[..., 1]
    return "".join(f"M{a:.2f} {b:.2f}L{c:.2f} {d:.2f}" for (a, c), (b, d) in zip(x.tolist(), y.tolist(), strict=True))
