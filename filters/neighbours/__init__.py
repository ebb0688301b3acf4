"""Nearest neighbours of points."""

from .kd_tree import LEAF, build_tree
from .nearest import check_cloud, leaf_ranges, nearest_neighbours
from .tree_search import search_leaves

__all__ = [
    "LEAF",
    "build_tree",
    "check_cloud",
    "leaf_ranges",
    "nearest_neighbours",
    "search_leaves",
]
