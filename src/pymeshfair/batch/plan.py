"""The plan of a batch: every scan with its recipe and its output; no two outputs are the same file."""

import os
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import ParameterError
from ..files.formats import WRITABLE, extension
from ..files.provenance import provenance_path
from ..recipe import Recipe
from ..running.job import Job
from ..scripts.warnings import traps
from .inputs import Asked, labels

#: placeholders in the name of outputs, which stand for parts of the input's path
PLACEHOLDERS = ("{stem}", "{name}", "{extension}", "{folder}", "{parent}", "{number}")
#: so many collisions are named
_NAMED = 10


@dataclass(frozen=True)
class Scan:
    """One scan of a batch."""

    number: int  # from 1, in the order of the batch
    input: Path
    output: Path  # the file to write
    overrides: tuple[str, ...]  # changes of the recipe by its own row of a table
    recipe: Recipe  # with these changes
    label: str  # a short name that no other scan of the batch has


def job_of(template: Job, scan: Scan, *, threads: int, memory: int | None) -> Job:
    """The run of one scan; `memory` is in bytes, where the template gives none."""
    return replace(
        template,
        recipe=scan.recipe,
        input=scan.input,
        output=scan.output,
        overrides=(*template.overrides, *scan.overrides),
        threads=threads,
        memory_limit=template.memory_limit or memory,
        own_texture_names=True,
        warnings=(*(str(change) for change in scan.recipe.changes if not change.same_meaning), *traps(scan.recipe.script)),
    )


def plan_scans(asked: Sequence[Asked], recipe: Recipe, folder: Path, name: str = "") -> list[Scan]:
    """The scans of a batch; `name` is that of outputs, with `PLACEHOLDERS`, empty for the names of the inputs."""
    if not asked:
        raise ParameterError("there is no scan to clean")
    variants: dict[tuple[str, ...], Recipe] = {}
    scans = []
    for number, one in enumerate(asked, 1):
        if one.overrides not in variants:
            variants[one.overrides] = recipe.override(one.overrides) if one.overrides else recipe
        output = folder / (one.output or _named(name, one, number))
        output = Path(os.path.normpath(output))
        if folder not in output.parents:
            raise ParameterError(f"the output {output} of {one.input} would lie outside the folder {folder}")
        scans.append(Scan(number, one.input, output, one.overrides, variants[one.overrides], ""))
    _check_collisions(scans)
    names = labels([scan.input for scan in scans], [scan.output for scan in scans])
    return [replace(scan, label=name) for scan, name in zip(scans, names, strict=True)]


def _named(name: str, asked: Asked, number: int) -> str:
    input, folder = asked.input, asked.folder or Path()
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
        raise ParameterError(f"the name {name!r} of outputs cannot be made; it may have {', '.join(PLACEHOLDERS)}") from None


def _check_collisions(scans: Sequence[Scan]) -> None:
    """Refuse a batch in which one scan would write over another, or over an input."""
    by_output = defaultdict(list)
    inputs = {os.path.normcase(os.path.realpath(scan.input)): scan.input for scan in scans}
    for scan in scans:
        by_output[os.path.normcase(scan.output)].append(scan)
    problems = [
        f"{path}, the output of {scan.input}, is the input {taken}"
        for scan in scans
        for path in (scan.output, provenance_path(scan.output))
        if (taken := inputs.get(os.path.normcase(os.path.realpath(path))))
    ]
    problems += [
        f"{group[0].output} would be the output of {' and of '.join(str(scan.input) for scan in group)}"
        for group in by_output.values()
        if len(group) > 1
    ]
    if problems:
        more = f"\n  and {len(problems) - _NAMED:,} more" if len(problems) > _NAMED else ""
        told = "\n".join(f"  {problem}" for problem in problems[:_NAMED])
        raise ParameterError(
            f"outputs would be lost:\n{told}{more}\n"
            f"give another folder, or names that differ by --name with {', '.join(PLACEHOLDERS)}"
        )
