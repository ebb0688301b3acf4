"""What holds for every scan of a batch, as it goes to the workers."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..recipe import Recipe
from ..running.job import Job
from ..running.messages import steps_document, steps_from
from ..scripts.guards import NO_GUARDS, Guards
from ..scripts.script import Script
from ..scripts.traps import traps
from ..scripts.write import format_script


@dataclass(frozen=True)
class Settings:
    """Of a run, what all scans share; see `pymeshfair.running.job.Job`.

    Attributes:
        recipe: the steps, with the overrides that hold for all.
        overrides: these overrides.
        others: mesh files for further layers, absolute paths.
        overwrite: replace outputs whatever they are.
        timeout: seconds for each scan, or None.
        memory: bytes for each scan; None for an equal share.
        allow_outside: let inputs name files outside their folders.
        guards: limits over those of the recipe.
        keep_broken: write outputs that break them.
        command: the command line.
    """

    recipe: Recipe
    overrides: tuple[str, ...] = ()
    others: tuple[Path, ...] = ()
    overwrite: bool = False
    timeout: float | None = None
    memory: int | None = None
    allow_outside: bool = False
    guards: Guards = NO_GUARDS
    keep_broken: bool = False
    command: tuple[str, ...] = ()

    def job(self, input: Path, output: Path, overrides: Sequence[str], *, threads: int, memory: int | None) -> Job:
        """The run of one scan.

        Args:
            input: the mesh file.
            output: the file to write.
            overrides: of this scan alone.
            threads: that filters may use.
            memory: bytes, where the settings give none.
        """
        recipe = self.recipe.override(overrides) if overrides else self.recipe
        return Job(
            recipe=recipe,
            input=input,
            output=output,
            others=self.others,
            overwrite=self.overwrite,
            timeout=self.timeout,
            memory_limit=memory if self.memory is None else self.memory,
            allow_outside=self.allow_outside,
            threads=threads,
            overrides=(*self.overrides, *overrides),
            command=self.command,
            guards=self.guards,
            keep_broken=self.keep_broken,
            displacement=True,
            own_texture_names=True,
            warnings=(*(str(change) for change in recipe.changes if not change.same_meaning), *traps(recipe.script)),
        )

    def to_document(self) -> dict[str, Any]:
        """The settings as a document that `from_document` reads."""
        script = self.recipe.script
        return {
            "name": self.recipe.name,
            "steps": steps_document(script.steps),
            "comment": script.comment,
            "path": None if script.path is None else str(script.path),
            "recipe_guards": script.guards.texts(),
            "changes": self.recipe.changes,
            "overrides": self.overrides,
            "others": [str(path) for path in self.others],
            "overwrite": self.overwrite,
            "timeout": self.timeout,
            "memory": self.memory,
            "allow_outside": self.allow_outside,
            "guards": self.guards.texts(),
            "keep_broken": self.keep_broken,
            "command": self.command,
        }

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Settings:
        """The settings in a document.

        Raises:
            UnknownNameError: a filter that this installation does not have.
        """
        path = document["path"]
        guards = Guards.parse(document["recipe_guards"])
        script = Script(steps_from(document["steps"]), document["comment"], None if path is None else Path(path), guards)
        return cls(
            Recipe(document["name"], script, document["changes"]),
            document["overrides"],
            tuple(Path(other) for other in document["others"]),
            document["overwrite"],
            document["timeout"],
            document["memory"],
            document["allow_outside"],
            Guards.parse(document["guards"]),
            document["keep_broken"],
            document["command"],
        )


def recipe_digest(recipe: Recipe) -> str:
    """The SHA-256 digest of a recipe, every value said, as the provenance of a run has it."""
    return hashlib.sha256(format_script(recipe.script).encode("utf-8")).hexdigest()
