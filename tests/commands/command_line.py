"""Runs `pymeshfair` in a process of its own, as a shell does, and without one where that is enough."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from click.testing import Result
from jsonschema import Draft202012Validator
from typer.testing import CliRunner

from pymeshfair.commands.app import app

#: the program of the interpreter that runs the tests, whatever else is on the PATH
COMMAND = [sys.executable, "-m", "pymeshfair"]
#: the schemas of what the commands print with --json
DOCUMENTS = Path(__file__).parents[2] / "src/pymeshfair/commands/documents.json"
SCHEMAS = json.loads(DOCUMENTS.read_text("utf-8"))


def run_process(
    *arguments: str | Path, environment: Mapping[str, str] | None = None, timeout: float = 120
) -> subprocess.CompletedProcess[str]:
    """A real process, whose stdout and stderr are pipes."""
    return subprocess.run(
        [*COMMAND, *map(str, arguments)],
        capture_output=True,
        encoding="utf-8",
        timeout=timeout,
        env={**os.environ, **(environment or {})},
    )


def invoke(*arguments: str | Path) -> Result:
    """The same within this process."""
    return CliRunner().invoke(app, list(map(str, arguments)), prog_name="pymeshfair")


def document(printed: str) -> dict[str, Any]:
    """The one JSON document that stdout holds; NaN and Infinity, which are no JSON, are refused."""

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is no JSON")

    read = json.loads(printed, parse_constant=refuse)
    assert isinstance(read, dict)
    assert fits(read, *SCHEMAS["commands"]), f"no schema in {DOCUMENTS} is one of {read.keys()}"
    return read


def fits(read: Any, *commands: str) -> bool:
    """Whether a document is one that such a command prints, or its error."""
    failed = {"type": "object", "properties": {"error": {"$ref": "#/$defs/error"}}, "required": ["error"], "maxProperties": 1}
    schema = {"anyOf": [*(SCHEMAS["commands"][name] for name in commands), failed], "$defs": SCHEMAS["$defs"]}
    return bool(Draft202012Validator(schema).is_valid(read))
