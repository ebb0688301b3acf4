"""Every block of every page runs, in order, in a fresh folder with the demo's scan.

Blocks of ``sh`` go to a shell, those of ``python`` are one program, and ``xml`` and ``csv`` are files of the folder.
``exit=2`` behind the language says that a block fails, and with which code. ``sh elsewhere`` installs, or needs several machines.
CONTRIBUTING.md has a test of its own. The tests take a piece of the scan; most are slow, and run before a release.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest
import trimesh

from pymeshfair.commands.run import sample_scan

from .meshes import sample_path, tube

PROJECT = Path(__file__).parents[1]
BLOCK = re.compile(r"^```(\w*) ?([\w=]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: the names of files whose text is a block
FILES = {"xml": "my_recipe.mlx", "csv": "table.csv"}
PAGES = [
    f"{path.relative_to(PROJECT)}"
    for path in (PROJECT / "README.md", *sorted((PROJECT / "docs").glob("*.md")))
    if re.search(r"^```(sh|python)$", path.read_text("utf-8"), re.MULTILINE)
]
#: those that take a few seconds on a piece of the scan
QUICK = {f"docs/{name}.md" for name in ("robust", "curves", "writing_recipes", "fairing")}
#: the commands of pages, with one change: the page to tune on is served for two seconds, without a browser
COMMAND = f"""#!/bin/sh
if [ "$1" = demo ] && [ -e pymeshfair_demo ]; then exit; fi  # a piece of the demo's scan is there
if [ "$1" != tune ]; then exec {sys.executable} -m pymeshfair "$@"; fi
timeout -s INT 10 {sys.executable} -m pymeshfair "$@" --no-browser; code=$?
[ $code = 124 ]
"""


def _piece(whole: trimesh.Trimesh) -> trimesh.Trimesh:
    """The middle of the demo's scan, 18 mm wide."""
    middle = whole.vertices[:, :2].min(axis=0) / 2 + whole.vertices[:, :2].max(axis=0) / 2
    inside = (np.abs(whole.vertices[:, :2] - middle) < 9.0).all(axis=1)
    used, faces = np.unique(whole.faces[inside[whole.faces].all(axis=1)], return_inverse=True)
    return trimesh.Trimesh(whole.vertices[used], faces.reshape(-1, 3), process=False)


def _cloud(scan: trimesh.Trimesh) -> Any:
    """Its points alone."""
    return trimesh.Trimesh(scan.vertices, process=False)


def _parts() -> trimesh.Trimesh:
    """Two open tubes, one behind the other."""
    vertices, faces = tube()
    ahead = vertices + np.array([0.0, 0.0, 1.5 * np.ptp(vertices[:, 2])])
    return trimesh.Trimesh(np.concatenate([vertices, ahead]), np.concatenate([faces, faces + len(vertices)]), process=False)


def _painted(scan: trimesh.Trimesh) -> trimesh.Trimesh:
    """The scan with red vertices in its middle."""
    far = np.linalg.norm(scan.vertices - scan.vertices.mean(axis=0), axis=1)
    colors = np.where((far < np.quantile(far, 0.1))[:, None], [255, 0, 0, 255], [200, 200, 200, 255])
    return trimesh.Trimesh(scan.vertices, scan.faces, vertex_colors=colors.astype(np.uint8), process=False)


def _survey(scan: trimesh.Trimesh, path: str) -> None:
    cloud = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    cloud.header.scales = np.full(3, 0.001)
    cloud.xyz = scan.vertices
    cloud.write(path)


def _script(path: str) -> None:
    from pymeshfair import Recipe

    recipe = Recipe("smoothing")
    recipe.apply_coord_taubin_fairing(iterations=5)
    recipe.save(path)


#: what pages name besides scan.ply, and how it comes into the folder
OTHERS: dict[str, Callable[[trimesh.Trimesh, str], object]] = {
    "scans/north.ply": lambda scan, path: scan.export(path),
    "scans/south.ply": lambda scan, path: scan.export(path),
    "cloud.ply": lambda scan, path: _cloud(scan).export(path),
    "painted.ply": lambda scan, path: _painted(scan).export(path),
    "parts.ply": lambda scan, path: _parts().export(path),
    "scan.obj": lambda scan, path: scan.export(path),
    "bunny.obj": lambda scan, path: shutil.copy(sample_path("bunny.obj"), path),
    "hall.ply": lambda scan, path: _cloud(scan).export(path),
    "valley.laz": _survey,
    "statue.ply": lambda scan, path: scan.export(path),
    "my_smoothing.mlx": lambda scan, path: _script(path),
    "old.mlx": lambda scan, path: shutil.copy(sample_path("sample_filter_script.mlx"), path),
}


@pytest.mark.parametrize(
    ("page", "whole"),
    [
        pytest.param(
            page,
            whole,
            id=f"{Path(page).stem}-{'whole' if whole else 'piece'}",
            marks=[] if page in QUICK and not whole else pytest.mark.slow,
        )
        for whole in (False, True)
        for page in PAGES
    ],
)
def test_the_blocks_of_a_page_run_in_order(page: str, whole: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each ends with the exit code that it says; Python's need nothing but what those before have defined."""
    text = (PROJECT / page).read_text("utf-8")
    folder, commands = tmp_path / "work", tmp_path / "bin"
    folder.mkdir()
    commands.mkdir()
    for name, program in {"pymeshfair": COMMAND, "python": f'#!/bin/sh\nexec {sys.executable} "$@"\n'}.items():
        (commands / name).write_text(program)
        (commands / name).chmod(0o755)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PATH", f"{commands}{os.pathsep}{os.environ['PATH']}")
    scan: Any = trimesh.load(sample_scan(), process=False)
    scan = scan if whole else _piece(scan)
    scan.export("scan.ply")
    for name, make in OTHERS.items():
        if name in text or (name.startswith("scans/") and "scans/" in text):
            Path(name).parent.mkdir(exist_ok=True)
            make(scan, name)
    if not whole:
        Path("pymeshfair_demo").mkdir()
        shutil.copy("scan.ply", "pymeshfair_demo/face.ply")
    names: dict[str, object] = {}
    for language, how, block in BLOCK.findall(text):
        if language in FILES:
            Path(FILES[language]).write_text(block, "utf-8")
        elif language == "python":
            exec(compile(block, page, "exec"), names)
        elif language == "sh" and how != "elsewhere":
            done = subprocess.run(["bash", "-eo", "pipefail", "-c", block], capture_output=True, text=True, timeout=1800)
            assert done.returncode == int(how.removeprefix("exit=") or 0), f"{block}\n{done.stdout}\n{done.stderr}"


def test_every_block_is_of_a_kind_that_runs_or_shows() -> None:
    """A block has a language, and what is not run is a picture, or says that it belongs elsewhere."""
    for path in (PROJECT / "README.md", PROJECT / "CONTRIBUTING.md", *(PROJECT / "docs").glob("*.md")):
        for language, how, block in BLOCK.findall(path.read_text("utf-8")):
            assert language in {"sh", "python", "bibtex", "mermaid", *FILES}, f"{path.name}: {block}"
            assert re.fullmatch(r"elsewhere|exit=\d+|", how), f"{path.name}: {how}"
