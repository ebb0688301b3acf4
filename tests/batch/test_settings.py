"""Settings as they go to workers."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from pymeshfair.batch.fitness import probe, unfit_for
from pymeshfair.batch.inputs import Asked
from pymeshfair.batch.plan import plan_scans
from pymeshfair.batch.settings import Settings
from pymeshfair.recipe import load_recipe, shipped_recipes
from pymeshfair.scripts.guards import Guards


@pytest.mark.parametrize("name", shipped_recipes())
def test_settings_arrive_as_they_were_sent(name: str) -> None:
    """Pickled and read again, every recipe means the same, and every option is there."""
    sent = Settings(
        load_recipe(name),
        overrides=("a=b",),
        others=(Path("/x.ply"),),
        overwrite=True,
        timeout=2.0,
        memory=10**9,
        allow_outside=True,
        unchecked=True,
        keep_all=True,
        guards=Guards.parse({"require": "manifold"}),
        keep_broken=True,
        command=("c",),
    )
    arrived = Settings.from_document(pickle.loads(pickle.dumps(sent.to_document())))
    assert arrived == sent
    assert arrived.recipe.digest == sent.recipe.digest
    assert arrived.recipe.script.path == sent.recipe.script.path


def test_a_worker_that_differs_says_how(tmp_path: Path) -> None:
    """Other versions, another meaning of the recipe, a folder that it does not see, an input of another size: each by itself."""
    settings = Settings(load_recipe("smooth_taubin"))
    (tmp_path / "in.ply").write_text("12345")
    (tmp_path / "out").mkdir()
    scans = plan_scans([Asked(tmp_path / "in.ply")], settings.recipe, tmp_path / "out")
    with probe(tmp_path / "out", scans, settings) as asked:
        assert unfit_for(asked) == []
        assert unfit_for({**asked, "packages": {**asked["packages"], "numba": "0.1"}})[0].startswith("it has numba ")
        assert unfit_for({**asked, "recipe": "0" * 64})[0].startswith("the recipe means something else there")
        steps = [("no_such_filter", *asked["settings"]["steps"][0][1:])]
        assert "no_such_filter" in unfit_for({**asked, "settings": {**asked["settings"], "steps": steps}})[0]
        assert unfit_for({**asked, "token": "other"}) == [f"it does not see the folder of outputs {tmp_path / 'out'}"]
        (tmp_path / "in.ply").write_text("1")
        assert unfit_for(asked) == [f"it does not see the input {tmp_path / 'in.ply'}, or sees another file there"]
    assert list((tmp_path / "out").iterdir()) == []
