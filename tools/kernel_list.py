"""The list of kernels that are compiled at installation: those that recipes, reports, and all filters as they are, do use."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from loaded_kernels import loaded_kernels

from pymeshfair.commands.run import sample_scan
from pymeshfair.declaration import Filter
from pymeshfair.errors import PymeshfairError
from pymeshfair.files.inputs import read_file
from pymeshfair.files.outputs import save_mesh
from pymeshfair.filters.compilation import kernel
from pymeshfair.filters.diffusion import implicit_fairing
from pymeshfair.filters.spectral import lowest_eigenpairs, spectral_problem
from pymeshfair.looking.comparison import compare, state_of
from pymeshfair.mesh_data import moved
from pymeshfair.meshset import MeshSet
from pymeshfair.recipe import Recipe, load_recipe, shipped_recipes
from pymeshfair.registry import custom_filters
from pymeshfair.report.comparison_page import comparison_page
from pymeshfair.running.job import Job
from pymeshfair.running.read import read_mesh, reported_values
from pymeshfair.running.session import Session
from pymeshfair.scripts.guards import Guards

LIST = kernel.LIST


def list_text() -> str:
    """Run everything in this process, and write down what was compiled or loaded for it."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
    from first_run_scans import scan_of, write_scans

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scans = write_scans(folder)
        for recipe in shipped_recipes():
            _run(load_recipe(recipe), scans[scan_of(recipe)], folder)
        _run(load_recipe("clean_range_map"), sample_scan(), folder)
        _compare(sample_scan(), scans[scan_of("denoise")])
        _read_polygons(folder)
        _solve_large_systems()
        for filter in custom_filters():
            for scan in scans.values():
                _apply(filter, scan)
    used: dict[str, dict[str, Any]] = {}
    for module, kernel_name, found in sorted(loaded_kernels("pymeshfair"), key=lambda named: named[:2]):
        if found.code:
            used.setdefault(module, {})[kernel_name] = sorted(found.code, key=repr)
    return json.dumps(used, indent=1) + "\n"


def _run(recipe: Recipe, scan: Path, folder: Path) -> None:
    """As the worker of ``pymeshfair run`` does it, with limits and a map of what has changed."""
    stage = folder / "stage" / f"{recipe.name}-{scan.stem}"
    (stage / "new").mkdir(parents=True, exist_ok=True)
    guards = Guards.parse({"max_displacement": "1000%", "keep_sharp": "0%"})
    job = Job(recipe, scan, folder / "out.ply", guards=guards, map=folder / "map.ply")
    print(recipe.name, scan.name, file=sys.stderr)
    try:
        Session(job, stage, lambda event: None).run()
    except PymeshfairError as error:  # what it used until then counts
        print(f"  {recipe.name} on {scan.name}: {error}", file=sys.stderr)


def _compare(before: Path, after: Path) -> None:
    """Two meshes, with a report."""
    first, second = (state_of(read_mesh(path)) for path in (before, after))
    comparison_page(compare(first, second, tolerance=first.mean_edge), title="", subtitle="", numbers={})
    reported_values(after, "get_surface_spectrum", {"modes": 0})


def _read_polygons(folder: Path) -> None:
    """Polygons of an OBJ and of a PLY file, whose points come in no order."""
    corners = [(x, y) for x in range(4) for y in range(4)]
    squares = [[a, a + 4, a + 5, a + 1] for a in range(11) if a % 4 < 3]
    lines = [f"v {x} {y} {(x * y) % 3}" for x, y in corners] + [f"f {' '.join(str(v + 1) for v in f)}" for f in squares]
    (folder / "squares.obj").write_text("\n".join(lines) + "\n")
    mesh = read_file(folder / "squares.obj").mesh
    for name in ("again.obj", "again.ply", "third.ply"):
        stage = folder / f"stage-{name}"
        stage.mkdir()
        saved = save_mesh(moved(mesh, mesh.vertices + 1.0), folder / name, stage, resolution=lambda: 1.0)
        saved.output.staged.rename(folder / name)
        mesh = read_file(folder / name).mesh


def _solve_large_systems() -> None:
    """Sheets larger than the scans: factors that threads share, and multigrid where there are too many rows for factors."""
    for side in (150, 240):
        x, y = (axis.ravel() for axis in np.indices((side, side)))
        first = np.flatnonzero((x < side - 1) & (y < side - 1))
        corners = np.column_stack([first, first + side, first + side + 1, first + 1])
        faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]]).astype(np.int32)
        vertices = np.column_stack([x, y, np.sin(x) * np.cos(y)]).astype(np.float64)
        implicit_fairing(vertices, faces, time_step=400.0)
        if side == 150:
            lowest_eigenpairs(spectral_problem(vertices, faces), 20)


def _apply(filter: Filter, scan: Path) -> None:
    """The filter with its defaults, for all vertices and for some, where the scan has what it needs."""
    can_select = "selected" in filter.defaults
    for some in (False, True) if can_select else (False,):
        meshes = MeshSet()
        meshes.load_new_mesh(str(scan))
        if some:
            meshes.compute_selection_by_condition_per_vertex(condselect="x > 1")
        try:
            meshes.apply_filter(filter.python_name, **({"selected": True} if some else {}))
            meshes.current_mesh()
        except Exception as error:  # not for such scans
            print(f"  {filter.python_name} on {scan.name}: {type(error).__name__}", file=sys.stderr)
