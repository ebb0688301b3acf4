"""Meanings of an old script across steps that are lost today: the current layer, and a selection that stays."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from ..declaration import Arity
from ..errors import UnknownNameError
from ..meshlab.facts import former_parameters
from ..registry import find_filter
from .problems import Change
from .script import FilterElement, Script, Step

_DELETE = "delete_current_mesh"
_CLOSE_HOLES = "meshing_close_holes"


def upgraded_steps(
    script: Script, names: Mapping[int, str], *, aged: bool, always_current: frozenset[int]
) -> tuple[Script, list[Change]]:
    """The script with steps that do together what was meant, and what was changed."""
    steps: list[Step] = []
    changes: list[Change] = []
    skipped = False
    for index, step in enumerate(script.steps):
        if skipped:
            skipped = False
            continue
        later = script.steps[index + 1 :]
        line = step.line or 0
        name = names.get(line, step.filter.name)
        if left_current_layer(step):
            if deletes_result(later):
                meaning = (
                    _ALWAYS if line in always_current else _LAYERS if _asks_for_layers(later[1:]) else "" if aged else _UNSURE
                )
                what = "is left out: today it would delete the result of the step before, then the input"
                changes.append(Change(line=later[0].line or 0, filter=later[0].filter.name, what=what, meaning=meaning))
                skipped = True
            elif aged and line not in always_current:
                changes.append(Change(line=line, filter=name, what="its result is the current layer now", meaning=_CURRENT))
        steps.append(step)
    whole: list[Step] = []
    leftover = set(steps_on_leftover_selection(steps))
    for number, step in enumerate(steps):
        if number in leftover:
            parameter = next(p.xml_name for p in step.filter.parameters if p.name == "selected")
            what = f"{parameter} is false now"
            changes.append(Change(line=step.line or 0, filter=step.filter.name, what=what, meaning=_WHOLE))
            whole.append(step.with_values({"selected": False}))
        else:
            whole.append(step)
    return replace(script, steps=tuple(whole)), changes


_LAYERS = "the input stays as a layer, and a later step looks at layers"
_ALWAYS = "the filter that the step before was made its result current in every version, so that this step deleted it"
_UNSURE = "in MeshLab 2016 it deleted the input, today it deletes the result; now nothing is deleted, and the result is current"
_CURRENT = "MeshLab 2016 left the input current; today later steps work on the result, and the result is written"
_WHOLE = "without it only the faces that closed the holes were worked on; now it is the whole mesh"


def left_current_layer(step: Step) -> bool:
    """Whether the result of the step is the current layer today, but was not in MeshLab 2016."""
    return former_parameters(step.filter.name).layers == "left"


def deletes_result(later: Iterable[Step]) -> bool:
    """Whether the next step deletes the current layer."""
    return next((step.filter.python_name == _DELETE for step in later), False)


def steps_on_leftover_selection(steps: Iterable[Step]) -> Iterator[int]:
    """The indices of the steps that work on the faces that Close Holes has selected, as they do not say ``Selected``."""
    leftover = False
    for index, step in enumerate(steps):
        name = step.filter.python_name
        if name == _CLOSE_HOLES:
            leftover = step.values.get("newfaceselected", True) is True
        elif "selection" in name or name.startswith(("create_", "generate_")):
            leftover = False
        elif leftover and step.filter.defaults.get("selected", True) is None and "selected" not in step.values:
            yield index


def _asks_for_layers(steps: Iterable[Step]) -> bool:
    """Whether any of the steps works on several layers or names one."""
    for step in steps:
        if step.values.get("alllayers") or step.values.get("visiblelayer", False):
            return True
        if step.filter.arity in (Arity.FIXED, Arity.VARIABLE) and "visiblelayer" not in step.values:
            return True
    return False


#: the filter that made another layer the current one; MeshLab has none today
CHANGES_LAYER = "Change the current layer"
#: filters that add one layer and make it current
_ADD_ONE = frozenset(
    {
        "generate_convex_hull",
        "generate_copy_of_current_mesh",
        "generate_from_selected_faces",
        "generate_from_selected_vertices",
        "generate_resampled_uniform_mesh",
        "generate_sampling_element",
        "generate_sampling_montecarlo",
        "generate_sampling_poisson_disk",
        "generate_simplified_point_cloud",
        "generate_surface_reconstruction_screened_poisson",
    }
)


class CurrentLayer:
    """The current layer of a script that begins with one mesh, as far as it is known."""

    def __init__(self) -> None:
        self._id: int | None = 0
        self._layers: int | None = 1
        self.maker: int | None = None  # the line of the step that made it; None for the mesh that was there

    def is_asked_for(self, element: FilterElement, values: Mapping[str, str]) -> bool:
        """Whether a step only makes the layer current that is so today."""
        named = " ".join((element.name or "").casefold().split()) == CHANGES_LAYER.casefold()
        return named and self._id is not None and values.get("mesh", "").strip() == str(self._id)

    def go_on(self, element: FilterElement, values: Mapping[str, str]) -> None:
        """Take a step into account, which has its name of today and once had these values."""
        try:
            name = find_filter(element.name or "").python_name
        except UnknownNameError:
            name = ""
        adds_one = name.startswith("create_") or (name in _ADD_ONE and values.get("SaveMontecarlo", "false") == "false")
        if adds_one and self._layers is not None:
            self._id, self.maker = self._layers, element.line
            self._layers += 1
        elif not name or name.startswith(("generate_", "delete_")):
            self._id = self._layers = self.maker = None
