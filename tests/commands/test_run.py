"""`pymeshfair run` in real processes: what it writes, what it says, and how it ends when it does not end well."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.meshlab.loading import ADVICE

from .command_line import COMMAND, document, invoke, run_process

STEPS = {
    "smooth": '<filter name="Laplacian Smooth"><Param type="RichInt" name="stepSmoothNum" value="{}"/></filter>',
    # MeshLab refuses it, in words, on a mesh without texture coordinates
    "refused": '<filter name="Transfer: Texture to Vertex Color (1 or 2 meshes)"/>',
    # it ends the process on any mesh when no second layer is there
    "deadly": '<filter name="MLS projection (APSS)"/>',
}


def write_recipe(folder: Path, *steps: str) -> Path:
    """A script of these steps, one a line, the first in line 3."""
    path = folder / "recipe.mlx"
    path.write_text("\n".join(["<!DOCTYPE FilterScript>", "<FilterScript>", *steps, "</FilterScript>"]), encoding="utf-8")
    return path


def smoothing(steps: int) -> str:
    """Laplacian smoothing: 100,000 steps, the most that a script may ask for, take about 20 s on the square below."""
    return STEPS["smooth"].format(steps)


@pytest.fixture
def scan(tmp_path: Path) -> Path:
    """A rough square of 41 x 41 vertices as a PLY file; 1,681 vertices, 3,200 faces, 160 border edges."""
    n = 41
    height = np.random.default_rng(11).normal(scale=0.1, size=n * n)
    corners = [i * n + j for i in range(n - 1) for j in range(n - 1)]
    faces = [f for c in corners for f in ((c, c + n, c + 1), (c + 1, c + n, c + n + 1))]
    lines = [
        "ply\nformat ascii 1.0",
        f"element vertex {n * n}\nproperty double x\nproperty double y\nproperty double z",
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header",
        *(f"{k // n} {k % n} {float(height[k])!r}" for k in range(n * n)),
        *(f"3 {a} {b} {c}" for a, b, c in faces),
    ]
    path = tmp_path / "scan.ply"
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def files(folder: Path) -> set[str]:
    """Everything in a folder, hidden files included."""
    return {path.name for path in folder.iterdir()}


def test_run_writes_the_output_and_shows_before_and_after(tmp_path: Path, scan: Path) -> None:
    """The table is on stdout with the files written, the steps are on stderr, and nothing but the two files is left."""
    before = files(tmp_path)
    done = run_process("run", "smooth_taubin", scan, "-o", tmp_path / "out.ply")
    assert done.returncode == 0, done.stderr
    assert files(tmp_path) - before == {"out.ply", "out.ply.provenance.json"}
    rows = {re.split(r"\s{2,}", line.strip())[0]: re.split(r"\s{2,}", line.strip())[1:] for line in done.stdout.splitlines()}
    assert rows["vertices"] == ["1,681", "1,681"]
    assert rows["faces"] == ["3,200", "3,200"]
    assert rows["border edges"] == ["160", "160"]
    assert rows["components"] == ["1", "1"]
    assert {"area", "mean edge"} <= set(rows)
    [roughness] = [values for name, values in rows.items() if name.startswith("roughness")]
    assert float(roughness[1]) < float(roughness[0])
    assert str(tmp_path / "out.ply") in rows
    assert str(tmp_path / "out.ply.provenance.json") in rows
    assert "step 1 of 1: Taubin Smooth" in done.stderr
    assert "\x1b" not in done.stdout + done.stderr


def test_json_is_one_document_with_everything(tmp_path: Path, scan: Path) -> None:
    """Stdout holds one document; the effective parameters in it are those of `--set`."""
    recipe = write_recipe(tmp_path, smoothing(3), '<filter name="Select Border"/>')
    arguments: list[str | Path] = [
        "run",
        recipe,
        scan,
        "-o",
        tmp_path / "out.ply",
        "--set",
        "laplacian.stepsmoothnum=5",
        "--json",
    ]
    done = run_process(*arguments)
    assert done.returncode == 0, done.stderr
    read = document(done.stdout)
    assert [Path(read[key]).name for key in ("input", "output", "provenance")] == [
        "scan.ply",
        "out.ply",
        "out.ply.provenance.json",
    ]
    assert [s["filter"] for s in read["steps"]] == ["Laplacian Smooth", "Select Border"]
    assert read["steps"][0]["parameters"]["stepsmoothnum"] == 5
    assert read["before"]["vertices"] == read["after"]["vertices"] == 1681
    assert read["after"]["roughness"] < read["before"]["roughness"]
    assert "error" not in read
    assert "laplacian.stepsmoothnum=5" in (tmp_path / "out.ply.provenance.json").read_text("utf-8")


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("3.stepsmoothnum=5", "no step 3"),
        ("1.stepsmoothnum=few", "'few'"),
        ("1.steps=5", "stepsmoothnum"),
        ("steps=5", "STEP.PARAM=VALUE"),
    ],
)
def test_wrong_set_is_wrong_usage(tmp_path: Path, scan: Path, override: str, said: str) -> None:
    """A step, parameter or value that is not there ends with 2 before anything is written."""
    recipe = write_recipe(tmp_path, smoothing(3))
    before = files(tmp_path)
    done = invoke("run", recipe, scan, "-o", tmp_path / "out.ply", "--set", override)
    assert done.exit_code == 2
    assert said in done.stderr
    assert files(tmp_path) == before


@pytest.mark.parametrize("limit", ["--require", "--max-displacement", "--max-volume-change", "--keep-sharp"])
def test_an_empty_limit_is_refused(tmp_path: Path, scan: Path, limit: str) -> None:
    """A limit from an empty variable of the shell is wrong usage, not a run without the limit."""
    done = invoke("run", "smooth_taubin", scan, "-o", tmp_path / "new.ply", limit, "")
    assert done.exit_code == 2
    assert "''" in done.stderr
    assert not (tmp_path / "new.ply").exists()


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--timeout", "nan", "the time limit must be above 0 seconds, and it is nan"),
        ("--timeout", "soon", "'soon' is not a number."),
        ("--memory", "٤GB", "'٤GB' is no amount of memory"),
        ("--memory", "9" * 400, "is no amount of memory"),
        ("--max-displacement", "far", "--max-displacement: 'far' is no length"),
        ("--max-displacement", "1e400", "--max-displacement: '1e400' is no length"),
        ("--max-volume-change", "much", "--max-volume-change 'much' is no percentage"),
        ("--keep-sharp", "101%", "--keep-sharp '101%' is above 100 %"),
        ("--require", "closed", "--require: 'closed' is no requirement"),
        ("--unit", "inch", "'inch' is no unit of scans; the units are mm"),
    ],
)
def test_a_wrong_value_is_named_with_its_option(option: str, value: str, message: str) -> None:
    """It is wrong usage, and the message has the name that was typed."""
    done = invoke("run", "smooth_taubin", "nothing.ply", "-o", "new.ply", option, value)
    assert done.exit_code == 2
    assert message in done.stderr


def test_a_map_that_cannot_be_written_is_refused(tmp_path: Path, scan: Path) -> None:
    """The root folder is no file, and a name may be too long."""
    for place in ("/", tmp_path / f"{'x' * 300}.ply"):
        done = invoke("run", "smooth_taubin", scan, "-o", tmp_path / "new.ply", "--map", place)
        assert done.exit_code == 1
        assert f"cannot write {place}: " in done.stderr


def test_a_file_in_the_way_stays_unless_overwrite_is_given(tmp_path: Path, scan: Path) -> None:
    """An output that some other program wrote is refused with 1, and replaced when asked by name."""
    output = tmp_path / "out.ply"
    output.write_text("mine", encoding="utf-8")
    refused = run_process("run", "smooth_taubin", scan, "-o", output, "--json")
    assert refused.returncode == 1
    assert document(refused.stdout)["error"]["kind"] == "OutputError"
    assert output.read_text("utf-8") == "mine"
    assert run_process("run", "smooth_taubin", scan, "-o", output, "--overwrite").returncode == 0
    assert output.read_bytes().startswith(b"ply")


@pytest.mark.parametrize(
    ("input", "output", "kind"),
    [
        ("none.ply", "out.ply", "InputError"),
        ("scan.ply", "nowhere/out.ply", "OutputError"),
        ("scan.ply", "out.xls", "OutputError"),
    ],
)
def test_what_cannot_be_read_or_written_is_a_failed_run(tmp_path: Path, scan: Path, input: str, output: str, kind: str) -> None:
    """A missing input, a missing folder and an unknown format end with 1, name the path, and leave nothing."""
    before = files(tmp_path)
    done = invoke("run", "smooth_taubin", scan.with_name(input), "-o", tmp_path / output, "--json")
    assert done.exit_code == 1
    error = document(done.stdout)["error"]
    assert error["kind"] == kind
    assert str(tmp_path / (input if kind == "InputError" else output)) in error["message"]
    assert files(tmp_path) == before


@pytest.mark.parametrize(("step", "kind"), [("refused", "StepFailedError"), ("deadly", "WorkerDied")])
def test_a_step_that_fails_or_kills_the_worker_is_named(tmp_path: Path, scan: Path, step: str, kind: str) -> None:
    """The message names the step, its filter, file and line; nothing is left beside the input."""
    recipe = write_recipe(tmp_path, smoothing(1), STEPS[step])
    before = files(tmp_path)
    done = run_process("run", recipe, scan, "-o", tmp_path / "out.ply", "--json")
    assert done.returncode == 1
    error = document(done.stdout)["error"]
    assert error["kind"] == kind
    assert "step 2 of 2" in error["message"]
    assert "recipe.mlx:4" in error["message"]
    assert error["place"]["step"] == 2
    assert "Traceback" not in done.stderr
    assert files(tmp_path) == before


def test_a_broken_limit_names_the_options_that_help(tmp_path: Path, scan: Path) -> None:
    """Without a map the error names --map, and --keep-broken in any case."""
    arguments = ("run", "smooth_taubin", scan, "-o", tmp_path / "out.ply", "--max-displacement", "1e-9")
    assert run_process(*arguments).stderr.endswith("; --map OUT.ply shows where; --keep-broken writes it all the same\n")
    shown = run_process(*arguments, "--map", tmp_path / "map.ply").stderr
    assert "map.ply shows where" in shown
    assert "--map" not in shown


def test_timeout_stops_the_run(tmp_path: Path, scan: Path) -> None:
    """A run that takes longer than `--timeout` ends with 1, says where it was stopped, and leaves nothing."""
    recipe = write_recipe(tmp_path, smoothing(100_000))
    before = files(tmp_path)
    done = run_process("run", recipe, scan, "-o", tmp_path / "out.ply", "--timeout", "2", "--json")
    assert done.returncode == 1
    error = document(done.stdout)["error"]
    assert (error["kind"], error["seconds"]) == ("RunTimeout", 2)
    assert error["message"].startswith(error["place"]["doing"])
    assert files(tmp_path) == before


@pytest.mark.skipif(sys.platform == "win32", reason="signals to a process group")
@pytest.mark.usefixtures("terminal_signals")
def test_ctrl_c_within_a_filter_ends_with_130_within_a_second(tmp_path: Path, scan: Path) -> None:
    """The terminal's SIGINT, which goes to the whole process group, stops the worker too, and nothing is left."""
    recipe = write_recipe(tmp_path, smoothing(100_000))
    before = files(tmp_path)
    command = [*COMMAND, "run", str(recipe), str(scan), "-o", str(tmp_path / "out.ply"), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith("step 1 of 1"):
                break
        time.sleep(0.3)  # well into the filter, which does not listen to signals
        start = time.monotonic()
        os.killpg(process.pid, signal.SIGINT)
        stdout, stderr = process.communicate(timeout=30)
        took = time.monotonic() - start
    assert process.returncode == 130
    assert took < 2.0  # a second by contract, another for a loaded machine
    assert document(stdout)["error"]["kind"] == "Interrupted"
    assert "Traceback" not in stderr
    assert files(tmp_path) == before
    with pytest.raises(ProcessLookupError):  # no worker is left in the group
        os.killpg(process.pid, 0)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals")
def test_a_terminal_shows_a_bar_and_keeps_the_finished_steps(tmp_path: Path, scan: Path) -> None:
    """On a terminal stderr has a bar that moves within a step, and a line for each finished step; stdout stays plain."""
    recipe = write_recipe(tmp_path, smoothing(2_500), '<filter name="Select Border"/>')
    leader, follower = os.openpty()
    command = [*COMMAND, "run", str(recipe), str(scan), "-o", str(tmp_path / "out.ply"), "--json"]
    environment = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "100"}
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=follower, env=environment) as process:
        os.close(follower)
        shown = b""
        while True:
            try:
                part = os.read(leader, 4096)
            except OSError:  # the other end is closed
                break
            if not part:
                break
            shown += part
        stdout, _ = process.communicate(timeout=60)
    os.close(leader)
    assert process.returncode == 0
    assert json.loads(stdout)["steps"][1]["filter"] == "Select Border"
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode("utf-8")).replace("\r", "\n")
    assert "step 1 of 2: Laplacian Smooth" in plain
    shares = {int(share) for share in re.findall(r"(\d+)%", plain)}
    assert shares - {0, 50, 100}, "the bar did not move within a step"
    assert re.search(r"^ +1 +\d+\.\d\d s +Laplacian Smooth\s*$", plain, re.MULTILINE)


#: what `import pymeshlab` does where a system library is missing: it fails, or prints which of its plugins do
NO_LIBGL = "raise ImportError('libGL.so.1: cannot open shared object file: No such file or directory')"
NO_LIBOPENGL = """
print("Warning:\\nUnable to load the following plugins:\\n\\n\\tlibio_base.so: libio_base.so does not seem to be a Qt Plugin.\\n")
print("Cannot load library plugins/libio_base.so: (libOpenGL.so.0: cannot open shared object file: No such file or directory)")
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "program", "library"),
    [("run", NO_LIBGL, "libGL.so.1"), ("run", NO_LIBOPENGL, "libOpenGL.so.0"), ("demo", NO_LIBOPENGL, "libOpenGL.so.0")],
)
def test_a_missing_system_library_is_a_message_with_its_cure(
    tmp_path: Path, scan: Path, command: str, program: str, library: str
) -> None:
    """Where pymeshlab or its plugins do not load, `run` and `demo` say which packages to install, without a traceback."""
    import pymeshlab

    fake = tmp_path / "fake" / "pymeshlab"
    fake.mkdir(parents=True)
    (fake / "__init__.py").write_text(program, encoding="utf-8")
    (fake / "tests").symlink_to(Path(pymeshlab.__file__).parent / "tests")
    words_after: dict[str, list[str | Path]] = {
        "demo": ["-o", tmp_path / "demo"],
        "run": ["smooth_taubin", scan, "-o", tmp_path / "out.ply"],
    }
    done = run_process(command, *words_after[command], environment={"PYTHONPATH": str(fake.parent)})
    assert done.returncode == 1
    assert f"{library}: cannot open shared object file; {ADVICE}" in done.stderr
    assert "apt install libgl1 libopengl0" in ADVICE
    assert "Traceback" not in done.stderr
