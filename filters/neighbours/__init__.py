"""Nearest neighbours of points, in memory or by cells, and balls that touch a surface."""

from .cells import CellTree, Nearest, cells_within, gap_to, offer_cells, reaching_out
from .kd_tree import LEAF, build_tree, check_cloud, leaf_ranges, nearest_neighbours, search_leaves, split_nodes, tree_scale
from .touching_balls import touching_balls

__all__ = [
    "LEAF",
    "CellTree",
    "Nearest",
    "build_tree",
    "cells_within",
    "check_cloud",
    "gap_to",
    "leaf_ranges",
    "nearest_neighbours",
    "offer_cells",
    "reaching_out",
    "search_leaves",
    "split_nodes",
    "touching_balls",
    "tree_scale",
]
