"""Contests on point clouds: nearest neighbours and outliers."""

from __future__ import annotations

from typing import Any

import neighbours
import numpy as np
import pymeshlab

from pymeshfair.filters.outliers import local_outlier_probability

from .contest import Contest, Floats, Peer, Subject, Work

NEIGHBOURS = 32


def meshlab_outliers(subject: Subject) -> Work:
    """MeshLab's LoOP filter, which counts the point itself as a neighbour."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(subject.vertices))

    def work() -> Any:
        meshes.compute_selection_point_cloud_outliers(knearest=NEIGHBOURS + 1)
        return meshes

    return work


def pynomaly(subject: Subject) -> Work:
    """PyNomaly's."""
    from PyNomaly import loop

    def work() -> Any:
        found = loop.LocalOutlierProbability(subject.vertices, extent=3, n_neighbors=NEIGHBOURS, progress_bar=False).fit()
        return np.asarray(found.local_outlier_probabilities, dtype=np.float64)

    return work


def open3d_outliers(subject: Subject) -> Work:
    """Open3D's statistical outliers: not probabilities, the same neighbours."""
    import open3d

    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(subject.vertices))
    return lambda: cloud.remove_statistical_outlier(nb_neighbors=NEIGHBOURS, std_ratio=3.0)


def distances(points: Floats, found: Any) -> Floats:
    """The distance to each neighbour: ties may be in any order."""
    return np.asarray(np.linalg.norm(points[found] - points[:, None], axis=2))


def found_by(way: Any) -> Any:
    """A way of benchmarks/neighbours.py, as points and the neighbours of each."""
    return lambda s: lambda: (s.vertices, way(s.vertices, NEIGHBOURS))


CONTESTS = (
    Contest(
        f"LoOP, {NEIGHBOURS} neighbours",
        lambda s: lambda: local_outlier_probability(s.vertices, neighbors=NEIGHBOURS),
        "The search for neighbours: comparing distances within leaves of the tree, two thirds of a call; building the tree on "
        "one thread takes a tenth.",
        {
            "pymeshlab": Peer(meshlab_outliers, "pymeshlab", goal=4.2),
            "PyNomaly": Peer(pynomaly, "PyNomaly", largest=1.5e4, agrees=1e-6, goal=249.0),
            "Open3D": Peer(open3d_outliers, "open3d", largest=2e5, goal=1.2),
        },
        subject="points",
    ),
    Contest(
        f"{NEIGHBOURS} nearest neighbours",
        found_by(neighbours.by_us),
        "As LoOP.",
        {
            "scipy": Peer(found_by(neighbours.by_scipy), "scipy", agrees=1e-12),
            "pykdtree": Peer(found_by(neighbours.by_pykdtree), "pykdtree", agrees=1e-12, goal=1.3),
        },
        subject="points",
        orders=("scan",),
        result=lambda found: distances(*found),
    ),
)
