"""Each file of the corpus is read whole, or refused with the reason; none silently becomes something else."""

from __future__ import annotations

from pathlib import Path

import pytest

from pymeshfair.files.errors import InputError

from ..running.runs import session_report, warnings_besides_unit
from .corpus import Case, documents, gltfs, headers, plys, texts


@pytest.mark.parametrize("case", [*texts(), *gltfs(), *plys(), *headers(), *documents()], ids=lambda case: case.name)
def test_every_file_gets_its_verdict(tmp_path: Path, case: Case) -> None:
    """Refused for the reason, or read to the last vertex and face with a word about what is not kept."""
    path = tmp_path / case.name
    path.write_bytes(case.data)
    if case.refusal is not None:
        with pytest.raises(InputError, match=case.refusal):
            session_report(path, tmp_path / "out.ply")
        return
    report = session_report(path, tmp_path / "out.ply")
    assert (report["after"]["vertices"], report["after"]["faces"]) == case.counts
    warnings = " ".join(warnings_besides_unit(report, case.name))
    assert (case.warning is None and not warnings) or (case.warning is not None and case.warning in warnings)


def test_nothing_is_hashed_of_what_is_no_mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A large file that begins as none of its format does is refused for its first bytes, and not read for its digest."""

    def read_whole(path: Path, **_: object) -> None:
        raise AssertionError(f"{path} was read whole")

    monkeypatch.setattr("pymeshfair.running.session.described_file", read_whole)
    for name in ("a.ply", "a.glb", "a.3mf", "a.dae", "a.wrl"):
        path = tmp_path / name
        with path.open("wb") as file:
            file.truncate(1 << 31)
        with pytest.raises(InputError, match="does not begin with"):
            session_report(path, tmp_path / f"{name}.ply")
