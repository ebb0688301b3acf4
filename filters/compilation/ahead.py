"""Compiles ahead of the first use, in several processes side by side: at installation, and by ``pymeshfair doctor --warm``.

``signatures.json`` lists the kernels and the types of their arguments: those that the shipped recipes and all filters with their
defaults use. ``tools/generate.py kernels`` writes it from runs of these.
"""

import importlib
import json
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from queue import SimpleQueue
from typing import Any, TypeAlias

from . import machine_code
from .compiler import CompilationError, Compiler
from .kernel import Signature, from_json
from .threads import most_threads

LIST = Path(__file__).parent / "signatures.json"
#: by module and kernel, the types of arguments
Signatures: TypeAlias = dict[str, dict[str, list[Signature]]]


def listed_signatures() -> Signatures:
    """The signatures that are compiled ahead."""
    listed = json.loads(LIST.read_text("utf-8"))
    return {module: {name: list(from_json(each)) for name, each in kernels.items()} for module, kernels in listed.items()}


def signatures_of(kernels: Iterable[tuple[str, str, Any]]) -> Signatures:
    """The types of arguments for which kernels, such as those of `loaded_kernels`, were loaded or compiled."""
    signatures: Signatures = {}
    for module, name, kernel in kernels:
        if types := sorted(kernel.code, key=repr):
            signatures.setdefault(module, {})[name] = types
    return {module: dict(sorted(signatures[module].items())) for module in sorted(signatures)}


def compile_ahead(
    signatures: Mapping[str, Mapping[str, list[Signature]]],
    *,
    processes: int | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> list[str]:
    """Compiles all kernels that are not stored yet, in so many processes, None for one a processor; the messages of failures."""
    tasks = [(m, name, types) for m, kernels in signatures.items() for name, each in kernels.items() for types in each]
    count = processes or most_threads()
    compilers = [Compiler() for _ in range(count)]
    idle: SimpleQueue[Compiler] = SimpleQueue()
    for compiler in compilers:
        idle.put(compiler)
    failures = []
    with ThreadPoolExecutor(count) as pool:
        futures = [pool.submit(_compile, idle, *task) for task in tasks]
        for done, future in enumerate(as_completed(futures), 1):
            failures += future.result()
            progress(done / len(tasks))
    for compiler in compilers:
        compiler.close()
    return failures


def _compile(idle: SimpleQueue[Compiler], module: str, name: str, signature: Signature) -> list[str]:
    """Compiles one kernel; returns the message of a failure."""
    compiler = idle.get()
    try:
        stored = getattr(importlib.import_module(module), name).stored_name(signature)
        if machine_code.read(stored) is None:
            machine_code.write(stored, compiler.compile(module, name, signature))
    except (CompilationError, ImportError, AttributeError, TypeError) as error:  # an outdated list costs time later, no more
        return [f"{module}.{name}: {type(error).__name__}: {error}"]
    finally:
        idle.put(compiler)
    return []
