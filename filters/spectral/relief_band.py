"""The waves of a surface that are relief: longer than its noise, shorter than its shape."""

from typing import NamedTuple

import numpy as np

from ..mesh import Floats, Ints
from .spectrum import spectrum

#: The longest wave of the relief in shortest ones: two octaves.
OCTAVES = 4.0
#: Waves shorter than this many mean edges are never relief: triangles do not show them.
SHORTEST = 5.0
#: A band whose energy is this many times that of noise is signal: three parts of four of it.
SIGNAL = 4.0
# Noise shows where waves are this many mean edges long; shorter ones belong to no regular triangles.
_NOISE_FROM, _NOISE_TO = 2.5, 4.0
# Enough for bands down to ten edges; the long waves of the shape are not resolved, and not needed.
_STEPS = 300


class ReliefBand(NamedTuple):
    """Two wavelengths, in mesh units: those of the shortest and of the longest waves of the relief."""

    shortest: float
    longest: float


def relief_band(vertices: Floats, faces: Ints, mean_edge: float) -> ReliefBand:
    """Finds the band of the relief in the spectrum of a surface.

    Noise that is independent at each vertex has the same energy in every mode, so that its energy in a band of a third of an
    octave grows with the square of the frequency. Its level is taken from waves of 2.5 to 4 mean edges, which show little else.
    The relief begins a third of an octave above the shortest band that has `SIGNAL` times as much energy as such noise would, at
    `SHORTEST` edges at least, and ends two octaves above.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles, at least one with an area.
        mean_edge: of the mesh, above 0.
    """
    # In mean edges, since the edges of bands are the same numbers for all meshes.
    found = spectrum(vertices / mean_edge, faces, modes=0, steps=_STEPS)
    edges = found.band_edges
    wavelengths = 2.0 * np.pi / np.sqrt(edges[1:] * edges[:-1])
    energies, squares = found.band_energies, wavelengths**-2.0
    noisy = (wavelengths > _NOISE_FROM) & (wavelengths < _NOISE_TO)
    level = energies[noisy].sum() / max(squares[noisy].sum(), 1e-300)
    signal = (wavelengths > _NOISE_FROM) & (energies > 0.0) & (energies >= SIGNAL * level * squares)
    shortest = SHORTEST
    if noisy.any() and signal.any():
        shortest = max(SHORTEST, 2.0 ** (1.0 / 3.0) * float(wavelengths[signal].min()))
    return ReliefBand(shortest * mean_edge, OCTAVES * shortest * mean_edge)
