"""What a script needs besides the mesh that it works on: other layers, files and rasters."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..declaration import FileOpen, Mesh, Parameter
from .problems import Problem, ScriptError
from .script import Script, Step

_NEW_LAYER = ("create_", "generate_")
#: it makes as many layers as the mesh has components
_MANY_LAYERS = "generate_splitting_by_connected_components"


def check_needs(script: Script, *, layers: int) -> None:
    """Check that a run with so many mesh files gives every step what it needs.

    Raises:
        ScriptError: a step needs a layer or a file that there will not be, or rasters; lists every such step.
    """
    if unmet := list(unmet_needs(script, layers=layers)):
        raise ScriptError(unmet)


def unmet_needs(script: Script, *, layers: int) -> Iterator[Problem]:
    """What the steps need and will not find when a run begins with `layers` layers, numbered from 0."""
    name = "script" if script.path is None else str(script.path)
    known: int | None = layers
    for step in script.steps:
        if "raster" in step.filter.name.casefold():
            message = (
                "needs rasters (photographs with their cameras), which no mesh file holds; "
                "open the project in MeshLab for this step, and run the others here"
            )
            yield Problem(file=name, line=step.line, filter=step.filter.name, message=message)
        for parameter in step.filter.parameters:
            if (lacking := _lacking(parameter, step, known)) is not None:
                yield Problem(file=name, line=step.line, filter=step.filter.name, parameter=parameter.xml_name, message=lacking)
        if step.filter.python_name == _MANY_LAYERS:
            known = None
        elif known is not None and step.filter.python_name.startswith(_NEW_LAYER):
            known += 1


def _lacking(parameter: Parameter, step: Step, layers: int | None) -> str | None:
    """What a value names that will not be there; None if it is, or if that is not known before the run."""
    wanted: Any = step.values.get(parameter.name)
    if isinstance(parameter, Mesh) and wanted is not None and layers is not None and wanted >= layers:
        there = "is only layer 0" if layers == 1 else f"are only layers 0 to {layers - 1}"
        return f"is layer {wanted}, but there {there} then; give the file of each further layer to `pymeshfair run` by --with"
    made_by_itself = step.values.get("use_dummy_texture") is True
    if isinstance(parameter, FileOpen) and wanted and not made_by_itself and not Path(wanted).is_file():
        return f"is the file {wanted!r}, which is not there; its path counts from the folder in which the command runs"
    return None
