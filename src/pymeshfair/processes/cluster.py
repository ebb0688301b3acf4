"""Connects to a dask scheduler, and checks that its workers have the same packages and files as this machine."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import pickle
import secrets
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import PymeshfairError, RunError, require_extra
from .environment import packages_here

if TYPE_CHECKING:
    from distributed import Client

_ANSWER = "10s"  # how long a scheduler may take to answer
_PROBE_PREFIX = ".pymeshfair-batch-"  # of the probe file, which workers read to prove that they see the folder of outputs


class ClusterError(RunError):
    """The workers of a scheduler cannot start or continue the work."""


class LostSchedulerError(ClusterError):
    """The connection to the scheduler is lost."""

    def __init__(self) -> None:
        super().__init__("the scheduler does not answer any more; restart it, then continue with --resume")


@dataclass(frozen=True)
class Scheduler:
    """The address and the certificates of a dask scheduler, as in dask's own commands."""

    address: str = ""  # such as ``tcp://host:8786``; empty if it is in `file`
    file: Path | None = None  # the file to which ``dask scheduler --scheduler-file`` writes its address
    ca_file: Path | None = None  # certificates of the authorities that the client trusts
    certificate: Path | None = None  # the certificate of this client
    key: Path | None = None  # its private key

    def __post_init__(self) -> None:
        require_extra("cluster", "distributed")

    def find_address(self) -> str:
        if self.file is None:
            return self.address
        try:
            return str(json.loads(self.file.read_bytes())["address"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ClusterError(f"{self.file} has no address of a scheduler: {error}") from error

    def security(self) -> Any:
        """Returns the certificates for dask; None leaves them to dask's configuration."""
        from distributed.security import Security

        files = {"tls_ca_file": self.ca_file, "tls_client_cert": self.certificate, "tls_client_key": self.key}
        for path in files.values():
            if path is not None and not path.is_file():
                raise ClusterError(f"there is no file {path}")
        existing = {name: str(path) for name, path in files.items() if path is not None}
        return Security(require_encryption=True, **existing) if existing else None  # type: ignore[no-untyped-call]


@contextlib.contextmanager
def open_client(scheduler: Scheduler) -> Iterator[Client]:
    """Opens a client of a scheduler."""
    from distributed import Client

    # `ClusterError` reports the errors, so dask's loggers are silenced: each of them, since some have a level of their own.
    for name in ("distributed", "tornado", *logging.root.manager.loggerDict):
        if name.partition(".")[0] in ("distributed", "tornado"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # dask warns about differing versions
        address, security = scheduler.find_address(), scheduler.security()
        try:
            client = Client(address, security=security, timeout=_ANSWER, set_as_default=False)  # type: ignore[no-untyped-call]
        except (OSError, ValueError, TimeoutError, TypeError, RuntimeError) as error:
            hint = "; it may need a certificate (--tls-ca-file, --tls-cert, --tls-key)" if security is None else ""
            raise ClusterError(f"no scheduler answers at {address}: {error}{hint}") from error
        with client:
            yield client


@dataclass(frozen=True)
class Conditions:
    """The conditions that a worker must meet."""

    packages: Mapping[str, str | None]  # the version of each package
    probe: Path  # a file in the folder of outputs
    token: str  # the content of that file
    inputs: Mapping[Path, int | None]  # some inputs with their sizes in bytes, None if unknown
    recipe: bytes  # pickled
    digest: str  # of the recipe

    def unfit(self) -> list[str]:
        """Returns the reasons why this process cannot be a worker; empty if it can."""
        installed, folder = packages_here(), self.probe.parent
        reasons = [
            f"it has {f'{name} {installed[name]}' if installed[name] else f'no {name}'}, and the client {version or 'none'}"
            for name, version in self.packages.items()
            if installed[name] != version
        ]
        try:
            if (digest := pickle.loads(self.recipe).digest) != self.digest:
                reasons.append(f"it reads the recipe differently (checksum {digest[:12]} in place of {self.digest[:12]})")
        except PymeshfairError as error:
            reasons.append(f"it cannot read the recipe: {error}")
        try:
            is_seen = self.probe.read_text("ascii") == self.token
        except OSError:
            is_seen = False
        if not is_seen:
            reasons.append(f"it does not see the folder of outputs {folder}")
        elif not os.access(folder, os.W_OK | os.X_OK):
            reasons.append(f"it cannot write to the folder of outputs {folder}")
        unseen = [path for path, size in self.inputs.items() if size is not None and _size(path) != size]
        if unseen:
            more = f" and {len(unseen) - 1} others" if len(unseen) > 1 else ""
            reasons.append(f"it does not see the input {unseen[0]}{more}, or sees another file there")
        return reasons


@contextlib.contextmanager
def conditions(folder: Path, recipe: Any, inputs: Sequence[Path]) -> Iterator[Conditions]:
    """Yields the conditions for a `Recipe`; during the context the folder of outputs has the probe file."""
    for old_probe in folder.glob(f"{_PROBE_PREFIX}*"):  # a killed run may have left it
        old_probe.unlink(missing_ok=True)
    path, token = folder / f"{_PROBE_PREFIX}{secrets.token_hex(8)}", secrets.token_hex(16)
    try:
        path.write_text(token, "ascii")
    except OSError as error:
        raise ClusterError(f"cannot write to the folder {folder}: {error.strerror or error}") from error
    try:
        sizes = {input: _size(input) for input in inputs}
        yield Conditions(packages_here(), path, token, sizes, pickle.dumps(recipe), recipe.digest)
    finally:
        path.unlink(missing_ok=True)


def check_workers(client: Client, worker_conditions: Conditions) -> None:
    """Raises `ClusterError` if a worker does not meet the conditions, or if there is none."""
    answers = client.run(worker_conditions.unfit, on_error="return")
    if not answers:
        raise ClusterError("the scheduler has no workers; start workers, then start the run again")
    unfit = {
        address: [f"the check failed there: {type(answer).__name__}: {answer}"] if isinstance(answer, BaseException) else answer
        for address, answer in answers.items()
        if answer
    }
    if unfit:
        lines = "\n".join(f"  {address}: {'; '.join(reasons)}" for address, reasons in unfit.items())
        raise ClusterError(
            f"{len(unfit)} of {len(answers)} workers cannot take part, and nothing was begun:\n{lines}\n"
            "correct or stop these workers, then start the run again"
        )


def _size(path: Path) -> int | None:
    try:
        return path.stat().st_size
    except OSError:
        return None
