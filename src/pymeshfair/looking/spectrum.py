"""The spectrum of a mesh file, measured in a process of its own."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..recipe import Recipe
from ..registry import find_filter
from ..running.job import Event, Job
from ..running.supervise import run_job
from ..scripts.script import Script, Step

#: the filter that measures
MEASURES = "get_surface_spectrum"


def measured_spectrum(
    mesh: Path, *, modes: int = 50, timeout: float | None = None, on_event: Callable[[Event], None] = lambda event: None
) -> dict[str, Any]:
    """The result of the filter ``get_surface_spectrum`` for a mesh file, with so many modes one by one."""
    measure = Step(find_filter(MEASURES)).with_values({"modes": modes})
    with tempfile.TemporaryDirectory() as folder:
        job = Job(Recipe("spectrum", Script((measure,))), mesh, Path(folder) / "measured.ply", timeout=timeout, measures=False)
        result = run_job(job, on_event)
    return dict(result.steps[0].values)
