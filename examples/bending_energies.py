"""The least bending near a noisy bunny, held mildly and strongly: ``python examples/bending_energies.py OUT.png``.

The surface p' minimises sum A (|L p'|^2 + w |p' - p|^2); w is in one over the fourth power of mean edges [nealen2006].
"""

from pathlib import Path

import numpy as np
import pymeshlab
from panels import Panel, draw_panels, named_output, save_picture

from pymeshfair.filters.fairing import bilaplacian_smoothing
from pymeshfair.filters.geometry import mean_edge_length

output = named_output()
meshes = pymeshlab.MeshSet()
meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny.obj"))
bunny, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
edge = mean_edge_length(bunny, faces)
noisy = bunny + np.random.default_rng(0).normal(scale=0.2 * edge, size=bunny.shape)
panels = [Panel("noise of 0.2 edges", noisy, faces)]
for weight in (0.2, 0.02):
    half = 2.0 * np.pi / weight**0.25 * mean_edge_length(noisy, faces)  # the wavelength of which half remains
    smooth = bilaplacian_smoothing(noisy, faces, detail_size=half)
    apart = np.linalg.norm(smooth - bunny, axis=1).mean() / edge
    print(f"w = {weight}: {apart:.3f} mean edges from the bunny without noise")
    panels.append(Panel(f"w = {weight}", smooth, faces))
save_picture(output, draw_panels(panels))
