"""What the machine code of a function follows from, as a hash: its own code and all that it takes from elsewhere.

Numba's own cache looks at the file that a function is in, and misses a change of a function or constant of another file that was
compiled into it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np


def fingerprint(function: FunctionType, options: dict[str, Any]) -> str:
    """The hash of a function that numba compiles with these options.

    Raises:
        TypeError: the function uses something whose changes cannot be seen.
    """
    parts = "\n".join(_of_function(function, options))
    return hashlib.sha256(parts.encode("utf-8", "backslashreplace")).hexdigest()


def _of_function(function: FunctionType, options: dict[str, Any]) -> Iterator[str]:
    yield f"options {sorted(options.items())!r}"
    yield f"defaults {function.__defaults__!r}"
    for cell in function.__closure__ or ():
        yield f"closure {_of_value(cell.cell_contents, function)}"
    yield from _of_code(function.__code__, function)


def _of_code(code: CodeType, function: FunctionType) -> Iterator[str]:
    yield f"code {code.co_code.hex()} {code.co_argcount} {code.co_flags} {code.co_varnames} {code.co_names}"
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _of_code(constant, function)
        else:
            yield f"constant {constant!r}"
    for name in code.co_names:
        if name in function.__globals__:
            yield f"global {name} {_of_value(function.__globals__[name], function)}"


def _of_value(value: Any, function: FunctionType) -> str:
    if hasattr(value, "fingerprint") and hasattr(value, "py_func"):
        return "itself" if value.py_func is function else str(value.fingerprint)
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
    raise TypeError(f"{function.__module__}.{function.__qualname__} uses {value!r}, of which no hash can be made")
