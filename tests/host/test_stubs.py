"""What type checkers and editors know of `MeshSet`."""

from __future__ import annotations

import ast
import inspect

import pymeshlab_stubs
import pytest
from stubs import STUB, format_stub, method_text

from pymeshfair.declaration import Bool, Filter, FilterClass, Matrix, Point, Shot
from pymeshfair.meshlab.base import FilterParameterError, UnknownFilterError
from pymeshfair.meshlab.facts import meshlab_filters
from pymeshfair.meshset import MeshSet
from pymeshfair.registry import custom_filters


def test_the_stub_is_current() -> None:
    """The stub is what `python tools/generate.py stubs` writes from today's declarations."""
    assert STUB.read_text(encoding="utf-8") == format_stub(), "run: python tools/generate.py"


def test_the_stub_says_what_the_methods_are() -> None:
    """Each filter, MeshLab's and our own, is a method of the stub with the parameters, defaults and text of the real one."""
    tree = ast.parse(STUB.read_text(encoding="utf-8"))
    (kind,) = [node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == "FilterMethods"]
    methods = {node.name: node for node in kind.body if isinstance(node, ast.FunctionDef)}
    known_to_all = [*meshlab_filters(), *(known for known in custom_filters() if known.origin == "pymeshfair")]
    assert {known.python_name for known in known_to_all} == methods.keys()
    assert len(methods) > 281
    for known in known_to_all:
        stub, real = methods[known.python_name], getattr(MeshSet, known.python_name)
        defaults = {p.name: p.default for p in inspect.signature(real).parameters.values() if p.name != "self"}
        assert [a.arg for a in stub.args.kwonlyargs] == [*defaults]
        told = [ast.literal_eval(d) for d in stub.args.kw_defaults if d is not None]
        long = {name for name, value in defaults.items() if len(repr(value)) > 90}
        assert told == [... if name in long else value for name, value in defaults.items()]
        assert long <= {"grammar", "transformmatrix"}
        assert ast.get_docstring(stub) == inspect.getdoc(real)


def test_every_kind_of_parameter_has_a_type() -> None:
    """Points, matrices and kinds without a type of their own are written, too, and quotes and backslashes survive."""
    known = Filter(
        python_name="odd",
        name="Odd",
        info='Says """quoted""" and \\n.',
        classes=FilterClass.OTHER,
        parameters=(
            Point(name="at", help="Where.", default=(0.0, 0.0, 1.0)),
            Matrix(name="matrix", help="How.", default=((1.0,),)),
            Bool(name="yes", help="Whether.", default=True),
            Shot(name="camera", help="From where."),
        ),
    )
    method = ast.parse("class A:\n" + "\n".join(method_text(known))).body[0]
    assert isinstance(method, ast.ClassDef)
    (function,) = method.body
    assert isinstance(function, ast.FunctionDef)
    types = [ast.unparse(a.annotation) for a in function.args.kwonlyargs if a.annotation is not None]
    assert types == ["PointLike", "MatrixLike", "bool", "Any"]
    assert (ast.get_docstring(function) or "").startswith(known.info)


def test_type_checkers_hold_the_parameters() -> None:
    """A value of the wrong type or a misspelt parameter is an error of the type checker (see the comments) and of the call."""
    meshes = MeshSet()
    meshes.create_cube()
    meshes.apply_coord_taubin_fairing(step=0.5, operator="uniform", border="free")
    meshes.meshing_isotropic_explicit_remeshing(iterations=1, targetlen="30%", selectedonly=False)
    with pytest.raises(UnknownFilterError, match="did you mean 'maxholesize'"):
        meshes.meshing_close_holes(maxholesiz=30)  # type: ignore[call-arg]
    with pytest.raises(FilterParameterError, match=r"'maxholesize' takes a whole number.*got 'many'"):
        meshes.meshing_close_holes(maxholesize="many")  # type: ignore[arg-type]
    with pytest.raises(FilterParameterError, match="parameter 'step' takes a number"):
        meshes.apply_coord_taubin_fairing(step="much")  # type: ignore[arg-type]
    with pytest.raises(FilterParameterError, match="parameter 'operator' takes one of"):
        meshes.apply_coord_taubin_fairing(operator="uniforn")  # type: ignore[arg-type]
    with pytest.raises(UnknownFilterError, match="did you mean 'step'"):
        meshes.apply_coord_taubin_fairing(stepp=0.5)  # type: ignore[call-arg]


def test_measures_are_never_none() -> None:
    """A filter that measures gives a dictionary, so that a strict checker takes its items (see the absence of a comment)."""
    meshes = MeshSet()
    meshes.create_cube()
    assert meshes.get_surface_measures()["vertices"] == 8


def test_the_stub_of_pymeshlab_is_current() -> None:
    """It is what pymeshlab says of itself today."""
    assert pymeshlab_stubs.STUB.read_text(encoding="utf-8") == pymeshlab_stubs.format_stub(), "run: python tools/generate.py"


def test_every_filter_can_be_completed() -> None:
    """`MeshSet` lists all of MeshLab's filters and ours, each with a signature that says a default or ``...`` and with words."""
    names = set(dir(MeshSet))
    for known in (*meshlab_filters(), *custom_filters()):
        assert known.python_name in names
        method = getattr(MeshSet, known.python_name)
        shown = inspect.signature(method).parameters
        assert [*shown] == ["self", *(p.name for p in known.parameters)]
        assert (method.__doc__ or "").strip()
    assert "maxholesize: int = 30" in str(inspect.signature(MeshSet.meshing_close_holes))
    assert "selected: bool = Ellipsis" in str(inspect.signature(MeshSet.meshing_close_holes))
