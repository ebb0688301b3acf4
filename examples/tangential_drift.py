"""Three Laplacians on a sphere that is sampled densely at its top: ``python examples/tangential_drift.py OUT.png``.

Each runs until the sphere has shrunk by 1 %. Colours tell how far vertices have slid along it: to where they are sparse with the
umbrella and the scale-dependent operator, the latter half as far at most; nowhere with Laplace-Beltrami [desbrun1999].
"""

import numpy as np
from panels import Panel, draw_panels, named_output, save_picture
from scipy.spatial import ConvexHull

from pymeshfair.filters.diffusion import implicit_fairing
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.looking.picture import Appearance

output = named_output()
turn = np.arange(1500) + 0.5
y = 1.0 - 2.0 * (turn / 1500) ** 2
around = np.pi * (1.0 + 5.0**0.5) * turn
sphere = np.column_stack([np.sqrt(1.0 - y**2) * np.cos(around), y, np.sqrt(1.0 - y**2) * np.sin(around)])
faces = ConvexHull(sphere).simplices
a, b, c = (sphere[faces[:, k]] for k in range(3))
inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
faces[inwards] = faces[inwards, ::-1]

panels = []
edge = mean_edge_length(sphere, faces)
for operator in ("uniform", "scale_dependent", "cotangent"):
    time = 1e-4
    shape = sphere
    while np.linalg.norm(shape, axis=1).mean() > 0.99:
        time *= 1.1
        shape = implicit_fairing(sphere, faces, operator=operator, time_step=time)
    drift = np.linalg.norm(shape / np.linalg.norm(shape, axis=1, keepdims=True) - sphere, axis=1) / edge
    print(f"{operator}: {drift.mean():.4f} mean edges along the sphere, {drift.max():.4f} at most")
    panels.append(Panel(f"{operator}: {drift.mean():.3f} edges", shape, faces, scalars=drift))
appearance = Appearance("scalar", elevation=25.0, width=300, height=300, label="drift in mean edges")
save_picture(output, draw_panels(panels, appearance), full_color=True)
