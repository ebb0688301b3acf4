"""MeshLab's filters that give another result each time they run, and no parameter for the seed.

Found by running each three times in fresh processes and twice within one, on a small scan, with pymeshlab 2025.7.
"""

from __future__ import annotations

UNREPEATABLE = frozenset(
    (
        "apply_coord_random_displacement",
        "generate_marching_cubes_apss",
        "generate_sampling_montecarlo",
        "generate_sampling_poisson_disk",
        "generate_sampling_voronoi",
        "generate_simplified_point_cloud",
        "generate_voronoi_filtering",
        "meshing_decimation_clustering",
    )
)
