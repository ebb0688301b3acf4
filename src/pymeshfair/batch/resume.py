"""Which scans are done already: by content, from the provenance beside each output, whoever wrote it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..files.provenance import read_provenance, sha256_of
from ..processes.versions import PACKAGES, packages_here
from ..running.job import Job
from .outcome import Outcome, digests_of
from .plan import Scan

#: files are read and digested by so many threads
_READERS = 4


def done_before(scans: Sequence[Scan], template: Job, journal: Mapping[str, Outcome]) -> dict[int, Outcome]:
    """By their numbers the scans whose output is there, made of the same input by the same recipe, limits and versions.

    Args:
        scans: all of a batch.
        template: of the runs of the batch.
        journal: the last line about each output; what it tells beyond the provenance is kept.
    """
    variants = {id(scan.recipe): scan.recipe for scan in scans}
    recipes = {key: recipe.digest for key, recipe in variants.items()}
    guards = {key: replace(template, recipe=recipe).all_guards.texts() for key, recipe in variants.items()}
    others = [sha256_of(path) for path in template.others if path.is_file()]
    packages = packages_here()

    def found(scan: Scan) -> Outcome | None:
        record = read_provenance(scan.output)
        if record is None:
            return None
        try:
            wanted = (recipes[id(scan.recipe)], others, guards[id(scan.recipe)], packages)
            if _made_by(record) != wanted or not _is_whole(record, scan):
                return None
            outcome = Outcome.of_record(record, scan.input, scan.output)
        except (KeyError, TypeError, ValueError, OSError):  # another's document, or a file that is gone
            return None
        if outcome.status == "broken" and not template.keep_broken:
            return None
        told = journal.get(str(scan.output))
        if told is not None and told.digests == digests_of(record):
            outcome = told
        return replace(outcome, resumed=True)

    with ThreadPoolExecutor(_READERS) as pool:
        outcomes = pool.map(found, scans)
        return {scan.number: outcome for scan, outcome in zip(scans, outcomes, strict=True) if outcome is not None}


def _made_by(record: Mapping[str, Any]) -> tuple[Any, ...]:
    """Of an output its recipe, the digests of further layers, the limits that it kept, and the versions of packages."""
    return (
        record["recipe"]["sha256"],
        [other["sha256"] for other in record["input"]["others"]],
        record.get("guards", {}).get("limits", {}),
        {name: record["versions"].get(name) for name in PACKAGES},
    )


def _is_whole(record: Mapping[str, Any], scan: Scan) -> bool:
    """Whether the files of a record are what they were, input and output with all that belongs to them."""
    described = [record["output"], *record["output"].get("side_files", ()), *record["input"]["side_files"]]
    pairs = [(scan.input, record["input"]["sha256"]), *((Path(f["path"]), f["sha256"]) for f in described)]
    if Path(record["output"]["path"]) != scan.output:
        return False
    return all(path.is_file() and sha256_of(path) == digest for path, digest in pairs)
