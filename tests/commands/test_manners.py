"""How much commands print, what they read from standard input, and which options a folder gives them."""

from __future__ import annotations

import os
import pty
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pymeshfair.commands.display import show_table
from pymeshfair.recipe import load_recipe
from tests.running.runs import BONE

from .command_line import COMMAND, document, invoke, run_process

SCRIPT = load_recipe("smooth_taubin").text


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, with a scan."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(BONE, "scan.ply")
    return tmp_path


@pytest.mark.slow
def test_a_pipe_gets_a_line_a_step_and_less_or_more_if_asked() -> None:
    """By default one line a step; with -q nothing; with -v more than a line, and the same table in the end."""
    run = ("run", "clean_range_map", "scan.ply", "-o", "out.ply", "--overwrite", "--unit", "mm")
    usual, little, much = (invoke(*run, *more) for more in ((), ("-q",), ("-v",)))
    steps = len(load_recipe("clean_range_map").script.steps)
    lines = [
        line
        for line in usual.stderr.splitlines()
        if line[0] != " " and "compiling" not in line and not line.startswith("warning: ")
    ]
    assert len(lines) == steps
    assert all(line.startswith("step ") for line in lines)
    assert not [line for line in little.output.splitlines() if not line.startswith("warning: ")]
    assert len(much.stderr.splitlines()) > 2 * steps
    assert usual.stdout.partition(" steps in ")[0] == much.stdout.partition(" steps in ")[0]


def test_quiet_commands_print_what_was_asked_for_and_errors_alone() -> None:
    """A written script is no news with -q; a list, a document and an error are."""
    assert invoke("export", "smooth_taubin", "-o", "plain.mlx", "-q").output == ""
    assert invoke("check", "smooth_taubin", "-q").output == ""
    assert len(invoke("list", "recipes", "-q").stdout.splitlines()) > 20
    assert document(invoke("check", "smooth_taubin", "-q", "--json").stdout)["recipes"][0]["ok"]
    assert invoke("check", "nothing.mlx", "-q").exit_code == 2
    assert "cannot be read" in invoke("check", "nothing.mlx", "-q").output


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [("check", "-"), ("export", "-", "-o", "-"), ("upgrade", "-", "-o", "-")])
def test_scripts_come_from_standard_input(arguments: tuple[str, ...]) -> None:
    """A script on standard input is checked, exported and upgraded like that in a file; what is wrong with it has its line."""
    for text, code in ((SCRIPT, 0), (SCRIPT.replace("<filter name", "<filter nam"), 2)):
        done = subprocess.run([*COMMAND, *arguments], input=text, capture_output=True, text=True, timeout=60)
        assert done.returncode == code, done.stderr
        assert ("<stdin>:" in done.stdout + done.stderr) == (code == 2)


@pytest.mark.slow
def test_a_run_and_a_batch_read_standard_input_and_a_comparison_prints_its_table() -> None:
    """A recipe, a list and a table of scans; deviations are a table for the next program."""
    for arguments, text in (
        (("run", "-", "scan.ply", "-o", "run.ply"), SCRIPT),
        (("batch", "smooth_taubin", "@-", "-o", "one"), "scan.ply\n"),
        (("batch", "smooth_taubin", "-", "-o", "two"), "input,taubin.stepsmoothnum\nscan.ply,10\n"),
    ):
        done = subprocess.run([*COMMAND, *arguments, "-q"], input=text, capture_output=True, text=True, timeout=100)
        assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert Path("run.ply").read_bytes() == Path("one/scan.ply").read_bytes() == Path("two/scan.ply").read_bytes()
    rows = invoke("compare", "scan.ply", "run.ply", "--no-self-intersections", "--deviations", "-").stdout.splitlines()
    assert len(rows) > 1000
    assert all(row.count(",") == rows[0].count(",") for row in rows)


@pytest.mark.parametrize("columns", [None, 50])
def test_tables_fit(columns: int | None, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """A table has at most 100 columns in a pipe, or as many as the terminal, however long its cells are."""
    monkeypatch.delenv("COLUMNS", raising=False)
    if columns is not None:
        monkeypatch.setenv("COLUMNS", str(columns))
    show_table(["scan", "what became of it"], ["n" * 150, "word " * 60], ["short", "1"], numbers=(1,))
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= (columns or 100)
    assert sum(line.count("n") for line in lines) >= 150


@pytest.mark.slow
def test_no_command_colours_a_terminal_that_wants_none() -> None:
    """With NO_COLOR a run, an error and a table on a real terminal have no escape sequence for colours."""
    for arguments in (("run", "smooth_taubin", "scan.ply", "-o", "out.ply"), ("check", "nothing.mlx"), ("info", "scan.ply")):
        shown = b"".join(_on_terminal(*arguments))
        assert not re.search(rb"\x1b\[(\d+;)*[349]\d(;\d+)*m", shown), shown


def _on_terminal(*arguments: str) -> list[bytes]:
    main, other = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, *arguments],
        stdin=other,
        stdout=other,
        stderr=other,
        env={**os.environ, "NO_COLOR": "1", "TERM": "xterm-256color"},
    )
    os.close(other)
    parts = []
    while True:
        try:
            parts.append(os.read(main, 65536))
        except OSError:  # the process has ended
            break
        if not parts[-1]:
            break
    process.wait(60)
    os.close(main)
    return parts


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes_commands_options_and_recipes() -> None:
    """The printed script, sourced by a real bash, gives what begins so."""
    name = Path(sys.executable).parent / "pymeshfair"
    assert name.exists()
    program = """
        export PATH="{bin}:$PATH"
        eval "$(env _PYMESHFAIR_COMPLETE=source_bash pymeshfair)"
        for line in "pymeshfair ver" "pymeshfair run --max-d" "pymeshfair run clean_r"; do
            COMP_WORDS=($line); COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 )); COMPREPLY=()
            _pymeshfair_completion pymeshfair "${{COMP_WORDS[COMP_CWORD]}}"
            echo "${{COMPREPLY[@]}}"
        done
    """
    done = subprocess.run(
        ["bash", "-c", program.format(bin=name.parent)], capture_output=True, text=True, timeout=60, env={**os.environ}
    )
    assert done.stdout.split() == ["verify", "--max-displacement", "clean_range_map"], done.stderr


def test_the_version_has_a_short_option() -> None:
    """-V is --version."""
    assert run_process("-V").stdout == invoke("--version").stdout
