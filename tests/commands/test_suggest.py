"""`pymeshfair suggest` makes the automatic parameters of a scan explicit."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.commands.suggest import _behind, _by_evidence, _explicit, _setting_lines, _summary, _trials
from pymeshfair.filters.denoising.automatic import automatic_choice
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import shipped_recipes
from pymeshfair.running.read import read_mesh
from pymeshfair.running.suitability import Trial
from pymeshfair.scripts import parse_script
from pymeshfair.scripts.write import format_script
from tests.meshes import cube, noisy, torus

from .command_line import document, invoke


def _saved(path: Path, mesh: tuple[np.ndarray, np.ndarray]) -> Path:
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*mesh))
    meshes.save_current_mesh(str(path))
    return path


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A torus with noise."""
    return _saved(tmp_path_factory.mktemp("scans") / "torus.ply", noisy(torus(30, 15), 0.08))


@pytest.mark.slow
def test_the_recipe_says_what_automatic_would_do(scan: Path, tmp_path: Path) -> None:
    """The written recipe is a script whose values are those that are found from the arrays."""
    done = invoke("suggest", scan, "-o", tmp_path / "suggested.mlx")
    assert done.exit_code == 0, done.stderr
    (step,) = parse_script((tmp_path / "suggested.mlx").read_bytes(), "suggested.mlx").steps
    assert step.filter.python_name == "apply_coord_normal_filtering"
    setting = automatic_choice(*noisy(torus(30, 15), 0.08)).setting
    chosen = setting.parameters
    assert chosen is not None
    assert step.values["relaxation"] == setting.relaxation
    assert step.values["relaxation_direction"] == setting.relaxation_direction
    for name, value in vars(chosen).items():
        assert step.values[name] == value
    assert "mean edges" in done.stderr


@pytest.mark.slow
def test_families_of_smoothers_are_compared(scan: Path) -> None:
    """Every family has a line and its error, the least first; the document has the same, and one of them is chosen."""
    done = invoke("suggest", scan)
    lines = done.stderr.partition("smoothers, each with")[2].splitlines()[1:]
    told = document(invoke("suggest", scan, "--json").stdout)["found"]["smoothers"]
    assert {"nothing", "normal_filtering", "taubin"} <= {trial["smoother"] for trial in told}
    assert [line.split()[0] for line in lines[: len(told)]] == [f"{e:.4f}" for e in sorted(trial["error"] for trial in told)]
    assert [trial["chosen"] for trial in told].count(True) == 1
    assert all(trial["amount"] > 0 for trial in told if trial["smoother"] in ("taubin", "bilaplacian", "spectral", "implicit"))


@pytest.mark.slow
def test_all_recipes_are_ranked_with_reasons(scan: Path) -> None:
    """A noisy torus is to be denoised; every shipped recipe has its place and its reasons, and lines fit 80 characters."""
    told = document(invoke("suggest", scan, "--json").stdout)
    assert sorted(r["recipe"] for r in told["recipes"]) == list(shipped_recipes())
    first = told["recipes"][0]
    assert first["task"] == "denoise"
    assert any("noise is" in reason["found"] for reason in first["met"])
    assert all(r["met"] if r["fits"] else r["unmet"] for r in told["recipes"])
    fits = [r["fits"] for r in told["recipes"]]
    assert fits == sorted(fits, reverse=True)
    printed = invoke("suggest", scan).stdout.splitlines()
    assert printed[0].split()[:2] == ["1", f"{first['recipe']}:"]
    assert max(map(len, printed)) <= 80


def test_a_cloud_of_points_is_told_its_recipes(tmp_path: Path) -> None:
    """Without faces there is nothing to denoise, and the recipes for clouds come first."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(torus(30, 15)[0]))
    meshes.save_current_mesh(str(tmp_path / "cloud.ply"))
    told = document(invoke("suggest", tmp_path / "cloud.ply", "--json").stdout)
    assert told["found"] is None
    assert told["recipes"][0]["recipe"] == "clean_point_cloud"


@pytest.mark.slow
def test_document_and_file_hold_the_same_recipe(scan: Path, tmp_path: Path) -> None:
    """`--json` holds the estimate and the text that `-o` writes, which is a valid recipe."""
    path = tmp_path / "mine.mlx"
    told = document(invoke("suggest", scan, "--json", "-o", path).stdout)
    assert told["recipe"] == path.read_text(encoding="utf-8")
    assert told["found"]["noise"] > 0.0
    assert invoke("check", path).exit_code == 0


@pytest.mark.parametrize("amount", [0.0, 0.08])
@pytest.mark.slow
def test_the_noise_is_what_info_says_of_the_same_scan(tmp_path: Path, amount: float) -> None:
    """Of a torus with fine waves, with and without noise, both commands name the same level."""
    vertices, faces = torus(60, 30)
    vertices[:, 2] += 0.02 * np.sin(9.0 * vertices[:, 0]) * np.cos(11.0 * vertices[:, 1])
    path = _saved(tmp_path / "torus.ply", noisy((vertices, faces), amount))
    said = re.search(r"noise is about (\S+) mean edges", invoke("info", path).stdout)
    assert said is not None
    assert f" {said[1]} mean edges" in invoke("suggest", path).stderr


def test_a_clean_model_needs_no_recipe(tmp_path: Path) -> None:
    """A cube as it was designed is said to be clean, and nothing is written."""
    path = _saved(tmp_path / "cube.ply", cube())
    done = invoke("suggest", path)
    assert done.exit_code == 0
    assert "denoise: noise is 0 edges" in done.stdout.partition("not for this mesh:")[2]
    assert "no noise" in done.stderr
    assert invoke("suggest", path, "-o", tmp_path / "none.mlx").exit_code != 0
    assert not (tmp_path / "none.mlx").exists()


def test_a_recipe_is_not_written_under_the_name_of_a_mesh(scan: Path) -> None:
    """A slip that would replace a scan by a recipe is refused before anything is read."""
    before = scan.read_bytes()
    assert invoke("suggest", scan, "-o", scan).exit_code != 0
    assert scan.read_bytes() == before


def test_recipes_are_not_tried_where_no_setting_was() -> None:
    """Fused maps get a strong setting without a trial: there is nothing that recipes could be compared with."""
    assert _trials(MeshData(vertices=np.empty((0, 3))), {"mesh": 1.0}, {"shape": "correlated"}, None, None) == {}


@pytest.mark.parametrize("nothing", [0.3, 0.0])
def test_relief_is_no_evidence_where_neighbours_share_their_noise(
    nothing: float, scan: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Waves of that noise pass for relief: what takes them keeps its place, with the error that its own filter was judged by.

    Nothing at all has no error where coordinates are rounded, but the noise.
    """
    tried = {name: Trial(error=0.25, before=0.28, relief=0.4) for name in ("denoise", "smooth_implicit")}
    monkeypatch.setattr("pymeshfair.running.trials.trials", lambda *_, **__: tried)
    values = {"shape": "correlated", "tried": [{"error": nothing, "excess": 0.1}, {"error": 0.2, "excess": 0.0}]}
    found = _trials(read_mesh(scan).mesh, {"mesh": 1.0, "noise": 0.3}, values, None, None)
    assert found["denoise"] == Trial(error=0.2, before=0.3, relief=None)
    assert found["smooth_implicit"] == Trial(error=0.3, before=0.3, relief=None)


@pytest.mark.parametrize(("noise", "outliers", "clean"), [(0.015, "keep", True), (0.015, "only", False), (0.03, "keep", False)])
def test_noise_of_meshing_counts_as_none(noise: float, outliers: str, clean: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Recipes are judged by how little they move below 0.018 edges, but where few vertices are far off."""
    told: dict[str, Any] = {}
    monkeypatch.setattr("pymeshfair.running.trials.trials", lambda *_, **how: told.update(how) or {})
    values = {"shape": "noisy", "outliers": outliers}
    _trials(MeshData(vertices=np.empty((0, 3))), {"mesh": 1.0, "noise": noise}, values, None, None)
    assert told["clean"] is clean


def test_noise_of_impulses_counts_by_what_removing_it_moves() -> None:
    """Most vertices are exact, so that the level is 0; what was tried moved them by 0.07 edges. A clean surface has none."""
    traits = {"noise": 0.0}
    assert _by_evidence(traits, {"shape": "noisy", "drift": 0.07}) == {"noise": 0.07, "camera noise": 0.0}
    assert _by_evidence({"noise": 0.06}, {"shape": "clean", "drift": 0.0})["noise"] == 0.0


def test_ranking_and_summary_name_the_noise_that_info_names() -> None:
    """A mean displacement up to twice the noise is no noise; where it counts as noise in the ranking, the summary says so."""
    values = {"shape": "noisy", "drift": 0.088, "sure": True}
    assert _by_evidence({"noise": 0.07}, values)["noise"] == 0.07
    assert "which counts as the noise" not in _summary(Path("a.ply"), values, 0.07, 0.07)
    said = "moves the vertices by 0.088 mean edges on average, which counts as the noise in the ranking"
    assert said in _summary(Path("a.ply"), values, 0.01, 0.088)


def test_the_printed_command_can_be_pasted_into_a_shell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Names with spaces are quoted, and a name that begins with - is no option."""
    monkeypatch.chdir(tmp_path)
    values = {"shape": "noisy", "outliers": "keep", "drift": 0.1, "sure": True}
    monkeypatch.setattr("pymeshfair.commands.suggest._tried", lambda *_: values)
    monkeypatch.setattr("pymeshfair.commands.suggest._trials", lambda *_: {})
    for name in ("a b.ply", "-d.ply"):
        _saved(tmp_path / name, noisy(torus(12, 6), 0.08))
    told = [invoke("suggest", f"./{name}", "-o", recipe).stderr for name, recipe in (("a b.ply", "r 1.mlx"), ("-d.ply", "r.mlx"))]
    assert "`pymeshfair run 'r 1.mlx' 'a b.ply' -o RESULT`" in " ".join(told[0].split())
    assert "`pymeshfair run r.mlx ./-d.ply -o RESULT`" in " ".join(told[1].split())


def test_a_name_that_xml_cannot_hold_is_escaped_in_the_recipe() -> None:
    """A scan with bytes in its name that are no text, or control characters, gets its recipe, too."""
    recipe = _explicit(Path("a\udcff\x01.ply"), {"shape": "noisy"}, 0.2)
    assert recipe is not None
    assert "scans such as a\\udcff\\x01.ply" in format_script(recipe.script)


def test_settings_for_rounded_coordinates_have_no_standard_errors() -> None:
    """The best is the best, others are behind; where there are standard errors they are told, and which one is chosen."""
    rows = ((0.0, 0.0, False), (0.2, 0.0, False), (0.2, 0.1, False), (0.2, 0.1, True))
    trials = [{"excess": excess, "uncertainty": error, "chosen": chosen} for excess, error, chosen in rows]
    told = ["best", "behind", "2.0 standard errors behind", "2.0 standard errors behind, chosen"]
    assert [_behind(trial) for trial in trials] == told


def test_the_chosen_setting_has_a_line_even_far_behind_the_best() -> None:
    """Where only the tenth setting is flat enough, its line stands beside those of the best and of doing nothing."""
    parts = {"relaxation": 0, "parameters": None, "outliers": "keep", "rounding": "keep", "uncertainty": 0.1}
    tried = [{**parts, "relaxation": k, "error": 1.0, "excess": (20 - k) % 20 / 10, "chosen": k == 5} for k in range(20)]
    lines = _setting_lines({"shape": "noisy", "tried": tried})
    assert [line for line in lines if "chosen" in line] == [
        "  1.0000  5 pairs of Taubin steps (15.0 standard errors behind, chosen)"
    ]
    assert "  1.0000  nothing (best)" in lines
