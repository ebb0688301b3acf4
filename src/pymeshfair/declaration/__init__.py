"""The vocabulary in which a filter declares itself: its parameters, the layer that it reads and the edit that it returns.

One frozen `Filter` drives everything that users see of it: the method of `MeshSet`, the checks, the .mlx reader and writer,
``pymeshfair info``, the documentation and MeshLab's dialog. It mirrors MeshLab's C++ ``FilterPlugin`` member by member.
The decorator `mesh_filter` makes one of a function with an annotated, keyword-only signature; CONTRIBUTING.md has an example.
This module imports neither pymeshlab nor any plugin.
"""

from ..errors import nearest
from .filter import Arity, Filter, FilterClass, MeshElement, mesh_filter
from .layer import Bools, Edit, Floats, Ints, Layer, NewLayer
from .parameters import (
    AUTO,
    Bool,
    Color,
    Direction,
    Enum,
    FileOpen,
    FileSave,
    Float,
    Int,
    Matrix,
    Mesh,
    Parameter,
    Percentage,
    Point,
    Shot,
    String,
)
from .units import Length, LengthUnit

__all__ = [
    "AUTO",
    "Arity",
    "Bool",
    "Bools",
    "Color",
    "Direction",
    "Edit",
    "Enum",
    "FileOpen",
    "FileSave",
    "Filter",
    "FilterClass",
    "Float",
    "Floats",
    "Int",
    "Ints",
    "Layer",
    "Length",
    "LengthUnit",
    "Matrix",
    "Mesh",
    "MeshElement",
    "NewLayer",
    "Parameter",
    "Percentage",
    "Point",
    "Shot",
    "String",
    "mesh_filter",
    "nearest",
]
