"""Which layer is the current one as an old script goes on, so that a step that made it current can be left out."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import UnknownNameError
from ..registry import find_filter
from .elements import FilterElement

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
    """The current layer of a script that begins with one mesh, as far as it is known.

    Attributes:
        maker: the line of the step that made it; None for the mesh that was there.
    """

    def __init__(self) -> None:
        self._id: int | None = 0
        self._layers: int | None = 1
        self.maker: int | None = None

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
