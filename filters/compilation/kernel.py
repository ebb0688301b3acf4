"""A function that numba compiles when it is first called, not when its module is imported.

To import numba, and to make one of its dispatchers of every function, takes half a second. A command that only reads what filters
declare, and a run that uses ten of two hundred functions, do without.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import cached_property
from types import FunctionType
from typing import TYPE_CHECKING, Any, Literal, TypeVar, overload

from .fingerprint import fingerprint

if TYPE_CHECKING:
    from numba import prange as prange
else:

    class prange:  # noqa: N801 - as numba calls it
        """Numba's ``prange``, which a kernel gets when it is compiled; a plain range before."""

        def __new__(cls, *limits: int) -> range:
            """A range, which runs the function without numba."""
            return range(*limits)


#: what a type checker sees of a kernel: the function that it is made of
Function = TypeVar("Function", bound=Callable[..., Any])


class Kernel:
    """A function of arrays and numbers that runs as machine code.

    Numba sees it as a function of its own: kernels call each other, and take each other as arguments.

    Attributes:
        py_func: the function, which Python can run too.
        options: what numba is told besides.
    """

    def __init__(self, function: FunctionType, options: dict[str, Any]) -> None:
        """See `compiled`."""
        self.py_func = function
        self.options = options
        self.__name__ = function.__name__
        self.__qualname__ = function.__qualname__
        self.__module__ = function.__module__
        self.__doc__ = function.__doc__

    def __call__(self, *arguments: Any) -> Any:
        """The function's result; for arguments of new types it is loaded or compiled first."""
        if self.options.get("parallel"):
            from .numba_threads import call_parallel

            return call_parallel(self.dispatcher, *arguments)
        return self.dispatcher(*arguments)

    def __repr__(self) -> str:
        return f"<kernel {self.__module__}.{self.__qualname__}>"

    @cached_property
    def dispatcher(self) -> Any:
        """What numba makes of the function; it takes what was compiled before from the store."""
        from .notices import listen_to_numba
        from .numba_threads import load_numba
        from .stored import StoredKernels

        numba = load_numba()
        listen_to_numba()
        function = self.py_func
        if self.options.get("parallel"):
            names = {**function.__globals__, "prange": numba.prange}
            function = FunctionType(function.__code__, names, function.__name__, function.__defaults__, function.__closure__)
            function.__module__, function.__qualname__ = self.__module__, self.__qualname__
        made = numba.njit(**self.options)(function)
        made._cache = StoredKernels(self)
        return made

    @cached_property
    def fingerprint(self) -> str:
        """A hash of everything that the machine code follows from, the types of the arguments aside."""
        return fingerprint(self.py_func, self.options)

    @property
    def signatures(self) -> list[Any]:
        """The types of arguments for which this process has machine code."""
        return list(self.dispatcher.signatures) if "dispatcher" in self.__dict__ else []

    def compile(self, signature: Any) -> None:
        """Load or compile it for these types of arguments."""
        self.dispatcher.compile(signature)

    @property
    def _numba_type_(self) -> Any:
        """The type that numba sees."""
        return self.dispatcher._numba_type_


@overload
def compiled(function: Function, /) -> Function: ...


@overload
def compiled(
    *, nogil: bool = ..., parallel: bool = ..., fastmath: object = ..., error_model: Literal["python", "numpy"] = ...
) -> Callable[[Function], Function]: ...


def compiled(function: Any = None, /, **options: Any) -> Any:
    """Make a `Kernel` of a function: ``@compiled`` or ``@compiled(nogil=True)``.

    Args:
        function: it may use what numba knows, and other kernels.
        **options: numba's: `nogil` lets other threads run meanwhile, `parallel` gives the loops over `prange` to numba's threads,
            `fastmath` names the freedom that sums may take, and with "numpy" for `error_model` a division by 0 is no error: loops
            without a look at each divisor are done for several elements at once.
    """
    return Kernel(function, options) if function is not None else lambda function: Kernel(function, options)


def loaded_kernels(package: str) -> Iterator[tuple[str, str, Kernel]]:
    """Module, name and kernel of all that are defined in loaded modules of a package."""
    for module_name, module in list(sys.modules.items()):
        if module_name.startswith(f"{package}."):
            for name, value in list(vars(module).items()):
                if isinstance(value, Kernel) and value.__module__ == module_name:
                    yield module_name, name, value
