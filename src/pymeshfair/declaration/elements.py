"""MeshLab's own words for where a filter belongs, what it needs and what it changes."""

from __future__ import annotations

import enum


class FilterClass(enum.IntFlag):
    """The menus of MeshLab that a filter appears in, with MeshLab's own bits."""

    SELECTION = 0x1
    CLEANING = 0x2
    REMESHING = 0x4
    FACE_COLORING = 0x8
    VERTEX_COLORING = 0x10
    MESH_COLORING = 0x20
    MESH_CREATION = 0x40
    SMOOTHING = 0x80
    QUALITY = 0x100
    LAYER = 0x200
    RASTER_LAYER = 0x400
    NORMAL = 0x800
    SAMPLING = 0x1000
    TEXTURE = 0x2000
    RANGE_MAP = 0x4000
    POINT_SET = 0x8000
    MEASURE = 0x10000
    POLYGONAL = 0x20000
    CAMERA = 0x40000
    OTHER = 0x80000


class MeshElement(enum.IntFlag):
    """What a filter needs or changes, with the bits of MeshLab's ``MeshModel::MeshElement``."""

    NONE = 0
    VERTCOORD = 0x1
    VERTNORMAL = 0x2
    VERTFLAG = 0x4
    VERTCOLOR = 0x8
    VERTQUALITY = 0x10
    VERTNUMBER = 0x800
    FACEVERT = 0x1000
    FACENORMAL = 0x2000
    FACEFLAG = 0x4000
    FACECOLOR = 0x8000
    FACEQUALITY = 0x10000
    FACENUMBER = 0x80000
    WEDGTEXCOORD = 0x200000
    VERTFLAGSELECT = 0x1000000
    FACEFLAGSELECT = 0x2000000
    #: the edges of polylines; MeshLab has no bit for them and does not use this one
    EDGENUMBER = 0x4000000


class Arity(enum.IntEnum):
    """How many layers a filter reads, with MeshLab's numbers."""

    NONE = 0
    SINGLE_MESH = 1
    FIXED = 2
    VARIABLE = 3
