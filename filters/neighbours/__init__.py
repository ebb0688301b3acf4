"""Nearest neighbours of points, and balls that touch a surface."""

from .kd_tree import LEAF, build_tree
from .nearest import check_cloud, leaf_ranges, nearest_neighbours
from .touching_balls import touching_balls
from .tree_search import search_leaves

__all__ = [
    "LEAF",
    "build_tree",
    "check_cloud",
    "leaf_ranges",
    "nearest_neighbours",
    "search_leaves",
    "touching_balls",
]
