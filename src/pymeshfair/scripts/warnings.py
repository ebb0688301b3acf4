"""Warnings about valid scripts: steps that miss their purpose, lengths out of proportion, and missing layers or files."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..declaration import FileOpen, Length, Mesh, Parameter
from ..errors import ParameterError
from .guards import parse_fits
from .script import Problem, Script, ScriptError, Step, paragraphs
from .upgrade import deletes_result, works_on_leftover_selection

#: lengths are out of proportion above a share of the diagonal and a multiple of the default, or below a share of the diagonal
_LARGE_PART, _LARGE_MULTIPLE, _SMALL_PART = 0.1, 5.0, 1e-7
_WITH = "give the file of each further layer to `pymeshfair run` by --with"
_NEW_LAYER = ("create_", "generate_")
_MANY_LAYERS = "generate_splitting_by_connected_components"


def script_warnings(script: Script, *, layers: int = 1, diagonal: float | None = None) -> list[str]:
    """All warnings; those about lengths only with the `diagonal` of a mesh."""
    words = paragraphs(script.comment)
    warnings = [f"superseded: {words['Superseded']}"] if "Superseded" in words else []
    warnings += [*traps(script), *(str(problem) for problem in unmet_needs(script, layers=layers))]
    return warnings if diagonal is None else [*warnings, *lengths_out_of_proportion(script, diagonal=diagonal)]


def traps(script: Script) -> Iterator[str]:
    """Warnings about conditions of the head that cannot be read, and steps that do something else than what was meant."""
    try:
        parse_fits(paragraphs(script.comment).get("Fits", ""))
    except ParameterError as error:
        yield f"head: {error}; scans are checked against none of its conditions"
    for index in deletes_result(script.steps):
        yield (
            f"{_place(script, index)} deletes the result of the step before, because this result is now the current layer; "
            "MeshLab 2016 deleted the input here; `pymeshfair upgrade` removes the step"
        )
    for index, selecting in works_on_leftover_selection(script.steps):
        yield (
            f"{_place(script, index)} works on the faces that {selecting} has selected, and on nothing else; "
            "give it Selected=false for the whole mesh, as `pymeshfair upgrade` does"
        )


def lengths_out_of_proportion(script: Script, *, diagonal: float) -> Iterator[str]:
    """A sentence for each length in mesh units that is out of proportion to the diagonal; none after a step that scales."""
    if not diagonal > 0:
        return
    for index, step in enumerate(script.steps):
        for name, value in step.values.items():
            if isinstance(value, Length) and value.unit == "absolute" and value.amount:
                part, default = abs(value.amount) / diagonal, step.filter.defaults.get(name)
                usual = default.amount / 100 if isinstance(default, Length) and default.unit == "percent" else 0.0
                if part < _SMALL_PART or part > max(_LARGE_PART, _LARGE_MULTIPLE * usual):
                    yield (
                        f"{_place(script, index)}: {name if step.line is None else step.filter.parameter(name).xml_name} is "
                        f"{value.amount:g}, which is {100 * part:.3g} % of the mesh's diagonal {diagonal:.4g}; if the script was "
                        "made for MESH, `pymeshfair upgrade --relative-to MESH` makes its lengths relative to the size of MESH"
                    )
        if step.filter.python_name == "compute_matrix_from_scaling_or_normalization":
            return


def _place(script: Script, index: int) -> str:
    step = script.steps[index]
    return f"step {index + 1} ({step.filter.name}{'' if step.line is None else f', line {step.line}'})"


def check_needs(script: Script, *, layers: int, advice: str = _WITH) -> None:
    """Raise `ScriptError` if there are `unmet_needs`."""
    if unmet := list(unmet_needs(script, layers=layers, advice=advice)):
        raise ScriptError(unmet)


def unmet_needs(script: Script, *, layers: int, advice: str = _WITH) -> Iterator[Problem]:
    """Problems with layers, files and rasters that a run with `layers` layers lacks; `advice` says how to give more layers."""
    count: int | None = layers
    for step in script.steps:
        if "raster" in step.filter.name.casefold():
            message = (
                "needs rasters (photographs with their cameras), which no mesh file holds; "
                "open the project in MeshLab for this step, and run the others here"
            )
            yield script.problem(step, message)
        for parameter in step.filter.parameters:
            if (lacking := _lacking(parameter, step, count, advice)) is not None:
                yield script.problem(step, lacking, parameter=parameter.xml_name)
        if step.filter.python_name == _MANY_LAYERS:
            count = None
        elif count is not None and step.filter.python_name.startswith(_NEW_LAYER):
            count += 1


def _lacking(parameter: Parameter, step: Step, layers: int | None, advice: str) -> str | None:
    """The problem with a value that names a missing layer or file; None without a problem, or if only the run can show it."""
    wanted: Any = step.values.get(parameter.name)
    if isinstance(parameter, Mesh) and wanted is not None and layers is not None and wanted >= layers:
        there = "is only layer 0" if layers == 1 else f"are only layers 0 to {layers - 1}"
        return f"is layer {wanted}, but so far there {there}; {advice}"
    made_by_itself = step.values.get("use_dummy_texture") is True
    if isinstance(parameter, FileOpen) and wanted and not made_by_itself and not Path(wanted).is_file():
        return f"is the file {wanted!r}, which is not there; its path counts from the folder in which the command runs"
    return None
