"""The filter script of a mesh set: what was applied, saved, loaded and applied again."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair import Recipe
from pymeshfair.declaration import Edit, Length
from pymeshfair.errors import PymeshfairError, StepFailedError
from pymeshfair.meshlab.base import FilterFailedError, ScriptStepFailedError
from pymeshfair.meshset import MeshSet
from pymeshfair.registry import find_filter
from pymeshfair.scripts import Script, ScriptError, Step, read_script, write_script
from tests.host.snapshots import differences, everything, give_back, sample
from tests.meshes import icosphere


def ball() -> MeshSet:
    """A mesh set with one sphere."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(2)), "ball")
    return meshes


def test_a_session_becomes_a_script_that_does_the_same(tmp_path: Path) -> None:
    """Filters of both kinds are recorded with all their values; the saved script makes the same mesh again, to the bit."""
    first = ball()
    first.apply_coord_taubin_fairing(iterations=3, step=0.423456789012)
    first.meshing_surface_subdivision_midpoint(iterations=1)
    first.apply_coord_implicit_fairing(detail_size="20%")
    first.apply_coord_laplacian_smoothing(stepsmoothnum=2)
    first.compute_selection_by_outlier_probability_per_vertex(neighbors=12)
    file = tmp_path / "session.mlx"
    first.save_filter_script(str(file))
    second = ball()
    second.load_filter_script(str(file))
    second.apply_filter_script()
    assert differences(everything(first), everything(second)) == []
    steps = read_script(file).steps
    assert [step.filter.python_name for step in steps] == [
        "apply_coord_taubin_fairing",
        "meshing_surface_subdivision_midpoint",
        "apply_coord_implicit_fairing",
        "apply_coord_laplacian_smoothing",
        "compute_selection_by_outlier_probability_per_vertex",
    ]
    assert all(step.values.keys() == {p.name for p in step.filter.parameters} for step in steps)
    assert steps[0].values["step"] == 0.423456789012


def test_relative_lengths_stay_relative(tmp_path: Path) -> None:
    """What was given in percent or edges is written so, beside the length on the step's mesh; MeshLab's defaults likewise."""
    meshes = ball()
    diagonal = meshes._bench.current().diagonal
    meshes.apply_coord_implicit_fairing(detail_size="20%")
    meshes.apply_coord_implicit_fairing()
    meshes.meshing_isotropic_explicit_remeshing(iterations=1, targetlen="0.8edge")
    meshes.meshing_isotropic_explicit_remeshing(iterations=1, targetlen=pymeshlab.PercentageValue(10.1))
    meshes.meshing_merge_close_vertices(threshold=pymeshlab.PercentageValue(1))
    file = tmp_path / "lengths.mlx"
    meshes.save_filter_script(str(file))
    detail, default, edges, percent, merge = read_script(file).steps
    assert detail.values["detail_size"] == Length(20.0, "percent")
    assert default.values["detail_size"] == Length(6.0, "edge")
    assert edges.values["targetlen"] == Length(0.8, "edge")
    assert edges.values["maxsurfdist"] == Length(1.0, "percent")
    assert percent.values["targetlen"] == Length(10.1, "percent")
    # percent of a hundredth of the diagonal, which MeshLab has in single precision
    threshold = merge.values["threshold"]
    assert isinstance(threshold, Length)
    assert threshold.unit == "percent"
    assert threshold.amount == pytest.approx(0.01, rel=2.0**-22)
    written = re.search(r'name="detail_size" value="([^"]*)"', file.read_text(encoding="utf-8"))
    assert written is not None
    assert float(written[1]) == pytest.approx(0.2 * diagonal)


def test_an_absolute_length_is_that_of_the_mesh_before_its_step(tmp_path: Path) -> None:
    """Pymeshlab, which reads these alone, merges no more vertices than the session did before it made the mesh larger."""
    first, theirs, again = ball(), pymeshlab.MeshSet(), ball()
    own, reapplied = tmp_path / "session.mlx", tmp_path / "reapplied.mlx"
    theirs.add_mesh(pymeshlab.Mesh(*icosphere(2)))
    first.meshing_merge_close_vertices(threshold=pymeshlab.PercentageValue(1))
    first.compute_matrix_from_scaling_or_normalization(axisx=1000.0)
    first.save_filter_script(str(own))
    theirs.load_filter_script(str(own))
    theirs.apply_filter_script()
    np.testing.assert_array_equal(theirs.current_mesh().vertex_matrix(), first.current_mesh().vertex_matrix())
    again.load_filter_script(str(own))
    again.apply_filter_script()
    again.save_filter_script(str(reapplied))
    assert reapplied.read_bytes() == own.read_bytes()


def globe(radius: float) -> MeshSet:
    """A mesh set with a sphere and a small piece beside it."""
    meshes = MeshSet()
    (vertices, faces), (more, their) = icosphere(3), icosphere(1)
    vertices = np.concatenate([vertices, 0.05 * more + [1.2, 0.0, 0.0]])
    meshes.add_mesh(pymeshlab.Mesh(radius * vertices, np.concatenate([faces, their + 642])))
    return meshes


def test_a_recorded_recipe_means_the_same_at_every_size(tmp_path: Path) -> None:
    """Recorded on a sphere of radius 1 and run at radius 10, percentages and defaults give the same faces in the same order."""
    first = globe(1.0)
    first.meshing_remove_connected_component_by_diameter()
    first.meshing_isotropic_explicit_remeshing(iterations=3, targetlen=pymeshlab.PercentageValue(6))
    first.meshing_merge_close_vertices(threshold=pymeshlab.PercentageValue(100))
    first.apply_coord_laplacian_smoothing_scale_dependent(delta="0.002%")
    file = tmp_path / "recorded.mlx"
    first.save_filter_script(str(file))
    assert {value.unit for step in read_script(file).steps for value in step.values.values() if isinstance(value, Length)} == {
        "percent"
    }
    second = globe(10.0)
    second.load_filter_script(str(file))
    second.apply_filter_script()
    found, expected = second.current_mesh(), first.current_mesh()
    assert 300 < found.face_number() < 1280
    assert found.face_number() == expected.face_number()
    np.testing.assert_array_equal(found.face_matrix(), expected.face_matrix())


def test_a_script_has_what_recipes_did(tmp_path: Path) -> None:
    """After README's steps, filters and a recipe by its name, the saved script closes the hole as they did, to the bit."""
    vertices, faces = icosphere(3)
    (tmp_path / "own.mlx").write_text('<FilterScript><filter name="Taubin Smooth"/></FilterScript>')

    def holed() -> MeshSet:
        meshes = MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces[(vertices[faces][:, :, 2] < 0.8).all(axis=1)]))
        return meshes

    first, second = holed(), holed()
    first.meshing_remove_duplicate_vertices()
    first.apply_coord_implicit_fairing(detail_size="6edge")
    first.apply_recipe("fill_holes_smoothly")
    Recipe.load(tmp_path / "own.mlx").apply(first)
    file = tmp_path / "recipe.mlx"
    first.save_filter_script(str(file))
    names = [step.filter.python_name for step in read_script(file).steps]
    assert names[:2] == ["meshing_remove_duplicate_vertices", "apply_coord_implicit_fairing"]
    assert "meshing_close_holes_by_fairing" in names[2:-1]
    assert names[-1] == "apply_coord_taubin_smoothing"
    second.load_filter_script(str(file))
    second.apply_filter_script()
    assert second.current_mesh().face_number() > holed().current_mesh().face_number()
    np.testing.assert_array_equal(second.current_mesh().vertex_matrix(), first.current_mesh().vertex_matrix())
    np.testing.assert_array_equal(second.current_mesh().face_matrix(), first.current_mesh().face_matrix())


def test_the_script_follows_meshlabs_rules(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Loading replaces the script, applying a filter adds to it, applying the script does not, clearing empties it."""
    file = tmp_path / "one.mlx"
    write_script(Script((Step(find_filter("apply_coord_taubin_fairing"), {"iterations": 2}),)), file)
    meshes = ball()

    def size() -> int:
        meshes.print_filter_script()
        found = re.match(r"Filter Script Size : (\d+)\n", capsys.readouterr().out)
        assert found is not None
        return int(found[1])

    meshes.apply_coord_taubin_smoothing()
    meshes.apply_coord_taubin_fairing()
    assert size() == 2
    meshes.load_filter_script(str(file))
    assert size() == 1
    meshes.apply_filter_script()
    assert size() == 1
    meshes.apply_coord_taubin_fairing()
    assert size() == 2
    with pytest.raises(pymeshlab.PyMeshLabException):
        meshes.compute_selection_by_condition_per_vertex(condselect="nonsense(")
    assert size() == 2
    meshes.apply_step(give_back(Edit(vertex_scalars=np.zeros(162))))
    assert size() == 2
    meshes.clear()
    assert size() == 2
    meshes.clear_filter_script()
    assert size() == 0


def test_printing_works_after_a_failed_filter(capsys: pytest.CaptureFixture[str]) -> None:
    """MeshLab's own output stays muted after a failure; the script is printed by Python, with every value."""
    meshes = ball()
    meshes.apply_coord_implicit_fairing(detail_size="20%")
    with pytest.raises(pymeshlab.PyMeshLabException):
        meshes.compute_selection_by_condition_per_vertex(condselect="nonsense(")
    capsys.readouterr()
    meshes.print_filter_script()
    out = capsys.readouterr().out
    assert out.startswith("Filter Script Size : 1\n\n0: apply_coord_implicit_fairing\n\toperator : str = cotangent\n")
    assert "\tdetail_size : Length = 20%\n" in out


def test_a_script_does_what_its_filters_do_one_by_one() -> None:
    """A script of both kinds of filters makes the same mesh as the filters applied one after another, to the bit."""
    chain: list[tuple[str, dict[str, Any]]] = [
        ("apply_coord_taubin_fairing", {"iterations": 2}),
        ("compute_selection_by_outlier_probability_per_vertex", {"neighbors": 8, "threshold": 0.1}),
        ("apply_coord_explicit_smoothing", {"iterations": 1, "selected": True}),
        ("meshing_surface_subdivision_midpoint", {"iterations": 1}),
        ("apply_coord_explicit_smoothing", {"iterations": 1}),
        ("apply_coord_taubin_fairing", {"iterations": 1}),
    ]
    one_by_one = ball()
    for name, values in chain:
        one_by_one.apply_filter(name, **values)
    together = ball()
    together._script.steps = list(one_by_one._script.steps)
    together.apply_filter_script()
    assert differences(everything(one_by_one), everything(together)) == []


@pytest.mark.parametrize("fails", ["plugin", "MeshLab"])
def test_a_failing_step_is_named_and_leaves_the_steps_before(fails: str, tmp_path: Path) -> None:
    """The error says step, filter, file and line, and the mesh is as the last complete step left it."""
    last = (
        '<filter name="Explicit Smoothing"><Param type="RichBool" name="selected" value="true"/></filter>'
        if fails == "plugin"
        else '<filter name="Transfer Color: Face to Vertex"/>'
    )
    taubin = '<filter name="Taubin Fairing"><Param type="RichInt" name="iterations" value="1"/></filter>'
    file = tmp_path / "broken.mlx"
    steps = "\n".join([taubin, taubin, last, taubin])
    file.write_text(f"<!DOCTYPE FilterScript>\n<FilterScript>\n{steps}\n</FilterScript>\n", encoding="utf-8")
    expected = ball()
    for _ in range(2):
        expected.apply_coord_taubin_fairing(iterations=1)
    meshes = ball()
    meshes.load_filter_script(str(file))
    with pytest.raises(ScriptStepFailedError) as caught:
        meshes.apply_filter_script()
    error = caught.value
    assert (error.place.step, error.place.total, error.place.file, error.place.line) == (3, 4, file, 5)
    assert str(error).startswith(f"step 3 of 4, {error.place.filter!r} (broken.mlx:5): ")
    assert isinstance(error, StepFailedError)  # the same error that a run ends with
    assert isinstance(error.__cause__, FilterFailedError if fails == "plugin" else pymeshlab.PyMeshLabException)
    assert differences(everything(expected), everything(meshes)) == []


def test_a_broken_script_is_refused_whole(tmp_path: Path) -> None:
    """Loading a script with problems lists them and leaves the current script alone; MeshLab would silently empty it."""
    meshes = ball()
    meshes.apply_coord_taubin_fairing(iterations=1)
    file = tmp_path / "broken.mlx"
    file.write_text('<FilterScript>\n<filter name="Taubn Fairing"/>\n</FilterScript>\n', encoding="utf-8")
    with pytest.raises(ScriptError, match=r"broken.mlx:2: filter 'Taubn Fairing'.*did you mean 'Taubin Fairing'"):
        meshes.load_filter_script(str(file))
    assert len(meshes._script.steps) == 1
    with pytest.raises(PymeshfairError, match="cannot write"):
        meshes.save_filter_script(str(tmp_path / "missing/x.mlx"))


def test_recorded_values_are_complete() -> None:
    """A step is recorded with every value that it ran with, those that depend on the mesh included."""
    meshes = MeshSet()
    meshes.load_new_mesh(sample("bone.ply"))
    meshes.apply_filter("meshing_decimation_clustering")
    recorded = meshes._script.steps[-1]
    assert recorded.values.keys() == {p.name for p in recorded.filter.parameters}
    fresh = MeshSet()
    fresh.load_new_mesh(sample("bone.ply"))
    assert fresh._filters.apply_step(Step(recorded.filter))[1].values == recorded.values


def test_what_a_filter_was_last_used_with_is_no_default_of_a_script() -> None:
    """MeshLab remembers the values of a remeshing as defaults of the next; a step that leaves them out takes the table's."""
    remeshing = find_filter("meshing_isotropic_explicit_remeshing")
    results = []
    for disturb in (False, True):
        meshes = ball()
        if disturb:
            meshes.meshing_isotropic_explicit_remeshing(iterations=1, targetlen="30%", featuredeg=80.0)
            meshes = ball()
        step = Step(remeshing, {"targetlen": Length(10.0, "percent")})
        assert meshes._filters.apply_step(step)[1].values["iterations"] == 10
        results.append(meshes.current_mesh().vertex_matrix())
    np.testing.assert_array_equal(results[0], results[1])
