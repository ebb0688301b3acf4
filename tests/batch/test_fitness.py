"""Which workers of a scheduler may take part in a batch."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from pymeshfair.processes.cluster import conditions
from pymeshfair.recipe import load_recipe, shipped_recipes
from pymeshfair.running.job import Job
from pymeshfair.scripts.guards import Guards


@pytest.mark.parametrize("name", shipped_recipes())
def test_jobs_arrive_as_they_were_sent(name: str) -> None:
    """Pickled and read again, every recipe means the same, and every option is there."""
    sent = Job(load_recipe(name), Path("a"), Path("b"), guards=Guards.parse({"require": "manifold"}), keep_broken=True)
    arrived = pickle.loads(pickle.dumps(sent))
    assert arrived == sent
    assert arrived.recipe.digest == sent.recipe.digest
    assert arrived.recipe.script.path == sent.recipe.script.path


def test_a_worker_that_differs_says_how(tmp_path: Path) -> None:
    """Other versions, another meaning of the recipe, a folder that it does not see, an input of another size: each by itself."""
    recipe = load_recipe("smooth_taubin")
    input, folder = tmp_path / "in.ply", tmp_path / "out"
    input.write_text("12345")
    folder.mkdir()
    with conditions(folder, recipe, [input]) as wanted:
        assert pickle.loads(pickle.dumps(wanted)).unfit() == []
        assert replace(wanted, packages={**wanted.packages, "numba": "0.1"}).unfit()[0].startswith("it has numba ")
        assert replace(wanted, digest="0" * 64).unfit()[0].startswith("it reads the recipe differently")
        unknown = wanted.recipe.replace(b"apply_coord_taubin_smoothing", b"apply_coord_taubin_smoothinX")
        assert "apply_coord_taubin_smoothinX" in replace(wanted, recipe=unknown).unfit()[0]
        assert replace(wanted, token="other").unfit() == [f"it does not see the folder of outputs {folder}"]
        input.write_text("1")
        assert wanted.unfit() == [f"it does not see the input {input}, or sees another file there"]
    assert list(folder.iterdir()) == []
