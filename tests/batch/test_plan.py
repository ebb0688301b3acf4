"""Which scans a command line means, and where their outputs go."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest
import trimesh

from pymeshfair.batch.plan import expand, plan_scans, sample, without_outputs
from pymeshfair.batch.work import Task
from pymeshfair.commands.batch import BatchLines
from pymeshfair.errors import ParameterError
from pymeshfair.recipe import load_recipe
from pymeshfair.running.job import Job
from pymeshfair.running.supervise import run_job
from tests.meshes import icosphere


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder: two scans, another in a folder within, and what is no scan."""
    folder = tmp_path / "no pattern [1]"
    (folder / "deep").mkdir(parents=True)
    for name in ("b.ply", "a.stl", "deep/c.ply", "notes.txt", ".hidden.ply", "readme.md"):
        (folder / name).write_text("x")
    monkeypatch.chdir(folder)
    return folder


def names(*arguments: str) -> list[str]:
    """The inputs that arguments mean, from the working folder."""
    return [asked.input.relative_to(Path.cwd()).as_posix() for asked in expand(arguments)]


def test_arguments_are_files_folders_and_patterns(folder: Path) -> None:
    """In the order of the arguments, within a folder or pattern by path, each scan once; a folder with all below it."""
    assert names("b.ply", "b.ply") == ["b.ply"]
    assert names(".") == ["a.stl", "b.ply", "deep/c.ply"]
    assert names(".", "deep") == ["a.stl", "b.ply", "deep/c.ply"]
    assert names("*.ply") == ["b.ply"]
    assert names("**/*.ply") == ["b.ply", "deep/c.ply"]
    assert names("gone.ply") == ["gone.ply"]  # its turn tells that it is not there
    (folder / "odd[1].ply").write_text("x")
    assert names("odd[1].ply") == ["odd[1].ply"]


def test_lists_name_what_lies_beside_them(folder: Path) -> None:
    """A list has an argument a line, relative to its own folder, with blank lines and comments."""
    (folder / "deep" / "list.txt").write_text("# scans\n\nc.ply\n../*.ply\n")
    assert [asked.input.resolve() for asked in expand(["@deep/list.txt"])] == [folder / "deep/c.ply", folder / "b.ply"]


def test_tables_set_outputs_and_parameters(folder: Path) -> None:
    """Columns set the output and the recipe's values; an empty cell sets nothing, nor does a column with # before its name."""
    table = "\ufeffinput,output,taubin.lambda,depth,#note,#note\nb.ply,x.ply,0.4,,blue,\ndeep/c.ply,,,2,red,\n"
    (folder / "t.csv").write_text(table, "utf-8")
    first, second = expand(["t.csv"], ["depth"])
    assert (first.input, first.output, first.overrides) == (folder / "b.ply", "x.ply", ("taubin.lambda=0.4",))
    assert (second.input, second.output, second.overrides) == (folder / "deep/c.ply", None, ("depth=2",))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("", "needs a column 'input'"),
        ("name\nx\n", "needs a column 'input'; it has 'name'"),
        ("input,ouput\nb.ply,x\n", "'ouput' is no known column; did you mean 'output'"),
        ("input,input\nb.ply,b.ply\n", "'input' is there twice"),
        ("input,output\nb.ply\n", "t.csv:2: it has 1 cells, but the table has 2 columns"),
        ("input,output\n,x.ply\n", "t.csv:2: the cell of the column input is empty"),
        ('input\n"b.ply\n', "t.csv"),
        ("input\nb\0.ply\n", "t.csv: it is not UTF-8 text"),
    ],
)
def test_wrong_tables_are_refused(folder: Path, table: str, message: str) -> None:
    """The message says where and what."""
    (folder / "t.csv").write_text(table)
    with pytest.raises(ParameterError, match=message):
        expand(["t.csv"])


@pytest.mark.parametrize("argument", ["@-", "-"])
def test_names_on_standard_input_are_utf_8(folder: Path, argument: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in files: in every locale, and after a byte order mark."""
    data = "\ufeffinput\né.ply\n" if argument == "-" else "\ufeffé.ply\r\n"
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data.encode("utf-8")), encoding="latin-1"))
    assert [scan.input.name for scan in expand([argument])] == ["é.ply"]


@pytest.mark.parametrize("argument", ["*.obj", "@gone.txt", "empty", "gone.csv", ""])
def test_what_means_nothing_is_refused(folder: Path, argument: str) -> None:
    """A pattern without files, a list or a table that is not there, a folder without scans."""
    (folder / "empty").mkdir()
    with pytest.raises(ParameterError):
        expand([argument])


def test_a_sample_is_spread_by_size(folder: Path) -> None:
    """The smallest and the largest file are among those that are chosen, in the order of the batch."""
    for number, size in enumerate((5, 900, 40, 1, 300)):
        (folder / f"s{number}.ply").write_text("x" * size)
    scans = plan_scans(expand(["s*.ply"]), load_recipe("smooth_taubin"), folder / "out")
    for count, chosen in ((1, [3]), (2, [1, 3]), (3, [1, 2, 3]), (5, [0, 1, 2, 3, 4]), (9, [0, 1, 2, 3, 4])):
        assert [scan.number - 1 for scan in sample(scans, count)] == chosen
    assert sample([], 2) == []


def test_a_batch_of_no_scan_ends_with_an_empty_summary(folder: Path) -> None:
    """As does one whose sample has none; only its journal is written."""
    recipe = load_recipe("smooth_taubin")
    out = folder / "out"
    scans = plan_scans(expand(["b.ply"]), recipe, out)
    task = Task(scans, Job(recipe, Path(), Path()), out, None, 1, sample=0, report=True)
    assert task.carry_out(BatchLines()).counts["left"] == 1
    assert task.written == ()


def planned(*arguments: str, name: str = "", out: str = "out") -> list[str]:
    """The outputs of a batch from the folder of outputs."""
    base = Path.cwd() / out
    return [
        s.output.relative_to(base).as_posix() for s in plan_scans(expand(arguments), load_recipe("smooth_taubin"), base, name)
    ]


def test_outputs_are_named_after_inputs(folder: Path) -> None:
    """By default with the same name, in a format that can be written; else as asked, with folders if need be."""
    (folder / "d.pts").write_text("x")
    assert planned(".") == ["a.stl", "b.ply", "d.pts", "deep/c.ply"]
    assert planned("**/*.ply", name="{folder}/x/{stem}.obj") == ["x/b.obj", "deep/x/c.obj"]
    assert planned("b.ply", "deep/c.ply", name="{parent}/{stem}_{number:02}.obj") == [f"{folder.name}/b_01.obj", "deep/c_02.obj"]


@pytest.mark.parametrize(
    ("arguments", "name", "out", "message"),
    [
        ((".", "deep"), "x.ply", "out", "would be the output of .*a.stl and of .*b.ply and of .*c.ply"),
        (("b.ply",), "", ".", "b.ply, the output of .*b.ply, is the input"),
        (("b.ply", "deep/c.ply"), "{stem}_{parent}.ply", ".", None),
        (("b.ply",), "../b2.ply", "out", "would lie outside"),
        (("b.ply",), "{stam}.ply", "out", r"cannot be made from .*; it may have \{stem\}"),
        (("b.ply",), "{", "out", "cannot be made"),
    ],
)
def test_no_output_is_lost(folder: Path, arguments: tuple[str, ...], name: str, out: str, message: str | None) -> None:
    """Two scans with one output, an output that is an input or outside the folder, and names that cannot be made are refused."""
    if message is None:
        assert len(planned(*arguments, name=name, out=out)) == len(arguments)
        return
    with pytest.raises(ParameterError, match=message):
        planned(*arguments, name=name, out=out)


def test_a_row_changes_its_own_recipe_alone(folder: Path) -> None:
    """Values of a table hold for their scan; a value that the recipe does not have is refused."""
    (folder / "t.csv").write_text("input,1.stepsmoothnum\nb.ply,3\na.stl,\n")
    recipe = load_recipe("smooth_taubin")
    first, second = plan_scans(expand(["t.csv"]), recipe, folder / "out")
    assert first.recipe.script.steps[0].values["stepsmoothnum"] == 3
    assert second.recipe is recipe
    (folder / "t.csv").write_text("input,1.nothing\nb.ply,3\n")
    with pytest.raises(LookupError, match="nothing"):
        plan_scans(expand(["t.csv"]), recipe, folder / "out")


def test_scans_have_the_shortest_names_that_differ(folder: Path) -> None:
    """A name that another scan has, too, gets the folders before it; one input with two outputs the names of these."""
    for name in ("one/left/scan.ply", "two/left/scan.ply", "two/right/scan.ply"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("x")
    (folder / "t.csv").write_text("input,output\none/left/scan.ply,x.ply\none/left/scan.ply,y.ply\n")
    recipe = load_recipe("smooth_taubin")
    scans = plan_scans(expand(["b.ply", "one", "two"]), recipe, folder / "out", "{number}.ply")
    assert [scan.label for scan in scans] == ["b.ply", "one/left/scan.ply", "two/left/scan.ply", "right/scan.ply"]
    assert [s.label for s in plan_scans(expand(["t.csv"]), recipe, folder / "out")] == ["scan.ply to x.ply", "scan.ply to y.ply"]
    (folder / "t.csv").write_text("input,output\nb.ply,x/b.ply\nb.ply,y/b.ply\n")
    assert [s.label for s in plan_scans(expand(["t.csv"]), recipe, folder / "out")] == ["b.ply to x/b.ply", "b.ply to y/b.ply"]


def test_outputs_among_the_inputs_leave_no_scan(folder: Path) -> None:
    """A folder of inputs cannot be the folder of outputs, under whatever name."""
    (folder / "link").symlink_to(folder)
    for out in (folder, folder / "link"):
        with pytest.raises(ParameterError, match=r"the scans lie in the folder of outputs, .*give outputs another folder"):
            without_outputs(expand(["."]), out)
    kept, dropped = without_outputs(expand(["."]), folder / "deep")
    assert [scan.input.name for scan in kept] == ["a.stl", "b.ply"]
    assert dropped == [f"{folder / 'deep' / 'c.ply'}, which lies in the folder of outputs"]


def test_a_scan_that_a_run_replaced_is_a_scan(tmp_path: Path) -> None:
    """A run that wrote over its input did not make it of another scan."""
    trimesh.Trimesh(*icosphere(1), process=False).export(tmp_path / "scan.ply")
    run_job(Job(load_recipe("smooth_taubin"), tmp_path / "scan.ply", tmp_path / "scan.ply", overwrite=True))
    kept, dropped = without_outputs(expand([str(tmp_path)]), tmp_path / "out")
    assert ([scan.input.name for scan in kept], dropped) == (["scan.ply"], [])


def test_a_wrong_value_of_a_table_is_named_with_its_line(folder: Path) -> None:
    """The error of a cell says in which line of which table it is."""
    (folder / "t.csv").write_text("input,1.stepsmoothnum\nb.ply,3\na.stl,ten\n")
    with pytest.raises(ParameterError, match=r"t\.csv:3: cannot set '1\.stepsmoothnum=ten'"):
        plan_scans(expand(["t.csv"]), load_recipe("smooth_taubin"), folder / "out")
