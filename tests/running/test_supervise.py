"""Runs in real worker processes: how they end, how fast, and what they leave."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import pytest

from pymeshfair.errors import OutOfMemory, RunError, RunTimeout, StepFailedError, WorkerDied, WorkerError
from pymeshfair.files.errors import InputError, OutputError
from pymeshfair.files.provenance import sha256_of
from pymeshfair.processes.process import Process
from pymeshfair.running.job import Event, Job, Message, PhaseStarted, RunResult, StepFinished, StepProgress, StepStarted
from pymeshfair.running.read import read_mesh
from pymeshfair.running.supervise import run_job

from .runs import BONE, CRASHES, RANGE_MAP, SAMPLES, SLOW, SMOOTH, Given, names_in, ply_bytes, recipe_of, session_report, xyz

posix = pytest.mark.skipif(os.name != "posix", reason="needs signals")


def job_of(output: Path, *steps: Given, source: Path = BONE, **more: Any) -> Job:
    """A job of these steps."""
    return Job(recipe_of(*steps), source, output, **more)


def slowness() -> float:
    """How many times slower than an idle one this machine is just now; 1 if nothing else runs."""
    started = time.monotonic()
    subprocess.run([sys.executable, "-c", "import numpy"], check=True)
    return max(1.0, (time.monotonic() - started) / 0.2)


class Witness:
    """Collects events, and does something once when a step is under way."""

    def __init__(self, act: Callable[[], object] = lambda: None) -> None:
        self.events: list[Event] = []
        self.acted_at: float | None = None
        self._act = act

    def __call__(self, event: Event) -> None:
        self.events.append(event)
        if isinstance(event, StepProgress) and event.fraction > 0 and self.acted_at is None:
            self.acted_at = time.monotonic()
            self._act()


@pytest.fixture
def workers(monkeypatch: pytest.MonkeyPatch) -> list[Process]:
    """The workers that the test has started, in order."""
    started: list[Process] = []
    start = Process.__init__

    def noted(self: Process, *arguments: Any, **more: Any) -> None:
        start(self, *arguments, **more)
        started.append(self)

    monkeypatch.setattr(Process, "__init__", noted)
    return started


def is_alive(pid: int) -> bool:
    """Whether there is a process of that number that has not ended."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    status = Path(f"/proc/{pid}/stat")
    return not status.exists() or status.read_text().rpartition(")")[2].split()[0] != "Z"


# ---------------------------------------------------------------------------------------------------------------- a good end


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunResult, list[Event], Path]:
    """A run of three steps on the real range map: its result, its events, its folder."""
    folder = tmp_path_factory.mktemp("mixed")
    witness = Witness()
    steps: list[Given] = [
        ("apply_coord_taubin_smoothing", {"stepsmoothnum": 30}),
        ("meshing_close_holes", {"maxholesize": 20}),
        ("apply_coord_taubin_fairing", {"iterations": 3}),
    ]
    job = job_of(folder / "clean.ply", *steps, source=RANGE_MAP, command=("pymeshfair", "run"), overrides=("2.maxholesize=20",))
    return run_job(job, witness), witness.events, folder


def test_a_run_writes_two_files(mixed: tuple[RunResult, list[Event], Path]) -> None:
    """The output and its provenance are there and nothing else, the output as plain MeshLab would have made it."""
    result, _, folder = mixed
    assert names_in(folder) == {"clean.ply", "clean.ply.provenance.json"}
    assert (result.output, result.provenance) == (folder / "clean.ply", folder / "clean.ply.provenance.json")
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(result.output))
    mesh = meshes.current_mesh()
    assert (mesh.vertex_number(), mesh.face_number()) == (result.after["vertices"], result.after["faces"])
    assert result.after["border_edges"] < result.before["border_edges"] == 4117
    assert result.after["roughness"] < result.before["roughness"]


def test_events_tell_the_run_in_order(mixed: tuple[RunResult, list[Event], Path]) -> None:
    """Reading, each step from its start over growing progress to its end, writing; MeshLab's words come within their step."""
    _, events, _ = mixed
    order = [e for e in events if not isinstance(e, StepProgress | Message)]
    kinds = [type(e) for e in order]
    assert kinds == [PhaseStarted, *[StepStarted, StepFinished] * 3, PhaseStarted]
    assert [e.index for e in order if isinstance(e, StepStarted)] == [1, 2, 3]
    for index in (1, 2, 3):
        told = [e.fraction for e in events if isinstance(e, StepProgress) and e.index == index]
        assert all(0 <= f <= 1 for f in told)
        assert told == sorted(told)
        assert len(told) >= (10 if index == 1 else 2)
    said = next(i for i, e in enumerate(events) if isinstance(e, Message) and "Closed" in e.text)
    assert isinstance(next(e for e in reversed(events[:said]) if isinstance(e, StepProgress)), StepProgress)
    assert not any(isinstance(e, Message) and e.level == "warning" for e in events)


def test_provenance_says_how_it_came_about(mixed: tuple[RunResult, list[Event], Path]) -> None:
    """Digests are those of the files, parameters those that were effective, messages those of the filters."""
    result, _, _ = mixed
    record = json.loads(result.provenance.read_text("utf-8"))
    assert record["input"]["sha256"] == sha256_of(RANGE_MAP)
    assert record["output"]["sha256"] == sha256_of(result.output)
    assert record["output"]["path"] == str(result.output)
    assert record["recipe"]["sha256"] == hashlib.sha256(record["recipe"]["text"].encode()).hexdigest()
    assert record["recipe"]["overrides"] == ["2.maxholesize=20"]
    taubin, holes, fairing = record["steps"]
    assert taubin["parameters"]["stepsmoothnum"] == 30
    # Given as 3 % of the diagonal, which is 260.9 after the first step.
    assert holes["parameters"]["refineholeedgelen"] == pytest.approx(0.03 * 260.9, rel=1e-3)
    assert holes["messages"][0].startswith("Closed ")
    assert holes["values"]["closed_holes"] > 0
    assert (fairing["origin"], fairing["parameters"]["mu"]) == ("pymeshfair", -0.53)
    measures = {"before": dict(result.before), "after": dict(result.after), "change": dict(result.change)}
    assert record["measures"] == {**measures, "traits": {}, "unit": None}
    assert record["warnings"] == list(result.warnings)
    assert record["run"]["command"] == ["pymeshfair", "run"]
    assert record["run"]["peak_memory_bytes"] == result.peak_memory
    assert record["versions"]["pymeshlab"]


def test_the_same_run_writes_the_same_bytes(tmp_path: Path) -> None:
    """The same job again replaces its own output without asking, and both files are the same but for what is under "run"."""
    steps: list[Given] = [SMOOTH, ("apply_coord_explicit_smoothing", {})]
    before = [run_job(job_of(tmp_path / "out.ply", *steps)), sha256_of(tmp_path / "out.ply")]
    record = json.loads((tmp_path / "out.ply.provenance.json").read_text("utf-8"))
    assert run_job(job_of(tmp_path / "out.ply", *steps)).output == tmp_path / "out.ply"
    again = json.loads((tmp_path / "out.ply.provenance.json").read_text("utf-8"))
    assert sha256_of(tmp_path / "out.ply") == before[1]
    del record["run"], again["run"]
    assert again == record
    assert names_in(tmp_path) == {"out.ply", "out.ply.provenance.json"}


def test_textures_go_with_the_mesh(tmp_path: Path) -> None:
    """A textured OBJ file is cleaned in place of none: texture, material and mesh are written, the input is untouched."""
    source = tmp_path / "in"
    source.mkdir()
    for name in ("bunny10k_textured.obj", "bunny10k_textured.mtl", "TextureDouble_A.png"):
        shutil.copy(SAMPLES / name, source)
    before = {p: sha256_of(p) for p in source.iterdir()}
    (tmp_path / "out").mkdir()
    job = job_of(tmp_path / "out" / "clean.obj", SMOOTH, source=source / "bunny10k_textured.obj")
    result = run_job(job)
    texture = tmp_path / "out" / "TextureDouble_A.png"
    assert set(result.side_files) == {texture, tmp_path / "out" / "clean.obj.mtl"}
    assert names_in(tmp_path / "out") == {"clean.obj", "clean.obj.mtl", "clean.obj.provenance.json", "TextureDouble_A.png"}
    assert sha256_of(texture) == before[source / "TextureDouble_A.png"]
    assert {p: sha256_of(p) for p in source.iterdir()} == before
    assert names_in(tmp_path) == {"in", "out"}
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(result.output))
    assert meshes.current_mesh().has_wedge_tex_coord()
    assert list(meshes.current_mesh().textures()) == ["TextureDouble_A.png"]


def test_the_input_is_replaced_only_when_asked_by_name(tmp_path: Path) -> None:
    """A run over its own input is refused; with `overwrite` the input is replaced, whole."""
    path = tmp_path / "scan.ply"
    shutil.copy(BONE, path)
    with pytest.raises(OutputError, match="it is the input"):
        run_job(job_of(path, SMOOTH, source=path))
    assert sha256_of(path) == sha256_of(BONE)
    result = run_job(job_of(path, SMOOTH, source=path, overwrite=True))
    assert sha256_of(path) != sha256_of(BONE)
    assert json.loads(result.provenance.read_text("utf-8"))["input"]["sha256"] == sha256_of(BONE)


# ----------------------------------------------------------------------------------------------------------------- bad ends


def test_a_crash_is_an_error_that_names_the_step(tmp_path: Path) -> None:
    """A filter that crashes the process is named by number, name, file and line, with the signal; nothing is left behind."""
    with pytest.raises(WorkerDied) as caught:
        run_job(job_of(tmp_path / "out.ply", SMOOTH, CRASHES))
    error = caught.value
    name = recipe_of(CRASHES).script.steps[0].filter.name
    assert str(error) == f"step 2 of 2, {name!r} (test.mlx:4): the worker process crashed (SIGSEGV)"
    assert error.signal == "SIGSEGV"
    assert "Segmentation fault" in error.details
    assert names_in(tmp_path) == set()


@posix
def test_a_killed_worker_is_an_error_too(tmp_path: Path, workers: list[Process]) -> None:
    """Kill -9 in the middle of a filter ends the run at once with the step's name; nothing is left behind."""
    witness = Witness(lambda: os.kill(workers[0].pid, signal.SIGKILL))
    with pytest.raises(
        WorkerDied, match=r"step 1 of 1, 'Taubin Smooth' \(test.mlx:3\): the worker process was killed \(SIGKILL\)"
    ):
        run_job(job_of(tmp_path / "out.ply", SLOW), witness)
    assert witness.acted_at is not None
    assert time.monotonic() - witness.acted_at < 1 * slowness()
    assert names_in(tmp_path) == set()


def test_a_filter_that_refuses_is_an_error_that_names_the_step(tmp_path: Path) -> None:
    """A refusal comes in the filter's own words, MeshLab's and ours."""
    with pytest.raises(StepFailedError, match=r"step 1 of 1, 'Transfer: .*' \(test.mlx:3\): Source mesh doesn't have") as caught:
        run_job(job_of(tmp_path / "out.ply", ("transfer_texture_to_color_per_vertex", {})))
    assert caught.value.place.step == 1
    cloud = tmp_path / "cloud.ply"
    cloud.write_bytes(ply_bytes(xyz(np.random.default_rng(0).random((50, 3))), faces=()))
    with pytest.raises(StepFailedError, match="step 1 of 1, 'Taubin Fairing'"):
        run_job(job_of(tmp_path / "out.ply", ("apply_coord_taubin_fairing", {}), source=cloud))
    assert names_in(tmp_path) == {"cloud.ply"}


def test_a_run_ends_when_its_time_is_up(tmp_path: Path, workers: list[Process]) -> None:
    """The timeout counts from the start, names the step, and ends the worker."""
    limit = 1.5 + 1.5 * slowness()
    started = time.monotonic()
    with pytest.raises(RunTimeout, match=rf"step 1 of 1, 'Taubin Smooth' .* stopped after the {limit:g} s"):
        run_job(job_of(tmp_path / "out.ply", SLOW, timeout=limit))
    assert limit <= time.monotonic() - started < limit + 1 * slowness()
    assert not is_alive(workers[0].pid)
    assert names_in(tmp_path) == set()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux holds a process to its memory")
def test_memory_is_held_to_its_limit(tmp_path: Path) -> None:
    """A step that needs more memory than was given ends the run with an error about memory, or a crash that mentions it."""
    subdivide: Given = ("meshing_surface_subdivision_midpoint", {"iterations": 7, "threshold": "0"})
    with pytest.raises(RunError, match="memory") as caught:
        run_job(job_of(tmp_path / "out.ply", subdivide, memory_limit=600_000_000))
    assert isinstance(caught.value, OutOfMemory | WorkerDied)
    assert "step 1 of 1" in str(caught.value)
    assert names_in(tmp_path) == set()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux holds a process to its memory")
@pytest.mark.parametrize("megabytes", [100, 120])
def test_less_memory_than_the_libraries_need(megabytes: int, tmp_path: Path) -> None:
    """A run with less memory than the libraries take ends at once, with an error that says so."""
    with pytest.raises(OutOfMemory, match=f"needed more memory than the {megabytes} MB that the run was given; give it more"):
        run_job(job_of(tmp_path / "out.ply", SMOOTH, memory_limit=megabytes * 10**6, timeout=60))
    assert names_in(tmp_path) == set()


def test_an_exception_of_the_listener_stops_the_run(tmp_path: Path, workers: list[Process]) -> None:
    """What `on_event` raises comes out of `run_job`, after the worker has been ended and its files removed."""

    def fail() -> None:
        raise BrokenPipeError("nobody reads")

    with pytest.raises(BrokenPipeError, match="nobody reads"):
        run_job(job_of(tmp_path / "out.ply", SLOW), Witness(fail))
    assert not is_alive(workers[0].pid)
    assert names_in(tmp_path) == set()


def test_bad_inputs_and_outputs_start_nothing(tmp_path: Path, workers: list[Process]) -> None:
    """A missing input and a missing folder are errors before any process is started."""
    with pytest.raises(InputError, match="there is no such file"):
        run_job(job_of(tmp_path / "out.ply", SMOOTH, source=tmp_path / "gone.ply"))
    with pytest.raises(OutputError, match="does not exist; make it first"):
        run_job(job_of(tmp_path / "gone" / "out.ply", SMOOTH))
    assert workers == []
    assert names_in(tmp_path) == set()


def test_an_input_that_crashes_meshlab(tmp_path: Path) -> None:
    """A file on which MeshLab crashes while it reads is an error that says so; so it is when it is only measured."""
    path = tmp_path / "bad.qobj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nq 0 1 2 100000000\n")
    with pytest.raises(WorkerDied, match=r"reading bad.qobj: the worker process crashed \(SIGSEGV\); the file is probably"):
        run_job(job_of(tmp_path / "out.ply", SMOOTH, source=path, unchecked=True))
    with pytest.raises(WorkerDied, match="reading bad"):
        read_mesh(path, unchecked=True)
    with pytest.raises(InputError, match="--unchecked"):
        run_job(job_of(tmp_path / "out.ply", SMOOTH, source=path))
    assert names_in(tmp_path) == {"bad.qobj"}


@pytest.mark.parametrize("name", ["an out of memory scan.3ds", "an out of memory test/scan.3ds"])
def test_a_damaged_file_is_no_lack_of_memory_whatever_its_name(name: str, tmp_path: Path) -> None:
    """MeshLab's error names the file; words of the name are not read as the reason."""
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(b"no mesh")
    with pytest.raises(InputError, match="MeshLab says: "):
        run_job(job_of(tmp_path / "out.ply", SMOOTH, source=path, unchecked=True))


def test_a_declaration_bomb_costs_little(tmp_path: Path) -> None:
    """A PLY file of 250 bytes that declares ten million vertices is refused within 2 s and 300 MB."""
    path = tmp_path / "bomb.ply"
    path.write_bytes(ply_bytes(xyz(), faces=()).replace(b"element vertex 4", b"element vertex 10000000"))
    started = time.monotonic()
    with pytest.raises(InputError, match="declares 10,000,000 of 'vertex'"):
        run_job(job_of(tmp_path / "out.ply", SMOOTH, source=path, memory_limit=300_000_000))
    assert time.monotonic() - started < 2 * slowness()


def test_a_defect_in_the_worker_is_called_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception that nobody thought of comes with its traceback and asks to be reported."""
    (tmp_path / "lib").mkdir()
    sabotage = "import pymeshfair.files.inputs as i\ni.check_magic = lambda *a, **k: 1 / 0\n"
    (tmp_path / "lib" / "sitecustomize.py").write_text(sabotage)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "lib"))
    with pytest.raises(WorkerError, match=r"reading bone\.ply: ZeroDivisionError: division by zero; this is a defect") as caught:
        run_job(job_of(tmp_path / "out.ply", SMOOTH))
    assert "Traceback" in caught.value.details


def test_measures_of_a_file() -> None:
    """`read_mesh` gives a file's mesh and its measures, in this process."""
    found = read_mesh(BONE)
    assert (len(found.mesh.vertices), len(found.mesh.faces)) == (1872, 3022)
    assert (found.measures["vertices"], found.measures["faces"]) == (1872, 3022)
    assert found.warnings == ()


# ----------------------------------------------------------------------------------------------------------------- full disk


@pytest.fixture
def small_disk(mounted: Callable[[str], Path]) -> Path:
    """A file system that takes less than half of the bone in any format."""
    return mounted("40k")


@pytest.mark.parametrize("extension", ["ply", "3mf"])
def test_a_full_disk_leaves_what_was_there(small_disk: Path, extension: str) -> None:
    """A full disk is an error that says so, in archives too; the former output is there unharmed, alone."""
    output = small_disk / f"out.{extension}"
    output.write_bytes(b"former output")
    with pytest.raises(OutputError, match=f"cannot write .*out.{extension}: the disk is full"):
        run_job(job_of(output, overwrite=True))
    assert names_in(small_disk) == {output.name}
    assert output.read_bytes() == b"former output"


@pytest.mark.parametrize("extension", ["ply", "obj", "stl", "off", "xyz", "wrl", "3mf", "glb", "las"])
def test_no_format_takes_a_torn_file_for_a_whole_one(small_disk: Path, extension: str) -> None:
    """What a worker could not write whole is an error in every format."""
    with pytest.raises(OutputError, match="no space left on device"):
        session_report(SAMPLES / "airplane.obj", small_disk / f"out.{extension}")


# ------------------------------------------------------------------------------------------------------------------- signals

SUPERVISOR = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from tests.running.runs import BONE, SLOW, recipe_of
from pymeshfair.running.job import Job, StepProgress
from pymeshfair.running.supervise import run_job

def show(event):
    if isinstance(event, StepProgress) and event.fraction > 0:
        print("working", flush=True)

try:
    run_job(Job(recipe_of(SLOW), BONE, Path({output!r})), show)
except KeyboardInterrupt:
    print("interrupted", flush=True)
    sys.exit(130)
"""


@pytest.fixture
def supervisor(tmp_path: Path, terminal_signals: None) -> Iterator[subprocess.Popen[str]]:
    """A program that is in the middle of a long run to out/clean.ply, in a session of its own."""
    (tmp_path / "out").mkdir()
    tests = str(Path(__file__).parent.parent.parent)
    program = SUPERVISOR.format(tests=tests, output=str(tmp_path / "out" / "clean.ply"))
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "working\n"
        yield process
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def children_of(pid: int) -> list[int]:
    """The processes that a process has started."""
    return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


linux = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")


@linux
@pytest.mark.parametrize(
    ("number", "status", "word"), [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, -15, ""), (signal.SIGHUP, -1, "")]
)
def test_signals_end_a_run_within_a_second(
    tmp_path: Path, supervisor: subprocess.Popen[str], number: int, status: int, word: str
) -> None:
    """Ctrl-C raises KeyboardInterrupt, SIGTERM and SIGHUP end the program as ever; worker and files are gone before that."""
    (worker,) = children_of(supervisor.pid)
    assert any(name.startswith(".pymeshfair-") for name in names_in(tmp_path / "out"))
    started = time.monotonic()
    supervisor.send_signal(number)
    if number == signal.SIGINT:
        supervisor.send_signal(number)  # impatience must not cut the clean-up short
    assert supervisor.wait(10) == status
    assert time.monotonic() - started < 1 * slowness()
    assert not is_alive(worker)
    assert names_in(tmp_path / "out") == set()
    assert supervisor.stdout is not None
    assert supervisor.stdout.read().splitlines()[-1:] == ([word] if word else []) or not word


@linux
def test_a_worker_ends_with_its_supervisor(tmp_path: Path, supervisor: subprocess.Popen[str]) -> None:
    """When the supervisor is killed, which it cannot answer, the worker ends in the middle of a filter and cleans up itself."""
    (worker,) = children_of(supervisor.pid)
    supervisor.kill()
    supervisor.wait()
    deadline = time.monotonic() + 5
    while is_alive(worker) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not is_alive(worker)
    assert names_in(tmp_path / "out") == set()


def test_runs_in_other_threads(tmp_path: Path) -> None:
    """A run does not need the main thread, and two at once do not disturb each other."""
    results: dict[int, RunResult] = {}

    def work(k: int) -> None:
        results[k] = run_job(job_of(tmp_path / f"{k}.ply", SMOOTH))

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sha256_of(results[0].output) == sha256_of(results[1].output)
    assert replace(results[0], seconds=0).warnings == results[1].warnings
