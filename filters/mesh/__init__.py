"""A mesh as arrays: types, checks of input, normalised meshes, orders of vertices."""

from .arrays import Bools, Floats, Ints, Longs, check_edges, check_mesh, check_movable, check_points, check_vertex_mask, mask_of
from .normalised import NormalisedMesh, Whole, bounding_box, check_healthy, normalised_mesh, scaled_to_unit, spikes, unit_scale
from .ordering import order_by_place, order_of_faces, worth_reordering

__all__ = [
    "Bools",
    "Floats",
    "Ints",
    "Longs",
    "NormalisedMesh",
    "Whole",
    "bounding_box",
    "check_edges",
    "check_healthy",
    "check_mesh",
    "check_movable",
    "check_points",
    "check_vertex_mask",
    "mask_of",
    "normalised_mesh",
    "order_by_place",
    "order_of_faces",
    "scaled_to_unit",
    "spikes",
    "unit_scale",
    "worth_reordering",
]
