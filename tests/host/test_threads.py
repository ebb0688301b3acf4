"""Mesh sets in several threads."""

from __future__ import annotations

import subprocess
import sys

#: four threads, each with filters of both kinds on a mesh set of its own
PROGRAM = """
import threading
from pathlib import Path
import pymeshlab
from pymeshfair import MeshSet

bone = Path(pymeshlab.__file__).parent / "tests/sample_meshes/bone.ply"
ends = []

def work():
    for _ in range(3):
        meshes = MeshSet()
        meshes.load_new_mesh(str(bone))
        meshes.meshing_isotropic_explicit_remeshing(iterations=1)
        meshes.apply_coord_taubin_fairing(iterations=2)
        meshes.apply_coord_laplacian_smoothing()
        meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=1000)
        meshes.compute_curvature_principal_directions_per_vertex()
    ends.append(meshes.current_mesh().face_number())

threads = [threading.Thread(target=work) for _ in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert ends == [1000] * 4
"""


def test_mesh_sets_may_work_in_several_threads() -> None:
    """MeshLab's own filters crash the process side by side: here they take turns."""
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, encoding="utf-8", timeout=120)
    assert done.returncode == 0, done.stderr
