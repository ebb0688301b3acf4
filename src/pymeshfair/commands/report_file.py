"""The option ``--report`` of commands: one HTML file about two meshes, and about the run between them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from ..looking.mesh_state import MeshState
    from ..report.comparison_page import Compared

Report = Annotated[
    Path | None,
    typer.Option(
        "--report",
        metavar="OUT.html",
        help="Write a page that needs no network: pictures, 3D, numbers, charts, steps.",
    ),
]
Up = Annotated[str, typer.Option("--up", metavar="y|z", help="The upright axis in the pictures of the report.")]
#: vertices of a mesh beyond which its spectrum takes longer than all the rest of a report
MOST_OF_SPECTRUM = 200_000


def check_report(path: Path, up: str, *, overwrite: bool) -> None:
    """Refuse a report that could not be written, before anything is computed."""
    from ..files.writing import check_target
    from ..looking.camera import view_rows

    check_target(path, ("html", "htm"), overwrite=overwrite)
    view_rows(0.0, 0.0, up)


def compared_files(before: MeshState, after: MeshState, *, tolerance: float | None = None) -> tuple[Compared, list[str]]:
    """The comparison of two meshes that were read from files, and the parts left out of it, with the reason."""
    from ..errors import PymeshfairError
    from ..looking.comparison import compare
    from ..report.comparison_page import Compared
    from ..running.read import reported_values

    comparison, distances = compare(before, after, tolerance=tolerance)
    spectra: dict[str, Any] = {}
    left_out = []
    if before.self_intersecting is None and after.self_intersecting is None:
        left_out.append("Faces that cut others were not looked for: `compare --self-intersections` does, in large meshes, too.")
    if max(len(before.mesh.vertices), len(after.mesh.vertices)) > MOST_OF_SPECTRUM:
        left_out.append(f"No spectrum: a mesh has more than {MOST_OF_SPECTRUM:,} vertices. `pymeshfair spectrum` takes its time.")
    else:
        try:
            for name, state in (("before", before), ("after", after)):
                spectra[name] = reported_values(state.path, "get_surface_spectrum", {"modes": 0})
        except PymeshfairError as error:
            spectra.clear()
            left_out.append(f"No spectrum: {error}")
    return Compared(before, after, comparison, distances, spectra), left_out


def page_numbers(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """The document of a command in terms of JSON, with names of files alone, as a page has it."""
    from .streams import plain

    return dict(plain({**numbers, "files": {key: path and path.name for key, path in numbers["files"].items()}}))
