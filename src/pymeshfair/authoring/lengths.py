"""The relative lengths of a script in mesh units, each on the mesh that its step meets."""

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from .. import recipe as named
from ..declaration import Length
from ..running.job import Job
from ..running.supervise import run_job
from ..scripts import Script


def lengths_on_mesh(script: Script, path: Path) -> list[Mapping[str, Length]]:
    """By step, the relative lengths in mesh units, by Python parameter name.

    The steps up to the last one that has any are run on the mesh, since they may change its size.
    """
    steps = script.with_defaults().steps
    count = max((number for number, step in enumerate(steps, 1) if step.relative_lengths), default=0)
    if count == 0:
        return [{} for _ in steps]
    first = replace(script, steps=script.steps[:count], guards=type(script.guards)())
    with tempfile.TemporaryDirectory(prefix="pymeshfair-export-") as folder:
        result = run_job(Job(named.Recipe("export", first), path, Path(folder) / "mesh.ply", measures=False))
    done = [step.parameters for step in result.steps]
    return [
        {name: Length(done[index][name]) for name in step.relative_lengths} if index < count else {}
        for index, step in enumerate(steps)
    ]
