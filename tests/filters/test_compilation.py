"""Kernels are compiled when they are first called, once for all processes, and never taken for others."""

from __future__ import annotations

import _thread
import importlib
import json
import os
import pickle
import platform
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
import pytest
from loaded_kernels import loaded_kernels

from pymeshfair.filters import geometry
from pymeshfair.filters.compilation import (
    compile_ahead,
    compiled,
    listed_signatures,
    machine_code,
    processor,
)
from pymeshfair.filters.compilation.compiler import COMPILER, CompilationError, Compiler, numba_type
from pymeshfair.filters.compilation.kernel import fingerprint, from_json

PROJECT = Path(__file__).parents[2]
PACKAGES = ("filters", "src", "plugins", "mlx_scripts")
#: calls a kernel, and tells what was compiled and where it is kept
PROGRAM = """
import numpy as np, pymeshfair.filters.topology as t
from pymeshfair.filters.compilation import on_compilation, stored
compiled = []
on_compilation(compiled.append)
print(t.border_edges(np.array([[0, 1, 2]], dtype=np.int32)).tolist(), len(compiled), stored().folder)
"""
EDGES = "[[0, 1], [0, 2], [1, 2]]"
SIZE = 3


@compiled
def inner(x: float) -> float:
    """Uses a number of this module."""
    return x * SIZE


@compiled
def outer(x: float) -> float:
    """Uses another kernel."""
    return inner(x) + 1.0


@compiled
def factorial(number: int) -> int:
    """Calls itself."""
    return number * factorial(number - 1) if number > 1 else 1


def test_a_kernel_may_call_itself() -> None:
    """Its search for parallel loops in the kernels that it calls ends."""
    assert factorial(5) == 120


def run(environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    """A fresh process."""
    return subprocess.run(
        [sys.executable, *arguments], env={**os.environ, **environment}, capture_output=True, text=True, timeout=120, check=False
    )


def copied_tree(folder: Path) -> Path:
    """The packages without anything compiled."""
    for name in PACKAGES:
        shutil.copytree(PROJECT / name, folder / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    return folder / "src"


@pytest.mark.skipif(not sys.platform.startswith("linux") or os.geteuid() != 0, reason="takes a read-only mount, as root on Linux")
def test_kernels_work_where_neither_the_package_nor_a_home_can_be_written(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """On a read-only file system and without a home the mathematics is imported, compiles and runs, and leaves nothing behind."""
    source = copied_tree(tmp_path)
    shell = 'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1" && cd / && exec "$2" -c "$3"'
    environment = {
        **{k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"},
        "HOME": "/proc/nowhere",
        "XDG_CACHE_HOME": "/proc/nowhere",
        "PYTHONPATH": str(source),
        "PYTHONDONTWRITEBYTECODE": "1",
        "TMPDIR": str(tmp_path_factory.mktemp("temporary")),
    }
    command = ["unshare", "--mount", "sh", "-c", shell, "sh", str(tmp_path), sys.executable, PROGRAM]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)
    if "unshare" in done.stderr or "mount:" in done.stderr:
        pytest.skip(f"this machine does not let a test mount: {done.stderr.strip()}")
    assert done.returncode == 0, done.stderr
    edges, count, folder = done.stdout.strip().rsplit(" ", 2)
    assert edges == EDGES
    assert int(count) > 0
    assert folder.startswith("/proc/nowhere")
    assert not list(Path(environment["TMPDIR"]).iterdir())


@pytest.mark.slow
def test_what_one_process_compiles_the_next_ones_load(tmp_path: Path) -> None:
    """With an empty store kernels are compiled and that is told; the next process compiles none, nor does one to which the
    store came with a package that it cannot write to.
    """
    source = copied_tree(tmp_path / "copy")  # an installation has its kernels already
    environment = {"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(tmp_path / "store")}
    first, second = (run(environment, "-c", PROGRAM) for _ in range(2))
    assert first.stdout.startswith(f"{EDGES} "), first.stderr
    assert int(first.stdout.split()[-2]) > 0
    assert second.stdout.startswith(f"{EDGES} 0 "), second.stderr
    shutil.copytree(tmp_path / "store/pymeshfair", tmp_path / "copy/filters/compilation/kernels")
    installed = run({"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(tmp_path / "empty")}, "-c", PROGRAM)
    assert installed.stdout.startswith(f"{EDGES} 0 "), installed.stderr


@pytest.mark.slow
def test_a_damaged_file_in_the_store_is_compiled_again(tmp_path: Path) -> None:
    """What a full disk has cut off is no reason to fail."""
    source, store = copied_tree(tmp_path / "copy"), tmp_path / "store"
    environment = {"PYTHONPATH": str(source), "NUMBA_CACHE_DIR": str(store)}
    run(environment, "-c", PROGRAM)
    for file in store.glob("pymeshfair/*/*"):
        file.write_bytes(file.read_bytes()[:100])
    done = run(environment, "-c", PROGRAM)
    assert done.stdout.startswith(f"{EDGES} "), done.stderr
    assert int(done.stdout.split()[-2]) > 0


def test_machine_code_with_a_wrong_byte_is_not_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a disk has changed in the middle of a file would end the process, so it counts as missing."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    code = machine_code.MachineCode(b"machine code" * 100, "function", "environment", ("a constant",))
    machine_code.write("kernel", code)
    assert machine_code.read("kernel") == code
    (file,) = tmp_path.glob("pymeshfair/*/kernel")
    data = bytearray(file.read_bytes())
    data[500] ^= 1
    file.write_bytes(data)
    assert machine_code.read("kernel") is None


@pytest.mark.skipif(os.name != "posix", reason="user numbers of POSIX")
def test_a_user_whom_the_system_does_not_know_needs_no_home(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a container: HOME is not set, and the user number has no account. No kernel is read, and no error is raised."""

    def unknown(number: int) -> None:
        raise KeyError(number)

    monkeypatch.setattr("pwd.getpwuid", unknown)
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    assert machine_code.users_folder().is_absolute()
    assert machine_code.read("kernel") is None


def test_a_wrong_number_of_threads_is_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    """All processors are used, as by numba."""
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    processors = machine_code.most_threads.__wrapped__()
    monkeypatch.setenv("NUMBA_NUM_THREADS", "many")
    assert machine_code.most_threads.__wrapped__() == processors


def test_an_unfinished_file_is_no_kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a killed process has left is not counted."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    machine_code.write("module.kernel-1234", machine_code.MachineCode(b"", "function", "environment", ()))
    (file,) = tmp_path.glob("pymeshfair/*/*")
    file.with_name("1234.part").touch()
    assert machine_code.stored().kept == 1


def test_after_an_interrupt_no_further_kernel_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernels that wait in the queue are not compiled."""
    begun = []

    def compile_one(_: object, __: str, name: str, signature: object) -> list[str]:
        begun.append(name)
        if len(begun) == 20:  # two at a time; the others wait in the queue
            _thread.interrupt_main()
        time.sleep(0.02)
        return []

    monkeypatch.setattr("pymeshfair.filters.compilation.kernel._compile", compile_one)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # background processes start with SIGINT ignored
    try:
        with pytest.raises(KeyboardInterrupt):
            compile_ahead({"module": {f"kernel{number}": [()] for number in range(300)}}, processes=2)
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(begun) < 300


@pytest.mark.skipif(os.name != "posix", reason="the signal of POSIX terminals")
def test_ctrl_c_leaves_the_compiler_to_its_parent() -> None:
    """A terminal sends SIGINT to the compiler, too; the compiler ignores it, and answers the next request."""
    compiler = Compiler()
    for _ in range(2):
        with pytest.raises(CompilationError, match="no attribute 'missing'"):
            compiler.compile("pymeshfair.filters.compilation.kernel", "missing", ())
        compiler._process.send_signal(signal.SIGINT)
        time.sleep(0.2)
    compiler.close()


def test_a_compiler_that_is_closed_meanwhile_starts_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """After Ctrl-C the main thread closes the compilers while other threads use them: these threads get an error at once."""
    compiler = Compiler()
    assert compiler._process.poll() is None
    monkeypatch.setattr(Compiler, "_send", staticmethod(lambda process, message: compiler.close()))
    with pytest.raises(CompilationError, match="has ended"):
        compiler.compile("module", "kernel", ())
    assert "_process" not in vars(compiler)


def test_a_change_of_what_a_kernel_is_compiled_from_changes_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Constants of its module, kernels that it calls and what numba is told are part of a kernel, as its own code is."""

    def anew(kernel: Any, **options: bool) -> str:
        return fingerprint(kernel.py_func, options)

    before = anew(inner)
    assert anew(inner) == before
    assert anew(inner, nogil=True) != before
    assert anew(outer) != before
    called = anew(outer)
    monkeypatch.setattr(sys.modules[__name__], "SIZE", 4)
    assert anew(inner) != before
    monkeypatch.setattr(sys.modules[__name__], "inner", compiled(inner.py_func))  # type: ignore[attr-defined]
    assert anew(outer) != called


def test_what_no_hash_can_be_made_of_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kernel must not use what could change unseen, such as a list."""
    monkeypatch.setattr(sys.modules[__name__], "SIZE", [3])
    function: Any = inner
    assert isinstance(function.py_func, FunctionType)
    with pytest.raises(TypeError, match=r"test_compilation\.inner uses \[3\]"):
        fingerprint(function.py_func, {})


def test_every_kernel_has_a_fingerprint_of_its_own() -> None:
    """None uses anything that no hash can be made of; two of the same fingerprint are the same function."""
    for module in PROJECT.glob("filters/*/*.py"):
        importlib.import_module(f"pymeshfair.filters.{module.parent.name}.{module.stem}".removesuffix(".__init__"))
    found: dict[str, Any] = {}
    for _, _, kernel in loaded_kernels("pymeshfair"):
        other = found.setdefault(kernel.fingerprint, kernel)
        assert other.py_func.__code__.co_code == kernel.py_func.__code__.co_code
    assert len(found) > 100


def test_the_list_of_what_is_compiled_ahead_can_be_read() -> None:
    """Every kernel of the list exists, with so many arguments, and numba has their types."""
    for module, kernels in listed_signatures().items():
        for name, signatures in kernels.items():
            kernel = getattr(importlib.import_module(module), name)
            for signature in signatures:
                assert len(signature) == kernel.py_func.__code__.co_argcount, f"{module}.{name}: tools/generate.py kernels"
                assert all(numba_type(written) is not None for written in signature)


class Pair(NamedTuple):
    """Arguments that belong together."""

    values: np.ndarray[Any, Any]
    factor: float


@compiled
def scaled(pair: Pair, shift: tuple[int, int], most: int) -> tuple[Any, float, Pair]:
    """Takes and gives back arrays, tuples and named tuples."""
    found = np.empty(min(len(pair.values), most))
    for k in range(len(found)):
        found[k] = pair.values[k] * pair.factor + shift[0] - shift[1]
    return found, found.sum(), Pair(pair.values, 2.0 * pair.factor)


def test_code_is_loaded_without_numba_and_does_the_same() -> None:
    """Arrays of any layout, read-only ones, tuples and named tuples go in and come out; a process that computes has no numba."""
    values = np.arange(12.0).reshape(3, 4)
    frozen = values.ravel().copy()
    frozen.flags.writeable = False
    for array in (values.ravel(), values[:, 1], frozen):
        found = scaled(Pair(array, 3.0), (5, 2), 4)
        expected = scaled.py_func(Pair(array, 3.0), (5, 2), 4)  # type: ignore[attr-defined]
        np.testing.assert_array_equal(found[0], expected[0])
        assert found[1] == expected[1]
        assert isinstance(found[2], Pair)
        assert found[2].factor == 6.0
        assert np.shares_memory(found[2].values, array)
    done = run({}, "-c", "import sys, numpy as np; from pymeshfair.filters.topology import border_edges;"
               "border_edges(np.array([[0, 1, 2]], dtype=np.int32)); print('numba' in sys.modules)")  # fmt: skip
    assert done.stdout.strip() == "False", done.stderr


@compiled
def refusing(values: Any, least: int) -> float:
    """Raises errors with constant texts and with numbers."""
    if len(values) < least:
        raise ValueError("too few")
    if values[0] < 0:
        raise KeyError(least)
    return 1.0 / float(values[0])


def test_threads_load_a_kernel_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four threads that call a kernel first get one function: code that is loaded twice may lose its environment."""
    points, faces = np.eye(3), np.array([[0, 1, 2]], dtype=np.int32)
    measured = geometry.measure_faces(points, faces)
    loads: list[str] = []
    load, barrier = machine_code.load, threading.Barrier(4)

    def slowly(code: machine_code.MachineCode, name: str) -> Any:
        loads.append(name)
        time.sleep(0.05)
        return load(code, name)

    def call(_: int) -> Any:
        barrier.wait()
        return geometry.measure_faces(points, faces)

    monkeypatch.setattr(machine_code, "load", slowly)
    monkeypatch.setattr(geometry._measure_faces, "code", {})
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(call, range(4)))
    assert loads == ["_measure_faces"]
    assert all(np.array_equal(result, measured) for result in results)


@pytest.mark.parametrize(("first", "least"), [(1.0, 9), (-1.0, 2), (0.0, 2), (4.0, 2)])
def test_errors_are_those_that_numba_raises(first: float, least: int) -> None:
    """An exception of a kernel, and a division by 0, come out with the same type and text however the code was loaded."""

    def outcome(function: Any) -> Any:
        try:
            return function(np.array([first, 2.0, 3.0]), least)
        except Exception as error:
            return type(error), str(error)

    assert outcome(refusing) == outcome(refusing.dispatcher)  # type: ignore[attr-defined]


def test_the_installation_goes_on_after_what_cannot_be_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A list that is not current names kernels that are gone, or types that numba refuses: that is told, the rest is compiled."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    listed: Any = {
        "pymeshfair.filters.topology": {"no_such_kernel": [("int64",)]},
        __name__: {"inner": [("float64",), ("none",)]},
    }
    failures = compile_ahead(listed, processes=1)
    assert sorted(text.split(":")[0] for text in failures) == ["pymeshfair.filters.topology.no_such_kernel", f"{__name__}.inner"]
    kernel: Any = inner
    assert machine_code.read(kernel.stored_name(("float64",))) is not None
    assert machine_code.read(kernel.stored_name(("none",))) is None


def test_an_interrupted_compilation_does_not_answer_the_next_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """After Ctrl-C during a compilation the next kernel gets its own machine code, which is stored under its name."""

    def interrupt(stream: Any) -> None:
        raise KeyboardInterrupt

    compiler, module = Compiler(), "pymeshfair.filters.geometry"
    listed = listed_signatures()[module]
    first, second = list(listed)[:2]
    with monkeypatch.context() as patched:
        patched.setattr(pickle, "load", interrupt)
        with pytest.raises(KeyboardInterrupt):
            compiler.compile(module, first, listed[first][0])
    try:
        assert second in compiler.compile(module, second, listed[second][0]).function
    finally:
        compiler.close()


def test_two_compiler_processes_give_no_two_functions_one_symbol() -> None:
    """The linker takes equal symbols for one function: else a filter may use the weights of another kernel."""
    module = "pymeshfair.filters.denoising.normal_filter"
    listed = listed_signatures()[module]
    symbols = []
    for name in ("_weighted_means", "_follow_trend"):
        compiler = Compiler()
        code = compiler.compile(module, name, listed[name][0])
        compiler.close()
        symbols.append(set(re.findall(rb"_ZN10pymeshfair\w+", code.object)))
    assert all(any(b"robust5_loop" in symbol for symbol in each) for each in symbols)
    assert not symbols[0] & symbols[1]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs forks")
def test_a_fork_has_a_compiler_process_of_its_own() -> None:
    """Else a fork, as of `multiprocessing`, could take the machine code that its parent or another fork asked for."""
    module, (name, signatures) = (
        "pymeshfair.filters.geometry",
        next(iter(listed_signatures()["pymeshfair.filters.geometry"].items())),
    )
    COMPILER.compile(module, name, signatures[0])
    assert "_process" in vars(COMPILER)
    with vars(COMPILER)["_lock"]:  # as if another thread compiled
        fork = os.fork()
        if fork == 0:
            os._exit("_process" in vars(COMPILER) or vars(COMPILER)["_lock"].locked())
    assert os.waitpid(fork, 0)[1] == 0
    assert name in COMPILER.compile(module, name, signatures[0]).function


@pytest.mark.slow
def test_each_level_of_processor_has_its_own_code_with_the_same_bits(tmp_path: Path) -> None:
    """What was compiled for another level is not taken; smoothing gives the same coordinates with both."""
    program = (
        "import hashlib; from pymeshfair.filters.compilation import on_compilation, processor, stored\n"
        "from pymeshfair.filters.diffusion import taubin_fairing; from tests.meshes import icosphere\n"
        "compiled = []; on_compilation(compiled.append); result = taubin_fairing(*icosphere(3))\n"
        "print(processor(), len(compiled) > 0, stored().kept > 0, hashlib.sha256(result.tobytes()).hexdigest())\n"
    )
    environment = {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(PROJECT)}
    levels = [processor(), "x86-64" if platform.machine() in ("x86_64", "AMD64") else "generic"]
    first, other = (run({**environment, "NUMBA_CPU_NAME": level}, "-c", program).stdout.split() for level in levels)
    assert [first[0], other[0]] == levels
    assert other[1:3] == ["True", "True"]
    assert first[3] == other[3]


@pytest.mark.parametrize(("lacking", "level"), [((), "x86-64-v3"), (("fma",), "x86-64-v2"), (("fma", "ssse3"), "x86-64")])
def test_the_level_is_the_best_whose_features_the_processor_has(
    lacking: tuple[str, ...], level: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A processor without one feature of a level takes the next lower one; other kinds of processor the code for all of them."""
    import llvmlite.binding as llvm

    features = dict.fromkeys((feature for _, needed in machine_code._X86_LEVELS for feature in needed), True)
    monkeypatch.setattr(llvm, "get_host_cpu_features", lambda: features | dict.fromkeys(lacking, False))
    monkeypatch.delenv("NUMBA_CPU_NAME", raising=False)
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    assert processor.__wrapped__() == level
    monkeypatch.setattr(platform, "machine", lambda: "arm64")
    assert processor.__wrapped__() == "generic"


def test_an_array_that_a_kernel_made_lives_as_long_as_it_is_used() -> None:
    """Its memory is numba's, and is given back with it: a thousand arrays of a megabyte do not add up."""
    import gc
    import resource

    kept = scaled(Pair(np.ones(1000), 1.0), (0, 0), 10)[0]
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(1000):
        scaled(Pair(np.ones(125_000), 1.0), (0, 0), 125_000)
    gc.collect()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000
    np.testing.assert_array_equal(kept, np.ones(10))


def test_the_list_has_what_common_filters_use() -> None:
    """Smoothing and measuring a mesh takes no kernel, and none for other types, than are compiled ahead."""
    program = (
        "import json, numpy as np; from loaded_kernels import loaded_kernels;"
        "from pymeshfair.filters.inspection import surface_measures; from pymeshfair.filters.diffusion import taubin_fairing;"
        "from tests.meshes import icosphere; v, f = icosphere(2); taubin_fairing(v, f); surface_measures(v, f);"
        "print(json.dumps([(m, name, list(kernel.code)) for m, name, kernel in loaded_kernels('pymeshfair')]))"
    )
    done = run({"PYTHONPATH": os.pathsep.join(map(str, (PROJECT, PROJECT / "tools")))}, "-c", program)
    assert done.returncode == 0, done.stderr
    listed, missing = listed_signatures(), []
    for module, name, signatures in json.loads(done.stdout):
        missing += [f"{module}.{name} {s}" for s in map(from_json, signatures) if s not in listed.get(module, {}).get(name, ())]
    assert not missing, "python tools/generate.py kernels"
