"""Every filter tells how far it is, and whoever is told may stop it; the mesh is then what it was."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

from pymeshfair.declaration import Filter, MeshElement
from tests.contracts.scenes import apply, mesh_set, scene_for
from tests.contracts.variants import FILTERS, Variant, each_variant, outcome_of
from tests.host.snapshots import differences, everything


def tells_progress(declared: Filter) -> bool:
    """Whether the filter's function takes `progress`."""
    assert declared.function is not None
    return "progress" in inspect.signature(declared.function).parameters


TELLING = [declared for declared in FILTERS if tells_progress(declared)]


def test_what_changes_a_mesh_tells_progress() -> None:
    """Filters that only count, or show what they see as scalars and colours, may keep silent."""
    moves = MeshElement.VERTCOORD | MeshElement.VERTNUMBER | MeshElement.FACENUMBER | MeshElement.FACENORMAL
    assert not [declared.python_name for declared in set(FILTERS) - set(TELLING) if declared.changes & moves]


@each_variant
def test_progress_rises_to_one(variant: Variant) -> None:
    """Shares rise from 0 to 1, never fall, end at 1, and being told changes no bit of the result."""
    if not tells_progress(variant.declared):
        pytest.skip("a filter that only counts or looks")
    told: list[float] = []
    found = apply(variant.declared, scene_for(variant.declared), variant.values, on_progress=told.append)
    assert told[0] >= 0.0
    assert (np.diff(told) >= 0.0).all()
    assert told[-1] == 1.0
    assert found.differences(outcome_of(variant)) == []


class Stop(BaseException):
    """What a caller stops the work with: no error that a filter may catch and work around."""


@pytest.mark.parametrize("declared", TELLING, ids=lambda d: d.python_name)
def test_stopped_work_leaves_the_mesh_as_it_was(declared: Filter) -> None:
    """An exception out of the first, a middle and the last telling ends the filter, comes out as it is, and changes no bit."""
    for share in (0.0, 0.5, 1.0):
        meshes = mesh_set(scene_for(declared), select=True)
        before = everything(meshes)
        stopped: list[float] = []

        def stop(done: float, share: float = share, stopped: list[float] = stopped) -> None:
            if done >= share:
                stopped.append(done)
                raise Stop

        meshes.on_progress = stop
        with pytest.raises(Stop):
            meshes.apply_filter(declared.python_name)
        assert len(stopped) == 1
        assert differences(before, everything(meshes)) == []
