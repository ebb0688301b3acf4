"""Loads machine code that numba has made, without numba: its import takes longer than most filters.

Numba's code calls small functions in C, of numba's own extension modules; these are loaded by their paths, and the code is linked
with them by llvmlite. `compiler` makes the code; a test compares both ways of loading it.
"""

import builtins
import ctypes
import importlib.machinery
import importlib.metadata
import importlib.util
import os
import pickle
import platform
import sys
import threading
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

#: The levels of x86-64, the best first, and a few features of each.
_X86_LEVELS = (
    ("x86-64-v3", ("avx2", "bmi2", "f16c", "fma", "lzcnt", "movbe")),
    ("x86-64-v2", ("cx16", "popcnt", "sse4.2", "ssse3")),
)
_LOCK = threading.RLock()


class MachineCode(NamedTuple):
    """One function for one signature."""

    object: bytes  # an object file, as compilers write it
    function: str  # the symbol of the function that takes Python's arguments
    environment: str  # the symbol of the variable that points to its constants
    constants: tuple[Any, ...]  # which are objects of Python


@cache
def processor() -> str:
    """The processor that code is made for: a level that many share, so that results have the same bits on all of them.

    The environment variable NUMBA_CPU_NAME names another one.
    """
    if name := os.environ.get("NUMBA_CPU_NAME"):
        return name
    if platform.machine().lower() not in ("x86_64", "amd64"):
        return "generic"
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features()
    for level, needed in _X86_LEVELS:
        if all(features.get(feature) for feature in needed):
            return level
    return "x86-64"


@cache
def made_here() -> str:
    """A name of the versions of Python, numba and llvmlite, the system and the processor, on which code depends."""
    numba, llvmlite = (importlib.metadata.version(name) for name in ("numba", "llvmlite"))
    return f"{sys.implementation.cache_tag}-numba{numba}-llvmlite{llvmlite}-{sys.platform}-{platform.machine()}-{processor()}"


def load(code: MachineCode, name: str) -> Callable[..., Any]:
    """The function of compiled code, which holds a reference to the code; `name` is for messages."""
    import llvmlite.binding as llvm

    with _LOCK:
        engine, dynfunc = _engine()
        engine.add_object_file(llvm.ObjectFileRef.from_data(code.object))
        engine.finalize_object()
        function = engine.get_function_address(code.function)
        variable = engine.get_global_value_address(code.environment)
    if not (function and variable):
        raise ImportError(f"the machine code of {name} has no function {code.function}")
    environment = dynfunc.Environment({})
    environment.consts.extend(code.constants)
    ctypes.c_void_p.from_address(variable).value = id(environment)
    made: Callable[..., Any] = dynfunc.make_function(sys.modules[__name__], name, "machine code", function, environment, (code,))
    return made


def load_linker() -> None:
    """Loads the libraries of `load` now, not with the first function."""
    made_here()
    _engine()


@cache
def _engine() -> tuple[Any, Any]:
    """LLVM's linker, with numba's functions in C; and the module that makes functions of Python."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    helpers, dynfunc = extension("_helperlib"), extension("_dynfunc")
    runtime = extension("core.runtime._nrt_python")
    llvm.add_symbol("_Py_NoneStruct", id(None))
    for name, address in helpers.c_helpers.items():
        llvm.add_symbol(f"numba_{name}", address)
    for name, address in runtime.c_helpers.items():
        llvm.add_symbol(name if name.startswith("_") else f"NRT_{name}", address)
    llvm.add_symbol("numba_unpickle", ctypes.cast(_UNPICKLE, ctypes.c_void_p).value)
    for value in vars(builtins).values():
        if isinstance(value, type) and issubclass(value, BaseException):
            llvm.add_symbol(f"PyExc_{value.__name__}", id(value))
    machine = llvm.Target.from_default_triple().create_target_machine(jit=True, opt=3)
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine), dynfunc


@cache
def extension(name: str) -> Any:
    """An extension module of numba's by its name within numba, loaded without numba."""
    whole = f"numba.{name}"
    if whole in sys.modules:
        return sys.modules[whole]
    spec = importlib.util.find_spec("numba")
    if spec is None or spec.origin is None:
        raise ImportError("numba is not installed")
    *folders, last = name.split(".")
    folder = Path(spec.origin).parent.joinpath(*folders)
    for suffix in importlib.machinery.EXTENSION_SUFFIXES:
        if (path := folder / f"{last}{suffix}").exists():
            loader = importlib.machinery.ExtensionFileLoader(whole, str(path))
            module = importlib.util.module_from_spec(importlib.machinery.ModuleSpec(whole, loader, origin=str(path)))
            loader.exec_module(module)
            return module
    raise ImportError(f"numba has no extension module {name} for this Python")


_unpickled: dict[int, Any] = {}


@ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
def _UNPICKLE(data: int, size: int, digest: int) -> Any:  # noqa: N802 - stands for a function in C
    """A constant in numba's code: a class, or the arguments of an exception."""
    if data not in _unpickled:
        _unpickled[data] = pickle.loads(ctypes.string_at(data, size))
    return _unpickled[data]
