"""``pymeshfair picture MESH... -o OUT.png``: draws meshes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from . import options
from .streams import print_document, say, warn

if TYPE_CHECKING:
    from ..running.read import ReadMesh

#: the extensions of pictures, and Pillow's names of their formats
PICTURES = {"png": "PNG", "jpg": "JPEG", "jpeg": "JPEG", "webp": "WEBP"}


def picture(
    meshes: Annotated[list[Path], Argument(metavar="MESH...", help="The mesh files to draw; none is changed.")],
    output: Annotated[Path, Option("--output", "-o", metavar="PICTURE", help="A .png, .jpg or .webp file to write.")],
    color: Annotated[
        str,
        Option(
            metavar="plain|own|curvature|gaussian|distance|displacement|reflection|shape|scalar",
            help="What the colours show; 'own' shows the mesh's colours; distance and displacement are from the first mesh.",
        ),
    ] = "plain",
    view: Annotated[
        str,
        Option(metavar="front|back|left|right|top|bottom|iso|AZ,EL", help="A side, or degrees that the eye moves right and up."),
    ] = "front",
    up: options.Up = None,
    zoom: Annotated[
        str, Option(metavar="X,Y,Z,SIZE|vertex=N,SIZE", help="Zoom in; vertex N is of the last mesh. SIZE: 20, 10%, 30edge.")
    ] = "",
    size: Annotated[str, Option(metavar="WIDTHxHEIGHT", help="The size of each panel in pixels.")] = "640x640",
    title: Annotated[list[str] | None, Option(metavar="TEXT", help="One title for each MESH; by default the file names.")] = None,
    stripes: Annotated[float | None, Option(help="Reflection lines, by default 8; more show smaller defects.", min=1)] = None,
    limits: options.Limits = None,
    tolerance: options.Tolerance = None,
    unit: options.Unit = None,
    allow_outside: options.AllowOutside = False,
    unchecked: options.Unchecked = False,
    overwrite: options.Overwrite = False,
    json: options.Json = False,
) -> None:
    """Draw meshes from one camera, with a scale bar and, if colours show numbers, a colour bar.

    Needs neither a display nor a graphics card.
    """
    import io

    from ..declaration.parameters import Length, doubts_of_typed_unit
    from ..errors import ParameterError
    from ..files.formats import extension
    from ..files.writing import check_target, write_file
    from ..looking.picture import COLORINGS, Appearance, check_coloring, draw_meshes, view_angles
    from ..running.read import read_mesh

    check_target(output, PICTURES, overwrite=overwrite)
    check_coloring(color)
    coloring = COLORINGS.get(color)
    options.refuse_unused(
        f"--color {color} does not show it: leave it out, or choose another --color",
        limits=None if coloring else limits,
        tolerance=None if color == "distance" else tolerance,
        stripes=None if color == "reflection" else stripes,
    )
    parts = limits.split(",") if limits and color not in ("distance", "displacement") else ()
    if any(Length.parse(part, "--limits").unit != "absolute" for part in parts):
        raise ParameterError(f"--limits {limits}: --color {color} shows no lengths; write numbers without a unit")
    azimuth, elevation = view_angles(view)
    try:
        width, height = (int(part) for part in size.casefold().split("x"))
    except ValueError:
        raise ParameterError(f"{size!r} is no size: write WIDTHxHEIGHT in pixels, such as 800x600") from None
    if title is not None and len(title) != len(meshes):
        raise ParameterError(f"{len(title)} titles for {len(meshes)} meshes: give one --title for each, or none")
    opened = [read_mesh(path, allow_outside=allow_outside, unchecked=unchecked) for path in meshes]
    warn(*dict.fromkeys(w for mesh in opened for w in mesh.warnings), *doubts_of_typed_unit(unit, opened[0].mesh.unit))
    units = dict.fromkeys(u for u in (unit or opened[0].mesh.unit, *(read.mesh.unit for read in opened[1:])) if u)
    if len(units) > 1:
        warn(f"the meshes are in {' and '.join(units)}: they are drawn with the coordinates of their files")
    unit, assumed = options.assumed_unit(unit, {str(read.path): read.mesh.unit for read in opened})
    warn(*assumed)
    centre, extent = _region(zoom, opened[-1], unit) if zoom else (None, 0.0)
    measured = opened[0].measured
    allowed, ends = options.lengths_in_mesh_units(tolerance, limits, unit, measured.diagonal, measured.resolution())
    appearance = Appearance(
        unit=unit or "",
        limits=ends,
        tolerance=allowed or 0.0,
        color=color,
        azimuth=azimuth,
        elevation=elevation,
        up=up or "y",
        centre=centre,
        extent=extent,
        width=width,
        height=height,
        stripes=stripes or 8.0,
    )
    drawn = draw_meshes([read.mesh for read in opened], title or [path.name for path in meshes], appearance)
    drawn.save(encoded := io.BytesIO(), format=PICTURES[extension(output)])
    write_file(output, encoded.getvalue(), overwrite=overwrite)
    if json:
        print_document({"picture": output, "width": drawn.width, "height": drawn.height, "meshes": meshes})
    else:
        say(f"Written: {output} ({drawn.width} x {drawn.height} pixels)")


def _region(text: str, read: ReadMesh, unit: str | None) -> tuple[tuple[float, float, float], float]:
    from ..declaration import Length
    from ..errors import ParameterError

    *place, size = text.split(",")
    wanted, measured = Length.parse(size, f"--zoom {text}").in_mesh_units(unit), read.measured
    extent = wanted.resolve(diagonal=measured.diagonal, mean_edge=measured.resolution)
    if not extent > 0.0:
        raise ParameterError(f"--zoom {text}: the size of a close-up must be above 0")
    count = len(read.mesh.vertices)
    try:
        if len(place) == 1 and place[0].startswith("vertex="):
            x, y, z = read.mesh.vertices[range(count).index(int(place[0].removeprefix("vertex=")))]
        else:
            x, y, z = (float(part) for part in place)
        if not math.isfinite(x + y + z):
            raise ValueError
    except ValueError:
        raise ParameterError(
            f"--zoom {text}: write X,Y,Z,SIZE or vertex=N,SIZE, with N below the vertex count {count} of {read.path.name}"
        ) from None
    return (float(x), float(y), float(z)), extent
