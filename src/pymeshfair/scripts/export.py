"""Writes a script that needs nothing but MeshLab: its own filters, every parameter, lengths in mesh units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from ..declaration import Length
from .problems import Problem, ScriptError
from .script import Script, Step
from .write import write_script


def export_script(script: Script, path: str | Path, *, size: tuple[float, float] | None = None) -> None:
    """Write the script for MeshLab's desktop and plain pymeshlab; the file appears whole or not at all.

    Args:
        script: the steps.
        path: where to.
        size: bounding-box diagonal and mean edge length of the mesh that the script is for. Without it relative lengths
            cannot be mesh units, and a script that has any is refused.

    Raises:
        ScriptError: a step's filter is not MeshLab's, or a length is relative and no size is given; lists every such step.
        PymeshfairError: it cannot be written.
    """
    whole = script.with_defaults()
    if problems := list(_problems(whole, sized=size is not None)):
        raise ScriptError(problems)
    diagonal, edge = size or (1.0, 1.0)
    steps = tuple(_in_mesh_units(step, diagonal, edge) for step in whole.steps)
    write_script(replace(whole, steps=steps), path, diagonal=diagonal, mean_edge=edge)


def _problems(script: Script, *, sized: bool) -> Iterator[Problem]:
    name = "recipe" if script.path is None else str(script.path)
    for step in script.steps:
        if step.filter.function is not None:
            message = f"is a filter of {step.filter.origin}, which MeshLab lacks; MeshLab alone cannot run this step"
            yield Problem(file=name, line=step.line, filter=step.filter.name, message=message)
            continue
        for parameter in step.filter.parameters:
            value = step.values.get(parameter.name)
            if isinstance(value, Length) and value.unit != "absolute" and value.amount and not sized:
                message = f"is {value}, which depends on the size of the mesh; say with --for MESH which mesh the script is for"
                yield Problem(file=name, line=step.line, filter=step.filter.name, parameter=parameter.xml_name, message=message)


def _in_mesh_units(step: Step, diagonal: float, mean_edge: float) -> Step:
    lengths = {
        name: Length(value.resolve(diagonal=diagonal, mean_edge=lambda: mean_edge))
        for name, value in step.values.items()
        if isinstance(value, Length)
    }
    return step.with_checked(lengths)
