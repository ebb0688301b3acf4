"""The parts of `MeshSet`, each alone: layers and filters on a plain pymeshlab mesh set, the script log on none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.errors import StepFailedError
from pymeshfair.meshlab.base import FilterFailedError, FilterParameterError, UnknownLayerError
from pymeshfair.meshset.filter_runner import FilterRunner, ScriptLog
from pymeshfair.registry import find_filter
from pymeshfair.scripts import Step
from pymeshfair.write_back import Workbench
from tests.meshes import icosphere


@pytest.fixture
def meshes() -> pymeshlab.MeshSet:
    """Pymeshlab's own mesh set with one sphere."""
    found = pymeshlab.MeshSet()
    found.add_mesh(pymeshlab.Mesh(*icosphere(1)))
    return found


def test_layers_read_any_mesh_set(meshes: pymeshlab.MeshSet) -> None:
    """A layer has the arrays of pymeshlab's mesh; one that is not there is named."""
    layers = Workbench(meshes)
    assert np.array_equal(layers.current().vertices, meshes.current_mesh().vertex_matrix())
    with pytest.raises(UnknownLayerError, match="here: there is no layer 7"):
        layers.check(7, "here: ")


def test_layers_of_an_empty_mesh_set_are_empty() -> None:
    """Without a mesh there is no current layer, and what is read of it has no vertices."""
    layers = Workbench(pymeshlab.MeshSet())
    assert not layers.has_current()
    assert layers.current().vertices.shape == (0, 3)


def test_a_set_whose_layer_is_not_current_has_no_current_layer() -> None:
    """MeshLab has no layer to read there, and a read crashes the process."""
    meshes = MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.eye(3)), set_as_current=False)
    with pytest.raises(FilterFailedError, match="has no current mesh: load one first"):
        meshes.apply_coord_taubin_fairing()
    assert repr(meshes).splitlines()[0] == "MeshSet of 1 layer"


def test_the_runner_applies_both_kinds_and_says_what_ran(meshes: pymeshlab.MeshSet) -> None:
    """A filter of MeshLab's and one of a plugin work on pymeshlab's mesh set and come back as steps with all their values."""
    runner = FilterRunner(Workbench(meshes))
    before = meshes.current_mesh().vertex_matrix()
    for name in ("apply_coord_taubin_smoothing", "apply_coord_taubin_fairing"):
        _, step = runner.apply(name, {})
        assert step is not None
        assert set(step.values) == {p.name for p in find_filter(name).parameters}
        assert not np.array_equal(meshes.current_mesh().vertex_matrix(), before)
        before = meshes.current_mesh().vertex_matrix()
    with pytest.raises(FilterParameterError, match="'iterations' takes a whole number"):
        runner.apply("apply_coord_taubin_fairing", {"iterations": "many"})


def test_the_log_applies_its_steps_in_order_and_names_the_one_that_fails(tmp_path: Path) -> None:
    """Steps are handed over one by one; an error names step, file and line, and carries the words of its cause."""
    file = tmp_path / "two.mlx"
    file.write_text('<FilterScript>\n<filter name="Taubin Fairing"/>\n<filter name="Taubin Smooth"/>\n</FilterScript>\n')
    log = ScriptLog.of(str(file))
    seen: list[Step] = []

    def see(step: Step) -> tuple[None, Step]:
        seen.append(step)
        return None, step

    list(log.apply(see))
    assert [step.filter.name for step in seen] == ["Taubin Fairing", "Taubin Smooth"]

    def fail(step: Step) -> tuple[None, Step]:
        if step == seen[1]:
            raise FilterParameterError("no")
        return None, step

    with pytest.raises(StepFailedError, match=r"^step 2 of 2, 'Taubin Smooth' \(two.mlx:3\): no$"):
        list(log.apply(fail))
    assert ScriptLog.of(None).steps == []
