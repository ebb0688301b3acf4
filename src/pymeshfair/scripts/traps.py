"""Steps of a valid script that MeshLab runs without a word and that hardly do what was meant."""

from __future__ import annotations

from collections.abc import Iterator

from ..declaration import Length
from .script import Script, Step
from .upgraded_steps import deletes_result, left_current_layer, steps_on_leftover_selection

#: A length is out of proportion above this part of the diagonal and this multiple of the filter's own default ...
_LARGE_PART, _LARGE_MULTIPLE = 0.1, 5.0
#: ... and below this part of the diagonal.
_SMALL_PART = 1e-7


def traps(script: Script) -> Iterator[str]:
    """What is likely to surprise, one sentence each, known without a mesh."""
    for index, step in enumerate(script.steps):
        later = script.steps[index + 1 :]
        if left_current_layer(step) and deletes_result(later):
            yield (
                f"{_place(script, index + 1)} deletes the result of the step before: that is the current layer since "
                "MeshLab 2016; `pymeshfair upgrade` leaves the step out"
            )
    for index in steps_on_leftover_selection(script.steps):
        yield (
            f"{_place(script, index)} works on the faces that Close Holes has selected, and on nothing else; "
            "give it Selected=false for the whole mesh, as `pymeshfair upgrade` does"
        )


def lengths_out_of_proportion(script: Script, *, diagonal: float) -> Iterator[str]:
    """The lengths in mesh units that hardly suit a mesh with that diagonal of its bounding box, one sentence each.

    Nothing is said about the steps after one that scales the mesh.
    """
    if not diagonal > 0:
        return
    for index, step in enumerate(script.steps):
        for name, value in step.values.items():
            if isinstance(value, Length) and value.unit == "absolute" and value.amount:
                part = abs(value.amount) / diagonal
                if part < _SMALL_PART or part > max(_LARGE_PART, _LARGE_MULTIPLE * _default_part(step, name)):
                    yield (
                        f"{_place(script, index)}: {name} is {value.amount:g}, which is {100 * part:.3g} % of this mesh's "
                        f"diagonal {diagonal:.4g}; `pymeshfair upgrade --relative-to MESH` makes the lengths of a script that "
                        "was made for MESH relative to its size"
                    )
        if step.filter.python_name == "compute_matrix_from_scaling_or_normalization":
            return


def _default_part(step: Step, name: str) -> float:
    """The filter's own default as a part of the diagonal; 0 if it is none."""
    default = step.filter.defaults.get(name)
    return default.amount / 100 if isinstance(default, Length) and default.unit == "percent" else 0.0


def _place(script: Script, index: int) -> str:
    step = script.steps[index]
    return f"step {index + 1} ({step.filter.name}{'' if step.line is None else f', line {step.line}'})"
