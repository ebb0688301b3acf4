"""The syntax of expressions: what pymeshlab's own parser accepts is accepted, what it refuses is refused."""

from __future__ import annotations

import random
import re

import pymeshlab
import pytest

from pymeshfair import MeshSet
from pymeshfair.scripts.values import FUNCTIONS, evaluates, is_expression
from tests.scripts.texts import one_filter, problems


@pytest.mark.parametrize(
    "text",
    [
        "q",
        "(q < 0)",
        " x + -y*2^-3 ",
        "x--2",
        "x>0 && y<=1 || z!=3",
        "x ? y : z",
        "x ? 1 : y ? 2 : 3",
        "x>0 ? y>0 ? 1 : 2 : 3",
        "min(1,2,3)+atan2(x,y)*rnd()",
        "sin( x )",
        "my_attribute > 0.5",
        ".5+5.+1e5-1.e-5",
        "_pi*_e",
        "-(-x)",
    ],
)
def test_expressions_in_use_are_accepted(text: str) -> None:
    """Comparisons, signs, choices, functions, constants and the mesh's own attributes have nothing wrong."""
    assert evaluates(text)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "  ",
        "x +",
        "(x",
        "x)",
        "x y",
        "2x",
        "--x",
        "x ** 2",
        "q = 0",
        "x & y",
        "x ? y",
        "x : y",
        "x, y",
        "pow(x,2)",
        "sin x",
        "sin (x)",
        "sin(x,y)",
        "min()",
        "rnd(1)",
        "x;",
        "é",
    ],
)
def test_other_expressions_are_refused(text: str) -> None:
    """Slips of every kind, and two that muParser lets pass."""
    assert not evaluates(text)


@pytest.mark.slow
def test_the_programs_own_parser_agrees() -> None:
    """Of 20,000 random expressions of known names pymeshlab accepts exactly ours, several results (``x, y``) aside."""
    meshes = MeshSet()  # which lets MeshLab go of a mesh set in which a filter has failed; plain ones make later tests die
    meshes.create_cube()
    rng = random.Random(1)
    known = {*FUNCTIONS, "x", "y", "q", "_pi"}
    pieces = [
        "x",
        "y",
        "q",
        "_pi",
        "1",
        ".5",
        "2.",
        "1e3",
        *"+-*/^<?:(),!&%",
        ">=",
        "==",
        "!=",
        "&&",
        "||",
        " ",
        "sin(",
        "min(",
        "atan2(",
        "rnd(",
    ]
    pieces += ["(x", "x)", "x+y", "x>0", "-x", "2x", "1e", "log10(x)", "rnd()", "x?1:2"]
    accepted = compared = 0
    for _ in range(20_000):
        text = "".join(rng.choice(pieces) for _ in range(rng.randint(1, 9)))
        without_numbers = re.sub(r"(?<![A-Za-z_0-9.])[0-9]+\.?[0-9]*([eE][0-9]+)?", "1 ", text)
        if set(re.findall(r"[A-Za-z_]\w*", without_numbers)) - known:
            continue  # run-together names of nothing
        try:
            meshes.apply_filter("compute_selection_by_condition_per_vertex", condselect=text)
            theirs = True
        except pymeshlab.PyMeshLabException:
            theirs = False
        ours = evaluates(text)
        if theirs and not ours and "," in text:
            continue
        assert ours == theirs, text
        compared += 1
        accepted += theirs
    assert compared > 5000
    assert accepted > 500


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_every_function_exists_in_the_program(name: str) -> None:
    """The program evaluates each function with its fewest arguments, and refuses it with one fewer or, if bounded, one more."""
    meshes = MeshSet()
    meshes.create_cube()
    fewest, most = (1, None) if FUNCTIONS[name] == "n" else (int(FUNCTIONS[name]),) * 2
    meshes.apply_filter("compute_selection_by_condition_per_vertex", condselect=f"{name}({','.join('x' * fewest)})")
    for count in {fewest - 1, (most or 0) + 1} - {-1} if most is not None else {0}:
        with pytest.raises(pymeshlab.PyMeshLabException, match="parameters"):
            meshes.apply_filter("compute_selection_by_condition_per_vertex", condselect=f"{name}({','.join('x' * count)})")


def test_expressions_are_checked_where_filters_take_them() -> None:
    """An expression that MeshLab would quietly take for 0 is a problem of the script; a new attribute's name is none."""
    param = '<Param type="RichString" name="{}" value="{}"/>'
    assert "pow" in problems(one_filter("Per Vertex Geometric Function", param.format("x", "pow(x,2)")))[0].message
    assert problems(one_filter("Define New Per Vertex Custom Scalar Attribute", param.format("name", "a b"))) == ()
    assert is_expression("meshing_refine_by_function", "condSelect")
    assert not is_expression("set_mesh_name", "newName")
