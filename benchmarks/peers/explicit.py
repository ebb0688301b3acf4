"""Contests of explicit smoothing: Taubin's, Laplacian steps, a sweep alone, and a filter from mesh to mesh."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import NDArray

from pymeshfair.filters.diffusion import explicit_smoothing, taubin_fairing
from pymeshfair.filters.diffusion.explicit import explicit_surface
from pymeshfair.filters.execution import threads_for
from pymeshfair.meshset import MeshSet

from .contest import Contest, Floats, Peer, Preparation, Subject, Work

#: Bytes of a sweep over the one-rings, a vertex: 24 read, 24 written, 12 of its places in lists, 4 of each of six neighbours.
SWEEP = 24 + 24 + 12 + 6 * 4
#: Bytes of a mesh, a vertex: 24 read and 24 written, and 12 of each of two triangles.
MESH = 48 + 24


def meshlab(name: str, **parameters: Any) -> Preparation:
    """A filter of MeshLab on a mesh that it has loaded."""

    def prepare(subject: Subject) -> Work:
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(subject.vertices, subject.faces))

        def work() -> Any:
            meshes.apply_filter(name, **parameters)
            return meshes

        return work

    return prepare


def from_mesh_to_mesh(subject: Subject) -> Work:
    """Our filter as a method of a MeshSet, its result written back into MeshLab's mesh."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(subject.vertices, subject.faces))

    def work() -> Any:
        meshes.apply_coord_taubin_fairing()
        meshes.current_mesh()
        return meshes

    return work


def vtk_arrays() -> Any:
    """VTK's module of numpy's arrays."""
    return importlib.import_module("vtkmodules.util.numpy_support")


def vtk_mesh(vertices: Floats, faces: NDArray[np.int32]) -> Any:
    """A mesh of VTK's, in double precision."""
    import vtk

    points, cells, data = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    points.SetData(vtk_arrays().numpy_to_vtk(vertices, deep=1))
    cells.SetData(3, vtk_arrays().numpy_to_vtkIdTypeArray(np.ascontiguousarray(faces, dtype=np.int64).ravel(), deep=1))
    data.SetPoints(points)
    data.SetPolys(cells)
    return data


def vtk_sinc(backend: str) -> Preparation:
    """VTK's windowed sinc filter of 20 iterations, which is its Taubin smoothing."""

    def prepare(subject: Subject) -> Work:
        import vtk

        vtk.vtkSMPTools.SetBackend(backend)
        smooth = vtk.vtkWindowedSincPolyDataFilter()
        smooth.SetInputData(vtk_mesh(subject.vertices, subject.faces))
        smooth.SetNumberOfIterations(20)
        smooth.BoundarySmoothingOn()
        smooth.FeatureEdgeSmoothingOff()

        def work() -> Any:
            smooth.Update()
            return vtk_arrays().vtk_to_numpy(smooth.GetOutput().GetPoints().GetData())

        return work

    return prepare


def trimesh_taubin(subject: Subject) -> Work:
    """Trimesh's, by scipy's sparse products."""
    import trimesh

    mesh = trimesh.Trimesh(subject.vertices, subject.faces, process=False)
    smooth: Any = trimesh.smoothing.filter_taubin
    return lambda: smooth(mesh, lamb=0.5, nu=0.53, iterations=20).vertices


def open3d_mesh(method: str, **parameters: Any) -> Preparation:
    """A smoothing filter of Open3D."""

    def prepare(subject: Subject) -> Work:
        import open3d

        mesh = open3d.geometry.TriangleMesh(
            open3d.utility.Vector3dVector(subject.vertices), open3d.utility.Vector3iVector(subject.faces)
        )
        return lambda: np.asarray(getattr(mesh, method)(**parameters).vertices)

    return prepare


def meshlib_relax(subject: Subject) -> Work:
    """MeshLib's, in place, on all threads."""
    import meshlib.mrmeshnumpy as arrays
    import meshlib.mrmeshpy as meshlib

    mesh, settings = arrays.meshFromFacesVerts(subject.faces, subject.vertices), meshlib.MeshRelaxParams()
    settings.iterations, settings.force = 10, 0.5

    def work() -> Any:
        meshlib.relax(mesh, settings)
        return arrays.getNumpyVerts(mesh)

    return work


def sweeps(subject: Subject) -> Work:
    """Twenty sweeps of the uniform operator on a mesh that has been made ready, renumbered where that pays."""
    surface = explicit_surface(
        subject.vertices, subject.faces, operator="uniform", border="along", movable=None, iterations=10, whole=None, steps=2
    )
    now, free = surface.mesh.points.copy(), surface.mesh.points.copy()

    def work() -> Any:
        with threads_for(len(now)):
            for _ in range(10):
                surface.advance(now, free, 0.5)
                surface.advance(free, now, -0.53)
        return now

    return work


def vertices_of(result: Any) -> Floats:
    """The coordinates, whichever side they come from."""
    return np.asarray(result.current_mesh().vertex_matrix() if hasattr(result, "current_mesh") else result, dtype=np.float64)


CONTESTS = (
    Contest(
        "Taubin, 10 pairs of steps",
        lambda s: lambda: taubin_fairing(s.vertices, s.faces),
        "Instructions. At a million vertices the sweeps take 0.5 of the processor time; finding the triangles at every vertex "
        "and ordering them takes 0.25; sorting vertices and triangles by place takes 0.12, on one thread.",
        {
            "VTK": Peer(vtk_sinc("Sequential"), "vtk", goal=3.0),
            "VTK, threads": Peer(vtk_sinc("STDThread"), "vtk", goal=2.5),
            "pymeshlab": Peer(
                meshlab("apply_coord_taubin_smoothing", stepsmoothnum=10), "pymeshlab", agrees=1e-6, goal=8.0, largest=2e6
            ),
            "trimesh": Peer(trimesh_taubin, "trimesh", agrees=1e-6, largest=2e6),
            "Open3D": Peer(open3d_mesh("filter_smooth_taubin", number_of_iterations=10), "open3d", largest=2e5),
        },
        sizes=(10_000, 100_000, 1_000_000, 5_000_000),
        traffic=MESH + 20 * SWEEP,
        result=vertices_of,
    ),
    Contest(
        "Taubin, mesh to mesh",
        from_mesh_to_mesh,
        "Reading and writing MeshLab's mesh takes more than the filter.",
        {
            "pymeshlab": Peer(meshlab("apply_coord_taubin_smoothing", stepsmoothnum=10), "pymeshlab", agrees=1e-6, goal=4.0),
        },
        orders=("scan",),
        result=vertices_of,
    ),
    Contest(
        "20 sweeps of the uniform operator",
        sweeps,
        "Instructions: six neighbours a vertex are gathered one by one, three doubles each, two of which the compiler takes at a "
        "time.",
        sizes=(10_000, 100_000, 1_000_000, 5_000_000),
        traffic=20 * SWEEP,
    ),
    Contest(
        "Laplacian, uniform, 10 steps",
        lambda s: lambda: explicit_smoothing(s.vertices, s.faces),
        "As Taubin's, with half the sweeps. At 10k the triangles around the vertices take 0.36 of a call and ten sweeps 0.4, on "
        "one thread, as two would take 1.2 to 1.5 times as long. At 1M sorting by place takes a fifth of the time by the clock, "
        "ordering triangles a quarter. MeshLib has its half-edges before the clock starts, and takes twice our processor time at "
        "10k; six runs gave ratios of 0.98 to 1.3 there.",
        {
            "MeshLib": Peer(meshlib_relax, "meshlib", goal=1.3),
            "pymeshlab": Peer(
                meshlab("apply_coord_laplacian_smoothing", stepsmoothnum=10, cotangentweight=False),
                "pymeshlab",
                goal=7.0,
                largest=2e6,
            ),
            "Open3D": Peer(open3d_mesh("filter_smooth_simple", number_of_iterations=10), "open3d", largest=2e5),
        },
        sizes=(10_000, 100_000, 1_000_000, 5_000_000),
        traffic=MESH + 10 * SWEEP,
    ),
    Contest(
        "Laplacian, cotangent, 10 steps",
        lambda s: lambda: explicit_smoothing(s.vertices, s.faces, operator="cotangent"),
        "Memory: neighbours are gathered anew in every step, each with two cotangents (square roots and divisions). A step takes "
        "26 ns of processor time a vertex of 10,000, which the second cache holds, and 67 ns a vertex of 100,000.",
        {
            "pymeshlab": Peer(
                meshlab("apply_coord_laplacian_smoothing", stepsmoothnum=10, cotangentweight=True),
                "pymeshlab",
                goal=8.0,
                largest=2e6,
            ),
        },
        traffic=MESH + 10 * SWEEP,
    ),
)
