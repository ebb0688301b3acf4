"""Values that are none are refused in the same words everywhere, on a mesh set and by the function behind the filter."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Iterator
from types import CodeType
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.declaration import Bool, Enum, Filter, Float, Int, Mesh, Parameter, Percentage, Point
from pymeshfair.errors import PymeshfairError
from pymeshfair.filters.checks import FilterInputError
from tests.contracts.scenes import mesh_set, scene_for, two_open_spheres
from tests.contracts.variants import FILTERS
from tests.host.snapshots import differences, everything

NAN, INFINITY = float("nan"), float("inf")
#: values that are none, by the kind of parameter that must refuse them
NONE_OF: dict[type[Parameter], tuple[Any, ...]] = {
    Int: (2.0, 2.5, NAN, True, "2", None, np.float64(3.0), 2**40),
    Float: (NAN, INFINITY, -INFINITY, True, "0.5", None, 1e300, 1 + 2j),
    Percentage: ("wide", "nan", "-1%", "1e999", 0.5, True, None),
    Enum: ("umbrella", "", 1, None, True),
    Bool: (1, 0.0, "yes", None, NAN),
    Mesh: (-1, 1.0, True, "0", None, 2**40),
    Point: ("up", (1.0, 2.0), (1.0, 2.0, NAN), 1.0, None),
}
PARAMETERS = [(declared, parameter) for declared in FILTERS for parameter in declared.parameters]


def beyond(parameter: Parameter) -> Iterator[float]:
    """The nearest values outside the bounds of a number."""
    if isinstance(parameter, Int):
        yield from (bound + way for bound, way in ((parameter.minimum, -1), (parameter.maximum, 1)) if bound is not None)
    elif isinstance(parameter, Float):
        ends = ((parameter.minimum, -math.inf), (parameter.maximum, math.inf))
        yield from (np.nextafter(np.float32(bound), np.float32(way)).item() for bound, way in ends if bound is not None)


@pytest.mark.parametrize(("declared", "parameter"), PARAMETERS, ids=lambda x: getattr(x, "python_name", "") or x.name)
def test_a_mesh_set_names_filter_parameter_and_value(declared: Filter, parameter: Parameter) -> None:
    """Each message is "filter: parameter 'p' takes ..., got ...", by `apply_filter` and by the method, and nothing changes."""
    meshes = mesh_set(scene_for(declared))
    before = everything(meshes)
    (wrong,) = (values for kind, values in NONE_OF.items() if isinstance(parameter, kind))
    for value in (*wrong, *(v for v in beyond(parameter) if not parameter.is_automatic(v))):
        for call in (getattr(meshes, declared.python_name), lambda **given: meshes.apply_filter(declared.python_name, **given)):
            with pytest.raises(pymeshlab.PyMeshLabException) as caught:
                call(**{parameter.name: value})
            assert isinstance(caught.value, PymeshfairError)
            said = str(caught.value)
            assert said.startswith(f"{declared.python_name}: ")
            if isinstance(parameter, Percentage) and isinstance(value, float):
                assert f"parameter {parameter.name!r} is a length, and {value} has no unit" in said
            elif not (isinstance(parameter, Percentage) and isinstance(value, str)):  # which says how to write a length
                assert f"parameter {parameter.name!r} takes {parameter.describe_allowed()}, got " in said
                assert said.endswith(repr(value)) or "; did you mean" in said or "single precision" in said
    assert differences(before, everything(meshes)) == []


# ------------------------------------------------------------------------------------------------------------- functions

#: values that are none for the function behind a filter, and the words that it refuses them with
WORDS: dict[type[Parameter], tuple[tuple[Any, ...], str]] = {
    Int: ((2.0, 2.5, NAN, True), "{name} is {value}: it must be a whole number "),
    Float: ((NAN, INFINITY, -INFINITY), "{name} is {value}: it must be "),
    Enum: (("umbrella", "", 1), "{name} {value} is not one of "),
}


#: What must be given besides the mesh so that a function looks at a parameter, by function and parameter or function alone.
ALONG: dict[tuple[str, str | None], dict[str, Any]] = {
    ("bilaplacian_smoothing", None): {"detail_size": 0.5},
    ("curve_smoothing", "mu"): {"method": "taubin"},
    ("curve_smoothing", "pass_band"): {"method": "taubin"},
    ("curve_smoothing", "time_step"): {"method": "implicit"},
    ("fair_region", None): {"free": two_open_spheres().chosen},
    ("implicit_fairing", None): {"time_step": 0.01},
    ("spectral_filter", None): {"detail_size": 0.5},
    ("surplus_points", None): {"side": 0.5},
    ("spectral_filter", "gain"): {"detail_size": 0.5, "response": "enhance"},
    ("spectral_filter", "modes"): {},
}


def names_in(code: CodeType) -> Iterator[str]:
    """The names that a function uses, those inside of it included."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from names_in(constant)


def functions_of(declared: Filter) -> Iterator[Callable[..., Any]]:
    """The functions of arrays in `pymeshfair.filters` that the filter calls, itself or through functions of plugins."""
    assert declared.function is not None
    own: Callable[..., Any] = inspect.unwrap(declared.function)  # of one whose parameters are the fields of a dataclass
    ahead, seen = [own], set[Callable[..., Any]]()
    while ahead:
        caller = ahead.pop()
        if not inspect.isfunction(caller) or caller in seen:
            continue
        seen.add(caller)
        names = list(names_in(caller.__code__))
        families = (caller.__globals__.get(name) for name in names)
        spaces = (caller.__globals__, *(vars(family) for family in families if inspect.ismodule(family)))
        for called in (space.get(name) for space in spaces for name in names):
            if not inspect.isfunction(called):
                continue
            if called.__module__.startswith("pymeshfair.filters."):
                yield called
            elif called.__module__.startswith("pymeshfair.plugins."):
                ahead.append(called)


def arguments(function: Callable[..., Any], declared: Filter, parameter: str | None = None) -> dict[str, Any] | None:
    """What a function takes of the filter's scene, and what it needs along with a parameter; None if it takes no scene."""
    scene = scene_for(declared)
    there = {"vertices": scene.vertices, "points": scene.vertices, "faces": scene.faces, "edges": scene.edges}
    there |= {"values": scene.scalars, "mode": 1, **ALONG.get((function.__name__, None), {})}
    parameters = inspect.signature(function).parameters.values()
    needed = [p.name for p in parameters if p.default is p.empty and p.kind is not p.VAR_KEYWORD]
    if not set(needed) <= there.keys():
        return None
    along = ALONG.get((function.__name__, parameter), ALONG.get((function.__name__, None), {}))
    return {**{name: there[name] for name in needed}, **along}


def function_cases() -> Iterator[Any]:
    """Every parameter that a filter shares by name with a function behind it, once for each function."""
    seen = set()
    for declared in FILTERS:
        for function in functions_of(declared):
            for parameter in declared.parameters:
                kind = next((kind for kind in WORDS if isinstance(parameter, kind)), None)
                known = inspect.signature(function).parameters
                if kind is None or parameter.name not in known or (function, parameter.name) in seen:
                    continue
                if arguments(function, declared) is None:
                    continue
                seen.add((function, parameter.name))
                yield pytest.param(declared, function, parameter, kind, id=f"{function.__name__}-{parameter.name}")


@pytest.mark.parametrize(("declared", "function", "parameter", "kind"), list(function_cases()))
def test_a_function_refuses_in_the_same_words(
    declared: Filter, function: Callable[..., Any], parameter: Parameter, kind: type[Parameter]
) -> None:
    """The function behind a filter, called with arrays, names parameter and value as every other does."""
    given = arguments(function, declared, parameter.name)
    assert given is not None
    for value in WORDS[kind][0]:
        words = re.escape(WORDS[kind][1].format(name=parameter.name, value=repr(value)))
        with pytest.raises(FilterInputError, match=f"^{words}"):
            function(**{**given, parameter.name: value})


def test_most_filters_have_a_function_to_try() -> None:
    """The search for functions finds one behind every filter that has numbers or words of its own, but for those listed."""
    found = {declared.python_name for declared in FILTERS if any(arguments(f, declared) for f in functions_of(declared))}
    assert {declared.python_name for declared in FILTERS} - found == set()
