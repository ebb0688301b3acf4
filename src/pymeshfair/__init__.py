"""Reproducible clean-up of 3D scans for MeshLab and Python.

`MeshSet` replaces pymeshlab's class and has more filters. `Recipe` is a chain of filters as an object. `run` cleans a file in a
separate process and returns a `RunResult`. Every error is a `PymeshfairError`; `errors` has its main subclasses. `search`
finds filters by words, and ``help(pymeshfair.MeshSet.apply_coord_implicit_fairing)`` explains that filter. All names of pymeshlab
are here too, so ``import pymeshfair as ml`` can replace ``import pymeshlab as ml``. The import loads neither pymeshlab nor numba.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pymeshfair.meshset.pymeshlab_classes as pymeshlab_classes

    from . import errors
    from .authoring import Recipe, run
    from .errors import PymeshfairError
    from .meshset import MeshSet
    from .meshset.methods import filter_list, print_filter_list, print_filter_parameter_list, search
    from .meshset.pymeshlab_classes import *  # noqa: F403
    from .registry import reload_plugins
    from .running.job import RunResult

    __version__: str

__all__ = [
    "MeshSet",
    "PymeshfairError",
    "Recipe",
    "RunResult",
    "__version__",
    "errors",
    "filter_list",
    "print_filter_list",
    "print_filter_parameter_list",
    "reload_plugins",
    "run",
    "search",
]


class _Public(list[str]):
    """The public names; ``help(pymeshfair)``, which tests names by ``in``, leaves out two classes with 300 methods each."""

    def __contains__(self, name: object) -> bool:
        return name not in ("MeshSet", "Recipe") and super().__contains__(name)


_OURS = {
    "MeshSet": "meshset",
    "Recipe": "authoring",
    "run": "authoring",
    "RunResult": "running.job",
    "PymeshfairError": "errors",
    "reload_plugins": "registry",
    **dict.fromkeys(("filter_list", "print_filter_list", "print_filter_parameter_list", "search"), "meshset.methods"),
}


def _from_elsewhere(name: str) -> Any:
    import importlib

    if name == "errors":
        return importlib.import_module(".errors", __name__)
    if name == "__version__":
        import importlib.metadata

        return importlib.metadata.version("pymeshfair")
    if name in _OURS:
        return getattr(importlib.import_module(f".{_OURS[name]}", __name__), name)
    if not name.startswith("_"):
        from .meshlab.loading import load_pymeshlab

        load_pymeshlab()
        import pymeshlab

        if hasattr(pymeshlab, name):
            return getattr(pymeshlab, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


if TYPE_CHECKING:
    __all__ += pymeshlab_classes.__all__
else:  # with `__getattr__` a type checker would accept any name
    __all__ = _Public(__all__)
    __getattr__ = _from_elsewhere


def __dir__() -> list[str]:
    _from_elsewhere("Mesh")  # names the system libraries that pymeshlab lacks
    import pymeshlab

    return sorted({*__all__, *(name for name in dir(pymeshlab) if not name.startswith("_"))})
