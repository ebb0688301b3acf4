"""The settings of a repertoire run side by side, so that what they predict can be compared."""

from collections.abc import Iterator, Sequence
from itertools import islice, pairwise

import numpy as np

from ..diffusion.taubin import taubin_fairing
from ..evidence import put_where_expected
from ..mesh import Bools, Floats, Ints, normalised_mesh
from ..topology import BorderPolicy, border_vertices
from .adjacency import Adjacency
from .face_neighbourhoods import RINGS_OF_NEIGHBORHOOD
from .relaxation import RelaxationDirection, along_normals, outline_kept
from .repertoire import REPERTOIRE, Chain, Repertoire
from .rounds import rounds


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
        whole: bool = True,
        of: Repertoire = REPERTOIRE,
    ) -> None:
        """For (m, 3) triangles of n vertices with (n, 3) unit normals, along which "normal" moves them.

        `replaced` are (n,) the outliers, where these have been replaced and may move alone. Patches are not the `whole` mesh: at
        their rims the surface does not end.
        """
        self._of = of
        self._faces, self._normals, self._border, self._movable = faces, normals, border, movable
        self._along, self._replaced = direction == "normal", replaced
        self._outline = border_vertices(faces, len(normals)) & (whole and border == "along")
        self._adjacency = Adjacency.of(normalised_mesh(np.zeros((len(normals), 3)), faces), ends=whole)
        # Here, once, and not by several threads at once.
        for kind in {"edge", "vertex", *(parameters.neighborhood for parameters, _ in of.chains)}:
            if kind in RINGS_OF_NEIGHBORHOOD:
                self._adjacency.around(kind)

    def __call__(self, points: Floats, held: Ints) -> Sequence[Iterator[Floats]]:
        """The results for (n, 3) points of ordinary size, by the families of `settings`.

        Where nothing but outliers moves the held-out vertices are moved like them, from where a quadric expects them: so well are
        they put back.
        """
        fair, of = {0: points}, self._of
        for before, steps in pairwise(sorted({0, *of.taubin, *of.relaxations})):
            fair[steps] = taubin_fairing(
                fair[before], self._faces, iterations=steps - before, border=self._border, movable=self._movable
            )
        if self._outline.any():
            fair = {steps: outline_kept(points, moved, self._normals, self._outline) for steps, moved in fair.items()}
        starts = {k: along_normals(points, fair[k], self._normals) if self._along else fair[k] for k in of.relaxations}
        families = [iter([fair[steps] for steps in of.taubin])]
        families += [self._chain(starts[k], chain, self._movable) for k in of.relaxations for chain in of.chains]
        if self._replaced is not None:
            moves = self._replaced.copy()
            moves[held] = True
            expected = put_where_expected(points, self._faces, self._normals, np.flatnonzero(moves).astype(np.int32))
            families += [iter([expected]), *(self._chain(expected, chain, moves) for chain in of.chains)]
        return families

    def _chain(self, points: Floats, chain: Chain, movable: Bools | None) -> Iterator[Floats]:
        return results_after(points, self._faces, self._adjacency, chain, border=self._border, movable=movable)


def results_after(
    points: Floats, faces: Ints, adjacency: Adjacency, chain: Chain, *, border: BorderPolicy, movable: Bools | None
) -> Iterator[Floats]:
    """The (n, 3) results of the rounds at which a chain may stop, ascending, for a mesh with this adjacency."""
    parameters, stops = chain
    mesh = normalised_mesh(points, faces, movable).in_order(adjacency.places)
    results = rounds(
        mesh,
        adjacency,
        parameters.normal_filter(),
        vertex_iterations=parameters.vertex_iterations,
        vertex_update=parameters.vertex_update,
        border=border,
    )
    done = 0
    for stop in stops:
        result = next(islice(results, stop - done - 1, None), mesh.points)
        done = stop
        yield mesh.restored(result)
