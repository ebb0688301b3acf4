"""Fairing: of a whole mesh, tangential, of a selected region, between two rims."""

import math
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from pymeshfair.declaration import Bool, Edit, Enum, FilterClass, Float, Int, Layer, MeshElement, Percentage, mesh_filter
from pymeshfair.errors import MeshError
from pymeshfair.filters import fairing
from pymeshfair.filters.checks import FilterInputError
from pymeshfair.filters.execution import Progress, ignore_progress, part_of
from pymeshfair.filters.holes import remesh_region
from pymeshfair.filters.inspection import surface_measures
from pymeshfair.filters.mesh import Bools, Floats, Ints

from . import moving_vertices as moving
from .moving_vertices import ADDS_ELEMENTS, MOVES_VERTICES, Border, Selected, additions, displacement, vertex_smoother

Features: TypeAlias = Literal["none", "curvature", "scalar"]


@vertex_smoother(name="Bi-Laplacian Smoothing", references=("nealen2006", "zheng2011"))
def apply_coord_bilaplacian_smoothing(
    layer: Layer,
    *,
    detail_size: Annotated[float, moving.DETAIL_SIZE],
    weight: Annotated[float, Float(minimum=0, advanced=True)] = 0.0,
    features: Annotated[Features, Enum()] = "none",
    feature_angle: Annotated[float, Float(minimum=1, maximum=179)] = 30.0,
    feature_scalar: Annotated[float, Float(minimum=1e-30, maximum=1e30)] = 1.0,
    border: Border = "along",
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Smooths by trading the bending of the surface for the distance that its vertices move: (C M^-1 W C + w M) p' = w M p.

    W is 1, or nearly 0 at features, where the surface may bend. Against implicit fairing at the same detail size, shorter waves
    are damped more and longer ones kept better, so that shapes shrink far less. Returns w in one over the fourth power of mesh
    units (0 or infinite where no number is so small or large), how many vertices moved and how far the furthest went.

    Args:
        detail_size: Waves of this length come out with half their amplitude: smaller details vanish, larger ones stay. Larger is
            smoother. 'auto' takes the size whose slopes are expected to be nearest to the true ones. Not used when a weight is
            given.
        weight: How strongly vertices are held to their places, w, in one over the fourth power of mean edges. Larger stays closer
            to the input: 0.02 smooths strongly, 0.2 mildly. 0: not used, the detail size decides.
        features: What is spared. 'none': every place is smoothed alike; 'curvature': ridges, found where the surface bends by
            more than an angle, may stay sharp; 'scalar': places of a high vertex scalar are spared.
        feature_angle: For 'curvature', the angle between neighbouring triangles, in degrees, at which a ridge counts half; noise
            is filtered out before. Larger spares sharper ridges alone.
        feature_scalar: For 'scalar', the size of the vertex scalar at which smoothing counts half, as 1 / (1 + (q / this)^2).
            Larger spares higher values alone.
    """
    if weight == 0.0 and detail_size == 0.0:
        raise moving.no_amount("weight")
    before = 0.3 if features == "curvature" else 0.0
    weights = _feature_weights(layer, features, feature_angle, feature_scalar, lambda done: progress(before * done))
    if weight:  # as a length, whose fourth power may leave the range of numbers
        detail_size = 2.0 * math.pi * layer.mean_edge / weight**0.25
    if detail_size == 0.0:
        raise FilterInputError("the mean edge has no length, so that a weight in mean edges has no meaning; give a detail size")
    if detail_size < 0.0 and weights is not None:
        raise FilterInputError("detail_size 'auto' knows no features: give a size such as '6edge', or features='none'")
    notes: set[str] = set()

    def smooth(points: Floats, faces: Ints, size: float, **how: Any) -> Floats:
        notes.clear()
        how |= {
            "feature_weights": weights,
            "border": border,
            "on_irregular": lambda count: notes.add(moving.irregular_note(count)),
        }
        return fairing.bilaplacian_smoothing(points, faces, detail_size=size, **how)

    done = moving.smoothed_by_size(layer, detail_size, smooth, selected=selected, progress=part_of(progress, before, 1.0))
    if done.amount:
        done = done._replace(notes=(*notes, *done.notes))
    held = fairing.weight_of_detail_size(done.amount) if done.amount else math.inf
    return done.edit(weight=held, **displacement(layer.vertices, done.vertices))


def _feature_weights(layer: Layer, features: Features, angle: float, scalar: float, progress: Progress) -> Floats | None:
    if features == "none":
        return None
    if features == "curvature":
        return fairing.feature_weights(layer.vertices, layer.faces, feature_angle=angle, progress=progress)
    if not (layer.has_vertex_scalars and layer.vertex_scalars.any()):
        raise FilterInputError(
            "features='scalar' needs a vertex scalar, and that of the mesh is 0 everywhere: first compute one, such as a "
            "curvature"
        )
    return fairing.scalar_feature_weights(layer.vertex_scalars, half=scalar)


@mesh_filter(
    name="Tangential Smoothing",
    classes=FilterClass.SMOOTHING | FilterClass.REMESHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES | MeshElement.FACENUMBER,
    references=("nealen2006", "lawson1977", "botsch2004remeshing"),
)
def apply_coord_tangential_smoothing(
    layer: Layer,
    *,
    weight: Annotated[float, Float(minimum=1e-9, maximum=1e9)] = 0.1,
    iterations: Annotated[int, Int(minimum=0, maximum=1000)] = 5,
    max_deviation: Annotated[float, Percentage(label="Largest deviation", default="0.05edge")],
    flip_edges: Annotated[bool, Bool()] = False,
    selected: Selected = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Makes triangles better shaped on the same surface: vertices move along it towards the middle of their neighbours.

    Open borders stay. No triangle folds over. Colours and texture coordinates move along with their vertices. Triangles whose
    edges are flipped come last; they take colour and scalar from the old ones near them, and their custom attributes are 0.
    Returns the mean quality of the triangles before and after, as Surface Measures has it (1 for equilateral ones, 0 for those
    without area), how many triangles flips have changed, how many vertices moved and how far the furthest went.

    Args:
        weight: How strongly vertices are held to their places. Larger moves them less in each iteration.
        iterations: How many steps are taken. More give better triangles, up to a point, and take longer.
        max_deviation: How far the middles of triangles and edges may get from the surface as it was, at sharp edges a fifth of
            it; vertices stay on it. Larger allows better triangles where the surface is curved or has edges.
        flip_edges: Before each step, take the other diagonal of two neighbouring triangles where that makes them better: for
            range maps and other grids, where moving vertices alone does next to nothing. Not on textured meshes.
    """
    textured = flip_edges and layer.has_wedge_tex_coords
    how: dict[str, Any] = {"weight": weight, "iterations": iterations, "max_deviation": max_deviation}
    how["flip_edges"] = flip_edges and not textured
    movable = moving.movable_vertices(layer, selected)
    vertices, faces = fairing.tangential_smoothing(layer.vertices, layer.faces, **how, movable=movable, progress=progress)
    replaced = (np.sort(faces, axis=1) != np.sort(layer.faces, axis=1)).any(axis=1)
    exchange: dict[str, Any] = {}
    if new := int(replaced.sum()):  # new triangles are selected if those in their rows were
        exchange["added_faces"] = faces[replaced]
        exchange["delete_faces"] = np.append(replaced, np.zeros(new, dtype=np.bool_))
        exchange["face_selection"] = np.append(layer.face_selection, layer.face_selection[replaced])
    values = {
        "triangle_quality_before": surface_measures(layer.vertices, layer.faces).triangle_quality,
        "triangle_quality_after": surface_measures(vertices, faces).triangle_quality,
        "changed_triangles": new,
        **displacement(layer.vertices, vertices),
    }
    note = "No edge was flipped: the triangles are textured, and flipped ones would lose their texture."
    return Edit(vertices=vertices, **exchange, values=values, notes=(note,) if textured else ())


FairingEnergy: TypeAlias = Annotated[
    fairing.Energy,
    Enum(
        help="'membrane' spans it like a soap film, and meets its surroundings with a crease; 'thin_plate' bends least and "
        "continues their tangent planes; 'minimum_variation' continues their curvatures too, so that what is round stays round."
    ),
]


@mesh_filter(
    name="Region Fairing",
    classes=FilterClass.SMOOTHING,
    requires=MeshElement.FACENUMBER,
    changes=MOVES_VERTICES | ADDS_ELEMENTS,
    references=("botsch2004",),
)
def apply_coord_region_fairing(
    layer: Layer,
    *,
    energy: FairingEnergy = "thin_plate",
    iterations: Annotated[int, Int(minimum=1, maximum=100, advanced=True)] = 1,
    remesh: Annotated[bool, Bool()] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Replaces the selected part of a surface by the smoothest one that continues its surroundings.

    What the part looked like is forgotten: for dents, scars, bad fillings and seams. The selected vertices move, or, when no
    vertex is selected, those all of whose triangles are; the others, and open borders, stay. One, two or three rings of vertices
    around the region decide, so select until the damage ends, and a ring more. Returns how many vertices moved. With `remesh`
    the selected vertices and their triangles go, new ones come last and are selected, and their numbers are returned.

    Args:
        iterations: How often, each time with the areas and angles that the one before has left. More forget the shape that was
            there more fully, and come nearer to the surface of least area or bending; one is mostly enough. With remeshing it is
            done three times at least.
        remesh: Replace the triangles of the part, too, by regular ones as dense as those around: for rough damage, whose needles
            and folds would remain. Colours go on from around; what the texture showed there is lost, and each new triangle shows
            one place of it. Without, triangles, texture and all attributes stay.
    """
    try:
        chosen = layer.selected_vertices()
    except MeshError:
        raise FilterInputError(
            f"nothing is selected in {layer.label!r}: select the vertices of the part that is to be faired, or triangles on all "
            "sides of them"
        ) from None
    if chosen.all():
        raise FilterInputError(
            "all vertices are selected, so that no surroundings are left to continue: select the part that is to be "
            "faired and leave its surroundings (to smooth a whole mesh take Bi-Laplacian Smoothing)"
        )
    if remesh:
        return _remade(layer, chosen, energy, max(3, iterations), progress)
    vertices = layer.vertices
    for i in range(iterations):
        partial = part_of(progress, i / iterations, (i + 1) / iterations)
        faired = fairing.fair_region(vertices, layer.faces, chosen, energy=energy, progress=partial)
        vertices = faired.vertices
    moved = int(faired.free.sum())
    notes = []
    if moved < chosen.sum():
        notes.append(_staying(chosen, moved))
    if faired.irregular:
        notes.append(moving.irregular_note(faired.irregular))
    return Edit(vertices=faired.vertices, values={"moved": moved}, notes=tuple(notes))


def _staying(chosen: Bools, moved: int) -> str:
    """The note on selected vertices that do not move."""
    count = int(chosen.sum())
    return f"{count - moved:,} of the {count:,} selected vertices lie on an open border or have no triangle, and stay."


def _remade(layer: Layer, chosen: Bools, energy: fairing.Energy, rounds: int, progress: Progress) -> Edit:
    """The selected vertices and their triangles replaced by a filling."""
    region, filling = remesh_region(layer.vertices, layer.faces, chosen, energy=energy, rounds=rounds, progress=progress)
    new_vertices, new_faces = len(filling.new_vertices), len(filling.new_faces)
    lower = sum(used != energy for used in filling.energies)
    notes = []
    if (chosen & ~region).any():
        notes.append(_staying(chosen, int((chosen & region).sum())))
    if lower:
        notes.append(f"{lower} of {len(filling.closed)} parts were placed with a lower energy than {energy!r}.")
    return Edit(
        **additions(layer, filling.new_vertices, filling.new_faces),
        delete_vertices=np.concatenate([region, np.zeros(new_vertices, dtype=np.bool_)]),
        values={
            "deleted_vertices": int(region.sum()),
            "deleted_faces": int(region[layer.faces].any(axis=1).sum()),
            "new_vertices": new_vertices,
            "new_faces": new_faces,
            "parts": len(filling.closed),
        },
        notes=tuple(notes),
    )


@mesh_filter(
    name="Bridge Rims by Fairing",
    classes=FilterClass.REMESHING,
    requires=MeshElement.FACENUMBER,
    changes=ADDS_ELEMENTS,
    references=("fuchs1977", "botsch2004"),
)
def meshing_bridge_rims_by_fairing(
    layer: Layer,
    *,
    energy: FairingEnergy = "thin_plate",
    selected: Annotated[bool, Bool(label="Selected rims only")] = False,
    progress: Progress = ignore_progress,
) -> Edit:
    """Joins two parts of a mesh by a smooth neck between the two rims that face each other.

    A rim is a loop of border edges. The two rims nearest each other get a band of triangles between them, as dense as they are,
    whose inside is then faired; the parts themselves stay as they are. The new vertices and triangles are selected. Parts in
    several layers are merged into one first (Flatten Visible Layers). Returns how many vertices and triangles are new, and how
    many edges each rim has.

    Args:
        selected: Join the two selected rims that lie nearest each other, which may belong to one part; a rim is selected when all
            of its vertices are. Otherwise the two nearest rims of different parts are joined.
    """
    among = layer.selected_vertices() if selected else None
    blend = fairing.blend_parts(layer.vertices, layer.faces, energy=energy, among=among, progress=progress)
    return Edit(
        **additions(layer, blend.vertices, blend.faces),
        values={
            "new_vertices": len(blend.vertices),
            "new_faces": len(blend.faces),
            "first_rim_edges": len(blend.rims[0]),
            "second_rim_edges": len(blend.rims[1]),
        },
    )
