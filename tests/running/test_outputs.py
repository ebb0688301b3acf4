"""Files that appear whole or not at all, and that replace nothing they must not."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from pymeshfair.files.errors import OutputError
from pymeshfair.files.outputs import MadeFrom, check_output, material_path
from pymeshfair.files.provenance import SCHEMA, described_file, provenance_path, recorded_digest
from pymeshfair.files.writing import StagedFile, place, stage_file
from pymeshfair.operating_system import System


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """An input file."""
    path = tmp_path / "scan.ply"
    path.write_bytes(b"input")
    return path


def record(output: Path, source: Path, *side_files: Path) -> None:
    """Write the provenance of an output as a run would."""
    entry = described_file(output) | {"side_files": [described_file(f) for f in side_files]}
    document = {"schema": SCHEMA, "input": {"path": str(source.absolute())}, "recipe": {"sha256": "recipe"}, "output": entry}
    provenance_path(output).write_text(json.dumps(document))


def check(output: Path, source: Path, *, overwrite: bool = False) -> None:
    """Whether a run of the recipe may write the output."""
    check_output(output, MadeFrom(source, "recipe"), overwrite=overwrite)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("gone/out.ply", "the folder .*gone does not exist; make it first"),
        ("scan.ply/out.ply", "the folder .*scan.ply is no folder"),
        (
            "out.docx",
            r"'.docx' is no format for it; name a file that ends with .ply, .obj, .off, .stl, .glb, .3mf, .wrl, .las, .laz, .xyz",
        ),
        ("out", "it has no extension that says the format"),
        ("folder.ply", "there is a folder"),
        ("a" * 240 + ".ply", "its name has 260 bytes, and 255 are the most"),
        ("scan.ply", "it is the input"),
        ("link.ply", "it is the input"),
        ("stranger.ply", "it exists and no provenance says that a run wrote it"),
    ],
)
def test_outputs_that_are_refused_before_any_work(tmp_path: Path, source: Path, name: str, reason: str) -> None:
    """A missing folder, an unknown format, a folder in the way, the input and a stranger's file are each refused for that."""
    (tmp_path / "folder.ply").mkdir()
    (tmp_path / "stranger.ply").write_bytes(b"precious")
    (tmp_path / "link.ply").hardlink_to(source)
    with pytest.raises(OutputError, match=reason):
        check(tmp_path / name, source)
    assert (tmp_path / "stranger.ply").read_bytes() == b"precious"


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="the superuser may write everywhere")
def test_a_folder_without_permission_is_refused(tmp_path: Path, source: Path) -> None:
    """A folder that cannot be written to is refused before any work."""
    (tmp_path / "locked").mkdir(mode=0o500)
    with pytest.raises(OutputError, match="cannot be written to"):
        check(tmp_path / "locked" / "out.ply", source)


def test_overwriting_by_name(tmp_path: Path, source: Path) -> None:
    """With `overwrite` the input and a stranger's file may be replaced, but a folder still may not."""
    (tmp_path / "stranger.ply").touch()
    (tmp_path / "folder.ply").mkdir()
    check(source, source, overwrite=True)
    check(tmp_path / "stranger.ply", source, overwrite=True)
    with pytest.raises(OutputError, match="there is a folder"):
        check(tmp_path / "folder.ply", source, overwrite=True)


def test_what_a_former_run_wrote_may_be_replaced(tmp_path: Path, source: Path) -> None:
    """An output whose provenance names the same input and whose digest is unchanged is replaced without asking."""
    output = tmp_path / "out.obj"
    output.write_bytes(b"mesh")
    material_path(output).write_bytes(b"newmtl")
    record(output, source, material_path(output))
    check(output, source)
    output.unlink()
    check(output, source)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda o, s: o.write_bytes(b"edited by hand"), "has been changed since a run wrote it"),
        (lambda o, s: material_path(o).write_bytes(b"edited"), "obj.mtl: it exists and has been changed"),
        (lambda o, s: provenance_path(o).write_text("{}"), "no provenance says"),
        (lambda o, s: provenance_path(o).write_text(f'{{"schema": "{SCHEMA}", "input": 1, "output": 2}}'), "no provenance says"),
        (lambda o, s: provenance_path(o).write_text(f'{{"schema":"{SCHEMA}","input":{{}},"output":{{}},"guards":0}}'), "no prov"),
        (lambda o, s: provenance_path(o).write_text("broken {"), "no provenance says"),
        (lambda o, s: record(o, s.with_name("other.ply"), material_path(o)), "was made from another input, .*other.ply"),
        (lambda o, s: record(o, s), "obj.mtl: it exists and is not from the last run that wrote the output"),
    ],
)
def test_anything_else_is_not(tmp_path: Path, source: Path, change: Callable[[Path, Path], object], reason: str) -> None:
    """Once the output, its material file or its provenance is another than the one written, it is nobody's to replace."""
    output = tmp_path / "out.obj"
    output.write_bytes(b"mesh")
    material_path(output).write_bytes(b"newmtl")
    record(output, source, material_path(output))
    change(output, source)
    with pytest.raises(OutputError, match=reason):
        check(output, source)


def test_a_link_is_no_former_output(tmp_path: Path, source: Path) -> None:
    """A symbolic link is not followed and not replaced, wherever it points."""
    (tmp_path / "out.ply").symlink_to(tmp_path / "nowhere" / "out.ply")
    for overwrite in (False, True):
        with pytest.raises(OutputError, match="there is a link: name the file itself that it leads to"):
            check(tmp_path / "out.ply", source, overwrite=overwrite)


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    """A staging folder with a new output, a new provenance and a new texture."""
    folder = tmp_path / "stage"
    (folder / "old").mkdir(parents=True)
    for name in ("mesh", "provenance", "texture"):
        (folder / name).write_bytes(f"new {name}".encode())
    return folder


def put_in_place(stage: Path, folder: Path) -> None:
    """Commit the files of the fixture `stage`."""
    side = StagedFile(stage / "texture", folder / "t.png")
    output = StagedFile(stage / "mesh", folder / "out.ply")
    provenance = StagedFile(stage / "provenance", provenance_path(folder / "out.ply"))
    place([side, output, provenance], stage, outdated=[provenance.target])


def contents(folder: Path) -> dict[str, bytes]:
    """The files of a folder with what is in them."""
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}


NEW = {"out.ply": b"new mesh", "out.ply.provenance.json": b"new provenance", "t.png": b"new texture"}
OLD = {"out.ply": b"old mesh", "out.ply.provenance.json": b"old provenance", "t.png": b"old texture"}


@pytest.mark.parametrize("links", [True, False], ids=["hard links", "no hard links"])
@pytest.mark.parametrize("before", [{}, OLD], ids=["nothing there", "replacing"])
def test_all_files_appear(
    tmp_path: Path, stage: Path, before: dict[str, bytes], links: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A commit puts the three files in place, on file systems with and without hard links."""
    if not links:
        monkeypatch.setattr(os, "link", lambda *a, **k: (_ for _ in ()).throw(OSError("no links here")))
    for name, data in before.items():
        (tmp_path / name).write_bytes(data)
    put_in_place(stage, tmp_path)
    assert contents(tmp_path) == NEW


@pytest.mark.parametrize("before", [{}, OLD], ids=["nothing there", "replacing"])
@pytest.mark.parametrize("step", range(4))
@pytest.mark.parametrize("error", [OSError(13, "Permission denied"), KeyboardInterrupt()])
def test_or_none_of_them(
    tmp_path: Path, stage: Path, before: dict[str, bytes], step: int, error: BaseException, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever rename fails, or the flush after the last, what was there before is there again, and nothing else."""
    for name, data in before.items():
        (tmp_path / name).write_bytes(data)
    moves = iter(range(100))
    replace, flush_ = Path.replace, System.flush

    def failing_replace(self: Path, target: Path) -> Path:
        if self.parent == stage and next(moves) == step:
            raise error
        return replace(self, target)

    def failing_flush(self: System, path: Path) -> None:
        if step == 3:
            raise error
        flush_(self, path)

    monkeypatch.setattr(Path, "replace", failing_replace)
    monkeypatch.setattr(System, "flush", failing_flush)
    with pytest.raises(OutputError if isinstance(error, OSError) else KeyboardInterrupt):
        put_in_place(stage, tmp_path)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("step", range(4))
def test_power_cuts_leave_no_output_with_another_ones_provenance(
    tmp_path: Path, stage: Path, step: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If everything ends between two renames, a provenance file and the output beside it still belong together."""
    for name, data in OLD.items():
        (tmp_path / name).write_bytes(data)
    moves = iter(range(100))
    replace = Path.replace

    def seen(self: Path, target: Path) -> Path:
        if self.parent == stage and next(moves) == step:
            now = contents(tmp_path)
            mesh, provenance = now["out.ply"], now.get("out.ply.provenance.json")
            assert provenance is None or mesh.split()[0] == provenance.split()[0]
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", seen)
    put_in_place(stage, tmp_path)


def test_whole_files(tmp_path: Path) -> None:
    """`stage_file` writes what it is given and never over another file."""
    stage_file(tmp_path / "a", tmp_path / "b", b"data")
    assert (tmp_path / "a").read_bytes() == b"data"
    with pytest.raises(OutputError, match=r"cannot write .*b: file exists"):
        stage_file(tmp_path / "a", tmp_path / "b", b"other")


def test_a_record_with_gaps_has_no_digests(tmp_path: Path) -> None:
    """Side files that are null, as another program may write them, and an entry without a digest are as good as none."""
    record = {"output": {"path": "/a/out.obj", "side_files": None}, "guards": {"maps": None}}
    assert recorded_digest(record, tmp_path / "out.obj") is None
    assert recorded_digest(record, tmp_path / "out.mtl") is None
