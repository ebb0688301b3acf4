"""Nearest neighbours of points."""

from .kd_tree import LEAF, build_tree
from .nearest import check_cloud, chunks, nearest_neighbours
from .tree_search import search

__all__ = [
    "LEAF",
    "build_tree",
    "check_cloud",
    "chunks",
    "nearest_neighbours",
    "search",
]
