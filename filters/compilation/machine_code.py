"""Stores machine code compiled by numba, and loads it without numba, whose import takes longer than most filters.

Machine code calls C functions of numba's extension modules. These modules are loaded by their paths; llvmlite links the code.
"""

import builtins
import ctypes
import hashlib
import importlib.machinery
import importlib.metadata
import importlib.util
import os
import pickle
import platform
import sys
import threading
import uuid
from collections.abc import Callable
from contextlib import nullcontext, suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

#: The levels of x86-64, the best first, and some features that each requires.
_X86_LEVELS = (
    ("x86-64-v3", ("avx2", "bmi2", "f16c", "fma", "lzcnt", "movbe")),
    ("x86-64-v2", ("cx16", "popcnt", "sse4.2", "ssse3")),
)
_LOCK = threading.RLock()
#: In a fork: the linkers of its parent processes. They are kept, because freeing a linker frees the code that it has linked.
_FORMER: list[Any] = []
#: The folder of kernels that come with the package.
INSTALLED = Path(__file__).parent / "kernels"
#: The C functions that parallel code calls besides ``numba_parallel_for``.
_FUNCTIONS = (
    *("do_scheduling_signed", "do_scheduling_unsigned", "allocate_sched", "deallocate_sched", "get_sched_size"),
    *("get_num_threads", "set_num_threads", "get_thread_id", "set_parallel_chunksize", "get_parallel_chunksize"),
)


class MachineCode(NamedTuple):
    """The machine code of one function for one signature."""

    object: bytes  # an object file
    function: str  # the symbol of the function, which takes Python arguments
    environment: str  # the symbol of the variable that points to the constants
    constants: tuple[Any, ...]  # Python objects


@cache
def processor() -> str:
    """The target processor of the code: a level that many processors share, so that results have the same bits on all of them.

    The environment variable NUMBA_CPU_NAME overrides it.
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
def platform_name() -> str:
    """The folder name for this machine: the versions of Python, numba and llvmlite, the system and the processor."""
    numba, llvmlite = (importlib.metadata.version(name) for name in ("numba", "llvmlite"))
    return f"{sys.implementation.cache_tag}-numba{numba}-llvmlite{llvmlite}-{sys.platform}-{platform.machine()}-{processor()}"


def users_folder() -> Path:
    """The user's folder for compiled code: in NUMBA_CACHE_DIR, or in the cache folder of the system."""
    if folder := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(folder) / "pymeshfair"
    home = Path("/", os.path.expanduser("~"))  # noqa: PTH111 - "/~" for a user without a home, where pathlib raises an error
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData/Local") / "pymeshfair" / "kernels"
    if sys.platform == "darwin":
        return home / "Library/Caches/pymeshfair/kernels"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "pymeshfair" / "kernels"


class Stored(NamedTuple):
    """The kernels that are stored for this machine, see `platform_name`."""

    installed: int  # number of kernels in `INSTALLED`
    kept: int  # number of kernels in `folder`
    folder: Path  # the user's folder
    lasts: bool  # whether `folder` is writable; if not, every process compiles missing kernels again


def stored() -> Stored:
    """Counts the stored kernels."""
    folder = users_folder()
    installed, kept = (sum(1 for _ in (place / platform_name()).glob("*-*")) for place in (INSTALLED, folder))
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return Stored(installed, kept, folder, folder.is_dir() and os.access(folder, os.W_OK | os.X_OK))


def read(name: str) -> MachineCode | None:
    """Returns the code stored under a name, or None."""
    for place in (INSTALLED, users_folder()):
        with suppress(OSError):  # there is no such file
            data = (place / platform_name() / name).read_bytes()
            if data.endswith(hashlib.sha256(data[:-32]).digest()):  # damaged machine code would end the process
                return MachineCode(*pickle.loads(data))
    return None


def write(name: str, code: MachineCode) -> None:
    """Stores code under a name; atomically, since several processes may write the same file."""
    place = users_folder() / platform_name()
    with suppress(OSError):  # without the file the next process compiles the kernel again
        place.mkdir(parents=True, exist_ok=True)
        part = place / f"{uuid.uuid4().hex}.part"
        try:
            data = pickle.dumps(tuple(code))
            part.write_bytes(data + hashlib.sha256(data).digest())
            part.replace(place / name)
        finally:
            part.unlink(missing_ok=True)


def load(code: MachineCode, name: str) -> Callable[..., Any]:
    """Links machine code and returns its function, which holds a reference to the code; `name` is for messages."""
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
    """Loads what `read` and `load` need, so that the first kernel does not wait for it."""
    platform_name()
    _engine()


@cache
def _engine() -> tuple[Any, Any]:
    """LLVM's linker with the symbols of numba's C functions; and numba's module that makes Python functions."""
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
    """Loads an extension module, named relative to numba, without importing numba."""
    whole = f"numba.{name}"
    if whole in sys.modules:
        return sys.modules[whole]
    spec = importlib.util.find_spec("numba")
    if spec is None or spec.origin is None:
        raise ImportError("numba is not installed")
    folder = Path(spec.origin).parent.joinpath(*name.split(".")[:-1])
    module_spec = importlib.machinery.PathFinder.find_spec(whole, [str(folder)])
    if module_spec is None or module_spec.loader is None:
        raise ImportError(f"numba has no extension module {name} for this Python")
    module = importlib.util.module_from_spec(module_spec)
    module_spec.loader.exec_module(module)
    return module


@ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
@cache
def _UNPICKLE(data: int, size: int, digest: int) -> Any:  # noqa: N802 - stands for a function in C
    """Unpickles a constant of machine code (a class, or the arguments of an exception), once."""
    return pickle.loads(ctypes.string_at(data, size))


@cache
def most_threads() -> int:
    """The largest number of threads: NUMBA_NUM_THREADS if it is a number, else the number of processors for this process."""
    count = os.environ.get("NUMBA_NUM_THREADS", "").strip()
    if count.isdecimal():
        return max(1, int(count))
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def start_threads() -> tuple[Any, Any]:
    """Returns a function that sets how many threads the calling thread uses, and a lock for parallel calls (none with OpenMP)."""
    import llvmlite.binding as llvm

    layer: Any = None
    lock: Any = nullcontext()
    with suppress(ImportError):
        layer = None if _FORMER else extension("np.ufunc.omppool")
    if layer is None:
        layer, lock = extension("np.ufunc.workqueue"), threading.Lock()
    llvm.add_symbol("numba_parallel_for", layer.parallel_for)
    for name in _FUNCTIONS:
        llvm.add_symbol(name, getattr(layer, name))
    ctypes.CFUNCTYPE(None, ctypes.c_int)(layer.launch_threads)(most_threads())
    return ctypes.CFUNCTYPE(None, ctypes.c_int)(layer.set_num_threads), lock


def _begin_fork() -> None:
    """Makes a fork link kernels anew, to numba's own threads: GNU OpenMP kills a fork if the parent process has used it."""
    if start_threads.cache_info().currsize:
        _FORMER.append(_engine())
        _engine.cache_clear()
        start_threads.cache_clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_fork)
