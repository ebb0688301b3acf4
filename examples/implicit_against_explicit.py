"""The same diffusion time in one implicit and in many explicit steps: ``python examples/implicit_against_explicit.py OUT.png``.

The longest explicit step that is stable follows from the smallest triangle; an implicit step may be of any length [desbrun1999].
"""

import time
from pathlib import Path

import numpy as np
import pymeshlab
from panels import Panel, draw_panels, named_output, save_picture

from pymeshfair.filters.checks import UnstableStepError
from pymeshfair.filters.diffusion import explicit_smoothing, implicit_fairing
from pymeshfair.filters.geometry import mean_edge_length

output = named_output()
meshes = pymeshlab.MeshSet()
meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny.obj"))
bunny, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
edge = mean_edge_length(bunny, faces)
noisy = bunny + np.random.default_rng(0).normal(scale=0.2 * edge, size=bunny.shape)
duration = (2.0 * edge) ** 2
try:
    explicit_smoothing(noisy, faces, operator="robust", step=duration, iterations=1)
except UnstableStepError as error:
    print(error)
    steps = int(np.ceil(duration / error.largest_stable))
panels = [Panel("noise of 0.2 edges", noisy, faces)]
for title, smooth, parameters in (
    (f"{steps:,} explicit steps", explicit_smoothing, {"step": duration / steps, "iterations": steps}),
    ("1 implicit step", implicit_fairing, {"time_step": duration}),
):
    smooth(noisy, faces, operator="robust", **parameters | {"iterations": 1})  # compiles
    began = time.perf_counter()
    panels.append(Panel(title, smooth(noisy, faces, operator="robust", **parameters), faces))
    print(f"{title}: {time.perf_counter() - began:.2f} s")
save_picture(output, draw_panels(panels))
