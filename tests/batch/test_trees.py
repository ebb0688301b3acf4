"""A tree of scans with equal names: kept, each row told apart, and done again only where it has changed."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from pymeshfair.files.provenance import provenance_path
from tests.commands.command_line import document, run_process

from .batches import journal_of, write_scan


def write_tree(folder: Path, folders: int, each: int) -> Path:
    """So many folders with scans of the same names."""
    for k in range(folders):
        parent = folder / f"wing{k % 4}" / f"find{k:02}"
        parent.mkdir(parents=True)
        for i in range(each):
            write_scan(parent / f"scan{i}.ply", 100 * k + i, subdivisions=0)
    return folder


def batch(tree: Path, out: Path, *options: str) -> tuple[dict[str, Any], int]:
    """The document of a resumed batch, and how many scans it did."""
    done = run_process("batch", "smooth_taubin", tree, "-o", out, "--resume", "--json", *options)
    assert done.returncode in (0, 1), done.stderr
    found = document(done.stdout)
    return found, found["counts"]["scans"] - found["counts"]["resumed"] - found["counts"]["left"]


def outputs(out: Path) -> list[str]:
    """The meshes in the folder of a batch."""
    return sorted(path.relative_to(out).as_posix() for path in out.rglob("*.ply"))


@pytest.mark.parametrize(("folders", "each"), [(6, 2), pytest.param(40, 8, marks=pytest.mark.slow)])
def test_a_tree_is_kept_and_resumed(tmp_path: Path, folders: int, each: int) -> None:
    """The outputs have the tree of the inputs and unique names; an added, a changed and a removed file cost 1, 1 and 0 scans."""
    tree, out = write_tree(tmp_path / "tree", folders, each), tmp_path / "tree" / "clean"
    total = folders * each
    (tree / "wing0" / "find00" / "broken.ply").write_bytes(b"ply\n")
    found, done = batch(tree, out)
    assert done == total + 1
    assert found["counts"]["failed"] == 1
    assert outputs(out) == sorted(p.relative_to(tree).as_posix() for p in tree.glob("wing*/*/scan*.ply"))
    names = [scan["name"] for scan in found["scans"]]
    assert len(set(names)) == total + 1
    assert "broken.ply" in names
    assert "find01/scan1.ply" in names
    (tree / "wing0" / "find00" / "broken.ply").unlink()
    assert batch(tree, out)[1] == 0
    write_scan(tree / "wing0" / "find00" / "another.ply", 9999, subdivisions=0)
    assert batch(tree, out)[1] == 1
    write_scan(tree / "wing1" / "find01" / "scan0.ply", 8888, subdivisions=0)
    assert batch(tree, out)[1] == 1
    shutil.rmtree(tree / "wing2" / "find02")
    assert batch(tree, out)[1] == 0


@pytest.mark.slow
def test_an_output_of_an_earlier_recipe_is_named(tmp_path: Path) -> None:
    """Where a scan fails now the row says of which recipe the file is that lies there; the file stays."""
    tree, out = write_tree(tmp_path / "tree", 2, 1), tmp_path / "out"
    batch(tree, out)
    scan = tree / "wing0" / "find00" / "scan0.ply"
    scan.write_bytes(b"ply\n")
    done = run_process("batch", "smooth_implicit", tree, "-o", out, "--overwrite")
    assert done.returncode == 1
    assert "the existing output is of smooth_taubin, run at 20" in done.stderr
    assert "find00/scan0.ply" in done.stdout
    assert provenance_path(out / "wing0" / "find00" / "scan0.ply").exists()
    assert [line["former"][:38] for line in journal_of(out) if line["status"] == "failed"] == [
        "the existing output is of smooth_taubi"
    ]


@pytest.mark.slow
def test_outputs_of_earlier_runs_are_left_out_and_named(tmp_path: Path) -> None:
    """Outputs beside their inputs are no scans of the next batch, nor is what lies in its folder of outputs."""
    tree = write_tree(tmp_path / "tree", 1, 1)
    scan = tree / "wing0" / "find00" / "scan0.ply"
    assert run_process("run", "smooth_taubin", scan, "-o", scan.with_name("smooth.ply")).returncode == 0
    for _ in range(2):
        done = run_process("batch", "smooth_taubin", tree, "-o", tree / "out", "--name", "{folder}/{stem}_clean.ply", "--json")
        assert done.returncode == 0, done.stderr
        assert document(done.stdout)["counts"]["scans"] == 1
        assert f"left out: {scan.with_name('smooth.ply')}" in done.stderr.replace("\n", "")
    assert outputs(tree / "out") == ["wing0/find00/scan0_clean.ply"]
