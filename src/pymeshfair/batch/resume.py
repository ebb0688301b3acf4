"""The scans that are done already: by content, from the provenance beside each output."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import ParameterError
from ..files.provenance import formatted, provenance_path, read_provenance, recorded_digest, sha256_of
from ..files.writing import write_file
from ..processes.versions import PACKAGES, packages_here
from ..running.job import Job
from .journal import Journal
from .outcome import Outcome, digests_of
from .plan import Scan

#: files are read and digested by so many threads
_READERS = 4


@dataclass(frozen=True)
class Done:
    """A scan that is done.

    Attributes:
        outcome: as of this batch.
        path: its output; another than that of the scan if its number in the names has changed.
    """

    outcome: Outcome
    path: Path


def done_before(
    scans: Sequence[Scan], template: Job, journal: Mapping[str, Outcome], *, renumber: bool = False
) -> dict[int, Done]:
    """By their numbers the scans whose output is there, made of the same input by the same recipe, limits and versions.

    Args:
        scans: all of a batch.
        template: of the runs of the batch.
        journal: the last line about each output; what it tells beyond the provenance is kept.
        renumber: take outputs under other names of the journal, too: an added scan changes the numbers of those after it.
    """
    variants = {id(scan.recipe): scan.recipe for scan in scans}
    recipes = {key: recipe.digest for key, recipe in variants.items()}
    jobs = {key: replace(template, recipe=recipe) for key, recipe in variants.items()}
    others = [sha256_of(path) for path in template.others if path.is_file()]
    packages = packages_here()

    def look(scan: Scan, path: Path) -> Done | None:
        record = read_provenance(path)
        if record is None:
            return None
        try:
            job = jobs[id(scan.recipe)]
            limits = job.all_guards.in_mesh_units(job.unit_of(record["input"].get("unit"))).texts()
            wanted = (recipes[id(scan.recipe)], others, limits, packages)
            if _made_by(record) != wanted or not _is_whole(record, scan, path):
                return None
            outcome = Outcome.of_record(record, scan.input, scan.output)
        except (KeyError, TypeError, ValueError, OSError, ParameterError):  # another's document, or a file that is gone
            return None
        if outcome.status == "broken" and not template.keep_broken:
            return None
        former = journal.get(str(path))
        if former is not None and former.digests == digests_of(record):
            outcome = replace(former, output=str(scan.output))
        return Done(replace(outcome, resumed=True), path)

    with ThreadPoolExecutor(_READERS) as pool:
        done = {scan.number: one for scan, one in zip(scans, pool.map(lambda s: look(s, s.output), scans), strict=True) if one}
    if renumber:
        taken = {one.path for one in done.values()}
        places = defaultdict(list)
        for outcome in journal.values():
            places[outcome.input].append(Path(outcome.output))
        for scan in (scan for scan in scans if scan.number not in done):
            for path in places[str(scan.input)]:
                if path not in taken and path.suffix == scan.output.suffix and (one := look(scan, path)):
                    done[scan.number] = one
                    taken.add(path)
                    break
    return done


def rename_outputs(scans: Sequence[Scan], done: dict[int, Done], journal: Journal) -> None:
    """Give the outputs of scans that are done the names of this batch, and note that in the journal.

    Outputs of the former batch that are in the way of others, of scans that are gone or have changed, are removed. What is no
    output of that batch stays, and the scan that needs its name counts as not done.
    """
    moves = {scan.number: done[scan.number].path for scan in scans if scan.number in done}
    targets = {scan.number: scan.output for scan in scans}
    moves = {number: path for number, path in moves.items() if path != targets[number]}
    while moves:
        sources = set(moves.values())
        number = next((number for number in moves if targets[number] not in sources), None)
        if number is None:  # a ring: one of them steps aside
            number, path = next(iter(moves.items()))
            moves[number] = path.with_name(f".pymeshfair-renamed-{path.name}")
            _rename(path, moves[number])
            continue
        path, target = moves.pop(number), targets[number]
        if target.exists() and not _is_former(target, journal):
            del done[number]
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        _rename(path, target)
        journal.append(done[number].outcome)
    for scan in scans:
        former = journal.before.get(str(scan.output))
        if scan.number not in done and former and former.input != str(scan.input) and _is_former(scan.output, journal):
            scan.output.unlink()
            provenance_path(scan.output).unlink()


def _is_former(output: Path, journal: Journal) -> bool:
    """Whether a file is, to the byte, an output of the former batch."""
    if str(output) not in journal.before or not output.is_file():
        return False
    return sha256_of(output) == recorded_digest(read_provenance(output), output)


def _rename(path: Path, target: Path) -> None:
    """Rename an output and its provenance."""
    record = read_provenance(path)
    assert record is not None
    record["output"]["path"] = str(target)
    path.replace(target)
    write_file(provenance_path(target), formatted(record), overwrite=True)
    provenance_path(path).unlink()


def _made_by(record: Mapping[str, Any]) -> tuple[Any, ...]:
    """Of an output its recipe, the digests of further layers, the limits that it kept, and the versions of packages."""
    return (
        record["recipe"]["sha256"],
        [other["sha256"] for other in record["input"]["others"]],
        record.get("guards", {}).get("limits", {}),
        {name: record["versions"].get(name) for name in PACKAGES},
    )


def _is_whole(record: Mapping[str, Any], scan: Scan, path: Path) -> bool:
    """Whether the files of a record are what they were, input and output with all that belongs to them."""
    described = [record["output"], *record["output"].get("side_files", ()), *record["input"]["side_files"]]
    pairs = [(scan.input, record["input"]["sha256"]), *((Path(f["path"]), f["sha256"]) for f in described)]
    if Path(record["output"]["path"]) != path or (path != scan.output and len(described) > 1):
        return False  # files beside an output have names that begin with its own
    return all(path.is_file() and sha256_of(path) == digest for path, digest in pairs)
