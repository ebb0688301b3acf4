"""Draws spectra: energy against frequency, before and after, with the response of a filter over them. Needs matplotlib."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from ..filters.spectral.problem import Response

_COLORS = {"before": "tab:gray", "after": "tab:blue"}


def draw_spectra(spectra: Mapping[str, Mapping[str, Any]], response: Response | None, extension: str) -> bytes:
    """The bytes of a picture, png, svg or pdf, of what ``get_surface_spectrum`` returns by name, with the response over it."""
    figure = Figure(figsize=(7.5, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    draw_on(axes, spectra, response)
    drawn = io.BytesIO()
    # Without a date in it, a picture of the same spectra is the same file.
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    figure.savefig(drawn, format=extension, dpi=120, metadata=dates.get(extension))
    return drawn.getvalue()


def draw_on(axes: Any, spectra: Mapping[str, Mapping[str, Any]], response: Response | None = None) -> None:
    """Draw bands as steps and single modes as dots, on logarithmic axes of matplotlib's; the upper one tells wavelengths."""
    lowest, highest, least, most = math.inf, 0.0, math.inf, 0.0
    for name, spectrum in spectra.items():
        edges, energies = np.asarray(spectrum["band_edges"]), np.asarray(spectrum["band_energies"])
        if len(energies) == 0:
            continue
        color = _COLORS.get(name)
        axes.stairs(
            energies, edges, color=color, label=f"bands of 1/3 octave, {name}" if len(spectra) > 1 else "bands of 1/3 octave"
        )
        energy = np.asarray(spectrum["energies"])
        seen = energy > 0.0
        axes.plot(np.asarray(spectrum["frequencies"])[seen], energy[seen], ".", color=color, markersize=3, alpha=0.5)
        lowest, highest = min(lowest, float(edges[0])), max(highest, float(edges[-1]))
        most = max(most, float(energies.max()))
        least = least if name == "after" and math.isfinite(least) else float(energies[energies > 0.0].min())
    axes.set(xscale="log", yscale="log", xlabel="frequency (radians per mesh unit)", ylabel="energy (squared mesh units)")
    if not lowest < highest:
        return
    axes.set_xlim(lowest, highest)
    # A response takes all that there is, and the last bands of a mesh may hold next to nothing.
    axes.set_ylim(bottom=max(0.1 * least, 1e-11 * most))
    upper = axes.secondary_xaxis("top", functions=(_inverted, _inverted))
    upper.set_xlabel("wavelength (mesh units)")
    if response is not None:
        omega = np.geomspace(lowest, highest, 400)
        factor = axes.twinx()
        factor.plot(omega, response.profile(omega), color="tab:orange", label=response.name)
        factor.set(ylabel=f"response of {response.name}", ylim=(0.0, None))
    axes.legend(loc="lower left", fontsize="small")


def _inverted(value: Any) -> Any:
    """A frequency of a wavelength, and the other way round."""
    with np.errstate(divide="ignore"):
        return 2.0 * np.pi / np.asarray(value, dtype=np.float64)
