"""Which mesh files a command line means: files, folders, patterns, lists and tables."""

from __future__ import annotations

import csv
import glob
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..declaration import nearest
from ..errors import ParameterError
from ..files.formats import READABLE, extension

#: what a folder may hold besides scans; a pattern takes them all the same
_RARELY_A_MESH = frozenset(("txt",))
_COLUMNS = ("input", "output")


@dataclass(frozen=True)
class Asked:
    """One scan as it was asked for.

    Attributes:
        input: the mesh file, an absolute path; whether it exists is seen when its turn comes.
        output: its output relative to the folder of the batch, where a table names it.
        overrides: ``STEP.PARAM=VALUE``, from the columns of a table.
    """

    input: Path
    output: str | None = None
    overrides: tuple[str, ...] = ()


def expand(arguments: Sequence[str], settings: Sequence[str] = ()) -> list[Asked]:
    """The scans that arguments mean, in their order, each once.

    An argument is a mesh file; a folder, whose mesh files count in the order of their names, without those of its own folders and
    without .txt files; a pattern with ``*``, ``?``, ``[]`` or ``**``; ``@LIST``, a file with one of these a line; or a table
    ``*.csv``. What a list or a table names is relative to its own folder.

    Args:
        arguments: in the order of the command line.
        settings: of the recipe, which a table may have columns for.

    Raises:
        ParameterError: an argument means nothing, or a list or table cannot be read.
    """
    found: dict[Asked, None] = {}
    for argument in arguments:
        found |= dict.fromkeys(_expanded(argument, Path.cwd(), settings))
    return list(found)


def _expanded(argument: str, base: Path, settings: Sequence[str]) -> Iterator[Asked]:
    if argument.startswith("@"):
        yield from _listed(base / argument[1:], settings)
        return
    path = base / argument
    if path.is_dir():
        files = sorted(p for p in path.iterdir() if _is_scan(p))
        if not files:
            raise ParameterError(f"the folder {path} holds no mesh files; '{argument}/**/*.ply' looks deeper")
    elif not path.exists() and glob.has_magic(argument):
        files = sorted(p for p in map(Path, glob.glob(str(path), recursive=True)) if p.is_file())  # noqa: PTH207 - patterns with folders
        if not files:
            raise ParameterError(f"no file fits the pattern {argument!r} (looked for {path})")
    elif extension(path) == "csv":
        yield from _table(path, settings)
        return
    elif extension(path) in ("html", "htm"):
        raise ParameterError(f"{argument} is a page, not a scan; --report takes no name, it writes batch.html to the folder")
    else:
        files = [path]
    for file in files:
        yield Asked(file.absolute())


def _is_scan(path: Path) -> bool:
    kind = extension(path)
    return not path.name.startswith(".") and kind in READABLE and kind not in _RARELY_A_MESH and path.is_file()


def _listed(path: Path, settings: Sequence[str]) -> Iterator[Asked]:
    for number, line in enumerate(_text(path).splitlines(), 1):
        entry = line.strip()
        if not entry or entry.startswith("#"):
            continue
        if entry.startswith("@"):
            raise ParameterError(f"{path}:{number}: a list cannot name another list, {entry!r}")
        yield from _expanded(entry, path.absolute().parent, settings)


def _table(path: Path, settings: Sequence[str]) -> Iterator[Asked]:
    rows = csv.reader(_text(path).splitlines(), strict=True)
    try:
        header = [name.strip() for name in next(rows, [])]
        _check_header(path, header, settings)
        for number, row in enumerate(rows, 2):
            if not any(cell.strip() for cell in row):
                continue
            if len(row) != len(header):
                raise ParameterError(f"{path}:{number}: it has {len(row)} cells, but the table has {len(header)} columns")
            cells = {name: cell.strip() for name, cell in zip(header, row, strict=True) if not name.startswith("#")}
            if not cells["input"]:
                raise ParameterError(f"{path}:{number}: the cell of the column input is empty")
            overrides = tuple(f"{name}={cell}" for name, cell in cells.items() if name not in _COLUMNS and cell)
            yield Asked(path.absolute().parent / cells["input"], cells.get("output") or None, overrides)
    except csv.Error as error:
        raise ParameterError(f"{path}:{rows.line_num}: {error}") from None


def _check_header(path: Path, header: Sequence[str], settings: Sequence[str]) -> None:
    if "input" not in header:
        raise ParameterError(f"{path}:1: a table needs a column 'input'; it has {', '.join(map(repr, header)) or 'none at all'}")
    for name in header:
        if header.count(name) > 1:
            raise ParameterError(f"{path}:1: the column {name!r} is there twice")
        if name not in (*_COLUMNS, *settings) and "." not in name and not name.startswith("#"):
            near = nearest(name, (*_COLUMNS, *settings))
            hint = f"did you mean {near!r}? " if near else ""
            raise ParameterError(
                f"{path}:1: {name!r} is no column that is known; {hint}"
                f"Columns are {', '.join((*_COLUMNS, *settings))} and STEP.PARAM, "
                "and one whose name begins with # is passed over"
            )


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise ParameterError(f"cannot read {path}: {(reason or str(error)).lower()}") from None
