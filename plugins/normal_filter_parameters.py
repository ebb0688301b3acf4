"""The parameters of filters of face normals, each of which may be left to the scan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from pymeshfair.declaration import Enum, Float, Int
from pymeshfair.filters.denoising import (
    NEIGHBORHOODS,
    NORMAL_FILTER_METHODS,
    RANGE_MEASURES,
    SPACE_KERNELS,
    Neighborhood,
    NormalFilterMethod,
    RangeMeasure,
    SpaceKernel,
)
from pymeshfair.filters.robust import KERNEL_NAMES, KernelName

Auto: TypeAlias = Literal["auto"]


@dataclass(frozen=True, kw_only=True)
class NormalFilterParameters:
    """How face normals are filtered; see `NormalFilter`. "auto", 0, and -1 of the range floor, mean: chosen for the mesh."""

    method: Annotated[
        Auto | NormalFilterMethod,
        Enum(
            label="Method",
            choices=("auto", *NORMAL_FILTER_METHODS),
            help="What the weight of a neighbouring face is made of, besides its area. 'mean': nothing else, which rounds every "
            "edge. 'unilateral': how far its normal deviates. 'bilateral': and how far away it is. 'averaged': bilateral, "
            "deviations measured on normals averaged before, for strong noise. 'guided': on the normals of the most even "
            "patches, for sharp edges. 'vertex_normals': bilateral on the normals of vertices, which loses edges; to compare "
            "with.",
        ),
    ] = "auto"
    range_kernel: Annotated[
        Auto | KernelName,
        Enum(
            label="Range kernel",
            choices=("auto", *KERNEL_NAMES),
            help="How weight falls with the deviation of normals. 'truncated_l1', 'truncated_l2' and 'tukey' reach 0 and keep "
            "edges; 'huber', 'lorentzian' and 'gaussian' suit smooth shapes.",
        ),
    ] = "auto"
    space_kernel: Annotated[
        Auto | SpaceKernel,
        Enum(
            label="Space kernel",
            choices=("auto", *SPACE_KERNELS),
            advanced=True,
            help="How weight falls with distance; 'constant' does not.",
        ),
    ] = "auto"
    range_measure: Annotated[
        Auto | RangeMeasure,
        Enum(
            label="Range measure",
            choices=("auto", *RANGE_MEASURES),
            advanced=True,
            help="How the deviation of two normals is measured: 'euclidean', the length of their difference, up to 2; 'angle' in "
            "radians; 'squared', the square of that length.",
        ),
    ] = "auto"
    range_sigma: Annotated[
        float,
        Float(
            label="Range sigma",
            minimum=0,
            help="The deviation of normals at which the range kernel falls, in the unit of the range measure; 0.5 is about 30 "
            "degrees. Larger smooths more, and across sharper edges. 0: automatic.",
        ),
    ] = 0.0
    range_floor: Annotated[
        float,
        Float(
            label="Range floor",
            minimum=-1,
            maximum=4,
            advanced=True,
            help="Smaller deviations count as this one. Above 0, such as 0.03, it keeps 'l1' and 'truncated_l1' from locking "
            "the normals of two faces that happen to agree. -1: automatic.",
        ),
    ] = -1.0
    space_sigma: Annotated[
        float,
        Float(
            label="Space sigma",
            minimum=0,
            help="The distance at which the space kernel falls, in mean distances of neighbouring triangles' centres. Larger "
            "smooths larger details. 0: automatic.",
        ),
    ] = 0.0
    neighborhood: Annotated[
        Auto | Neighborhood,
        Enum(
            label="Neighborhood",
            choices=("auto", *NEIGHBORHOODS),
            help="Which faces are averaged over: those across the edges, those at the vertices, those in two or three rings, or "
            "those within a radius of twice the mean distance of centres, straight ('radius') or along the surface "
            "('geodesic'), which does not jump across a thin wall. Larger smooths larger details and is slower.",
        ),
    ] = "auto"
    normal_iterations: Annotated[
        int,
        Int(
            label="Normal iterations",
            minimum=0,
            maximum=10_000,
            help="How often the normals are filtered before the vertices follow. More smooth more. 0: automatic.",
        ),
    ] = 0
