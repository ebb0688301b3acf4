"""`pymeshfair upgrade` and what `run` and `check` do with scripts of older MeshLab versions."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from pymeshfair import MeshSet
from pymeshfair.scripts import read_script

from .command_line import document, invoke

OLD = """<!DOCTYPE FilterScript>
<FilterScript>
  <filter name="Remove Duplicated Vertex"/>
  <filter name="Merge Close Vertices">
    <Param type="RichAbsPerc" name="Threshold" value="0.5" min="0" max="100"/>
  </filter>
</FilterScript>
"""
CHANGED = """<!DOCTYPE FilterScript>
<FilterScript>
  <filter name="Remove Duplicated Vertex"/>
  <filter name="Close Holes"/>
  <filter name="Laplacian Smooth"/>
</FilterScript>
"""
TRANSFER = """<!DOCTYPE FilterScript>
<FilterScript>
  <filter name="Vertex Attribute Transfer">
    <Param type="RichMesh" name="SourceMesh" value="1"/>
    <Param type="RichMesh" name="TargetMesh" value="0"/>
    <Param type="RichBool" name="GeomTransfer" value="true"/>
  </filter>
</FilterScript>
"""


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """A script whose upgrade keeps its meaning."""
    path = tmp_path / "old.mlx"
    path.write_text(OLD, encoding="utf-8")
    return path


@pytest.fixture
def changed(tmp_path: Path) -> Path:
    """A script whose upgrade changes its meaning."""
    path = tmp_path / "changed.mlx"
    path.write_text(CHANGED, encoding="utf-8")
    return path


@pytest.fixture
def sphere(tmp_path: Path) -> Path:
    """A sphere of radius 1."""
    meshes = MeshSet()
    meshes.create_sphere(subdiv=2)
    path = tmp_path / "sphere.ply"
    meshes.save_current_mesh(str(path))
    return path


def test_an_upgraded_script_is_valid(old: Path, tmp_path: Path) -> None:
    """The new file passes `check`, which the old one does not, and upgrading it again writes the same bytes."""
    new, again = tmp_path / "new.mlx", tmp_path / "again.mlx"
    assert invoke("check", old).exit_code == 2
    assert "`pymeshfair upgrade`" in invoke("check", old).stdout
    done = invoke("upgrade", old, "-o", new)
    assert done.exit_code == 0
    assert "line 3: filter 'Remove Duplicated Vertex': is 'Remove Duplicate Vertices' now (same meaning)" in done.stdout
    assert invoke("check", new).exit_code == 0
    assert invoke("upgrade", new, "-o", again).exit_code == 0
    assert again.read_bytes() == new.read_bytes()


def test_a_change_of_meaning_has_to_be_accepted(changed: Path, tmp_path: Path) -> None:
    """Without --accept nothing is written and the exit code is 2; with it the script is written."""
    new = tmp_path / "new.mlx"
    refused = invoke("upgrade", changed, "-o", new, "--json")
    assert refused.exit_code == 2
    assert not new.exists()
    read = document(refused.stdout)
    assert [change["same_meaning"] for change in read["changes"]] == [True, False]
    assert "--accept" in read["error"]["message"]
    accepted = invoke("upgrade", changed, "-o", new, "--accept", "--json")
    assert accepted.exit_code == 0
    assert document(accepted.stdout)["output"] == str(new)
    assert new.exists()


def test_lengths_are_made_relative_to_a_mesh(old: Path, sphere: Path, tmp_path: Path) -> None:
    """A length of 0.5 that was made for the sphere is written as a part of its diagonal, with the length beside it."""
    new = tmp_path / "new.mlx"
    assert invoke("upgrade", old, "-o", new, "--relative-to", sphere).exit_code == 0
    assert 'value="0.5" ' in new.read_text("utf-8")
    assert 'relative="14.' in new.read_text("utf-8")


MERGE = """
  <filter name="Merge Close Vertices">
    <Param type="RichAbsPerc" name="Threshold" value="{}" min="0" max="100"/>
  </filter>
"""
SCALE = '<filter name="Transform: Scale, Normalize"><Param type="RichFloat" name="axisX" value="1000"/></filter>'


def test_a_length_is_a_part_of_the_mesh_before_its_step(sphere: Path, tmp_path: Path) -> None:
    """Behind a step that makes the mesh a thousand times larger, 50 is the part that 0.05 was before; both changes are listed."""
    path, new = tmp_path / "scaled.mlx", tmp_path / "new.mlx"
    path.write_text(f"<FilterScript>{MERGE.format(0.05)}{SCALE}{MERGE.format(50)}</FilterScript>", encoding="utf-8")
    done = invoke("upgrade", path, "-o", new, "--relative-to", sphere)
    assert done.exit_code == 0, done.stderr
    first, second = (step.values["threshold"] for step in read_script(new).steps[::2])
    assert second.amount == pytest.approx(first.amount, rel=1e-6)
    assert re.findall(r"parameter 'Threshold': is (1\.\d+)% of the diagonal .* now, was (\S+) \(same meaning\)", done.stdout) == [
        (f"{first.amount:.6g}", "0.05"),
        (f"{second.amount:.6g}", "50"),
    ]
    path.write_text(TRANSFER.replace("</FilterScript>", f"{MERGE.format(1)}</FilterScript>"), encoding="utf-8")
    refused = invoke("upgrade", path, "-o", tmp_path / "other.mlx", "--relative-to", sphere)
    assert refused.exit_code == 2
    assert "is layer 1, but so far there is only layer 0; --relative-to runs the steps on one mesh alone" in refused.stderr


def test_check_warns_of_traps_and_of_lengths_that_do_not_suit_the_mesh(tmp_path: Path, sphere: Path) -> None:
    """A valid script is ok, with warnings for a leftover selection, for a large length and for a layer that has to be given."""
    path = tmp_path / "a.mlx"
    path.write_text(OLD.replace("Duplicated Vertex", "Duplicate Vertices"), encoding="utf-8")
    assert document(invoke("check", path, "--json").stdout)["recipes"][0]["warnings"] == []
    (warning,) = document(invoke("check", path, "--mesh", sphere, "--json").stdout)["recipes"][0]["warnings"]
    assert "Threshold is 0.5, which is 14." in warning
    path.write_text(CHANGED.replace("Duplicated Vertex", "Duplicate Vertices"), encoding="utf-8")
    done = invoke("check", path)
    assert done.exit_code == 0
    assert "works on the faces that Close Holes has selected" in done.stdout
    path.write_text(TRANSFER, encoding="utf-8")
    assert "by --with" in invoke("check", path).stdout


def test_a_run_upgrades_and_records_what_changed(changed: Path, sphere: Path, tmp_path: Path) -> None:
    """With --upgrade an old script runs, and the record has the changed meaning among its warnings."""
    output = tmp_path / "out.ply"
    assert invoke("run", changed, sphere, "-o", output).exit_code == 2
    done = invoke("run", changed, sphere, "-o", output, "--upgrade")
    assert done.exit_code == 0, done.stderr
    record = json.loads((tmp_path / "out.ply.provenance.json").read_text("utf-8"))
    assert any(
        "meaning changes: without this parameter MeshLab worked only on the faces" in warning for warning in record["warnings"]
    )
    assert record["steps"][2]["parameters"]["selected"] is False


def test_a_run_takes_a_second_mesh(sphere: Path, tmp_path: Path) -> None:
    """Layer 1 is the mesh of --with: its place is transferred to the input. Without it the run is refused before it starts."""
    recipe, output, other = tmp_path / "transfer.mlx", tmp_path / "out.ply", tmp_path / "other.ply"
    recipe.write_text(TRANSFER, encoding="utf-8")
    meshes = MeshSet()
    meshes.create_sphere(subdiv=2, radius=1.01)
    meshes.save_current_mesh(str(other))
    refused = invoke("run", recipe, sphere, "-o", output, "--json")
    assert refused.exit_code == 2
    assert document(refused.stdout)["error"]["problems"][0]["line"] == 3
    done = invoke("run", recipe, sphere, "-o", output, "--with", other)
    assert done.exit_code == 0, done.stderr
    result = MeshSet()
    result.load_new_mesh(str(output))
    # The nearest points lie on the facets of the larger sphere, a little within its radius of 1.01; the input has radius 1.
    assert 1.005 < result.current_mesh().bounding_box().max()[0] < 1.01
    record = json.loads((tmp_path / "out.ply.provenance.json").read_text("utf-8"))
    assert [Path(entry["path"]).name for entry in record["input"]["others"]] == ["other.ply"]
