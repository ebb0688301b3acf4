"""Scripts that plain pymeshlab runs give the same bits here."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.scripts import ScriptError, read_script
from pymeshfair.scripts.warnings import unmet_needs
from tests.host.snapshots import sample
from tests.scripts.texts import script

OWN = """<!DOCTYPE FilterScript>
<FilterScript>
 <filter name="Merge Close Vertices">
  <Param type="RichAbsPerc" name="Threshold" value="0.001" min="0" max="1"/>
 </filter>
 <filter name="Close Holes"><Param type="RichInt" name="MaxHoleSize" value="100"/></filter>
 <filter name="Simplification: Quadric Edge Collapse Decimation">
  <Param type="RichInt" name="TargetFaceNum" value="1500"/><Param type="RichBool" name="Selected" value="false"/>
 </filter>
 <filter name="Conditional Vertex Selection"><Param type="RichString" name="condSelect" value="z > 0.1"/></filter>
 <filter name="Laplacian Smooth"><Param type="RichInt" name="stepSmoothNum" value="3"/></filter>
 <filter name="Per Vertex Quality Function"><Param type="RichString" name="q" value="x * y"/></filter>
</FilterScript>
"""
FOLDER = Path(os.environ.get("PYMESHFAIR_DATA", "/nowhere")) / "mlx_wild"


def after(meshes: Any, script: Path) -> list[Any]:
    """What a mesh set has of a bone after a script."""
    meshes.load_new_mesh(sample("bone.ply"))
    meshes.load_filter_script(str(script))
    meshes.apply_filter_script()
    mesh = meshes.current_mesh()
    return [mesh.vertex_matrix(), mesh.face_matrix(), mesh.vertex_normal_matrix(), mesh.vertex_selection_array()]


def check(script: Path) -> None:
    """Check that both ways give the same."""
    for plain, ours in zip(after(pymeshlab.MeshSet(), script), after(MeshSet(), script), strict=True):
        np.testing.assert_array_equal(plain, ours)


def test_a_script_gives_the_bits_of_plain_pymeshlab(tmp_path: Path) -> None:
    """Lengths in mesh units, defaults that depend on the mesh, selections and expressions: all as plain pymeshlab has them."""
    path = tmp_path / "own.mlx"
    path.write_text(OWN, encoding="utf-8")
    check(path)


@pytest.mark.parametrize(
    "steps",
    [
        '<filter name="Transform: Translate, Center, set Origin">{axisX=-500000}{axisZ=7}</filter>',
        '<filter name="Per Vertex Quality Function"><Param type="RichString" name="q" value="x"/></filter>'
        '<filter name="Select by Vertex Quality">{minQ=5}{maxQ=9}</filter>',
        '<filter name="Select Faces with edges longer than...">{Threshold=1e9}</filter>',
    ],
    ids=["translation", "scalars", "edges"],
)
def test_numbers_beyond_bounds_of_the_mesh_give_the_bits_of_plain_pymeshlab(steps: str, tmp_path: Path) -> None:
    """A script has no bounds; a call of pymeshlab translates by five diagonals at most, and selects what is at the bound."""
    path = tmp_path / "own.mlx"
    param = r'<Param type="RichDynamicFloat" name="\1" value="\2" min="-1e9" max="1e9"/>'
    path.write_bytes(script(re.sub(r"{(\w+)=(\S+?)}", param, steps)))
    check(path)


@pytest.mark.skipif(not FOLDER.is_dir(), reason="set PYMESHFAIR_DATA to the folder that has mlx_wild/")
def test_real_scripts_give_the_bits_of_plain_pymeshlab() -> None:
    """All scripts of today among the real ones that need one mesh and choose nothing at random."""
    checked = 0
    for path in sorted(FOLDER.glob("*.mlx")):
        try:
            script = read_script(path)
        except ScriptError:
            continue
        reconstructs = any(step.filter.python_name.startswith("generate_") for step in script.steps)
        if not reconstructs and not list(unmet_needs(script, layers=1)):
            check(path)
            checked += 1
    assert checked >= 10
