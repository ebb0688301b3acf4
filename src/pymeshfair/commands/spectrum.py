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


PICTURES = ("png", "svg", "pdf")


def spectrum(
    mesh: Annotated[Path, Argument(metavar="MESH", help="The mesh file to look at; it is not changed.")],
    output: Annotated[Path | None, Option("--output", "-o", metavar="PICTURE", help="A .png, .svg or .pdf file to draw.")] = None,
    after: Annotated[Path | None, Option(metavar="MESH2", help="Compare with this mesh.")] = None,
    modes: Annotated[int, Option(help="How many modes are listed one by one, from the lowest.", min=0)] = 50,
    timeout: Timeout = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Tell how much of a shape lies at which wavelength, from its largest parts to its noise.

    Where the fall of the curve turns flat, noise begins: that wavelength is a detail size for smoothing.
    """
    from ..errors import require_extra
    from ..files.formats import extension
    from ..files.writing import check_target, write_file
    from ..running.read import reported_values
    from .display import progress

    if output is not None:
        require_extra("plot", "matplotlib")
        check_target(output, PICTURES, overwrite=overwrite)
    paths = {"before": mesh} | ({} if after is None else {"after": after})
    options: dict[str, Any] = {"values": {"modes": modes}, "timeout": timeout}
    with progress() as show:
        shown = {name: reported_values(path, "get_surface_spectrum", **options, on_event=show) for name, path in paths.items()}
    if output is not None:
        write_file(output, draw_spectra(shown, extension(output)), overwrite=overwrite)
    if json:
        print_document({"mesh": mesh, **shown, "picture": output})
        return
    _print(shown)
    if output is not None:
        say(f"{output}: written", err=True)


def _print(spectra: Mapping[str, Mapping[str, Any]]) -> None:
    """A row for each band, from the longest waves to the shortest, with the root mean square height of its waves."""
    from .display import show_table

    heights: dict[int, dict[str, float]] = {}
    for name, spectrum in spectra.items():
        for low, high, energy in zip(spectrum["band_edges"], spectrum["band_edges"][1:], spectrum["band_energies"], strict=False):
            band = round(1.5 * math.log2(low * high) - 0.5)
            heights.setdefault(band, {})[name] = math.sqrt(max(energy, 0.0))
    headers = ["wavelength", "in mean edges", *(f"height {name}" if len(spectra) > 1 else "height" for name in spectra)]
    rows = []
    for band, at_band in sorted(heights.items()):
        length = 2 * math.pi / 2.0 ** ((band + 0.5) / 3)
        row = [f"{length:.4g}", f"{length / spectra['before']['mean_edge']:.3g}"]
        rows.append(row + [f"{at_band[name]:.3g}" if name in at_band else "" for name in spectra])
    show_table(headers, *rows, numbers=range(len(headers)))
    typer.echo(
        "\nheight: the root mean square, in mesh units, of what the waves of a third of an octave add to the surface", err=True
    )


_COLORS = {"before": "tab:gray", "after": "tab:blue"}


def draw_spectra(spectra: Mapping[str, Mapping[str, Any]], extension: str) -> bytes:
    """The bytes of a picture, png, svg or pdf, of what ``get_surface_spectrum`` returns by name.

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
        # The last bands of a mesh may hold next to nothing.
        axes.set_ylim(bottom=max(0.1 * least, 1e-11 * most))
        axes.secondary_xaxis("top", functions=(inverted, inverted)).set_xlabel("wavelength (mesh units)")
        axes.legend(loc="lower left", fontsize="small")
    drawn = io.BytesIO()
    # Without a date in it, a picture of the same spectra is the same file.
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    figure.savefig(drawn, format=extension, dpi=120, metadata=dates.get(extension))
    return drawn.getvalue()
