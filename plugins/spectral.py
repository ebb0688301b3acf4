"""Spectral filters, which change each wave of a surface according to its wavelength, with or without computing its modes."""

import math
from dataclasses import fields
from typing import Annotated, Any

import numpy as np

from pymeshfair.declaration import Edit, Enum, FilterClass, Float, Int, Layer, MeshElement, Percentage, mesh_filter
from pymeshfair.filters import spectral
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.execution import Progress, ignore_progress
from pymeshfair.filters.mesh import Floats, Ints
from pymeshfair.filters.operators import SurfaceOperatorName

from .moving_vertices import DETAIL_SIZE, Selected, movable_vertices, no_amount, smoothed_by_size, vertex_smoother

ORDER = Int(minimum=min(spectral.ORDERS), maximum=max(spectral.ORDERS), advanced=True)
OPERATOR = Enum(
    label="Operator",
    advanced=True,
    help="'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same operator for slivers and non-manifold "
    "meshes; 'auto' takes 'robust' if it is needed.",
)


@vertex_smoother(name="Spectral Filter", references=("taubin1995", "vallet2008"))
def apply_coord_spectral_filter(
    layer: Layer,
    *,
    response: Annotated[spectral.ResponseName, Enum()] = "low_pass",
    detail_size: Annotated[float, DETAIL_SIZE],
    largest_size: Annotated[float, Percentage(automatic=0, default="auto")],
    modes: Annotated[int, Int(minimum=0, maximum=1_000_000)] = 0,
    gain: Annotated[float, Float(minimum=0, maximum=10)] = 2.0,
    order: Annotated[int, ORDER] = spectral.DEFAULT_ORDER,
    method: Annotated[spectral.SpectralMethod, Enum()] = "auto",
    operator: Annotated[SurfaceOperatorName, OPERATOR] = "auto",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Removes, keeps or exaggerates details by their size, like an equaliser for sound.

    A surface is a sum of waves, the modes of its Laplace-Beltrami operator. The filter multiplies each mode by a factor that
    depends only on its wavelength. The centroids of components stay, and open borders become as smooth as the surface. Returns
    the method that ran (route), the number of modes or the degree of the polynomial or rational function, the wavelength at the
    cutoff, and an error estimate in mesh units.

    Args:
        response: 'low_pass' removes waves shorter than the detail size. 'enhance' multiplies the waves from the detail size to
            the largest size by the gain, and keeps all others; the detail size should exceed the size of the noise. 'band_pass'
            keeps only this band, for inspection.
        largest_size: The longest wave of the band of 'enhance' and 'band_pass'. Larger includes larger parts. 'auto': four detail
            sizes.
        modes: The number of modes (manifold harmonics), over all components; the last one's wavelength replaces the detail size.
            More keep finer features: 5 leave a blob, 500 most features. 0: not used, the detail size decides.
        gain: The factor of 'enhance' for the waves of the band. Larger makes these details stronger; a gain below 1 weakens them.
        order: How sharply the response falls at the detail size. 1 is diffusion; larger is sharper, slower, and leaves ripples
            beside edges. Not used with modes and the route 'eigenvectors'.
        method: 'eigenvectors' computes the modes; 'polynomial' filters without them, far faster on large meshes; 'auto' computes
            modes only if their number is given and memory allows. The result names the method.
    """
    if modes == 0 and detail_size == 0.0:
        raise no_amount(layer, "modes")
    if detail_size < 0.0 and response != "low_pass" and not modes:
        raise FilterInputError(
            f"detail_size 'auto' is for the response 'low_pass', not {response!r}: give a size such as '6edge'"
        )
    filtered: spectral.SpectralResult | None = None
    options: dict[str, Any] = {"response": response, "order": order, "method": method, "operator": operator}
    options |= {"largest_size": largest_size or None, "modes": modes or None, "gain": gain if response == "enhance" else None}

    def smooth(points: Floats, faces: Ints, size: float, **keywords: Any) -> Floats:
        nonlocal filtered
        filtered = spectral.spectral_filter(points, faces, detail_size=None if modes else size, **options, **keywords)
        return filtered.vertices

    smoothed = smoothed_by_size(layer, 0.0 if modes else detail_size, smooth, selected=selected, progress=progress)
    if filtered is None or not (modes or smoothed.amount):
        return smoothed.edit()
    report = {f.name: getattr(filtered, f.name) for f in fields(filtered) if f.name not in ("vertices", "explanation")}
    return Edit(vertices=smoothed.vertices, values={**report, **smoothed.values}, notes=(_in_words(response, filtered),))


def _in_words(response: spectral.ResponseName, filtered: spectral.SpectralResult) -> str:
    if filtered.route == "none":
        return filtered.explanation
    did = {"low_pass": "waves shorter than {} were removed", "band_pass": "waves from {} to the largest size were kept"}
    return did.get(response, "waves from {} to the largest size became stronger or weaker").format(f"{filtered.detail_size:.4g}")


@vertex_smoother(name="Detail Enhancement", references=("vallet2008", "ma2012"))
def apply_coord_detail_enhancement(
    layer: Layer,
    *,
    gain: Annotated[float, Float(minimum=0, maximum=10)] = 2.0,
    detail_size: Annotated[float, Percentage(automatic=0, default="auto")],
    largest_size: Annotated[float, Percentage(automatic=0, default="auto")],
    most: Annotated[float, Float(minimum=0.001, maximum=0.5)] = 0.05,
    operator: Annotated[SurfaceOperatorName, OPERATOR] = "auto",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Makes the relief of a surface, such as worn letters, higher, and keeps the shape, the size and the borders.

    Vertices move along the normals that the surface would have without relief; waves shorter or longer than those of the relief
    stay. Near open borders and in thin parts vertices move less; parts far thinner than the longest wave stay. Returns the
    shortest and the longest wavelength of the relief, its height in the input (root mean square), and the largest
    displacement.

    Args:
        gain: The factor for the height of the relief. Larger makes the relief higher, a gain below 1 flatter; 1 changes nothing.
        detail_size: The shortest wave of the relief: choose it above the size of the noise. Larger includes only larger details.
            'auto': about the shortest wavelength at which the spectrum clearly exceeds the noise, at least five mean edges.
        largest_size: The longest wave of the relief. Larger includes larger parts. 'auto': four detail sizes.
        most: The largest displacement of a vertex, as a share of the thickness of the body there, or of the gap in front of the
            vertex if the gap is smaller. Larger lets thin parts change more.
    """
    options: dict[str, Any] = {"gain": gain, "most": most, "operator": operator, "progress": progress}
    options |= {"detail_size": detail_size or None, "largest_size": largest_size or None}
    enhanced = spectral.enhance_details(layer.vertices, layer.faces, **options, movable=movable_vertices(layer, selected))
    notes: tuple[str, ...] = ("nothing was enhanced: no triangle has an area",)
    if enhanced.detail_size > 0.0:
        edge = layer.mean_edge
        notes = (
            f"the relief is taken to be waves of {enhanced.detail_size / edge:.3g} to {enhanced.largest_size / edge:.3g} mean "
            f"edges, {enhanced.height / edge:.2g} mean edges high; no vertex moved by more than "
            f"{enhanced.largest_displacement / edge:.2g} mean edges",
        )
        if not selected and enhanced.largest_displacement < 0.01 * abs(gain - 1.0) * enhanced.height:
            staying = "vertices near a border and parts far thinner than the longest wave stay"
            notes += (f"hardly anything moved: {staying}; a smaller largest_size moves them",)
    report = {f.name: getattr(enhanced, f.name) for f in fields(enhanced) if f.name != "vertices"}
    return Edit(vertices=enhanced.vertices, values=report, notes=notes)


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
    mode: Annotated[int, Int(minimum=0, maximum=1_000_000)] = 10,
    operator: Annotated[SurfaceOperatorName, OPERATOR] = "auto",
    progress: Progress = ignore_progress,
) -> Edit:
    """Writes a mode of the surface, one of the waves that spectral filters keep or remove, to the vertex scalar for inspection.

    Modes are eigenfunctions of the Laplace-Beltrami operator. Mode 0 is constant; other modes are 0 outside one component.
    Modes are 0 at vertices without a triangle; the mean square of a mode over the surface is 1, its sign is reproducible.
    Returns the frequency f (radians per mesh unit), the wavelength (2 pi / f) and the eigenvalue (f squared).

    Args:
        mode: The number of the mode, by rising frequency over all components. 0 is constant, 1 is the longest wave; a
            larger number has shorter waves and takes longer.
    """
    harmonic = spectral.one_harmonic(layer.vertices, layer.faces, mode, operator=operator, progress=progress)
    frequency = math.sqrt(max(harmonic.eigenvalue, 0.0))
    notes: tuple[str, ...] = ()
    if harmonic.share_of_area < 0.5:
        notes = (
            f"this mode is 0 outside one of {harmonic.n_components} components, which has {100.0 * harmonic.share_of_area:.2g} % "
            "of the area: take another mode, or remove small components first",
        )
    wavelength = 2.0 * math.pi / frequency if frequency > 0.0 else math.inf
    values = {"frequency": frequency, "wavelength": wavelength, "eigenvalue": harmonic.eigenvalue}
    return Edit(vertex_scalars=harmonic.values, values=values, notes=notes)


@mesh_filter(
    name="Surface Spectrum", classes=FilterClass.MEASURE, requires=MeshElement.FACENUMBER, references=("vallet2008", "golub1969")
)
def get_surface_spectrum(
    layer: Layer,
    *,
    modes: Annotated[int, Int(minimum=0, maximum=100_000)] = 50,
    operator: Annotated[SurfaceOperatorName, OPERATOR] = "auto",
    progress: Progress = ignore_progress,
) -> Edit:
    """Measures the energy of the shape by frequency, which shows where the shape ends and the noise begins.

    The energy of a frequency is the contribution of its waves to the mean squared distance of the surface from the centroids of
    its components, in squared mesh units; a frequency is 2 pi over a wavelength, in radians per mesh unit. Returns frequencies
    and energies of the lowest modes; bounds and energies of bands of a third of an octave, up to the finest waves of the mesh;
    and the total energy, the area, the diagonal and the mean edge.

    Args:
        modes: The number of modes to list, from the lowest. More reach higher frequencies and take longer; bands need no modes.
    """
    energies = spectral.spectrum(layer.vertices, layer.faces, modes=modes, operator=operator, progress=progress)
    # Lists, not arrays: a run reports lists in full.
    values = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in vars(energies).items()}
    return Edit(values={**values, "diagonal": layer.diagonal, "mean_edge": layer.mean_edge})
