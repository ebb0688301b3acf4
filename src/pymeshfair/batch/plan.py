"""Plans a batch: finds the scans that a command line names, and gives each a recipe, an output and a short name."""

import csv
import glob
import os
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path

from ..declaration import nearest
from ..errors import ParameterError, PymeshfairError
from ..files.errors import reason_of
from ..files.formats import READABLE, WRITABLE, extension
from ..files.provenance import provenance_path, read_provenance
from ..recipe import Recipe
from ..running.job import Job

_COLUMNS = ("input", "output")


@dataclass(frozen=True)
class RequestedScan:
    """One scan as the command line names it."""

    input: Path  # the absolute path of the mesh file, which may not exist
    #: the folder of the file, relative to the named folder or to the fixed part of the pattern; None for a file named directly
    folder: Path | None = None
    output: str | None = None  # from a table, relative to the folder of the batch; None if no table gives one
    overrides: tuple[str, ...] = ()  # ``NAME=VALUE`` or ``STEP.PARAM=VALUE``, from the columns of a table
    row: str = ""  # the table and the line that name the scan, ``t.csv:2``; empty if no table does


def expand(arguments: Sequence[str], settings: Sequence[str] = ()) -> list[RequestedScan]:
    """Returns the scans that arguments name, in their order, without repetition; a table may have the `settings` as columns.

    An argument is a mesh file; a folder, for the mesh files in it and below it in the order of their paths, without hidden and
    .txt files; a pattern with ``*``, ``?``, ``[]`` or ``**``; ``@LIST``, a file with an argument (no list) per line; or a table
    ``*.csv``. ``@-`` and ``-`` are a list and a table on standard input. Inputs in a list or a table are relative to its folder.
    """
    scans: dict[tuple[object, ...], RequestedScan] = {}
    for argument in arguments:
        for scan in _expanded(argument, Path.cwd(), settings):
            scans.setdefault((scan.input, scan.output, scan.overrides), scan)
    return list(scans.values())


def without_outputs(scans: Sequence[RequestedScan], folder: Path) -> tuple[list[RequestedScan], list[str]]:
    """Drops scans in `folder` or made from other scans, unless named directly; returns the kept scans, and texts on the rest."""
    inputs, kept, dropped, root = {scan.input for scan in scans}, list[RequestedScan](), list[str](), folder.resolve()
    for scan in scans:
        record = None if scan.folder is None else read_provenance(scan.input)
        if scan.folder is not None and scan.input.parent.resolve().is_relative_to(root):
            dropped.append(f"{scan.input}, which lies in the folder of outputs")
        elif record is not None and (source := Path(str(record["input"].get("path")))) in inputs and source != scan.input:
            dropped.append(f"{scan.input}, which a run made of another scan")
        else:
            kept.append(scan)
    if dropped and not kept:
        raise ParameterError(f"the scans lie in the folder of outputs, {folder}: give outputs another folder")
    return kept, dropped


def labels(inputs: Sequence[Path], outputs: Sequence[Path]) -> list[str]:
    """Returns a short name for each scan: the shortest unique end of its input's path.

    If an input has several outputs, the shortest unique end of the output's path follows.
    """
    uses, ends, ends_of_outputs = Counter(inputs), _shortest_ends(inputs), _shortest_ends(outputs)
    return [ends[i] if uses[i] == 1 else f"{ends[i]} to {ends_of_outputs[o]}" for i, o in zip(inputs, outputs, strict=True)]


def _shortest_ends(paths: Sequence[Path]) -> dict[Path, str]:
    ends = {path: [Path(*path.parts[-k:]).as_posix() for k in range(1, len(path.parts) + 1)] for path in paths}
    counts = Counter(end for ends_of_path in ends.values() for end in ends_of_path)
    return {path: next((end for end in ends[path] if counts[end] == 1), str(path)) for path in paths}


def _expanded(argument: str, base: Path, settings: Sequence[str]) -> Iterator[RequestedScan]:
    if argument.startswith("@"):
        yield from _listed(base / argument[1:], settings)
        return
    if not argument:
        raise ParameterError("an INPUT is empty; write . for the working folder")
    path = base / argument
    if os.path.isdir(path):  # noqa: PTH112 - false if the name is too long
        root = path.absolute()
        files = sorted(_scans_below(root))
        if not files:
            raise ParameterError(f"there are no mesh files in the folder {path} and its subfolders")
    elif glob.has_magic(argument) and not os.path.exists(path):  # noqa: PTH110 - likewise
        root = Path(base, *takewhile(lambda part: not glob.has_magic(part), Path(argument).parts))
        found = glob.glob(argument, root_dir=base, recursive=True)  # noqa: PTH207 - patterns with folders
        files = sorted(path for path in (base / name for name in found) if path.is_file())
        if not files:
            raise ParameterError(f"no file fits the pattern {argument!r} (searched for {path})")
    elif argument == "-" or extension(path) == "csv":
        yield from _table(path, settings)
        return
    elif extension(path) in ("html", "htm"):
        raise ParameterError(f"{argument} is a page, not a scan; --report takes no name, it writes batch.html to the folder")
    else:
        yield RequestedScan(path.absolute())
        return
    for file in files:
        yield RequestedScan(file.absolute(), file.absolute().parent.relative_to(root))


def _scans_below(root: Path) -> Iterator[Path]:
    for parent, folders, names in os.walk(root):
        folders[:] = [name for name in folders if not name.startswith(".")]
        for path in (Path(parent, name) for name in names if not name.startswith(".")):
            if extension(path) in READABLE and extension(path) != "txt" and path.is_file():  # a text is rarely a scan
                yield path


def _listed(path: Path, settings: Sequence[str]) -> Iterator[RequestedScan]:
    for number, line in enumerate(_text(path).splitlines(), 1):
        entry = line.strip()
        if not entry or entry.startswith("#"):
            continue
        if entry.startswith("@"):
            raise ParameterError(f"{path}:{number}: a list cannot name another list, {entry!r}")
        yield from _expanded(entry, path.absolute().parent, settings)


def _table(path: Path, settings: Sequence[str]) -> Iterator[RequestedScan]:
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
            input = path.absolute().parent / cells["input"]
            yield RequestedScan(input, None, cells.get("output") or None, overrides, f"{path}:{number}")
    except csv.Error as error:
        raise ParameterError(f"{path}:{rows.line_num}: {error}") from None


def _check_header(path: Path, header: Sequence[str], settings: Sequence[str]) -> None:
    if "input" not in header:
        raise ParameterError(f"{path}:1: a table needs a column 'input'; it has {', '.join(map(repr, header)) or 'none at all'}")
    allowed = (*_COLUMNS, *settings)
    for name in (name for name in header if not name.startswith("#")):
        if header.count(name) > 1:
            raise ParameterError(f"{path}:1: the column {name!r} is there twice")
        if name not in allowed and "." not in name:
            near = nearest(name, allowed)
            raise ParameterError(
                f"{path}:1: {name!r} is no known column; {f'did you mean {near!r}? ' if near else ''}"
                f"Columns are {', '.join(allowed)} and STEP.PARAM, and a column whose name begins with # is ignored"
            )


def _text(path: Path) -> str:
    try:
        data = sys.stdin.buffer.read() if path.name == "-" else path.read_bytes()
        text = data.decode("utf-8-sig")
        if "\0" in text:
            raise ValueError
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else "it is not UTF-8 text"
        raise ParameterError(f"cannot read {path}: {reason}") from None
    return text


#: placeholders in the names of outputs: parts of the input's path, and the scan's number
PLACEHOLDERS = ("{stem}", "{name}", "{extension}", "{folder}", "{parent}", "{number}")
_LISTED = 10  # the most collisions in a message


@dataclass(frozen=True)
class Scan:
    """One scan of a batch."""

    number: int  # from 1
    input: Path
    output: Path
    overrides: tuple[str, ...]  # see `RequestedScan`
    recipe: Recipe  # the recipe of the batch with these overrides
    label: str  # a short name, see `labels`


def job_of(template: Job, scan: Scan, *, threads: int, memory: int | None) -> Job:
    """Returns the job of a scan; `memory` is its memory limit in bytes if the template has none."""
    return replace(
        template,
        recipe=scan.recipe,
        input=scan.input,
        output=scan.output,
        overrides=(*template.overrides, *scan.overrides),
        threads=threads,
        memory_limit=template.memory_limit or memory,
        own_texture_names=True,
    )


def plan_scans(requests: Sequence[RequestedScan], recipe: Recipe, folder: Path, name: str = "") -> list[Scan]:
    """Returns the scans of a batch; `name` is the name of outputs with `PLACEHOLDERS`, or empty for the names of the inputs."""
    if not requests:
        raise ParameterError("there is no scan to clean")
    variants: dict[tuple[str, ...], Recipe] = {}
    scans = []
    for number, request in enumerate(requests, 1):
        try:
            if request.overrides not in variants:
                variants[request.overrides] = recipe.override(request.overrides) if request.overrides else recipe
        except PymeshfairError as error:
            error.args = (f"{request.row}: {error}",)
            raise
        output = Path(os.path.normpath(folder / (request.output or _output_name(name, request, number))))
        if folder not in output.parents:
            raise ParameterError(f"the output {output} of {request.input} would lie outside the folder {folder}")
        scans.append(Scan(number, request.input, output, request.overrides, variants[request.overrides], ""))
    _check_collisions(scans)
    names = labels([scan.input for scan in scans], [scan.output for scan in scans])
    return [replace(scan, label=name) for scan, name in zip(scans, names, strict=True)]


def _output_name(name: str, request: RequestedScan, number: int) -> str:
    input, folder = request.input, request.folder or Path()
    if not name:
        return str(folder / (input.name if extension(input) in WRITABLE else f"{input.stem}.ply"))
    values = {
        "stem": input.stem,
        "name": input.name,
        "extension": extension(input),
        "folder": folder.as_posix(),
        "parent": input.parent.name,
        "number": number,
    }
    try:
        return name.format(**values)
    except (KeyError, IndexError, ValueError, AttributeError):
        raise ParameterError(f"output names cannot be made from {name!r}; it may have {', '.join(PLACEHOLDERS)}") from None


def _check_collisions(scans: Sequence[Scan]) -> None:
    by_output = defaultdict(list)
    inputs = {os.path.normcase(os.path.realpath(scan.input)): scan.input for scan in scans}
    for scan in scans:
        by_output[os.path.normcase(scan.output)].append(scan)
    problems = [
        f"{path}, the output of {scan.input}, is the input {other_input}"
        for scan in scans
        for path in (scan.output, provenance_path(scan.output))
        if (other_input := inputs.get(os.path.normcase(os.path.realpath(path))))
    ]
    problems += [
        f"{group[0].output} would be the output of {' and of '.join(str(scan.input) for scan in group)}"
        for group in by_output.values()
        if len(group) > 1
    ]
    if problems:
        more = f"\n  and {len(problems) - _LISTED:,} more" if len(problems) > _LISTED else ""
        listed = "\n".join(f"  {problem}" for problem in problems[:_LISTED])
        raise ParameterError(
            f"files would be overwritten:\n{listed}{more}\n"
            f"give another folder, or a --name in which {', '.join(PLACEHOLDERS)} make the names differ"
        )


def sample(scans: Sequence[Scan], count: int) -> list[Scan]:
    """Returns `count` scans, or all if there are fewer, spread over the sizes of their files, in the order of the batch."""
    if count >= len(scans):
        return list(scans)
    by_size = sorted(scans, key=lambda scan: (scan.input.stat().st_size if scan.input.is_file() else 0, scan.number))
    chosen = {round(k * (len(by_size) - 1) / max(1, count - 1)) for k in range(count)}
    return sorted((by_size[i] for i in chosen), key=lambda scan: scan.number)
