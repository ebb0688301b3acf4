"""What is checked before a run by tiles, and its failures in the words of a run."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

from ..errors import ParameterError
from ..files.errors import ContentsError, InputError, OutputError
from ..files.formats import extension
from ..files.inputs import check_input, check_magic
from ..files.outputs import check_output
from ..running.job import Job
from .memory import cloud_room, surface_room
from .mesh import MeshFile
from .moves import NORMALS
from .plan import LOOP, STRAYS, Move, Selection
from .ply_slices import PlySlices
from .sources import CLOUD_FORMATS, open_cloud
from .work_folder import work_path
from .workers import FullDiskError


def formats_of(plan: list[Selection] | list[Move]) -> tuple[str, ...]:
    """The extensions of what a plan reads and writes."""
    return CLOUD_FORMATS if isinstance(plan[0], Selection) else ("ply",)


def check(job: Job, plan: list[Selection] | list[Move]) -> None:
    """Refuse what cannot be done by tiles, before anything is done.

    Raises:
        ParameterError: something is asked for that needs the whole mesh.
        InputError, OutputError: a file cannot be read or written by slices.
    """
    if not plan:
        raise ParameterError("the recipe has no steps, so there is nothing to do by tiles")
    formats = formats_of(plan)
    if job.all_guards or job.map is not None or job.others:
        raise ParameterError(
            "limits of the result, an intervention map and further layers need the whole mesh at once; leave them out, or --tiles"
        )
    check_input(job.input, formats)
    try:
        check_magic(job.input)
        if isinstance(plan[0], Selection):
            open_cloud(job.input)
        else:
            MeshFile(PlySlices(job.input)).check()
    except ContentsError as error:
        raise InputError(job.input, str(error)) from error
    check_output(job.output, job.made_from, overwrite=job.overwrite, formats=formats)
    kinds = [extension(path).replace("laz", "las") for path in (job.input, job.output)]
    if kinds[0] != kinds[1]:
        raise OutputError(job.output, f"by tiles a .{extension(job.input)} file becomes a file of the same kind")
    _check_room(job, plan)


def _check_room(job: Job, plan: list[Selection] | list[Move]) -> None:
    folder = job.output.absolute().parent
    if isinstance(plan[0], Selection):
        cloud = open_cloud(job.input)
        neighbors = {LOOP: 0, STRAYS: 0}
        for selection in plan:
            assert isinstance(selection, Selection)
            neighbors[selection.filter] = max(neighbors[selection.filter], selection.neighbors)
        needed = cloud_room(len(cloud), cloud.row, neighbors[LOOP], neighbors[STRAYS])
    else:
        mesh = MeshFile(PlySlices(job.input))
        vertices, faces = len(mesh.file), mesh.file.tables["face"].element.count
        row = mesh.file.vertices.dtype.itemsize + 24 + faces * mesh.file.tables["face"].dtype.itemsize // vertices
        needed = surface_room(vertices, faces, row, rounds=any(step.filter == NORMALS for step in plan))
    former = sum(file.stat().st_size for file in work_path(job.output).glob("**/*") if file.is_file())
    free = shutil.disk_usage(folder).free + former
    if needed > free:
        raise OutputError(
            job.output,
            f"the work needs {needed / 1e9:.3g} GB on the disk of {folder}, of which {free / 1e9:.3g} GB are free: free some, or "
            "name an output on another disk",
        )


@contextmanager
def told_as_run(job: Job) -> Iterator[None]:
    """Failures of tasks in the words of a run."""
    try:
        yield
    except ContentsError as error:
        raise InputError(job.input, str(error)) from error
    except (FullDiskError, OSError) as error:
        words = (error.strerror if isinstance(error, OSError) else None) or str(error)
        raise OutputError(job.output, f"there is no room for the files of the work: {words}".lower()) from error
