"""A sphere whose top was cut off and filled flat, faired in three orders: ``python examples/orders_of_fairing.py OUT.png``.

A membrane stays flat, a thin plate bulges, and minimum variation, of third order, nearly restores the sphere.
"""

import numpy as np
import pymeshlab
from panels import Panel, draw_panels, named_output, save_picture

from pymeshfair.filters.fairing import ENERGIES, fair_region
from pymeshfair.looking.picture import Appearance

output = named_output()
meshes = pymeshlab.MeshSet()
meshes.create_sphere(radius=1.0, subdiv=5)
sphere, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix().astype(np.int32)
top = (sphere[:, 2] > 0) & (np.hypot(sphere[:, 0], sphere[:, 1]) < 0.85)
flat = sphere.copy()
flat[top, 2] = np.sqrt(1 - 0.85**2)
marked = top[faces].any(axis=1)
panels = [Panel("filled flat", flat, faces, marked=marked)]
for energy in ENERGIES:
    shape = fair_region(flat, faces, top, energy=energy).vertices
    print(f"{energy}: the top is at {shape[:, 2].max():.4f}, of the sphere at 1")
    panels.append(Panel(energy, shape, faces, marked=marked))
save_picture(output, draw_panels(panels, Appearance(elevation=20.0, up="z", width=300, height=300)))
