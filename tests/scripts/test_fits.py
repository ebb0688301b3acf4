"""The conditions with which a recipe says for which scans it is."""

from __future__ import annotations

import math

import pytest

from pymeshfair.errors import ParameterError
from pymeshfair.recipe import TASKS, RecipeHead, load_recipe, shipped_heads
from pymeshfair.scripts import Script
from pymeshfair.scripts.guards import QUANTITIES, WORDS, parse_fits
from pymeshfair.scripts.warnings import script_warnings


@pytest.mark.parametrize(
    ("text", "least", "most"),
    [
        ("noise 0.1 to 0.4 edges", 0.1, 0.4),
        ("noise from .1 edges", 0.1, math.inf),
        ("noise up to 3 edges.", -math.inf, 3.0),
        ("faces up to 2,000,000", -math.inf, 2e6),
        ("border edges from 1", 1.0, math.inf),
    ],
)
def test_a_quantity_has_a_bound_below_above_or_both(text: str, least: float, most: float) -> None:
    """Bounds are read as numbers, thousands with commas; the full stop at the end is none of them."""
    [condition] = parse_fits(text)
    assert (condition.least, condition.most) == (least, most)


def test_conditions_are_met_within_their_bounds_both_included() -> None:
    """A trait on a bound is inside, beyond it outside; one that is not known meets nothing."""
    [condition] = parse_fits("noise 0.1 to 0.4 edges")
    assert [condition.is_met({"noise": n}) for n in (0.09, 0.1, 0.4, 0.41)] == [False, True, True, False]
    assert not condition.is_met({})


@pytest.mark.parametrize("word", WORDS)
def test_every_word_can_be_turned_round(word: str) -> None:
    """With "no" before it, a condition is met by exactly those scans by which it is not met without."""
    [plain], [turned] = parse_fits(word), parse_fits(f"no {word}")
    for value in (0.0, 0.5, 1.0, 7.0):
        traits = {plain.trait: value}
        assert plain.is_met(traits) != turned.is_met(traits)
        assert plain.found(traits) == turned.found(traits) != ""


def test_sharp_and_smooth_leave_no_scan_out() -> None:
    """Every surface is one or the other."""
    sharp, smooth = parse_fits("sharp, smooth")
    assert all(sharp.is_met({"sharpness": s}) or smooth.is_met({"sharpness": s}) for s in (0.0, 0.3, 0.5, 0.68, 0.9, 1.0))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("nois up to 3 edges", "did you mean 'noise'"),
        ("mesh, rangemap", "did you mean 'range map'"),
        ("my dragon", "there are mesh, cloud"),
        ("noise up to 3 mm", "noise is in edges"),
        ("faces up to 3 edges", "faces has no unit"),
        ("noise 3 to 1 edges", "nothing lies between"),
        ("noise", "A quantity has bounds, such as"),
    ],
)
def test_what_is_no_condition_is_refused_with_what_was_meant(text: str, said: str) -> None:
    """The message has the condition and the nearest word, or what is wrong with it."""
    with pytest.raises(ParameterError, match=said):
        parse_fits(text)
    assert any(said in warning for warning in script_warnings(Script((), f"Title\n\nFits: {text}")))


@pytest.mark.parametrize("head", shipped_heads(), ids=lambda head: head.name)
def test_every_shipped_recipe_says_its_task_and_what_it_fits(head: RecipeHead) -> None:
    """The task is one of those that lists are ordered by, and the conditions can be read and name what the recipe takes."""
    assert head.info.task in TASKS
    conditions = parse_fits(head.info.fits)
    assert conditions[0].text in ("mesh", "cloud", "curves")
    assert script_warnings(load_recipe(head.name).script) == []


def test_quantities_and_words_are_different() -> None:
    """No name is both, so that a condition has one meaning."""
    assert not WORDS.keys() & QUANTITIES.keys()
