"""The types of arguments, as short texts: what machine code is made for, and found again by."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from ..checks import PymeshfairError

#: the type of an argument: ``"float64"``, ``"int64"``, ``"bool"``, ``"none"``; of an array with its number of axes and its
#: layout (C, F, or A for any) ``"float64 2 C"``, and ``"float64 2 C readonly"``; a tuple of types; and for a named tuple the
#: module and the name of its class, then the tuple
ArgumentType: TypeAlias = "str | tuple[Any, ...]"
Signature: TypeAlias = "tuple[ArgumentType, ...]"

_NAMES = {
    dtype: np.dtype(dtype).name
    for dtype in ("?", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8")
}  # fmt: skip
_DTYPES = {np.dtype(code): name for code, name in _NAMES.items()}
_PLAIN: dict[type, str] = {bool: "bool", int: "int64", float: "float64", type(None): "none"}
_PLAIN |= {dtype.type: name for dtype, name in _DTYPES.items()}
#: by dtype, number of axes and flags of an array
_ARRAYS: dict[tuple[Any, int, int], str] = {}


class UnknownTypeError(PymeshfairError, TypeError):
    """An argument is of a type that has no text here."""


def signature_of(arguments: tuple[Any, ...]) -> Signature:
    """The types of arguments.

    Raises:
        UnknownTypeError: one has another type than those of `ArgumentType`.
    """
    return tuple([_type_of(value) for value in arguments])


def _type_of(value: Any) -> ArgumentType:
    kind = type(value)
    if kind is np.ndarray:
        key = (value.dtype, value.ndim, value.flags.num)
        name = _ARRAYS.get(key)
        if name is None:
            name = _ARRAYS[key] = _array_type(value)
        return name
    plain = _PLAIN.get(kind)
    if plain is not None:
        return plain
    if isinstance(value, tuple):
        parts = tuple([_type_of(part) for part in value])
        return parts if kind is tuple else (f"{kind.__module__}:{kind.__qualname__}", parts)
    if isinstance(value, np.ndarray):
        return _type_of(value.view(np.ndarray))
    raise UnknownTypeError(f"no machine code is made for {kind.__name__}")


def _array_type(array: np.ndarray[Any, Any]) -> str:
    name = _DTYPES.get(array.dtype)
    if name is None or not array.flags.aligned:
        raise UnknownTypeError(f"no machine code is made for arrays of {array.dtype}")
    layout = "C" if array.flags.c_contiguous else "F" if array.flags.f_contiguous else "A"
    return f"{name} {array.ndim} {layout}" + ("" if array.flags.writeable else " readonly")


def from_json(document: Any) -> Any:
    """The type, or signature, that was written as JSON: lists are tuples."""
    return tuple(from_json(part) for part in document) if isinstance(document, list) else document
