"""Small scripts to read, and a filter with a parameter of every kind that a filter of ours can have."""

from __future__ import annotations

from typing import Annotated

from pymeshfair.declaration import (
    Bool,
    Color,
    Direction,
    Edit,
    Enum,
    FilterClass,
    Float,
    Int,
    Layer,
    Matrix,
    Mesh,
    Percentage,
    Point,
    String,
    mesh_filter,
)
from pymeshfair.scripts import Problem, ScriptError, Step, parse_script

Row = tuple[float, ...]


@mesh_filter(name="Every Kind", classes=FilterClass.OTHER)
def apply_coord_every_kind(
    layer: Layer,
    *,
    flag: Annotated[bool, Bool(label="a", help="b")] = True,
    count: Annotated[int, Int(label="a", help="b", minimum=-3, maximum=12)] = 2,
    share: Annotated[float, Float(label="a", help="b", minimum=0.0, maximum=1.0)] = 0.5,
    number: Annotated[float, Float(label="a", help="b")] = 1e-5,
    size: Annotated[float, Percentage(label="a", help="b", default="1%")],
    offset: Annotated[float, Percentage(label="a", help="b", default="0", minimum=None)],
    word: Annotated[str, Enum(label="a", help="b", choices=("one", 'two "2" <&>', "drei"))] = "one",
    text: Annotated[str, String(label="a", help="b")] = "",
    layer_id: Annotated[int, Mesh(label="a", help="b", xml_name="LayerId")] = 0,
    place: Annotated[tuple[float, float, float], Point(label="a", help="b")] = (0.0, 0.0, 0.0),
    axis: Annotated[tuple[float, float, float], Direction(label="a", help="b")] = (0.0, 0.0, 1.0),
    tint: Annotated[tuple[int, int, int, int], Color(label="a", help="b")] = (0, 0, 0, 255),
    matrix: Annotated[tuple[Row, ...], Matrix(label="a", help="b")] = (
        (1.0, 0.0, 0.0, 0.0),
        (0.0, 1.0, 0.0, 0.0),
        (0.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 0.0, 1.0),
    ),
) -> Edit:
    """Does nothing with a parameter of every kind."""
    return Edit()


def script(*lines: str) -> bytes:
    """A script with these lines in it, the first of them on line 3."""
    return "\n".join(["<!DOCTYPE FilterScript>", "<FilterScript>", *lines, "</FilterScript>", ""]).encode()


def one_filter(name: str, *params: str) -> bytes:
    """A script of one filter, on line 3, with these ``<Param>`` elements or other lines from line 4 on."""
    return script(f'<filter name="{name}">', *params, "</filter>")


def taubin(*params: str) -> bytes:
    """A script of MeshLab's Taubin Smooth."""
    return one_filter("Taubin Smooth", *params)


def step(data: bytes) -> Step:
    """The only step of a script that has nothing wrong."""
    (only,) = parse_script(data, "test.mlx").steps
    return only


def problems(data: bytes) -> tuple[Problem, ...]:
    """What is wrong with a script; nothing at all if it can be read."""
    try:
        parse_script(data, "test.mlx")
    except ScriptError as error:
        return error.problems
    return ()
