"""The vocabulary in which a filter declares itself: its parameters, the layer that it reads and the edit that it returns.

One frozen `Filter`, which mirrors MeshLab's C++ ``FilterPlugin``, drives everything that users see of it: the method of
`MeshSet`, the checks, scripts, ``pymeshfair info`` and the pages. `mesh_filter` makes one of a function with an annotated,
keyword-only signature; CONTRIBUTING.md has an example.
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

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int32]
Bools: TypeAlias = NDArray[np.bool_]


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
    def has_face_scalars(self) -> bool: ...
    @property
    def has_face_colors(self) -> bool: ...
    @property
    def has_wedge_tex_coords(self) -> bool: ...
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
    """The changes by a filter. None means untouched; everything that is not named stays as it is, bit by bit.

    n and m count the vertices and faces of the layer; N = n + a and M = m + b count those that are added, too, which come last.

    Attributes of added elements that the edit does not set come from near by: scalars and texture coordinates of the nearest old
    element, colours as blends of those around. A face shows one place of the texture at its three corners, of about that colour.
    Added elements are not selected, their custom attributes are 0, normals follow from the coordinates.

    MeshLab leaves some things not as they were where elements are added: a mesh with texture coordinates at the corners of its
    faces alone gets some at its vertices, one of polygons alone becomes one of triangles, and new scalars of faces make those of
    a mesh without colours white.
    """

    vertices: Floats | None = None  # (n, 3) new coordinates
    added_vertices: Floats | None = None  # (a, 3) vertices to add, to a mesh that has faces
    added_faces: Ints | None = None  # (b, 3) three different indices of vertices; from n on they mean `added_vertices`
    vertex_selection: Bools | None = None  # (N,) the new selection
    face_selection: Bools | None = None  # (M,)
    vertex_scalars: Floats | None = None  # (N,) the new scalar ("quality")
    face_scalars: Floats | None = None  # (M,)
    vertex_colors: Floats | None = None  # (N, 4) red, green, blue, opacity from 0 to 1
    face_colors: Floats | None = None  # (M, 4)
    vertex_normals: Floats | None = None  # (N, 3) of a point cloud; a mesh's normals follow from its coordinates
    face_normals: Floats | None = None  # (M, 3) unit normals
    delete_vertices: Bools | None = None  # (N,) true where the vertex goes, which takes its faces along
    delete_faces: Bools | None = None  # (M,) true where the face goes
    new_layers: tuple[NewLayer, ...] = ()  # layers to add; the first becomes the current one
    values: Mapping[str, Any] = field(default_factory=dict)  # what `apply_filter` returns: numbers, texts, arrays by name
    notes: tuple[str, ...] = ()  # sentences for the user, such as parts that were left alone, with the reason


class FilterClass(enum.IntFlag):
    """The menus of MeshLab that a filter appears in, with MeshLab's own bits."""

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
    """The number of layers that a filter reads, with MeshLab's numbers."""

    NONE, SINGLE_MESH, FIXED, VARIABLE = 0, 1, 2, 3


@dataclass(frozen=True)
class Equivalent:
    """A filter of MeshLab's, with the values by which it gives the same result, to rounding."""

    filter: str  # its Python name
    values: Mapping[str, Any]  # by Python parameter name
    closed_only: bool = False  # the results are the same on closed meshes without a selection alone


FindEquivalent: TypeAlias = Callable[[Mapping[str, Any]], Equivalent | None]


@dataclass(frozen=True, kw_only=True)
class Filter:
    """One filter, MeshLab's or ours."""

    python_name: str  # in Python, e.g. ``apply_coord_taubin_fairing``
    name: str  # in MeshLab's menus and in .mlx scripts, e.g. ``Taubin Fairing``
    info: str = ""  # what it does, in plain text; the first line is a summary
    classes: FilterClass = FilterClass.OTHER  # MeshLab's menus
    requires: MeshElement = MeshElement.NONE  # elements that the mesh must have
    changes: MeshElement = MeshElement.NONE  # elements that the filter changes
    arity: Arity = Arity.SINGLE_MESH  # how many layers it reads
    parameters: tuple[Parameter, ...] = ()  # in declared order, which is the order in .mlx scripts
    references: tuple[str, ...] = ()  # keys of docs/bibliography.bib
    origin: str = "MeshLab"  # ``"MeshLab"``, or the Python distribution that declares it
    function: Callable[..., Edit] | None = field(default=None, compare=False)  # the work; None for MeshLab's own filters
    #: gives, for all values of the parameters, the filter of MeshLab's that does the same; None where there is none
    equivalent: FindEquivalent | None = field(default=None, compare=False)

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
        meant = hint(name, names, f"it has {', '.join(names) or 'none'}")
        words = f"filter {self.python_name!r} has no parameter {name!r}; {meant}"
        raise UnknownNameError(words, suggestion=nearest(name, names))

    def check(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The values by parameter name, checked, in declared order; absent ones stay absent."""
        for name in values:
            self.parameter(name)
        return {p.name: p.check(values[p.name]) for p in self.parameters if p.name in values}

    def with_defaults(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """As `check`, with the default of every parameter that is absent."""
        return {**self.defaults, **self.check(values)}

    def in_order(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Values by parameter name, in declared order; they are not checked."""
        return {p.name: values[p.name] for p in self.parameters if p.name in values}

    def layers(self, values: Mapping[str, Any]) -> dict[str, int]:
        """The ids of layers among the values, by parameter name."""
        return {p.name: values[p.name] for p in self.parameters if isinstance(p, Mesh) and isinstance(values.get(p.name), int)}

    @property
    def defaults(self) -> dict[str, Any]:
        """The default of every parameter by name; None where MeshLab computes it for the mesh."""
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
    """Turn a function ``(layer, *, parameter: Annotated[type, Parameter(...)] = default, ...) -> Edit`` into a `Filter`.

    The function's name is the Python name and its docstring the description, whose section ``Args:`` has the help texts of those
    parameters whose annotation has none. Parameters that filters share may be the fields of a frozen, keyword-only dataclass,
    annotated alike, with help under ``Attributes:``; the function takes it as one parameter, users see its fields in that place.
    A parameter ``progress`` is not shown to users: the host passes a function that takes the share of the work done, from 0 to 1.
    `equivalent` lets `pymeshfair export` replace the filter; tests have to prove it.
    Raises `DeclarationError` if the signature, a default or a bound contradicts itself.
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
    """The function that takes the fields of its groups one by one; the function itself if it has no group."""
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
    """Whether a parameter's type is a dataclass, whose fields then are parameters of the filter."""
    return isinstance(hint, type) and dataclasses.is_dataclass(hint)


_SECTION = re.compile(r"\n\n(?:Args|Attributes):\n((?:    .*(?:\n|$))+)")  # the section of a docstring on parameters


def _documented(described: object) -> tuple[str, dict[str, str]]:
    """The docstring without its section on parameters, and that by parameter."""
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
    """The parameters that the arguments of a function declare, or the fields of a group."""
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
            raise DeclarationError(f"annotate {name!r} as Annotated[type, Float(...)] or another parameter")
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
    """The words of a `Literal`, or of a union of such."""
    if typing.get_origin(annotated) is Literal:
        return typing.get_args(annotated)
    return tuple(word for part in typing.get_args(annotated) for word in _words(part))


_PLAIN_TYPES = (bool, int, float, str)


def _contradiction(parameter: Parameter, annotated: Any) -> str:
    """Where a parameter's name, help, type, bounds and choices contradict each other; empty if nowhere."""
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
        kind = type(parameter).__name__
        return f"is annotated as {annotated.__name__}, but {kind} hands over {parameter.python_type.__name__}"
    return ""
