"""The unit of a scan: typed, of its file or of the recipe; in limits, tables, documents and records."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.authoring import Recipe
from pymeshfair.commands.options import lengths_in_mesh_units
from pymeshfair.errors import ParameterError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.outputs import Writing
from pymeshfair.files.three_mf import write_3mf
from pymeshfair.looking.picture import COLORINGS, in_unit
from pymeshfair.mesh_data import MeshData
from pymeshfair.scripts.guards import Guards
from pymeshfair.scripts.read import parse_script
from pymeshfair.scripts.script import ScriptError
from pymeshfair.scripts.write import export_script, format_script
from tests.commands.command_line import document, invoke, run_process
from tests.meshes import icosphere, noisy
from tests.running.runs import SMOOTH, Given, ply_bytes, recipe_of, xyz

#: smoothing moves a vertex of the sphere by up to 0.03 of its units
WITHIN, BEYOND = 0.1, 0.001
#: makes a new layer
NEW_MESH: Given = ("generate_convex_hull", {})


@pytest.fixture
def sphere(tmp_path: Path) -> Callable[[str], Path]:
    """Writes a noisy sphere of radius 1 as a 3MF file in a unit, or as PLY without one."""
    vertices, faces = noisy(icosphere(3), 0.02)

    def written(unit: str) -> Path:
        path = tmp_path / f"sphere_{unit}.3mf" if unit else tmp_path / "sphere.ply"
        if not unit:
            path.write_bytes(ply_bytes(xyz(vertices), faces.tolist()))
            return path
        with path.open("xb") as file:
            write_3mf(MeshData(vertices=vertices, faces=faces, unit=unit), file, Writing(lambda: 0.0, {}, "", []))
        return path

    return written


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    """A recipe that smooths."""
    path = tmp_path / "smooth.mlx"
    path.write_text(format_script(recipe_of(SMOOTH).script))
    return path


@pytest.mark.parametrize(
    ("of_file", "typed", "limit", "unit", "is_kept"),
    [
        ("mm", "", f"{WITHIN}mm", "mm", True),
        ("mm", "", f"{BEYOND}mm", "mm", False),
        ("m", "", f"{WITHIN}mm", "m", False),
        ("m", "mm", f"{WITHIN}mm", "mm", True),
        ("", "cm", f"{10 * WITHIN}mm", "cm", True),
        ("ft", "", f"{WITHIN}ft", "ft", True),
        ("m", "ft", f"{WITHIN}ft", "ft", True),
    ],
)
def test_a_limit_is_in_the_unit_of_the_file_or_the_one_typed(
    of_file: str,
    typed: str,
    limit: str,
    unit: str,
    is_kept: bool,
    sphere: Callable[[str], Path],
    recipe: Path,
    tmp_path: Path,
) -> None:
    """A 3MF file says its unit, what is typed goes over it, and tables, document, record and message name the one that holds."""
    options = ("--unit", typed) if typed else ()
    done = invoke("run", recipe, sphere(of_file), "-o", tmp_path / "out.ply", "--max-displacement", limit, "--json", *options)
    assert done.exit_code == (0 if is_kept else 1), done.stderr
    if not is_kept:
        said = f"{BEYOND} mm" if unit == "mm" else f"{limit} = 0.0001 m"
        assert f" {unit}, which is more than {said}" in done.stderr
        return
    assert document(done.stdout)["unit"] == unit
    warning = f"warning: the file of the scan says {of_file}, and --unit (unit= in Python) says {typed}"
    warning += f": the scan's numbers mean {typed}\n"
    assert (warning in done.stderr) is bool(of_file and typed)
    record = json.loads((tmp_path / "out.ply.provenance.json").read_bytes())
    assert record["measures"]["unit"] == unit
    assert record["input"].get("unit") == (of_file or None)
    assert record["guards"]["limits"] == {"max_displacement": repr(WITHIN)}
    assert run_process("verify", tmp_path / "out.ply").returncode == 0


def test_a_limit_with_a_unit_is_refused_where_nothing_says_that_of_the_scan(
    sphere: Callable[[str], Path], recipe: Path, tmp_path: Path
) -> None:
    """A PLY file has none: both readings are told, nothing is done; of a file in feet there is one reading."""
    done = invoke("run", recipe, sphere(""), "-o", tmp_path / "out.ply", "--max-displacement", "0.05mm")
    assert done.exit_code == 2, done.stderr
    assert "0.05 on a scan in mm and 5e-05 on a scan in m" in done.stderr
    done = invoke("run", recipe, sphere("ft"), "-o", tmp_path / "out.ply", "--max-displacement", "0.05mm")
    assert done.exit_code == 1, done.stderr
    assert "which is more than 0.05mm = 0.000164042 ft" in done.stderr
    assert not (tmp_path / "out.ply").exists()
    done = invoke("batch", recipe, sphere("mm"), tmp_path / "sphere.ply", "-o", tmp_path / "many", "--max-displacement", "0.05mm")
    assert done.exit_code == 2, done.stderr
    assert "5e-05 on a scan in m" in done.stderr
    assert not list((tmp_path / "many").glob("*.3mf"))


def test_the_head_of_a_recipe_says_the_unit_of_its_scans(sphere: Callable[[str], Path], tmp_path: Path) -> None:
    """It holds where neither the command nor the file says one; where the file says another one, that is warned of."""
    script = replace(recipe_of(SMOOTH).script, unit="mm", guards=Guards.parse({"max_displacement": f"{WITHIN}mm"}))
    text = format_script(script)
    assert f'<FilterScript unit="mm" maxDisplacement="{WITHIN}mm">' in text
    assert parse_script(text.encode(), "again.mlx").unit == "mm"
    path = tmp_path / "head.mlx"
    path.write_text(text)
    without = tmp_path / "without.mlx"
    without.write_text(text.replace(' unit="mm"', ""))
    assert (Recipe.load(without).script.unit, Recipe.load(path).script.unit) == ("", "mm")
    assert "unit=" not in export_script(script)[0]
    done = invoke("run", path, sphere(""), "-o", tmp_path / "out.ply", "--json")
    assert done.exit_code == 0, done.stderr
    assert document(done.stdout)["unit"] == "mm"
    assert "the recipe is for scans" not in done.stderr
    other = invoke("run", path, sphere("m"), "-o", tmp_path / "other.ply")
    assert other.exit_code == 1
    assert "the recipe is for scans in mm, and this scan is in m" in other.stderr
    options: list[str | Path] = ["-o", tmp_path / "typed.3mf", "--max-displacement", "1", "--unit"]
    typed = invoke("run", path, sphere("cm"), *options, "mm")
    assert typed.exit_code == 0, typed.stderr
    assert "the file of the scan says cm, and --unit (unit= in Python) says mm: the scan's numbers mean mm" in typed.stderr
    again = invoke("run", path, tmp_path / "sphere_cm.3mf", *options, "in")
    assert (again.exit_code, "was made by another recipe, or with other settings" in again.stderr) == (1, True)
    with pytest.raises(ScriptError, match="'inch' is no unit of scans; the units are mm, cm, m, in, ft, um"):
        parse_script(text.replace('unit="mm"', 'unit="inch"').encode(), "wrong.mlx")


@pytest.mark.parametrize(
    ("says", "output", "step"), [("--unit", "out.3mf", NEW_MESH), ("--unit", "out.glb", SMOOTH), ("recipe", "out.3mf", SMOOTH)]
)
def test_the_file_gets_the_unit_of_the_scan(
    says: str, output: str, step: Given, sphere: Callable[[str], Path], tmp_path: Path
) -> None:
    """A unit that was typed or is in the recipe's head is in the output, of a new mesh too, and the run can be repeated."""
    path = tmp_path / "step.mlx"
    path.write_text(format_script(replace(recipe_of(step).script, unit="cm" if says == "recipe" else "")))
    options = ("--unit", "cm") if says == "--unit" else ()
    done = invoke("run", path, sphere(""), "-o", tmp_path / output, *options)
    assert done.exit_code == 0, done.stderr
    size = np.ptp(read_file(sphere("")).mesh.vertices, axis=0).max() / (100 if output == "out.glb" else 1)
    written = read_file(tmp_path / output).mesh
    assert written.unit == ("m" if output == "out.glb" else "cm")
    assert np.ptp(written.vertices, axis=0).max() == pytest.approx(size, rel=0.2)
    assert invoke("verify", tmp_path / output).exit_code == 0


def test_layers_of_different_units_are_told_apart(sphere: Callable[[str], Path], recipe: Path, tmp_path: Path) -> None:
    """A warning names each file that has a unit; layers of one unit, and those without, get none."""
    run = ("run", recipe, sphere("m"), "--with", sphere("cm"), "--with", sphere(""), "-o", tmp_path / "out.3mf", "--overwrite")
    told, same = invoke(*run), invoke(*run, "--unit", "cm")
    words = "sphere_m.3mf is in m, sphere_cm.3mf is in cm: coordinates are taken as the files have them"
    assert f"warning: {words}\n" in told.stderr
    assert (told.exit_code, same.exit_code) == (0, 0)
    assert "coordinates are taken" not in same.stderr


@pytest.mark.parametrize("command", ["compare", "picture"])
def test_a_typed_unit_is_that_of_the_first_file(command: str, sphere: Callable[[str], Path], tmp_path: Path) -> None:
    """A first file without a unit is in the typed one, so that a second file in another unit gets a warning."""
    out = ("--no-self-intersections",) if command == "compare" else ("-o", tmp_path / "both.png", "--overwrite")
    other, same = (invoke(command, sphere(""), second, "--unit", "mm", *out) for second in (sphere("m"), sphere("mm")))
    assert (other.exit_code, same.exit_code) == (0, 0)
    words = {"compare": "BEFORE is in mm and AFTER in m: ", "picture": "the meshes are in mm and m: "}[command]
    assert (words in other.stderr, same.stderr) == (True, "")


def test_comparing_with_a_file_without_a_unit_says_what_is_assumed(sphere: Callable[[str], Path]) -> None:
    """Either file may say no unit: a warning says that the other's is assumed; none if both say none, or with --unit."""
    metres, silent = sphere("m"), sphere("")
    told = [
        " ".join(invoke("compare", *files, "--no-self-intersections").stderr.split())
        for files in ((metres, silent), (silent, metres), (silent, silent), (metres, silent, "--unit", "m"))
    ]
    words = "is in m, and {} has no unit: the same one is assumed"
    assert told == [f"warning: BEFORE {words.format('AFTER')}", f"warning: AFTER {words.format('BEFORE')}", "", ""]


def test_a_unit_that_only_the_other_file_says_is_that_of_lengths(sphere: Callable[[str], Path], tmp_path: Path) -> None:
    """A tolerance and limits in millimetres hold for a first file without a unit beside one in centimetres, which is said."""
    silent, other = sphere(""), sphere("cm")
    compared = invoke("compare", silent, other, "--no-self-intersections", "--tolerance", "1mm")
    drawn = invoke("picture", silent, other, "-o", tmp_path / "a.png", "--color", "distance", "--limits=-1mm,1mm")
    for told, first, second in ((compared, "BEFORE", "AFTER"), (drawn, silent.absolute(), other.absolute())):
        assert told.exit_code == 0, told.stderr
        words = f"warning: {second} is in cm, and {first} has no unit: the same one is assumed"
        assert " ".join(told.stderr.split()) == words
    assert "lie within 0.1 cm" in compared.stdout


@pytest.mark.slow
def test_tables_and_the_page_say_the_unit(sphere: Callable[[str], Path], recipe: Path, tmp_path: Path) -> None:
    """Measures, distances, lines below them, charts and the scale bar are in the unit of the file, none in mesh units."""
    page = tmp_path / "page.html"
    done = run_process("run", recipe, sphere("mm"), "-o", tmp_path / "out.ply", "--report", page)
    assert done.returncode == 0, done.stderr
    compared = invoke("compare", sphere("cm"), sphere("in"), "--no-self-intersections", "--tolerance", "1mm")
    assert compared.exit_code == 0, compared.stderr
    assert "BEFORE is in cm and AFTER in in: coordinates are compared as the files have them" in compared.stderr
    told = invoke("info", tmp_path / "sphere_mm.3mf").stdout
    for text, unit in ((done.stdout, "mm"), (compared.stdout, "cm"), (told, "mm"), (page.read_text("utf-8"), "mm")):
        for words in (f"area ({unit}²)", f"volume ({unit}³)", f"mean edge ({unit})"):
            assert words in text
        assert "mesh unit" not in text
    assert "moved: mean 0.0" in done.stdout
    assert " mm, 99 % below 0.0" in done.stdout
    assert "lie within 0.1 cm" in compared.stdout
    assert in_unit(COLORINGS["distance"].label, "mm") == "distance from the first surface (mm, outwards above 0)"
    assert in_unit(COLORINGS["gaussian"].label, "mm") == "Gaussian curvature (1 / squared mm)"


def test_a_picture_takes_limits_in_the_unit_of_the_first_file(sphere: Callable[[str], Path], tmp_path: Path) -> None:
    """Limits in millimetres give the bytes of those in the inches of the file, and another scale bar than without a unit."""
    source, other = sphere("in"), sphere("cm")
    drawn: list[bytes] = []
    for limits in ("-2.54mm,2.54mm", "-0.1in,0.1in", "-1mm,1mm"):
        out = tmp_path / f"{len(drawn)}.png"
        options = ("--color", "distance", f"--limits={limits}", "--size", "128x128", "--title", "a", "--title", "b")
        done = invoke("picture", source, other, "-o", out, *options)
        assert done.exit_code == 0, done.stderr
        drawn.append(out.read_bytes())
    assert drawn[0] == drawn[1] != drawn[2]


@pytest.mark.slow
def test_each_scan_of_a_batch_has_its_own_unit(sphere: Callable[[str], Path], recipe: Path, tmp_path: Path) -> None:
    """A limit in millimetres is kept by the scan in millimetres and not by that in metres; tables say both, a resumed one too."""
    scans = [sphere("mm"), sphere("m")]
    options = ("-o", tmp_path / "many", "--max-displacement", f"{WITHIN}mm", "--resume", "--jobs", "1")
    for _ in range(2):
        done = run_process("batch", recipe, *scans, *options)
        assert done.returncode == 1, done.stderr
        with (tmp_path / "many" / "batch.csv").open(encoding="utf-8") as file:
            rows = {Path(row["input"]).name: row for row in csv.DictReader(file)}
        assert (rows["sphere_mm.3mf"]["status"], rows["sphere_mm.3mf"]["unit"]) == ("done", "mm")
        assert rows["sphere_m.3mf"]["status"] == "failed"
    assert "1 of them before" in done.stdout
    again = run_process("batch", recipe, scans[0], *options[:2], "--max-displacement", f"{WITHIN}mm", "--unit", "cm", "--resume")
    assert "of them before" not in again.stdout


def test_a_picture_of_meshes_in_different_units_says_so(sphere: Callable[[str], Path], tmp_path: Path) -> None:
    """Inches and millimetres are drawn as the files have them, with a warning; two meshes in inches have none."""
    inches, warned = sphere("in"), []
    for number, other in enumerate((sphere("mm"), inches)):
        options = ("-o", tmp_path / f"{number}.png", "--color", "distance", "--size", "128x128")
        warned.append(" ".join(invoke("picture", inches, other, *options).stderr.split()))
    assert "the meshes are in in and mm: they are drawn with the coordinates of their files" in warned[0]
    assert "the meshes are in" not in warned[1]


@pytest.mark.parametrize("command", ["compare", "picture"])
def test_the_typed_unit_is_that_of_the_first_mesh(sphere: Callable[[str], Path], tmp_path: Path, command: str) -> None:
    """With --unit in for a file in millimetres, a second file in inches has the same unit, and one in millimetres has not."""
    first, inches, warned = sphere("mm"), sphere("in"), []
    for number, other in enumerate((inches, first)):
        where = ("-o", tmp_path / f"{number}.png", "--size", "128x128") if command == "picture" else ("--no-self-intersections",)
        done = invoke(command, first, other, "--unit", "in", *where)
        assert done.exit_code == 0, done.stderr
        warned.append("coordinates are compared as" in done.stderr or "the meshes are in in and mm" in done.stderr)
    assert warned == [False, True]


@pytest.mark.parametrize(("text", "measure"), [("1%", "diagonal"), ("0.5edge", "mean edge")])
def test_a_relative_tolerance_on_a_mesh_without_size_names_the_cause(text: str, measure: str) -> None:
    """A share of a diagonal or of a mean edge of 0 is refused as such, and not as a tolerance that is not above 0."""
    with pytest.raises(ParameterError, match=f"^{text} is 0, as the {measure} of the first mesh is 0: give the length in mesh"):
        lengths_in_mesh_units(text, None, None, 0.0, 0.0)
