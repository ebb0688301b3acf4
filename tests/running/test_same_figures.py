"""What a run removed, added and moved, in the five places that say it: table, document, limits, map and report."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path

import numpy as np
import pytest

from pymeshfair.files.inputs import read_file
from pymeshfair.running.intervention import ADDED, COLORS
from pymeshfair.scripts.write import format_script
from tests.commands.command_line import document, run_process
from tests.meshes import icosphere, noisy
from tests.running.runs import SMOOTH, Given, ply_bytes, recipe_of, xyz

REMOVE_PIECES: Given = ("meshing_remove_connected_component_by_face_number", {"mincomponentsize": 100})
CLOSE: Given = ("meshing_close_holes", {"maxholesize": 100})
#: name: the steps
RUNS: dict[str, tuple[Given, ...]] = {
    "removes a loose piece": (REMOVE_PIECES,),
    "removes a cap by its vertices": (
        ("compute_selection_by_condition_per_vertex", {"condselect": "z > 0.8"}),
        ("meshing_remove_selected_vertices", {}),
    ),
    "removes faces inside": (
        ("compute_selection_by_condition_per_face", {"condselect": "x0 < -0.9"}),
        ("meshing_remove_selected_faces", {}),
    ),
    "fills flat": (CLOSE,),
    "fills smoothly": (("meshing_close_holes_by_fairing", {}),),
    "moves by MeshLab's filter": (SMOOTH,),
    "moves by a plugin's filter": (("apply_coord_explicit_smoothing", {"iterations": 3}),),
    "cuts triangles otherwise": (("meshing_edge_flip_by_planar_optimization", {}),),
    "cuts triangles in four": (("meshing_surface_subdivision_midpoint", {"iterations": 1}),),
    "removes, fills and moves": (REMOVE_PIECES, CLOSE, SMOOTH),
}


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A noisy sphere with a hole, and a small one beside it."""
    vertices, faces = noisy(icosphere(3), 0.1)
    small, small_faces = icosphere(1, 0.1)
    path = tmp_path_factory.mktemp("scan") / "scan.ply"
    both = np.concatenate([vertices, small + np.array([0.0, 1.5, 0.0])])
    path.write_bytes(ply_bytes(xyz(both), np.concatenate([faces[6:], small_faces + len(vertices)]).tolist()))
    return path


@pytest.mark.parametrize("name", RUNS)
def test_five_places_say_the_same(name: str, scan: Path, tmp_path: Path) -> None:
    """Counts of vertices and faces, shares of area and distances are the same figures in all five."""
    (tmp_path / "recipe.mlx").write_text(format_script(recipe_of(*RUNS[name]).script), "utf-8")
    run = ("run", tmp_path / "recipe.mlx", scan, "--max-displacement", "1e-9", "--keep-broken", "-o")
    told = document(run_process(*run, tmp_path / "json.ply", "--json").stdout)
    places = ("--map", tmp_path / "map.ply", "--report", tmp_path / "page.html")
    table = run_process(*run, tmp_path / "clean.ply", *places)
    change = told["change"]
    removed, added, moved = change["removed"], change["added"], change["moved"]
    assert removed["faces"] or added["faces"] or moved["largest"] > 0.0

    # The record beside the output, and the document.
    record = json.loads((tmp_path / "clean.ply.provenance.json").read_text("utf-8"))
    assert record["measures"]["change"] == change

    # The map: faces by what became of them, and how far vertices have moved.
    states = read_file(tmp_path / "map.ply").mesh
    assert np.count_nonzero(states.face_scalars == 2.0) == added["faces"]
    of_old = (np.rint(255.0 * states.vertex_colors) != COLORS[ADDED]).any(axis=1)
    assert np.count_nonzero(~of_old) == added["vertices"]
    if moved["same"]:
        assert np.count_nonzero(states.vertex_scalars[of_old]) == moved["moved"]
    gone = tmp_path / "map.removed.ply"
    assert (len(read_file(gone).mesh.faces) if gone.exists() else 0) == removed["faces"]
    # The file of the map has single precision.
    assert states.vertex_scalars[moved["vertex"]] == pytest.approx(moved["largest"], rel=1e-6, abs=1e-12)

    # The limit: what was measured is the largest move.
    breaches = told["breaches"]
    assert [breach["amount"] for breach in breaches] == ([moved["largest"]] if moved["largest"] > 1e-9 else [])
    assert table.returncode == (1 if breaches else 0), table.stderr

    # The table: the sentence and the line below it.
    sentence = next(line for line in table.stdout.splitlines() if re.match("Removed|Added|Moved|Cut|Made", line))
    for part, verb in ((removed, "emoved"), (added, "dded")):
        if part["faces"] and not sentence.startswith("Cut"):
            counts = rf"{verb} .*?\({part['faces']:,} faces?\): {100.0 * part['share']:.3g} % of the area"
            assert re.search(counts, sentence), sentence
    if moved["largest"]:
        assert f"{moved['edges']:.2g} at most" in sentence
        assert f"at most {moved['largest']:.3g}" in table.stdout

    # The report: its numbers and its verdict.
    page = (tmp_path / "page.html").read_text("utf-8")
    numbers = json.loads(re.search(r'<script type="application/json" id="numbers">(.*?)</script>', page, re.DOTALL)[1])  # type: ignore[index]
    assert numbers["change"] == change
    assert sentence in html.unescape(page)
