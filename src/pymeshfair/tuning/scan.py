"""The scan that is tuned on: the whole, or a part of a large one."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..recipe import Recipe
from ..registry import find_filter
from ..running.job import Job
from ..running.read import read_mesh
from ..running.supervise import run_job
from ..scripts.script import Script, Step

#: vertices of the largest scan that is taken whole at first, and of the part of a larger one
MOST_VERTICES, PART = 200_000, 50_000


@dataclass(frozen=True)
class Scan:
    """A scan to tune on."""

    path: Path
    vertices: int  # how many it has
    diagonal: float  # of its bounding box, in mesh units
    mean_edge: float  # in mesh units
    part: Path | None  # a file with a part of it; None if it is small enough to be taken whole
    warnings: tuple[str, ...]  # contents that reading could not keep


def prepared_scan(path: Path, folder: Path, *, most: int = MOST_VERTICES, part: int = PART) -> Scan:
    """Read a scan; of over `most` vertices a part of about `part` in the middle of the first view, written to the folder."""
    read = read_mesh(path)
    mesh = read.mesh
    cut = None
    if len(mesh.vertices) > most:
        cut = folder / "part.ply"
        # Of what is in the middle of the first view the foremost, so that the part is seen from outside.
        aside = np.linalg.norm(mesh.vertices[:, :2] - np.median(mesh.vertices[:, :2], axis=0), axis=1)
        central = np.flatnonzero(aside <= max(float(aside.min()), 0.01 * read.measured.diagonal))
        x, y, z = mesh.vertices[central[mesh.vertices[central, 2].argmax()]].tolist()
        cut_out(path, cut, (x, y, z), vertices=part)
    return Scan(path, len(mesh.vertices), read.measured.diagonal, read.measured.resolution(), cut, read.warnings)


def cut_out(
    path: Path, target: Path, centre: tuple[float, float, float], radius: float | None = None, *, vertices: int = PART
) -> None:
    """Write what lies within a ball with all attributes; without a radius such that about so many vertices are in it."""
    x, y, z = centre
    if radius is None:
        distances = np.linalg.norm(read_mesh(path).mesh.vertices - np.array(centre), axis=1)
        radius = float(np.partition(distances, min(vertices, len(distances) - 1))[min(vertices, len(distances) - 1)])
    outside = f"((x - ({x!r}))^2 + (y - ({y!r}))^2 + (z - ({z!r}))^2) > {radius * radius!r}"
    steps = (
        Step(find_filter("compute_selection_by_condition_per_vertex")).with_values({"condselect": outside}),
        Step(find_filter("meshing_remove_selected_vertices")),
    )
    run_job(Job(Recipe("part", Script(steps)), path, target, measures=False))
