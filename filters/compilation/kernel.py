"""Kernels are functions compiled by numba. Their machine code is stored; the first call loads it, or compiles it.

The name of the stored file contains a hash of the function's code and of all functions and constants that it uses. Numba's own
cache does not notice changes of functions and constants imported from other files.

``signatures.json`` lists the kernels and argument types that the shipped recipes and all filters with default parameters use.
The build of a wheel and ``pymeshfair doctor --warm`` compile these kernels ahead; ``tools/generate.py kernels`` writes the list.
"""

import hashlib
import importlib
import json
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial, update_wrapper
from pathlib import Path
from queue import SimpleQueue
from types import CodeType, FunctionType, ModuleType
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeVar, overload

import numpy as np

from ..checks import PymeshfairError
from . import machine_code
from .compiler import COMPILER, SETTINGS, CompilationError, Compiler
from .machine_code import most_threads, start_threads

#: The type of an argument. A number: ``"float64"``, ``"int64"``, ``"bool"``; None: ``"none"``. An array with its number of axes
#: and its layout (C, F, or A for any): ``"float64 2 C"``, ``"float64 2 C readonly"``. A tuple: the tuple of the types. A named
#: tuple: (``"module:class"``, the tuple of the types).
ArgumentType: TypeAlias = "str | tuple[Any, ...]"
Signature: TypeAlias = "tuple[ArgumentType, ...]"

_DTYPES = {np.dtype(code): np.dtype(code).name for code in ("?", *["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"])}
_PLAIN: dict[type, str] = {bool: "bool", int: "int64", float: "float64", type(None): "none"}
_PLAIN |= {dtype.type: name for dtype, name in _DTYPES.items()}
_FORMAT = 2  # of stored code; in format 1, two functions could have the same symbol
_C, _F, _ALIGNED, _WRITEABLE = 0x1, 0x2, 0x100, 0x400  # numpy's flags of an array
LIST = Path(__file__).parent / "signatures.json"
#: The signatures by module and kernel name.
Signatures: TypeAlias = dict[str, dict[str, list[Signature]]]


class UnknownTypeError(PymeshfairError, TypeError):
    """The type of an argument is not an `ArgumentType`."""


def signature_of(arguments: tuple[Any, ...]) -> Signature:
    """Returns the types of the arguments; raises `UnknownTypeError` if one is not an `ArgumentType`."""
    return tuple([_type_of(value) for value in arguments])


def _type_of(value: Any) -> ArgumentType:
    kind = type(value)
    if kind is np.ndarray:
        return _array_type(value.dtype, value.ndim, value.flags.num)
    if (plain := _PLAIN.get(kind)) is not None:
        return plain
    if isinstance(value, tuple):
        parts = tuple([_type_of(part) for part in value])
        return parts if kind is tuple else (f"{kind.__module__}:{kind.__qualname__}", parts)
    if isinstance(value, np.ndarray):
        return _type_of(value.view(np.ndarray))
    raise UnknownTypeError(f"no machine code is made for {kind.__name__}")


@cache
def _array_type(dtype: np.dtype[Any], axes: int, flags: int) -> str:
    name = _DTYPES.get(dtype)
    if name is None or not flags & _ALIGNED:
        raise UnknownTypeError(f"no machine code is made for arrays of {dtype}")
    layout = "C" if flags & _C else "F" if flags & _F else "A"
    return f"{name} {axes} {layout}" + ("" if flags & _WRITEABLE else " readonly")


def from_json(document: Any) -> Any:
    """Reads a type or a signature from JSON, where tuples are lists."""
    return tuple(from_json(part) for part in document) if isinstance(document, list) else document


if TYPE_CHECKING:
    from numba import prange as prange
else:

    class prange:  # noqa: N801 - numba's name
        """A plain ``range``, so that functions also run without numba; the compiler replaces it by numba's ``prange``."""

        def __new__(cls, *limits: int) -> range:
            return range(*limits)


def fingerprint(function: FunctionType, options: dict[str, Any]) -> str:
    """Hashes a function and the numba options; raises `TypeError` if the function uses a value that cannot be hashed."""
    parts = [f"options {sorted(options.items())!r}", f"defaults {function.__defaults__!r}"]
    parts += [f"closure {_of_value(cell.cell_contents, function)}" for cell in function.__closure__ or ()]
    text = "\n".join([*parts, *_of_code(function.__code__, function)])
    return hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()


def _of_code(code: CodeType, function: FunctionType) -> Iterator[str]:
    yield f"code {code.co_code.hex()} {code.co_argcount} {code.co_flags} {code.co_varnames} {code.co_names}"
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _of_code(constant, function)
        elif constant != function.__doc__ or constant is None:
            yield f"constant {constant!r}"
    for name in code.co_names:
        if name in function.__globals__:
            yield f"global {name} {_of_value(function.__globals__[name], function)}"


def _of_value(value: Any, function: FunctionType) -> str:
    if isinstance(value, Kernel):
        return "itself" if value.py_func is function else value.fingerprint
    if isinstance(value, ModuleType):
        return value.__name__
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic | np.dtype):
        return repr(value)
    if isinstance(value, tuple):
        return f"({', '.join(_of_value(each, function) for each in value)})"
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, type) or type(value).__name__ in ("builtin_function_or_method", "ufunc"):
        return f"{getattr(value, '__name__', '')} {getattr(value, '_fields', '')}"
    raise TypeError(f"{function.__module__}.{function.__qualname__} uses {value!r}, which cannot be hashed")


#: For a type checker a kernel has the type of its Python function.
Function = TypeVar("Function", bound=Callable[..., Any])


class Kernel:
    """A function that runs as machine code, see `compiled`. Kernels can call kernels: numba treats them as its own functions."""

    __qualname__: str  # of the function

    def __init__(self, function: FunctionType, options: dict[str, Any]) -> None:
        self.py_func, self.options = function, options
        update_wrapper(self, function)
        self.code: dict[Signature, Callable[..., Any]] = {}  # the machine code that this process has loaded

    def __call__(self, *arguments: Any) -> Any:
        try:
            signature = signature_of(arguments)
        except UnknownTypeError:
            return self.dispatcher(*arguments)
        code = self.code.get(signature) or self._loaded(signature)
        if not self._is_parallel:
            return code(*arguments)
        set_number, lock = start_threads()
        with lock:  # without OpenMP (macOS, Linux without libgomp) two calls at once would crash the process
            set_number(allowed_threads())
            return code(*arguments)

    def _loaded(self, signature: Signature) -> Callable[..., Any]:
        if self._is_parallel:
            start_threads()  # the linker needs the addresses of the thread functions
            if hasattr(os, "register_at_fork"):
                os.register_at_fork(after_in_child=self.code.clear)  # a fork uses other thread functions, see `_begin_fork`
        if self.__module__ == "__main__" or getattr(sys.modules.get(self.__module__), self.__qualname__, None) is not self:
            return self.code.setdefault(signature, self.dispatcher)  # the compiler process cannot import this kernel
        name = self.stored_name(signature)
        code = machine_code.read(name)
        if code is None:
            with compiling():
                code = COMPILER.compile(self.__module__, self.__qualname__, signature)
            machine_code.write(name, code)
        with _LOADING:  # two copies of the code would share one environment object, and freeing a copy may free it
            loaded: Callable[..., Any] = self.code.get(signature) or machine_code.load(code, self.__name__)
            self.code[signature] = loaded
        return loaded

    @cached_property
    def _is_parallel(self) -> bool:
        names = self.py_func.__globals__
        called = (names.get(name) for name in self.py_func.__code__.co_names if names.get(name) is not self)
        return bool(self.options.get("parallel")) or any(isinstance(each, Kernel) and each._is_parallel for each in called)

    def stored_name(self, signature: Signature) -> str:
        key = hashlib.sha256(f"{_FORMAT} {self.fingerprint} {SETTINGS} {signature!r}".encode()).hexdigest()
        return f"{self.__module__.rpartition('.')[2]}.{self.__qualname__}-{key[:32]}"

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher, for the compiler process, kernels that it cannot import, and arguments without a `Signature`."""
        import numba

        function = self.py_func
        if self._is_parallel:
            names = {**function.__globals__, "prange": numba.prange}
            function = FunctionType(function.__code__, names, function.__name__, function.__defaults__, function.__closure__)
            function.__module__, function.__qualname__ = self.__module__, self.__qualname__
        return numba.njit(**self.options)(function)

    @cached_property
    def fingerprint(self) -> str:
        return fingerprint(self.py_func, self.options)

    @property
    def _numba_type_(self) -> Any:
        return self.dispatcher._numba_type_


@overload
def compiled(function: Function, /) -> Function: ...


@overload
def compiled(
    *, nogil: bool = ..., parallel: bool = ..., fastmath: object = ..., error_model: Literal["python", "numpy"] = ...
) -> Callable[[Function], Function]: ...


def compiled(function: Any = None, /, **options: Any) -> Any:
    """Makes a `Kernel` of a function: ``@compiled`` or ``@compiled(nogil=True)``.

    Args:
        function: may use the Python and NumPy that numba supports, and other kernels.
        **options: numba's options. `nogil` releases the interpreter lock. `parallel` runs loops over `prange` on several threads.
            `fastmath` names the allowed changes of floating-point operations. With "numpy" as `error_model` a division by 0
            raises no error, so that loops with divisions can be vectorised.
    """
    return Kernel(function, options) if function is not None else lambda function: Kernel(function, options)


def allowed_threads() -> int:
    """The number of threads that kernels called from this thread may use."""
    return int(getattr(_OF_THREAD, "count", most_threads()))


def set_threads(count: int) -> None:
    """Sets the number of threads, from 1 to `most_threads`, for kernels called from this thread."""
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


@dataclass(frozen=True)
class Compilation:
    """The compilations of this process so far."""

    kernels: int = 0  # those whose compilation has begun; a kernel that another kernel calls is compiled with it and not counted
    seconds: float = 0.0  # the total time of the finished ones
    is_going_on: bool = False


_LOADING = threading.Lock()
_OF_THREAD = threading.local()
_listeners: list[Callable[[Compilation], None]] = []
_so_far = [Compilation()]


def on_compilation(listener: Callable[[Compilation], None]) -> Callable[[], None]:
    """Calls the listener before and after each compilation that a kernel's call waits for; the returned function ends this."""
    _listeners.append(listener)
    return partial(_listeners.remove, listener)


@contextmanager
def compiling() -> Iterator[None]:
    """A context in which a kernel is compiled; calls the listeners at its start and its end."""

    def update(**changes: Any) -> None:
        _so_far[0] = replace(_so_far[0], **changes)
        for listener in _listeners:
            listener(_so_far[0])

    before, started = _so_far[0], time.perf_counter()
    update(kernels=before.kernels + 1, is_going_on=True)
    try:
        yield
    finally:
        update(seconds=before.seconds + time.perf_counter() - started, is_going_on=False)


def listed_signatures() -> Signatures:
    """Reads the signatures to compile ahead."""
    listed = json.loads(LIST.read_text("utf-8"))
    return {module: {name: list(from_json(each)) for name, each in kernels.items()} for module, kernels in listed.items()}


def compile_ahead(signatures: Mapping[str, Mapping[str, list[Signature]]], *, processes: int | None = None) -> list[str]:
    """Compiles all kernels that are not stored yet; `processes` None means `most_threads`. Returns messages of failures."""
    tasks = [(m, name, types) for m, kernels in signatures.items() for name, each in kernels.items() for types in each]
    count = processes or most_threads()
    compilers = [Compiler() for _ in range(count)]
    idle: SimpleQueue[Compiler] = SimpleQueue()
    for compiler in compilers:
        idle.put(compiler)
    with ThreadPoolExecutor(count) as pool:
        try:
            return [message for messages in pool.map(lambda task: _compile(idle, *task), tasks) for message in messages]
        finally:
            pool.shutdown(wait=False, cancel_futures=True)  # after Ctrl-C no other compilation starts
            for compiler in compilers:
                compiler.close()


def _compile(idle: SimpleQueue[Compiler], module: str, name: str, signature: Signature) -> list[str]:
    compiler = idle.get()
    try:
        stored = getattr(importlib.import_module(module), name).stored_name(signature)
        if machine_code.read(stored) is None:
            machine_code.write(stored, compiler.compile(module, name, signature))
    except (CompilationError, ImportError, AttributeError, TypeError) as error:  # an outdated list only costs time later
        return [f"{module}.{name}: {type(error).__name__}: {error}"]
    finally:
        idle.put(compiler)
    return []
