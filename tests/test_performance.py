"""benchmarks/all.py: what it compares gives the same results, and what it writes is what it measured."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from peers import measurement, results
from peers.contest import Contest
from peers.every import CONTESTS
from peers.measurement import OURS, Block, Timing
from peers.page import page
from peers.results import Run, bandwidth_share, fallen, ratio, slope
from peers.subjects import kept_subject, loaded_subject, make_subject

subject_of = cache(make_subject)
COMPARED = [(c, name) for c in CONTESTS.values() for name, peer in c.peers.items() if peer.agrees is not None]


@pytest.mark.slow
@pytest.mark.parametrize(("contest", "peer"), COMPARED, ids=[f"{c.name}, {name}" for c, name in COMPARED])
def test_peers_that_solve_the_same_equations_agree(contest: Contest, peer: str) -> None:
    """On a small subject in random order the peer's result is ours, within the difference that its contest allows."""
    other = contest.peers[peer]
    if not other.is_installed():
        pytest.skip(f"{other.needs} is not installed")
    subject = subject_of(contest.subject, contest.tiny, "random")
    ours, theirs = contest.ours(subject)(), other.prepare(subject)()
    assert other.agrees is not None
    assert measurement.difference(contest.result(ours), contest.result(theirs)) <= other.agrees


@pytest.mark.parametrize("contest", CONTESTS.values(), ids=CONTESTS)
def test_every_contest_says_what_bounds_it(contest: Contest) -> None:
    """The page has a sentence about each, and a ratio that is asked for is above 0."""
    assert contest.bound.endswith(".")
    assert all(peer.goal is None or peer.goal > 0 for peer in contest.peers.values())


def test_a_failing_peer_costs_nobody_else_their_time() -> None:
    """Its error is told, and ours and the others are measured."""

    def fail(_: object) -> None:
        raise MemoryError("too large")

    contest = next(iter(CONTESTS.values()))
    peer = next(iter(contest.peers.values()))
    broken = Contest(
        "broken",
        contest.ours,
        "Nothing.",
        {"failing": type(peer)(fail, "numpy"), "missing": type(peer)(fail, "no_such_module")},  # type: ignore[arg-type]
    )
    subject = subject_of("mesh", 1_000, "random")
    timings = measurement.turns(broken, 500, subject, subject, rounds=2)
    assert timings["failing"].error == "MemoryError: too large"
    assert timings["missing"].error == "no_such_module is not installed"
    assert timings[OURS].rounds == 2
    assert timings[OURS].seconds > 0.0


@pytest.mark.slow
def test_a_subject_is_kept_as_it_was_made(tmp_path: Path) -> None:
    """The process that measures gets the same arrays."""
    made, kept = make_subject("mesh", 500, "random"), loaded_subject(kept_subject(tmp_path, "mesh", 500, "random"))
    assert all((a == b).all() for a, b in ((made.vertices, kept.vertices), (made.faces, kept.faces), (made.free, kept.free)))
    assert made.edge == kept.edge


def run_of(ours: dict[int, float], theirs: float, *, load: float = 0.1) -> Run:
    """A run of one contest with the given seconds."""
    blocks = [
        Block(
            "Taubin, 10 pairs of steps",
            n,
            "scan",
            load,
            load,
            {OURS: Timing(t, t, t, 3), "VTK": Timing(theirs, theirs, theirs, 3)},
        )
        for n, t in ours.items()
    ]
    return Run("a machine", "2026-01-01", {"numpy": "2"}, 1e10, 2, blocks)


def test_ratios_growth_and_bandwidth_are_what_they_are_called() -> None:
    """Of times 0.01 s and 0.2 s for ten times the vertices, a peer of 0.4 s, and 10 GB/s."""
    run = run_of({10_000: 0.01, 100_000: 0.2}, 0.4)
    contest = CONTESTS[run.blocks[0].contest]
    assert ratio(run.blocks[1], "VTK") == pytest.approx(2.0)
    assert slope(run, contest, "scan") == pytest.approx(1.30103)
    assert contest.traffic is not None
    assert bandwidth_share(contest, run.blocks[1], run.bandwidth) == pytest.approx(contest.traffic * 100_000 / 0.2 / 1e10)


def test_a_ratio_that_fell_is_marked_and_one_within_noise_is_not(tmp_path: Path) -> None:
    """Against a saved run, read back from its file, in which ours took 0.1 s: 0.2 s has fallen, 0.11 s has not."""
    path = tmp_path / "saved.json"
    run_of({100_000: 0.1}, 0.4).saved(path)
    saved = Run.load(path)
    assert saved == run_of({100_000: 0.1}, 0.4)
    assert fallen(run_of({100_000: 0.2}, 0.4).blocks[0], "VTK", saved) == pytest.approx(4.0)
    assert fallen(run_of({100_000: 0.11}, 0.4).blocks[0], "VTK", saved) is None
    assert "2 (2) fell from 4" in page(run_of({100_000: 0.2}, 0.4), saved)


def test_a_later_run_keeps_what_it_did_not_measure() -> None:
    """A run of some contests or sizes is added to the saved one; what both have is the new one's."""
    together = run_of({100_000: 0.3}, 0.4).together_with(run_of({10_000: 0.01, 100_000: 0.2}, 0.4))
    assert {block.size: block.timings[OURS].seconds for block in together.blocks} == {10_000: 0.01, 100_000: 0.3}


def test_the_page_says_where_a_peer_is_faster_and_whether_the_machine_was_quiet() -> None:
    """A peer of half our time is in bold and in the list; a load of one core is said."""
    quiet, loaded = page(run_of({100_000: 0.2}, 0.1), None), page(run_of({100_000: 0.2}, 0.4, load=1.0), None)
    assert "**0.5** (0.5)" in quiet
    assert "* Taubin, 10 pairs of steps: VTK (100k scan 0.5)" in quiet
    assert "The machine was quiet" in quiet
    assert "was not quiet**: other work took up to 1.0 cores" in loaded
    assert "Nowhere in this run." in loaded


def test_the_page_is_that_of_the_saved_run() -> None:
    """docs/performance.md is written from benchmarks/all.json; `python benchmarks/all.py --show` renews it."""
    root = Path(__file__).parent.parent
    saved = results.Run.load(root / "benchmarks" / "all.json")
    assert saved is not None
    assert (root / "docs" / "performance.md").read_text("utf-8") == page(saved, None)
