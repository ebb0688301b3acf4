"""`pymeshfair.run`: a mesh file through a recipe in one call of Python."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pymeshlab

import pymeshfair
from pymeshfair.recipe import load_recipe
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from tests.commands.command_line import document, invoke
from tests.meshes import icosphere, noisy


def test_a_file_goes_through_a_recipe_with_its_settings_and_record(tmp_path: Path) -> None:
    """The output and its record are there, the setting took effect, and a recipe that is given as an object stays as it was."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*noisy(icosphere(3), 0.01)))
    meshes.save_current_mesh(str(tmp_path / "ball.ply"))
    recipe = pymeshfair.Recipe.load("denoise_meshlab_only")
    before = recipe.script
    result = pymeshfair.run(recipe, tmp_path / "ball.ply", tmp_path / "clean.ply", settings={"rounds": 3})
    assert result.output == tmp_path / "clean.ply"
    assert result.output.is_file()
    assert result.provenance.is_file()
    assert recipe.script == before
    assert re.fullmatch(r"<RunResult '.*clean.ply': 3 steps.*, 642 -> 642 vertices, \d+\.\d s>", repr(result))
    assert ", 1,200 -> 1 vertex, " in repr(replace(result, before={"vertices": 1200}, after={"vertices": 1}))
    assert result.record["recipe"]["name"] == "denoise_meshlab_only"
    assert result.record["measures"]["after"]["vertices"] == result.after["vertices"] == 642
    assert len(result.steps) == len(result.record["steps"]) == 3
    assert "rounds" in {s.name for s in recipe.script.settings}
    again = pymeshfair.run("denoise_meshlab_only", tmp_path / "ball.ply", tmp_path / "clean.ply", set=["rounds=3"])
    assert again.record["output"]["sha256"] == result.record["output"]["sha256"]


def test_one_text_and_one_file_need_no_list(tmp_path: Path) -> None:
    """A text in `set` is one override, and a text or a path in `others` is the file of layer 1."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(2)))
    for name in ("ball.ply", "n.ply"):
        meshes.save_current_mesh(str(tmp_path / name))
    recipe = pymeshfair.Recipe("distance")
    recipe.get_hausdorff_distance(sampledmesh=0, targetmesh=1, samplenum=10)
    others: list[str | Path] = [str(tmp_path / "n.ply"), tmp_path / "n.ply"]
    for number, other in enumerate(others):
        done = pymeshfair.run(recipe, tmp_path / "ball.ply", tmp_path / f"{number}.ply", set="1.samplenum=20", others=other)
        assert [entry["path"] for entry in done.record["input"]["others"]] == [str(tmp_path / "n.ply")]
        assert done.record["recipe"]["overrides"] == ["1.samplenum=20"]


def test_every_way_to_run_gives_the_same_warnings(tmp_path: Path) -> None:
    """A better recipe, conditions that cannot be read and a step that works on a selection are each told once."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(2)))
    meshes.save_current_mesh(str(tmp_path / "ball.ply"))
    steps = '<filter name="Close Holes"/><filter name="Laplacian Smooth"/>'
    head = "<!--\nOwn\n\nSuperseded: take another.\n\nFits: bricks.\n-->"
    (tmp_path / "own.mlx").write_text(f"<!DOCTYPE FilterScript>\n{head}\n<FilterScript>{steps}</FilterScript>\n")
    told = pymeshfair.run(tmp_path / "own.mlx", tmp_path / "ball.ply", tmp_path / "a.ply").warnings
    job = Job(load_recipe(tmp_path / "own.mlx"), tmp_path / "ball.ply", tmp_path / "b.ply")
    assert run_job(job).warnings == told
    done = invoke("run", tmp_path / "own.mlx", tmp_path / "ball.ply", "-o", tmp_path / "c.ply", "--json")
    assert tuple(document(done.stdout)["warnings"]) == told
    for words in ("superseded", "Fits: 'bricks' is no condition", "works on the faces that Close Holes has selected"):
        assert sum(words in text for text in told) == 1


def test_a_run_without_measures_writes_the_same_bytes(tmp_path: Path) -> None:
    """What is left out is said in the record; the output is the same."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*noisy(icosphere(2), 0.01)))
    meshes.save_current_mesh(str(tmp_path / "ball.ply"))
    measured = pymeshfair.run("smooth_taubin", tmp_path / "ball.ply", tmp_path / "with.ply")
    without = pymeshfair.run("smooth_taubin", tmp_path / "ball.ply", tmp_path / "without.ply", measures=False)
    assert (tmp_path / "without.ply").read_bytes() == (tmp_path / "with.ply").read_bytes()
    assert without.record["options"] == {"no_measures": True}
    assert "options" not in measured.record
