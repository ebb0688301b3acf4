"""Every command that writes, on every kind of place to write to: nothing that is there is lost."""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeAlias
from urllib.parse import urlsplit

import pytest
import trimesh
from websockets.sync.client import connect
from websockets.typing import Origin

import pymeshfair
from pymeshfair.errors import PymeshfairError
from pymeshfair.files.provenance import provenance_path
from pymeshfair.recipe import load_recipe
from pymeshfair.registry import find_filter
from pymeshfair.scripts.script import Script, Step
from pymeshfair.scripts.write import format_script
from tests.meshes import icosphere, noisy

from .command_line import COMMAND, document, invoke

OLD = '<!DOCTYPE FilterScript><FilterScript><filter name="Remove Duplicated Vertex"/></FilterScript>'
TAUBIN = format_script(Script((Step(find_filter("apply_coord_taubin_smoothing")),)))

#: writes to a file, with or without leave to replace it; whether it said that it did
Write: TypeAlias = Callable[[Path, bool], bool]


def by_command(*arguments: str, option: str = "-o") -> Write:
    """A command with the file as an option."""

    def write(target: Path, overwrite: bool) -> bool:
        return invoke(*arguments, option, target, *(["--overwrite"] if overwrite else [])).exit_code == 0

    return write


def by_python(call: Callable[[Path, bool], object]) -> Write:
    """A call of Python, which may replace a script without being asked, as pymeshlab's does."""

    def write(target: Path, overwrite: bool) -> bool:
        try:
            call(target, overwrite)
        except PymeshfairError:
            return False
        return True

    return write


def saved_script(target: Path) -> None:
    """A script of a mesh set."""
    meshes = pymeshfair.MeshSet()
    meshes.create_cube()
    meshes.save_filter_script(str(target))


#: every command that writes a file that is named, with the extension of the file
WRITERS: dict[str, tuple[str, Write]] = {
    "run": ("ply", by_command("run", "smooth_taubin", "scan.ply")),
    "run obj": ("obj", by_command("run", "smooth_taubin", "scan.ply")),
    "run --map": ("ply", by_command("run", "smooth_taubin", "scan.ply", "-o", "made.ply", option="--map")),
    "run --report": ("html", by_command("run", "smooth_taubin", "scan.ply", "-o", "made.ply", option="--report")),
    "run --tiles": ("ply", by_command("run", "tiles.mlx", "scan.ply", "--tiles")),
    "pymeshfair.run": ("ply", by_python(lambda t, o: pymeshfair.run("smooth_taubin", "scan.ply", t, overwrite=o))),
    "upgrade": ("mlx", by_command("upgrade", "old.mlx")),
    "export": ("mlx", by_command("export", "taubin.mlx")),
    "suggest": ("mlx", by_command("suggest", "scan.ply")),
    "picture": ("png", by_command("picture", "scan.ply")),
    "spectrum": ("svg", by_command("spectrum", "scan.ply")),
    "compare --report": ("html", by_command("compare", "scan.ply", "scan.ply", option="--report")),
    "MeshSet.save_filter_script": ("mlx", by_python(lambda t, o: saved_script(t))),
    "Recipe.save": ("mlx", by_python(lambda t, o: pymeshfair.Recipe.load("taubin.mlx").save(t))),
}
#: those that replace a script without being asked
REPLACING = {"MeshSet.save_filter_script", "Recipe.save"}


def make_file(path: Path) -> None:
    """A file of somebody else's."""
    path.write_bytes(b"precious")


def make_link(path: Path) -> None:
    """A link to a file of somebody else's."""
    make_file(path.with_name("leads here"))
    path.symlink_to("leads here")


def make_device(path: Path) -> None:
    """A device that swallows everything."""
    try:
        os.mknod(path, 0o600 | stat.S_IFCHR, os.makedev(1, 3))
    except (OSError, AttributeError):
        pytest.skip("only the superuser makes devices, and not everywhere")


def make_pipe(path: Path) -> None:
    """A pipe that is not read."""
    if not hasattr(os, "mkfifo"):
        pytest.skip("there are no pipes in folders here")
    os.mkfifo(path)


def make_folder(path: Path) -> None:
    """A folder that is not empty."""
    path.mkdir()
    make_file(path / "file")


#: what may be at a place, apart from nothing
IN_THE_WAY: dict[str, Callable[[Path], object]] = {
    "file": make_file,
    "link": make_link,
    "link that leads nowhere": lambda path: path.symlink_to("nowhere"),
    "pipe": make_pipe,
    "device": make_device,
    "folder": make_folder,
}


def entries(folder: Path) -> dict[str, object]:
    """Everything in a folder: what kind of thing each is, and what is in it."""
    found: dict[str, object] = {}
    for path in folder.rglob("*"):
        state = path.lstat()
        holds = str(path.readlink()) if path.is_symlink() else path.read_bytes() if stat.S_ISREG(state.st_mode) else state.st_rdev
        found[str(path.relative_to(folder))] = (stat.S_IFMT(state.st_mode), holds)
    return found


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The working folder, with what the commands read; opening a pipe for writing ends the test."""
    trimesh.Trimesh(*noisy(icosphere(3), 0.01), process=False).export(tmp_path / "scan.ply")
    (tmp_path / "old.mlx").write_text(OLD)
    (tmp_path / "taubin.mlx").write_text(TAUBIN)
    (tmp_path / "tiles.mlx").write_text('<FilterScript><filter name="Taubin Fairing"/></FilterScript>')
    monkeypatch.chdir(tmp_path)

    def hangs(*_: object) -> None:
        raise AssertionError("it hangs")

    if hasattr(signal, "SIGALRM"):
        before = signal.signal(signal.SIGALRM, hangs)
        signal.alarm(300)
        yield tmp_path
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    else:
        yield tmp_path


def lost(before: dict[str, object], after: dict[str, object]) -> set[str]:
    """What is not there any more as it was."""
    return {name for name, thing in before.items() if after.get(name) != thing}


#: tried at every change, the others before a release
QUICK = ("file",)
KINDS = [kind if kind in QUICK else pytest.param(kind, marks=pytest.mark.slow) for kind in IN_THE_WAY]


@pytest.mark.slow
@pytest.mark.parametrize("overwrite", [False, True], ids=["", "overwrite"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", WRITERS)
def test_nothing_in_the_way_is_lost(name: str, kind: str, overwrite: bool, place: Path) -> None:
    """What is there stays and the command fails, and writes nothing else; a file alone is replaced, if that was asked for."""
    extension, write = WRITERS[name]
    target = place / f"target.{extension}"
    IN_THE_WAY[kind](target)
    before = entries(place)
    may = kind == "file" and (overwrite or name in REPLACING)
    assert write(target, overwrite) is may
    after = entries(place)
    assert lost(before, after) == ({target.name} if may else set())
    assert may or after == before


@pytest.mark.parametrize("name", WRITERS)
def test_no_file_of_another_kind_is_replaced(name: str, place: Path) -> None:
    """A file whose name has an extension that the command does not write stays, whatever was asked for."""
    target = place / ("notes.md" if WRITERS[name][0] in ("ply", "obj") else "precious.ply")
    make_file(target)
    before = entries(place)
    assert not WRITERS[name][1](target, True)
    assert entries(place) == before


@pytest.mark.parametrize("name", WRITERS)
def test_a_missing_folder_is_not_made(name: str, place: Path) -> None:
    """A file in a folder that does not exist, or is none, is refused."""
    extension, write = WRITERS[name]
    before = entries(place)
    for folder in ("missing", "scan.ply"):
        assert not write(place / folder / f"target.{extension}", True)
    assert entries(place) == before


@pytest.mark.parametrize("name", [name for name, (extension, _) in WRITERS.items() if extension != "mlx"])
def test_a_hyphen_is_no_file(name: str, place: Path) -> None:
    """No command makes a file named "-"."""
    before = entries(place)
    WRITERS[name][1](Path("-"), True)
    assert entries(place) == before


@pytest.mark.slow
@pytest.mark.parametrize("name", ["upgrade old.mlx", "export taubin.mlx", "suggest scan.ply"])
def test_scripts_go_to_standard_output(name: str, place: Path) -> None:
    """With ``-o -`` standard output holds the script and nothing else; with --json beside it the command line is refused."""
    before = entries(place)
    done = invoke(*name.split(), "-o", "-")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.startswith("<!DOCTYPE FilterScript>")
    assert done.stdout.endswith("</FilterScript>\n")
    assert invoke(*name.split(), "-o", "-", "--json").exit_code == 2
    assert entries(place) == before


@pytest.mark.slow
def test_the_page_to_tune_on_saves_over_nothing(place: Path) -> None:
    """What is there under the name of a recipe to save stays; a file alone is replaced, if that was ticked."""
    for kind, make in IN_THE_WAY.items():
        if kind != "device":
            make(place / f"{kind}.mlx")
    (place / "leads here").write_bytes(b"precious")
    before = entries(place)
    command = [*COMMAND, "tune", "scan.ply", "--recipe", "smooth_taubin", "--no-browser", "--json"]
    steps = [{"on": True, "values": {}} for _ in load_recipe("smooth_taubin").script.steps]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = urlsplit(document("".join(iter(process.stdout.readline, "}\n")) + "}")["address"])
        origin = Origin(f"http://{address.netloc}")
        with connect(f"ws://{address.netloc}{address.path}socket", origin=origin, max_size=None) as page:

            def save(name: str, replace: bool) -> str:
                page.send(json.dumps({"do": "save", "recipe": "smooth_taubin", "name": name, "steps": steps, "replace": replace}))
                while True:
                    said = page.recv()
                    if isinstance(said, str) and (word := json.loads(said)["is"]) in ("saved", "problem"):
                        return str(word)

            names = [kind for kind in IN_THE_WAY if kind != "device"]
            assert [save(name, False) for name in names] == ["problem"] * len(names)
            assert entries(place) == before
            assert [save(name, True) for name in names] == ["saved"] + ["problem"] * (len(names) - 1)
            assert lost(before, entries(place)) == {"file.mlx"}
            assert save("scan.ply", True) == "saved"  # as scan.ply.mlx
            assert lost(before, entries(place)) == {"file.mlx"}
        process.send_signal(signal.SIGINT)


#: the files that are written beside others, by what writes them
BESIDE: dict[str, tuple[Sequence[str], str]] = {
    "provenance": (("run", "smooth_taubin", "scan.ply", "-o", "out/made.ply"), "made.ply.provenance.json"),
    "materials": (("run", "smooth_taubin", "scan.ply", "-o", "out/made.obj"), "made.obj.mtl"),
    "map of what was removed": (
        ("run", "smooth_taubin", "scan.ply", "-o", "out/made.ply", "--map", "out/map.ply"),
        "map.removed.ply",
    ),
    "batch, an output": (("batch", "smooth_taubin", "scan.ply", "-o", "out"), "scan.ply"),
    "batch, a provenance": (("batch", "smooth_taubin", "scan.ply", "-o", "out"), "scan.ply.provenance.json"),
    "batch.csv": (("batch", "smooth_taubin", "scan.ply", "-o", "out"), "batch.csv"),
    "batch.json": (("batch", "smooth_taubin", "scan.ply", "-o", "out"), "batch.json"),
    "batch.jsonl": (("batch", "smooth_taubin", "scan.ply", "-o", "out"), "batch.jsonl"),
    "batch.html": (("batch", "smooth_taubin", "scan.ply", "-o", "out", "--report"), "batch.html"),
    "demo": (("demo", "-o", "out"), "face_clean.ply"),
    "demo, the scan": (("demo", "-o", "out"), "face.ply"),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", BESIDE)
def test_nothing_beside_an_output_is_lost(name: str, kind: str, place: Path) -> None:
    """What a command writes besides what was named replaces nothing either."""
    arguments, target = BESIDE[name]
    (place / "out").mkdir()
    IN_THE_WAY[kind](place / "out" / target)
    before = entries(place)
    done = invoke(*arguments)
    assert not lost(before, entries(place)), done.output


def test_a_folder_of_a_batch_may_be_no_folder(place: Path) -> None:
    """A batch and a demo into what is no folder are refused, and it stays."""
    for kind in ("file", "link", "link that leads nowhere", "pipe"):
        IN_THE_WAY[kind](place / "out")
        before = entries(place)
        for command in (("batch", "smooth_taubin", "scan.ply"), ("demo",)):
            assert invoke(*command, "-o", "out").exit_code == 1, (kind, command)
            assert entries(place) == before
        (place / "out").unlink()


@pytest.mark.slow
def test_pages_of_a_batch_replace_no_other_files(place: Path) -> None:
    """The page of a scan goes where none or a former one is; what else is there stays, and the batch says so."""
    reports = place / "out" / "reports"
    reports.mkdir(parents=True)
    make_file(reports / "scan.ply.html")
    done = invoke("batch", "smooth_taubin", "scan.ply", "-o", "out", "--report")
    assert "no page" in done.stderr
    assert (reports / "scan.ply.html").read_bytes() == b"precious"
    (reports / "scan.ply.html").unlink()
    for _ in range(2):
        assert "no page" not in invoke("batch", "smooth_taubin", "scan.ply", "-o", "out", "--report").stderr
    assert (reports / "scan.ply.html").exists()


@pytest.mark.slow
def test_a_former_result_is_replaced_by_the_same_run_alone(place: Path) -> None:
    """The same command may be given again; another recipe or setting is refused, in Python and by the command."""
    output = place / "out.ply"
    pymeshfair.run("smooth_taubin", "scan.ply", output)
    first = output.read_bytes()
    assert invoke("run", "smooth_taubin", "scan.ply", "-o", output).exit_code == 0
    pymeshfair.run("smooth_taubin", place / "scan.ply", output)
    with pytest.raises(PymeshfairError, match="by another recipe, or with other settings"):
        pymeshfair.run("denoise_meshlab_only", "scan.ply", output)
    with pytest.raises(PymeshfairError, match="by another recipe, or with other settings"):
        pymeshfair.run("smooth_taubin", "scan.ply", output, set=["1.stepSmoothNum=3"])
    refused = invoke("run", "denoise_meshlab_only", "scan.ply", "-o", output)
    assert refused.exit_code == 1
    assert "by another recipe, or with other settings" in refused.stderr
    assert output.read_bytes() == first
    pymeshfair.run("denoise_meshlab_only", "scan.ply", output, overwrite=True)
    assert output.read_bytes() != first
    assert provenance_path(output).exists()
