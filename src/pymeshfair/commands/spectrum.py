"""``pymeshfair spectrum MESH``."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Argument, Option

from .options import Json, Overwrite, Timeout
from .streams import print_document, say

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..declaration import Length
    from ..filters.spectral.problem import Response

PICTURES = ("png", "svg", "pdf")


def spectrum(
    mesh: Annotated[Path, Argument(metavar="MESH", help="The mesh file to look at; it is not changed.")],
    output: Annotated[Path | None, Option("--output", "-o", metavar="PICTURE", help="A .png, .svg or .pdf file to draw.")] = None,
    after: Annotated[Path | None, Option(metavar="MESH2", help="Compare with this mesh.")] = None,
    response: Annotated[
        str, Option(metavar="low_pass|band_pass|enhance", help="Draw this response, too, and what it leaves of MESH.")
    ] = "",
    detail_size: Annotated[str, Option(metavar="LENGTH", help="Of the response, such as 1% or 0.5; else 6edge.")] = "",
    largest_size: Annotated[str, Option(metavar="LENGTH", help="The longest wave of a band; else four detail sizes.")] = "",
    modes: Annotated[int, Option(help="How many modes are listed one by one, from the lowest.", min=0)] = 50,
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
        checked = find_filter("apply_coord_spectral_filter").with_defaults(values)
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
    from .display import progress

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
    from .display import show_table

    heights: dict[int, dict[str, float]] = {}
    for name, spectrum in spectra.items():
        for omega, energy in zip(_middles(spectrum), spectrum["band_energies"], strict=True):
            heights.setdefault(round(3 * math.log2(omega) - 0.5), {})[name] = math.sqrt(max(energy, 0.0))
    headers = ["wavelength", "in mean edges", *(f"height {name}" if len(spectra) > 1 else "height" for name in spectra)]
    headers += [response.name] if response is not None else []
    rows = []
    for band, at_band in sorted(heights.items()):
        omega = 2.0 ** ((band + 0.5) / 3)
        row = [f"{2 * math.pi / omega:.4g}", f"{2 * math.pi / omega / spectra['before']['mean_edge']:.3g}"]
        row += [f"{at_band[name]:.3g}" if name in at_band else "" for name in spectra]
        rows.append(row if response is None else [*row, f"{float(response.profile(omega)):.3f}"])
    show_table(headers, *rows, numbers=range(len(headers)))
    typer.echo(
        "\nheight: the root mean square, in mesh units, of what the waves of a third of an octave add to the surface", err=True
    )


_COLORS = {"before": "tab:gray", "after": "tab:blue"}


def draw_spectra(spectra: Mapping[str, Mapping[str, Any]], response: Response | None, extension: str) -> bytes:
    """The bytes of a picture, png, svg or pdf, of what ``get_surface_spectrum`` returns by name, with the response over it.

    Bands are steps and single modes dots, on logarithmic axes; the upper one tells wavelengths.
    """
    import numpy as np
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    def inverted(value: Any) -> Any:
        """A frequency of a wavelength, and the other way round."""
        with np.errstate(divide="ignore"):
            return 2.0 * np.pi / np.asarray(value, dtype=np.float64)

    figure = Figure(figsize=(7.5, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    lowest, highest, least, most = math.inf, 0.0, math.inf, 0.0
    for name, spectrum in spectra.items():
        edges, energies = np.asarray(spectrum["band_edges"]), np.asarray(spectrum["band_energies"])
        if len(energies) == 0:
            continue
        label = f"bands of 1/3 octave, {name}" if len(spectra) > 1 else "bands of 1/3 octave"
        axes.stairs(energies, edges, color=_COLORS.get(name), label=label)
        energy = np.asarray(spectrum["energies"])
        seen, frequencies = energy > 0.0, np.asarray(spectrum["frequencies"])
        axes.plot(frequencies[seen], energy[seen], ".", color=_COLORS.get(name), markersize=3, alpha=0.5)
        lowest, highest = min(lowest, float(edges[0])), max(highest, float(edges[-1]))
        most = max(most, float(energies.max()))
        least = least if name == "after" and math.isfinite(least) else float(energies[energies > 0.0].min())
    axes.set(xscale="log", yscale="log", xlabel="frequency (radians per mesh unit)", ylabel="energy (squared mesh units)")
    if lowest < highest:
        axes.set_xlim(lowest, highest)
        # A response takes all that there is, and the last bands of a mesh may hold next to nothing.
        axes.set_ylim(bottom=max(0.1 * least, 1e-11 * most))
        axes.secondary_xaxis("top", functions=(inverted, inverted)).set_xlabel("wavelength (mesh units)")
        if response is not None:
            omega = np.geomspace(lowest, highest, 400)
            factor = axes.twinx()
            factor.plot(omega, response.profile(omega), color="tab:orange", label=response.name)
            factor.set(ylabel=f"response of {response.name}", ylim=(0.0, None))
        axes.legend(loc="lower left", fontsize="small")
    drawn = io.BytesIO()
    # Without a date in it, a picture of the same spectra is the same file.
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    figure.savefig(drawn, format=extension, dpi=120, metadata=dates.get(extension))
    return drawn.getvalue()
