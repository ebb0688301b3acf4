"""Minimises area, bending or curvature change of a region inside fixed rings [botsch2004]."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..checks import ConvergenceError, FilterInputError, check_choice
from ..compilation import compiled
from ..execution import Progress, ignore_progress
from ..geometry import cross_product
from ..libraries import sparse
from ..linear_solvers import RefinedSolution, laplacian_power, refined_solution
from ..mesh import Bools, Floats, Ints, check_healthy, check_mesh, check_vertex_mask, mask_of, normalised_mesh, spikes
from ..operators import surface_laplacian
from ..topology import Submesh, proper_faces, submesh_around

Energy: TypeAlias = Literal["membrane", "thin_plate", "minimum_variation"]
ENERGIES: tuple[Energy, ...] = get_args(Energy)
# The mass of a vertex is at least `_LEAST_MASS` times the largest mass next to it, because slivers would spoil the conditioning.
# This bound is local, since whole parts may be tiny. Masses below `_NO_MASS` of the mean mass count as 0.
_LEAST_MASS, _NO_MASS = 1e-6, 1e-20


@dataclass(frozen=True, eq=False)
class FairedRegion:
    """A mesh with a fair region, and the accuracy of the solution.

    Attributes:
        vertices: (n, 3) all vertices; those that are not free keep every bit.
        free: (n,) the vertices that were solved for: those of the region that have a triangle and lie on no border.
        backward_error: `SpdSystem.backward_error`, with the residual in twice the precision; 0 if nothing was free.
        last_correction: the largest change of a coordinate in the last correction of the solution, as a share of the
            diagonal of the region with its rings. Usually the error of a coordinate is smaller.
        refinements: the number of corrections.
        area_share: the new area of the triangles with a free vertex over the old area; 1 if the old area was 0. Near 0, the
            fixed vertices lie too close together to span the region.
        irregular: the number of vertices placed by connectivity alone, because the surface's equations made spikes in their
            component or could not be solved; see `evened_operator`.
    """

    vertices: Floats
    free: Bools
    backward_error: float = 0.0
    last_correction: float = 0.0
    refinements: int = 0
    area_share: float = 1.0
    irregular: int = 0


def fair_region(
    vertices: ArrayLike,
    faces: ArrayLike,
    free: ArrayLike,
    *,
    energy: Energy = "thin_plate",
    dense: bool = False,
    progress: Progress = ignore_progress,
) -> FairedRegion:
    """Solves L^k p = 0 on the free vertices, k = 1, 2, 3, with the k rings of fixed vertices around as boundary [botsch2004].

    The symmetric form is (S M^-1)^(k-1) S p = 0 with S = -C, and C and M from `surface_laplacian` of the input with a lower bound
    on M. Its solution minimises the integral of |grad p|^2, |L p|^2 or |grad L p|^2. The former shape of the region matters
    only through S and M. Fairing once more, with the operator of the faired surface, comes closer to the surface of least area
    or bending.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        free: (n,) bool, the vertices to place. Border vertices of the mesh and vertices without a triangle stay, because a free
            border would shrink the region. At a fixed border the slope of a thin plate is not given, and L p = 0 there ("simply
            supported").
        energy: "membrane": k = 1, the region meets its rim at any angle. "thin_plate": k = 2, tangents continue across the rim.
            "minimum_variation": k = 3, curvatures continue too, and the region bulges like its surroundings.
        dense: whether the region is sampled more densely than its surroundings, like the filling of a hole. For a thin plate the
            mass of a fixed vertex at the rim is then at most the mean mass of its free neighbours. With a larger mass a crease
            along the rim would cost too little, and the region would meet the rim at an angle.
        progress: called from time to time with the share that is done; may raise to stop.

    Raises:
        FilterInputError: not a mesh, or an unknown energy. Also a connected part of the free vertices without a fixed neighbour,
            such as a whole closed component: its place is undetermined. Also a part with fewer than three fixed vertices within k
            rings, or with all of them in one line that does not contain the part: it would shrink. Also a vertex that would be
            moved by more than twice the diagonal of the region with its rings, even when placed by connectivity alone.
        ConvergenceError: the equations are too ill-conditioned to be solved.
    """
    points, triangles = check_mesh(vertices, faces)
    check_choice("energy", energy, ENERGIES)
    order = ENERGIES.index(energy) + 1
    chosen = check_vertex_mask("free", free, len(points))
    part = submesh_around(points, triangles, chosen, order) if chosen.any() else None
    if part is None or not part.free.any() or (part.points == part.points[0]).all():
        progress(1.0)
        return FairedRegion(points.copy(), np.zeros(len(points), dtype=np.bool_))
    mesh = normalised_mesh(part.points, part.faces)
    part = part._replace(points=mesh.points)
    operator = surface_operator(part.points, part.faces)
    system = _system(operator, part, order, dense)
    _check_held(system, part)
    extent = mesh.diagonal
    spiky, irregular = np.ones(len(mesh.points), dtype=np.bool_), 0
    places = np.flatnonzero(part.free)
    before = system.points.take(places, axis=0)
    try:
        solution = system.solution(extent, progress)
        spiky[:] = False
        spiky[places] = spikes(before, solution.values, extent)
    except ConvergenceError:
        pass  # it is not known which vertices cause this error: all count as spikes
    if spiky.any():
        operator, even = evened_operator(operator, part.faces, spiky)
        system = _system(operator, part, order, dense)
        solution, irregular = system.solution(extent, progress), int((even & part.free).sum())
        lower = f", or take energy '{ENERGIES[order - 2]}'" if order > 1 else ""
        cause = f"the triangles there are too irregular: improve them{lower}"
        check_healthy(before, solution.values, extent, part.vertices[part.free], cause)
    progress(1.0)
    moved, freed = points.copy(), part.vertices.take(places)
    moved[freed] = solution.values / mesh.scale + mesh.middle
    faired = part.points.copy()
    faired[places] = solution.values
    area_before, area_after = _areas(part.points, faired, part.free, part.faces)
    share = area_after / area_before if area_before > 0.0 else 1.0
    accuracy = solution.backward_error, solution.last_correction / extent, solution.refinements
    return FairedRegion(moved, mask_of(freed, len(points)), *accuracy, share, irregular)


class _System(NamedTuple):
    """(S M^-1)^(k-1) S p = 0 on the free vertices of a submesh."""

    dirichlet: sparse.csr_matrix  # S, (n, n)
    columns: sparse.csr_matrix  # (n, f) the columns of the free vertices
    inner: sparse.csr_matrix  # (f, f) the rows of the free vertices in these columns
    inverse_mass: Floats
    order: int
    points: Floats
    free: Bools

    def matrix(self) -> sparse.csr_matrix:
        """Returns the rows and columns of the free vertices in (S M^-1)^(k-1) S, (f, f)."""
        if self.order == 1:
            return self.inner
        scaled = sparse.csr_matrix(sparse.diags_array(self.inverse_mass) @ self.columns)
        return sparse.csr_matrix(self.columns.T @ scaled if self.order == 2 else scaled.T @ (self.dirichlet @ scaled))

    def solution(self, extent: float, progress: Progress) -> RefinedSolution:
        # A membrane is so well-conditioned that the residual of the first guess needs only ordinary precision.
        first = -(self.dirichlet @ self.points).compress(self.free, axis=0) if self.order == 1 else None
        return refined_solution(
            self.matrix(), self.residual, self.points.compress(self.free, axis=0), extent=extent, first=first, progress=progress
        )

    def residual(self, values: Floats) -> Floats:
        """Returns -(S M^-1)^(k-1) S p at the free vertices, in twice the precision; `values` are their coordinates."""
        all_points, places = self.points.copy(), np.flatnonzero(self.free)
        all_points[places] = values
        return -laplacian_power(self.dirichlet, self.inverse_mass, self.order, all_points).take(places, axis=0)


def _system(operator: SurfaceOperator, part: Submesh, order: int, dense: bool) -> _System:
    # Masses are divided by their mean so that their powers neither overflow nor underflow; this does not change the solution.
    # Border vertices get the inverse mass 0, because a Laplacian needs a closed one-ring.
    mass = _rim_as_dense(operator, part.free) if dense and order == 2 else operator.mass
    inverse = np.where(part.border, 0.0, float(mass.mean()) / mass)
    columns = sparse.csr_matrix(operator.dirichlet[:, part.free])
    return _System(operator.dirichlet, columns, sparse.csr_matrix(columns[part.free]), inverse, order, part.points, part.free)


def _rim_as_dense(operator: SurfaceOperator, free: Bools) -> Floats:
    """Limits the mass of each fixed vertex next to free vertices to the mean mass of its free neighbours; returns all masses."""
    beside = sparse.csr_matrix(operator.dirichlet != 0.0)[:, free].astype(np.float64)
    count = np.asarray(beside.sum(axis=1)).ravel()
    rim = ~free & (count > 0.0)
    mass = operator.mass.copy()
    mass[rim] = np.minimum(mass[rim], (beside @ mass[free])[rim] / count[rim])
    return mass


def _check_held(system: _System, part: Submesh) -> None:
    """Refuses a connected part of the free vertices if the fixed vertices around it do not span a triangle.

    A part that lies in one line with these fixed vertices, as in a slit, is accepted: it cannot shrink any more.
    """
    dirichlet, points, places = system.dirichlet, part.points, np.flatnonzero(part.free)
    count, labels = sparse.csgraph.connected_components(system.inner, directed=False)
    # Finds the fixed vertices in the `order` rings around each part.
    around = sparse.csr_matrix((np.ones(len(places)), (labels, places)), shape=(count, len(points)))
    outwards = dirichlet.copy()
    outwards.data = ((dirichlet.data != 0.0) & ~part.free[dirichlet.indices]).astype(np.float64)
    outwards.eliminate_zeros()
    around = sparse.csr_matrix(around @ outwards)
    for _ in range(system.order - 1):
        around = sparse.csr_matrix(around + around @ outwards)
        around.data[:] = 1.0
    around.sort_indices()
    for label, (start, end) in enumerate(pairwise(around.indptr)):
        holding = around.indices[start:end]
        if len(holding) >= 3 and not _in_line(points[holding]):
            continue
        held = places[labels == label]
        if len(holding) >= 3 and _in_line(points[np.concatenate([holding, held])]):
            continue
        group = f"the {len(held)} free vertices connected with vertex {part.vertices[held[0]]}"
        if len(holding) == 0:
            raise FilterInputError(
                f"{group} touch no fixed vertex, so that their place is undetermined: select less than a whole component"
            )
        kind = ("fixed vertex alone", "fixed vertices alone", "fixed vertices in one line")[min(len(holding), 3) - 1]
        raise FilterInputError(
            f"{group} are held by {len(holding)} {kind}, such as {part.vertices[holding[0]]}, and would shrink to nothing: "
            "around each part at least three vertices, not in one line, must stay; select less"
        )


def _in_line(points: Floats) -> bool:
    """Whether all points lie, up to rounding errors, on the line through the first point and the point farthest from it."""
    offsets = points - points[0]
    lengths = np.linalg.norm(offsets, axis=1)
    far = int(lengths.argmax())
    if lengths[far] == 0.0:
        return True
    return bool((np.linalg.norm(np.cross(offsets, offsets[far] / lengths[far]), axis=1) <= 1e-12 * lengths[far]).all())


class SurfaceOperator(NamedTuple):
    """The operator L = -M^-1 S on n vertices."""

    # S = -C with C the stiffness, (n, n) symmetric, positive semidefinite, with rows that sum to 0
    dirichlet: sparse.csr_matrix
    mass: Floats  # the diagonal of M, (n,), above 0


def surface_operator(points: Floats, faces: Ints) -> SurfaceOperator:
    """`surface_laplacian` with a lower bound on the masses."""
    laplacian = surface_laplacian(points, faces)
    np.negative(laplacian.stiffness.data, out=laplacian.stiffness.data)
    return SurfaceOperator(laplacian.stiffness, _floored(laplacian.mass, faces))


def evened_operator(operator: SurfaceOperator, faces: Ints, irregular: Bools) -> tuple[SurfaceOperator, Bools]:
    """Makes the weights and masses of an operator uniform in the connected components of irregular vertices.

    Where weights and masses differ by orders of magnitude, the energy may be least with a vertex far away from the others, a
    spike. In the component of a spike every edge gets the weight cot(60 degrees) and every vertex the same mass, as if all
    triangles were equilateral.

    `irregular` is (n,) which vertices became spikes. Returns the new operator, and (n,) which vertices are in their components.
    """
    n = len(operator.mass)
    a, b, c = faces[proper_faces(faces)].T
    ends = np.concatenate([a, b, c]), np.concatenate([b, c, a])
    edges = sparse.coo_matrix((np.ones(len(ends[0])), ends), shape=(n, n)).tocsr()
    edges = sparse.csr_matrix(edges + edges.T)
    edges.data[:] = 1.0 / math.sqrt(3.0)
    count, labels = sparse.csgraph.connected_components(edges, directed=False)
    inside = mask_of(labels[irregular], count)[labels]
    even = sparse.diags_array(np.asarray(edges.sum(axis=1)).ravel()) - edges
    share = sparse.diags_array(inside.astype(np.float64))
    kept = sparse.diags_array((~inside).astype(np.float64))
    means = np.bincount(labels, operator.mass, count) / np.maximum(np.bincount(labels, minlength=count), 1)
    mass = np.where(inside, means[labels], operator.mass)
    return SurfaceOperator(sparse.csr_matrix(share @ even + kept @ operator.dirichlet), mass), inside


def _floored(mass: Floats, faces: Ints) -> Floats:
    mean = float(mass.mean()) if len(mass) else 0.0
    if not mean > 0.0:
        return np.ones(len(mass))
    around = _largest_around(mass, faces)
    # Where the whole one-ring has no mass, as at triangles without area, the mean mass serves as the largest mass.
    around[around <= _NO_MASS * mean] = mean
    return np.asarray(np.maximum(mass, _LEAST_MASS * around))


@compiled
def _areas(before: Floats, after: Floats, free: Bools, faces: Ints) -> tuple[float, float]:
    """Returns the areas of the triangles with a free vertex, before and after."""
    sums = np.zeros(2)
    for a, b, c in faces:
        if free[a] or free[b] or free[c]:
            for k, points in enumerate((before, after)):
                x, y, z = cross_product(points, a, b, c)
                sums[k] += 0.5 * math.sqrt(x * x + y * y + z * z)
    return sums[0], sums[1]


@compiled
def _largest_around(mass: Floats, faces: Ints) -> Floats:
    """Returns the largest mass among each vertex and its neighbours."""
    largest = mass.copy()
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        most = max(mass[a], mass[b], mass[c])
        largest[a], largest[b], largest[c] = max(largest[a], most), max(largest[b], most), max(largest[c], most)
    return largest
