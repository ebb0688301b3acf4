"""The modes of a surface: one of them as a scalar, and the spectrum of the shape."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Annotated

import numpy as np

from pymeshfair.declaration import (
    Edit,
    FilterClass,
    Int,
    Layer,
    MeshElement,
    mesh_filter,
)
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.spectral import (
    SpectralOperator,
    one_harmonic,
    spectrum,
)

from .filtering import OPERATOR


@mesh_filter(
    name="Manifold Harmonic",
    classes=FilterClass.QUALITY,
    requires=MeshElement.FACENUMBER,
    changes=MeshElement.VERTQUALITY,
    references=("vallet2008",),
)
def compute_scalar_by_manifold_harmonic_per_vertex(
    layer: Layer,
    *,
    mode: Annotated[
        int,
        Int(
            label="Mode",
            minimum=0,
            maximum=1_000_000,
            help="Which one, by rising frequency over all components. 0 is constant, 1 the longest wave, whatever the number of "
            "components; larger has shorter waves and takes longer.",
        ),
    ] = 10,
    operator: Annotated[SpectralOperator, OPERATOR] = "auto",
    progress: Progress = ignore_progress,
) -> Edit:
    """Makes a mode of the surface, one of the waves that spectral filters keep or remove, the vertex scalar to look at.

    Modes are for a surface what sines are for sound: eigenfunctions of the Laplace-Beltrami operator. Its mean square over the
    surface is 1, its sign is arbitrary but always the same; it is 0 at vertices without a triangle and on other components.
    Returns its frequency (radians per mesh unit), its wavelength (2 pi / frequency) and its eigenvalue (the frequency squared).
    """
    harmonic = one_harmonic(layer.vertices, layer.faces, mode, operator=operator, progress=progress)
    frequency = math.sqrt(max(harmonic.eigenvalue, 0.0))
    notes: tuple[str, ...] = ()
    if harmonic.share_of_area < 0.5:
        notes = (
            f"this mode lives on one of {harmonic.n_components} components, with {100.0 * harmonic.share_of_area:.2g} % of the "
            "area: take another mode, or remove small components first",
        )
    return Edit(
        vertex_scalars=harmonic.values,
        values={
            "frequency": frequency,
            "wavelength": 2.0 * math.pi / frequency if frequency > 0.0 else math.inf,
            "eigenvalue": harmonic.eigenvalue,
        },
        notes=notes,
    )


@mesh_filter(
    name="Surface Spectrum",
    classes=FilterClass.MEASURE,
    requires=MeshElement.FACENUMBER,
    references=("vallet2008", "golub1969"),
)
def get_surface_spectrum(
    layer: Layer,
    *,
    modes: Annotated[
        int,
        Int(
            label="Modes",
            minimum=0,
            maximum=100_000,
            help="How many modes are listed, from the lowest. More reach higher frequencies and take longer; "
            "the energies of bands do not need them.",
        ),
    ] = 50,
    operator: Annotated[SpectralOperator, OPERATOR] = "auto",
    progress: Progress = ignore_progress,
) -> Edit:
    """How much of the shape lies at which frequency: where it ends and where noise begins.

    The energy of a frequency is what its waves add to the mean squared distance of the surface from the centroids of its
    components, in squared mesh units; a frequency is 2 pi over a wavelength, in radians per mesh unit. Returns the frequencies
    and energies of the lowest modes, and the energies of bands of a third of an octave up to the finest waves of the mesh.
    """
    energies = spectrum(layer.vertices, layer.faces, modes=modes, operator=operator, progress=progress)
    # Lists, not arrays: a run hands them over whole.
    report = {f.name: getattr(energies, f.name) for f in fields(energies)}
    values = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in report.items()}
    return Edit(values={**values, "diagonal": layer.diagonal, "mean_edge": layer.mean_edge})
