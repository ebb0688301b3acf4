"""A batch from its plan to its summary; scans that are done already are known by their content, from provenance."""

import math
import secrets
import shutil
import time
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import KW_ONLY, dataclass, field, replace
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from ..errors import ParameterError, RunError
from ..files.formats import extension
from ..files.inputs import check_input
from ..files.outputs import check_output
from ..files.provenance import formatted, provenance_path, read_provenance, recorded_digest, sha256_of
from ..files.writing import check_place, check_target, write_file
from ..processes.cluster import Scheduler
from ..processes.environment import PACKAGES, packages_here
from ..processes.pool import Pool
from ..processes.process import Items
from ..running.job import Job
from ..running.read import read_mesh
from ..running.supervise import Interrupts
from ..scripts.guards import refuse_unmeasured
from ..scripts.warnings import check_needs
from .journal import NAME, BatchError, Journal, Outcome, now, read_journal
from .page import NAME as PAGE
from .page import write_page
from .plan import Scan
from .station import Course, Listener, Station, ThisMachine, Workers, pool_of
from .summary import DOCUMENT, TABLE, Summary

#: so many scans are opened for each one that is chosen
_OPENED = 4


def sample(scans: Sequence[Scan], count: int) -> list[Scan]:
    """The `count` (at least 1) scans that lie furthest apart in the ranks of size and of noise, in the order of the batch.

    Size is that of the file; noise is the mean angle between neighbouring faces, of a few scans that are spread by size. One that
    cannot be opened is chosen for its size alone.
    """
    if count >= len(scans):
        return list(scans)
    by_size = sorted(scans, key=lambda scan: (scan.input.stat().st_size if scan.input.is_file() else 0, scan.number))
    steps = min(len(by_size), _OPENED * count) - 1
    opened = [by_size[i] for i in sorted({round(k * (len(by_size) - 1) / max(1, steps)) for k in range(steps + 1)})]
    noise = [_noise(scan.input) for scan in opened]
    ranked = {k: r for r, k in enumerate(sorted(range(len(opened)), key=lambda k: noise[k]))}
    places = [(k / len(opened), ranked[k] / len(opened)) for k in range(len(opened))]
    chosen = [0]  # the smallest
    while len(chosen) < count:
        left = (k for k in range(len(opened)) if k not in chosen)
        chosen.append(max(left, key=lambda k: (min(math.dist(places[k], places[c]) for c in chosen), k)))
    return sorted((opened[k] for k in chosen), key=lambda scan: scan.number)


def _noise(path: Path) -> float:
    try:
        measures = read_mesh(path).measures
    except RunError:
        return 0.0
    return float(measures["roughness"] or measures["mean_spacing"] or 0.0)


#: an output in doubles over its input in single precision, at most
_GROWTH = 2.0


@dataclass(frozen=True)
class Prospect:
    """The work that a batch would do."""

    states: Mapping[int, str]  # of each scan ``"to do"``, ``"done"`` or ``"cannot be done"``, by its number
    problems: Mapping[int, str]  # of those that cannot be done why, by their numbers
    bytes_in: int  # of the inputs that are to do
    bytes_free: int | None  # where the outputs go, or None where the system does not say

    @property
    def lacks_room(self) -> bool:
        """Whether the outputs probably do not fit on the disk."""
        return self.bytes_free is not None and self.bytes_free < _GROWTH * self.bytes_in


#: files are read and digested by so many threads
_READERS = 4


@dataclass(frozen=True)
class Done:
    """A scan that is done."""

    outcome: Outcome  # as of this batch
    path: Path  # its output; another than that of the scan if its number in the names has changed


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
    others = [sha256_of(path) for path in template.others if path.is_file()]
    packages = packages_here()

    def look(scan: Scan, path: Path) -> Done | None:
        record = read_provenance(path)
        if record is None:
            return None
        try:
            job = replace(template, recipe=scan.recipe)
            limits = job.all_guards.in_mesh_units(job.unit_of(record["input"].get("unit"))).texts()
            if _made_by(record) != (scan.recipe.digest, others, limits, packages) or not _is_whole(record, scan, path):
                return None
            outcome = Outcome.of_record(record, scan.input, scan.output)
        except (KeyError, TypeError, ValueError, OSError, ParameterError):  # another's document, or a file that is gone
            return None
        if outcome.status == "broken" and not template.keep_broken:
            return None
        former = journal.get(str(path))
        if former is not None and former.digests == outcome.digests:
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


@dataclass
class Task:
    """One batch."""

    scans: Sequence[Scan]  # all of them
    template: Job  # of their runs: what all scans share
    folder: Path  # where outputs go, an absolute path; made if need be
    scheduler: Scheduler | None  # of dask; None for this machine
    jobs: int  # scans at a time on this machine
    _: KW_ONLY
    resume: bool = False  # skip what is done
    stop: bool = False  # give up after the first scan that fails
    sample: int | None = None  # do only so many, spread by size and noise
    report: bool = False  # make a page of every scan that is done, and one of the batch
    renumber: bool = False  # with `resume`, rename outputs whose numbers in the names have changed
    written: tuple[Path, ...] = field(default=(), init=False)  # the files about the batch as a whole, once they are there

    def look_ahead(self) -> Prospect:
        """The work that would be done; nothing is written."""
        if self.folder.is_dir():
            self._check_own_files()
        return self._prospect(self._done(read_journal(self.folder / NAME)))

    def _prospect(self, done: Collection[int]) -> Prospect:
        """What can be seen without opening a mesh."""
        template = self.template
        check_needs(template.recipe.script, layers=1 + len(template.others))
        if not template.measures:
            refuse_unmeasured(template.all_guards)
        for path in template.others:
            check_input(path)
        states, problems, size = {}, {}, 0
        for scan in self.scans:
            states[scan.number] = "done" if scan.number in done else "to do"
            if scan.number in done:
                continue
            job = replace(template, input=scan.input, recipe=scan.recipe)
            job.check_unit()
            try:
                check_input(scan.input)
                size += scan.input.stat().st_size
                if scan.output.parent.is_dir():
                    check_output(scan.output, job.made_from, overwrite=template.overwrite)
            except (RunError, OSError) as error:
                states[scan.number], problems[scan.number] = "cannot be done", str(error)
        free = None
        with suppress(OSError):
            there = next((parent for parent in (self.folder, *self.folder.parents) if parent.exists()), self.folder)
            free = shutil.disk_usage(there).free
        return Prospect(states, problems, size, free)

    def _check_own_files(self) -> None:
        """Refuse a folder with files that have the names of those about the batch as a whole, and are not of a former batch.

        Of a former batch they are if the journal is one, see `pymeshfair.batch.journal.read_journal`.
        """
        journal = self.folder / NAME
        is_ours = check_place(journal) and bool(read_journal(journal) or not journal.stat().st_size)
        for name in (NAME, TABLE, DOCUMENT, *([PAGE] if self.report else [])):
            check_target(self.folder / name, (extension(Path(name)),), overwrite=self.template.overwrite or is_ours)

    def _done(self, journal: Mapping[str, Outcome]) -> dict[int, Done]:
        return done_before(self.scans, self.template, journal, renumber=self.renumber) if self.resume else {}

    @contextmanager
    def processes(self) -> Iterator[Pool | None]:
        """Processes of this machine for `carry_out`, which are started as soon as the context is entered."""
        if self.scheduler is not None:
            yield None
            return
        with pool_of(min(self.jobs, len(self.scans))) as pool:
            pool.prepare()
            yield pool

    def carry_out(self, listener: Listener, pool: Pool | None = None) -> Summary:
        """Do it, and write ``batch.json`` and ``batch.csv``, also if interrupted, and ``batch.html`` if a report is wanted."""
        started, clock = now(), time.monotonic()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BatchError(f"cannot make the folder {self.folder}: {error.strerror or error}") from error
        self._check_own_files()
        with Journal(self.folder, resume=self.resume) as journal:
            done = self._done(journal.before)
            if self.renumber and self.resume:
                rename_outputs(self.scans, done, journal)
            if journal.before and not self.resume:
                listener.note(
                    f"the journal of {len(journal.before):,} scans in {self.folder} begins anew; --resume would go on with it"
                )
            if self._prospect(done).lacks_room:
                listener.note(f"the disk of {self.folder} may be too small: outputs may need twice the size of the inputs")
            todo = [scan for scan in self.scans if scan.number not in done]
            if self.sample is not None:
                todo = sample(todo, self.sample)
            listener.begin(len(todo))
            outcomes = {number: one.outcome for number, one in done.items()}
            pages: dict[int, Mapping[str, Any]] = {}
            drawn = [scan for scan in self.scans if scan.number in done and self.report]
            try:
                if todo or drawn:
                    with self._workers(todo or drawn, pool) as (workers, items):
                        report = pages if self.report else None
                        Course(workers, journal, items, listener, outcomes, report, self.stop).run(todo, drawn)
            finally:
                if outcomes:  # else nothing was begun, and the files of a former batch stay
                    ordered = [outcomes[scan.number] for scan in self.scans if scan.number in outcomes]
                    finished, seconds = now(), time.monotonic() - clock
                    summary = Summary(
                        ordered, len(self.scans), self.template, started=started, finished=finished, seconds=seconds
                    )
                    self.written = (*summary.write(self.folder), journal.path)
            if self.report:
                made = {str(scan.output): pages.get(scan.number, {}) for scan in self.scans}
                self.written += (write_page(self.folder, summary, made),)
        return summary

    @contextmanager
    def _workers(self, scans: Sequence[Scan], pool: Pool | None) -> Iterator[tuple[Workers, Items]]:
        """The workers for some scans, and what they and signals put into; raises `ClusterError` if workers do not fit."""
        items: Items = SimpleQueue()
        if self.scheduler is None:
            jobs = min(self.jobs, len(scans))
            station = Station(self.template, self.folder, jobs, pool or pool_of(jobs))
            workers: AbstractContextManager[Workers] = ThisMachine(station, items)
        else:
            from .cluster import workers_of_scheduler

            name = f"pymeshfair-batch-{secrets.token_hex(8)}"
            workers = workers_of_scheduler(self.scheduler, self.template, scans, self.folder, items, name)
        with workers as opened, Interrupts(items):
            yield opened, items
