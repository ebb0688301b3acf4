"""Calls a plugin's filter on a layer: checks its requirements, converts lengths to mesh units, checks its edit."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from .declaration import Edit, Filter, Layer, Length, MeshElement, Percentage
from .errors import MeshError, PymeshfairError
from .mesh_data import checked_edit

_NEEDS: dict[MeshElement, tuple[str, Callable[[Layer], bool]]] = {
    MeshElement.FACENUMBER: ("faces", lambda layer: len(layer.faces) > 0),
    MeshElement.EDGENUMBER: ("edges", lambda layer: len(layer.edges) > 0),
    MeshElement.VERTNUMBER: ("vertices", lambda layer: len(layer.vertices) > 0),
    MeshElement.VERTCOLOR: ("vertex colors", lambda layer: layer.has_vertex_colors),
    MeshElement.VERTQUALITY: ("vertex scalars", lambda layer: layer.has_vertex_scalars),
    MeshElement.FACECOLOR: ("face colors", lambda layer: layer.has_face_colors),
    MeshElement.FACEQUALITY: ("face scalars", lambda layer: layer.has_face_scalars),
    MeshElement.WEDGTEXCOORD: ("texture coordinates of its faces' corners", lambda layer: layer.has_wedge_tex_coords),
    MeshElement.VERTFLAGSELECT: ("selected vertices", lambda layer: bool(layer.vertex_selection.any())),
    MeshElement.FACEFLAGSELECT: ("selected faces", lambda layer: bool(layer.face_selection.any())),
}


class StoppedError(PymeshfairError):
    """The progress callback raised an exception to stop the work; ``__cause__`` is that exception."""


def check_needs(declared: Filter, layer: Layer) -> None:
    """Raises `MeshError` if the layer lacks something that the filter requires."""
    lacking = [words for element, (words, is_there) in _NEEDS.items() if declared.requires & element and not is_there(layer)]
    if lacking:
        raise MeshError(f"{declared.python_name} cannot be applied: {layer.label!r} has no {' and no '.join(lacking)}")


def resolved(declared: Filter, values: Mapping[str, Any], layer: Layer) -> dict[str, Any]:
    """Returns the values, with lengths converted to mesh units on this layer."""

    def mesh_units(name: str, length: Length) -> float:
        def mean_edge() -> float:
            parameter = declared.parameter(name)
            if not (isinstance(parameter, Percentage) and parameter.of_edges and len(layer.edges)):
                return layer.mean_edge
            from .filters.geometry import mean_edge_length  # compiled code, loaded only if needed

            return mean_edge_length(layer.vertices, layer.edges)

        return length.resolve(diagonal=layer.diagonal, mean_edge=mean_edge)

    return {name: mesh_units(name, value) if isinstance(value, Length) else value for name, value in values.items()}


def call(declared: Filter, inputs: Mapping[str, Any], layer: Layer, on_progress: Callable[[float], None] | None) -> Edit:
    """Calls a plugin's filter and returns its edit; `inputs` are all parameter values, from `resolved`.

    `on_progress` receives the completed share of the work. If it raises an exception that the filter does not catch, `call`
    raises `StoppedError` with this cause. Other exceptions are passed on. An edit that does not fit the layer raises `MeshError`.
    """
    assert declared.function is not None
    inputs, stopped = {p.name: p.to_number(inputs[p.name]) for p in declared.parameters}, []

    def progress(done: float) -> None:
        if on_progress is not None:
            try:
                on_progress(done)
            except BaseException as error:
                stopped.append(error)
                raise

    if "progress" in inspect.signature(declared.function).parameters:
        inputs["progress"] = progress
    try:
        return checked_edit(declared.function(layer, **inputs), layer)
    except BaseException as error:
        if stopped and stopped[0] is error:
            raise StoppedError from error
        raise


def reason(error: Exception) -> str:
    """The message of an error; if it is neither ours nor pymeshlab's, the name of its class comes first."""
    foreseen = isinstance(error, PymeshfairError) or type(error).__name__ == "PyMeshLabException"
    return str(error) if foreseen else f"{type(error).__name__}: {error}".removesuffix(": ")
