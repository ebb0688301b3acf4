"""The compiler process, which imports numba so that the processes that call kernels need not.

The first kernel without stored machine code starts the compiler process, which ends with its parent process.
"""

from __future__ import annotations

import atexit
import importlib
import itertools
import os
import pickle
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from ..checks import PymeshfairError
from .machine_code import MachineCode, processor

if TYPE_CHECKING:
    from .kernel import ArgumentType, Signature

#: Environment variables of the compiler process, in place of the user's numba settings.
#: The SLP vectoriser computes the three coordinates of a point at once: a smoothing step of 10,000 vertices takes 30 % less time.
SETTINGS = {"NUMBA_DISABLE_INTEL_SVML": "1", "NUMBA_CPU_FEATURES": "", "NUMBA_SLP_VECTORIZE": "1", "PYTHONDONTWRITEBYTECODE": "1"}


class CompilationError(PymeshfairError, ImportError):
    """A kernel could not be compiled; the message says why."""


class Compiler:
    """The compiler process, which one thread at a time uses."""

    def __init__(self) -> None:
        self.__dict__.pop("_process", None)
        self._lock = threading.Lock()

    @cached_property
    def _process(self) -> subprocess.Popen[bytes]:
        inherited = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
        process = subprocess.Popen(
            [sys.executable, "-c", f"from {__name__} import main; main()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**inherited, **SETTINGS, "NUMBA_CPU_NAME": processor()},
        )
        atexit.register(self.close)
        self._send(process, sys.path)
        return process

    def compile(self, module: str, name: str, signature: Signature) -> MachineCode:
        """Compiles the kernel ``module.name`` for these argument types; raises `CompilationError` if this fails."""
        with self._lock:
            try:
                process = self._process  # `close` in another thread may remove `_process`
                self._send(process, (module, name, signature))
                assert process.stdout is not None
                answer = pickle.load(process.stdout)
            except (OSError, EOFError, ValueError, pickle.UnpicklingError) as error:
                self.__dict__.pop("_process", None)
                raise CompilationError(f"the process that compiles {module}.{name} has ended") from error
            except BaseException:
                self.close()  # else the next caller would get the answer to this request
                raise
        if isinstance(answer, str):
            raise CompilationError(f"{module}.{name}: {answer}")
        return MachineCode(*answer)

    def close(self) -> None:
        process = self.__dict__.pop("_process", None)
        if process is not None:
            atexit.unregister(self.close)
            with process:  # closes the pipes
                process.kill()

    @staticmethod
    def _send(process: subprocess.Popen[bytes], message: Any) -> None:
        assert process.stdin is not None
        process.stdin.write(pickle.dumps(message))
        process.stdin.flush()


def numba_type(argument_type: ArgumentType) -> Any:
    """Returns the numba type of a `pymeshfair.filters.compilation.kernel.ArgumentType`."""
    types: Any = importlib.import_module("numba").types
    if isinstance(argument_type, tuple):
        if len(argument_type) == 2 and isinstance(argument_type[0], str) and ":" in argument_type[0]:
            module, _, name = argument_type[0].partition(":")
            kind = attrgetter(name)(importlib.import_module(module))
            return types.BaseTuple.from_types([numba_type(part) for part in argument_type[1]], kind)
        return types.BaseTuple.from_types([numba_type(part) for part in argument_type])
    name, *layout = argument_type.split()
    scalar = {"bool": types.boolean, "none": types.none}.get(name) or getattr(types, name)
    return types.Array(scalar, int(layout[0]), layout[1], readonly="readonly" in layout) if layout else scalar


def machine_code(kernel: Any, signature: Signature) -> MachineCode:
    """Compiles a kernel with numba; runs in the compiler process."""
    # Numba gives every function a number, which its symbol contains. Two compiler processes must not make equal symbols, since
    # the linker would confuse them. So the numbers start at a hash of the kernel.
    identity: Any = importlib.import_module("numba.core.bytecode").FunctionIdentity
    identity._unique_ids = itertools.count(int(kernel.stored_name(signature)[-16:], 16))
    dispatcher = kernel.dispatcher
    arguments: Any = tuple(numba_type(argument_type) for argument_type in signature)
    dispatcher.compile(arguments)
    result = dispatcher.overloads[arguments]
    if result.library.has_dynamic_globals:
        raise CompilationError("its machine code holds addresses of the compiler process, so no other process can load it")
    _, _, (object_code, _) = result.library.serialize_using_object_code()
    constants = tuple(result.environment.consts)
    return MachineCode(object_code, result.fndesc.llvm_cpython_wrapper_name, result.fndesc.env_name, constants)


def main() -> None:
    """Compiles the kernels requested on stdin until stdin is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal; the parent ends this one
    orders, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDWR), 0)
    os.dup2(2, 1)  # stdout carries the answers, so prints go to stderr
    sys.path[:] = pickle.load(orders)
    with suppress(EOFError):
        while True:
            module, name, signature = pickle.load(orders)
            try:
                answer = pickle.dumps(tuple(machine_code(getattr(importlib.import_module(module), name), signature)))
            except Exception as error:
                answer = pickle.dumps(f"{type(error).__name__}: {error}")
            answers.write(answer)
            answers.flush()


COMPILER = Compiler()
if hasattr(os, "register_at_fork"):  # a forked process must not read answers to its parent or wait for the parent's threads
    os.register_at_fork(after_in_child=lambda: Compiler.__init__(COMPILER))
