"""OFF files that MeshLab writes and does not read as it wrote them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab

from tests.commands.command_line import run_process
from tests.meshes import icosphere


def test_colours_before_normals_are_read_as_they_were_written(tmp_path: Path) -> None:
    """MeshLab writes colours before normals and reads normals first: what it wrote comes back with the right ones of both."""
    vertices, faces = icosphere(1)
    colours = np.random.default_rng(1).integers(0, 256, (len(vertices), 4)) / 255
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces, v_color_matrix=colours))
    meshes.compute_normal_per_vertex()
    meshes.save_current_mesh(str(tmp_path / "ball.off"))
    meshes.load_new_mesh(str(tmp_path / "ball.off"))
    assert not np.allclose(meshes.current_mesh().vertex_color_matrix(), colours)
    done = run_process("run", "smooth_taubin", "--set", "1.stepsmoothnum=0", tmp_path / "ball.off", "-o", tmp_path / "same.ply")
    assert done.returncode == 0, done.stderr
    meshes.load_new_mesh(str(tmp_path / "same.ply"))
    assert np.allclose(meshes.current_mesh().vertex_color_matrix(), colours)
    assert np.allclose(meshes.current_mesh().vertex_normal_matrix(), vertices, atol=0.1)
