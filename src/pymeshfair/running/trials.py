"""Tries recipes on a scan: measures the prediction error at held-out vertices, and the lost relief (surface detail)."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from ..declaration import FilterClass, Floats, Ints, MeshElement
from ..errors import PymeshfairError
from ..files.inputs import read_file
from ..filters.denoising import Scan
from ..filters.diffusion import relief_lost
from ..filters.evidence import held_out_vertices, initial_positions, scores_of, tuned
from ..mesh_data import MeshData
from ..recipe import Recipe
from ..scripts.script import Script, Step
from .job import Job
from .suitability import Trial
from .supervise import run_job


def moving_script(recipe: Recipe, chosen: Step | None = None) -> Script | None:
    """The recipe's smoothing steps that keep the number of faces, or None; `chosen` replaces the step with the same filter."""
    steps = [
        step
        for step in recipe.script.steps
        if step.filter.classes & FilterClass.SMOOTHING and not step.filter.changes & MeshElement.FACENUMBER
    ]
    if chosen is not None:
        steps = [chosen if step.filter is chosen.filter else step for step in steps]
    return Script(tuple(steps)) if steps else None


def trials(
    vertices: Floats, faces: Ints, scripts: Mapping[str, Script], *, clean: bool, timeout: float | None = None
) -> dict[str, Trial]:
    """Try scripts on a sample of a scan.

    On a scan with noise, sets of vertices are held out, one after the other. No two vertices of a set are neighbours, and each
    starts at the position that its neighbours predict. The error of a script is the root mean square distance of its result
    from the scan along the normals there, see `scores_of`. On a `clean` scan none is held out: all `Scan.scored` ones count.

    Returns the trials by name, without scripts that failed or took more than `timeout` seconds; empty if no vertex is scored.
    """
    scan = Scan.of(vertices, faces)
    scored = np.flatnonzero(scan.scored).astype(np.int32)
    sets = [scored] if clean else held_out_vertices(scan.points, scan.faces, scored=scan.scored, sets=tuned.SETS)
    if not any(map(len, sets)):
        return {}
    # Automatic sizes are chosen on the scan itself, before vertices are held out, and then kept.
    results, explicit = dict[str, Floats](), dict[str, Script]()
    for name, points, script in _results(scan.points, scan.faces, scripts, timeout):
        results[name], explicit[name] = points, script
    start = None if clean else initial_positions(scan.points, scan.faces, normals=scan.normals, scored=scan.scored)
    heights = {name: list[Floats]() for name in ("", *results)}
    for held in sets:
        points, tried = scan.points, results
        if start is not None:
            points = start(held)
            tried = {name: result for name, result, _ in _results(points, scan.faces, explicit, timeout)}
            explicit = {name: explicit[name] for name in tried}
        for name, result in ({"": points} | tried).items():
            heights[name].append(np.einsum("ij,ij->i", (scan.points - result)[held], scan.normals[held]))
    scores = scores_of(np.stack([np.concatenate(heights[name]) for name in ("", *explicit)]))
    (before, *errors), (_, *ties) = scores.errors.tolist(), scores.within(0.0 if clean else tuned.STAYS).tolist()
    shows_relief = clean or not scan.has_impulses
    trial_of = dict[str, Trial]()
    for name, error, tied in zip(explicit, errors, ties, strict=True):
        loss = shows_relief and relief_lost(scan.points, results[name], scan.faces, noise=0.0 if clean else scan.noise.deviation)
        share, shortest = loss or (None, 0.0)
        trial_of[name] = Trial(error, before, share, shortest, tied)
    return trial_of


def _results(
    points: Floats, faces: Ints, scripts: Mapping[str, Script], timeout: float | None
) -> Iterator[tuple[str, Floats, Script]]:
    """Yield the name and the result of each script that does not fail, and the script with its automatic sizes filled in."""
    from ..files.ply_write import write_ply

    with tempfile.TemporaryDirectory(prefix="pymeshfair-trials-") as folder:
        source, target = Path(folder) / "scan.ply", Path(folder) / "result.ply"
        with source.open("xb") as file:
            write_ply(MeshData(vertices=points, faces=faces), file)
        for name, script in scripts.items():
            job = Job(Recipe(name, script), source, target, measures=False, overwrite=True, timeout=timeout)
            try:
                reports = run_job(job).steps
            except PymeshfairError:
                continue
            steps = [
                step.with_values({"detail_size": str(report.values["chosen"])})
                if report.parameters.get("detail_size") == "auto" and report.values.get("chosen")
                else step
                for step, report in zip(script.steps, reports, strict=True)
            ]
            yield name, read_file(target).mesh.vertices, script.with_steps(steps)
