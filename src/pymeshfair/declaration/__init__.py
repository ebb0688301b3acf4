"""The classes that declare a filter: its parameters, the layer that it reads and the edit that it returns.

A frozen `Filter`, which mirrors MeshLab's C++ ``FilterPlugin``, determines all that users see of a filter: the method of
`MeshSet`, the checks, scripts, ``pymeshfair info`` and HTML pages. `mesh_filter` makes a `Filter` from a function with an
annotated, keyword-only signature; CONTRIBUTING.md has an example.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import inspect
import keyword
import re
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol, TypeAlias, TypeGuard

import numpy as np
from numpy.typing import NDArray

from ..errors import DeclarationError, ParameterError, UnknownNameError, hint
from ..errors import nearest as nearest
from ..places import point_text as point_text
from .parameters import AUTO as AUTO
from .parameters import Bool as Bool
from .parameters import Color as Color
from .parameters import Direction as Direction
from .parameters import Enum as Enum
from .parameters import FileOpen as FileOpen
from .parameters import FileSave as FileSave
from .parameters import Float as Float
from .parameters import Int as Int
from .parameters import Length as Length
from .parameters import LengthUnit as LengthUnit
from .parameters import Matrix as Matrix
from .parameters import Mesh as Mesh
from .parameters import Parameter as Parameter
from .parameters import Percentage as Percentage
from .parameters import Point as Point
from .parameters import Shot as Shot
from .parameters import String as String
from .parameters import as_float as as_float

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Bools: TypeAlias = NDArray[np.bool_]


class Layer(Protocol):
    """The current mesh as read-only arrays: n vertices, m triangles, e edges.

    A mesh with only vertices is a point cloud, one with edges and no triangles a polyline.
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
    def has_face_scalars(self) -> bool: ...
    @property
    def has_face_colors(self) -> bool: ...
    @property
    def has_wedge_tex_coords(self) -> bool: ...
    @property
    def diagonal(self) -> float: ...  # of the bounding box, in mesh units
    @property
    def mean_edge(self) -> float: ...  # mean edge length; of a cloud the mean distance to the nearest neighbour
    def without_matrix(self) -> Layer: ...  # the layer with its matrix applied to its coordinates

    def selected_vertices(self) -> Bools:
        """The selected vertices; if there are none, the vertices whose triangles are all selected.

        Raises `MeshError` if nothing is selected.
        """
        ...

    def other(self, mesh_id: int) -> Layer:
        """Another layer, in the coordinates of this one. Raises `MeshError` for an unknown id, or a matrix without an inverse."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class NewLayer:
    """A layer that a filter adds to the mesh set; it gets the matrix of the layer that the filter read, if it read one."""

    label: str
    vertices: Floats
    faces: Ints | None = None
    edges: Ints | None = None
    vertex_normals: Floats | None = None
    vertex_scalars: Floats | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Edit:
    """The changes by a filter. None means unchanged; everything that the edit does not name keeps every bit.

    The layer has n vertices and m faces; N = n + a and M = m + b include the added elements, which come last.

    An edit may leave attributes of added elements unset: then scalars, and texture coordinates of vertices, come from an old
    element near the rim of the added ones, and colours are a blend of the colours around. All corners of an added face get
    one texture coordinate, where the image has about the blended colour. Of several textures, connected added faces get that
    of the old faces with which they share the most vertices. Added elements are not selected, custom attributes are 0,
    normals follow from coordinates.

    Side effects in a `MeshSet`, not in a run: added elements turn a mesh of polygons without triangles into a triangle mesh. If
    only face corners have texture coordinates, vertices get some, too. If the mesh has no colours, new face scalars make its
    faces white. Added faces with different textures are sorted by texture.
    """

    vertices: Floats | None = None  # (n, 3) new coordinates
    added_vertices: Floats | None = None  # (a, 3) vertices to add, to a mesh that has faces
    added_faces: Ints | None = None  # (b, 3) three different vertex indices; from n on they mean `added_vertices`
    vertex_selection: Bools | None = None  # (N,)
    face_selection: Bools | None = None  # (M,)
    vertex_scalars: Floats | None = None  # (N,) MeshLab's "quality"
    face_scalars: Floats | None = None  # (M,)
    vertex_colors: Floats | None = None  # (N, 4) red, green, blue, opacity from 0 to 1
    face_colors: Floats | None = None  # (M, 4)
    vertex_normals: Floats | None = None  # (N, 3) only of a point cloud; the normals of a mesh follow from its coordinates
    face_normals: Floats | None = None  # (M, 3) unit normals
    delete_vertices: Bools | None = None  # (N,) the vertices to delete with their faces
    delete_faces: Bools | None = None  # (M,) the faces to delete
    new_layers: tuple[NewLayer, ...] = ()  # the first becomes the current layer
    values: Mapping[str, Any] = field(default_factory=dict)  # the results that `apply_filter` returns: numbers, texts, arrays
    notes: tuple[str, ...] = ()  # sentences for the user, for example about unchanged parts and the reason


class FilterClass(enum.IntFlag):
    """The MeshLab menus of a filter, with MeshLab's bits."""

    SELECTION, CLEANING, REMESHING, FACE_COLORING = 0x1, 0x2, 0x4, 0x8
    VERTEX_COLORING, MESH_COLORING, MESH_CREATION, SMOOTHING = 0x10, 0x20, 0x40, 0x80
    QUALITY, LAYER, RASTER_LAYER, NORMAL = 0x100, 0x200, 0x400, 0x800
    SAMPLING, TEXTURE, RANGE_MAP, POINT_SET = 0x1000, 0x2000, 0x4000, 0x8000
    MEASURE, POLYGONAL, CAMERA, OTHER = 0x10000, 0x20000, 0x40000, 0x80000


class MeshElement(enum.IntFlag):
    """Parts of a mesh that a filter needs or changes, with the bits of MeshLab's ``MeshModel::MeshElement``."""

    NONE = 0
    VERTCOORD, VERTNORMAL, VERTFLAG, VERTCOLOR, VERTQUALITY, VERTNUMBER = 0x1, 0x2, 0x4, 0x8, 0x10, 0x800
    FACEVERT, FACENORMAL, FACEFLAG, FACECOLOR, FACEQUALITY, FACENUMBER = 0x1000, 0x2000, 0x4000, 0x8000, 0x10000, 0x80000
    WEDGTEXCOORD, VERTFLAGSELECT, FACEFLAGSELECT = 0x200000, 0x1000000, 0x2000000
    EDGENUMBER = 0x4000000  # the edges of polylines; MeshLab has no bit for them and does not use this one


class Arity(enum.IntEnum):
    """The number of layers that a filter reads, with MeshLab's constants."""

    NONE, SINGLE_MESH, FIXED, VARIABLE = 0, 1, 2, 3


@dataclass(frozen=True)
class Equivalent:
    """A MeshLab filter, and the parameter values that give the same result up to rounding."""

    filter: str  # the Python name
    values: Mapping[str, Any]  # by Python parameter name
    closed_only: bool = False  # whether the results are the same only on closed meshes without a selection


FindEquivalent: TypeAlias = Callable[[Mapping[str, Any]], Equivalent | None]


@dataclass(frozen=True, kw_only=True)
class Filter:
    """The declaration of a filter of MeshLab or of a plugin."""

    python_name: str  # the name in Python, e.g. ``apply_coord_taubin_fairing``
    name: str  # the name in MeshLab's menus and in .mlx scripts, e.g. ``Taubin Fairing``
    info: str = ""  # the description in plain text; the first line is a summary
    classes: FilterClass = FilterClass.OTHER
    requires: MeshElement = MeshElement.NONE  # what the mesh must have
    changes: MeshElement = MeshElement.NONE
    arity: Arity = Arity.SINGLE_MESH
    parameters: tuple[Parameter, ...] = ()  # in declared order, which is the order in .mlx scripts
    references: tuple[str, ...] = ()  # keys of docs/bibliography.bib
    origin: str = "MeshLab"  # ``"MeshLab"``, or the Python distribution of the plugin
    function: Callable[..., Edit] | None = field(default=None, compare=False)  # the implementation; None for MeshLab's filters
    #: returns, for the values of all parameters, the equivalent MeshLab filter, or None if there is none
    equivalent: FindEquivalent | None = field(default=None, compare=False)

    @property
    def is_builtin(self) -> bool:
        return self.function is None

    @property
    def summary(self) -> str:
        return self.info.partition("\n")[0]

    @property
    def menus(self) -> str:
        """The names of its menus in lower case, separated by commas."""
        return ", ".join(str(kind.name).replace("_", " ").lower() for kind in FilterClass if kind in self.classes)

    def parameter(self, name: str) -> Parameter:
        """Returns the parameter with a Python name, or raises `UnknownNameError` with the nearest name."""
        by_name = {parameter.name: parameter for parameter in self.parameters}
        if name in by_name:
            return by_name[name]
        words = hint(name, by_name, f"it has {', '.join(by_name) or 'none'}")
        message = f"filter {self.python_name!r} has no parameter {name!r}; {words}"
        raise UnknownNameError(message, suggestion=nearest(name, by_name))

    def check(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Returns the checked values by parameter name, in declared order."""
        for name in values:
            self.parameter(name)
        return {p.name: p.check(values[p.name]) for p in self.parameters if p.name in values}

    def with_defaults(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Like `check`, with the defaults of absent parameters."""
        return {**self.defaults, **self.check(values)}

    def in_order(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Returns values, given by parameter name, in declared order; checks nothing."""
        return {p.name: values[p.name] for p in self.parameters if p.name in values}

    def layers(self, values: Mapping[str, Any]) -> dict[str, int]:
        """The layer ids among the values, by parameter name."""
        named = {p.name: values.get(p.name) for p in self.parameters if isinstance(p, Mesh)}
        return {name: int(number) for name, number in named.items() if isinstance(number, int | np.integer)}

    @property
    def defaults(self) -> dict[str, Any]:
        """The defaults by parameter name; None if MeshLab computes the default from the mesh."""
        return {p.name: p.default for p in self.parameters}


def mesh_filter(
    *,
    name: str,
    classes: FilterClass,
    requires: MeshElement = MeshElement.NONE,
    changes: MeshElement = MeshElement.NONE,
    arity: Arity = Arity.SINGLE_MESH,
    references: Sequence[str] = (),
    equivalent: FindEquivalent | None = None,
) -> Callable[[Callable[..., Edit]], Filter]:
    """Makes a `Filter` from a function ``(layer, *, parameter: Annotated[type, Parameter(...)] = default, ...) -> Edit``.

    The name of the function is the Python name, its docstring the description. The section ``Args:`` has the help texts
    that annotations lack. A group of parameters that filters share is a frozen, keyword-only dataclass with
    fields annotated in the same way and help under ``Attributes:``; the function takes the group as one parameter, users see its
    fields. Users do not see a parameter ``progress``: the host passes a function that takes the completed share, from 0 to 1.
    `equivalent` lets `pymeshfair export` replace the filter; tests have to prove the equivalence. Raises `DeclarationError` for
    an incomplete or contradictory declaration.
    """

    def declare(function: Callable[..., Edit]) -> Filter:
        try:
            parameters = _parameters(function)
        except DeclarationError as error:
            raise DeclarationError(f"{function.__module__}.{function.__name__}: {error}") from error.__cause__
        return Filter(
            python_name=function.__name__,
            name=name,
            info=_documented(function)[0],
            classes=classes,
            requires=requires,
            changes=changes,
            arity=arity,
            parameters=parameters,
            references=tuple(references),
            origin=function.__module__.partition(".")[0],
            function=_gathering(function),
            equivalent=equivalent,
        )

    return declare


def _gathering(function: Callable[..., Edit]) -> Callable[..., Edit]:
    groups = {name: hint for name, hint in typing.get_type_hints(function).items() if name != "return" and _is_group(hint)}
    if not groups:
        return function

    @functools.wraps(function)
    def gathered(layer: Layer, **values: Any) -> Edit:
        for name, group in groups.items():
            values[name] = group(**{field.name: values.pop(field.name) for field in dataclasses.fields(group)})
        return function(layer, **values)

    return gathered


def _is_group(hint: Any) -> TypeGuard[type[Any]]:
    return isinstance(hint, type) and dataclasses.is_dataclass(hint)


_SECTION = re.compile(r"\n\n(?:Args|Attributes):\n((?:    .*(?:\n|$))+)")


def _documented(described: object) -> tuple[str, dict[str, str]]:
    text = inspect.getdoc(described) or ""
    section = _SECTION.search(text)
    _, *parts = re.split(r"^    (\w+): ", section[1] if section else "", flags=re.MULTILINE)
    helps = {name: " ".join(words.split()) for name, words in zip(parts[::2], parts[1::2], strict=True)}
    return _SECTION.sub("\n", text).rstrip(), helps


def _parameters(function: Callable[..., Edit]) -> tuple[Parameter, ...]:
    if not inspect.getdoc(function):
        raise DeclarationError("it has no docstring, which is the filter's description")
    layer = next(iter(inspect.signature(function).parameters.values()), None)
    if layer is None or layer.kind not in (layer.POSITIONAL_ONLY, layer.POSITIONAL_OR_KEYWORD):
        raise DeclarationError("it must take the layer as its first, positional parameter")
    parameters = tuple(_described(function, {}, skipped=1))
    in_scripts = [p.xml_name for p in parameters]
    if len(set(in_scripts)) != len(in_scripts):
        raise DeclarationError(f"two parameters share a name in scripts, {in_scripts}")
    return parameters


def _described(owner: Callable[..., Any], helps: Mapping[str, str], *, skipped: int = 0) -> Iterable[Parameter]:
    """Yields the parameters that the arguments of a function, or the fields of a group, declare."""
    hints, helps = typing.get_type_hints(owner, include_extras=True), {**_documented(owner)[1], **helps}
    for argument in list(inspect.signature(owner).parameters.values())[skipped:]:
        name, hint = argument.name, hints.get(argument.name)
        if name == "progress":
            continue
        if argument.kind is not argument.KEYWORD_ONLY:
            raise DeclarationError(f"parameter {name!r} must be keyword-only")
        if _is_group(hint):
            yield from _described(hint, helps)
            continue
        described = [x for x in getattr(hint, "__metadata__", ()) if isinstance(x, Parameter)]
        if len(described) != 1:
            raise DeclarationError(f"annotate {name!r} as Annotated[type, Float(...)], with Float or another class of parameters")
        parameter = replace(
            described[0],
            name=name,
            label=described[0].label or name.replace("_", " ").capitalize(),
            help=described[0].help or helps.get(name, ""),
            xml_name=described[0].xml_name or name,
            default=described[0].default if argument.default is argument.empty else argument.default,
        )
        annotated = typing.get_args(hint)[0]
        if isinstance(parameter, Enum) and not parameter.choices:
            parameter = replace(parameter, choices=_words(annotated))
        if reason := _contradiction(parameter, annotated):
            raise DeclarationError(f"parameter {name!r} {reason}")
        try:
            yield replace(parameter, default=parameter.check(parameter.default))
        except ParameterError as error:
            raise DeclarationError(f"the default does not fit: {error}") from error


def _words(annotated: Any) -> tuple[str, ...]:
    if typing.get_origin(annotated) is Literal:
        return typing.get_args(annotated)
    return tuple(word for part in typing.get_args(annotated) for word in _words(part))


_PLAIN_TYPES = (bool, int, float, str)


def _contradiction(parameter: Parameter, annotated: Any) -> str:
    minimum, maximum = getattr(parameter, "minimum", None), getattr(parameter, "maximum", None)
    if keyword.iskeyword(parameter.name):
        return "is a word of Python"
    if not parameter.help:
        return "needs a help text"
    if minimum is not None and maximum is not None and minimum > maximum:
        return f"has the minimum {minimum} above the maximum {maximum}"
    if isinstance(parameter, Enum):
        if not parameter.choices or len(set(parameter.choices)) != len(parameter.choices):
            return f"needs choices, each of them once; it has {parameter.choices}"
    elif parameter.python_type in _PLAIN_TYPES and annotated in _PLAIN_TYPES and annotated is not parameter.python_type:
        return f"is annotated as {annotated.__name__}, but {type(parameter).__name__} hands over {parameter.python_type.__name__}"
    return ""
