"""A batch on the workers of a scheduler, all of them processes of their own on the loopback."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from pymeshfair.processes import cluster

from .batches import contents, dask, journal_of, results_of_run, run_batch, start_batch, with_module, write_recipe, write_scans

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="kills processes")

#: a sitecustomize module: another version of pymeshfair
OTHER_VERSION = """
import importlib.metadata
true = importlib.metadata.version
importlib.metadata.version = lambda name: "0.0.9" if name == "pymeshfair" else true(name)
"""


class Scheduler:
    """A scheduler and the workers that a test starts."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "scheduler.json"
        self._processes = [dask("scheduler", "--scheduler-file", str(self._file), "--port", "0", "--no-dashboard")]
        deadline = time.monotonic() + 60
        while not self._file.exists() or not self._file.read_text():
            assert time.monotonic() < deadline
            time.sleep(0.05)
        self.address = json.loads(self._file.read_text())["address"]

    def start_worker(
        self, name: str, environment: Mapping[str, str] | None = None, prefix: tuple[str, ...] = ()
    ) -> subprocess.Popen[bytes]:
        """One worker of one thread in one process."""
        options = ("--name", name, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0")
        self._processes.append(dask("worker", self.address, *options, environment=environment, prefix=prefix))
        return self._processes[-1]

    def wait_for(self, count: int) -> None:
        """Wait until so many workers have come."""
        from distributed import Client

        with Client(self.address, set_as_default=False) as client:
            client.wait_for_workers(count, timeout=60)

    def kill(self) -> None:
        """End the scheduler alone."""
        self._processes[0].kill()
        self._processes[0].wait()

    def close(self) -> None:
        """End all of them."""
        for process in self._processes:
            process.kill()
            process.wait()


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[Scheduler]:
    """A scheduler without workers."""
    scheduler = Scheduler(tmp_path)
    yield scheduler
    scheduler.close()


@pytest.mark.slow
def test_a_lost_worker_costs_a_retry(tmp_path: Path, scheduler: Scheduler) -> None:
    """One of three workers is killed in the middle: every scan is done by the others, and the results are those of `run`."""
    scans = write_scans(tmp_path / "scans", 7)
    recipe = write_recipe(tmp_path / "recipe.mlx", steps=1000)
    workers = [scheduler.start_worker(f"worker{k}") for k in range(3)]
    expected = results_of_run(recipe, scans, tmp_path / "run", only=["scan000.ply", "scan001.ply", "scan002.ply"])
    scheduler.wait_for(3)
    process = start_batch(recipe, scans, "-o", tmp_path / "out", "--scheduler", scheduler.address, "--json")
    deadline = time.monotonic() + 60
    while not journal_of(tmp_path / "out"):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    os.kill(workers[0].pid, signal.SIGKILL)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert json.loads(out)["counts"]["done"] == 7
    found = contents(tmp_path / "out")
    assert {name: found[name] for name in expected} == expected
    assert len(found) == 14


def test_workers_that_are_not_fit_are_refused_before_anything_begins(tmp_path: Path, scheduler: Scheduler) -> None:
    """One of another version and one that sees another folder are named with the reason, and no scan is begun."""
    scans = write_scans(tmp_path / "scans", 2)
    (tmp_path / "out").mkdir()
    scheduler.start_worker("good")
    scheduler.start_worker("old", with_module(tmp_path / "lib", OTHER_VERSION))
    blind = _hides(tmp_path / "out")
    if blind:
        scheduler.start_worker("blind", prefix=blind)
    scheduler.wait_for(3 if blind else 2)
    done = run_batch("smooth_taubin", scans, "-o", tmp_path / "out", "--scheduler", scheduler.address)
    assert done.returncode == 1
    assert f"{2 if blind else 1} of {3 if blind else 2} workers cannot take part, and nothing was begun" in done.stderr
    assert "it has pymeshfair 0.0.9, and the client" in done.stderr
    assert (f"it does not see the folder of outputs {tmp_path / 'out'}" in done.stderr) == bool(blind)
    assert journal_of(tmp_path / "out") == []
    assert not list((tmp_path / "out").glob("*.ply"))


@pytest.mark.slow
def test_a_worker_that_comes_late_and_differs_leaves_again(tmp_path: Path, scheduler: Scheduler) -> None:
    """It gets no scan, and the batch goes on with those that it began with."""
    scans = write_scans(tmp_path / "scans", 3)
    scheduler.start_worker("good")
    scheduler.wait_for(1)
    recipe = write_recipe(tmp_path / "recipe.mlx", steps=5000)
    process = start_batch(recipe, scans, "-o", tmp_path / "out", "--scheduler", scheduler.address, "--json")
    deadline = time.monotonic() + 60
    while not list((tmp_path / "out").glob(".pymeshfair-run-*")):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    late = scheduler.start_worker("late", with_module(tmp_path / "lib", OTHER_VERSION))
    assert late.wait(60) is not None
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    assert json.loads(out)["counts"]["done"] == 3


def _hides(folder: Path) -> tuple[str, ...]:
    """What a command begins with that sees an empty folder there; empty if this system cannot do that."""
    command = ("unshare", "--mount", "sh", "-c", 'mount -t tmpfs tmpfs "$0" && exec "$@"', str(folder))
    if shutil.which("unshare") is None or subprocess.run([*command, "true"], capture_output=True).returncode:
        return ()
    return command


def test_no_scheduler_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """An address where none answers is named."""
    monkeypatch.setattr(cluster, "_ANSWER", "1s")
    with (
        pytest.raises(cluster.ClusterError, match=r"no scheduler answers at tcp://127\.0\.0\.1:1"),
        cluster.open_client(cluster.Scheduler("tcp://127.0.0.1:1")),
    ):
        pass


def certificates(folder: Path, name: str) -> tuple[str, ...]:
    """The options of a certificate that an authority of its own has signed, made as docs/batch.md does it."""
    for command in (
        f"req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=authority -keyout {name}-ca.key -out {name}-ca.pem",
        f"req -newkey rsa:2048 -nodes -subj /CN=scans -keyout {name}.key -out {name}.request",
        f"x509 -req -in {name}.request -CA {name}-ca.pem -CAkey {name}-ca.key -CAcreateserial -days 2 -out {name}.pem",
    ):
        subprocess.run(["openssl", *command.split()], cwd=folder, check=True, capture_output=True)
    files = {"--tls-ca-file": f"{name}-ca.pem", "--tls-cert": f"{name}.pem", "--tls-key": f"{name}.key"}
    return tuple(word for option, file in files.items() for word in (option, str(folder / file)))


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("openssl") is None, reason="makes certificates")
def test_a_scheduler_with_certificates(tmp_path: Path) -> None:
    """Workers with a certificate do the scans; a client without one, or with a strange one, is refused in one sentence."""
    ours, strange = certificates(tmp_path, "ours"), certificates(tmp_path, "strange")
    file = tmp_path / "scheduler.json"
    processes = [dask("scheduler", "--protocol", "tls", "--scheduler-file", str(file), "--port", "0", "--no-dashboard", *ours)]
    options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--memory-limit", "0")
    processes.append(dask("worker", "--scheduler-file", str(file), *options, *ours))
    scans = write_scans(tmp_path / "scans", 2)
    try:
        deadline = time.monotonic() + 60
        done = None
        while done is None or "the scheduler has no workers" in done.stderr or "has no address" in done.stderr:
            assert time.monotonic() < deadline, done
            done = run_batch("smooth_taubin", scans, "-o", tmp_path / "out", "--scheduler-file", file, *ours)
        assert done.returncode == 0, done.stderr
        address = json.loads(file.read_text())["address"]
        assert address.startswith("tls://")
        for wrong in ((), strange):
            refused = run_batch("smooth_taubin", scans, "-o", tmp_path / "other", "--scheduler", address, *wrong)
            assert refused.returncode == 1
            assert f"no scheduler answers at {address}" in refused.stderr
            assert "Traceback" not in refused.stderr
            assert not list((tmp_path / "other").glob("*.ply"))
    finally:
        for process in processes:
            process.kill()
            process.wait()


@pytest.mark.slow
def test_a_lost_scheduler_is_one_sentence(tmp_path: Path, scheduler: Scheduler) -> None:
    """When the scheduler is killed in the middle the batch ends with one sentence, and what is done stays done."""
    scans = write_scans(tmp_path / "scans", 4)
    worker = scheduler.start_worker("only")
    scheduler.wait_for(1)
    recipe = write_recipe(tmp_path / "recipe.mlx", steps=3000)
    process = start_batch(recipe, scans, "-o", tmp_path / "out", "--scheduler", scheduler.address)
    deadline = time.monotonic() + 60
    while not journal_of(tmp_path / "out"):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.02)
    scheduler.kill()
    _, err = process.communicate(timeout=120)
    worker.wait(60)
    assert process.returncode == 1
    assert "the scheduler does not answer any more; restart it, then continue with --resume" in err
    assert "Traceback" not in err
