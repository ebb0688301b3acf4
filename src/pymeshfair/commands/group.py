"""How the commands end: every error becomes one message or one JSON document, and an exit code."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Sequence
from typing import Any, NoReturn, cast

import typer
from typer.core import TyperGroup

from .failure import INTERRUPTED, Failure
from .streams import failure_of_stdout, secure_streams

# typer does not export the base class of its usage errors.
UsageError = cast("type[Exception]", typer.BadParameter.__bases__[0])


class CommandGroup(TyperGroup):
    """The commands of `pymeshfair`, with the same end for all of them."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> NoReturn:
        """Run the command line `args` and exit with 0 done, 1 failed, 2 wrong usage or invalid recipe, 130 interrupted."""
        arguments = list(sys.argv[1:] if args is None else args)
        options = arguments[: arguments.index("--")] if "--" in arguments else arguments
        secure_streams()
        if os.environ.get("NO_COLOR"):
            extra["color"] = False
        try:
            code = super().main(arguments, prog_name or "pymeshfair", complete_var, False, windows_expand_args, **extra)
            failure = INTERRUPTED if code == INTERRUPTED.exit_code else None
        except (KeyboardInterrupt, typer.Abort):
            failure = INTERRUPTED
        except UsageError as error:
            failure = Failure("UsageError", _with_hint(error), 2)
        except Exception as error:
            failure = Failure.of(error)
            if "--debug" in options:
                traceback.print_exc()
        if failure is None:
            lost = failure_of_stdout()
            if lost is None or code:
                sys.exit(code or 0)
            failure = Failure("OSError", f"what was printed got lost: {(lost.strerror or str(lost)).lower()} on stdout", 1)
        failure.show(json="--json" in options)
        sys.exit(failure.exit_code)


def _with_hint(error: Any) -> str:
    """The parser's own message and where to read on."""
    message = str(error.format_message())
    if error.ctx is None:
        return message
    return f"{message}\n`{error.ctx.command_path} --help` shows what it takes"
