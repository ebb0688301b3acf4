"""Which recipes a scan is for, and what a run says that is outside of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from numpy.typing import NDArray

from pymeshfair.errors import RunError
from pymeshfair.filters.geometry import mean_edge_length
from pymeshfair.filters.traits import measured_traits
from pymeshfair.mesh_data import MeshData
from pymeshfair.recipe import Recipe, RecipeHead, head_info, load_recipe
from pymeshfair.running.job import Job
from pymeshfair.running.measuring import measure
from pymeshfair.running.suitability import Trial, needed, ranked, traits_of, unsuitable
from pymeshfair.running.supervise import run_job
from pymeshfair.running.trials import trials
from pymeshfair.scripts.guards import parse_fits
from pymeshfair.scripts.script import Script
from tests.meshes import icosphere


def head(name: str, fits: str, task: str = "denoise") -> RecipeHead:
    """A recipe that says nothing but this."""
    return RecipeHead(name, head_info(f"Title\n\nTask: {task}\n\nFits: {fits}"), (), 1)


HEADS = [head("all", "mesh"), head("some", "mesh, noise from 0.1 edges"), head("few", "mesh, sharp, noise 0.1 to 0.4 edges")]


def test_the_recipe_that_is_made_for_most_of_the_scan_comes_first() -> None:
    """Of recipes that fit the one with the most conditions leads; those that do not fit come last."""
    sharp = {"mesh": 1.0, "noise": 0.2, "sharpness": 0.9}
    assert [s.recipe for s in ranked(sharp, HEADS)] == ["few", "some", "all"]
    strong = sharp | {"noise": 0.7}
    assert [s.recipe for s in ranked(strong, HEADS) if s.fits] == ["some", "all"]
    assert [s.recipe for s in ranked({"mesh": 0.0, "cloud": 1.0}, HEADS) if s.fits] == []


def test_openings_are_not_closed_unasked() -> None:
    """Of recipes that are as good those come last that would close a clean scan; where nothing is open they lead."""
    heads = [head("smooths", "mesh", task="smooth"), head("closes", "mesh, noise up to 0.04 edges", task="prepare")]
    moves_nothing = {"smooths": Trial(error=0.0, before=0.0, relief=None)}
    for borders, order in ((12.0, ["smooths", "closes"]), (0.0, ["closes", "smooths"])):
        traits = {"mesh": 1.0, "noise": 0.0, "border edges": borders}
        assert [s.recipe for s in ranked(traits, heads, moves_nothing)] == order


def test_what_cannot_be_told_apart_is_ordered_by_what_it_is_made_for() -> None:
    """Of two that held-out vertices do not tell apart the one with more conditions leads, though its error is larger."""
    traits = {"mesh": 1.0, "noise": 0.2, "sharpness": 0.9}
    tried = {
        "all": Trial(error=0.186, before=0.196, relief=None, tied=True),
        "few": Trial(error=0.187, before=0.196, relief=None, tied=True),
        "some": Trial(error=0.188, before=0.196, relief=None),
    }
    assert [s.recipe for s in ranked(traits, HEADS, tried)] == ["few", "all", "some"]


def test_a_new_surface_is_not_made_unasked() -> None:
    """A recipe that makes the surface anew comes behind others, however many conditions it sets that the scan meets."""
    heads = [head("anew", "mesh, noise up to 0.04 edges", task="remesh"), head("keeps", "mesh", task="prepare")]
    assert [s.recipe for s in ranked({"mesh": 1.0, "noise": 0.0, "border edges": 0.0}, heads)] == ["keeps", "anew"]


def test_what_was_tried_leads_by_its_error_and_what_erases_detail_comes_last() -> None:
    """The least error comes first, a recipe that moves nothing before one that is worse, and relief lost behind all."""
    traits = {"mesh": 1.0, "noise": 0.2, "sharpness": 0.9}
    good, worse = Trial(error=0.1, before=0.2, relief=0.02), Trial(error=0.3, before=0.2, relief=0.0)
    assert [s.recipe for s in ranked(traits, HEADS, {"few": worse, "all": good})] == ["all", "some", "few"]
    erasing = Trial(error=0.05, before=0.2, relief=0.4)
    found = ranked(traits, HEADS, {"few": erasing, "all": good})
    assert [s.recipe for s in found] == ["all", "some", "few"]
    assert found[-1].trial == erasing
    assert "would take 40% of the relief" in erasing.words


def test_the_least_error_leads_however_near_the_next_is() -> None:
    """Noise of the held-out vertices hides most of what errors differ by: a hundredth less is the better recipe."""
    traits = {"mesh": 1.0, "noise": 0.2, "sharpness": 0.9}
    best, next_best = Trial(error=0.186, before=0.196, relief=None), Trial(error=0.1876, before=0.196, relief=None)
    assert ranked(traits, HEADS, {"all": best, "few": next_best})[0].recipe == "all"


@pytest.mark.slow
def test_a_recipe_that_erases_bumps_is_seen_on_a_clean_scan() -> None:
    """Of a ball with bumps of ten edges a heavy smoothing takes a third of the relief and more, a light one hardly any."""
    vertices, faces = icosphere(4)
    x, y, z = 9.0 * vertices.T
    bumps = vertices * (1.0 + 0.02 * np.sin(x) * np.sin(y) * np.cos(z))[:, None]
    implicit = load_recipe("smooth_implicit").script.steps[0]
    scripts = {size: Script((implicit.with_values({"detail_size": size}),)) for size in ("3edge", "12edge")}
    found = trials(bumps, faces, scripts, clean=True)
    assert found["12edge"].erases
    assert (found["12edge"].relief or 0.0) > 1.0 / 3.0
    assert not found["3edge"].erases
    assert found["3edge"].before == 0.0


def test_a_detail_size_beside_a_time_step_is_not_filled_in() -> None:
    """A step of Implicit Fairing with a time step chooses no detail size, even where "auto" is written, and is tried as it is."""
    implicit = load_recipe("smooth_implicit").script.steps[0].with_values({"detail_size": "auto", "time_step": 1.0})
    assert list(trials(*icosphere(2), {"step": Script((implicit,))}, clean=True)) == ["step"]


def test_a_scan_outside_of_a_recipe_is_told_the_one_to_take() -> None:
    """The warning has the condition, what was found, and the best recipe for the same task."""
    traits = {"mesh": 1.0, "noise": 0.7, "sharpness": 0.9}
    text = unsuitable("few", HEADS[2].info, traits, ranked(traits, HEADS))
    assert text == "few is for noise 0.1 to 0.4 edges, and here noise is 0.7 edges: take some"
    assert unsuitable("some", HEADS[1].info, traits, ranked(traits, HEADS)) is None
    text = unsuitable("whole", head("whole", "mesh, no range map").info, traits | {"facing": 0.9}, [])
    assert "whole is for scans that are no range maps, and here the surface is seen from one side" in str(text)


def test_where_no_recipe_for_the_task_fits_none_is_made_up() -> None:
    """A clean scan is sent to `suggest`."""
    traits = {"mesh": 1.0, "noise": 0.0, "sharpness": 0.9}
    text = unsuitable("few", HEADS[2].info, traits, ranked(traits, HEADS))
    assert text is not None
    assert "suggest" in text
    assert "take" not in text.partition(":")[2].partition("take away")[0]


def test_a_recipe_for_clean_scans_sends_noisy_ones_to_denoising_first() -> None:
    """Where noise alone is in the way, the recipe that takes it off comes before, and does not replace what was wanted."""
    printing = head("print", "mesh, noise up to 0.04 edges", task="prepare")
    traits = {"mesh": 1.0, "noise": 0.2, "sharpness": 0.1}
    text = unsuitable("print", printing.info, traits, ranked(traits, [*HEADS, printing]))
    assert text == "print is for noise up to 0.04 edges, and here noise is 0.2 edges: run some first"


def test_a_recipe_that_has_nothing_to_do_is_not_replaced() -> None:
    """Nothing is open, the triangles are good, there is no noise: nothing else is advised; noise comes before triangles."""
    noisy = head("all", "mesh, noise from 0.04 edges")

    def said(fits: str, task: str, **traits: float) -> str:
        info = head("this", fits, task=task).info
        return (
            unsuitable("this", info, {"mesh": 1.0, "noise": 0.0} | traits, ranked({"mesh": 1.0} | traits, [noisy])) or ""
        ).partition(": ")[2]

    assert said("mesh, open", "repair", **{"border edges": 0.0}) == "there is nothing to close"
    good = {"triangle quality": 0.9}
    assert said("mesh, triangle quality up to 0.8", "prepare", **good) == "the triangles are good as they are"
    assert said("mesh, no sharp", "smooth", sharpness=0.9) == "it needs no smoothing"
    simulation = "mesh, noise up to 0.04 edges, triangle quality up to 0.8"
    assert said(simulation, "prepare", noise=0.2, **good) == "run all first"
    assert said("mesh, open, texture", "clean", texture=0.0, **{"border edges": 0.0}).startswith("no other recipe replaces it")


def test_what_is_judged_by_another_measure_is_no_substitute() -> None:
    """A filter of waves of a given size does not stand in for one of noise, though it smooths too."""
    waves = RecipeHead("waves", head_info("Title\n\nTask: smooth\n\nFits: mesh, smooth\n\nJudged: waves"), (), 1)
    normals = RecipeHead("few", head_info("Title\n\nTask: denoise\n\nFits: mesh, sharp\n\nJudged: normals"), (), 1)
    traits = {"mesh": 1.0, "sharpness": 0.1}
    text = unsuitable("few", normals.info, traits, ranked(traits, [normals, waves]))
    assert text is not None
    assert "take waves" not in text


def test_a_mesh_of_even_edges_but_one() -> None:
    """Four edges of length 1, and one of 2: the longest has 2 / 1.2 mean edges."""
    lozenge: NDArray[np.float64] = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    lozenge[2:, 1] = [1e-9, -1e-9]
    found = measured_traits(lozenge, np.array([[0, 1, 2], [1, 0, 3]]), ["longest edge"])
    assert found == {"longest edge": pytest.approx(2.0 / 1.2)}


def test_only_what_conditions_ask_for_is_measured() -> None:
    """A recipe for meshes with borders needs no look at the surface."""
    assert needed(parse_fits("mesh, open, faces up to 9")) == set()
    assert needed(parse_fits("mesh, noise up to 1 edges, sharp")) == {"noise", "sharpness"}


def test_clouds_and_curves_have_traits_without_a_surface() -> None:
    """What has no faces is a cloud, or curves if it has edges."""
    points, none = np.random.default_rng(0).normal(size=(9, 3)), np.zeros((0, 3), dtype=np.int32)
    cloud = traits_of(measure(MeshData(vertices=points, faces=none)))
    curves = traits_of(measure(MeshData(vertices=points, faces=none, edges=np.array([[0, 1]], dtype=np.int32))))
    assert (cloud["mesh"], cloud["cloud"], cloud["curves"]) == (0.0, 1.0, 0.0)
    assert (curves["mesh"], curves["cloud"], curves["curves"]) == (0.0, 0.0, 1.0)
    assert "noise" not in cloud


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "level", "asked", "told"),
    [
        ("smooth_taubin", 0.15, (), "denoise mostly keeps more"),
        ("smooth_taubin", 0.7, (), "take denoise"),
        ("smooth_implicit", 0.15, (), "denoise mostly keeps more"),
        ("smooth_implicit", 0.15, ("detail_size=6edge",), ""),
        ("smooth_implicit", 0.0, (), ""),
        ("denoise", 0.15, (), ""),
    ],
)
def test_a_run_on_noise_names_the_better_recipe(
    name: str, level: float, asked: tuple[str, ...], told: str, tmp_path: Path
) -> None:
    """What is not made for noise, or not for so much, names denoise, unless it was set which waves are to go."""
    vertices, faces = icosphere(4)
    heights = np.random.default_rng(1).normal(scale=level * mean_edge_length(vertices, faces), size=(len(vertices), 1))
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices * (1.0 + heights), faces))
    meshes.save_current_mesh(str(tmp_path / "ball.ply"))
    result = run_job(Job(load_recipe(name), tmp_path / "ball.ply", tmp_path / "out.ply", overrides=asked))
    assert [told in text for text in result.warnings if "denoise" in text] == [True] * bool(told)
    assert ('"noise"' in result.provenance.read_text("utf-8")) != bool(asked)


@pytest.mark.parametrize("measures", [True, False])
def test_a_recipe_for_meshes_refuses_a_cloud_before_the_first_step(tmp_path: Path, measures: bool) -> None:
    """Clean_range_map names what it is for and a recipe that fits, with measures or without, not MeshLab's words at step 5."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(icosphere(2)[0]))
    meshes.save_current_mesh(str(tmp_path / "cloud.ply"))
    with pytest.raises(
        RunError, match=r"^clean_range_map is for meshes, and here there are no faces: .*such as clean_point_cloud"
    ):
        run_job(Job(load_recipe("clean_range_map"), tmp_path / "cloud.ply", tmp_path / "out.ply", measures=measures))
    assert not (tmp_path / "out.ply").exists()


@pytest.mark.parametrize(
    ("task", "asked", "warned"),
    [
        ("denoise", ("a=12edge",), True),
        ("clean", (), True),
        ("smooth", (), True),
        ("smooth", ("a=12edge",), False),
        ("repair", (), False),
    ],
)
def test_a_run_that_takes_relief_warns(task: str, asked: tuple[str, ...], warned: bool, tmp_path: Path) -> None:
    """Bumps of ten edges that a filter of 12 edges takes are detail, unless one that smooths was set to that.

    The warning names another recipe, which moves nothing where there is no noise.
    """
    vertices, faces = icosphere(4)
    x, y, z = 9.0 * vertices.T
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices * (1.0 + 0.02 * np.sin(x) * np.sin(y) * np.cos(z))[:, None], faces))
    meshes.save_current_mesh(str(tmp_path / "bumps.ply"))
    step = load_recipe("smooth_implicit").script.steps[0].with_values({"detail_size": "12edge"})
    recipe = Recipe("own", Script((step,), f"Own\n\nTask: {task}"))
    result = run_job(Job(recipe, tmp_path / "bumps.ply", tmp_path / "out.ply", overrides=asked))
    told = [text for text in result.warnings if "of the relief apart from noise is gone" in text]
    assert bool(told) == warned
    assert all("a smaller value of detail_size, or take smooth_implicit, or leave the scan as it is" in text for text in told)


def test_a_run_of_a_superseded_recipe_says_what_to_take(tmp_path: Path) -> None:
    """It is carried out, and the warning repeats the words of the head."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(*icosphere(2)))
    meshes.save_current_mesh(str(tmp_path / "ball.ply"))
    recipe = load_recipe("smooth_laplacian")
    result = run_job(Job(recipe, tmp_path / "ball.ply", tmp_path / "out.ply"))
    assert f"smooth_laplacian is superseded: {recipe.info.superseded}" in result.warnings
    assert (tmp_path / "out.ply").exists()
