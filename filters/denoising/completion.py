"""Completes the parameters of denoising that a caller sets: by defaults, by fixed values, or by a choice for the mesh."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import asdict, fields
from typing import Any, Literal, TypeAlias

from ..evidence import Choice
from ..mesh import Floats, Ints
from .automatic import AutomaticChoice, automatic_choice
from .candidates import FIXED, REPERTOIRE, AutomaticParameters, Setting
from .normal_filter import NormalFilter
from .normal_filtering import normal_filtering

#: "held_out": parameters that are not set are chosen for the mesh. "fixed": they get all-round values.
Chooser: TypeAlias = Literal["held_out", "fixed"]
#: the parameters of the steps before normal filtering
PREPARATION = ("outliers", "rounding", "relaxation", "relaxation_direction")
_MOVING = PREPARATION[:3]
_STEPS = inspect.signature(normal_filtering).parameters
#: all parameters, with defaults for those that neither the caller nor the choice for the mesh sets
DEFAULTS: dict[str, Any] = {
    **{field.name: field.default for field in fields(NormalFilter) if field.name != "radius"},
    **{name: _STEPS[name].default for name in ("vertex_iterations", "outer_iterations", "vertex_update")},
    **{name: getattr(Setting(), name) for name in PREPARATION},
}
#: the sentence of a filter that has found nothing to do
NOTHING_TO_REMOVE = "no noise was found that can be removed safely: the vertices stay where they are"


def parameters_without_mesh(set_values: Mapping[str, Any], choice: Chooser) -> dict[str, Any] | None:
    """Returns all parameters; None if a parameter of normal filtering has to be chosen for the mesh."""
    if choice == "fixed":
        return {**DEFAULTS, **asdict(FIXED), **set_values}
    is_complete = {field.name for field in fields(AutomaticParameters)} <= set_values.keys()
    return {**DEFAULTS, **set_values} if is_complete else None


def parameters_for_mesh(
    vertices: Floats, faces: Ints, set_values: Mapping[str, Any], choice: Chooser, **options: Any
) -> tuple[dict[str, Any], AutomaticChoice | None]:
    """Returns all parameters, and the choice behind them if one is necessary; the `options` go to `automatic_choice`."""
    if (parameters := parameters_without_mesh(set_values, choice)) is not None:
        return parameters, None
    # Trials ignore the given rounding, and the given normal iterations: twenty iterations would take twenty times as long.
    not_tried = ("normal_iterations", "rounding")
    tried = REPERTOIRE.narrowed(**{name: value for name, value in set_values.items() if name not in not_tried})
    made = automatic_choice(vertices, faces, repertoire=tried, **options)
    chosen: dict[str, Any] = {}
    if made.setting.parameters is not None:
        chosen = asdict(made.setting.parameters)
    elif set_values.keys() <= set(PREPARATION):  # no normal filtering; if parameters of it are set, the default number of rounds
        chosen = {"outer_iterations": 0}
    before = {name: getattr(made.setting, name) for name in PREPARATION}
    return {**DEFAULTS, **chosen, **before, **set_values}, made


def reported(choice: Choice[Any] | None, labelled: Callable[[Any], Mapping[str, Any]]) -> list[dict[str, Any]]:
    """The report on each trial of a choice: the values of its label by name, its scores, and whether it was chosen."""
    if choice is None:
        return []
    return [
        {**labelled(t.label), "error": t.error, "excess": t.excess, "uncertainty": t.uncertainty, "chosen": t == choice.chosen}
        for t in choice.trials
    ]


def findings_of_choice(made: AutomaticChoice | None) -> dict[str, Any]:
    """The report on a choice: the kind of mesh, its noise, whether the choice is sure, and the trials; empty for None."""
    if made is None:
        return {}
    findings: dict[str, Any] = {"shape": made.kind, "noise": made.noise.deviation, "sure": made.sure}
    return findings if made.evidence is None else {**findings, "tried": reported(made.evidence, asdict)}


def notes_of_choice(made: AutomaticChoice | None, parameters: Mapping[str, Any], *, is_open: bool) -> tuple[str, ...]:
    """Notes on a choice: if all the `parameters` do nothing, and on correlated noise (not rounding) if the mesh `is_open`."""
    if made is None:
        return ()
    if parameters["outer_iterations"] == 0 and all(parameters[name] == DEFAULTS[name] for name in _MOVING):
        return (NOTHING_TO_REMOVE,)
    text = (
        "neighbouring vertices share their noise, and the border does not count in the choice of the filter: faces at "
        "the border, for example at silhouettes, may be farther from the true surface than before"
    )
    return (text,) if made.kind == "correlated" and made.setting.rounding == "keep" and is_open else ()
