"""The vocabulary in which a filter declares itself: its parameters, the layer that it reads and the edit that it returns.

One frozen `Filter` drives everything that users see of it: the method of `MeshSet`, the checks, the .mlx reader and writer,
``pymeshfair info``, the documentation and MeshLab's dialog. It mirrors MeshLab's C++ ``FilterPlugin`` member by member. The
usual way to make one is the decorator `mesh_filter` on a function with an annotated, keyword-only signature::

    @mesh_filter(name="Shift", classes=FilterClass.SMOOTHING, changes=MeshElement.VERTCOORD)
    def apply_coord_shift(
        layer: Layer,
        *,
        distance: Annotated[float, Percentage(label="Distance", help="How far. Larger moves further.", default="1%")],
    ) -> Edit:
        "Moves the mesh along x."
        return Edit(vertices=layer.vertices + [distance, 0.0, 0.0])

This module imports neither pymeshlab nor any plugin.
"""

from __future__ import annotations

import difflib
import enum
import inspect
import keyword
import math
import numbers
import re
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .errors import DeclarationError, ParameterError, UnknownNameError

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Bools: TypeAlias = NDArray[np.bool_]


class FilterClass(enum.IntFlag):
    """The menus of MeshLab that a filter appears in, with MeshLab's own bits."""

    SELECTION = 0x1
    CLEANING = 0x2
    REMESHING = 0x4
    FACE_COLORING = 0x8
    VERTEX_COLORING = 0x10
    MESH_COLORING = 0x20
    MESH_CREATION = 0x40
    SMOOTHING = 0x80
    QUALITY = 0x100
    LAYER = 0x200
    RASTER_LAYER = 0x400
    NORMAL = 0x800
    SAMPLING = 0x1000
    TEXTURE = 0x2000
    RANGE_MAP = 0x4000
    POINT_SET = 0x8000
    MEASURE = 0x10000
    POLYGONAL = 0x20000
    CAMERA = 0x40000
    OTHER = 0x80000


class MeshElement(enum.IntFlag):
    """What a filter needs or changes, with the bits of MeshLab's ``MeshModel::MeshElement``."""

    NONE = 0
    VERTCOORD = 0x1
    VERTNORMAL = 0x2
    VERTFLAG = 0x4
    VERTCOLOR = 0x8
    VERTQUALITY = 0x10
    VERTNUMBER = 0x800
    FACEVERT = 0x1000
    FACENORMAL = 0x2000
    FACEFLAG = 0x4000
    FACECOLOR = 0x8000
    FACEQUALITY = 0x10000
    FACENUMBER = 0x80000
    WEDGTEXCOORD = 0x200000
    VERTFLAGSELECT = 0x1000000
    FACEFLAGSELECT = 0x2000000


class Arity(enum.IntEnum):
    """How many layers a filter reads, with MeshLab's numbers."""

    NONE = 0
    SINGLE_MESH = 1
    FIXED = 2
    VARIABLE = 3


# ---------------------------------------------------------------------------------------------------------------- lengths

LengthUnit: TypeAlias = Literal["absolute", "percent", "edge"]
_LENGTH_SUFFIX: Mapping[LengthUnit, str] = {"absolute": "", "percent": "%", "edge": "edge"}
_LENGTH = re.compile(r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(%|edges?)?")


@dataclass(frozen=True)
class Length:
    """A length in mesh units, in percent of the bounding box's diagonal, or in mean edges.

    Written ``"0.3"``, ``"1%"`` and ``"0.5edge"``. The last two carry over from scan to scan. On a point cloud an "edge" is the
    mean distance from a point to its nearest neighbour.
    """

    amount: float
    unit: LengthUnit = "absolute"

    def __post_init__(self) -> None:
        amount = _as_float(self.amount)
        if amount is None or not math.isfinite(amount):
            raise ParameterError(f"the amount of a length must be a finite number, got {_shown(self.amount)}")
        if self.unit not in _LENGTH_SUFFIX:
            raise ParameterError(
                f"the unit of a length is one of {', '.join(map(repr, _LENGTH_SUFFIX))}, got {_shown(self.unit)}"
            )
        object.__setattr__(self, "amount", amount)  # numpy's numbers print themselves differently

    @classmethod
    def parse(cls, text: str) -> Length:
        """Read ``"0.3"``, ``"1%"`` or ``"0.5edge"``; raise `ParameterError` for anything else."""
        match = _LENGTH.fullmatch(text.strip()) if len(text) <= 400 else None
        if match is None:
            raise ParameterError(
                f"{_shown(text)} is no length: write 0.3 (mesh units), 1% (of the diagonal) or 0.5edge (mean edges)"
            )
        amount, suffix = match.groups()
        unit: LengthUnit = "percent" if suffix == "%" else "edge" if suffix else "absolute"
        return cls(float(amount), unit)

    def resolve(self, *, diagonal: float, mean_edge: Callable[[], float]) -> float:
        """The length in mesh units on a mesh of that bounding-box diagonal; `mean_edge` is only called when it is needed."""
        if self.unit == "percent":
            return self.amount / 100.0 * diagonal
        if self.unit == "edge":
            return self.amount * mean_edge()
        return self.amount

    def __str__(self) -> str:
        return f"{self.amount!r}{_LENGTH_SUFFIX[self.unit]}"


# ------------------------------------------------------------------------------------------------------------- parameters


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
        return ParameterError(f"parameter {self.name!r} takes {self.describe_allowed()}, got {_shown(value)}")

    def _refuse_what_meshlab_cannot_hold(self, number: float) -> None:
        # MeshLab's parameters are C floats; it drops a script's number outside their range without a word.
        if number != 0.0 and not 2.0**-150 < abs(number) <= 3.4028234663852886e38:
            raise ParameterError(f"{self._refuse(number)}: MeshLab keeps numbers in single precision, from 1e-45 to 3.4e38")


def _as_float(value: Any) -> float | None:
    """The float of a real number of Python or numpy; None of anything else, truth values included."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _shown(value: Any) -> str:
    text = str(value) if isinstance(value, Length) else repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


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
        number = _as_float(value)
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
    """

    kind = "a length such as '1%' (of the bounding box's diagonal), '0.5edge' or '0.3' (mesh units)"
    rich_type = "RichPercentage"
    xml_type = "RichAbsPerc"
    python_type = float
    minimum: float | None = 0.0

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


# ----------------------------------------------------------------------------------------------------------- layer and edit


class Layer(Protocol):
    """The current mesh as read-only arrays; each is read from MeshLab when it is first asked for.

    n vertices, m triangles, e edges. A mesh with vertices alone is a point cloud, one with edges and no triangles a polyline.
    """

    @property
    def label(self) -> str: ...
    @property
    def vertices(self) -> Floats: ...  # (n, 3)
    @property
    def faces(self) -> Ints: ...  # (m, 3) indices of vertices, counter-clockwise seen from outside
    @property
    def edges(self) -> Ints: ...  # (e, 2)
    @property
    def vertex_normals(self) -> Floats: ...  # (n, 3)
    @property
    def face_normals(self) -> Floats: ...  # (m, 3)
    @property
    def vertex_selection(self) -> Bools: ...  # (n,)
    @property
    def face_selection(self) -> Bools: ...  # (m,)
    @property
    def vertex_scalars(self) -> Floats: ...  # (n,)
    @property
    def face_scalars(self) -> Floats: ...  # (m,)
    @property
    def vertex_colors(self) -> Floats: ...  # (n, 4) from 0 to 1
    @property
    def face_colors(self) -> Floats: ...  # (m, 4) from 0 to 1
    @property
    def has_vertex_scalars(self) -> bool: ...
    @property
    def has_vertex_colors(self) -> bool: ...
    @property
    def diagonal(self) -> float: ...  # of the bounding box, in mesh units
    @property
    def mean_edge(self) -> float: ...  # mean edge length; of a cloud the mean distance to the nearest neighbour

    def selected_vertices(self) -> Bools:
        """The selected vertices or, when there are none, the vertices all of whose triangles are selected.

        Raises `MeshError` when nothing at all is selected.
        """
        ...

    def other(self, mesh_id: int) -> Layer:
        """Another layer of the mesh set; raises `MeshError` when there is none of that id."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class NewLayer:
    """A layer that a filter adds to the mesh set."""

    label: str
    vertices: Floats
    faces: Ints | None = None
    edges: Ints | None = None
    vertex_normals: Floats | None = None
    vertex_scalars: Floats | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Edit:
    """What a filter changed. None means untouched; everything that is not named stays as it is, bit by bit.

    Attributes:
        vertices: (n, 3) new coordinates.
        vertex_selection, face_selection: (n,), (m,) the new selection.
        vertex_scalars, face_scalars: (n,), (m,) the new scalar ("quality").
        vertex_colors, face_colors: (n, 4), (m, 4) red, green, blue, opacity from 0 to 1.
        vertex_normals: (n, 3) of a point cloud; a mesh's normals follow from its coordinates.
        face_normals: (m, 3) unit normals.
        delete_vertices, delete_faces: (n,), (m,) true where the element goes; a vertex takes its faces along.
        new_layers: layers to add; the first becomes the current one.
        values: what `apply_filter` returns: numbers, texts, arrays by name.
        notes: sentences that the user should read, such as what was left alone and why.
    """

    vertices: Floats | None = None
    vertex_selection: Bools | None = None
    face_selection: Bools | None = None
    vertex_scalars: Floats | None = None
    face_scalars: Floats | None = None
    vertex_colors: Floats | None = None
    face_colors: Floats | None = None
    vertex_normals: Floats | None = None
    face_normals: Floats | None = None
    delete_vertices: Bools | None = None
    delete_faces: Bools | None = None
    new_layers: tuple[NewLayer, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


# ------------------------------------------------------------------------------------------------------------------ filters


@dataclass(frozen=True, kw_only=True)
class Filter:
    """One filter, MeshLab's or ours.

    Attributes:
        python_name: the name in Python, e.g. ``apply_coord_taubin_fairing``.
        name: the name in MeshLab's menus and in .mlx scripts, e.g. ``Taubin Fairing``.
        info: what it does, in plain text; the first line is a summary.
        classes: MeshLab's menus.
        requires: what the mesh must have.
        changes: what the filter changes.
        arity: how many layers it reads.
        parameters: in declared order, which is the order in .mlx scripts.
        references: keys of docs/bibliography.bib.
        origin: who declares it: ``"MeshLab"`` or the name of a Python distribution.
        function: the work; None for MeshLab's own filters.
    """

    python_name: str
    name: str
    info: str = ""
    classes: FilterClass = FilterClass.OTHER
    requires: MeshElement = MeshElement.NONE
    changes: MeshElement = MeshElement.NONE
    arity: Arity = Arity.SINGLE_MESH
    parameters: tuple[Parameter, ...] = ()
    references: tuple[str, ...] = ()
    origin: str = "MeshLab"
    function: Callable[..., Edit] | None = field(default=None, compare=False)

    @property
    def is_builtin(self) -> bool:
        """Whether MeshLab itself carries the filter out."""
        return self.function is None

    @property
    def summary(self) -> str:
        """The first line of `info`."""
        return self.info.partition("\n")[0]

    def parameter(self, name: str) -> Parameter:
        """The parameter of that Python name; raise `UnknownNameError` with the nearest name if there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        names = [p.name for p in self.parameters]
        near = nearest(name, names)
        hint = f"; did you mean {near!r}?" if near else f"; it has {', '.join(names)}" if names else "; it has none"
        raise UnknownNameError(f"filter {self.python_name!r} has no parameter {name!r}{hint}", suggestion=near)

    def check(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The given values by parameter name, checked, in declared order; absent ones stay absent."""
        for name in values:
            self.parameter(name)
        return {p.name: p.check(values[p.name]) for p in self.parameters if p.name in values}

    def with_defaults(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """As `check`, with the default of every parameter that is absent."""
        checked = self.check(values)
        return {p.name: checked.get(p.name, p.default) for p in self.parameters}


def mesh_filter(
    *,
    name: str,
    classes: FilterClass,
    requires: MeshElement = MeshElement.NONE,
    changes: MeshElement = MeshElement.NONE,
    arity: Arity = Arity.SINGLE_MESH,
    references: Sequence[str] = (),
) -> Callable[[Callable[..., Edit]], Filter]:
    """Turn a function ``(layer, *, parameter: Annotated[type, Parameter(...)] = default, ...) -> Edit`` into a `Filter`.

    The function's name is the Python name and its docstring the description. A parameter ``progress`` is not shown to users:
    the host passes a function that takes the share of the work done, from 0 to 1.

    Raises:
        DeclarationError: the signature, a default or a bound contradicts itself.
    """

    def declare(function: Callable[..., Edit]) -> Filter:
        parameters = tuple(_parameters(function))
        in_scripts = [p.xml_name for p in parameters]
        if len(set(in_scripts)) != len(in_scripts):
            raise DeclarationError(
                f"{function.__module__}.{function.__name__}: two parameters share a name in scripts, {in_scripts}"
            )
        return Filter(
            python_name=function.__name__,
            name=name,
            info=inspect.getdoc(function) or "",
            classes=classes,
            requires=requires,
            changes=changes,
            arity=arity,
            parameters=parameters,
            references=tuple(references),
            origin=function.__module__.partition(".")[0],
            function=function,
        )

    return declare


def _parameters(function: Callable[..., Edit]) -> Iterable[Parameter]:
    where = f"{function.__module__}.{function.__name__}"
    hints = typing.get_type_hints(function, include_extras=True)
    if not inspect.getdoc(function):
        raise DeclarationError(f"{where} has no docstring; it is the filter's description")
    arguments = list(inspect.signature(function).parameters.values())
    if not arguments or arguments[0].kind not in (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD):
        raise DeclarationError(f"{where} must take the layer as its first, positional parameter")
    for argument in arguments[1:]:
        if argument.name == "progress":
            continue
        if argument.kind is not argument.KEYWORD_ONLY:
            raise DeclarationError(f"{where}: parameter {argument.name!r} must be keyword-only")
        hint = hints.get(argument.name)
        described = [x for x in getattr(hint, "__metadata__", ()) if isinstance(x, Parameter)]
        if len(described) != 1:
            raise DeclarationError(f"{where}: annotate {argument.name!r} as Annotated[type, Float(...)] or another parameter")
        _check_consistent(described[0], typing.get_args(hint)[0], f"{where}: parameter {argument.name!r}")
        yield _completed(described[0], argument, where)


_PLAIN_TYPES = (bool, int, float, str)


def _check_consistent(described: Parameter, annotated: Any, where: str) -> None:
    """Raise `DeclarationError` if a parameter's type, bounds and choices contradict each other."""
    minimum, maximum = getattr(described, "minimum", None), getattr(described, "maximum", None)
    if minimum is not None and maximum is not None and minimum > maximum:
        raise DeclarationError(f"{where} has the minimum {minimum} above the maximum {maximum}")
    if isinstance(described, Enum):
        if not described.choices or len(set(described.choices)) != len(described.choices):
            raise DeclarationError(f"{where} needs choices, each of them once; it has {described.choices}")
        if typing.get_origin(annotated) is Literal and not set(described.choices) <= set(typing.get_args(annotated)):
            raise DeclarationError(f"{where} offers {described.choices}, but its type allows {typing.get_args(annotated)}")
    elif described.python_type in _PLAIN_TYPES and annotated in _PLAIN_TYPES and annotated is not described.python_type:
        kind = type(described).__name__
        raise DeclarationError(
            f"{where} is annotated as {annotated.__name__}, but {kind} hands over {described.python_type.__name__}"
        )


def _completed(described: Parameter, argument: inspect.Parameter, where: str) -> Parameter:
    """The annotation's parameter with the name and default of the argument that it annotates."""
    if keyword.iskeyword(argument.name):
        raise DeclarationError(f"{where}: {argument.name!r} is a word of Python")
    if not described.label or not described.help:
        raise DeclarationError(f"{where}: parameter {argument.name!r} needs a label and a help text")
    default = described.default if argument.default is argument.empty else argument.default
    parameter = replace(described, name=argument.name, xml_name=described.xml_name or argument.name, default=default)
    try:
        return replace(parameter, default=parameter.check(default))
    except ParameterError as error:
        raise DeclarationError(f"{where}: the default does not fit: {error}") from error


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The one of `names` that `name` was most likely meant to be, upper and lower case, spaces and underscores aside; or None."""
    plain = {re.sub(r"[\s_-]+", "", n.casefold()): n for n in names}
    found = difflib.get_close_matches(re.sub(r"[\s_-]+", "", name.casefold()), plain, n=1, cutoff=0.6)
    return plain[found[0]] if found else None
