"""A run in one call: a mesh file through a recipe, with a record of everything that it did."""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from .recipe import Recipe

if TYPE_CHECKING:
    from ..running.job import Event, RunResult


def run(
    recipe: str | os.PathLike[str] | Recipe,
    input: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    settings: Mapping[str, object] | None = None,
    set: Sequence[str] = (),
    others: Sequence[str | os.PathLike[str]] = (),
    overwrite: bool = False,
    timeout: float | None = None,
    measures: bool = True,
    unit: str | None = None,
    on_event: Callable[[Event], None] = lambda event: None,
) -> RunResult:
    """Clean a mesh file with a recipe, as ``pymeshfair run`` does, in a process of its own::

        result = pymeshfair.run("clean_range_map", "scan.ply", "clean.ply", settings={"detail_size": "4edge"})
        print(result.after["volume"], result.warnings, result.record["versions"])

    Args:
        recipe: a shipped name, the path of an .mlx script, or a `Recipe`, which stays as it is.
        input: the mesh file.
        output: the file to write; its extension says the format. Beside it ``OUTPUT.provenance.json`` says how it came about.
        settings: values over the recipe's own, by the names of its settings.
        set: the same as texts ``NAME=VALUE`` or ``STEP.PARAM=VALUE``, as of the command line.
        others: mesh files for the layers 1, 2 ... that the recipe names.
        overwrite: replace `output`, whatever it is. Without, an existing file is replaced only if it is, to the byte, what a
            former run wrote there from the same input.
        timeout: seconds, or None.
        measures: measure the mesh before and after. Without, the run is faster, keeps no limits, and has nothing to compare.
        unit: the unit of the scan, mm, cm, m or in; a limit such as ``0.05mm`` needs it.
        on_event: called with each event of the run.

    Returns:
        What the run did: measures before and after, warnings, the paths of what was written, and its `record`.

    Raises:
        PymeshfairError: the run failed; see `pymeshfair.running.supervise.run_job` for the kinds.
    """
    chosen = recipe if isinstance(recipe, Recipe) else Recipe.load(recipe)
    if settings or set:
        chosen = copy.copy(chosen)
        chosen.set(*set, **(settings or {}))
    return chosen.run(
        input, output, others=others, overwrite=overwrite, timeout=timeout, measures=measures, unit=unit, on_event=on_event
    )
