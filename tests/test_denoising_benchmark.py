"""The denoising benchmark on a folder of its own: it runs on any pairs, and says what is wrong with a folder."""

from __future__ import annotations

import json
from pathlib import Path

import denoising
import denoising_choice
import numpy as np
import pytest
from denoising_findings import chest
from denoising_methods import OUR_TRIALS, Method
from denoising_metrics import errors
from denoising_pairs import mesh_set

from pymeshfair.filters.denoising import Setting, automatic_choice, normal_filtering
from pymeshfair.filters.diffusion import taubin_fairing


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One pair, in two formats, with a stray vertex."""
    shape = chest(4)
    for name, vertices in (("box_noisy.ply", shape.noisy), ("box_truth.off", shape.truth)):
        stray = np.concatenate([np.full((1, 3), 5.0), vertices])
        mesh_set((stray, shape.faces + np.int32(1))).save_current_mesh(str(tmp_path / name))
    return tmp_path


def run(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    """The program with these arguments."""
    monkeypatch.setattr("sys.argv", ["denoising.py", *map(str, arguments)])
    return denoising.main()


def test_tables_and_pictures_of_any_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every method has a line in the tables, tuned ones their settings, and every pair a picture."""
    output = folder / "out"
    assert run(monkeypatch, folder, "--methods", "sharp,MeshLab Taubin", "--gallery", "-o", output) == 0
    results = {r["method"]: r for r in json.loads((output / "denoising.json").read_text())}
    assert set(results) == {"noisy", "ours, sharp", "MeshLab Taubin", "MeshLab Taubin, tuned"}
    assert results["ours, sharp"]["errors"]["mad"] < results["noisy"]["errors"]["mad"]
    assert results["MeshLab Taubin, tuned"]["errors"]["mad"] <= results["MeshLab Taubin"]["errors"]["mad"]
    text = (output / "denoising.md").read_text()
    assert "## displacement, edges" in text
    assert "box, MeshLab Taubin, tuned (of 13)" in text
    assert (output / "box.png").stat().st_size > 1000


def test_what_is_missing_is_named(folder: Path) -> None:
    """An unknown pair, a lone noisy mesh and faces in another order end with words."""

    def refused(why: str, *names: str) -> None:
        with pytest.raises(SystemExit, match=why):
            list(denoising.read_pairs(folder, names))

    refused("no ball_noisy file; there are box", "ball")
    shape = chest(4)
    mesh_set((shape.truth, shape.faces[::-1])).save_current_mesh(str(folder / "box_truth.off"))
    refused("the faces of the noisy mesh are not those of the truth")
    (folder / "box_truth.off").unlink()
    refused("no box_truth file")


def test_a_tuned_method_reports_the_best_of_its_trials(folder: Path) -> None:
    """The least MAD of the method's own settings and of all its trials is kept, and the settings that gave it."""
    method = Method("low pass", taubin_fairing, {"iterations": 1}, ({"iterations": 2}, {"iterations": 20}))
    (pair,) = denoising.read_pairs(folder, [])
    result, _ = denoising.measure(method, pair, tuned=True)
    found = {
        settings["iterations"]: errors(taubin_fairing(pair.noisy, pair.faces, **settings), pair.truth, pair.faces).mad
        for settings in (method.settings, *method.trials)
    }
    assert result.errors.mad == min(found.values()) == found[result.settings["iterations"]]
    assert result.trials == 3


def test_every_trial_is_one_that_the_filter_takes() -> None:
    """All settings that are searched are allowed ones, no two are the same, and each denoises the chest."""
    shape = chest(6)
    before = shape.mad(shape.noisy)
    assert len({tuple(sorted(settings.items())) for settings in OUR_TRIALS}) == len(OUR_TRIALS)
    for settings in OUR_TRIALS:
        assert shape.mad(normal_filtering(shape.noisy, shape.faces, **settings)) < before, settings


@pytest.mark.slow
@pytest.mark.parametrize("rule", denoising_choice.rules())
def test_every_rule_of_the_choice_can_be_left_out(rule: str) -> None:
    """The choice finds a setting on the chest without it, and afterwards the method is whole again."""
    shape = chest(6)
    whole = automatic_choice(shape.noisy, shape.faces).setting
    with denoising_choice.left_out([rule]):
        assert automatic_choice(shape.noisy, shape.faces).setting != Setting()
    assert automatic_choice(shape.noisy, shape.faces).setting == whole
