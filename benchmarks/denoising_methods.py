"""The denoisers that are compared: ours, MeshLab's, trimesh's, VTK's and Open3D's, each with the settings to try when tuned.

A denoiser takes vertices and faces and gives new vertices; all vertices are used by some face.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pymeshlab
from denoising_metrics import Floats, Ints
from denoising_trials import (
    GUIDED,
    GUIDED_TRIALS,
    OUR_TRIALS,
    SHARP,
    SMOOTH,
    TAUBIN_STEPS,
    ZHENG,
    ZHENG_TRIALS,
    Settings,
    combinations,
)

from pymeshfair.filters.denoising import bilateral_fleishman, bilateral_jones, denoise_automatically, normal_filtering
from pymeshfair.filters.diffusion import implicit_fairing, taubin_fairing, time_step_of_detail_size
from pymeshfair.filters.geometry import mean_edge_length

#: filters of pymeshlab by name, with their values
Steps = list[tuple[str, Settings]]


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
        needs: the module that has it.
    """

    name: str
    run: Callable[..., Floats]
    settings: Settings
    trials: tuple[Settings, ...] = ()
    tuned_always: bool = False
    only_tuned: bool = False
    needs: str = "pymeshfair"

    @property
    def is_there(self) -> bool:
        """Whether the module that it needs is installed."""
        try:
            return importlib.util.find_spec(self.needs) is not None
        except ModuleNotFoundError:
            return False


def implicit(vertices: Floats, faces: Ints, *, detail_size: float) -> Floats:
    """Implicit fairing; the detail size is in mean edges."""
    time = time_step_of_detail_size(detail_size * mean_edge_length(vertices, faces), iterations=1)
    return implicit_fairing(vertices, faces, operator="cotangent", time_step=time)


def meshlab(vertices: Floats, faces: Ints, *, steps: Steps) -> Floats:
    """MeshLab's own filters one after the other."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    for name, values in steps:
        meshes.apply_filter(name, **values)
    return np.asarray(meshes.current_mesh().vertex_matrix())


def meshlab_taubin(steps: int, strength: float = 0.5) -> Settings:
    """MeshLab's Taubin filter: pairs of a step of `strength` and one of -1.06 times that."""
    values = {"lambda_": strength, "mu": -1.06 * strength, "stepsmoothnum": steps}
    return {"steps": [("apply_coord_taubin_smoothing", values)]}


def meshlab_two_step(outer: int = 3, normal: int = 20, fit: int = 20, angle: float = 60.0, taubin_before: int = 0) -> Settings:
    """MeshLab's two-step filter, after some Taubin steps."""
    values = {"stepsmoothnum": outer, "stepnormalnum": normal, "stepfitnum": fit, "normalthr": angle}
    before: Steps = meshlab_taubin(taubin_before)["steps"] if taubin_before else []
    return {"steps": [*before, ("apply_coord_two_steps_smoothing", values)]}


def trimesh_filter(vertices: Floats, faces: Ints, *, name: str, **settings: Any) -> Floats:
    """One of trimesh.smoothing's filters."""
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    getattr(trimesh.smoothing, name)(mesh, **settings)
    return np.asarray(mesh.vertices)


def vtk_windowed_sinc(vertices: Floats, faces: Ints, *, iterations: int, pass_band: float) -> Floats:
    """VTK's windowed sinc filter."""
    import vtk

    convert: Any = importlib.import_module("vtkmodules.util.numpy_support")
    points, triangles, mesh = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
    points.SetDataTypeToDouble()
    points.SetData(convert.numpy_to_vtk(vertices, deep=True))
    counted = np.column_stack([np.full(len(faces), 3), faces]).astype(np.int64).ravel()
    triangles.SetCells(len(faces), convert.numpy_to_vtkIdTypeArray(counted, deep=True))
    mesh.SetPoints(points)
    mesh.SetPolys(triangles)
    smoother = vtk.vtkWindowedSincPolyDataFilter()
    smoother.SetInputData(mesh)
    smoother.SetNumberOfIterations(iterations)
    smoother.SetPassBand(pass_band)
    smoother.FeatureEdgeSmoothingOff()
    smoother.NonManifoldSmoothingOn()
    smoother.NormalizeCoordinatesOn()
    smoother.Update()
    return np.array(convert.vtk_to_numpy(smoother.GetOutput().GetPoints().GetData()), dtype=np.float64)


def open3d_taubin(vertices: Floats, faces: Ints, *, iterations: int) -> Floats:
    """Open3D's Taubin filter."""
    open3d: Any = importlib.import_module("open3d")
    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(faces.astype(np.int32))
    )
    return np.asarray(mesh.filter_smooth_taubin(number_of_iterations=iterations).vertices)


METHODS = (
    Method("ours, auto", lambda vertices, faces: denoise_automatically(vertices, faces)[0], {}),
    Method("ours, sharp", normal_filtering, SHARP),
    Method("ours, smooth", normal_filtering, SMOOTH),
    Method("ours, searched", normal_filtering, SHARP, OUR_TRIALS, only_tuned=True),
    Method("ours, Zheng 2011", normal_filtering, ZHENG, ZHENG_TRIALS),
    Method("ours, Zhang 2015", normal_filtering, GUIDED, GUIDED_TRIALS),
    Method("ours, Fleishman 2003", bilateral_fleishman, {}),
    Method("ours, Jones 2003", bilateral_jones, {}),
    Method("ours, Taubin", taubin_fairing, {}, combinations(iterations=TAUBIN_STEPS)),
    Method("ours, implicit", implicit, {"detail_size": 6.0}, combinations(detail_size=(3.0, 4.0, 6.0, 8.0, 10.0, 14.0))),
    Method("MeshLab Taubin", meshlab, meshlab_taubin(10)),
    Method("MeshLab Taubin, tuned", meshlab, meshlab_taubin(10), tuple(map(meshlab_taubin, TAUBIN_STEPS)), tuned_always=True),
    Method("MeshLab two-step", meshlab, meshlab_two_step()),
    Method("MeshLab two-step, interleaved", meshlab, meshlab_two_step(50, 1, 1)),
    Method("MeshLab Taubin, then interleaved", meshlab, meshlab_two_step(50, 1, 1, taubin_before=5)),
    Method("MeshLab, our recipe", meshlab, meshlab_two_step(35, 1, 1, angle=45.0, taubin_before=3)),
    Method(
        "trimesh Taubin",
        trimesh_filter,
        {"name": "filter_taubin"},
        # trimesh counts both halves of a step.
        combinations(name=("filter_taubin",), iterations=tuple(2 * steps for steps in TAUBIN_STEPS)),
        needs="trimesh",
    ),
    Method(
        "trimesh Humphrey",
        trimesh_filter,
        {"name": "filter_humphrey"},
        combinations(name=("filter_humphrey",), iterations=TAUBIN_STEPS[:9], beta=(0.3, 0.5)),
        needs="trimesh",
    ),
    Method(
        "VTK windowed sinc",
        vtk_windowed_sinc,
        {"iterations": 20, "pass_band": 0.1},
        combinations(iterations=(10, 20, 40), pass_band=(0.1, 0.05, 0.02, 0.01)),
        needs="vtk",
    ),
    Method("Open3D Taubin", open3d_taubin, {"iterations": 10}, combinations(iterations=TAUBIN_STEPS), needs="open3d"),
)
