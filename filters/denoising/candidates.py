"""What denoising without parameters chooses from: steps of Taubin's, and rounds of normal filtering after some of them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import islice, pairwise

import numpy as np

from ..diffusion.taubin import taubin_fairing
from ..evidence import put_where_expected
from ..execution import Progress, ignore_progress
from ..mesh import Bools, Floats, Ints, normalised_mesh
from ..robust import KernelName
from ..topology import BorderPolicy
from .face_neighbourhoods import Neighborhood
from .impulses import Outliers
from .normal_filter import NormalFilter, NormalFilterMethod
from .preparation import denoised
from .relaxation import RelaxationDirection, along_normals
from .rounds import rounds
from .surroundings import Surroundings


@dataclass(frozen=True)
class AutomaticParameters:
    """What `normal_filtering` is to be called with, by its names."""

    method: NormalFilterMethod
    range_kernel: KernelName
    range_sigma: float
    range_floor: float
    space_sigma: float
    neighborhood: Neighborhood
    vertex_iterations: int
    outer_iterations: int
    normal_iterations: int = 1

    def normal_filter(self) -> NormalFilter:
        """The filter of the normals in a round."""
        return NormalFilter(**{f.name: getattr(self, f.name) for f in fields(NormalFilter) if hasattr(self, f.name)})


@dataclass(frozen=True)
class Setting:
    """Pairs of Taubin's steps, see `relaxed`, then normal filtering, outliers taken away; none of them is nothing at all."""

    relaxation: int = 0
    relaxation_direction: RelaxationDirection = "all"
    parameters: AutomaticParameters | None = None
    outliers: Outliers = "keep"

    def apply(
        self,
        vertices: Floats,
        faces: Ints,
        *,
        border: BorderPolicy,
        movable: Bools | None,
        certain: Bools | None = None,
        progress: Progress = ignore_progress,
    ) -> Floats:
        """(n, 3) the vertices of the mesh after it, see `denoised`."""
        return denoised(
            vertices,
            faces,
            outliers=self.outliers,
            relaxation=self.relaxation,
            relaxation_direction=self.relaxation_direction,
            filtering=None if self.parameters is None else vars(self.parameters),
            border=border,
            movable=movable,
            certain=certain,
            progress=progress,
        )


#: Steps of Taubin's alone, and before the chains. Noise in all directions moves vertices along the surface too, and filters of
#: normals leave that as it is; the steps even it out.
TAUBIN, RELAXATIONS = (0, 1, 2, 3, 5, 8, 12, 18, 28), (0, 3, 7, 15)
#: Normal filtering with the outer iterations at which it may stop: kernels that cut off keep edges, the wider the more noise;
#: Huber's over few neighbours suits figures.
CHAINS: tuple[tuple[AutomaticParameters, tuple[int, ...]], ...] = (
    (AutomaticParameters("bilateral", "truncated_l1", 1.0, 0.03, 2.5, "two_ring", 10, 0), (2, 5, 10, 20)),
    (AutomaticParameters("bilateral", "truncated_l1", 0.5, 0.03, 2.5, "two_ring", 10, 0), (5, 10, 20)),
    (AutomaticParameters("averaged", "truncated_l2", 0.15, 0.0, 2.5, "two_ring", 10, 0), (2, 4, 8, 14)),
    (AutomaticParameters("averaged", "truncated_l2", 0.25, 0.0, 2.5, "two_ring", 10, 0), (4, 10, 20)),
    (AutomaticParameters("averaged", "huber", 0.1, 0.0, 1.5, "vertex", 4, 0), (1, 2, 3, 4, 5, 6, 8, 11)),
    (AutomaticParameters("bilateral", "huber", 0.1, 0.0, 1.5, "vertex", 5, 0), (1, 2, 3, 4, 5, 6, 8, 11, 16)),
)

#: What suits most meshes somewhat, for those who do not want to wait.
FIXED = AutomaticParameters("bilateral", "lorentzian", 0.12, 0.0, 1.5, "two_ring", 5, 30)


def settings(
    direction: RelaxationDirection, outliers: Outliers = "keep", *, alone: bool = True
) -> tuple[tuple[Setting, ...], ...]:
    """The settings, a row a family: Taubin's steps, and each chain after each number of them, in that direction.

    Where outliers are replaced and may move `alone`, more rows move nothing but them: to where they are expected, and each chain
    after that.
    """
    families = [
        tuple(Setting(relaxation, outliers=outliers) for relaxation in TAUBIN),
        *(_family(relaxation, direction, chain, outliers) for relaxation in RELAXATIONS for chain in CHAINS),
    ]
    if outliers == "replace" and alone:
        families += [(Setting(outliers="only"),), *(_family(0, direction, chain, "only") for chain in CHAINS)]
    return tuple(families)


def _family(
    relaxation: int, direction: RelaxationDirection, chain: tuple[AutomaticParameters, tuple[int, ...]], outliers: Outliers
) -> tuple[Setting, ...]:
    parameters, stops = chain
    return tuple(Setting(relaxation, direction, replace(parameters, outer_iterations=stop), outliers) for stop in stops)


class SettingsTried:
    """All `settings` on meshes of the same faces, what they have in common done once; see `choose`."""

    def __init__(
        self,
        faces: Ints,
        normals: Floats,
        direction: RelaxationDirection,
        *,
        border: BorderPolicy,
        movable: Bools | None,
        replaced: Bools | None = None,
    ) -> None:
        """For (m, 3) triangles of n vertices with (n, 3) unit normals, along which "normal" moves them.

        `replaced` are (n,) the outliers, where these have been replaced and may move alone.
        """
        self._faces, self._normals, self._border, self._movable = faces, normals, border, movable
        self._along, self._replaced = direction == "normal", replaced
        self._known = Surroundings.of(normalised_mesh(np.zeros((len(normals), 3)), faces))
        # Found here, once, and not by several threads at once.
        for kind in {"edge", "vertex", *(chain.neighborhood for chain, _ in CHAINS)}:
            self._known.around(kind)

    def __call__(self, points: Floats, held: Ints) -> Sequence[Iterator[Floats]]:
        """The results for (n, 3) points of ordinary size, by the families of `settings`.

        Where nothing but outliers moves the held-out vertices are moved like them, from where a quadric expects them: so well are
        they put back.
        """
        fair = {0: points}
        for before, steps in pairwise(sorted({*TAUBIN, *RELAXATIONS})):
            fair[steps] = taubin_fairing(
                fair[before], self._faces, iterations=steps - before, border=self._border, movable=self._movable
            )
        starts = {k: along_normals(points, fair[k], self._normals) if self._along else fair[k] for k in RELAXATIONS}
        families = [iter([fair[steps] for steps in TAUBIN])]
        families += [self._chain(starts[k], *chain, self._movable) for k in RELAXATIONS for chain in CHAINS]
        if self._replaced is not None:
            moves = self._replaced.copy()
            moves[held] = True
            expected = put_where_expected(points, self._faces, self._normals, np.flatnonzero(moves).astype(np.int32))
            families += [iter([expected]), *(self._chain(expected, *chain, moves) for chain in CHAINS)]
        return families

    def _chain(
        self, points: Floats, chain: AutomaticParameters, stops: tuple[int, ...], movable: Bools | None
    ) -> Iterator[Floats]:
        return results_after(points, self._faces, self._known, chain, stops, border=self._border, movable=movable)


def results_after(
    points: Floats,
    faces: Ints,
    known: Surroundings,
    chain: AutomaticParameters,
    stops: tuple[int, ...],
    *,
    border: BorderPolicy,
    movable: Bools | None,
) -> Iterator[Floats]:
    """The (n, 3) results of the rounds at which a chain may stop, ascending, for a mesh whose adjacency is known."""
    mesh = normalised_mesh(points, faces, movable).in_order(known.places)
    results = rounds(mesh, known, chain.normal_filter(), vertex_iterations=chain.vertex_iterations, border=border)
    done = 0
    for stop in stops:
        result = next(islice(results, stop - done - 1, None), mesh.points)
        done = stop
        yield mesh.restored(result)
