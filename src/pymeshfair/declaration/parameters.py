"""The kinds of parameters: switches, numbers, lengths, words, texts, layers and cameras; points, colours and matrices."""

from __future__ import annotations

import math
import numbers
import re
import typing
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, cast

import numpy as np

from ..errors import ParameterError, nearest, shortened

AUTO = "auto"  # the word for a value that the filter chooses for the mesh
LengthUnit: TypeAlias = Literal["absolute", "percent", "edge", "mm", "cm", "m", "in", "ft", "um"]
METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254, "ft": 0.3048, "um": 1e-6}  # the units that a scan may have, in metres
_LENGTH_SUFFIX = {"absolute": "", "percent": "%", "edge": "edge"} | {unit: unit for unit in METRES}
_LENGTH = re.compile(rf"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(%|edges?|{'|'.join(METRES)})?")


def as_float(value: Any) -> float | None:
    """Converts a real number of Python or numpy to float; None for other values and for booleans."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


@dataclass(frozen=True)
class Length:
    """A length in mesh units, in percent of the bounding box diagonal, in mean edges, or in a unit of `METRES`.

    Written as ``"0.3"``, ``"1%"`` or ``"0.5edge"``. The mean edge of a point cloud is the mean distance to the nearest neighbour.
    Parameters of filters take no unit such as mm; limits of a run, and tolerances, may have one: ``"0.05mm"``.
    """

    amount: float
    unit: LengthUnit = "absolute"

    def __post_init__(self) -> None:
        amount = as_float(self.amount)
        if amount is None or not math.isfinite(amount):
            raise ParameterError(f"the amount of a length must be a finite number, got {shortened(repr(self.amount))}")
        if self.unit not in _LENGTH_SUFFIX:
            raise ParameterError(
                f"the unit of a length is one of {', '.join(map(repr, _LENGTH_SUFFIX))}, got {shortened(repr(self.unit))}"
            )
        object.__setattr__(self, "amount", amount)  # a float: numpy numbers have another repr

    @classmethod
    def parse(cls, text: str, name: str = "") -> Length:
        """Parses ``"0.3"``, ``"1%"``, ``"0.5edge"`` or ``"0.05mm"``; `name` begins the `ParameterError` for other texts."""
        match = _LENGTH.fullmatch(text.strip()) if len(text) <= 400 else None
        if match is None or not math.isfinite(float(match[1])):
            forms = "write 0.3 (mesh units), 1% (of the diagonal) or 0.5edge (mean edges)"
            raise ParameterError(f"{name}{name and ': '}{shortened(repr(text))} is no length: {forms}")
        suffix = match[2] or "absolute"
        return cls(float(match[1]), cast("LengthUnit", {"%": "percent", "edges": "edge"}.get(suffix, suffix)))

    def resolve(self, *, diagonal: float, mean_edge: Callable[[], float]) -> float:
        """The length in mesh units; calls `mean_edge` only if needed."""
        if self.unit == "percent":
            return self.amount / 100.0 * diagonal
        if self.unit == "edge":
            return self.amount * mean_edge()
        return self.in_mesh_units(None).amount

    def in_mesh_units(self, unit: str | None) -> Length:
        """Converts a length in a unit of `METRES` to mesh units of a scan in `unit`, which must be given; other lengths stay."""
        if self.unit not in METRES:
            return self
        if unit is None:
            amounts = {name: self.in_mesh_units(name).amount for name in (self.unit, "mm", "m")}
            readings = " and ".join(f"{amount:.6g} on a scan in {name}" for name, amount in amounts.items())
            raise ParameterError(
                f"{self} would be {readings}, and neither the file nor the recipe says the unit of the scan: give it by --unit "
                f"{'|'.join(METRES)} (unit= in Python), or give the length without a unit, as a number of the scan's own units"
            )
        return Length(self.amount * METRES[self.unit] / METRES[check_unit(unit)])

    def __str__(self) -> str:
        return f"{self.amount!r}{_LENGTH_SUFFIX[self.unit]}"


def unit_of_scan(typed: str | None, of_file: str | None, of_recipe: str = "") -> str | None:
    """The unit of a scan: the one that the user typed, else that of the file, else that of the recipe; or None."""
    if typed is not None:
        return check_unit(typed)
    return of_file or of_recipe or None


def doubts_of_typed_unit(typed: str | None, of_file: str | None) -> tuple[str, ...]:
    """A warning if the user typed another unit than the scan's file says; empty if not."""
    text = f"the file of the scan says {of_file}, and --unit (unit= in Python) says {typed}: the scan's numbers mean {typed}"
    return (text,) if typed and of_file and typed != of_file else ()


def check_unit(unit: str) -> str:
    """Returns the unit of a scan; raises `ParameterError` if it is unknown."""
    if unit not in METRES:
        raise ParameterError(f"{unit!r} is no unit of scans; the units are {', '.join(METRES)}")
    return unit


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a filter."""

    name: str = ""  # the name in Python, and in .mlx scripts unless `xml_name` is set
    label: str = ""  # the words before the input field in a dialog; by default made from the name
    help: str = ""  # the tooltip: the meaning, the unit, and the effect of larger values
    default: Any = None  # None in a filter of MeshLab's whose default depends on the mesh
    advanced: bool = False  # whether a dialog hides it at first
    xml_name: str = ""  # the name in .mlx scripts, which is MeshLab's C++ name
    #: the number that stands for "auto" in .mlx scripts and in calls of the filter's function; None if it cannot be automatic
    automatic: float | None = None

    kind: typing.ClassVar[str] = "a value"  # the kind of value in messages, e.g. "a whole number"
    xml_type: typing.ClassVar[str] = ""  # MeshLab's class of the parameter in .mlx scripts
    python_type: typing.ClassVar[Any] = object  # the type that the function of a filter receives

    def check(self, value: Any) -> Any:
        """Returns an allowed value as int, float, `Length` and so on, or as "auto"; raises `ParameterError` for other values."""
        raise NotImplementedError

    def describe_allowed(self) -> str:
        """The allowed values in words: ``"a whole number of at least 1"``."""
        return self.kind

    def to_number(self, value: Any) -> Any:
        return self.automatic if isinstance(value, str) and self.is_automatic(value) else value

    def is_automatic(self, value: Any) -> bool:
        return self.automatic is not None and (value == AUTO if isinstance(value, str) else as_float(value) == self.automatic)

    def refusal(self, value: Any) -> ParameterError:
        got = value if isinstance(value, Length) else shortened(repr(value))
        return ParameterError(f"parameter {self.name!r} takes {self.describe_allowed()}, got {got}")


class Bool(Parameter):
    """Yes or no."""

    kind = "True or False"
    xml_type = "RichBool"
    python_type = bool

    def check(self, value: Any) -> bool:
        if not isinstance(value, bool | np.bool_):
            raise self.refusal(value)
        return bool(value)


@dataclass(frozen=True, kw_only=True)
class _Bounded(Parameter):
    """A number or a length between two inclusive bounds; None means no bound."""

    minimum: float | None = None
    maximum: float | None = None

    def check_bounds(self, value: Any, number: float) -> None:
        """Raises `ParameterError` for a number out of bounds, or outside the range of C floats, which MeshLab uses."""
        if (self.minimum is not None and number < self.minimum) or (self.maximum is not None and number > self.maximum):
            raise self.refusal(value)
        if number != 0.0 and not 2.0**-150 < abs(number) <= 3.4028234663852886e38:
            raise ParameterError(f"{self.refusal(number)}: MeshLab keeps numbers in single precision, from 1e-45 to 3.4e38")

    def describe_allowed(self) -> str:
        low, high = self.minimum, self.maximum
        one_end = f" of at least {low}" if low is not None else f" of at most {high}" if high is not None else ""
        bounds = one_end if low is None or high is None else f" from {low} to {high}"
        return self.kind + bounds + ("" if self.automatic is None else ", or 'auto'")


@dataclass(frozen=True, kw_only=True)
class Int(_Bounded):
    """A whole number between two bounds."""

    kind = "a whole number"
    xml_type = "RichInt"
    python_type = int
    minimum: int | None = None
    maximum: int | None = None

    def check(self, value: Any) -> int | str:
        if self.is_automatic(value):
            return AUTO
        number = _whole(value)
        if number is None or abs(number) > 2**31 - 1:
            raise self.refusal(value)
        self.check_bounds(value, number)
        return number


class Float(_Bounded):
    """A finite number between two bounds; MeshLab shows a slider if both are given."""

    kind = "a number"
    python_type = float

    @property
    def xml_type(self) -> str:  # type: ignore[override]
        return "RichFloat" if self.minimum is None or self.maximum is None else "RichDynamicFloat"

    def check(self, value: Any) -> float | str:
        if self.is_automatic(value):
            return AUTO
        number = as_float(value)
        if number is None or not math.isfinite(number):
            raise self.refusal(value)
        self.check_bounds(value, number)
        return number


@dataclass(frozen=True, kw_only=True)
class Percentage(_Bounded):
    """A length: declarations and callers use `Length`, the function of the filter receives mesh units.

    A default may be a text (``"1%"``, ``"6edge"``). Zero is allowed, and often means "not used".
    """

    kind = "a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units)"
    xml_type = "RichAbsPerc"
    python_type = float
    minimum: float | None = 0.0
    of_edges: bool = False  # whether to take the mean edge of the layer's polylines even if the layer has faces

    def check(self, value: Any) -> Any:
        if isinstance(value, str):
            if self.is_automatic(value):
                return AUTO
            value = Length.parse(value)
        if isinstance(value, Length) and (value.unit == "absolute" or not value.amount) and value.amount == self.automatic:
            return AUTO
        number = as_float(value)
        if number is not None:
            text = f"{number:g}"
            raise ParameterError(
                f"parameter {self.name!r} is a length, and {text} has no unit: write '{text}edge' for {text} mean edges, "
                f"'{text}%' of the bounding box's diagonal, or '{text}' in quotes for mesh units"
            )
        if not isinstance(value, Length) or value.unit in METRES:
            raise self.refusal(value)
        self.check_bounds(value, value.amount)
        return value


@dataclass(frozen=True, kw_only=True)
class Enum(Parameter):
    """One of several words, by default those of the annotated `Literal`; an .mlx script has the index of the word."""

    xml_type = "RichEnum"
    python_type = str
    choices: tuple[str, ...] = ()

    def check(self, value: Any) -> str:
        if not isinstance(value, str) or value not in self.choices:
            near = nearest(value, self.choices) if isinstance(value, str) else None
            meant = f"; did you mean {near!r}?" if near else ""
            raise ParameterError(f"{self.refusal(value)}{meant}")
        return value

    def describe_allowed(self) -> str:
        return "one of " + ", ".join(map(repr, self.choices))


class String(Parameter):
    """Free text."""

    kind = "a text"
    xml_type = "RichString"
    python_type = str

    def check(self, value: Any) -> str:
        if not isinstance(value, str):
            raise self.refusal(value)
        return value


class FileOpen(String):
    """The path of a file to read; only in MeshLab's filters."""

    kind = "the path of a file to read"
    xml_type = "RichOpenFile"


class FileSave(String):
    """The path of a file to write; only in MeshLab's filters."""

    kind = "the path of a file to write"
    xml_type = "RichSaveFile"


class Mesh(Parameter):
    """A layer, by its id in the mesh set."""

    kind = "the id of a layer (a whole number)"
    xml_type = "RichMesh"
    python_type = int

    def check(self, value: Any) -> int:
        number = _whole(value)
        if number is None or not 0 <= number < 2**31:
            raise self.refusal(value)
        return number


class Shot(Parameter):
    """A camera; only in MeshLab's filters, and a script cannot set it."""

    kind = "nothing: a camera cannot be given here"
    xml_type = "RichShotf"

    def check(self, value: Any) -> Any:
        raise self.refusal(value)


class Point(Parameter):
    """Three coordinates: a position or a direction."""

    kind = "three finite numbers"
    xml_type = "RichPosition"
    python_type = tuple[float, float, float]

    def check(self, value: Any) -> tuple[float, ...]:
        return tuple(_numbers(self, value, (3,)))


class Direction(Point):
    """Three coordinates that MeshLab shows as a direction."""

    xml_type = "RichDirection"


class Color(Parameter):
    """Red, green, blue and opacity, each from 0 to 255."""

    kind = "four whole numbers from 0 to 255 (red, green, blue, opacity)"
    xml_type = "RichColor"
    python_type = tuple[int, int, int, int]

    def check(self, value: Any) -> tuple[int, ...]:
        channels = _numbers(self, value, (4,))
        if any(c != int(c) or not 0 <= c <= 255 for c in channels):
            raise self.refusal(value)
        return tuple(map(int, channels))


class Matrix(Parameter):
    """A 4 x 4 matrix, row by row."""

    kind = "a 4 x 4 matrix of finite numbers"
    xml_type = "RichMatrix44f"
    python_type = tuple[tuple[float, ...], ...]

    def check(self, value: Any) -> tuple[tuple[float, ...], ...]:
        return tuple(map(tuple, _numbers(self, value, (4, 4))))


def _whole(value: Any) -> int | None:
    return None if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Integral) else int(value)


def _numbers(parameter: Parameter, value: Any, shape: tuple[int, ...]) -> list[Any]:
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):  # rows of different lengths
        raise parameter.refusal(value) from None
    if array.dtype.kind not in "iuf" or array.shape != shape or not np.isfinite(array).all():
        raise parameter.refusal(value)
    return list(array.astype(np.float64).tolist())
