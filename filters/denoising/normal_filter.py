"""The settings of a filter of face normals, and what each of them means."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, TypedDict, TypeVar

from ..checks import check_choice, check_finite, check_positive, check_whole_number
from ..robust import KernelName
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, Neighborhood
from .normal_filters import SPACE_KERNELS, RangeMeasure, SpaceKernel

#: "mean": weights are areas alone [belyaev2001]. "unilateral": areas and a kernel of the deviation of normals [yadav2021].
#: "bilateral": and a kernel of the distance [zheng2011]. "averaged": bilateral, the deviation measured on normals averaged over
#: the faces at the vertices of a face. "guided": bilateral, the deviation measured on guide normals [zhang2015].
#: "vertex_normals": bilateral, on the normals of vertices; a face gets the mean of its corners'. It is there to compare with.
NormalFilterMethod: TypeAlias = Literal["mean", "unilateral", "bilateral", "averaged", "guided", "vertex_normals"]

_Function = TypeVar("_Function", bound=Callable[..., Any])


@dataclass(frozen=True, kw_only=True)
class NormalFilter:
    """How face normals are filtered: n_i <- normalise(sum_j A_j f(|c_i - c_j|) g(x_ij) n_j), `normal_iterations` times.

    The sum goes over the faces j around face i, of area A and centre c; x_ij is the deviation of their normals; see
    `weighted_normals`. Where a border cuts these faces off the mean follows the trend of the normals, see `follow_trend`. The
    defaults are those of [zheng2011] in their authors' code.

    Attributes:
        method: how weights come about; see `NormalFilterMethod`.
        range_kernel: g; not used by "mean". Kernels that reach 0 ("truncated_l1", "truncated_l2", "tukey") keep edges; "huber",
            "lorentzian" and "gaussian" suit smooth shapes.
        space_kernel: f; not used by "mean" and "unilateral".
        range_measure: how the deviation x of two normals is measured.
        range_sigma: the scale of g, in the unit of the measure. Larger smooths more and across sharper features. For "gaussian"
            the standard deviation.
        range_floor: smaller deviations count as this one, in the unit of the measure. Above 0 it keeps "l1" and "truncated_l1",
            whose weight is 1 / x, from locking the normals of two faces that happen to agree; 0.03 does them good.
        space_sigma: the scale of f, in mean distances of the centres of faces that share an edge. Larger smooths larger details,
            as far as the neighbourhood reaches. For "gaussian" the standard deviation.
        neighborhood: which faces are averaged over; see `Neighborhood`. Larger smooths larger details, and costs in proportion.
            With "vertex_normals" rings of vertices: one for "edge" and "vertex", two, or three; distances are then in mean edges.
        radius: for the neighbourhoods "radius" and "geodesic", in mean distances of the centres of the input.
        normal_iterations: filter passes. More smooth more.

    Raises:
        FilterInputError: a value that is not allowed.
    """

    method: NormalFilterMethod = "bilateral"
    range_kernel: KernelName = "gaussian"
    space_kernel: SpaceKernel = "gaussian"
    range_measure: RangeMeasure = "euclidean"
    range_sigma: float = 0.35
    range_floor: float = 0.0
    space_sigma: float = 1.0
    neighborhood: Neighborhood = "vertex"
    radius: float = 2.0
    normal_iterations: int = 20

    def __post_init__(self) -> None:
        check_choice("method", self.method, NormalFilterMethod)
        check_choice("range_kernel", self.range_kernel, SPACE_KERNELS[1:])
        check_choice("space_kernel", self.space_kernel, SPACE_KERNELS)
        check_choice("range_measure", self.range_measure, RangeMeasure)
        check_choice("neighborhood", self.neighborhood, Neighborhood)
        check_positive("range_sigma", self.range_sigma)
        check_finite("range_floor", self.range_floor, least=0.0)
        check_positive("space_sigma", self.space_sigma)
        check_positive("radius", self.radius)
        check_whole_number("normal_iterations", self.normal_iterations)
        if self.method == "vertex_normals":
            check_choice("neighborhood of the method 'vertex_normals'", self.neighborhood, tuple(RINGS_OF_NEIGHBORHOOD))

    @property
    def ignores_numbers_of_faces(self) -> bool:
        """Whether results have the same bits however faces are numbered, as long as each lists its neighbours in the same order.

        "guided" takes the lowest of patches that are as good; "vertex_normals" sums up over all faces.
        """
        return self.method not in ("guided", "vertex_normals")


class NormalFilterKeywords(TypedDict, total=False):
    """The attributes of `NormalFilter` as keyword arguments of a function, for type checkers."""

    method: NormalFilterMethod
    range_kernel: KernelName
    space_kernel: SpaceKernel
    range_measure: RangeMeasure
    range_sigma: float
    range_floor: float
    space_sigma: float
    neighborhood: Neighborhood
    radius: float
    normal_iterations: int


def lists_settings(function: _Function) -> _Function:
    """The function, whose signature lists the attributes of `NormalFilter` that it takes as ``**keywords``, for `help`."""
    signature = inspect.signature(function)
    listed = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
    settings = inspect.signature(NormalFilter).parameters.values()
    function.__signature__ = signature.replace(parameters=[*listed, *settings])  # type: ignore[attr-defined]
    return function
