"""Stores machine code that numba has made, and loads it without numba, whose import takes longer than most filters.

Code of the installation lies beside this module, other code in a folder of the user, under a name with all that it depends on.
It calls small functions in C, of numba's own extension modules; these are loaded by their paths, and the code is linked with them
by llvmlite. `compiler` makes the code; a test compares both ways of loading it. The threads of parallel kernels are OpenMP's,
through numba's module, or numba's own where there is no OpenMP.
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
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

#: The levels of x86-64, the best first, and a few features of each.
_X86_LEVELS = (
    ("x86-64-v3", ("avx2", "bmi2", "f16c", "fma", "lzcnt", "movbe")),
    ("x86-64-v2", ("cx16", "popcnt", "sse4.2", "ssse3")),
)
_LOCK = threading.RLock()
#: The kernels that come with the package; only the installation writes there.
INSTALLED = Path(__file__).parent / "kernels"
#: The functions that parallel code calls besides ``numba_parallel_for``.
_FUNCTIONS = (
    *("do_scheduling_signed", "do_scheduling_unsigned", "allocate_sched", "deallocate_sched", "get_sched_size"),
    *("get_num_threads", "set_num_threads", "get_thread_id", "set_parallel_chunksize", "get_parallel_chunksize"),
)
_OF_THREAD = threading.local()


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


def lasts() -> bool:
    """Whether later processes find the code that this one compiles: whether the user's folder can be written."""
    folder = users_folder()
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        return os.access(folder, os.W_OK | os.X_OK)
    return False


def users_folder() -> Path:
    """The user's folder for compiled code: in NUMBA_CACHE_DIR, or where the system keeps caches."""
    if folder := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(folder) / "pymeshfair"
    home = Path("~").expanduser()
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData/Local") / "pymeshfair" / "kernels"
    if sys.platform == "darwin":
        return home / "Library/Caches/pymeshfair/kernels"
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache") / "pymeshfair" / "kernels"


class Stored(NamedTuple):
    """The compiled functions for this Python, this numba and this processor."""

    installed: int  # the number of kernels that came compiled with the package
    kept: int  # the number of kernels compiled since
    folder: Path  # the folder of the latter
    lasts: bool  # whether that folder can be written; if not, every process compiles missing kernels anew


def stored() -> Stored:
    """The compiled functions that are stored."""
    folder = users_folder()
    installed, kept = (sum(1 for _ in (place / made_here()).glob("*")) for place in (INSTALLED, folder))
    return Stored(installed, kept, folder, lasts())


def read(name: str) -> MachineCode | None:
    """The data stored under that name, or None."""
    for place in (INSTALLED, users_folder()):
        with suppress(OSError, EOFError, pickle.UnpicklingError, TypeError, ValueError):  # a disk that was full or has failed
            return MachineCode(*pickle.loads((place / made_here() / name).read_bytes()))
    return None


def write(name: str, code: MachineCode) -> None:
    """Store it; a file appears whole or not at all, as several processes may write the same one."""
    place = users_folder() / made_here()
    with suppress(OSError):  # where nothing can be written the next process compiles it again
        place.mkdir(parents=True, exist_ok=True)
        part = place / f"{uuid.uuid4().hex}.part"
        try:
            part.write_bytes(pickle.dumps(tuple(code)))
            part.replace(place / name)
        finally:
            part.unlink(missing_ok=True)


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
    folder = Path(spec.origin).parent.joinpath(*name.split(".")[:-1])
    found = importlib.machinery.PathFinder.find_spec(whole, [str(folder)])
    if found is None or found.loader is None:
        raise ImportError(f"numba has no extension module {name} for this Python")
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


_unpickled: dict[int, Any] = {}


@ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
def _UNPICKLE(data: int, size: int, digest: int) -> Any:  # noqa: N802 - stands for a function in C
    """A constant in numba's code: a class, or the arguments of an exception."""
    if data not in _unpickled:
        _unpickled[data] = pickle.loads(ctypes.string_at(data, size))
    return _unpickled[data]


@cache
def most_threads() -> int:
    """The number of threads: one a processor that this process may use, or NUMBA_NUM_THREADS."""
    if count := os.environ.get("NUMBA_NUM_THREADS"):
        return max(1, int(count))
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def allowed_threads() -> int:
    """The number of threads that kernels called from this thread may use."""
    return int(getattr(_OF_THREAD, "count", most_threads()))


def set_threads(count: int) -> None:
    """Let kernels called from this thread use so many threads, from 1 to `most_threads`."""
    if not 1 <= count <= most_threads():
        raise ValueError(f"the number of threads must be from 1 to {most_threads()}, got {count}")
    _OF_THREAD.count = count


@contextmanager
def single_thread() -> Iterator[None]:
    """A context in which kernels called from this thread use one thread."""
    before = allowed_threads()
    set_threads(1)
    try:
        yield
    finally:
        set_threads(before)


def call_parallel(code: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """Call a parallel kernel with no more threads than this one allows.

    Without OpenMP, as on a bare Linux and on macOS, two callers at once would end the process: one waits for the other.
    """
    set_number, turns = start_threads()
    with turns:
        set_number(allowed_threads())
        return code(*arguments)


@cache
def start_threads() -> tuple[Any, Any]:
    """Starts the threads; the function that sets their number for this thread, and the lock, if only one may call at a time."""
    import llvmlite.binding as llvm

    turns: Any = nullcontext()
    try:
        layer = extension("np.ufunc.omppool")
    except ImportError:
        layer, turns = extension("np.ufunc.workqueue"), threading.Lock()
    llvm.add_symbol("numba_parallel_for", layer.parallel_for)
    for name in _FUNCTIONS:
        llvm.add_symbol(name, getattr(layer, name))
    ctypes.CFUNCTYPE(None, ctypes.c_int)(layer.launch_threads)(most_threads())
    return ctypes.CFUNCTYPE(None, ctypes.c_int)(layer.set_num_threads), turns
