"""``pymeshfair spectrum MESH``: the spectrum of a shape, as a table or a picture."""

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
    modes: Annotated[int, Option(help="The number of lowest modes that --json lists and PICTURE draws one by one.", min=0)] = 50,
    timeout: Timeout = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Show the spectrum of a shape: how high its waves of each length are, from its largest parts to its noise.

    Heights fall towards short waves, but are flat or rise where noise begins: take that wavelength as detail size of filters.
    PICTURE and --json show energies, the squares of heights.
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
        spectra = {name: reported_values(path, "get_surface_spectrum", **options, on_event=show) for name, path in paths.items()}
    if output is not None:
        write_file(output, draw_spectra(spectra, extension(output)), overwrite=overwrite)
    if json:
        print_document({"mesh": mesh, **spectra, "picture": output})
        return
    _print(spectra)
    if output is not None:
        say(f"{output}: written", err=True)


def _print(spectra: Mapping[str, Mapping[str, Any]]) -> None:
    from .display import show_table

    heights: dict[int, dict[str, float]] = {}  # root mean square heights by band b, from frequency 2^(b/3) to 2^((b+1)/3)
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
    typer.echo("\nheight: the root mean square height, in mesh units, of the waves in a third of an octave", err=True)


_COLORS = {"before": "tab:gray", "after": "tab:blue"}


def draw_spectra(spectra: Mapping[str, Mapping[str, Any]], extension: str) -> bytes:
    """Draws spectra, given by name as ``get_surface_spectrum`` returns them; returns the bytes of a png, svg or pdf file."""
    import numpy as np
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    def inverted(value: Any) -> Any:
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
        positive, frequencies = energy > 0.0, np.asarray(spectrum["frequencies"])
        axes.plot(frequencies[positive], energy[positive], ".", color=_COLORS.get(name), markersize=3, alpha=0.5)
        lowest, highest = min(lowest, float(edges[0])), max(highest, float(edges[-1]))
        most = max(most, float(energies.max()))
        least = least if name == "after" and math.isfinite(least) else float(energies[energies > 0.0].min())
    axes.set(xscale="log", yscale="log", xlabel="frequency (radians per mesh unit)", ylabel="energy (squared mesh units)")
    if lowest < highest:
        axes.set_xlim(lowest, highest)
        # The bands of the shortest waves may have hardly any energy, and would stretch the axis.
        axes.set_ylim(bottom=max(0.1 * least, 1e-11 * most))
        axes.secondary_xaxis("top", functions=(inverted, inverted)).set_xlabel("wavelength (mesh units)")
        axes.legend(loc="lower left", fontsize="small")
    drawn = io.BytesIO()
    # Without a date and random names the same spectra give the same file.
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with rc_context({"svg.hashsalt": "pymeshfair"}):
        figure.savefig(drawn, format=extension, dpi=120, metadata=dates.get(extension))
    return drawn.getvalue()
