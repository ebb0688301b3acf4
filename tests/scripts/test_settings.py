"""Settings and tags: values of a recipe with a name, and steps with one, read, set, written and left alone by MeshLab."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.declaration import Length
from pymeshfair.errors import ParameterError, UnknownNameError
from pymeshfair.recipe import load_recipe, shipped_heads
from pymeshfair.scripts import Script, format_script, parse_script, read_script
from pymeshfair.scripts.changing import override
from pymeshfair.scripts.guards import Guards
from pymeshfair.scripts.script import Setting
from tests.scripts.texts import problems, script

SIZE = '<Param type="RichAbsPerc" name="TargetLen" value="1" min="0" max="100" relative="1%" setting="size"/>'
PIECES = '<Param type="RichAbsPerc" name="MinComponentDiag" value="1" min="0" max="100" relative="1%" setting="size"/>'
ROUNDS = '<Param type="RichInt" name="stepSmoothNum" value="3" setting="rounds"/>'
HEAD = (
    '<setting name="size" default="1%" unit="length" description="How &lt;large&gt;."/>',
    '<setting name="rounds" default="3"/>',
)


def lines(*head: str, size: str = SIZE, rounds: str = ROUNDS) -> bytes:
    """A script whose settings begin in line 3 and are used by two steps and by one."""
    return script(
        *head,
        '<filter name="Remeshing: Isotropic Explicit Remeshing">',
        size,
        "</filter>",
        '<filter name="Remove Isolated pieces (wrt Diameter)">',
        PIECES,
        "</filter>",
        '<filter name="Laplacian Smooth" tag="smooth">',
        rounds,
        "</filter>",
        '<filter name="Taubin Smooth" tag="smooth"/>',
    )


def settled() -> Script:
    """That script, read."""
    return parse_script(lines(*HEAD), "settings.mlx")


def values(found: Script) -> list[Any]:
    """The values of the steps that settings set."""
    remeshing, pieces, smooth, _ = found.steps
    return [remeshing.values["targetlen"], pieces.values["mincomponentdiag"], smooth.values["stepsmoothnum"]]


def test_settings_are_read_and_written() -> None:
    """Name, default, unit, description, tag and use come back as they were; line numbers do not count."""
    found = settled()
    assert found.settings == (Setting("size", "1%", "length", "How <large>."), Setting("rounds", "3"))
    assert [step.settings for step in found.steps] == [
        {"targetlen": "size"},
        {"mincomponentdiag": "size"},
        {"stepsmoothnum": "rounds"},
        {},
    ]
    assert [step.tag for step in found.steps] == ["", "", "smooth", "smooth"]
    text = format_script(found)
    assert parse_script(text.encode(), "again") == found.with_defaults()
    assert format_script(parse_script(text.encode(), "again")) == text


def test_a_setting_is_set_in_every_step_that_uses_it() -> None:
    """NAME=VALUE changes both lengths and the default, so that the script written again is consistent."""
    found = override(settled(), ["size=2edge", "rounds = 7"])
    assert values(found) == [Length(2.0, "edge"), Length(2.0, "edge"), 7]
    assert [setting.default for setting in found.settings] == ["2edge", "7"]
    assert parse_script(format_script(found).encode(), "again").settings == found.settings


def test_a_step_that_is_set_by_itself_leaves_its_setting() -> None:
    """STEP.PARAM=VALUE goes over the setting from then on; a setting that nothing uses any more is gone."""
    found = override(settled(), ["isotropic.targetlen=5%", "size=3%", "3.stepSmoothNum=9"])
    assert values(found) == [Length(5.0, "percent"), Length(3.0, "percent"), 9]
    assert [setting.name for setting in found.settings] == ["size"]
    with pytest.raises(ParameterError, match="NAME=VALUE for a setting"):
        override(found, ["rounds"])
    assert override(settled(), ["3.stepSmoothNum=3"]) == settled()


def test_what_is_set_for_a_step_goes_over_its_setting_in_any_order() -> None:
    """A setting that comes later is not unknown, and it does not change the step, even where the step is given the default."""
    texts = ["3.stepsmoothnum=3", "rounds=7", "isotropic.targetlen=1%", "size=5%"]
    found = override(settled(), texts)
    assert found == override(settled(), texts[::-1])
    assert values(found) == [Length(1.0, "percent"), Length(5.0, "percent"), 3]
    assert [setting.name for setting in found.settings] == ["size"]


def test_a_tag_means_all_its_steps() -> None:
    """TAG.PARAM=VALUE sets the parameter in every step of the tag that has it."""
    found = override(settled(), ["smooth.stepsmoothnum=4", "smooth.mu=-0.6"])
    assert [dict(step.values) for step in found.steps[2:]] == [{"stepsmoothnum": 4}, {"mu": -0.6, "stepsmoothnum": 4}]
    with pytest.raises(UnknownNameError, match=r"cannot set 'smooth.nu=1': .*has no parameter 'nu'"):
        override(settled(), ["smooth.nu=1"])


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("sizes=1%", UnknownNameError, r"cannot set 'sizes=1%': the recipe has no setting 'sizes'; did you mean 'size'\?"),
        ("q=1%", UnknownNameError, "it has size, rounds"),
        ("size=big", ParameterError, "cannot set 'size=big': "),
        ("rounds=1.5", ParameterError, "cannot set 'rounds=1.5': .*whole number"),
        ("=3", ParameterError, r"write NAME=VALUE for a setting \(size, rounds\) or STEP.PARAM=VALUE"),
        (".x=3", ParameterError, "write NAME=VALUE"),
    ],
)
def test_a_wrong_setting_is_refused(text: str, error: type[Exception], message: str) -> None:
    """The error says what was written, what is wrong with it and what there is."""
    with pytest.raises(error, match=message):
        override(settled(), [text])


@pytest.mark.parametrize(
    ("data", "line", "message"),
    [
        (lines(*HEAD, HEAD[0]), 5, "'size' is declared twice"),
        (lines(*HEAD, '<setting name="third" default="1"/>'), 5, "no step uses the setting 'third'"),
        (lines(HEAD[0]), 10, "no setting of that name"),
        (lines(HEAD[0].replace("1%", "2%"), HEAD[1]), 5, "is 1.0%, but the default of its setting 'size' is 2%"),
        (lines(HEAD[0].replace("1%", "huge"), HEAD[1]), 5, "cannot take the default 'huge' of the setting 'size'"),
        (lines(*HEAD, '<setting default="1"/>'), 5, "<setting> has no name"),
        (lines(*HEAD, '<setting name="a b" default="1"/>'), 5, "letters, digits and underscores"),
        (lines(*HEAD, '<setting name="a" value="1" default=""/>'), 5, "no attribute 'value'"),
        (lines(*HEAD, '<setting name="a" default="1"><Param/></setting>'), 5, "the element <Param> is unknown here"),
        (lines(*HEAD).replace(b'"smooth"', b'"a.b"', 1), 11, "the tag 'a.b' must consist of letters"),
    ],
)
def test_what_is_wrong_with_settings_is_said(data: bytes, line: int, message: str) -> None:
    """A setting that is not whole, not used, not there or not the value of its step is a problem at its line."""
    found = problems(data)
    assert found[0].line == line
    assert message in found[0].message


def by_meshlab(text: str, path: Path) -> Any:
    """The vertices of a sphere after plain pymeshlab has run a script."""
    path.write_text(text, encoding="utf-8")
    meshes = pymeshlab.MeshSet()
    meshes.create_sphere(subdiv=2)
    meshes.load_filter_script(str(path))
    meshes.apply_filter_script()
    return meshes.current_mesh().vertex_matrix()


def test_meshlab_runs_the_defaults(tmp_path: Path) -> None:
    """Plain pymeshlab takes a script with settings and tags for the same script without."""
    text = format_script(settled(), diagonal=10.0)
    plain = re.sub(r'<setting .*?/>| (setting|tag)="\w+"', "", text)
    assert plain.count("\n") == text.count("\n")
    assert "setting" not in plain
    found = by_meshlab(text, tmp_path / "settings.mlx")
    assert len(found) > 100
    np.testing.assert_array_equal(found, by_meshlab(plain, tmp_path / "plain.mlx"))


def test_an_expression_is_checked_when_it_is_set() -> None:
    """One that MeshLab cannot evaluate, and would take for 0, is refused; blanks around a text do not count."""
    condition = '<Param type="RichString" name="condSelect" value="x > 0" setting="where"/>'
    step = ('<filter name="Conditional Vertex Selection">', condition, "</filter>")
    found = parse_script(script('<setting name="where" default="x > 0"/>', *step), "x")
    assert override(found, ["where= y > 1 "]).steps[0].values == {"condselect": "y > 1"}
    for text in ("where=y >", "1.condSelect=y >"):
        with pytest.raises(ParameterError, match="is no expression that MeshLab can evaluate"):
            override(found, [text])


def test_a_mesh_set_keeps_the_settings_of_its_script(tmp_path: Path) -> None:
    """What was loaded is saved with its settings and tags, and applied with the values of the defaults."""
    first, again = tmp_path / "first.mlx", tmp_path / "again.mlx"
    first.write_text(format_script(settled()), encoding="utf-8")
    meshes = MeshSet()
    meshes.create_sphere(subdiv=2)
    meshes.load_filter_script(str(first))
    meshes.save_filter_script(str(again))
    assert read_script(again) == read_script(first)
    meshes.clear_filter_script()
    meshes.meshing_remove_duplicate_vertices()
    meshes.save_filter_script(str(again))
    assert read_script(again).settings == ()


def test_a_mesh_set_keeps_head_limits_and_unit_of_its_script(tmp_path: Path) -> None:
    """What was loaded is saved with its head comment, its limits and the unit of its scans."""
    first, again = tmp_path / "first.mlx", tmp_path / "again.mlx"
    limits = Guards.parse({"max_displacement": "0.05mm"})
    whole = replace(settled(), comment="Title\n\nFor: scans", guards=limits, unit="mm")
    first.write_text(format_script(whole), encoding="utf-8")
    meshes = MeshSet()
    meshes.create_sphere(subdiv=2)
    meshes.load_filter_script(str(first))
    meshes.save_filter_script(str(again))
    assert read_script(again) == read_script(first)


def test_shipped_settings_say_what_they_do() -> None:
    """At least three recipes have settings; each has a unit and a description, and the head tells what loading tells."""
    heads = [head for head in shipped_heads() if head.settings]
    assert len(heads) >= 3
    for head in heads:
        assert head.settings == load_recipe(head.name).script.settings
        assert all(setting.unit and len(setting.description) > 10 for setting in head.settings)
