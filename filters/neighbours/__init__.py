"""Nearest neighbours of points, and balls that touch a surface."""

from .cells import CellTree, Nearest, cells_within, offer_cells, reaching_out
from .kd_tree import LEAF, build_tree, partition, tree_scale
from .nearest import check_cloud, leaf_ranges, nearest_neighbours, search_leaves
from .touching_balls import touching_balls

__all__ = [
    "LEAF",
    "CellTree",
    "Nearest",
    "build_tree",
    "cells_within",
    "check_cloud",
    "leaf_ranges",
    "nearest_neighbours",
    "offer_cells",
    "partition",
    "reaching_out",
    "search_leaves",
    "touching_balls",
    "tree_scale",
]
