"""What all commands share: help at once, exit codes, one message or one JSON document for an error."""

from __future__ import annotations

import importlib.metadata
import subprocess
import sys
from typing import Any

import pytest
import typer
from typer.core import TyperGroup
from typer.testing import CliRunner

from pymeshfair import recipe
from pymeshfair.commands.app import app

from .command_line import document, invoke, run_process

#: each takes longer to import than the help may take to appear
HEAVY = [
    "numpy",
    "scipy",
    "dask",
    "distributed",
    "numba",
    "pymeshlab",
    "trimesh",
    "rich",
    "pymeshfair.declaration",
    "pymeshfair.filters",
]
COMMANDS = {"demo", "run", "check", "list", "info", "suggest", "spectrum", "doctor"}


def all_commands() -> dict[str, Any]:
    """Every command that can be called, by the words that call it."""
    found: dict[str, Any] = {}
    waiting: list[tuple[str, Any]] = [("pymeshfair", typer.main.get_command(app))]
    while waiting:
        name, command = waiting.pop()
        if isinstance(command, TyperGroup):
            waiting += [(f"{name} {n}", c) for n, c in command.commands.items()]
        else:
            found[name] = command
    return found


def test_colours_are_left_out_where_that_is_asked_for() -> None:
    """With NO_COLOR no error and no mark has any, on a terminal too."""
    for arguments in (["check", "nothing.mlx"], ["run", "nothing", "a.ply", "-o", "b.ply"]):
        plain = CliRunner().invoke(app, arguments, color=True, env={"NO_COLOR": "1"})
        assert "\x1b" not in plain.output
        assert "error" in plain.output or "cannot be read" in plain.output
    assert "\x1b" in CliRunner().invoke(app, ["run", "nothing", "a.ply", "-o", "b.ply"], color=True).output


@pytest.mark.parametrize(("shell", "mark"), [("bash", "complete "), ("zsh", "#compdef"), ("fish", "complete --command")])
def test_commands_are_completed_by_the_shell(shell: str, mark: str) -> None:
    """The script for each shell is there, and gives the commands that begin so."""
    environment = {"_PYMESHFAIR_COMPLETE": f"source_{shell}"}
    assert mark in CliRunner().invoke(app, [], prog_name="pymeshfair", env=environment).output
    asked = {"_PYMESHFAIR_COMPLETE": "complete_bash", "COMP_WORDS": "pymeshfair ex", "COMP_CWORD": "1"}
    assert CliRunner().invoke(app, [], prog_name="pymeshfair", env=asked).output.split() == ["export"]


@pytest.mark.parametrize("words", ["run", "batch", "check", "export", "info", "tune scan.ply --recipe"])
def test_recipes_are_completed_by_the_shell(words: str) -> None:
    """Wherever a command takes the name of a recipe."""
    line = f"pymeshfair {words} smooth_tau"
    asked = {"_PYMESHFAIR_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)}
    assert CliRunner().invoke(app, [], prog_name="pymeshfair", env=asked).output.split() == ["smooth_taubin"]


def test_help_imports_nothing_heavy() -> None:
    """Whoever asks for help waits for typer alone."""
    program = (
        "import sys\nfrom pymeshfair.commands.app import main\nsys.argv = ['pymeshfair', '--help']\n"
        f"try: main()\nexcept SystemExit as end: print(end.code, [m for m in {HEAVY} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "0 []", done.stderr


def test_help_names_every_command() -> None:
    """The help is a complete list."""
    shown = invoke("--help")
    assert shown.exit_code == 0
    assert {line.split()[0] for line in shown.stdout.partition("Commands:")[2].splitlines() if line.strip()} >= COMMANDS


def test_version_is_that_of_the_package() -> None:
    """`--version` prints what the installed metadata says."""
    assert invoke("--version").stdout == f"pymeshfair {importlib.metadata.version('pymeshfair')}\n"


@pytest.mark.parametrize("name", all_commands())
def test_every_command_has_json_and_debug_and_explains_itself(name: str) -> None:
    """The two options are everywhere, and every command and option has words."""
    command = all_commands()[name]
    options = {option for parameter in command.params for option in parameter.opts}
    assert {"--json", "--debug"} <= options
    assert command.help
    context = command.make_context(name, [], resilient_parsing=True)
    records = [parameter.get_help_record(context) for parameter in command.params]
    assert all(record and record[1] for record in records), records


def test_version_runs_no_command() -> None:
    """A command after --version is not run."""
    assert (done := invoke("--version", "check", "nothing.mlx")).exit_code == 0
    assert done.stdout.startswith("pymeshfair ")


def test_a_name_that_is_too_long_is_told_in_words() -> None:
    """The message has the name and the reason, not the number of the error. `check` goes on with the next recipe."""
    assert (done := invoke("info", "x" * 300)).exit_code == 1
    assert done.stderr == f"error: {'x' * 300}: file name too long\n"
    assert invoke("check", "x" * 300, "smooth_taubin").stdout.endswith("\nsmooth_taubin: ok, 1 step\n")


def test_no_command_is_wrong_usage() -> None:
    """Without a command the help goes to stderr and the exit code is 2."""
    done = invoke()
    assert (done.exit_code, done.stdout) == (2, "")
    assert "Commands:" in done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["runn"],
        ["run", "smooth_taubin"],
        ["run", "smooth_taubin", "a.ply", "-o", "b.ply", "--timeout", "soon"],
        ["run", "smooth_taubin", "a.ply", "-o", "b.ply", "--timeout", "-1"],
        ["run", "smooth_taubin", "a.ply", "b.ply"],
        ["check"],
        ["list", "meshes"],
        ["list"],
        ["info"],
        ["doctor", "--fast"],
    ],
    ids=" ".join,
)
def test_wrong_usage_ends_with_2_and_one_document(arguments: list[str]) -> None:
    """A command line that cannot be read is one message on stderr and, if asked for, one document on stdout."""
    plain, with_json = invoke(*arguments), invoke(*arguments, "--json")
    assert (plain.exit_code, plain.stdout) == (2, "")
    assert plain.stderr.startswith("error: ")
    assert with_json.exit_code == 2
    error = document(with_json.stdout)["error"]
    assert error["kind"] == "UsageError"
    assert error["message"] in with_json.stderr


def test_near_misses_are_suggested() -> None:
    """A mistyped command is answered with the right one."""
    assert invoke("chekc").stderr.count("'check'") == 1


def test_unexpected_error_shows_its_traceback_only_with_debug(monkeypatch: pytest.MonkeyPatch) -> None:
    """A defect is a message and exit code 1; `--debug` adds where it happened."""

    def broken(name: str, **_: object) -> None:
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(recipe, "load_recipe", broken)
    plain, debugged, with_json = (invoke("check", "x.mlx", *more) for more in ([], ["--debug"], ["--json"]))
    assert [plain.exit_code, debugged.exit_code, with_json.exit_code] == [1, 1, 1]
    assert "ZeroDivisionError: by nothing" in plain.stderr
    assert "Traceback" not in plain.stderr + plain.stdout
    assert "Traceback" in debugged.stderr
    assert document(with_json.stdout)["error"]["kind"] == "ZeroDivisionError"


def test_interruption_ends_with_130(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C is no failure of the run: it has an exit code and a kind of its own."""

    def interrupted(name: str, **_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(recipe, "load_recipe", interrupted)
    done = invoke("check", "x.mlx", "--json")
    assert done.exit_code == 130
    assert document(done.stdout)["error"]["kind"] == "Interrupted"
    assert "Traceback" not in done.stderr


def test_a_closed_pipe_is_no_traceback() -> None:
    """`pymeshfair list filters | head -1` ends quietly."""
    program = f"{sys.executable} -c 'from pymeshfair.commands.app import main; main()' list filters | head -1"
    done = subprocess.run(["sh", "-c", program], capture_output=True, text=True, timeout=60)
    assert "Traceback" not in done.stderr
    assert len(done.stdout.splitlines()) == 1


def test_command_is_installed() -> None:
    """The package's metadata has the console script `pymeshfair`, and its target answers."""
    [script] = [e for e in importlib.metadata.entry_points(group="console_scripts") if e.name == "pymeshfair"]
    assert script.value == "pymeshfair.commands.app:main"
    assert run_process("--version").returncode == 0
