"""One shape in two resolutions, smoothed in two ways: ``python examples/mesh_independence.py OUT.png``.

Steps of the umbrella operator smooth a coarse mesh further than a fine one; a detail size means the same on both.
"""

from pathlib import Path

import pymeshlab
from fast_simplification import simplify
from panels import Panel, draw_panels, named_output, save_picture

from pymeshfair import MeshSet
from pymeshfair.filters.inspection import displacement
from pymeshfair.looking.picture import Appearance

output = named_output()
panels = []
for name, parameters in (
    ("apply_coord_explicit_smoothing", {"iterations": 40}),
    ("apply_coord_implicit_fairing", {"detail_size": "8%"}),
):
    shapes = []
    for size in (1.0, 1 / 16):
        meshes = MeshSet()
        meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny.obj"))
        if size < 1.0:  # MeshLab's decimation is not the same from run to run
            fine = meshes.current_mesh()
            meshes.add_mesh(pymeshlab.Mesh(*simplify(fine.vertex_matrix(), fine.face_matrix(), 1.0 - size)))
        meshes.apply_filter(name, **parameters)
        mesh = meshes.current_mesh()
        shapes.append((mesh.vertex_matrix(), mesh.face_matrix()))
        way = "40 umbrella steps" if "iterations" in parameters else "detail size 8 %"
        panels.append(Panel(f"{mesh.vertex_number():,} vertices, {way}", *shapes[-1]))
    apart = displacement(*shapes[1], *shapes[0]).distances
    print(f"{way}: the coarse result lies {100 * apart.mean():.3f} % of the bunny's size from the fine one")
save_picture(output, draw_panels(panels, Appearance(width=290, height=290)))
