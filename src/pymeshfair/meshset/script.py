"""A mesh set that remembers which filters were applied, and applies the filters of a script."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..declaration import Length
from ..scripts import Script, Step, read_script, write_script
from .errors import StepFailedError
from .filters import FilteringMeshSet, reason
from .listing import known_filter
from .methods import length_text


class ScriptedMeshSet(FilteringMeshSet):
    """The part of `MeshSet` that keeps a filter script, as MeshLab does: loading replaces it, every filter applied is added."""

    def __init__(self, verbose: bool = False) -> None:
        super().__init__(verbose)
        self._script: list[Step] = []
        self._script_file: str | None = None

    def apply_filter(self, filter_name: str, **kwargs: Any) -> dict[str, Any]:
        """Apply a filter, MeshLab's or a plugin's, to the current mesh and add it to the filter script.

        Args:
            filter_name: its Python name, or its name in MeshLab's menus.
            **kwargs: parameters by Python name; the others take their defaults. Lengths are ``"1%"`` of the bounding box's
                diagonal, ``"0.5edge"`` mean edges, ``"0.3"`` mesh units, `pymeshlab.PercentageValue` or `pymeshlab.PureValue`.

        Returns:
            What the filter reports, by name.

        Raises:
            UnknownFilterError: no such filter or parameter; the message gives the nearest name.
            FilterParameterError: a value that the filter does not take.
            UnknownLayerError: the id of a layer that is not there.
            FilterFailedError: a plugin's filter could not do its work; the mesh is as it was.
            pymeshlab.PyMeshLabException: base of all these, and MeshLab's word for every failure of its own filters.
        """
        known = known_filter(filter_name)
        if known is None:  # from a plugin of MeshLab's own kind; no script of ours can name it
            self._settle()
            return self._call_meshlab(filter_name, kwargs)
        result, step = self._run(known, kwargs)
        self._script.append(step)
        return result

    def load_filter_script(self, filter_script_name: str) -> None:
        """Read a filter script from an .mlx file in place of the current one.

        Raises:
            ScriptError: something in the script is wrong; lists every problem. The current script stays.
        """
        script = read_script(filter_script_name)
        self._script, self._script_file = list(script.steps), str(filter_script_name)

    def apply_filter_script(self) -> None:
        """Apply the current filter script: the filters that were loaded, and those applied since.

        Consecutive filters of plugins pass arrays on to each other, and MeshLab learns of the result when it needs it.

        Raises:
            StepFailedError: a step failed; the message names it with file and line. The mesh is as the last complete step
                left it.
        """
        with self.deferred():
            for number, step in enumerate(list(self._script), 1):
                self._apply_numbered(number, step)

    def _apply_numbered(self, number: int, step: Step) -> None:
        try:
            self.apply_step(step)
        except Exception as error:
            file = self._script_file if step.line is not None else None
            raise StepFailedError(reason(error), number=number, filter=step.filter.name, file=file, line=step.line) from error

    def save_filter_script(self, filter_script_name: str) -> None:
        """Write the current filter script to an .mlx file, every parameter with the value that it had.

        Raises:
            PymeshfairError: the file cannot be written.
        """
        units = {value.unit for step in self._script for value in step.values.values() if isinstance(value, Length)}
        sizes: dict[str, float] = {}
        layer = self._current_layer()
        if units - {"absolute"} and layer.diagonal > 0.0:
            sizes["diagonal"] = layer.diagonal
        if "edge" in units and sizes:
            sizes["mean_edge"] = layer.mean_edge
        write_script(Script(tuple(self._script)), Path(filter_script_name), **sizes)

    def clear_filter_script(self) -> None:
        """Forget the current filter script."""
        self._script, self._script_file = [], None

    def print_filter_script(self) -> None:
        """Print the current filter script: each filter with the values of its parameters."""
        print(f"Filter Script Size : {len(self._script)}\n")
        for number, step in enumerate(self._script):
            print(f"{number}: {step.filter.python_name}")
            for name, value in step.values.items():
                shown = length_text(value) if isinstance(value, Length) else value
                print(f"\t{name} : {type(value).__name__} = {shown}")
            print()
