"""Safe printing: closed or full streams do not abort a command; escape codes from files are removed."""

import enum
import errno
import io
import os
import sys
from contextlib import suppress
from typing import TextIO

import typer


class LastingStream(io.TextIOWrapper):
    """A text stream that goes on, to nowhere, once it cannot be written."""

    failure: OSError | None = None  # the error that stopped writing, or None; a pipe whose reader is gone is no failure

    def write(self, text: str) -> int:
        """Write, or not."""
        try:
            return super().write(text)
        except OSError as error:
            self._give_up(error)
            return len(text)

    def flush(self) -> None:
        """Flush, or not."""
        try:
            super().flush()
        except OSError as error:
            self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        if error.errno != errno.EPIPE:
            self.failure = self.failure or error
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.fileno())
        os.close(nowhere)
        with suppress(OSError):
            super().flush()


def secure_streams() -> None:
    """Make both output streams lasting ones; closed ones go to the null device, so that no file gets the number 1 or 2."""
    while (number := os.open(os.devnull, os.O_RDWR)) < 3:  # the lowest number that is free
        pass
    os.close(number)
    sys.stdout, sys.stderr = (_lasting(number, stream) for number, stream in ((1, sys.stdout), (2, sys.stderr)))


def _lasting(number: int, stream: TextIO | None) -> TextIO:
    if stream is not None and type(stream) is not io.TextIOWrapper:
        return stream  # replaced by another program, such as a test
    if stream is not None:
        with suppress(OSError):
            stream.flush()
    binary = open(number, "wb", closefd=False)  # noqa: SIM115 - a number, which stays open to the end
    encoding, errors = ("utf-8", "backslashreplace") if stream is None else (stream.encoding, "backslashreplace")
    return LastingStream(binary, encoding=encoding, errors=errors, line_buffering=True)


def failure_of_stdout() -> OSError | None:
    """The error by which output on stdout got lost, or None."""
    sys.stdout.flush()
    return sys.stdout.failure if isinstance(sys.stdout, LastingStream) else None


class Talk(enum.IntEnum):
    """The amount of output besides results, warnings and errors."""

    LITTLE = 0
    USUAL = 1
    MUCH = 2


_talk = Talk.USUAL


def talk(how_much: Talk | None = None) -> Talk:
    """The amount of output; `how_much` sets it."""
    global _talk
    _talk = _talk if how_much is None else how_much
    return _talk


def say(text: object, *, err: bool = False) -> None:
    """Print a remark, unless little is to be printed."""
    if _talk > Talk.LITTLE:
        typer.echo(printable(text), err=err)


def printable(text: object) -> str:
    """The text with control characters escaped, as a terminal would obey those in names of files; line feeds and tabs stay."""
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in str(text))


def complain(text: object, *, color: bool | None = None) -> None:
    """Print an error on stderr; `color` is needed where the context of typer, which knows it, is closed."""
    typer.echo(f"{typer.style('error:', fg='red')} {printable(text)}", err=True, color=color)


def warn(text: object) -> None:
    """Print a warning on stderr."""
    typer.echo(f"{typer.style('warning:', fg='yellow')} {printable(text)}", err=True)
