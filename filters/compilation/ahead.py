"""Compiles ahead of the first use, in several processes side by side: at installation, and by ``pymeshfair doctor --warm``.

Which kernels, and for which types of arguments, says the list in ``signatures.json``: those that the shipped recipes and all
filters with their defaults use. ``tools/generate.py kernels`` writes it from what they did use.
"""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from .numba_threads import load_numba

LIST = Path(__file__).parent / "signatures.json"
#: by module and kernel, the types of arguments, as numba writes them
Signatures: TypeAlias = dict[str, dict[str, list[str]]]


def listed_signatures() -> Signatures:
    """What is compiled ahead."""
    listed: Signatures = json.loads(LIST.read_text("utf-8"))
    return listed


#: Types that cannot be said by name, and constants of a kernel that calls: it has what it calls compiled within it.
_OF_CALLERS = (" at 0x", "Literal[")


def signatures_of(kernels: Iterable[tuple[str, str, Any]]) -> Signatures:
    """The types of arguments for which kernels were loaded or compiled.

    Args:
        kernels: as `pymeshfair.filters.compilation.loaded_kernels` gives them.
    """
    found: Signatures = {}
    for module, name, kernel in kernels:
        types = sorted(text for text in map(repr, kernel.signatures) if not any(part in text for part in _OF_CALLERS))
        if types:
            found.setdefault(module, {})[name] = types
    return {module: dict(sorted(found[module].items())) for module in sorted(found)}


def compile_ahead(
    signatures: Mapping[str, Mapping[str, list[str]]],
    *,
    processes: int | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> list[str]:
    """Compile what is not stored yet; the texts of what went wrong.

    Args:
        signatures: what to compile.
        processes: how many at a time; None is one a processor.
        progress: called with the share that is done.
    """
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor, as_completed

    tasks = [(module, name, tuple(types)) for module, kernels in signatures.items() for name, types in kernels.items()]
    failures = []
    count = processes or (len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count())
    with ProcessPoolExecutor(count, multiprocessing.get_context("spawn")) as pool:
        for done, future in enumerate(as_completed([pool.submit(_compile, *task) for task in tasks]), 1):
            failures += future.result()
            progress(done / len(tasks))
    return failures


def _compile(module: str, name: str, signatures: Iterable[str]) -> list[str]:
    """Compile one kernel; what went wrong."""
    try:
        for text in signatures:
            getattr(importlib.import_module(module), name).compile(_parsed(text))
    except Exception as error:  # a list that is not current costs time at the first run, no more
        return [f"{module}.{name}: {type(error).__name__}: {error}"]
    return []


def _parsed(text: str) -> Any:
    """The types of arguments that numba has written, such as ``(Array(float64, 2, 'C', False, aligned=True), int64)``."""
    types = load_numba().types
    names = {**vars(types), "bool": types.boolean}
    return eval(text, {"__builtins__": {}}, names)
