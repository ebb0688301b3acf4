"""Candidate settings of automatic denoising: Taubin steps alone, and rounds of normal filtering after Taubin steps."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import islice, pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..diffusion.explicit import taubin_fairing
from ..evidence import put_where_expected
from ..mesh import Bools, Floats, Ints, mask_of, normalised_mesh
from ..robust import KernelName
from ..topology import BorderPolicy, border_vertices
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD, Adjacency, Neighborhood
from .impulses import Outliers
from .normal_filter import NormalFilter, NormalFilterMethod, RangeMeasure, SpaceKernel
from .normal_filtering import rounds
from .preparation import RelaxationDirection, along_normals, denoised, direction_for, outline_kept
from .rounding import RoundingPolicy
from .scan import Scan
from .vertex_update import VertexUpdate


@dataclass(frozen=True)
class AutomaticParameters:
    """Arguments of `normal_filtering`, under the same names."""

    method: NormalFilterMethod
    range_kernel: KernelName
    range_sigma: float
    range_floor: float
    space_sigma: float
    neighborhood: Neighborhood
    vertex_iterations: int
    outer_iterations: int
    normal_iterations: int = 1
    space_kernel: SpaceKernel = "gaussian"
    range_measure: RangeMeasure = "euclidean"
    vertex_update: VertexUpdate = "sun"


@dataclass(frozen=True)
class Setting:
    """The steps of `denoised` and their parameters; the default setting does nothing."""

    relaxation: int = 0
    relaxation_direction: RelaxationDirection = "all"
    parameters: AutomaticParameters | None = None
    outliers: Outliers = "keep"
    rounding: RoundingPolicy = "keep"

    def apply(self, vertices: Floats, faces: Ints, **how: Any) -> Floats:
        """Returns (n, 3) the vertices after these steps. `how` are the other arguments of `denoised`."""
        values = {name: value for name, value in vars(self).items() if name != "parameters"}
        return denoised(vertices, faces, **values, filtering=None if self.parameters is None else vars(self.parameters), **how)


#: parameters of normal filtering, and the numbers of outer iterations to try
Chain: TypeAlias = tuple[AutomaticParameters, tuple[int, ...]]


class Repertoire(NamedTuple):
    """The candidates, as lists of parameters."""

    relaxations: tuple[int, ...]  # numbers of pairs of Taubin steps before the chains
    chains: tuple[Chain, ...]
    taubin: tuple[int, ...] = (0, 1, 2, 3, 5, 8, 12, 18, 28)  # numbers of pairs of Taubin steps alone; 0 does nothing
    relaxation_direction: RelaxationDirection | None = None  # None: "all" for Taubin steps alone, `direction_for` before chains
    outliers: Outliers | None = None  # treatment of outliers; None takes it from the mesh

    def narrowed(
        self,
        *,
        relaxation: int | None = None,
        relaxation_direction: RelaxationDirection | None = None,
        outliers: Outliers | None = None,
        **filtering: Any,
    ) -> "Repertoire":
        """The repertoire with these values: no `chains` if outer_iterations=0; else any `filtering` leaves only 0 in `taubin`."""
        rounds, chains = filtering.pop("outer_iterations", None), dict[AutomaticParameters, set[int]]()
        for parameters, stops in self.chains if rounds != 0 else ():
            chains.setdefault(replace(parameters, **filtering), set()).update(stops if rounds is None else [rounds])
        taubin = self.taubin if relaxation is None else (0, relaxation)
        return Repertoire(
            self.relaxations if relaxation is None else (relaxation,),
            tuple((parameters, tuple(sorted(stops))) for parameters, stops in chains.items()),
            tuple(sorted(set(taubin))) if rounds == 0 or (rounds is None and not filtering) else (0,),
            relaxation_direction or self.relaxation_direction,
            outliers or self.outliers,
        )


#: For independent noise. Taubin steps reduce noise along the surface; normal filtering does not. Gaussian kernels over one ring
#: suit curved parts, over two rings flat parts. Truncated L1 keeps sharp edges, Huber's kernel suits figures such as statues.
REPERTOIRE = Repertoire(
    relaxations=(0, 3, 7, 15),
    chains=(
        (AutomaticParameters("bilateral", "truncated_l1", 1.0, 0.03, 2.5, "two_ring", 10, 0), (2, 5, 10, 20)),
        (AutomaticParameters("bilateral", "truncated_l1", 0.5, 0.03, 2.5, "two_ring", 10, 0), (5, 10, 20)),
        (AutomaticParameters("bilateral", "gaussian", 0.25, 0.0, 2.5, "two_ring", 10, 0), (2, 5, 10, 20, 40)),
        (AutomaticParameters("bilateral", "gaussian", 0.4, 0.0, 2.5, "two_ring", 10, 0), (2, 5, 10, 20, 40)),
        (AutomaticParameters("averaged", "huber", 0.1, 0.0, 1.5, "vertex", 4, 0), (1, 2, 3, 4, 6, 8, 11)),
        (AutomaticParameters("bilateral", "gaussian", 0.25, 0.0, 1.5, "vertex", 5, 0), (1, 2, 4, 8, 16)),
        (AutomaticParameters("bilateral", "gaussian", 0.4, 0.0, 1.5, "vertex", 5, 0), (1, 2, 4, 8, 16)),
    ),
)

#: For noise that neighbours share: mostly two rings, and many rounds.
_WIDE = AutomaticParameters("averaged", "gaussian", 0.4, 0.0, 2.5, "two_ring", 20, 0)
CORRELATED = Repertoire(
    relaxations=(0, 7),
    chains=(
        (_WIDE, (1, 2, 3, 5, 7, 10, 14, 20, 28, 40)),
        (AutomaticParameters("bilateral", "truncated_l1", 0.5, 0.03, 2.5, "two_ring", 10, 0), (2, 5, 10, 20)),
        (AutomaticParameters("averaged", "truncated_l2", 0.25, 0.0, 2.5, "two_ring", 10, 0), (2, 4, 10, 20)),
        (AutomaticParameters("averaged", "huber", 0.1, 0.0, 1.5, "vertex", 4, 0), (1, 2, 3, 4, 6, 8, 11, 16)),
    ),
)

#: All-round parameters, for users who skip the choice.
FIXED = AutomaticParameters("bilateral", "lorentzian", 0.12, 0.0, 1.5, "two_ring", 5, 30)


class SettingsTried:
    """Runs settings on the faces of a scan and computes their common steps once.

    `labels` has a list of settings for each family: for Taubin steps alone, and for each chain after each number of Taubin steps.
    With `alone` there are also families that move only outliers: one puts them at predicted places, the others then filter them.
    """

    def __init__(
        self,
        scan: Scan,
        *,
        border: BorderPolicy,
        of: Repertoire = REPERTOIRE,
        alone: bool = False,
        rounding: RoundingPolicy = "keep",
    ) -> None:
        of_alone, direction = of.relaxation_direction or "all", of.relaxation_direction or direction_for(scan.noise)
        outliers: Outliers = "keep" if scan.replaced is None else "replace"

        def family(relaxation: int, chain: Chain, outliers: Outliers) -> list[Setting]:
            parameters = (replace(chain[0], outer_iterations=stop) for stop in chain[1])
            return [Setting(relaxation, direction, each, outliers, rounding) for each in parameters]

        self.labels = [[Setting(k, of_alone if k else "all", None, outliers, rounding) for k in of.taubin]]
        self.labels += [family(relaxation, chain, outliers) for relaxation in of.relaxations for chain in of.chains]
        self._scan, self._border, self._of = scan, border, of
        self._along, self._replaced = direction == "normal", scan.replaced if alone else None
        if self._replaced is not None:
            self.labels += [[Setting(outliers="only")], *(family(0, chain, "only") for chain in of.chains)]
        self._outline = border_vertices(scan.faces, len(scan.points)) & (scan.whole and border == "along")
        self._adjacency = Adjacency.of(normalised_mesh(np.zeros_like(scan.points), scan.faces), ends=scan.whole)
        for kind in {"edge", "vertex", *(parameters.neighborhood for parameters, _ in of.chains)}:
            if kind in RINGS_OF_NEIGHBORHOOD:
                self._adjacency.around(kind)  # fills the cache before several threads read it

    def __call__(self, points: Floats, held: Ints) -> Sequence[Iterator[Floats]]:
        """Returns the results of each family for (n, 3) points in units of the mean edge; `held` are the held-out vertices.

        Families that move only outliers move the held-out vertices, too: the errors there show how well they restore outliers.
        """
        fair, of, scan = {0: points}, self._of, self._scan
        for before, steps in pairwise(sorted({0, *of.taubin, *of.relaxations})):
            added = steps - before
            fair[steps] = taubin_fairing(fair[before], scan.faces, iterations=added, border=self._border, movable=scan.movable)
        if self._outline.any():
            fair = {steps: outline_kept(points, moved, scan.normals, self._outline) for steps, moved in fair.items()}
        along = {k: along_normals(points, moved, scan.normals) for k, moved in fair.items()} if self._along else fair
        families = [iter([(along if of.relaxation_direction else fair)[k] for k in of.taubin])]
        families += [self._results(along[k], chain, scan.movable) for k in of.relaxations for chain in of.chains]
        if self._replaced is not None:
            moves = self._replaced | mask_of(held, len(points))
            expected = put_where_expected(points, scan.faces, scan.normals, np.flatnonzero(moves).astype(np.int32))
            families += [iter([expected]), *(self._results(expected, chain, moves) for chain in of.chains)]
        return families

    def _results(self, points: Floats, chain: Chain, movable: Bools | None) -> Iterator[Floats]:
        """Yields the (n, 3) result after each number of rounds of a chain, ascending."""
        parameters, stops = chain
        mesh = normalised_mesh(points, self._scan.faces, movable).in_order(self._adjacency.places)
        attributes = vars(parameters)
        normal_filter = NormalFilter(**{f.name: attributes[f.name] for f in fields(NormalFilter) if f.name in attributes})
        of_vertices = {name: attributes[name] for name in ("vertex_iterations", "vertex_update")}
        results = rounds(mesh, self._adjacency, normal_filter, border=self._border, **of_vertices)
        for done, stop in pairwise((0, *stops)):
            yield mesh.restored(next(islice(results, stop - done - 1, None), mesh.points))
