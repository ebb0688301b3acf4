"""Makes an output again from its provenance, and says whether it is the same, or what has changed since."""

from __future__ import annotations

import hashlib
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ..errors import PymeshfairError
from ..files.errors import OutputError
from ..files.formats import extension
from ..files.inputs import read_file
from ..files.provenance import provenance_path, read_provenance, recorded_digest, sha256_of
from ..filters.inspection import displacement
from ..mesh_data import MeshData
from ..meshlab.unrepeatable import UNREPEATABLE
from ..recipe import Recipe, load_recipe
from ..scripts.guards import Guards
from ..scripts.read import parse_script
from ..scripts.write import format_script
from .job import Event, Job
from .supervise import run_job
from .versions import versions

Verdict: TypeAlias = Literal[
    "identical", "within tolerance", "output changed", "input changed", "recipe changed", "other versions", "not repeated"
]
#: of the diagonal, which the mean distance between two results may be that no seed repeats; and of the numbers of elements
TOLERANCE, COUNT_TOLERANCE = 0.01, 0.1


@dataclass(frozen=True)
class Verification:
    """What came of making an output again.

    Attributes:
        verdict: what is so, in two words.
        findings: sentences that say what differs, and where.
        notes: sentences about what has changed and made no difference.
    """

    verdict: Verdict
    findings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def holds(self) -> bool:
        """Whether the output is what its provenance says."""
        return self.verdict in ("identical", "within tolerance")


def verify_output(
    output: Path,
    *,
    recorded: bool = False,
    timeout: float | None = None,
    memory_limit: int | None = None,
    on_event: Callable[[Event], None] = lambda event: None,
    by_tiles: Callable[[Job, Callable[[Event], None]], object] = run_job,
) -> Verification:
    """Check an output against its provenance, and make it again from what that says.

    Args:
        output: the mesh file, with its provenance beside it.
        recorded: go on with the recipe that the provenance holds, even if the recipe's file has changed since.
        timeout: seconds for the run, or None.
        memory_limit: bytes that the run may take, or None for a share of the machine's.
        on_event: called with each event of the run.
        by_tiles: carries a job out that was done by tiles.

    Raises:
        OutputError: it has no provenance, or one that cannot be understood.
        RunError: the run failed.
    """
    output = Path(output).absolute()
    record = read_provenance(output)
    if record is None:
        raise OutputError(output, f"nothing is known of how it was made: there is no {provenance_path(output).name} of ours")
    with tempfile.TemporaryDirectory(prefix="pymeshfair-verify-") as folder:
        again = Path(folder) / output.name
        try:
            planned = _planned(output, record, again, recorded)
        except (KeyError, TypeError, AttributeError, ValueError, PymeshfairError) as error:
            raise OutputError(provenance_path(output), f"it cannot be understood ({type(error).__name__}: {error})") from error
        if isinstance(planned, Verification):
            return planned
        if "tiles" in record:
            run, memory_limit = by_tiles, memory_limit or record["tiles"].get("memory_limit")
        else:
            run = run_job
        run(replace(planned.job, timeout=timeout, memory_limit=memory_limit), on_event)
        return _compared(output, again, planned)


class _Plan(NamedTuple):
    """How an output is to be made again."""

    job: Job
    record: Mapping[str, Any]
    files: tuple[str, ...]
    unrepeatable: tuple[str, ...]
    versions: tuple[str, ...]
    notes: tuple[str, ...]


def _planned(output: Path, record: Mapping[str, Any], again: Path, recorded: bool) -> Verification | _Plan:
    """What has changed since, or how to make the output again."""
    entries = [record["output"], *record["output"].get("side_files", ())]
    if changed := tuple(_changed(entries, output.parent)):
        return Verification("output changed", changed)
    source = record["input"]
    if changed := tuple(_changed([source, *source.get("side_files", ()), *source.get("others", ())], None)):
        return Verification("input changed", changed)
    recipe, differs = _recipe(record["recipe"])
    if differs and not recorded:
        return Verification("recipe changed", (differs,))
    now = versions()
    was = record["versions"].items()
    others = tuple(f"{name} was {version}, and is {now.get(name)}" for name, version in was if version != now.get(name))
    options = record.get("options", {})
    job = Job(
        recipe,
        Path(source["path"]),
        again,
        others=tuple(Path(other["path"]) for other in source.get("others", ())),
        allow_outside=bool(options.get("allow_outside")),
        unchecked=bool(options.get("unchecked")),
        own_texture_names=bool(options.get("own_texture_names")),
        guards=Guards.parse(record.get("guards", {}).get("limits", {})),
        keep_broken=True,
    )
    job = replace(job, measures=bool(job.all_guards) or "tiles" in record)  # of which no byte depends
    files = tuple(Path(str(entry["path"])).name for entry in entries)
    _occupy(files[1:], again)
    unrepeatable = [step["python_name"] for step in record["steps"] if step["python_name"] in UNREPEATABLE]
    unrepeatable += ["writing .3mf files"] if extension(output) == "3mf" else []  # which have a random number
    return _Plan(job, record, files, tuple(unrepeatable), others, (differs,) if differs else ())


def _compared(output: Path, again: Path, plan: _Plan) -> Verification:
    different = [name for name in plan.files if not _same(again.with_name(name), plan.record)]
    if not different:
        return Verification("identical", notes=(*plan.notes, *plan.versions))
    said = [f"{name} has other bytes" for name in different]
    if plan.unrepeatable:
        said.append(f"{', '.join(plan.unrepeatable)} gives another result each time")
        apart = tuple(_differences(read_file(output).mesh, read_file(again).mesh))
        if not apart:
            return Verification("within tolerance", notes=(*plan.notes, *plan.versions, *said))
        said += apart
    return Verification("other versions" if plan.versions else "not repeated", (*said, *plan.versions), plan.notes)


def _changed(entries: list[Mapping[str, Any]], folder: Path | None) -> Iterator[str]:
    """The files that are not what an entry says; those beside the output may have been moved with it."""
    for entry in entries:
        path = Path(entry["path"]) if folder is None else folder / Path(entry["path"]).name
        if not path.is_file():
            yield f"{path} is not there any more"
        elif path.stat().st_size != entry["bytes"] or sha256_of(path) != entry["sha256"]:
            yield f"{path} is not what it was (its SHA-256 is another one)"


def _recipe(entry: Mapping[str, Any]) -> tuple[Recipe, str]:
    """The recipe that a record holds, and what is different about it now, or nothing."""
    text = str(entry["text"])
    recipe = Recipe(str(entry["name"]), parse_script(text.encode("utf-8"), str(entry["name"])))
    if hashlib.sha256(text.encode("utf-8")).hexdigest() != entry["sha256"]:
        return recipe, "the recipe in the provenance is not the one that was run: its SHA-256 is another one"
    if entry["file"] is None:
        return recipe, ""
    file = Path(entry["file"])
    if not file.is_file():
        return recipe, f"the recipe's file {file} is not there any more"
    try:
        now = format_script(load_recipe(file, upgrade=True).override(tuple(entry["overrides"])).script)
    except PymeshfairError as error:
        return recipe, f"the recipe's file {file} cannot be read any more: {error}"
    return recipe, "" if now == text else f"the recipe's file {file} says something else than when it was run"


def _occupy(names: tuple[str, ...], again: Path) -> None:
    """Put a file where the first run found one and so gave a texture another name, so that it gets that name again."""
    for name in names:
        match = re.fullmatch(rf"{re.escape(again.stem)}-(?:(\d+)-)?(.+)", name)
        if match is not None:
            for taken in (match[2], f"{again.stem}-{match[2]}", *(f"{again.stem}-{k}-{match[2]}" for k in range(2, 100))):
                if taken == name:
                    break
                again.with_name(taken).write_bytes(b"")


def _same(path: Path, record: Mapping[str, Any]) -> bool:
    return path.is_file() and sha256_of(path) == recorded_digest(record, path)


def _differences(one: MeshData, other: MeshData) -> Iterator[str]:
    """Why two results of a filter that no seed repeats are more different than chance makes them."""
    for what, had, has in (("vertices", len(one.vertices), len(other.vertices)), ("faces", len(one.faces), len(other.faces))):
        if abs(had - has) > COUNT_TOLERANCE * max(had, has):
            yield f"it had {had:,} {what}, and has {has:,} now"
    diagonal = float(np.linalg.norm(np.ptp(one.vertices, axis=0)))
    for a, b in ((one, other), (other, one)):
        found = displacement(a.vertices, a.faces, b.vertices, b.faces, correspondence="surface").distances
        if found.mean() > TOLERANCE * diagonal:
            yield f"the mean distance between both is {found.mean() / diagonal:.2%} of the diagonal"
            return
