"""The ways to call each filter that contracts are tried with, made from its declaration."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pymeshlab
import pytest

from pymeshfair.declaration import Bool, Enum, Filter, FilterClass
from pymeshfair.filters.robust import KERNEL_NAMES
from pymeshfair.registry import custom_filters
from tests.contracts.scenes import Outcome, apply, scene_for

#: Filters of ours, and those of this package alone: what others have installed is theirs to prove.
FILTERS: tuple[Filter, ...] = tuple(f for f in custom_filters() if f.origin == "pymeshfair")

#: any choice but the defaults, in `COMPANIONS`
ANY = "any"
NORMALS = {
    "method": "bilateral",
    "range_kernel": "gaussian",
    "space_kernel": "gaussian",
    "range_measure": "euclidean",
    "range_sigma": 0.4,
    "range_floor": 0.01,
    "space_sigma": 1.0,
    "neighborhood": "vertex",
    "normal_iterations": 3,
}

#: What must be given besides a choice so that the filter runs on the scene of its declaration, by filter and choice.
#: A new filter needs a line only if it does not run with its defaults, or with one of its choices alone.
COMPANIONS: dict[tuple[str, str | None], dict[str, Any]] = {
    # with all of these the mesh is not looked at for those left open, which the defaults do and which takes longest
    ("apply_coord_normal_filtering", ANY): {**NORMALS, "vertex_iterations": 3, "outer_iterations": 2, "vertex_update": "sun"},
    ("apply_normal_robust_filtering_per_face", ANY): NORMALS,
    ("apply_coord_curve_smoothing", "weights=uniform"): {"time_step": 10.0},
    ("apply_coord_explicit_smoothing", "operator=laplace_beltrami"): {"step": 0.05},
    ("apply_coord_explicit_smoothing", "operator=robust"): {"step": 0.05},
    ("apply_coord_explicit_smoothing", "operator=scale_dependent"): {"step": 0.05},
    ("apply_coord_implicit_fairing", "operator=inverse_length"): {"time_step": 1.0},
    ("apply_coord_implicit_fairing", "operator=scale_dependent"): {"time_step": 1.0},
    ("apply_coord_implicit_fairing", "operator=uniform"): {"time_step": 1.0},
}

#: Tried in ways of their own: what is selected by test_selection, `clouds_only`, which refuses the scenes, by test_outliers, and
#: `remesh`, which deletes vertices in the middle of all, so that the others change their numbers, by tests/plugins/test_fairing.
OTHERWISE = ("selected", "clouds_only", "remesh")


@dataclass(frozen=True, eq=False)
class Variant:
    """A filter with one choice other than its default, or with defaults alone."""

    declared: Filter
    choice: str | None
    values: Mapping[str, Any]

    @property
    def name(self) -> str:
        return self.declared.python_name + (f"-{self.choice}" if self.choice else "")


def variants_of(declared: Filter) -> list[Variant]:
    """The defaults; then every other choice of every word, and the other answer to every yes or no but those of `OTHERWISE`.

    Of kernels one other: they differ in the formula of a weight alone.
    """
    choices: dict[str | None, dict[str, Any]] = {None: {}}
    for parameter in declared.parameters:
        if isinstance(parameter, Enum):
            others = [choice for choice in parameter.choices if choice != parameter.default]
            for choice in others[-1:] if set(KERNEL_NAMES) <= set(parameter.choices) else others:
                choices[f"{parameter.name}={choice}"] = {parameter.name: choice}
        elif isinstance(parameter, Bool) and parameter.name not in OTHERWISE:
            choices[f"{parameter.name}={not parameter.default}"] = {parameter.name: not parameter.default}
    name = declared.python_name
    along = {choice: COMPANIONS.get((name, ANY), {}) if choice else {} for choice in choices}
    return [
        Variant(declared, choice, {**along[choice], **values, **COMPANIONS.get((name, choice), {})})
        for choice, values in choices.items()
    ]


VARIANTS: list[Variant] = [variant for declared in FILTERS for variant in variants_of(declared)]


#: runs a test for every filter, as its parameter `declared`
each_filter = pytest.mark.parametrize("declared", FILTERS, ids=lambda declared: declared.python_name)
#: runs a test for every way to call every filter, as its parameter `variant`; other ways than the first are slow together
each_variant = pytest.mark.parametrize(
    "variant",
    [pytest.param(v, marks=pytest.mark.slow if v.choice else []) for v in VARIANTS],
    ids=lambda variant: variant.name,
)


@functools.cache
def outcome_of(variant: Variant) -> Outcome:
    """What the variant makes of the scene of its filter; do not write into it."""
    try:
        return apply(variant.declared, scene_for(variant.declared), variant.values)
    except pymeshlab.PyMeshLabException as error:
        pytest.fail(f"{variant.name} does not run: {error}\nGive what it needs in COMPANIONS of tests/contracts/variants.py")


def is_of_points(declared: Filter) -> bool:
    """Whether every vertex of a mesh is data to the filter, with faces or without."""
    return bool(declared.classes & FilterClass.POINT_SET)
