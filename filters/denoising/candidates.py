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
from .impulses import Outliers
from .relaxation import along_normals, direction_for, outline_kept
from .repertoire import REPERTOIRE, Chain, Repertoire, settings
from .rounding import RoundingPolicy
from .rounds import rounds
from .scan import Scan


class SettingsTried:
    """All `settings` on points with the faces of a scan, what they have in common done once; see `Scan.choose`.

    Attributes:
        labels: the settings, a row a family.
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
        """Where outliers have been replaced they may move `alone`. At the rims of patches the surface does not end."""
        direction = of.relaxation_direction or direction_for(scan.noise)
        outliers: Outliers = "keep" if scan.replaced is None else "replace"
        self.labels = settings(direction, outliers, alone=alone, of=of, rounding=rounding)
        self._scan, self._border, self._of = scan, border, of
        self._along, self._replaced = direction == "normal", scan.replaced if alone else None
        self._outline = border_vertices(scan.faces, len(scan.points)) & (scan.whole and border == "along")
        self._adjacency = Adjacency.of(normalised_mesh(np.zeros_like(scan.points), scan.faces), ends=scan.whole)
        # Here, once, and not by several threads at once.
        for kind in {"edge", "vertex", *(parameters.neighborhood for parameters, _ in of.chains)}:
            if kind in RINGS_OF_NEIGHBORHOOD:
                self._adjacency.around(kind)

    def __call__(self, points: Floats, held: Ints) -> Sequence[Iterator[Floats]]:
        """The results for (n, 3) points of ordinary size, by the families of `settings`.

        Where nothing but outliers moves the held-out vertices are moved like them, from where a quadric expects them: so well are
        they put back.
        """
        fair, of, scan = {0: points}, self._of, self._scan
        for before, steps in pairwise(sorted({0, *of.taubin, *of.relaxations})):
            fair[steps] = taubin_fairing(
                fair[before], scan.faces, iterations=steps - before, border=self._border, movable=scan.movable
            )
        if self._outline.any():
            fair = {steps: outline_kept(points, moved, scan.normals, self._outline) for steps, moved in fair.items()}
        starts = {k: along_normals(points, fair[k], scan.normals) if self._along else fair[k] for k in of.relaxations}
        families = [iter([fair[steps] for steps in of.taubin])]
        families += [self._results(starts[k], chain, scan.movable) for k in of.relaxations for chain in of.chains]
        if self._replaced is not None:
            moves = self._replaced.copy()
            moves[held] = True
            expected = put_where_expected(points, scan.faces, scan.normals, np.flatnonzero(moves).astype(np.int32))
            families += [iter([expected]), *(self._results(expected, chain, moves) for chain in of.chains)]
        return families

    def _results(self, points: Floats, chain: Chain, movable: Bools | None) -> Iterator[Floats]:
        """The (n, 3) results of the rounds at which a chain may stop, ascending."""
        parameters, stops = chain
        mesh = normalised_mesh(points, self._scan.faces, movable).in_order(self._adjacency.places)
        results = rounds(
            mesh,
            self._adjacency,
            parameters.normal_filter(),
            vertex_iterations=parameters.vertex_iterations,
            vertex_update=parameters.vertex_update,
            border=self._border,
        )
        for done, stop in pairwise((0, *stops)):
            yield mesh.restored(next(islice(results, stop - done - 1, None), mesh.points))
