"""Standard streams: messages, the document of ``--json``, and ``-`` in place of a file.

Closed or full streams do not abort a command, and control characters from files are escaped.
"""

from __future__ import annotations

import dataclasses
import enum
import errno
import io
import json
import math
import os
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from ..recipe import Recipe


class LastingStream(io.TextIOWrapper):
    """A text stream that discards all further text after an error."""

    failure: OSError | None = None  # the error that stopped writing, or None; a closed pipe is no failure

    def write(self, text: str) -> int:
        with self._going_on():
            super().write(text)
        return len(text)

    def flush(self) -> None:
        with self._going_on():
            super().flush()

    @contextmanager
    def _going_on(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            if error.errno != errno.EPIPE:
                self.failure = self.failure or error
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
            with suppress(OSError):
                super().flush()


def secure_streams() -> None:
    """Replace stdout and stderr by `LastingStream`; open the null device on closed descriptors, so that no file takes them."""
    while (number := os.open(os.devnull, os.O_RDWR)) < 3:  # each call takes the lowest free descriptor
        pass
    os.close(number)
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name)
        if stream is not None and type(stream) is not io.TextIOWrapper:
            continue  # another program, such as a test, has replaced the stream
        if stream is not None:
            with suppress(OSError):
                stream.flush()
        binary = open(number, "wb", closefd=False)  # noqa: SIM115 - stays open until the process ends
        encoding = "utf-8" if stream is None else stream.encoding
        setattr(sys, name, LastingStream(binary, encoding=encoding, errors="backslashreplace", line_buffering=True))


def failure_of_stdout() -> OSError | None:
    """The error that stopped the output, or None."""
    sys.stdout.flush()
    return sys.stdout.failure if isinstance(sys.stdout, LastingStream) else None


class Verbosity(enum.IntEnum):
    """The amount of output besides results, warnings and errors."""

    QUIET, NORMAL, VERBOSE = range(3)


_verbosity = Verbosity.NORMAL


def verbosity(level: Verbosity | None = None) -> Verbosity:
    """Set the amount of output if `level` is given; return the amount."""
    global _verbosity
    _verbosity = _verbosity if level is None else level
    return _verbosity


def say(*texts: object, err: bool = False) -> None:
    """Print remarks, unless --quiet was given."""
    if _verbosity > Verbosity.QUIET:
        print_lines(texts, err=err)


def printable(text: object) -> str:
    """The text with unprintable characters escaped, since terminals may execute them; newlines and tabs stay."""
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in str(text))


def complain(text: object, *, color: bool | None = None) -> None:
    """Print an error on stderr. Typer's context decides on colours; give `color` only after that context is closed."""
    typer.echo(f"{typer.style('error:', fg='red')} {printable(text)}", err=True, color=color)


def warn(*texts: object) -> None:
    """Print warnings on stderr."""
    for text in texts:
        typer.echo(f"{typer.style('warning:', fg='yellow')} {printable(text)}", err=True)


def print_lines(lines: Iterable[object], *, err: bool = False) -> None:
    """Print lines, also with --quiet."""
    for line in lines:
        typer.echo(printable(line), err=err)


def show(document: Mapping[str, Any], lines: Iterable[str], *, json: bool) -> None:
    """Print the document as JSON, or as lines of text."""
    if json:
        print_document(document)
    else:
        print_lines(lines)


def print_document(document: Mapping[str, Any]) -> None:
    """Print `document` as JSON."""
    sys.stdout.write(json.dumps(plain(document), indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    sys.stdout.flush()


def plain(value: Any) -> Any:
    """`value` as JSON types. NaN and infinity become null, and a value of an unknown type becomes its text."""
    if isinstance(value, enum.Flag):
        return [member.name for member in type(value) if member.value and member in value]
    if value is None or isinstance(value, bool | str | int):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):  # numpy's scalars and arrays, without importing numpy
        return plain(value.tolist())
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return str(value)


STANDARD = Path("-")


def open_recipe(name: str, *, upgrade: bool = False) -> Recipe:
    """A shipped recipe, the script in a file, or the script on standard input."""
    from ..recipe import load_recipe, parse_recipe

    if name != str(STANDARD):
        return load_recipe(name, upgrade=upgrade)
    return parse_recipe(read_script_bytes(STANDARD), "<stdin>", upgrade=upgrade)


def read_script_bytes(path: Path) -> bytes:
    """The bytes of a script in a file or on standard input: at most `MOST_BYTES` + 1, enough to refuse a larger script."""
    from ..scripts.read import MOST_BYTES, read_bytes

    return sys.stdin.buffer.read(MOST_BYTES + 1) if path == STANDARD else read_bytes(path)


def check_text(output: Path, kinds: Collection[str], *, overwrite: bool, json: bool) -> None:
    """Refuse an output that cannot be written, before the work starts."""
    from ..files.writing import check_target

    if output != STANDARD:
        check_target(output, kinds, overwrite=overwrite)
    elif json:
        raise typer.BadParameter("standard output cannot take both this text and the document of --json", param_hint="-")


def save_text(text: str, output: Path, *, overwrite: bool) -> None:
    """Write the text to a file, or print it if the output is ``-``."""
    from ..files.writing import write_file

    if output == STANDARD:
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(encoding="utf-8")  # the same bytes as in a file
        sys.stdout.write(text)
    else:
        write_file(output, text.encode("utf-8"), overwrite=overwrite)
