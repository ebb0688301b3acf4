"""Spectral filters: by the wavelengths of a surface, with its modes or without them."""

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
    help="'cotangent' is the Laplace-Beltrami operator of the mesh; 'robust' is the same for slivers and non-manifold meshes; "
    "'auto' takes the robust one where it is needed.",
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
    """Removes, keeps or exaggerates details by their size, as an equaliser does with sound.

    A surface is a sum of waves, the modes of its Laplace-Beltrami operator, from its largest parts to the finest noise. The
    filter multiplies each by a factor that depends on its wavelength alone, whatever the sampling. Components are filtered one by
    one, and their centroids stay. Open borders are natural: their vertices are free, and they get as smooth as the surface.
    Returns the route that was taken, the number of modes or the degree of the polynomial, the wavelength at the cutoff, and a
    bound of the error in mesh units.

    Args:
        response: 'low_pass' removes waves shorter than the detail size; 'enhance' multiplies those from the detail size to the
            largest size by the gain and keeps all others; 'band_pass' keeps that band alone, about the centroid of each
            component, to look at.
        detail_size: Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay. With
            'enhance' and 'band_pass' the shortest wave of the band: choose it above the size of the noise. Larger is smoother.
            'auto' takes the size whose slopes are expected to be nearest to the true ones. Not used when a number of modes is
            given.
        largest_size: The longest wave of the band of 'enhance' and 'band_pass'. Larger takes in larger parts. 'auto': four detail
            sizes.
        modes: In place of the detail size, for 'low_pass': how many modes (manifold harmonics) are kept, over all components;
            centroids stay and do not count. More keep finer features: 5 leave a blob, 500 most of them. 0: not used, the detail
            size decides.
        gain: By what 'enhance' multiplies the waves of the band. Larger makes these details stronger, below 1 weaker.
        order: How sharply the response falls at the detail size. 1 is diffusion; larger is sharper, slower, and leaves ripples
            beside edges. Not used with a number of modes, where eigenvectors cut off at once.
        method: 'eigenvectors' computes the modes; 'polynomial' filters without them, far faster on large meshes; 'auto' computes
            modes only where their number is given and memory allows. The result says which ran.
    """
    if modes == 0 and detail_size == 0.0:
        raise no_amount("modes")
    if detail_size < 0.0 and response != "low_pass" and not modes:
        raise FilterInputError(
            f"detail_size 'auto' is for the response 'low_pass', not {response!r}: give a size such as '6edge'"
        )
    filtered: spectral.SpectralResult | None = None
    same: dict[str, Any] = {"response": response, "order": order, "method": method, "operator": operator}
    same |= {"largest_size": largest_size or None, "modes": modes or None, "gain": gain if response == "enhance" else None}

    def smooth(points: Floats, faces: Ints, size: float, **how: Any) -> Floats:
        nonlocal filtered
        filtered = spectral.spectral_filter(points, faces, detail_size=None if modes else size, **same, **how)
        return filtered.vertices

    done = smoothed_by_size(layer, 0.0 if modes else detail_size, smooth, selected=selected, progress=progress)
    if filtered is None or not (modes or done.amount):
        return done.edit()
    report = {f.name: getattr(filtered, f.name) for f in fields(filtered) if f.name not in ("vertices", "explanation")}
    return Edit(vertices=filtered.vertices, values={**report, **done.values}, notes=(_in_words(response, filtered),))


def _in_words(response: spectral.ResponseName, filtered: spectral.SpectralResult) -> str:
    """The change of the shape in words; the computation is reported in numbers."""
    if filtered.route == "none":
        return filtered.explanation
    did = {"low_pass": "waves shorter than {} were removed", "band_pass": "waves from {} on were kept"}
    return did.get(response, "waves from {} on were made stronger or weaker").format(f"{filtered.detail_size:.4g}")


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
    """Makes the relief of a surface higher, such as worn letters, and leaves its shape, its size and its borders.

    Vertices move along the normals of the shape, by the waves of the relief: shorter ones, noise among them, and longer ones stay
    as they are. Open borders stay, and what is near them changes less. Thin parts change less, too. Returns the two wavelengths,
    the height of the relief as it was (root mean square), the largest displacement, and the share of the vertices that the
    thickness has held back by half or more.

    Args:
        gain: How many times as high the relief becomes. Larger makes it stronger, below 1 flatter; 1 changes nothing.
        detail_size: The shortest wave of the relief: choose it above the size of the noise. Larger takes in larger details alone.
            'auto': where the spectrum of the surface rises above its noise, at least five mean edges.
        largest_size: The longest wave of the relief; what is larger is shape and stays. Larger takes in larger parts. 'auto':
            four detail sizes.
        most: How far a vertex may move, as a share of the thickness of the body there, or of the gap in front of it if that is
            less. Larger lets thin parts change more.
    """
    how: dict[str, Any] = {"gain": gain, "most": most, "operator": operator, "progress": progress}
    how |= {"detail_size": detail_size or None, "largest_size": largest_size or None}
    enhanced = spectral.enhance_details(layer.vertices, layer.faces, **how, movable=movable_vertices(layer, selected))
    notes: tuple[str, ...] = ("nothing was enhanced: no triangle has an area",)
    if enhanced.detail_size > 0.0:
        edge = layer.mean_edge
        notes = (
            f"the relief is taken to be waves of {enhanced.detail_size / edge:.3g} to {enhanced.largest_size / edge:.3g} mean "
            f"edges, {enhanced.height / edge:.2g} mean edges high; no vertex moved by more than "
            f"{enhanced.largest_displacement / edge:.2g}",
        )
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
    """Makes a mode of the surface, one of the waves that spectral filters keep or remove, the vertex scalar to look at.

    Modes are for a surface what sines are for sound: eigenfunctions of the Laplace-Beltrami operator. Its mean square over the
    surface is 1, its sign is arbitrary but always the same; it is 0 at vertices without a triangle and on other components.
    Returns its frequency (radians per mesh unit), its wavelength (2 pi / frequency) and its eigenvalue (the frequency squared).

    Args:
        mode: Which one, by rising frequency over all components. 0 is constant, 1 the longest wave, whatever the number of
            components; larger has shorter waves and takes longer.
    """
    harmonic = spectral.one_harmonic(layer.vertices, layer.faces, mode, operator=operator, progress=progress)
    frequency = math.sqrt(max(harmonic.eigenvalue, 0.0))
    notes: tuple[str, ...] = ()
    if harmonic.share_of_area < 0.5:
        notes = (
            f"this mode lives on one of {harmonic.n_components} components, with {100.0 * harmonic.share_of_area:.2g} % of the "
            "area: take another mode, or remove small components first",
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
    """How much of the shape lies at which frequency: where it ends and where noise begins.

    The energy of a frequency is what its waves add to the mean squared distance of the surface from the centroids of its
    components, in squared mesh units; a frequency is 2 pi over a wavelength, in radians per mesh unit. Returns the frequencies
    and energies of the lowest modes, and the energies of bands of a third of an octave up to the finest waves of the mesh.

    Args:
        modes: How many modes are listed, from the lowest. More reach higher frequencies and take longer; the energies of bands do
            not need them.
    """
    energies = spectral.spectrum(layer.vertices, layer.faces, modes=modes, operator=operator, progress=progress)
    # Lists, not arrays: a run hands them over whole.
    report = {f.name: getattr(energies, f.name) for f in fields(energies)}
    values = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in report.items()}
    return Edit(values={**values, "diagonal": layer.diagonal, "mean_edge": layer.mean_edge})
