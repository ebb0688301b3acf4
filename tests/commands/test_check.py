"""`pymeshfair check` names every problem of every recipe."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from .command_line import document, invoke, run_process

THREE_PROBLEMS = """<!DOCTYPE FilterScript>
<FilterScript>
  <filter name="Taubin Smoth"/>
  <filter name="Laplacian Smooth">
    <Param type="RichInt" name="stepSmoothNum" value="three"/>
    <Param type="RichBool" name="Bondary" value="true"/>
  </filter>
</FilterScript>
"""


def bad_script(folder: Path) -> Path:
    """A script with a wrong name of a filter, of a parameter, and a wrong value."""
    path = folder / "bad.mlx"
    path.write_text(THREE_PROBLEMS, encoding="utf-8")
    return path


def test_a_check_imports_neither_numba_nor_scipy_nor_meshlab() -> None:
    """What filters declare is read without what carries them out, which would take a second."""
    slow = ("numba", "scipy", "pymeshlab", "igl")
    program = (
        "import sys\nfrom pymeshfair.commands.app import main\nsys.argv = ['pymeshfair', 'check', 'denoise', 'clean_range_map']\n"
        f"try: main()\nexcept SystemExit as end: print(end.code, [m for m in {slow} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "0 []", done.stderr


def test_valid_recipes_are_ok_with_their_number_of_steps() -> None:
    """A valid recipe is one line and exit code 0."""
    done = invoke("check", "smooth_taubin", "smooth_implicit")
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert [line.partition(":")[0] for line in lines] == ["smooth_taubin", "smooth_implicit"]
    assert all(": ok, " in line for line in lines)


def test_every_problem_of_every_recipe_is_named_by_file_and_line(tmp_path: Path) -> None:
    """Three problems in one file and a missing recipe are all shown, and the valid recipe between them too."""
    bad = bad_script(tmp_path)
    done = run_process("check", bad, "smooth_taubin", "clean_nothing")
    assert done.returncode == 2
    lines = done.stdout.splitlines()
    assert [line.startswith(f"{bad}:{n}: ") for line, n in zip(lines, (3, 5, 6), strict=False)] == [True] * 3
    assert lines[3].startswith("smooth_taubin: ok")
    assert "'clean_nothing'" in lines[4]
    assert "Taubin Smooth" in lines[0]
    assert "Traceback" not in done.stderr


def test_json_lists_the_problems_by_recipe_and_together(tmp_path: Path) -> None:
    """The document has a verdict for each recipe and an error with all problems; stdout holds nothing else."""
    bad = bad_script(tmp_path)
    done = run_process("check", "smooth_taubin", bad, "--json")
    assert done.returncode == 2
    read = document(done.stdout)
    good, broken = read["recipes"]
    assert good["ok"]
    assert good["steps"] > 0
    assert not broken["ok"]
    assert [p["line"] for p in broken["problems"]] == [3, 5, 6]
    assert [p["parameter"] for p in broken["problems"]] == [None, "stepSmoothNum", "Bondary"]
    assert read["error"]["problems"] == broken["problems"]
    assert read["error"]["message"] == "1 of 2 recipes not valid"


def test_json_of_valid_recipes_has_no_error() -> None:
    """`error` is there exactly when the exit code is not 0."""
    done = invoke("check", "smooth_taubin", "--json")
    assert done.exit_code == 0
    assert "error" not in document(done.stdout)


def test_same_problems_stop_a_run_before_its_input_is_opened(tmp_path: Path) -> None:
    """`run` refuses an invalid recipe with exit code 2 and the same lines, even if the input does not exist."""
    bad = bad_script(tmp_path)
    checked = invoke("check", bad)
    done = invoke("run", bad, tmp_path / "none.ply", "-o", tmp_path / "out.ply", "--json")
    assert done.exit_code == 2
    error = document(done.stdout)["error"]
    assert error["kind"] == "ScriptError"
    assert [p["line"] for p in error["problems"]] == [3, 5, 6]
    assert error["message"] == checked.stdout.rstrip("\n")
    assert not (tmp_path / "out.ply").exists()
