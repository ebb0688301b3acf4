"""Pictures of arrays, side by side from one camera: for the examples, and for the pictures of the pages."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from pymeshfair.looking.picture import Appearance, draw_meshes
from pymeshfair.looking.shading import CLAY
from pymeshfair.mesh_data import MeshData, as_levels

#: the colour of faces that are marked
_MARK = np.array([0.95, 0.60, 0.22])


@dataclass(frozen=True, eq=False)
class Panel:
    """One mesh of a picture."""

    title: str  # the text above
    vertices: ArrayLike  # (n, 3) coordinates
    faces: ArrayLike = ()  # (m, 3) triangles; none for a cloud or polylines
    edges: ArrayLike = ()  # (e, 2) edges of polylines
    scalars: ArrayLike | None = None  # (n,) numbers that become colours with ``Appearance("scalar")``
    colors: ArrayLike | None = None  # (n, 3) from 0 to 1, shown with ``Appearance("own")``
    marked: ArrayLike | None = None  # (m,) bool, faces that are tinted; then the picture is coloured by ``"own"``


def draw_panels(panels: Sequence[Panel], appearance: Appearance | None = None) -> Image.Image:
    """Draw meshes side by side as `draw_meshes` does; the first is the reference of displacements."""
    how = appearance or Appearance(width=300, height=300)
    some_marked = any(panel.marked is not None for panel in panels)
    if some_marked:
        how = replace(how, color="own")
    return draw_meshes([_mesh(panel, tinted=some_marked) for panel in panels], [panel.title for panel in panels], how)


def named_output() -> Path:
    """Return the path of the picture that the command line of an example names, its one argument."""
    if len(sys.argv) != 2:
        raise SystemExit(f"usage: python {sys.argv[0]} OUT.png, a picture to write")
    return Path(sys.argv[1])


def save_picture(path: Path, *pictures: Image.Image, across: bool = False, full_color: bool = False) -> None:
    """Write pictures below, or `across` beside each other into a PNG file, of 256 colours unless `full_color`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    widths, heights = [p.width for p in pictures], [p.height for p in pictures]
    size = (sum(widths), max(heights)) if across else (max(widths), sum(heights))
    whole = Image.new("RGB", size, "white")
    for k, picture in enumerate(pictures):
        whole.paste(picture, (sum(widths[:k]), 0) if across else (0, sum(heights[:k])))
    (whole if full_color else whole.quantize(256)).save(path, format="PNG", optimize=True)


def _mesh(panel: Panel, *, tinted: bool) -> MeshData:
    mesh = MeshData(
        vertices=np.asarray(panel.vertices), faces=np.asarray(panel.faces), edges=np.asarray(panel.edges), label=panel.title
    )
    marked = np.zeros(len(mesh.faces), dtype=np.bool_) if panel.marked is None else np.asarray(panel.marked)
    return mesh.with_attributes(
        {
            "scalars": None if panel.scalars is None else np.asarray(panel.scalars, dtype=np.float64),
            "colors": None if panel.colors is None else _levels(np.asarray(panel.colors)),
        },
        {"colors": _levels(np.where(marked[:, None], _MARK, CLAY)) if tinted else None},
    )


def _levels(colors: Any) -> Any:
    """(k, 4) opaque colours as levels of (k, 3) colours from 0 to 1."""
    return as_levels(np.concatenate([colors, np.ones((len(colors), 1))], axis=1))
