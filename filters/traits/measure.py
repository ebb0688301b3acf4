"""The traits of a scan, those that are asked for, from one sample of it."""

from collections.abc import Collection
from typing import Literal, TypeAlias, get_args

from numpy.typing import ArrayLike

from ..checks import check_choice
from ..denoising.correlated_noise import neighbours_share_noise
from ..denoising.noise_level import estimate_noise
from ..evidence import sample_of
from ..geometry import edge_lengths
from ..mesh import check_mesh, normalised_mesh
from ..topology import edges
from .facing import facing
from .sharpness import sharpness
from .surface_noise import surface_noise

#: "noise": of `surface_noise`, in mean edges. "sharpness" and "facing": of the functions. "camera noise": 1 if neighbours share
#: their noise, as those of a depth camera's map do, else 0. "longest edge": in mean edges.
Trait: TypeAlias = Literal["noise", "sharpness", "facing", "camera noise", "longest edge"]
TRAITS: tuple[Trait, ...] = get_args(Trait)


def measured_traits(
    vertices: ArrayLike, faces: ArrayLike, wanted: Collection[str] = TRAITS, *, mean_edge: float | None = None
) -> dict[str, float]:
    """Measure what is asked for, on patches of a large mesh, so that it takes a fraction of a second on any.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        wanted: which traits.
        mean_edge: of the mesh, if it is known; that saves time.

    Returns:
        The traits by name. They are the same for the mesh moved, turned or scaled.

    Raises:
        FilterInputError: not a mesh, or an unknown trait.
    """
    names = set(wanted)
    for name in sorted(names):
        check_choice("wanted", name, TRAITS)
    points, triangles = check_mesh(vertices, faces)
    found: dict[str, float] = {}
    if "facing" in names:
        found["facing"] = facing(points, triangles)
    if "longest edge" in names:
        lengths = edge_lengths(points, edges(triangles))
        found["longest edge"] = float(1.0 / (lengths / lengths.max()).mean()) if len(lengths) and lengths.max() > 0.0 else 1.0
    if not names & {"noise", "sharpness", "camera noise"}:
        return found
    mesh = normalised_mesh(points, triangles)
    sample = sample_of(mesh.points, mesh.cells, None if mean_edge is None else mean_edge * mesh.scale)
    if "camera noise" in names:
        shares = neighbours_share_noise(sample.points, sample.faces, estimate_noise(sample.points, sample.faces))
        found["camera noise"] = float(shares)
    if "noise" in names or "sharpness" in names:
        noise = surface_noise(sample)
        found |= {"noise": noise} if "noise" in names else {}
        found |= {"sharpness": sharpness(sample, noise)} if "sharpness" in names else {}
    return found
