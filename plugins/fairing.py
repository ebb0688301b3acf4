"""Fairing filters: bi-Laplacian smoothing of a mesh, tangential smoothing, region fairing, and bridges between two rims."""

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
    """Smooths by balancing the bending of the surface against the displacement of vertices: (C M^-1 W C + w M) p' = w M p.

    C is the stiffness and M the mass of the surface; W is 1, or nearly 0 at features, where the surface may bend. Shapes shrink
    far less than by implicit fairing at the same detail size. Returns w in 1 / (mesh unit)^4 (infinite without smoothing, 0
    or infinite if w under- or overflows), the number of moved vertices and the largest displacement.

    Args:
        weight: The weight w that holds vertices in place, in 1 / (mean edge)^4. Larger stays closer to the input: 0.02 smooths
            strongly, 0.2 mildly. 0: not used, the detail size decides.
        features: The features to keep. 'none'; 'curvature': ridges, where the surface bends by more than the feature angle, stay
            sharp; 'scalar': parts whose vertex scalar is far from 0.
        feature_angle: For 'curvature': the angle between adjacent triangles, in degrees, at which W is 1/2; noise is filtered out
            beforehand. Larger keeps only sharper ridges.
        feature_scalar: For 'scalar': q0 in W = 1 / (1 + (q / q0)^2) at a scalar q. Larger keeps only parts farther from 0.
    """
    if weight:  # converted to a length: the weight per mean edge^4 may overflow
        detail_size = 2.0 * math.pi * layer.mean_edge / weight**0.25
    if detail_size == 0.0:
        raise moving.no_amount(layer, "weight")
    if detail_size < 0.0 and features != "none":
        raise FilterInputError("detail_size 'auto' cannot keep features: give a size such as '6edge', or features='none'")
    before = 0.3 if features == "curvature" else 0.0
    weights = _feature_weights(layer, features, feature_angle, feature_scalar, lambda done: progress(before * done))
    notes: set[str] = set()

    def smooth(points: Floats, faces: Ints, size: float, **options: Any) -> Floats:
        notes.clear()
        options |= {"feature_weights": weights, "border": border}
        options["on_irregular"] = lambda count: notes.add(moving.irregular_note(count))
        return fairing.bilaplacian_smoothing(points, faces, detail_size=size, **options)

    smoothed = moving.smoothed_by_size(layer, detail_size, smooth, selected=selected, progress=part_of(progress, before, 1.0))
    if smoothed.amount:
        smoothed = smoothed._replace(notes=(*notes, *smoothed.notes))
    held = fairing.weight_of_detail_size(smoothed.amount) if smoothed.amount else math.inf
    return smoothed.edit(weight=held, **displacement(layer.vertices, smoothed.vertices))


def _feature_weights(layer: Layer, features: Features, angle: float, scalar: float, progress: Progress) -> Floats | None:
    """(n,) the weights W; None for 1 everywhere."""
    if features == "none":
        return None
    if features == "curvature":
        return fairing.feature_weights(layer.vertices, layer.faces, feature_angle=angle, progress=progress)
    if not (layer.has_vertex_scalars and layer.vertex_scalars.any()):
        raise FilterInputError("features='scalar' needs vertex scalars, but those of the mesh are 0: compute some first")
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
    """Improves the shape of triangles on the same surface: vertices move along it towards the mean of their neighbours.

    Open borders stay. No triangle folds over. Colours and texture coordinates move with their vertices. Triangles with flipped
    edges come last; they take colour and scalar from nearby old triangles, and their custom attributes are 0. Returns the mean
    triangle quality before and after (1 for equilateral triangles), the number of triangles changed by flips, the number of
    moved vertices and the largest displacement.

    Args:
        weight: How strongly vertices are held in place. Larger moves them less in each iteration.
        iterations: The number of steps. More give better triangles, up to a point, and take longer.
        max_deviation: The largest distance of the centres of triangles and edges from the input surface; at sharp edges a fifth
            of this value. Vertices stay on the surface. Larger allows better triangles where the surface is curved or has edges.
        flip_edges: Before each step, flip edges where this improves the two adjacent triangles: for range maps and other grids.
            Not on textured meshes.
    """
    textured = flip_edges and layer.has_wedge_tex_coords
    options: dict[str, Any] = {"weight": weight, "iterations": iterations, "max_deviation": max_deviation}
    options["flip_edges"] = flip_edges and not textured
    movable = moving.movable_vertices(layer, selected)
    vertices, faces = fairing.tangential_smoothing(layer.vertices, layer.faces, **options, movable=movable, progress=progress)
    replaced = (np.sort(faces, axis=1) != np.sort(layer.faces, axis=1)).any(axis=1)
    exchange: dict[str, Any] = {}
    if new := int(replaced.sum()):  # new triangles inherit the selection of the old triangles in the same rows
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
        help="'membrane' is like a soap film, with a crease at the boundary; 'thin_plate' bends least and continues the "
        "surrounding tangent planes; 'minimum_variation' continues the curvatures too, so that round shapes stay round."
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
    """Replaces the selected part of a surface by the smoothest part that continues the surface around it.

    For dents, scars, bad fillings and seams. The selected vertices move; if no vertex is selected, those whose triangles are all
    selected. Other vertices, and open borders, stay. The energies read one, two or three rings of vertices around the region, so
    select all of the damage and one ring more. Returns how many vertices moved, and the solution's backward error, number of
    corrections, and last correction as a share of the region's diagonal. With `remesh`: numbers of old and new elements instead.

    Args:
        iterations: How often to solve, each time with the areas and angles of the previous result. With more, the old shape
            matters less; once is usually enough. Remeshing takes at least three.
        remesh: Also replace the triangles of the part by regular triangles as dense as those around, for rough damage. They come
            last and are selected. Their colours continue those around; each shows a single point of the texture.
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
    vertices, area_share, irregular = layer.vertices, 1.0, 0
    for i in range(iterations):
        partial = part_of(progress, i / iterations, (i + 1) / iterations)
        faired = fairing.fair_region(vertices, layer.faces, chosen, energy=energy, progress=partial)
        vertices, area_share, irregular = faired.vertices, area_share * faired.area_share, max(irregular, faired.irregular)
    moved = int(faired.free.sum())
    notes = []
    if moved < chosen.sum():
        notes.append(_staying(chosen, moved, "lie on an open border or have no triangle"))
    if irregular:
        notes.append(moving.irregular_note(irregular))
    if area_share < 1 / 3:
        notes.append(
            f"The region's area shrank to {area_share:.2g} of what it was, because the vertices that stay around it span a "
            "smaller area. Select less if the region should keep its size."
        )
    report = {name: getattr(faired, name) for name in ("backward_error", "last_correction", "refinements")}
    return Edit(vertices=faired.vertices, values={"moved": moved, **report}, notes=tuple(notes))


def _staying(chosen: Bools, moved: int, reason: str) -> str:
    count = int(chosen.sum())
    return f"{count - moved:,} of the {count:,} selected vertices {reason}, and stay."


def _remade(layer: Layer, chosen: Bools, energy: fairing.Energy, rounds: int, progress: Progress) -> Edit:
    region, filling = remesh_region(layer.vertices, layer.faces, chosen, energy=energy, rounds=rounds, progress=progress)
    lower = sum(used != energy for used in filling.energies)
    notes = []
    if (chosen & ~region).any():
        notes.append(_staying(chosen, int((chosen & region).sum()), "have no triangle, or one that touches an open border"))
    if lower:
        notes.append(f"{lower} of {len(filling.closed)} parts of the region needed a simpler energy than {energy!r}.")
    return Edit(
        **additions(layer, filling.new_vertices, filling.new_faces),
        delete_vertices=np.concatenate([region, np.zeros(len(filling.new_vertices), dtype=np.bool_)]),
        values={
            "deleted_vertices": int(region.sum()),
            "deleted_faces": int(region[layer.faces].any(axis=1).sum()),
            "new_vertices": len(filling.new_vertices),
            "new_faces": len(filling.new_faces),
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
    """Joins two parts of a mesh by a smooth neck between two rims that face each other.

    A rim is a loop of border edges. The neck is a band of triangles, as dense as the rims, between the two nearest rims of
    different parts; its inside is faired. Old vertices stay. The new elements are selected. Merge parts in different layers
    first (Flatten Visible Layers). Returns the numbers of new vertices and triangles, and of the edges of each rim.

    Args:
        selected: Join the two nearest selected rims, which may belong to the same part; a rim is selected if all of its vertices
            are.
    """
    among = layer.selected_vertices() if selected else None
    blend = fairing.blend_parts(layer.vertices, layer.faces, energy=energy, among=among, progress=progress)
    doubt = (
        "The two rims do not face each other clearly enough to tell whether both parts face outwards; if the neck is "
        "twisted, turn the faces of one part over (invert faces orientation) and join them again."
    )
    return Edit(
        **additions(layer, blend.vertices, blend.faces),
        values={
            "new_vertices": len(blend.vertices),
            "new_faces": len(blend.faces),
            "first_rim_edges": len(blend.rims[0]),
            "second_rim_edges": len(blend.rims[1]),
        },
        notes=(doubt,) if blend.doubtful else (),
    )
