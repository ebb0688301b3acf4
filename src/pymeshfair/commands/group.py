"""Common to all commands: options, the amount of output, and the end as one message or JSON document with an exit code."""

from __future__ import annotations

import os
import re
import sys
import traceback
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, NoReturn, cast

import typer
from typer.core import TyperCommand, TyperGroup, TyperOption

from .streams import Talk, complain, failure_of_stdout, print_document, secure_streams, talk, warn


class Failure(NamedTuple):
    """The error that ended a command."""

    kind: str  # the name of the exception, e.g. ``"ScriptError"``.
    message: str  # the mistake, its place, and advice
    exit_code: int  # 1 the run failed, 2 wrong usage or an invalid recipe, 130 interrupted
    #: further attributes of the exception, such as the problems of a script or the step that failed
    details: Mapping[str, Any] = MappingProxyType({})

    @classmethod
    def of(cls, error: Exception) -> Failure:
        """The failure for an exception."""
        from ..errors import ParameterError, PymeshfairError, UnknownNameError

        kind, message = type(error).__name__, str(error)
        if isinstance(error, PymeshfairError):
            details = {name: value for name, value in vars(error).items() if not name.startswith("_")}
            invalid = isinstance(error, UnknownNameError | ParameterError) or "problems" in details
            return cls(kind, message, 2 if invalid else 1, details)
        if not isinstance(error, OSError):
            advice = "this is a defect of pymeshfair or of a plugin; --debug shows where it happened"
            message = f"unexpected {kind}: {message}\n{advice}"
        return cls(kind, message, 1)

    def show(self, *, json: bool) -> None:
        """Print the message on stderr and, with `json`, the document on stdout."""
        complain(self.message, color=False if os.environ.get("NO_COLOR") else None)
        if json:
            print_document({"error": {**self.details, "kind": self.kind, "message": self.message}})


INTERRUPTED = Failure("Interrupted", "interrupted", 130)

# typer does not export the base class of its usage errors.
UsageError = cast("type[Exception]", typer.BadParameter.__bases__[0])


def _option(names: Sequence[str], help: str, how_much: Talk | None = None) -> TyperOption:
    def chosen(context: Any, parameter: Any, value: bool) -> None:
        if value and how_much is not None:
            talk(how_much)

    return TyperOption(param_decls=[*names], is_flag=True, expose_value=False, callback=chosen, help=help)


class Command(TyperCommand):
    """A command with the options that all have; of -q and -v the last counts."""

    def __init__(self, *args: Any, params: Sequence[Any] = (), **extra: Any) -> None:
        quiet = _option(("--quiet", "-q"), "Print errors and warnings alone, and what was asked for.", Talk.LITTLE)
        verbose = _option(("--verbose", "-v"), "Print when steps begin, how far they are, and all notes.", Talk.MUCH)
        debug = _option(("--debug",), "Show the traceback of an error.")
        super().__init__(*args, params=[*params, quiet, verbose, debug], **extra)


class CommandGroup(TyperGroup):
    """The commands of `pymeshfair`, with the same end for all of them."""

    def main(self, args: Sequence[str] | None = None, prog_name: str | None = None, **extra: Any) -> NoReturn:  # type: ignore[override]
        """Run the command line `args` and exit with 0 done, 1 failed, 2 wrong usage or invalid recipe, 130 interrupted."""
        arguments = list(sys.argv[1:] if args is None else args)
        options = arguments[: arguments.index("--")] if "--" in arguments else arguments
        secure_streams()
        talk(Talk.USUAL)
        warnings.showwarning = lambda message, *where: warn(message)
        if os.environ.get("NO_COLOR"):
            extra["color"] = False
        try:
            if not any(name.endswith("_COMPLETE") for name in os.environ):
                extra["default_map"] = folder_options(self)
            code = super().main(arguments, prog_name or "pymeshfair", **{**extra, "standalone_mode": False})
            failure = INTERRUPTED if code == INTERRUPTED.exit_code else None
        except (KeyboardInterrupt, typer.Abort):
            failure = INTERRUPTED
        except UsageError as error:
            where: Any = getattr(error, "ctx", None)
            hint = "" if where is None else f"\n`{where.command_path} --help` shows what it takes"
            failure = Failure("UsageError", f"{cast('Any', error).format_message()}{hint}", 2)
        except Exception as error:
            failure = Failure.of(error)
            if "--debug" in options:
                traceback.print_exc()
        if failure is None:
            lost = failure_of_stdout()
            if lost is None or code:
                sys.exit(code or 0)
            failure = Failure("OSError", f"what was printed got lost: {(lost.strerror or str(lost)).lower()} on stdout", 1)
        if failure.exit_code == 2 and (used := used_options(extra.get("default_map", {}), arguments)):
            failure = failure._replace(message=f"{failure.message}\n{used}")
        failure.show(json="--json" in options)
        sys.exit(failure.exit_code)


# ------------------------------------------------------------------------------------------------------- options of a folder

OWN, PROJECT = Path("pymeshfair.toml"), Path("pyproject.toml")
#: options that a folder from elsewhere must not set: replaced files, unchecked reading, and the machines that take part
TYPED = ("overwrite", "allow-outside", "unchecked", "keep-broken", "scheduler", "host", "output", "help", "json", "debug")


def folder_options(app: Any) -> dict[str, Any]:
    """By command, its options from the file of the working folder, as click's ``default_map``.

    The whole of pymeshfair.toml, or ``[tool.pymeshfair]`` of pyproject.toml, gives options to every command that has them; a
    table in it with the name of a command, such as ``[tool.pymeshfair.run]``, to that one. What is typed goes first.

    Raises:
        ParameterError: the file cannot be read, or has what is no option; the message has the line.
    """
    for file, title in ((OWN, ""), (PROJECT, "tool.pymeshfair")):
        table: Any = _parsed(file) if file.is_file() else None
        for key in title.split(".") if title else ():
            table = table.get(key) if isinstance(table, dict) else None
        if isinstance(table, dict):
            return _values(app, table, file, title, {})
    return {}


def _parsed(file: Path) -> dict[str, Any]:
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        return tomllib.loads(file.read_text("utf-8"))
    except (OSError, ValueError) as error:  # of TOML and of UTF-8 too
        raise _wrong(f"{file} cannot be read: {error}; correct it, or move it away") from None


def _values(command: Any, table: Mapping[str, Any], file: Path, title: str, around: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a command, or by name of those of a group: of its table, over those of the tables around it."""
    options, inner = _options(command), getattr(command, "commands", {})
    tables = {name: value for name, value in table.items() if name in inner and isinstance(value, dict)}
    own = {name: value for name, value in table.items() if name not in tables}
    for key in own:
        _check(key, {*options, *inner}, file, title)
    values = {name: value for name, value in {**around, **own}.items() if name in options}
    if inner:
        titles = {name: f"{title}.{name}".lstrip(".") for name in inner}
        return {name: _values(one, tables.get(name, {}), file, titles[name], values) for name, one in inner.items()}
    found = {}
    for key, value in values.items():
        found[options[key].name] = [value] if options[key].multiple and not isinstance(value, list) else value
        try:
            options[key].type_cast_value(typer.Context(command), found[options[key].name])
        except typer.BadParameter as error:
            raise _wrong(f"{_place(file, key)}: {key}: {error.message}") from None
    return found


def _options(command: Any) -> dict[str, Any]:
    """The options of a command, or of all commands of a group, by their long names."""
    if inner := getattr(command, "commands", None):
        return {name: option for one in inner.values() for name, option in _options(one).items()}
    named = {str(max(p.opts, key=len)).lstrip("-"): p for p in command.params if p.param_type_name == "option"}
    return {name: option for name, option in named.items() if name not in TYPED}


def _check(key: str, allowed: set[str], file: Path, title: str) -> None:
    if key in allowed:
        return
    from ..declaration import nearest

    where = f"{_place(file, key)}: {f'[{title}] has ' if title else ''}{key!r}"
    if key in TYPED:
        raise _wrong(f"{where}, which has to be typed; take it out of the file")
    near = nearest(key, allowed)
    hint = f"did you mean {near!r}?" if near else "`pymeshfair COMMAND --help` lists the options"
    raise _wrong(f"{where}, which is no option{f' of {title}' if title else ''}; {hint}")


def _place(file: Path, key: str) -> str:
    """The file and the line of the first such key."""
    written = re.compile(rf"""\s*(\[.*)?["']?{re.escape(key)}["']?\s*[=\]]""")
    lines = enumerate(file.read_text("utf-8").splitlines(), 1)
    return next((f"{file}:{number}" for number, line in lines if written.match(line)), str(file))


def _wrong(message: str) -> Exception:
    from ..errors import ParameterError

    return ParameterError(message)


def used_options(options: Mapping[str, Any], arguments: Sequence[str]) -> str:
    """Which options of the file a command line meets, as a sentence for its errors; empty if none."""
    for word in arguments:
        options = options.get(word, options) if isinstance(options.get(word, {}), dict) else options
    values = [f"{name} = {value}" for name, value in options.items() if not isinstance(value, dict)]
    return f"{OWN if OWN.is_file() else PROJECT} has: {', '.join(values)}" if values else ""
