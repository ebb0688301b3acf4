"""The filter script of a mesh set: the loaded steps, and every filter applied since."""

from collections.abc import Callable
from pathlib import Path

from ..declaration import Layer, Length
from ..errors import Place
from ..meshlab.base import ScriptStepFailedError, reason
from ..scripts import Script, Step, read_script, write_script
from ..scripts.write import NOMINAL_DIAGONAL, NOMINAL_EDGE
from .methods import length_text


class ScriptLog:
    """A list of steps that is read from a file, grows with every filter applied, and is applied, printed and saved.

    Attributes:
        steps: in the order in which they run.
    """

    def __init__(self, script: Script | None = None) -> None:
        self._take(Script(()) if script is None else script)

    def load(self, file: str) -> None:
        """Take the steps of an .mlx file in place of these; after a `ScriptError` these stay."""
        self._take(read_script(file))

    def _take(self, script: Script) -> None:
        self.steps: list[Step] = list(script.steps)
        self._file, self._settings = script.path, script.settings

    def clear(self) -> None:
        """Forget all steps."""
        self._take(Script(()))

    def apply(self, apply_step: Callable[[Step], object]) -> None:
        """Apply each step in turn.

        Raises:
            ScriptStepFailedError: a step failed.
        """
        for number, step in enumerate(list(self.steps), 1):
            try:
                apply_step(step)
            except Exception as error:  # noqa: PERF203
                file = self._file if step.line is not None else None
                place = Place.of_step(number, len(self.steps), step.filter.name, file=file, line=step.line)
                raise ScriptStepFailedError(place, reason(error)) from error

    def save(self, file: str, layer: Layer) -> None:
        """Write the steps to an .mlx file, with absolute lengths beside the relative ones for this layer.

        Raises:
            PymeshfairError: the file cannot be written.
        """
        units = {value.unit for step in self.steps for value in step.values.values() if isinstance(value, Length)}
        sized = bool(units - {"absolute"}) and layer.diagonal > 0.0
        diagonal = layer.diagonal if sized else NOMINAL_DIAGONAL
        mean_edge = layer.mean_edge if sized and "edge" in units else NOMINAL_EDGE
        script = Script((), settings=self._settings).with_steps(self.steps)
        write_script(script, Path(file), diagonal=diagonal, mean_edge=mean_edge, overwrite=True)

    def print(self) -> None:
        """Print each step with the values of its parameters, as pymeshlab prints its script."""
        print(f"Filter Script Size : {len(self.steps)}\n")
        for number, step in enumerate(self.steps):
            print(f"{number}: {step.filter.python_name}")
            for name, value in step.values.items():
                shown = length_text(value) if isinstance(value, Length) else value
                print(f"\t{name} : {type(value).__name__} = {shown}")
            print()
