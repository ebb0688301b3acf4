"""Trials of recipes on a scan: the error at held-out vertices, and the relief that is lost."""

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
    """The steps of a recipe that smooth, without those that delete; None if there are none.

    Args:
        recipe: the recipe.
        chosen: the step of normal filtering with the values that were found for the scan, which need not be found again.
    """
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

    On a scan with noise sets of vertices, no two of a set neighbours, are put where the others say, and the distance of each
    result from their real places is measured; what is done to the surface counts, not what slides along it.

    Args:
        vertices: (n, 3) coordinates.
        faces: (m, 3) triangles.
        scripts: those to try, by name.
        clean: whether the scan has no noise.
        timeout: seconds for each.

    Returns:
        By name; a script that fails is left out, and all are where no vertex can be held out.
    """
    scan = Scan.of(vertices, faces)
    scored = np.flatnonzero(scan.scored).astype(np.int32)
    sets = [scored] if clean else held_out_vertices(scan.points, scan.faces, scored=scan.scored, masks=tuned.MASKS)
    if not any(map(len, sets)):
        return {}
    # What is automatic is chosen on the scan as it is.
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
    level = 0.0 if clean else scan.noise.deviation
    tells = clean or not scan.has_impulses
    found = dict[str, Trial]()
    for name, error, tied in zip(explicit, errors, ties, strict=True):
        lost = tells and relief_lost(scan.points, results[name], scan.faces, noise=level)
        share, shortest = lost or (None, 0.0)
        found[name] = Trial(error, before, share, shortest, tied)
    return found


def _results(
    points: Floats, faces: Ints, scripts: Mapping[str, Script], timeout: float | None
) -> Iterator[tuple[str, Floats, Script]]:
    """The name, the vertices and the script with the sizes that it found, of each that does not fail."""
    from ..files.ply_write import write_ply

    with tempfile.TemporaryDirectory(prefix="pymeshfair-trials-") as folder:
        source, target = Path(folder) / "scan.ply", Path(folder) / "result.ply"
        with source.open("xb") as file:
            write_ply(MeshData(vertices=points, faces=faces), file)
        for name, script in scripts.items():
            job = Job(Recipe(name, script), source, target, measures=False, overwrite=True, timeout=timeout)
            try:
                steps = run_job(job).steps
            except PymeshfairError:
                continue
            found = [
                step.with_values({"detail_size": str(report.values["chosen"])})
                if report.parameters.get("detail_size") == "auto" and report.values["chosen"]
                else step
                for step, report in zip(script.steps, steps, strict=True)
            ]
            yield name, read_file(target).mesh.vertices, script.with_steps(found)
