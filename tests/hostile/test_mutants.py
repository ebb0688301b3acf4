"""Damaged files of every format: read or refused at once, and never read as a mesh of other faces than their text has."""

from __future__ import annotations

import random
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.files.polygons import triangulated

from .mutants import MATERIALS, SEEDS, check, mutant


@pytest.mark.slow
@pytest.mark.parametrize("name", SEEDS)
def test_damaged_files_are_read_or_refused(tmp_path: Path, name: str) -> None:
    """Of 120 files none raises anything but an error about the input, or takes two seconds; some are read and some refused."""
    choose, counts = random.Random(f"test {name}"), Counter[str]()
    (tmp_path / "a.mtl").write_bytes(MATERIALS)
    triangulated(np.eye(4, 3), np.arange(4), np.array([4]))  # compiles it where there is no store of kernels
    path = tmp_path / name
    path.write_bytes(SEEDS[name]())
    assert check(path) == "read"
    for number in range(120):
        path.write_bytes(mutant(name, choose))
        started = time.perf_counter()
        verdict = check(path)
        assert verdict in ("read", "refused"), number
        assert time.perf_counter() - started < 2.0
        counts[verdict] += 1
    assert counts.keys() == {"read", "refused"}
