"""Each file of the tables is read whole, or refused for its reason; what of it is lost or doubtful is said, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeAlias

import pytest

from pymeshfair.files.errors import InputError

from ..running.runs import session_report, warnings_besides_unit
from .corpora import archives, corners, gltf, obj, off, ply, points, scenes, stl
from .mutants import MATERIALS

#: a refusal, or the numbers of vertices and faces and what the warnings say
Verdict: TypeAlias = "str | tuple[Any, ...]"
TABLES = (ply, obj, off, stl, points, gltf, scenes, archives, corners)
CASES: dict[str, tuple[str | bytes, Verdict]] = {name: (data, verdict) for t in TABLES for name, data, verdict in t.ROWS}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_every_row_of_the_tables(tmp_path: Path, name: str) -> None:
    """Refused in the words of the table; or read with its counts, and with its warnings and no other."""
    data, verdict = CASES[name]
    (tmp_path / "a.mtl").write_bytes(MATERIALS)
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    if isinstance(verdict, str):
        with pytest.raises(InputError) as caught:
            session_report(path, tmp_path / "out.ply")
        assert verdict.replace("{}", name) in str(caught.value)
        return
    report = session_report(path, tmp_path / "out.ply")
    assert (report["after"]["vertices"], report["after"]["faces"]) == verdict[:2]
    words = [w for w in verdict[2:] if not w.startswith("MeshLab says")]  # which the supervisor hears
    warnings = warnings_besides_unit(report, name)
    assert len(warnings) == len(words), warnings
    for said, expected in zip(warnings, words, strict=True):
        assert expected.replace("{}", name) in said


def test_the_tables_are_wide() -> None:
    """There are more bad and awkward files than in the comparison of readers, whose 175 are of as many kinds."""
    assert len(CASES) > 350
    assert sum(isinstance(verdict, str) for _, verdict in CASES.values()) > 200
