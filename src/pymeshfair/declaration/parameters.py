"""The kinds of parameter that a filter can have, one for each of MeshLab's Rich types."""

from __future__ import annotations

import math
import numbers
import typing
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ParameterError
from .layer import Floats
from .length import Length
from .names import nearest
from .values import as_float, shown


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a filter.

    Attributes:
        name: the Python name, which is also the name in .mlx scripts unless `xml_name` says otherwise.
        label: the words before the input field in a dialog.
        help: the tooltip: what it means, in which unit, and which direction does what.
        default: the value when none is given; None in a built-in filter whose default depends on the mesh.
        advanced: whether a dialog hides it at first.
        xml_name: the name in .mlx scripts, MeshLab's C++ name.
    """

    name: str = ""
    label: str = ""
    help: str = ""
    default: Any = None
    advanced: bool = False
    xml_name: str = ""

    #: the word for the kind of value in messages, e.g. "a whole number"
    kind: typing.ClassVar[str] = "a value"
    #: MeshLab's class of the parameter and the name of that class in .mlx scripts
    rich_type: typing.ClassVar[str] = ""
    xml_type: typing.ClassVar[str] = ""
    #: the type that a filter's function receives
    python_type: typing.ClassVar[Any] = object

    def check(self, value: Any) -> Any:
        """The value in the type that the filter receives; raise `ParameterError` if it is not one the parameter allows."""
        raise NotImplementedError

    def describe_allowed(self) -> str:
        """What is allowed, in words: ``"a whole number of at least 1"``."""
        return self.kind

    def _refuse(self, value: Any) -> ParameterError:
        return ParameterError(
            f"parameter {self.name!r} takes {self.describe_allowed()}, got {value if isinstance(value, Length) else shown(value)}"
        )

    def _refuse_what_meshlab_cannot_hold(self, number: float) -> None:
        # MeshLab's parameters are C floats; it drops a script's number outside their range without a word.
        if number != 0.0 and not 2.0**-150 < abs(number) <= 3.4028234663852886e38:
            raise ParameterError(f"{self._refuse(number)}: MeshLab keeps numbers in single precision, from 1e-45 to 3.4e38")


@dataclass(frozen=True, kw_only=True)
class Bool(Parameter):
    """Yes or no."""

    kind = "True or False"
    rich_type = xml_type = "RichBool"
    python_type = bool

    def check(self, value: Any) -> bool:
        if not isinstance(value, bool | np.bool_):
            raise self._refuse(value)
        return bool(value)


@dataclass(frozen=True, kw_only=True)
class Int(Parameter):
    """A whole number between two bounds, both included."""

    kind = "a whole number"
    rich_type = xml_type = "RichInt"
    python_type = int
    minimum: int | None = None
    maximum: int | None = None

    def check(self, value: Any) -> int:
        if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Integral):
            raise self._refuse(value)
        number = int(value)
        if not (_at_least(number, self.minimum) and _at_most(number, self.maximum)) or abs(number) > 2**31 - 1:
            raise self._refuse(value)
        return number

    def describe_allowed(self) -> str:
        return self.kind + _bounds(self.minimum, self.maximum)


@dataclass(frozen=True, kw_only=True)
class Float(Parameter):
    """A finite number between two bounds, both included. Bounds on both sides make MeshLab show a slider."""

    kind = "a number"
    python_type = float
    minimum: float | None = None
    maximum: float | None = None

    @property
    def rich_type(self) -> str:  # type: ignore[override]
        return "RichFloat" if self.minimum is None or self.maximum is None else "RichDynamicFloat"

    @property
    def xml_type(self) -> str:  # type: ignore[override]
        return self.rich_type

    def check(self, value: Any) -> float:
        number = as_float(value)
        if number is None or not (math.isfinite(number) and _at_least(number, self.minimum) and _at_most(number, self.maximum)):
            raise self._refuse(value)
        self._refuse_what_meshlab_cannot_hold(number)
        return number

    def describe_allowed(self) -> str:
        return self.kind + _bounds(self.minimum, self.maximum)


@dataclass(frozen=True, kw_only=True)
class Percentage(Parameter):
    """A length: the declaration and the caller use `Length`, the filter's function receives mesh units.

    A default may be written as text (``"1%"``, ``"6edge"``). Zero is allowed and means what the help says, usually "not used".

    Attributes:
        of_edges: whether mean edges are those of the layer's polylines even where it has faces, too.
    """

    kind = "a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units)"
    rich_type = "RichPercentage"
    xml_type = "RichAbsPerc"
    python_type = float
    minimum: float | None = 0.0
    of_edges: bool = False

    def check(self, value: Any) -> Length:
        if isinstance(value, str):
            value = Length.parse(value)
        if not isinstance(value, Length) or not _at_least(value.amount, self.minimum):
            raise self._refuse(value)
        self._refuse_what_meshlab_cannot_hold(value.amount)
        return value

    def describe_allowed(self) -> str:
        return self.kind + _bounds(self.minimum, None)


@dataclass(frozen=True, kw_only=True)
class Enum(Parameter):
    """One of several words; in a .mlx script their index."""

    kind = "one of"
    rich_type = xml_type = "RichEnum"
    python_type = str
    choices: tuple[str, ...] = ()

    def check(self, value: Any) -> str:
        if not isinstance(value, str) or value not in self.choices:
            near = nearest(value, self.choices) if isinstance(value, str) else None
            hint = f"; did you mean {near!r}?" if near else ""
            raise ParameterError(f"{self._refuse(value)}{hint}")
        return value

    def describe_allowed(self) -> str:
        return "one of " + ", ".join(map(repr, self.choices))


@dataclass(frozen=True, kw_only=True)
class String(Parameter):
    """Free text."""

    kind = "a text"
    rich_type = xml_type = "RichString"
    python_type = str

    def check(self, value: Any) -> str:
        if not isinstance(value, str):
            raise self._refuse(value)
        return value


@dataclass(frozen=True, kw_only=True)
class Mesh(Parameter):
    """Another layer, by its id in the mesh set."""

    kind = "the id of a layer (a whole number)"
    rich_type = xml_type = "RichMesh"
    python_type = int

    def check(self, value: Any) -> int:
        if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Integral) or not 0 <= int(value) < 2**31:
            raise self._refuse(value)
        return int(value)


@dataclass(frozen=True, kw_only=True)
class Point(Parameter):
    """Three coordinates: a position or a direction."""

    kind = "three finite numbers"
    rich_type = xml_type = "RichPosition"
    python_type = tuple[float, float, float]

    def check(self, value: Any) -> tuple[float, float, float]:
        x, y, z = _numbers(self, value, (3,))
        return float(x), float(y), float(z)


@dataclass(frozen=True, kw_only=True)
class Direction(Point):
    """Three coordinates that MeshLab shows as a direction."""

    rich_type = xml_type = "RichDirection"


@dataclass(frozen=True, kw_only=True)
class Color(Parameter):
    """Red, green, blue and opacity, each from 0 to 255."""

    kind = "four whole numbers from 0 to 255 (red, green, blue, opacity)"
    rich_type = xml_type = "RichColor"
    python_type = tuple[int, int, int, int]

    def check(self, value: Any) -> tuple[int, int, int, int]:
        channels = _numbers(self, value, (4,))
        if any(c != int(c) or not 0 <= c <= 255 for c in channels):
            raise self._refuse(value)
        red, green, blue, alpha = (int(c) for c in channels)
        return red, green, blue, alpha


@dataclass(frozen=True, kw_only=True)
class Matrix(Parameter):
    """A 4 x 4 matrix, row by row."""

    kind = "a 4 x 4 matrix of finite numbers"
    rich_type = "RichMatrix44"
    xml_type = "RichMatrix44f"
    python_type = tuple[tuple[float, ...], ...]

    def check(self, value: Any) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(float(x) for x in row) for row in _numbers(self, value, (4, 4)))


@dataclass(frozen=True, kw_only=True)
class FileOpen(String):
    """The path of a file to read; only MeshLab's built-in filters have one."""

    kind = "the path of a file to read"
    rich_type = "RichFileOpen"
    xml_type = "RichOpenFile"


@dataclass(frozen=True, kw_only=True)
class FileSave(String):
    """The path of a file to write; only MeshLab's built-in filters have one."""

    kind = "the path of a file to write"
    rich_type = "RichFileSave"
    xml_type = "RichSaveFile"


@dataclass(frozen=True, kw_only=True)
class Shot(Parameter):
    """A camera; only MeshLab's built-in filters have one, and no script can say its value."""

    kind = "nothing: a camera cannot be given here"
    rich_type = "RichShot"
    xml_type = "RichShotf"

    def check(self, value: Any) -> Any:
        raise self._refuse(value)


def _at_least(number: float, minimum: float | None) -> bool:
    return minimum is None or number >= minimum


def _at_most(number: float, maximum: float | None) -> bool:
    return maximum is None or number <= maximum


def _bounds(minimum: float | None, maximum: float | None) -> str:
    if minimum is not None and maximum is not None:
        return f" from {minimum} to {maximum}"
    if minimum is not None:
        return f" of at least {minimum}"
    if maximum is not None:
        return f" of at most {maximum}"
    return ""


def _numbers(parameter: Parameter, value: Any, shape: tuple[int, ...]) -> Floats:
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):  # rows of different lengths
        raise parameter._refuse(value) from None
    if array.dtype.kind not in "iuf" or array.shape != shape or not np.isfinite(array).all():
        raise parameter._refuse(value)
    return array.astype(np.float64)
