"""Whether a worker gives the results that this machine gives: asked of every one before a batch begins."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import PymeshfairError
from .errors import BatchError
from .plan import Scan
from .resume import packages_here
from .settings import Settings

#: what the name of the file begins with by which workers show that they see the folder of outputs
PROBE_PREFIX = ".pymeshfair-batch-"


@contextlib.contextmanager
def probe(folder: Path, scans: Sequence[Scan], settings: Settings) -> Iterator[dict[str, Any]]:
    """What workers are asked, as a document for `unfit_for`, while a file lies in the folder of outputs that they must see.

    Raises:
        BatchError: nothing can be written to the folder.
    """
    for left in folder.glob(f"{PROBE_PREFIX}*"):  # by a batch that was killed
        left.unlink(missing_ok=True)
    path, token = folder / f"{PROBE_PREFIX}{secrets.token_hex(8)}", secrets.token_hex(16)
    firsts = {scan.input.parent: scan.input for scan in reversed(scans)}
    try:
        path.write_text(token, "ascii")
    except OSError as error:
        raise BatchError(f"cannot write to the folder {folder}: {error.strerror or error}") from error
    try:
        yield {
            "packages": packages_here(),
            "settings": settings.to_document(),
            "recipe": settings.recipe.digest,
            "probe": str(path),
            "token": token,
            "inputs": {str(p): _size(p) for p in (*firsts.values(), *settings.others)},
        }
    finally:
        path.unlink(missing_ok=True)


def unfit_for(asked: Mapping[str, Any]) -> list[str]:
    """Why this process must not take part in a batch; empty if it may."""
    reasons = []
    here = packages_here()
    for name, version in asked["packages"].items():
        if here[name] != version:
            reasons.append(f"it has {name} {here[name] or 'not at all'} in place of {version}")
    try:
        digest = Settings.from_document(asked["settings"]).recipe.digest
        if digest != asked["recipe"]:
            reasons.append(f"the recipe means something else there (checksum {digest[:12]} in place of {asked['recipe'][:12]})")
    except PymeshfairError as error:
        reasons.append(f"it cannot read the recipe: {error}")
    return reasons + _unseen(asked)


def _unseen(asked: Mapping[str, Any]) -> list[str]:
    reasons = []
    probe = Path(asked["probe"])
    try:
        seen = probe.read_text("ascii") == asked["token"]
    except OSError:
        seen = False
    if not seen:
        reasons.append(f"it does not see the folder of outputs {probe.parent}")
    elif not os.access(probe.parent, os.W_OK | os.X_OK):
        reasons.append(f"it cannot write to the folder of outputs {probe.parent}")
    unseen = [Path(path) for path, size in asked["inputs"].items() if size is not None and _size(Path(path)) != size]
    if unseen:
        more = f" and {len(unseen) - 1} others" if len(unseen) > 1 else ""
        reasons.append(f"it does not see the input {unseen[0]}{more}, or sees another file there")
    return reasons


def _size(path: Path) -> int | None:
    try:
        return path.stat().st_size
    except OSError:
        return None
