"""Recipes: found by name or path, described by their head comment, changed value by value."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import pytest

from pymeshfair import recipe as recipe_module
from pymeshfair.declaration import Bool, Color, Enum, Float, Int, Length, Matrix, Mesh, Parameter, Percentage, Point, Shot, String
from pymeshfair.errors import ParameterError, UnknownNameError
from pymeshfair.mlx_scripts import WITHDRAWN
from pymeshfair.recipe import Recipe, RecipeInfo, load_recipe, shipped_recipes
from pymeshfair.scripts import ScriptError, format_script, parse_script
from pymeshfair.scripts.values import parse_value
from pymeshfair.scripts.warnings import script_warnings

TWO_STEPS = """
    <!DOCTYPE FilterScript>
    <!--
    Two ways to smooth

    For: any mesh,
    large or small.

    Note that it shrinks.

    Does: this: and that.

    Tune: lambda.

    For: the second time.
    -->
    <FilterScript>
      <filter name="Remove Duplicate Vertices"/>
      <filter name="Taubin Smooth">
        <Param type="RichFloat" name="lambda" value="0.5"/>
      </filter>
      <filter name="Laplacian Smooth"/>
      <filter name="Remove Isolated pieces (wrt Diameter)"/>
      <filter name="Taubin Smooth"/>
    </FilterScript>
"""


def recipe() -> Recipe:
    """A recipe with five steps, two of the same filter."""
    return Recipe("two_steps", parse_script(textwrap.dedent(TWO_STEPS).strip().encode(), "two_steps.mlx"))


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that stands for the one of the shipped recipes."""
    monkeypatch.setattr(recipe_module, "_scripts", lambda folder=".": {p.stem: p for p in (tmp_path / folder).glob("*.mlx")})
    (tmp_path / "smooth_two_ways.mlx").write_text(textwrap.dedent(TWO_STEPS).strip())
    (tmp_path / "broken.mlx").write_text("<FilterScript><filter name='Taubin Smoth'/></FilterScript>")
    return tmp_path


@pytest.mark.parametrize("name", shipped_recipes())
def test_shipped_recipes_are_whole_and_say_what_they_are_for(name: str) -> None:
    """Every shipped recipe is read without a problem, says title, purpose, doing and tuning, and survives being written."""
    found = load_recipe(name)
    assert found.name == name
    assert found.script.steps
    assert "\n" not in found.title
    info = found.info
    assert min(map(len, (info.title, info.purpose, info.does, info.tune))) > 10
    assert parse_script(format_script(found.script).encode(), name) == found.script.with_defaults()
    for step in found.script.steps:
        left_to_the_mesh = {p.name for p in step.filter.parameters if p.default is None}
        unsaid = {p.name for p in step.filter.parameters} - set(step.values)
        assert not unsaid & left_to_the_mesh, f"{step.filter.name}: say {unsaid & left_to_the_mesh}, or the desktop stops there"


def test_the_recipes_of_the_first_release_are_there() -> None:
    """The five recipes are shipped under their names."""
    assert {"clean_range_map", "clean_point_cloud", "smooth_taubin", "smooth_implicit"} <= set(shipped_recipes())


@pytest.mark.parametrize("name", sorted(WITHDRAWN))
def test_a_withdrawn_recipe_is_answered_with_what_to_take(name: str) -> None:
    """The name is not among those that are shipped, and the error names a recipe that is."""
    assert name not in shipped_recipes()
    with pytest.raises(UnknownNameError, match="is no longer shipped: take") as raised:
        load_recipe(name)
    assert any(repr(other) in str(raised.value) for other in shipped_recipes())


@pytest.mark.parametrize("name", shipped_recipes(superseded=True))
def test_a_superseded_recipe_is_loaded_and_says_what_to_take(name: str) -> None:
    """It is not listed, does what it did, and its head names a recipe that is shipped."""
    assert name not in shipped_recipes()
    found = load_recipe(name)
    assert found.name == name
    assert found.script.steps
    assert any(f"take {other!r}" in found.info.superseded for other in shipped_recipes())
    assert script_warnings(found.script) == [f"superseded: {found.info.superseded}"]


def test_the_head_comment_is_taken_apart() -> None:
    """The first line is the title; paragraphs that begin with For, Does and Tune are taken; others stay as words."""
    assert recipe().info == RecipeInfo(
        title="Two ways to smooth",
        purpose="any mesh, large or small.",
        does="this: and that.",
        tune="lambda.",
    )
    assert recipe().title == "Two ways to smooth"
    assert recipe().description.startswith("For: any mesh,\nlarge or small.")
    bare = Recipe("bare", parse_script(b"<FilterScript><filter name='Box/Cube'/></FilterScript>", "bare.mlx"))
    assert (bare.title, bare.description, bare.info) == ("bare", "", RecipeInfo())


def test_recipes_are_loaded_by_name_or_path(shipped: Path) -> None:
    """A name means the shipped recipe, whatever lies in the folder where one stands; a path means the file."""
    assert load_recipe("smooth_two_ways").name == "smooth_two_ways"
    assert load_recipe("smooth_two_ways").title == "Two ways to smooth"
    for path in (shipped / "smooth_two_ways.mlx", str(shipped / "smooth_two_ways.mlx")):
        assert load_recipe(path) == Recipe("smooth_two_ways", recipe().script)
    (shipped / "noextension").write_bytes((shipped / "smooth_two_ways.mlx").read_bytes())
    assert load_recipe(str(shipped / "noextension")).name == "noextension"


def test_an_unknown_recipe_gets_a_suggestion(shipped: Path) -> None:
    """An unknown name is answered with the nearest and with all that are shipped; a missing path with its reason."""
    with pytest.raises(
        UnknownNameError, match=r"did you mean 'smooth_two_ways'\? \(shipped: broken, smooth_two_ways; a script"
    ) as caught:
        load_recipe("smooth_two_way")
    assert caught.value.suggestion == "smooth_two_ways"
    with pytest.raises(UnknownNameError, match=r"there is no recipe 'q' \(shipped"):
        load_recipe("q")
    with pytest.raises(ScriptError, match=r"missing\.mlx: cannot be read: No such file"):
        load_recipe(str(shipped / "missing.mlx"))
    with pytest.raises(ScriptError, match="did you mean 'Taubin Smooth'"):
        load_recipe("broken")


@pytest.mark.parametrize(
    ("override", "step", "values"),
    [
        ("2.lambda=0.4", 1, {"lambda_": 0.4}),
        ("2.lambda_=0.4", 1, {"lambda_": 0.4}),
        (" 5 . stepSmoothNum = 3 ", 4, {"stepsmoothnum": 3}),
        ("Laplacian Smooth.Selected=yes", 2, {"selected": True}),
        ("apply_coord_laplacian_smoothing.boundary=off", 2, {"boundary": False}),
        ("laplacian.stepsmoothnum=3", 2, {"stepsmoothnum": 3}),
        ("diameter.mincomponentdiag=5%", 3, {"mincomponentdiag": Length(5.0, "percent")}),
        ("Remove Isolated pieces (wrt Diameter).MinComponentDiag=0.3", 3, {"mincomponentdiag": Length(0.3)}),
    ],
)
def test_values_are_put_over_the_recipes_own(override: str, step: int, values: dict[str, Any]) -> None:
    """A step is meant by number, name or part of a name, a parameter by either of its names; everything else stays."""
    before = recipe().script
    after = recipe().override([override]).script
    assert after.steps[step].values == {**before.steps[step].values, **values}
    assert [s for i, s in enumerate(after.steps) if i != step] == [s for i, s in enumerate(before.steps) if i != step]
    assert (after.comment, [s.line for s in after.steps]) == (before.comment, [s.line for s in before.steps])


def test_of_several_values_the_last_wins() -> None:
    """Overrides are taken in order."""
    assert recipe().override(["2.lambda=0.1", "2.mu=-0.2", "2.lambda=0.3"]).script.steps[1].values == {"lambda_": 0.3, "mu": -0.2}
    assert recipe().override([]) == recipe()


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("taubin.lambda=1", "'taubin' fits several steps, 2 (Taubin Smooth), 5 (Taubin Smooth); give the step's number"),
        ("Taubin Smooth.lambda=1", "fits several steps"),
        ("smooth.lambda=1", "fits several steps, 2 (Taubin Smooth), 3 (Laplacian Smooth), 5 (Taubin Smooth)"),
        ("laplacan.x=1", "no step's filter is called 'laplacan'; did you mean 'Laplacian'?"),
        ("qqq.x=1", "no step's filter is called 'qqq'; the script has 1 Remove Duplicate Vertices, 2 Taubin Smooth"),
        ("0.lambda=1", "there is no step 0; the script has 1 Remove"),
        ("6.lambda=1", "there is no step 6"),
        ("2.lamda=1", "filter 'Taubin Smooth' has no parameter 'lamda'; did you mean 'lambda'?"),
        ("2.qqq=1", "has no parameter 'qqq'; it has lambda_, mu, stepsmoothnum, selected"),
        ("1.x=1", "has no parameter 'x'; it has none"),
    ],
)
def test_names_that_fit_nothing_or_too_much_are_explained(override: str, message: str) -> None:
    """An unknown or ambiguous step and an unknown parameter are errors that quote the override and list what there is."""
    with pytest.raises(UnknownNameError) as caught:
        recipe().override([override])
    assert str(caught.value).startswith(f"cannot set {override!r}: ")
    assert message in str(caught.value)


@pytest.mark.parametrize("override", ["", "lambda", "lambda=1", "2.lambda", "=1", ".lambda=1", "2.=1", "2=lambda=1"])
def test_other_forms_are_explained(override: str) -> None:
    """Whatever is not STEP.PARAM=VALUE is an error that shows the form."""
    with pytest.raises(ParameterError, match=r"write STEP\.PARAM=VALUE"):
        recipe().override([override])


@pytest.mark.parametrize(
    "override", ["2.lambda=x", "2.lambda=nan", "2.stepsmoothnum=-1", "2.stepsmoothnum=1.5", "2.selected=maybe"]
)
def test_values_that_do_not_fit_are_explained(override: str) -> None:
    """A value of the wrong kind or beyond the bounds is an error with the override and what the parameter takes."""
    with pytest.raises(ParameterError, match=r"^cannot set '2\..*': parameter '.*' takes "):
        recipe().override([override])


@pytest.mark.parametrize(
    ("parameter", "text", "value"),
    [
        *[(Bool(name="b"), text, True) for text in ("true", "Yes", "ON", "1", " true ")],
        *[(Bool(name="b"), text, False) for text in ("false", "No", "off", "0")],
        (Int(name="i"), " +12 ", 12),
        (Float(name="f"), "1e-3", 0.001),
        (Float(name="f"), "-2", -2.0),
        (Percentage(name="p"), "1.5 %", Length(1.5, "percent")),
        (Percentage(name="p"), "2edge", Length(2.0, "edge")),
        (Percentage(name="p"), "0.1", Length(0.1)),
        (Enum(name="e", choices=("two words", "b")), " two words ", "two words"),
        (String(name="s"), " kept = as is ", " kept = as is "),
        (Mesh(name="m"), "3", 3),
        (Point(name="p"), "1, -2.5,3e2", (1.0, -2.5, 300.0)),
        (Point(name="p"), "1 2 3", (1.0, 2.0, 3.0)),
        (Color(name="c"), "255,128,0", (255, 128, 0, 255)),
        (Color(name="c"), "255,128,0,7", (255, 128, 0, 7)),
        (
            Matrix(name="m"),
            "1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1",
            ((1.0, 0.0, 0.0, 5.0), (0.0, 1.0, 0.0, 6.0), (0.0, 0.0, 1.0, 7.0), (0.0, 0.0, 0.0, 1.0)),
        ),
    ],
)
def test_every_kind_of_value_can_be_said_on_a_command_line(parameter: Parameter, text: str, value: Any) -> None:
    """Each kind has its plain way of being written, blanks aside; text is taken as it is."""
    got = parse_value(parameter, text)
    assert got == value
    assert type(got) is type(value)


@pytest.mark.parametrize(
    ("parameter", "text"),
    [
        (Bool(name="b"), "2"),
        (Int(name="i"), "1_000"),
        (Int(name="i"), "9" * 30),
        (Float(name="f"), "1_0"),
        (Float(name="f"), "0,5"),
        (Percentage(name="p"), "-1%"),
        (Enum(name="e", choices=("a", "b")), "0"),
        (Mesh(name="m"), "-1"),
        (Point(name="p"), "1,2"),
        (Point(name="p"), "1,2,x"),
        (Color(name="c"), "256,0,0"),
        (Color(name="c"), "red"),
        (Matrix(name="m"), "1,2,3"),
        (Shot(name="s"), "x"),
    ],
)
def test_other_texts_are_refused(parameter: Parameter, text: str) -> None:
    """What does not fit is a ParameterError, never another exception."""
    with pytest.raises(ParameterError):
        parse_value(parameter, text)
