"""Declarations: what each kind of parameter lets pass, and what contradicts itself."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, Literal, cast

import numpy as np
import pytest

from pymeshfair.declaration import (
    Bool,
    Color,
    Direction,
    Edit,
    Enum,
    FileOpen,
    Filter,
    FilterClass,
    Float,
    Int,
    Layer,
    Length,
    Matrix,
    Mesh,
    MeshElement,
    Parameter,
    Percentage,
    Point,
    Shot,
    String,
    mesh_filter,
    nearest,
)
from pymeshfair.errors import DeclarationError, ParameterError, UnknownNameError
from pymeshfair.registry import custom_filters, find_filter
from pymeshfair.scripts.values import param_attributes, parse_value, read_value

INT = Int(name="n", minimum=1, maximum=9)
FLOAT = Float(name="x", minimum=-1.0, maximum=1.0)
FREE_FLOAT = Float(name="x")
LENGTH = Percentage(name="length")
WORD = Enum(name="word", choices=("uniform", "cotangent"))


@pytest.mark.parametrize(
    ("parameter", "value", "received"),
    [
        (Bool(name="b"), True, True),
        (Bool(name="b"), np.False_, False),
        (INT, 1, 1),
        (INT, 9, 9),
        (INT, np.int64(5), 5),
        (INT, np.uint8(5), 5),
        (Int(name="n"), -(2**31) + 1, -(2**31) + 1),
        (FLOAT, -1, -1.0),
        (FLOAT, np.float32(0.5), 0.5),
        (FLOAT, Fraction(1, 4), 0.25),
        (FREE_FLOAT, 3.4028234663852886e38, 3.4028234663852886e38),
        (FREE_FLOAT, 1e-45, 1e-45),
        (LENGTH, "1%", Length(1.0, "percent")),
        (LENGTH, Length(0.5, "edge"), Length(0.5, "edge")),
        (LENGTH, "0", Length(0.0)),
        (Percentage(name="p", minimum=None), "-2%", Length(-2.0, "percent")),
        (WORD, "uniform", "uniform"),
        (String(name="s"), "", ""),
        (FileOpen(name="f"), "a.png", "a.png"),
        (Mesh(name="m"), np.int32(3), 3),
        (Point(name="p"), np.array([1, 2, 3]), (1.0, 2.0, 3.0)),
        (Direction(name="p"), [0, 0, 1.5], (0.0, 0.0, 1.5)),
        (Color(name="c"), (255, 0.0, 1, 2), (255, 0, 1, 2)),
        (Matrix(name="m"), np.eye(4, dtype=int), tuple(map(tuple, np.eye(4).tolist()))),
    ],
)
def test_allowed_values_arrive_in_the_filters_type(parameter: Parameter, value: Any, received: Any) -> None:
    """A value that is allowed, of Python or numpy, arrives as exactly the Python type that the filter's function receives."""
    checked = parameter.check(value)
    assert checked == received
    assert type(checked) is type(received)


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        (Bool(name="b"), 1),
        (Bool(name="b"), "true"),
        (Bool(name="b"), None),
        (INT, True),
        (INT, np.True_),
        (INT, 1.0),
        (INT, 0),
        (INT, 10),
        (INT, "5"),
        (Int(name="n"), 2**31),
        (FLOAT, True),
        (FLOAT, math.nan),
        (FLOAT, math.inf),
        (FLOAT, np.float64("nan")),
        (FLOAT, 1.0000001),
        (FLOAT, "0.5"),
        (FLOAT, 1j),
        (FREE_FLOAT, 10**400),
        (FREE_FLOAT, 3.5e38),
        (FREE_FLOAT, 1e-46),
        (LENGTH, 5.0),
        (LENGTH, "-1%"),
        (LENGTH, "one"),
        (LENGTH, "1 mm"),
        (LENGTH, Length(1e39)),
        (WORD, "Uniform"),
        (WORD, 0),
        (String(name="s"), b"x"),
        (Mesh(name="m"), -1),
        (Mesh(name="m"), 2**31),
        (Mesh(name="m"), True),
        (Point(name="p"), (1, 2)),
        (Point(name="p"), (1, 2, math.nan)),
        (Point(name="p"), ("1", "2", "3")),
        (Point(name="p"), (True, False, True)),
        (Point(name="p"), ((1, 2), (3,))),
        (Point(name="p"), (1, 2, 10**400)),
        (Color(name="c"), (256, 0, 0, 0)),
        (Color(name="c"), (0.5, 0, 0, 0)),
        (Color(name="c"), (0, 0, 0)),
        (Matrix(name="m"), np.eye(3)),
        (Matrix(name="m"), np.full((4, 4), np.inf)),
        (Shot(name="s"), "anything"),
    ],
)
def test_other_values_are_refused_by_name(parameter: Parameter, value: Any) -> None:
    """A value of another type, outside the bounds or not finite is a ParameterError that names the parameter and the value."""
    with pytest.raises(ParameterError, match=f"parameter '{parameter.name}'|is no length"):
        parameter.check(value)


@pytest.mark.parametrize(
    ("parameter", "number"),
    [
        (Int(name="n", minimum=1, automatic=0), 0),
        (Int(name="n", minimum=0, automatic=-1), np.int64(-1)),
        (Float(name="x", minimum=0, maximum=4, automatic=-1), -1.0),
        (Percentage(name="p", automatic=0), "0"),
        (Percentage(name="p", automatic=0), Length(0.0, "edge")),
        (Percentage(name="p", automatic=-1), Length(-1.0)),
    ],
)
def test_automatic_is_auto_or_its_number(parameter: Parameter, number: Any) -> None:
    """The word and the number are taken in Python, the word on a command line; a script has the number."""
    assert parameter.check("auto") == parse_value(parameter, " auto ") == "auto"
    assert "'auto'" in parameter.describe_allowed()
    assert parameter.check(number) == "auto"
    written = param_attributes(parameter, "auto", diagonal=100.0, mean_edge=1.0)
    assert float(written["value"]) == parameter.automatic
    assert read_value(parameter, written | {"type": parameter.xml_type}, filter_name="") == ("auto", [])


def test_every_automatic_parameter_of_the_plugins_says_so() -> None:
    """No help text says "automatic" by a number; a parameter whose default is automatic shows "auto" as that."""
    for known in custom_filters():
        for parameter in known.parameters:
            assert not re.search(r"-?[01]: (automatic|chosen|estimated|measured|from )", parameter.help), parameter
            if parameter.automatic is not None and parameter.default == "auto":
                assert known.with_defaults({})[parameter.name] == "auto"
                assert known.parameter(parameter.name).to_number("auto") == parameter.automatic


def test_refusals_say_what_is_allowed_and_what_came() -> None:
    """A refusal gives the bounds and the value, cut short when it is long, and a near choice."""
    with pytest.raises(ParameterError, match=r"'n' takes a whole number from 1 to 9, got 10$"):
        INT.check(10)
    with pytest.raises(ParameterError, match=r"'length' takes a length .* of at least 0.0, got -1.0%"):
        LENGTH.check("-1%")
    with pytest.raises(ParameterError, match=r"one of 'uniform', 'cotangent', got 'cotan'; did you mean 'cotangent'\?"):
        WORD.check("cotan")
    with pytest.raises(ParameterError, match=r"got 'zzzz.{60,80}\.\.\.$"):
        INT.check("z" * 1000)
    with pytest.raises(ParameterError, match="single precision"):
        FREE_FLOAT.check(1e39)
    assert Int(minimum=3).describe_allowed() == "a whole number of at least 3"
    assert Float(maximum=3.5).describe_allowed() == "a number of at most 3.5"


@pytest.mark.parametrize(
    ("text", "length"),
    [
        ("0.3", Length(0.3)),
        (" 1 % ", Length(1.0, "percent")),
        ("0.5edge", Length(0.5, "edge")),
        ("6 edges", Length(6.0, "edge")),
        ("+.5e-3", Length(0.0005)),
        ("2.", Length(2.0)),
    ],
)
def test_lengths_are_read_with_their_unit(text: str, length: Length) -> None:
    """A length is read from text, blanks aside, and its own text reads back as the same length."""
    assert Length.parse(text) == length
    assert Length.parse(str(length)) == length


@pytest.mark.parametrize("text", ["", "%", "edge", "mm", "1%%", "1,5%", "nan", "inf", "1e400", "0x10", "1_000", "٣", "1" * 500])
def test_other_texts_are_no_lengths(text: str) -> None:
    """Whatever is not a finite decimal number with one of the units is refused."""
    with pytest.raises(ParameterError):
        Length.parse(text)


def test_a_hostile_length_is_refused_in_linear_time() -> None:
    """A million digits, or blanks, before a wrong letter cost no more than reading them (the pattern does not backtrack)."""
    for text in ("1" * 1_000_000 + "x", "1" + " " * 1_000_000 + "x"):
        with pytest.raises(ParameterError, match=r"\.\.\."):
            Length.parse(text)


def test_lengths_refuse_amounts_and_units_that_are_none() -> None:
    """A length made by hand is as strict as one that is read, and numpy's numbers in it print as Python's."""
    for amount in (math.nan, math.inf, True, "1", 10**400):
        with pytest.raises(ParameterError, match="finite number"):
            Length(amount)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="unit"):
        Length(1.0, "furlong")  # type: ignore[arg-type]
    assert str(Length(np.float64(0.25), "edge")) == "0.25edge"


def test_a_length_asks_for_the_mean_edge_only_when_it_needs_it() -> None:
    """1 % of a diagonal of 50 is 0.5, half an edge of 0.2 is 0.1, and a plain length never looks at the mesh."""

    def no_edges() -> float:
        raise AssertionError("asked for the mean edge")

    assert Length(1.0, "percent").resolve(diagonal=50.0, mean_edge=no_edges) == 0.5
    assert Length(3.0).resolve(diagonal=50.0, mean_edge=no_edges) == 3.0
    assert Length(0.5, "edge").resolve(diagonal=50.0, mean_edge=lambda: 0.2) == 0.1


def test_two_bounds_make_a_slider() -> None:
    """MeshLab's class of a number is RichDynamicFloat exactly when it has both bounds."""
    assert Float(minimum=0.0).xml_type == "RichFloat"
    assert Float(minimum=0.0, maximum=1.0).xml_type == "RichDynamicFloat"


@mesh_filter(name="Test Shift", classes=FilterClass.SMOOTHING, changes=MeshElement.VERTCOORD, references=("taubin1995",))
def apply_coord_test_shift(
    layer: Layer,
    *,
    distance: Annotated[float, Percentage(label="Distance", help="How far.", default="1%")],
    axis: Annotated[Literal["x", "y"], Enum(label="Axis", help="Where to.", choices=("x", "y"))] = "x",
    times: Annotated[int, Int(label="Times", help="How often.", minimum=0, xml_name="Times")] = 2,
    progress: object = None,
) -> Edit:
    """Moves the mesh.

    Along an axis.
    """
    return Edit(vertices=layer.vertices)


def test_a_decorated_function_becomes_a_declaration() -> None:
    """Name, description, parameters, defaults and names in scripts come from the function alone; progress stays hidden."""
    known = apply_coord_test_shift
    assert isinstance(known, Filter)
    assert (known.python_name, known.name, known.summary) == ("apply_coord_test_shift", "Test Shift", "Moves the mesh.")
    assert [p.name for p in known.parameters] == ["distance", "axis", "times"]
    assert [p.xml_name for p in known.parameters] == ["distance", "axis", "Times"]
    assert known.with_defaults({}) == {"distance": Length(1.0, "percent"), "axis": "x", "times": 2}
    assert not known.is_builtin
    assert known.function is not None


@dataclass(frozen=True, kw_only=True)
class Step:
    """Parameters that filters share."""

    size: Annotated[float, Float(label="Size", help="How long.", minimum=0)] = 0.5
    length: Annotated[float, Percentage(label="Length", help="How far.", default="2%")]


def test_fields_of_a_dataclass_are_parameters_in_its_place() -> None:
    """Users see the fields of a shared dataclass as parameters; the function gets the dataclass; progress is still its own."""

    @mesh_filter(name="Grouped", classes=FilterClass.OTHER)
    def grouped(
        layer: Layer,
        *,
        first: Annotated[int, Int(label="First", help="Number.")] = 1,
        step: Step,
        last: Annotated[int, Int(label="Last", help="Number.")] = 9,
        progress: object = None,
    ) -> Edit:
        """Does."""
        return Edit(values={"first": first, "step": step, "last": last, "progress": progress})

    assert [p.name for p in grouped.parameters] == ["first", "size", "length", "last"]
    assert grouped.with_defaults({"size": 1}) == {"first": 1, "size": 1.0, "length": Length(2.0, "percent"), "last": 9}
    assert grouped.function is not None
    edit = grouped.function(cast(Layer, None), first=2, size=0.25, length=3.0, last=4, progress="told")
    assert edit.values == {"first": 2, "step": Step(size=0.25, length=3.0), "last": 4, "progress": "told"}
    assert "progress" in inspect.signature(grouped.function).parameters


def test_the_docstring_has_the_help_of_parameters() -> None:
    """Help is taken from ``Args:`` where the annotation has none; the description is the docstring without that section."""

    @mesh_filter(name="Documented", classes=FilterClass.OTHER)
    def documented(
        layer: Layer,
        *,
        first: Annotated[int, Int()] = 1,
        last: Annotated[int, Int(help="Its own.")] = 9,
    ) -> Edit:
        """Does.

        More.

        Args:
            layer: The mesh.
            first: A number: one of
                several.
            last: Not this.

        Last.
        """
        return Edit()

    assert documented.info == "Does.\n\nMore.\n\nLast."
    assert [p.help for p in documented.parameters] == ["A number: one of several.", "Its own."]


def test_given_values_are_checked_in_declared_order() -> None:
    """Values come back in declared order; absent ones stay absent; an unknown one is named with the nearest that exists."""
    assert list(apply_coord_test_shift.check({"times": 1, "distance": "3%"}).items()) == [
        ("distance", Length(3.0, "percent")),
        ("times", 1),
    ]
    with pytest.raises(UnknownNameError, match="did you mean 'distance'") as caught:
        apply_coord_test_shift.check({"distanse": "1%"})
    assert caught.value.suggestion == "distance"
    with pytest.raises(UnknownNameError, match="it has distance, axis, times"):
        apply_coord_test_shift.check({"q": 1})
    with pytest.raises(UnknownNameError, match="it has none"):
        Filter(python_name="f", name="F").parameter("q")


def _without_docstring(layer: Layer) -> Edit:
    return Edit()


def _without_layer(*, times: Annotated[int, Int(label="a", help="b")] = 1) -> Edit:
    """Does."""
    return Edit()


def _without_annotation(layer: Layer, *, times: int = 1) -> Edit:
    """Does."""
    return Edit()


def _positional(layer: Layer, times: Annotated[int, Int(label="a", help="b")] = 1) -> Edit:
    """Does."""
    return Edit()


def _open_ended(layer: Layer, **values: int) -> Edit:
    """Does."""
    return Edit()


def _without_default(layer: Layer, *, times: Annotated[int, Int(label="a", help="b")]) -> Edit:
    """Does."""
    return Edit()


def _default_outside(layer: Layer, *, times: Annotated[int, Int(label="a", help="b", maximum=3)] = 4) -> Edit:
    """Does."""
    return Edit()


def _bounds_crossed(layer: Layer, *, times: Annotated[int, Int(label="a", help="b", minimum=5, maximum=3)] = 4) -> Edit:
    """Does."""
    return Edit()


def _without_help(layer: Layer, *, times: Annotated[int, Int(label="a")] = 4) -> Edit:
    """Does."""
    return Edit()


def _other_type(layer: Layer, *, times: Annotated[float, Int(label="a", help="b")] = 4) -> Edit:
    """Does."""
    return Edit()


def _without_choices(layer: Layer, *, axis: Annotated[str, Enum(label="a", help="b")] = "x") -> Edit:
    """Does."""
    return Edit()


def _same_name_in_scripts(
    layer: Layer,
    *,
    a: Annotated[int, Int(label="a", help="b")] = 1,
    b: Annotated[int, Int(label="a", help="b", xml_name="a")] = 1,
) -> Edit:
    """Does."""
    return Edit()


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (_without_docstring, "no docstring"),
        (_without_layer, "the layer as its first"),
        (_without_annotation, "annotate 'times'"),
        (_positional, "'times' must be keyword-only"),
        (_open_ended, "'values' must be keyword-only"),
        (_without_default, "the default does not fit: .* got None"),
        (_default_outside, "the default does not fit: .* of at most 3, got 4"),
        (_bounds_crossed, "the minimum 5 above the maximum 3"),
        (_without_help, "needs a help text"),
        (_other_type, "annotated as float, but Int hands over int"),
        (_without_choices, "needs choices"),
        (_same_name_in_scripts, "share a name in scripts"),
    ],
)
def test_contradictions_are_found_where_the_filter_is_defined(function: Callable[..., Edit], reason: str) -> None:
    """A declaration that contradicts itself is an error when its module is imported, and the error names the function."""
    with pytest.raises(DeclarationError, match=reason) as caught:
        mesh_filter(name="X", classes=FilterClass.OTHER)(function)
    assert function.__name__ in str(caught.value)


def test_the_nearest_name_ignores_case_blanks_and_underscores() -> None:
    """Taubin-smooth is near to 'Taubin Smooth'; nothing is near to what resembles nothing."""
    names = ["Taubin Smooth", "Laplacian Smooth", "Dilate Selection"]
    assert nearest("taubin_SMOOTH", names) == "Taubin Smooth"
    assert nearest("Dilate selektion", iter(names)) == "Dilate Selection"
    assert nearest("qqq", names) is None
    assert nearest("", []) is None


def test_layers_are_found_whatever_whole_number_names_them() -> None:
    """A layer given as a whole number of numpy is one of the filter's layers, so that its id is checked and translated."""
    assert find_filter("get_hausdorff_distance").layers({"targetmesh": np.int64(7)}) == {"targetmesh": 7}
