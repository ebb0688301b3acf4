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
from ..filters.evidence import held_out_vertices, initial_positions, random_signs, scores_of
from ..filters.evidence.tuned import STAYS
from ..filters.topology import edges
from ..mesh_data import MeshData
from ..recipe import Recipe
from ..scripts.script import Script, Step
from .job import Job
from .suitability import Trial
from .supervise import run_job

#: sets of vertices, of which the largest is held out
_MASKS = 4
#: the noise is added once more, times this: little enough for the filters, and far more than rounding
_LITTLE = 0.1


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

    On a scan with noise some vertices, no two of them neighbours, are put where the others say, and the distance of each
    result from their real places is measured; what is done to the surface counts, not what slides along it. Of those that this
    cannot tell from the best the risk is estimated.

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
    masks = held_out_vertices(scan.points, scan.faces, scored=scan.scored, masks=_MASKS)
    held = max(masks, key=len, default=np.empty(0, np.int32))
    if not len(held):
        return {}
    start = scan.points if clean else initial_positions(scan.points, scan.faces, normals=scan.normals, scored=scan.scored)(held)
    results = dict(results_of(start, scan.faces, scripts, timeout))

    def heights(points: Floats, which: Ints) -> Floats:
        return np.asarray(np.einsum("ij,ij->i", scan.points[which] - points[which], scan.normals[which]))

    which = np.flatnonzero(scan.scored).astype(np.int32) if clean else held
    scores = scores_of(np.stack([heights(points, which) for points in (start, *results.values())]))
    ties = [name for name, tied in zip(results, scores.within(STAYS)[1:], strict=True) if tied]
    risks = {} if clean or len(ties) < 2 else risks_of(scan, {name: scripts[name] for name in ties}, timeout)
    level = 0.0 if clean else scan.noise.deviation
    tells = clean or not scan.has_impulses
    lost = [(tells and relief_lost(scan.points, points, scan.faces, noise=level)) or (None, 0.0) for points in results.values()]
    return {
        name: Trial(float(error), float(scores.errors[0]), share, shortest, risks.get(name))
        for name, error, (share, shortest) in zip(results, scores.errors[1:], lost, strict=True)
    }


def risks_of(scan: Scan, scripts: Mapping[str, Script], timeout: float | None = None) -> dict[str, float]:
    """The expected distance of results from the truth, by filtering the scan and the scan with a little more noise.

    Held-out vertices are few, and their noise is in all errors. With noise of the deviation s, h = n . (f(y) - y), signs b and
    g = n . (f(y + e s b) - f(y)) / e, the squared error is the mean of h^2 + 2 s b g - s^2 over all vertices [stein1981,
    ramani2008].

    Args:
        scan: with noise of its own at every vertex.
        scripts: those to compare, by name.
        timeout: seconds for each.

    Returns:
        By name the root mean square along the normals, in mean edges, without those that fail; none where it is lost in noise.
    """
    level, scored = scan.noise.deviation, scan.scored
    noise = level * random_signs(scan.points, edges(scan.faces), scan.seed)
    first = dict(results_of(scan.points, scan.faces, scripts, timeout))
    second = dict(results_of(scan.points + _LITTLE * noise[:, None] * scan.normals, scan.faces, scripts, timeout))

    def risk(name: str) -> float:
        moved, passed = (
            np.einsum("ij,ij->i", points, scan.normals)[scored]
            for points in (first[name] - scan.points, (second[name] - first[name]) / _LITTLE)
        )
        return float(np.mean(moved**2 + 2.0 * noise[scored] * passed)) - level**2

    squares = {name: risk(name) for name in first if name in second}
    if min(squares.values(), default=0.0) < 0.0:  # the noise was estimated too high
        return {}
    return {name: float(np.sqrt(square)) for name, square in squares.items()}


def results_of(
    points: Floats, faces: Ints, scripts: Mapping[str, Script], timeout: float | None = None
) -> Iterator[tuple[str, Floats]]:
    """The vertices that each script makes, by its name; without those that fail."""
    from ..files.ply_write import write_ply

    with tempfile.TemporaryDirectory(prefix="pymeshfair-trials-") as folder:
        source, target = Path(folder) / "scan.ply", Path(folder) / "result.ply"
        with source.open("xb") as file:
            write_ply(MeshData(vertices=points, faces=faces), file)
        for name, script in scripts.items():
            job = Job(Recipe(name, script), source, target, measures=False, overwrite=True, timeout=timeout)
            try:
                run_job(job)
            except PymeshfairError:
                continue
            yield name, read_file(target).mesh.vertices
