"""A noisy bunny after 100 steps of either kind: ``python examples/taubin_against_laplacian.py OUT.png``.

Laplacian steps take the noise and then the ears; Taubin's, a step forth and a longer one back, take the noise alone [taubin1995].
"""

from pathlib import Path

import numpy as np
import pymeshlab
from panels import Panel, draw_panels, named_output, save_picture

from pymeshfair.filters.diffusion import explicit_smoothing, taubin_fairing
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.inspection import surface_measures

output = named_output()
meshes = pymeshlab.MeshSet()
meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny.obj"))
bunny, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
noisy = bunny + np.random.default_rng(0).normal(scale=0.2 * mean_edge_length(bunny, faces), size=bunny.shape)

volume = surface_measures(noisy, faces).volume
panels = [Panel("noise of 0.2 edges", noisy, faces)]
for title, smooth in (
    ("Laplacian", explicit_smoothing(noisy, faces, iterations=100)),
    ("Taubin", taubin_fairing(noisy, faces, iterations=100)),
):
    kept = surface_measures(smooth, faces).volume / volume
    print(f"{title}: {100 * kept:.2f} % of the volume")
    panels.append(Panel(f"{title}, {100 * kept:.1f} % of the volume", smooth, faces))
save_picture(output, draw_panels(panels))
