"""An output made again from its provenance: the same, or told what has changed."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet, Recipe, run
from pymeshfair.commands.run import EXIT_CODES
from pymeshfair.files.errors import VerifyError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.outputs import Writing
from pymeshfair.files.provenance import described_file, provenance_path, read_provenance
from pymeshfair.files.three_mf import write_3mf
from pymeshfair.mesh_data import MeshData
from pymeshfair.processes.environment import versions
from pymeshfair.recipe import load_recipe
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from pymeshfair.running.verify import _differences, verify_output

from ..commands.command_line import document, invoke
from .runs import BONE, SAMPLES, SMOOTH, Given, recipe_of

_SCRIPT = '<!DOCTYPE FilterScript>\n<FilterScript><filter name="{}"/></FilterScript>\n'


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an output of a recipe of the user's own, from a copy of a scan."""
    folder = tmp_path_factory.mktemp("once")
    shutil.copy(BONE, folder / "scan.ply")
    (folder / "own.mlx").write_text(_SCRIPT.format("Taubin Smooth"))
    recipe = load_recipe(folder / "own.mlx").override(["1.stepSmoothNum=3"])
    run_job(Job(recipe, folder / "scan.ply", folder / "out.ply", overrides=("1.stepSmoothNum=3",)))
    return folder


@pytest.fixture
def made(once: Path, tmp_path: Path) -> Path:
    """The same as if made in a folder of its own."""
    folder = tmp_path / "made"
    shutil.copytree(once, folder)
    record = provenance_path(folder / "out.ply")
    record.write_text(record.read_text().replace(str(once), str(folder)))
    return folder / "out.ply"


def test_an_output_is_made_again_to_the_byte(made: Path) -> None:
    """So it is where output and provenance have been moved together, and the command exits with 0."""
    folder = made.parent / "elsewhere"
    folder.mkdir()
    for path in (made, provenance_path(made)):
        path.rename(folder / path.name)
    done = invoke("verify", folder / made.name, "--json")
    assert done.exit_code == 0
    assert document(done.stdout)["verdict"] == "identical"


def test_an_output_is_made_again_where_it_was_moved_with_its_input(tmp_path: Path) -> None:
    """As on another machine: the folders are others, the input lies to the output as it did, and a note names it."""
    for folder in ("scans", "clean"):
        (tmp_path / "here" / folder).mkdir(parents=True)
    shutil.copy(BONE, tmp_path / "here/scans/scan.ply")
    run_job(Job(load_recipe("smooth_taubin"), tmp_path / "here/scans/scan.ply", tmp_path / "here/clean/out.ply"))
    moved = (tmp_path / "here").rename(tmp_path / "there")
    found = verify_output(moved / "clean/out.ply")
    assert (found.verdict, found.notes[:1]) == (
        "identical",
        (f"the input is {moved / 'scans/scan.ply'}, which was moved or copied together with the output",),
    )
    (moved / "scans/scan.ply").write_bytes(BONE.read_bytes() + b"\n")
    assert verify_output(moved / "clean/out.ply").verdict == "input changed"


def test_a_recipe_that_was_moved_is_not_believed(made: Path) -> None:
    """A file beside an output may be anybody's: the recipe in the provenance is taken instead, if it is wished."""
    moved = made.parent.rename(made.parent.with_name("there"))
    gone = f"the recipe's file {made.parent / 'own.mlx'} is not there any more: --recorded takes the one in the provenance"
    assert verify_output(moved / made.name).findings == (gone,)
    assert verify_output(moved / made.name, recorded=True).verdict == "identical"


def _change(name: str, text: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        with (folder / name).open("a") as file:
            file.write(text)

    return change


def _rewritten(record: dict[str, object], made: Path) -> None:
    provenance_path(made).write_text(json.dumps(record))


@pytest.mark.parametrize(
    ("change", "verdict", "words"),
    [
        (_change("out.ply", "x"), "output changed", "out.ply is not what it was"),
        (lambda folder: (folder / "out.ply").unlink(), "output changed", "out.ply is not there: it was removed, or"),
        (_change("scan.ply", "x"), "input changed", "scan.ply is not what it was"),
        (lambda folder: (folder / "scan.ply").unlink(), "input changed", "scan.ply is not there any more"),
        (_change("own.mlx", "<!-- x -->"), "recipe changed", "own.mlx says something else"),
        (lambda folder: (folder / "own.mlx").unlink(), "recipe changed", "own.mlx is not there any more"),
    ],
)
def test_what_has_changed_is_told_apart(made: Path, change: Callable[[Path], None], verdict: str, words: str) -> None:
    """Nothing is run: the finding names the file, and each kind has an exit code of its own."""
    if words.startswith("own.mlx says"):
        (made.parent / "own.mlx").write_text(_SCRIPT.format("Laplacian Smooth"))
    else:
        change(made.parent)
    found = verify_output(made)
    assert found.verdict == verdict
    assert words in found.findings[0]
    assert invoke("verify", made).exit_code == EXIT_CODES[found.verdict] > 2


def test_a_script_that_was_run_as_it_is_has_not_changed(made: Path) -> None:
    """An upgrade would give it a parameter that it lacks, but the run was not asked for one."""
    script = made.parent / "as_it_is.mlx"
    script.write_text(_SCRIPT.format("Subdivision Surfaces: Catmull-Clark"))
    run_job(Job(load_recipe(script), made.parent / "scan.ply", made.with_name("finer.ply")))
    assert verify_output(made.with_name("finer.ply")).verdict == "identical"


def test_the_recorded_recipe_is_enough(made: Path) -> None:
    """With --recorded a recipe's file that has changed is a note, and the recipe in the provenance is run."""
    (made.parent / "own.mlx").unlink()
    found = verify_output(made, recorded=True)
    assert found.verdict == "identical"
    assert "own.mlx is not there any more" in found.notes[0]


def test_a_forged_recipe_is_seen(made: Path) -> None:
    """A recipe in the provenance that is not the one whose digest it gives was not run."""
    record = json.loads(provenance_path(made).read_text())
    record["recipe"]["text"] = record["recipe"]["text"].replace('"3"', '"4"')
    _rewritten(record, made)
    assert verify_output(made).verdict == "recipe changed"


def test_other_bytes_with_other_versions(made: Path) -> None:
    """Which differ is said; with the same versions the run is not repeated."""
    record = json.loads(provenance_path(made).read_text())
    record["versions"]["numpy"] = "1.0"
    made.write_bytes(BONE.read_bytes())
    record["output"] |= {"bytes": BONE.stat().st_size, "sha256": record["input"]["sha256"]}
    _rewritten(record, made)
    found = verify_output(made)
    assert found.verdict == "other versions"
    assert found.findings[0] == "out.ply has other bytes"
    assert found.findings[1].startswith("numpy was 1.0")
    record["versions"] = versions()
    _rewritten(record, made)
    assert verify_output(made).verdict == "not repeated"


RANDOM: Given = ("apply_coord_random_displacement", {"displacement": "0.1%"})


def test_what_no_seed_repeats_is_compared_by_tolerance(tmp_path: Path) -> None:
    """Another random displacement of a thousandth is within a two-hundredth of the diagonal, and the filter is named."""
    output = run_job(Job(recipe_of(RANDOM), BONE, tmp_path / "out.ply")).output
    found = verify_output(output, recorded=True)
    assert found.verdict in ("identical", "within tolerance")
    if found.verdict == "within tolerance":  # which it nearly always is
        assert "apply_coord_random_displacement gives another result each time" in found.notes[-1]


def test_outputs_of_one_place_are_compared() -> None:
    """Points that are all in one place have no diagonal: elsewhere they differ, and in the same place they do not."""
    one, other = (MeshData(vertices=np.full((2, 3), place)) for place in (0.0, 1.0))
    assert len(list(_differences(one, other, 0.1))) == 1
    assert list(_differences(one, one, 0.1)) == []


def _moved(output: Path, by: float) -> None:
    """Move one vertex of an output by so many diagonals, and let its provenance agree."""
    meshes = MeshSet()
    meshes.load_new_mesh(str(output))
    points = meshes.current_mesh().vertex_matrix()
    points[0] += by * np.linalg.norm(np.ptp(points, axis=0)) * np.array([1.0, 0.0, 0.0])
    changed = MeshSet()
    changed.add_mesh(pymeshlab.Mesh(points, meshes.current_mesh().face_matrix()))
    changed.save_current_mesh(str(output))
    record = json.loads(provenance_path(output).read_text())
    record["output"] |= described_file(output)
    _rewritten(record, output)


@pytest.mark.slow
def test_one_moved_vertex_is_more_than_chance(tmp_path: Path) -> None:
    """Of a filter that repeats but for the order of its elements, an output with a vertex elsewhere is none."""
    folder = tmp_path / "clustering.mlx"
    folder.write_text(_SCRIPT.format("Simplification: Clustering Decimation"))
    output = run_job(Job(load_recipe(folder), BONE, tmp_path / "out.ply")).output
    assert verify_output(output).verdict in ("identical", "within tolerance")
    for by in (1.0, 1e-4):
        _moved(output, by)
        found = verify_output(output)
        assert found.verdict == "not repeated"
        assert any("a vertex is" in text and "from the nearest one" in text for text in found.findings)


def test_the_steps_of_a_provenance_are_not_believed(made: Path) -> None:
    """A record that names a filter without a seed among its steps makes a changed output no less changed."""
    _moved(made, 1.0)
    record = json.loads(provenance_path(made).read_text())
    record["steps"][0]["python_name"] = "apply_coord_random_displacement"
    _rewritten(record, made)
    assert verify_output(made).verdict == "not repeated"


@pytest.mark.slow
@pytest.mark.parametrize("file", [None, "mlx_scripts/smooth_taubin.mlx"])
def test_a_recipe_is_not_the_shipped_one_because_it_says_so(file: str | None, tmp_path: Path) -> None:
    """Another script under the name of a shipped recipe is no such recipe, with its digest right, without a file or with one."""
    folder = tmp_path / "mlx_scripts"
    folder.mkdir()
    (folder / "smooth_taubin.mlx").write_text(_SCRIPT.format("Laplacian Smooth"))
    output = run_job(Job(load_recipe(folder / "smooth_taubin.mlx"), BONE, tmp_path / "out.ply")).output
    record = json.loads(provenance_path(output).read_text())
    record["recipe"]["file"] = None if file is None else str(tmp_path / file)
    _rewritten(record, output)
    (folder / "smooth_taubin.mlx").unlink()
    assert verify_output(output).verdict == "recipe changed"
    assert verify_output(output, recorded=True).verdict == "identical"


@pytest.mark.parametrize("folder", ["mlx_scripts", "superseded"])
def test_a_file_in_a_folder_named_like_those_of_shipped_recipes_is_the_users_own(folder: str, tmp_path: Path) -> None:
    """A changed copy of a shipped recipe, in a folder of the same name, is compared with itself and not with the shipped one."""
    (tmp_path / folder).mkdir()
    own = tmp_path / folder / "smooth_taubin.mlx"
    own.write_text(_SCRIPT.format("Laplacian Smooth"))
    output = run_job(Job(load_recipe(own), BONE, tmp_path / "out.ply")).output
    found = verify_output(output)
    assert (found.verdict, found.notes) == ("identical", (f"the recipe is from {own}",))


def test_a_shipped_recipe_needs_no_file(tmp_path: Path) -> None:
    """It is the one of this installation, wherever that of the run was."""
    output = run_job(Job(load_recipe("smooth_taubin"), BONE, tmp_path / "out.ply")).output
    record = json.loads(provenance_path(output).read_text())
    record["recipe"]["file"] = "/elsewhere/site-packages/pymeshfair/mlx_scripts/smooth_taubin.mlx"
    _rewritten(record, output)
    assert verify_output(output).verdict == "identical"


def test_zipped_outputs_repeat_to_the_bit(tmp_path: Path) -> None:
    """A .3mf file holds neither dates nor random numbers: a repeated run writes the same bytes, and one moved vertex is seen."""
    output = run_job(Job(load_recipe("smooth_taubin"), BONE, tmp_path / "out.3mf", unit="mm")).output
    assert verify_output(output).verdict == "identical"
    mesh, record = read_file(output).mesh, json.loads(provenance_path(output).read_text())
    moved = mesh.vertices.copy()
    moved[0] *= 1.0 + 1e-6
    with output.open("wb") as file:  # by ours: MeshLab's reader of .3mf files sets the locale of the process to "C"
        write_3mf(replace(mesh, vertices=moved), file, Writing(lambda: 0.0, {}, "", []))
    record["output"] |= described_file(output)
    _rewritten(record, output)
    assert verify_output(output).verdict == "not repeated"


def test_a_run_of_python_is_that_of_the_command_line(tmp_path: Path) -> None:
    """Values that Python sets are in the record, by setting and by step, of a shipped recipe and of a file: it is repeated."""
    (tmp_path / "own.mlx").write_text(_SCRIPT.format("Taubin Smooth"))
    runs = {
        "settings": run("smooth_implicit", BONE, tmp_path / "settings.ply", settings={"detail_size": "8edge"}),
        "set": run(tmp_path / "own.mlx", BONE, tmp_path / "set.ply", set=["1.stepSmoothNum=3"]),
    }
    assert [done.record["recipe"]["overrides"] for done in runs.values()] == [["detail_size=8edge"], ["1.stepSmoothNum=3"]]
    assert [verify_output(done.output).verdict for done in runs.values()] == ["identical"] * 2
    assert invoke("run", "smooth_implicit", BONE, "-o", tmp_path / "x.ply", "--set", "detail_size=8edge").exit_code == 0
    of_command = json.loads(provenance_path(tmp_path / "x.ply").read_text())
    assert of_command["warnings"] == list(runs["settings"].warnings)


def test_a_changed_recipe_of_python_has_no_file_until_it_is_saved(tmp_path: Path) -> None:
    """With another step, tag or limit it is not the file's, which is said with what to do; saved, it is that of the new file."""
    changes: list[Callable[[Recipe], object]] = [
        lambda recipe: recipe.apply_coord_taubin_fairing(iterations=2),
        lambda recipe: recipe.tag("first"),
        lambda recipe: recipe.limit(max_displacement="50%"),
    ]
    for change in changes:
        recipe = Recipe.load("smooth_taubin")
        change(recipe)
        assert recipe.script.path is None
    found = verify_output(recipe.run(BONE, tmp_path / "out.ply").output)
    assert found.findings == ("the recipe was not in a file: --recorded repeats the run with the one in the provenance",)
    recipe.set("1.stepSmoothNum=3")
    recipe.save(tmp_path / "own.mlx")
    assert verify_output(recipe.run(BONE, tmp_path / "saved.ply").output).verdict == "identical"


@pytest.mark.parametrize("option", ["--allow-outside", "--unchecked"])
def test_what_weakens_a_run_is_given_again(option: str, made: Path) -> None:
    """A provenance cannot let a mesh file name files anywhere, or MeshLab read what is not checked."""
    record = json.loads(provenance_path(made).read_text())
    record["options"] = {option.removeprefix("--").replace("-", "_"): True}
    _rewritten(record, made)
    refused = invoke("verify", made)
    assert refused.exit_code == 2
    assert f"the run was given {option}, which a provenance cannot allow" in refused.stderr
    assert invoke("verify", made, option).exit_code == 0


def test_textures_get_the_names_that_they_had(tmp_path: Path) -> None:
    """A texture that was written under another name, as its own was taken, is so again."""
    (tmp_path / "TextureDouble_A.png").write_bytes(b"another one")
    source = SAMPLES / "bunny10k_textured.obj"
    output = run_job(Job(recipe_of(SMOOTH), source, tmp_path / "out.obj")).output
    assert (tmp_path / "out-TextureDouble_A.png").exists()
    assert verify_output(output, recorded=True).verdict == "identical"


def test_an_output_may_be_copied_under_another_name(tmp_path: Path) -> None:
    """An OBJ file, whose bytes and textures have the old name in them, is made again to the byte; a changed copy is found."""
    (tmp_path / "TextureDouble_A.png").write_bytes(b"another one")
    output = run_job(Job(recipe_of(SMOOTH), SAMPLES / "bunny10k_textured.obj", tmp_path / "out.obj")).output
    copied = tmp_path / "copied.obj"
    shutil.copy(provenance_path(output), provenance_path(copied))
    shutil.copy(output, copied)
    found = verify_output(copied, recorded=True)
    assert (found.verdict, found.notes[-1]) == ("identical", "the run wrote it as out.obj")
    copied.write_bytes(b"# changed\n" + output.read_bytes())
    found = verify_output(copied, recorded=True)
    assert (found.verdict, found.findings) == ("output changed", (f"{copied} is not what it was (its SHA-256 is different)",))


@pytest.mark.parametrize(
    "damage",
    [
        {"input": []},
        {"input": {"others": [1]}},
        {"input": {"others": None}},
        {"output": {"side_files": True}},
        {"guards": {"maps": 1}},
        {"guards": None},
        {"options": {"unit": []}},
        {"versions": 1.5},
        "[" * 100_000,
    ],
)
def test_a_damaged_provenance_is_none(damage: dict[str, Any] | str, tmp_path: Path) -> None:
    """A record with a part of a wrong type, or with JSON that is nested too deeply, counts as none."""
    record = {"schema": "pymeshfair-provenance-1", "input": {}, "output": {}}
    path = provenance_path(tmp_path / "out.ply")
    path.write_text(json.dumps(record), "utf-8")
    assert read_provenance(tmp_path / "out.ply") == record
    path.write_text(damage if isinstance(damage, str) else json.dumps({**record, **damage}), "utf-8")
    assert read_provenance(tmp_path / "out.ply") is None


def test_an_output_of_unknown_origin(tmp_path: Path) -> None:
    """Without a file or its provenance, or with one that lacks something, the error says which, and that nothing is verified."""
    with pytest.raises(VerifyError, match=r"cannot verify .*out\.ply: there is no such file$"):
        verify_output(tmp_path / "out.ply")
    shutil.copy(BONE, tmp_path / "out.ply")
    with pytest.raises(VerifyError, match=r"cannot verify .*out\.ply: nothing is known"):
        verify_output(tmp_path / "out.ply")
    _rewritten({"schema": "pymeshfair-provenance-1", "input": {}, "output": {}}, tmp_path / "out.ply")
    with pytest.raises(VerifyError, match="cannot be understood"):
        verify_output(tmp_path / "out.ply")
