"""What moved, was added and was removed: ten runs whose table, document, provenance, limits, map and report say the same."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pymeshfair.files.inputs import read_file
from pymeshfair.looking.words import change_lines
from pymeshfair.mesh_data import MeshData
from pymeshfair.registry import find_filter
from pymeshfair.running.shape_change import ADDED, MOVED
from pymeshfair.scripts.script import Script, Step
from pymeshfair.scripts.write import format_script
from tests.commands.command_line import document, run_process
from tests.meshes import area, icosphere, noisy, tetrahedron
from tests.running.runs import ply_bytes, xyz

BELOW = ("compute_selection_by_condition_per_face", {"condselect": "(z0 < -0.6)"})
SMOOTH = ("apply_coord_taubin_smoothing", {"stepsmoothnum": 3})
PIECES = ("meshing_remove_connected_component_by_face_number", {"mincomponentsize": 25})
#: removing, filling, moving, cutting
RUNS: dict[str, list[tuple[str, dict[str, Any]]]] = {
    "move": [SMOOTH],
    "move by our own": [("apply_coord_implicit_fairing", {})],
    "remove a piece": [PIECES],
    "cut a part away": [BELOW, ("meshing_remove_selected_faces", {}), ("meshing_remove_unreferenced_vertices", {})],
    "fill": [("meshing_close_holes", {})],
    "fill by our own": [("meshing_close_holes_by_fairing", {})],
    "remove and move": [PIECES, SMOOTH],
    "fill and move": [("meshing_close_holes", {}), SMOOTH],
    "cut, remove, fill and move": [
        BELOW,
        ("meshing_remove_selected_faces", {}),
        PIECES,
        ("meshing_close_holes_by_fairing", {}),
        SMOOTH,
    ],
    "nothing": [("meshing_remove_duplicate_vertices", {})],
}


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A noisy sphere with a hole, and a small piece beside it."""
    vertices, faces = noisy(icosphere(3), 0.02)
    piece, its_faces = tetrahedron()
    holed = faces[(vertices[faces].mean(axis=1) @ [0.0, 0.6, 0.8]) < 0.97]
    path = tmp_path_factory.mktemp("scan") / "scan.ply"
    every = np.concatenate([vertices, 0.2 * piece + [2.0, 0, 0]])
    path.write_bytes(ply_bytes(xyz(every), [*holed.tolist(), *(its_faces + len(vertices)).tolist()]))
    return path


def part(mesh: MeshData, chosen: Any) -> float:
    """The area of some faces."""
    return area(mesh.vertices, mesh.faces[chosen])


#: tried at every change; the others before a release
QUICK = ("cut, remove, fill and move",)


@pytest.mark.parametrize("name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in RUNS])
def test_all_say_the_same(name: str, scan: Path, tmp_path: Path) -> None:
    """Each figure of the document is that of the table, the provenance, the map, the broken limit and the report."""
    steps = [(find_filter(filter), values) for filter, values in RUNS[name]]
    recipe, out, map_file, page = (tmp_path / n for n in ("steps.mlx", "out.ply", "map.ply", "page.html"))
    recipe.write_text(format_script(Script(tuple(Step(f, f.check(values)) for f, values in steps))))
    kept = ("--max-displacement", "1e-9", "--keep-broken", "--overwrite")
    ran = run_process("run", recipe, scan, "-o", out, *kept, "--map", map_file, "--report", page, "--json")
    told = document(ran.stdout)
    change, breaches = told["change"], told["breaches"]
    shown = run_process("run", recipe, scan, "-o", out, *kept)
    for line in change_lines(change):
        assert line in shown.stdout
        assert line in page.read_text("utf-8")
    assert json.loads((tmp_path / "out.ply.provenance.json").read_bytes())["measures"]["change"] == change
    data = page.read_text("utf-8").split('id="numbers">')[1].split("</script>")[0]
    assert json.loads(data)["change"] == change

    moved, mapped, read = change["moved"], read_file(map_file).mesh, read_file(scan).mesh
    assert moved["same"]
    states = mapped.face_scalars
    assert change["added"]["faces"] == (states == ADDED).sum()
    assert change["added"]["area"] == pytest.approx(part(mapped, states == ADDED), rel=1e-6)
    removed_file = tmp_path / "map.removed.ply"
    gone = read_file(removed_file).mesh if removed_file.exists() else None
    assert change["removed"]["faces"] == (0 if gone is None else len(gone.faces))
    assert change["removed"]["area"] == pytest.approx(0.0 if gone is None else part(gone, slice(None)), rel=1e-6)
    assert change["removed"]["share"] == pytest.approx(change["removed"]["area"] / area(read.vertices, read.faces))
    assert len(read.faces) - change["removed"]["faces"] + change["added"]["faces"] == told["after"]["faces"]
    touched = np.unique(mapped.faces[states != ADDED])
    assert moved["largest"] == pytest.approx(mapped.vertex_scalars[touched].max(), rel=1e-6)
    if moved["largest"] == 0.0:
        assert breaches == []
        assert (states != MOVED).all()
        return
    (breach,) = breaches
    assert (breach["amount"], breach["vertex"], breach["place"]) == (moved["largest"], moved["vertex"], moved["place"])
    assert mapped.vertex_scalars[moved["vertex"]] == pytest.approx(moved["largest"], rel=1e-6)
