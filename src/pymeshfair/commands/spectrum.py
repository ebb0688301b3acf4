"""``pymeshfair spectrum MESH``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import Json, Overwrite, Timeout
from .streams import print_document, say

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..declaration import Length
    from ..filters.spectral.problem import Response

#: the filter whose parameters the response has
FILTERS = "apply_coord_spectral_filter"
PICTURES = ("png", "svg", "pdf")


def spectrum(
    mesh: Annotated[Path, typer.Argument(metavar="MESH", help="The mesh file to look at; it is not changed.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="PICTURE", help="Draw the spectrum there: a .png, .svg or .pdf file."),
    ] = None,
    after: Annotated[
        Path | None, typer.Option(metavar="MESH2", help="Compare with this mesh, for example the same one cleaned.")
    ] = None,
    response: Annotated[
        str,
        typer.Option(
            metavar="low_pass|band_pass|enhance",
            help="Draw this response of the spectral filter too and, without MESH2, compare with what it leaves of MESH.",
        ),
    ] = "",
    detail_size: Annotated[
        str, typer.Option(metavar="LENGTH", help="Of the response, such as 6edge, 1% or 0.5; 6edge if not given.")
    ] = "",
    largest_size: Annotated[
        str, typer.Option(metavar="LENGTH", help="The longest wave of a band; four detail sizes if not given.")
    ] = "",
    modes: Annotated[int, typer.Option(help="How many modes are listed one by one, from the lowest.", min=0)] = 50,
    timeout: Timeout = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Tell how much of a shape lies at which wavelength, from its largest parts to its noise.

    Where the fall of the curve turns flat, noise begins: that wavelength is a detail size for smoothing.
    """
    from ..declaration import AUTO
    from ..errors import ParameterError, require_extra
    from ..files.formats import extension
    from ..files.writing import check_target, write_file
    from ..registry import find_filter

    if output is not None:
        require_extra("plot", "matplotlib")
        check_target(output, PICTURES, overwrite=overwrite)
    filtering = {}
    if response:
        values = {"response": response, "detail_size": detail_size or "6edge", "largest_size": largest_size or AUTO}
        checked = find_filter(FILTERS).with_defaults(values)
        filtering = {name: checked[name] for name in values}
        if _in_mesh_units(filtering["detail_size"], {"diagonal": 1.0, "mean_edge": 1.0}) == 0.0:
            raise ParameterError(f"detail_size {detail_size} is no wavelength: give a length above 0")
    elif detail_size or largest_size:
        raise ParameterError("--detail-size and --largest-size are those of a response: give --response too")
    before = _measured(mesh, modes, timeout)
    drawn = _response(filtering, before) if filtering else None
    shown = {"before": before}
    if after is not None:
        shown["after"] = _measured(after, modes, timeout)
    elif drawn is not None:
        shown["after"] = _filtered(before, drawn)
    if output is not None:
        from .spectrum_picture import draw_spectra

        write_file(output, draw_spectra(shown, drawn, extension(output)), overwrite=overwrite)
    if json:
        described = None
        if drawn is not None:
            described = {"name": drawn.name, "cutoff_frequencies": drawn.cutoffs, "bands": drawn.profile(_middles(before))}
        print_document({"mesh": mesh, **shown, "response": described, "picture": output})
        return
    _print(shown, drawn)
    if output is not None:
        say(f"{output}: written", err=True)


def _measured(mesh: Path, modes: int, timeout: float | None) -> dict[str, Any]:
    """The spectrum of a mesh file, with the progress of the process that measures it."""
    from ..running.read import reported_values
    from .progress import progress

    with progress() as show:
        return reported_values(mesh, "get_surface_spectrum", {"modes": modes}, timeout=timeout, on_event=show)


def _filtered(spectrum: Mapping[str, Any], response: Response) -> dict[str, Any]:
    """The spectrum of the filtered shape in the modes of the mesh before: F^2 times every energy."""
    import numpy as np

    edges = np.asarray(spectrum["band_edges"], dtype=np.float64)
    within = np.geomspace(edges[:-1], edges[1:], 9) if len(edges) else np.empty((1, 0))
    bands = np.asarray(spectrum["band_energies"]) * (response.profile(within) ** 2).mean(axis=0)
    modes = np.asarray(spectrum["energies"]) * response.profile(np.asarray(spectrum["frequencies"], dtype=np.float64)) ** 2
    return {**spectrum, "band_energies": bands.tolist(), "energies": modes.tolist(), "energy": float(bands.sum())}


def _response(filtering: Mapping[str, Any], spectrum: Mapping[str, Any]) -> Response:
    """F for the lengths of this mesh."""
    from ..errors import ParameterError
    from ..filters.checks import FilterInputError
    from ..filters.spectral.problem import RESPONSES
    from ..filters.spectral.spectral_filter import BAND

    detail_size, largest_size = (_in_mesh_units(filtering[name], spectrum) for name in ("detail_size", "largest_size"))
    sizes = (detail_size,) if filtering["response"] == "low_pass" else (detail_size, largest_size or BAND * detail_size)
    try:
        return RESPONSES[filtering["response"]](*sizes)
    except FilterInputError as error:
        raise ParameterError(str(error)) from error


def _in_mesh_units(length: Length | str, spectrum: Mapping[str, Any]) -> float:
    """0 for "auto"."""
    if isinstance(length, str):
        return 0.0
    return length.resolve(diagonal=spectrum["diagonal"], mean_edge=lambda: float(spectrum["mean_edge"]))


def _middles(spectrum: Mapping[str, Any]) -> Any:
    """The geometric mean frequency of each band."""
    import numpy as np

    edges = np.asarray(spectrum["band_edges"], dtype=np.float64)
    return np.sqrt(edges[:-1] * edges[1:])


def _print(spectra: Mapping[str, Mapping[str, Any]], response: Response | None) -> None:
    """A row for each band, from the longest waves to the shortest, with the root mean square height of its waves."""
    import math

    from .tables import console, table

    heights: dict[int, dict[str, float]] = {}
    first = spectra["before"]
    for name, spectrum in spectra.items():
        for omega, energy in zip(_middles(spectrum), spectrum["band_energies"], strict=True):
            heights.setdefault(round(3 * math.log2(omega) - 0.5), {})[name] = math.sqrt(max(energy, 0.0))
    headers = ["wavelength", "in mean edges", *(f"height {name}" if len(spectra) > 1 else "height" for name in spectra)]
    rows = []
    for band in sorted(heights):
        omega = 2.0 ** ((band + 0.5) / 3)
        row = [f"{2 * math.pi / omega:.4g}", f"{2 * math.pi / omega / first['mean_edge']:.3g}"]
        row += [f"{heights[band][name]:.3g}" if name in heights[band] else "" for name in spectra]
        if response is not None:
            row.append(f"{float(response.profile(omega)):.3f}")
        rows.append(row)
    if response is not None:
        headers.append(response.name)
    console().print(table(headers, rows, numbers=range(len(headers))))
    typer.echo(
        "\nheight: the root mean square, in mesh units, of what the waves of a third of an octave add to the surface", err=True
    )
