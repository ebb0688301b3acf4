"""Traps of valid scripts, and what a script needs besides its mesh."""

from __future__ import annotations

from pathlib import Path

import pytest

from pymeshfair.scripts import ScriptError, parse_script
from pymeshfair.scripts.warnings import check_needs, lengths_out_of_proportion, traps, unmet_needs
from tests.scripts.texts import one_filter, script

POISSON = '<filter name="Surface Reconstruction: Screened Poisson"/>'


def test_deleting_the_result_of_a_reconstruction_is_a_trap() -> None:
    """Delete Current Mesh right behind a reconstruction deletes its result today, and not the input."""
    (said,) = traps(parse_script(script(POISSON, '<filter name="Delete Current Mesh"/>'), "a"))
    assert said.startswith("step 2 (Delete Current Mesh, line 4) deletes the result")
    assert not list(traps(parse_script(script('<filter name="Close Holes"/>', '<filter name="Delete Current Mesh"/>'), "a")))


@pytest.mark.parametrize("closing", ["Close Holes", "Close Holes by Fairing", "Bridge Rims by Fairing"])
def test_a_step_on_the_faces_that_closed_the_holes_is_a_trap(closing: str) -> None:
    """A step behind a filter that closes or bridges rims works on the new faces alone, unless it says Selected=false."""
    smooth, close = '<filter name="Laplacian Smooth"/>', f'<filter name="{closing}"/>'
    (said,) = traps(parse_script(script(close, smooth), "a"))
    assert said.startswith(f"step 2 (Laplacian Smooth, line 4) works on the faces that {closing} has selected")
    whole = '<filter name="Laplacian Smooth"><Param type="RichBool" name="Selected" value="false"/></filter>'
    assert not list(traps(parse_script(script(close, whole), "a")))


@pytest.mark.parametrize(("value", "warned"), [("0.5", True), ("0.01", False), ("0", False), ("1e-9", True)])
def test_lengths_that_do_not_suit_the_mesh_are_named(value: str, warned: bool) -> None:
    """On a mesh of diagonal 1 a threshold of 0.01 is fine; half of the mesh and nearly nothing are not."""
    data = one_filter("Merge Close Vertices", f'<Param type="RichAbsPerc" name="Threshold" value="{value}" min="0" max="1"/>')
    said = list(lengths_out_of_proportion(parse_script(data, "a"), diagonal=1.0))
    assert [": Threshold is " in text for text in said] == [True] * warned
    relative = data.replace(b"/>", b' relative="50%"/>')
    assert not list(lengths_out_of_proportion(parse_script(relative, "a"), diagonal=1.0))


def test_lengths_are_not_judged_behind_a_step_that_scales_the_mesh() -> None:
    """Behind a scaling the size of the mesh is another one."""
    merge = '<filter name="Merge Close Vertices"><Param type="RichAbsPerc" name="Threshold" value="9" min="0" max="9"/></filter>'
    data = script('<filter name="Transform: Scale, Normalize"/>', merge)
    assert not list(lengths_out_of_proportion(parse_script(data, "a"), diagonal=1.0))
    assert list(lengths_out_of_proportion(parse_script(script(merge), "a"), diagonal=1.0))


def transfer(source: int, target: int) -> str:
    """A step from one layer to another."""
    param = '<Param type="RichMesh" name="{}" value="{}"/>'.format
    return f'<filter name="Vertex Attribute Transfer">{param("SourceMesh", source)}{param("TargetMesh", target)}</filter>'


def test_layers_that_will_not_be_there_are_named_with_their_line() -> None:
    """A step may name the layers of the files and those that former steps make; any other is refused before the run."""
    needs_two = parse_script(script(transfer(0, 1)), "a")
    with pytest.raises(ScriptError, match="is layer 1, but so far there is only layer 0") as caught:
        check_needs(needs_two, layers=1)
    assert [problem.line for problem in caught.value.problems] == [3]
    check_needs(needs_two, layers=2)
    check_needs(parse_script(script(POISSON, transfer(0, 1)), "a"), layers=1)
    check_needs(parse_script(script('<filter name="Split in Connected Components"/>', transfer(0, 9)), "a"), layers=1)


def test_steps_that_need_rasters_are_refused() -> None:
    """MeshLab ends the process when a filter of rasters finds none; it is not begun."""
    data = one_filter("Parameterization + texturing from registered rasters")
    with pytest.raises(ScriptError, match="needs rasters"):
        check_needs(parse_script(data, "a"), layers=1)


def test_files_that_are_not_there_are_named_before_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A texture that a step reads has to be there, unless the step makes one by itself."""
    monkeypatch.chdir(tmp_path)
    name = '<Param type="RichOpenFile" name="textName" value="bark.png" exts_cardinality="0"/>'
    dummy = '<Param type="RichBool" name="use_dummy_texture" value="true"/>'

    def needs(*params: str) -> list[str]:
        return [problem.message for problem in unmet_needs(parse_script(one_filter("Set Texture", *params), "x"), layers=1)]

    assert needs(name) == [
        "is the file 'bark.png', which is not there; its path counts from the folder in which the command runs"
    ]
    assert needs(name, dummy) == []
    (tmp_path / "bark.png").write_bytes(b"")
    assert needs(name) == []
