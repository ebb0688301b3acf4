"""The denoisers that are compared: ours, MeshLab's, trimesh's, VTK's and Open3D's, each with the settings to try when tuned.

A denoiser takes vertices and faces and gives new vertices; all vertices are used by some face.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import pymeshlab
from denoising_metrics import Floats, Ints
from peers.explicit import vtk_arrays, vtk_mesh

from pymeshfair.filters.denoising import bilateral_fleishman, bilateral_jones, denoise_automatically, normal_filtering
from pymeshfair.filters.diffusion import taubin_fairing

Settings: TypeAlias = dict[str, Any]


@dataclass(frozen=True)
class Method:
    """One denoiser.

    Attributes:
        name: what the table calls it, and `--methods` takes.
        run: vertices and faces, and the settings as keywords, to new vertices.
        settings: what it is run with when it is not tuned.
        trials: what is tried per mesh when it is tuned, beside `settings`; empty if it has nothing to tune.
        tuned_always: a baseline that is only fair when tuned: its trials run in any case.
        only_tuned: left out unless tuning is asked for.
    """

    name: str
    run: Callable[..., Floats]
    settings: Settings
    trials: tuple[Settings, ...] = ()
    tuned_always: bool = False
    only_tuned: bool = False


def combinations(fixed: Settings | None = None, /, **values: tuple[Any, ...]) -> tuple[Settings, ...]:
    """The fixed settings with every combination of the values."""
    return tuple((fixed or {}) | dict(zip(values, chosen, strict=True)) for chosen in itertools.product(*values.values()))


#: the widths of the kernels that were found to suit sharp shapes
SHARP: Settings = {
    "method": "bilateral",
    "range_kernel": "truncated_l1",
    "neighborhood": "two_ring",
    "range_sigma": 1.0,
    "range_floor": 0.0,
    "space_sigma": 2.5,
    "outer_iterations": 20,
    "normal_iterations": 1,
    "vertex_iterations": 10,
}
#: the settings of two papers
ZHENG: Settings = {"range_sigma": 0.35, "normal_iterations": 20, "vertex_iterations": 10}
GUIDED: Settings = ZHENG | {"method": "guided", "neighborhood": "two_ring"}
#: What has won on some mesh, and its nearest relatives, from sharp to smooth: method, kernel, neighbourhood, range sigmas, space
#: sigmas, schedules of outer and vertex iterations, and range floors.
FAMILIES: tuple[tuple[Any, ...], ...] = (
    # Sharp edges; the more noise, the more rounds. Deviations are measured on averaged normals where the noise is impulsive or
    # turns faces over.
    ("bilateral", "truncated_l1", "two_ring", (1.0,), (2.5,), ((20, 10), (30, 5), (60, 3)), (0.03, 0.06)),
    ("averaged", "truncated_l1", "two_ring", (0.25, 0.36), (2.5,), ((20, 10), (30, 10)), (0.03,)),
    ("averaged", "truncated_l2", "two_ring", (0.15, 0.25), (2.5,), ((20, 10), (40, 10)), (0.0,)),
    # The steps of depth cameras, which only wide kernels and many rounds smooth away.
    ("averaged", "gaussian", "two_ring", (0.25, 0.4), (2.5,), ((40, 20),), (0.0,)),
    # Smooth with a few edges.
    ("bilateral", "lorentzian", "vertex", (0.12, 0.25), (1.5,), ((10, 4), (20, 2)), (0.0,)),
    # Smooth and detailed; the finer the details, the smaller the neighbourhood and the fewer the steps of the vertices.
    ("averaged", "huber", "two_ring", (0.05,), (1.0, 2.0), ((5, 5), (7, 4)), (0.0, 0.1)),
    ("averaged", "huber", "vertex", (0.05,), (1.0,), ((7, 4), (10, 3)), (0.0,)),
    ("bilateral", "huber", "vertex", (0.1, 0.2), (1.5,), ((5, 5), (10, 3)), (0.0,)),
    ("bilateral", "huber", "edge", (0.2, 0.6), (2.5,), ((10, 4), (16, 2)), (0.0,)),
)
OUR_TRIALS = tuple(
    SHARP
    | {"method": method, "range_kernel": kernel, "neighborhood": neighborhood, "range_sigma": sigma, "range_floor": floor}
    | {"space_sigma": width, "outer_iterations": outer, "vertex_iterations": fit}
    for method, kernel, neighborhood, sigmas, widths, schedules, floors in FAMILIES
    for sigma, floor, width, (outer, fit) in itertools.product(sigmas, floors, widths, schedules)
)
TAUBIN_STEPS = (2, 3, 5, 7, 10, 15, 20, 30, 40, 60, 80, 120)


def meshlab(vertices: Floats, faces: Ints, **filters: Settings) -> Floats:
    """MeshLab's own filters one after the other."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    for name, values in filters.items():
        meshes.apply_filter(name, **values)
    return np.asarray(meshes.current_mesh().vertex_matrix())


def meshlab_taubin(steps: int) -> Settings:
    """MeshLab's Taubin filter: pairs of a step of 0.5 and one of -0.53."""
    return {"apply_coord_taubin_smoothing": {"lambda_": 0.5, "mu": -0.53, "stepsmoothnum": steps}}


def meshlab_two_step(outer: int, normal: int, fit: int, angle: float) -> Settings:
    """MeshLab's two-step filter."""
    values = {"stepsmoothnum": outer, "stepnormalnum": normal, "stepfitnum": fit, "normalthr": angle}
    return {"apply_coord_two_steps_smoothing": values}


def trimesh_filter(vertices: Floats, faces: Ints, *, name: str, **settings: Any) -> Floats:
    """One of trimesh.smoothing's filters."""
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    getattr(trimesh.smoothing, name)(mesh, **settings)
    return np.asarray(mesh.vertices)


def vtk_windowed_sinc(vertices: Floats, faces: Ints, *, iterations: int, pass_band: float) -> Floats:
    """VTK's windowed sinc filter."""
    import vtk

    smoother = vtk.vtkWindowedSincPolyDataFilter()
    smoother.SetInputData(vtk_mesh(vertices, faces))
    smoother.SetNumberOfIterations(iterations)
    smoother.SetPassBand(pass_band)
    smoother.FeatureEdgeSmoothingOff()
    smoother.NonManifoldSmoothingOn()
    smoother.NormalizeCoordinatesOn()
    smoother.Update()
    return np.array(vtk_arrays().vtk_to_numpy(smoother.GetOutput().GetPoints().GetData()), dtype=np.float64)


def open3d_taubin(vertices: Floats, faces: Ints, *, iterations: int) -> Floats:
    """Open3D's Taubin filter."""
    import open3d

    mesh = open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(faces))
    return np.asarray(mesh.filter_smooth_taubin(number_of_iterations=iterations).vertices)


METHODS = (
    Method("ours, auto", lambda vertices, faces: denoise_automatically(vertices, faces)[0], {}),
    Method("ours, sharp", normal_filtering, SHARP),
    Method("ours, searched", normal_filtering, SHARP, OUR_TRIALS, only_tuned=True),
    Method(
        "ours, Zheng 2011",
        normal_filtering,
        ZHENG,
        combinations(ZHENG, range_sigma=(0.25, 0.35, 0.45), normal_iterations=(10, 20, 40)),
    ),
    Method("ours, Zhang 2015", normal_filtering, GUIDED, (GUIDED | {"range_sigma": 0.25}, GUIDED | {"normal_iterations": 40})),
    Method("ours, Fleishman 2003", bilateral_fleishman, {}),
    Method("ours, Jones 2003", bilateral_jones, {}),
    Method("ours, Taubin", taubin_fairing, {}, combinations(iterations=TAUBIN_STEPS)),
    Method("MeshLab Taubin", meshlab, meshlab_taubin(10)),
    Method("MeshLab Taubin, tuned", meshlab, meshlab_taubin(10), tuple(map(meshlab_taubin, TAUBIN_STEPS)), tuned_always=True),
    Method("MeshLab two-step", meshlab, meshlab_two_step(3, 20, 20, 60.0)),
    Method("MeshLab, our recipe", meshlab, meshlab_taubin(3) | meshlab_two_step(35, 1, 1, 45.0)),
    # trimesh counts both halves of a step.
    Method(
        "trimesh Taubin",
        trimesh_filter,
        {"name": "filter_taubin"},
        combinations({"name": "filter_taubin"}, iterations=tuple(2 * steps for steps in TAUBIN_STEPS)),
    ),
    Method(
        "trimesh Humphrey",
        trimesh_filter,
        {"name": "filter_humphrey"},
        combinations({"name": "filter_humphrey"}, iterations=TAUBIN_STEPS[:9], beta=(0.3, 0.5)),
    ),
    Method(
        "VTK windowed sinc",
        vtk_windowed_sinc,
        {"iterations": 20, "pass_band": 0.1},
        combinations(iterations=(10, 20, 40), pass_band=(0.1, 0.05, 0.02, 0.01)),
    ),
    Method("Open3D Taubin", open3d_taubin, {"iterations": 10}, combinations(iterations=TAUBIN_STEPS)),
)
