"""Measures traits of a scan, a few numbers on which the recommendation of recipes is based."""

from collections.abc import Collection
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from .checks import check_choice
from .denoising import Scan, filter_face_normals, shared_noise
from .diffusion import taubin_fairing
from .geometry import angles_between, edge_lengths, seen_from_one_side
from .mesh import check_mesh, normalised_mesh
from .topology import edges, face_adjacency

#: "noise": `shared_noise`, or if it is 0 `Scan.surface_noise`, in mean edges. "sharpness": see `sharpness`.
#: "facing": `seen_from_one_side`, 1/2 for half a sphere and at least 0.4 for a range map. "camera noise": 1 if `shared_noise`
#: is above 0, else 0. "longest edge": in mean edges.
Trait: TypeAlias = Literal["noise", "sharpness", "facing", "camera noise", "longest edge"]


def measured_traits(
    vertices: ArrayLike, faces: ArrayLike, wanted: Collection[str] = get_args(Trait), *, mean_edge: float | None = None
) -> dict[str, float]:
    """Measures traits in a fraction of a second; a large mesh is sampled by patches.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        wanted: names of the traits to measure.
        mean_edge: mean edge length of the mesh; None measures it, which takes longer.

    Returns:
        The traits by name. Moving, turning or scaling the mesh does not change them.

    Raises:
        FilterInputError: not a mesh, or an unknown trait.
    """
    names = set(wanted)
    for name in sorted(names):
        check_choice("wanted", name, Trait)
    points, triangles = check_mesh(vertices, faces)
    mesh = normalised_mesh(points, triangles)
    traits: dict[str, float] = {}
    if "facing" in names:
        traits["facing"] = seen_from_one_side(mesh.points, mesh.cells)
    if "longest edge" in names:
        lengths = edge_lengths(points, edges(triangles))
        traits["longest edge"] = float(1.0 / (lengths / lengths.max()).mean()) if len(lengths) and lengths.max() > 0.0 else 1.0
    if not names & {"noise", "sharpness", "camera noise"}:
        return traits
    scan, _ = Scan.sampled(mesh.points, mesh.cells, edge=None if mean_edge is None else mean_edge * mesh.scale)
    shared = shared_noise(scan.points, scan.faces, scan.noise)
    noise = shared or scan.surface_noise
    sharp = sharpness(scan, noise) if "sharpness" in names else 0.0
    measured = {"camera noise": float(shared > 0.0), "noise": noise, "sharpness": sharp}
    return traits | {name: value for name, value in measured.items() if name in names}


def sharpness(scan: Scan, noise: float) -> float:
    """Returns the share of sharp edges, with t >= 30 degrees, in the sum of t l over all edges, after noise is removed.

    t is the angle between the normals of the two faces of an edge, l its length. Each normal is averaged with the normals in its
    two rings that differ by less than 41 degrees. Taubin steps first remove the noise, which is given in mean edges: five pairs
    of steps for 0.1 and above, fewer for less noise, since more steps would round the edges of a dodecahedron.

    Returns:
        1 for a cube, 0 for a finely meshed sphere or a plane, up to pi r / (pi r + h) for a finely meshed cylinder. Machine parts
        have 0.7 to 0.95 with noise of up to 0.5 edges; figures, bodies and terrain have up to 0.66.
    """
    pairs, shared = face_adjacency(scan.faces)
    steps, points = round(5 * min(1.0, noise / 0.1)), scan.points
    if steps:
        points = taubin_fairing(points, scan.faces, iterations=steps, border="along")
    normals = filter_face_normals(
        points, scan.faces, range_kernel="tukey", range_sigma=0.7, space_sigma=2.0, neighborhood="two_ring", normal_iterations=6
    )
    angles = angles_between(*normals[pairs.T])
    bending = angles * edge_lengths(scan.points, shared)
    total = float(bending.sum())
    # On planes the total consists only of rounding errors of the coordinates.
    return float(bending[angles >= np.radians(30.0)].sum()) / total if total > 1e-6 * len(bending) else 0.0


__all__ = ["Trait", "measured_traits", "sharpness"]
