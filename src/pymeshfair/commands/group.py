"""What all commands share: options, verbosity, exit codes, and the message and JSON document of an error."""

from __future__ import annotations

import os
import re
import sys
import traceback
import warnings
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn, cast

import typer
from typer.core import TyperCommand, TyperGroup, TyperOption

from .streams import Verbosity, complain, failure_of_stdout, print_document, secure_streams, verbosity, warn


class Failure(NamedTuple):
    """The error that ended a command."""

    kind: str  # the name of the exception
    message: str
    exit_code: int  # 1: failed, 2: wrong usage or an invalid recipe, 130: interrupted
    #: further attributes of the exception, such as the problems of a script or the step that failed
    details: Mapping[str, Any] = MappingProxyType({})

    @classmethod
    def of(cls, error: Exception) -> Failure:
        from ..errors import ParameterError, PymeshfairError, UnknownNameError

        kind, message = type(error).__name__, str(error)
        if isinstance(error, PymeshfairError):
            details = {name: value for name, value in vars(error).items() if not name.startswith("_")}
            invalid = isinstance(error, UnknownNameError | ParameterError) or "problems" in details
            return cls(kind, message, 2 if invalid else 1, details)
        if isinstance(error, OSError) and error.filename is not None:
            message = f"{os.fsdecode(error.filename)}: {(error.strerror or message).lower()}"
        elif not isinstance(error, OSError):
            advice = "this is a defect of pymeshfair or of a plugin; --debug shows where it happened"
            message = f"unexpected {kind}: {message}\n{advice}"
        return cls(kind, message, 1)

    def show(self, *, json: bool) -> None:
        complain(self.message, color=False if os.environ.get("NO_COLOR") else None)
        if json:
            print_document({"error": {**self.details, "kind": self.kind, "message": self.message}})


INTERRUPTED = Failure("Interrupted", "interrupted", 130)

# Typer does not export the base class of its usage errors.
UsageError = cast("type[Exception]", typer.BadParameter.__bases__[0])


def _option(names: Sequence[str], help: str, level: Verbosity | None = None) -> TyperOption:
    def chosen(context: Any, parameter: Any, value: bool) -> None:
        if value and level is not None:
            verbosity(level)

    return TyperOption(param_decls=[*names], is_flag=True, expose_value=False, callback=chosen, help=help)


class Command(TyperCommand):
    """A command with the options that all commands have; the last of -q and -v counts."""

    def __init__(self, *args: Any, params: Sequence[Any] = (), **extra: Any) -> None:
        quiet = _option(("--quiet", "-q"), "Print only errors, warnings and requested output.", Verbosity.QUIET)
        verbose = _option(("--verbose", "-v"), "Print the start and the progress of steps, and all notes.", Verbosity.VERBOSE)
        debug = _option(("--debug",), "Show the traceback of an error.")
        super().__init__(*args, params=[*params, quiet, verbose, debug], **extra)


class CommandGroup(TyperGroup):
    """The commands of `pymeshfair`, whose errors and exit codes are handled here."""

    def main(self, args: Sequence[str] | None = None, prog_name: str | None = None, **extra: Any) -> NoReturn:  # type: ignore[override]
        arguments = list(sys.argv[1:] if args is None else args)
        options = arguments[: arguments.index("--")] if "--" in arguments else arguments
        secure_streams()
        verbosity(Verbosity.NORMAL)
        warnings.showwarning = lambda message, *where: warn(message)
        if os.environ.get("NO_COLOR"):
            extra["color"] = False
        try:
            code = super().main(arguments, prog_name or "pymeshfair", **{**extra, "standalone_mode": False})
            failure = INTERRUPTED if code == INTERRUPTED.exit_code else None
        except (KeyboardInterrupt, typer.Abort):
            failure = INTERRUPTED
        except UsageError as error:
            context: Any = getattr(error, "ctx", None)
            hint = "" if context is None else f"\n`{context.command_path} --help` shows its arguments and options"
            sentences = re.split(r"(?<=[.?]) ", cast("Any", error).format_message())
            message = " ".join(dict.fromkeys(sentences))  # typer and newer versions of click both add a suggestion
            message = message.replace("a valid float range", "a number").replace("a valid integer range", "a whole number")
            failure = Failure("UsageError", f"{message}{hint}", 2)
        except Exception as error:
            failure = Failure.of(error)
            if "--debug" in options:
                traceback.print_exc()
        if failure is None:
            stdout_error = failure_of_stdout()
            if stdout_error is None or code:
                sys.exit(code or 0)
            failure = Failure("OSError", f"output got lost: {(stdout_error.strerror or str(stdout_error)).lower()} on stdout", 1)
        failure.show(json="--json" in options)
        sys.exit(failure.exit_code)
