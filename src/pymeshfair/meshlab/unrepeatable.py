"""MeshLab's filters that give another result each time they run, and have no parameter for the seed; how far results are apart.

Found by running each in fresh processes and within one, with pymeshlab 2025.7, on the bone, the airplane and a noisy sphere: two
results had as many vertices and faces, and were apart by less than the distances here.
"""

from collections.abc import Mapping
from types import MappingProxyType

#: filters that leave something in the process, such as the state of a generator of random numbers, by which the next run of the
#: same filter gives another result than in a fresh process; measured as above
LEAVES_STATE = frozenset(
    {
        "apply_coord_cubic_stylization",
        "apply_coord_random_displacement",
        "compute_iso_parametrization",
        "generate_dust_accumulation_point_cloud",
        "generate_sampling_montecarlo",
        "generate_sampling_poisson_disk",
        "generate_sampling_voronoi",
        "generate_simplified_point_cloud",
        "generate_voronoi_atlas_parametrization",
        "meshing_decimation_clustering",
    }
)
#: the same elements in another order: of the diagonal, what rounding leaves
_REORDERED = 1e-6

#: by Python name, how far a vertex or the middle of a face may be from the nearest one of another result, of the diagonal
UNREPEATABLE: Mapping[str, float] = MappingProxyType(
    {
        "apply_coord_random_displacement": 5e-3,  # twice its parameter, so that small amounts alone can be compared
        "generate_marching_cubes_apss": 1e-3,  # measured: 3.5e-4
        "generate_sampling_montecarlo": _REORDERED,
        "generate_sampling_poisson_disk": _REORDERED,
        "generate_sampling_voronoi": _REORDERED,
        "generate_simplified_point_cloud": _REORDERED,
        "generate_voronoi_filtering": _REORDERED,
        "meshing_decimation_clustering": _REORDERED,
    }
)
