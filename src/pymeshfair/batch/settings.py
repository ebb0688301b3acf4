"""What holds for every scan of a batch, as it goes to the workers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from ..recipe import Recipe
from ..registry import find_filter
from ..running.job import Job
from ..scripts.guards import NO_GUARDS, Guards
from ..scripts.script import Step
from ..scripts.traps import traps


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
        unchecked: let MeshLab read formats that are not checked before.
        keep_all: fail a scan if anything of it is not in its output.
        guards: limits over those of the recipe.
        keep_broken: write outputs that break them.
        command: the command line.
        measures: whether to measure scans before and after; without, there are no limits and no numbers to compare scans by.
        unit: of the scans, or None if it is not known.
    """

    recipe: Recipe
    overrides: tuple[str, ...] = ()
    others: tuple[Path, ...] = ()
    overwrite: bool = False
    timeout: float | None = None
    memory: int | None = None
    allow_outside: bool = False
    unchecked: bool = False
    keep_all: bool = False
    guards: Guards = NO_GUARDS
    keep_broken: bool = False
    command: tuple[str, ...] = ()
    measures: bool = True
    unit: str | None = None

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
            unchecked=self.unchecked,
            keep_all=self.keep_all,
            threads=threads,
            overrides=(*self.overrides, *overrides),
            command=self.command,
            guards=self.guards,
            keep_broken=self.keep_broken,
            displacement=self.measures,
            own_texture_names=True,
            warnings=(*(str(change) for change in recipe.changes if not change.same_meaning), *traps(recipe.script)),
            measures=self.measures,
            unit=self.unit,
        )

    def limits(self, recipe: Recipe) -> Guards:
        """The limits of a scan with that recipe.

        Raises:
            ParameterError: one has a unit, and that of the scans is not known.
        """
        return recipe.script.guards.overridden(self.guards).in_mesh_units(self.unit)

    def to_document(self) -> dict[str, Any]:
        """The settings as something that can be pickled, which `from_document` reads: filters are known by their names."""
        script = self.recipe.script
        return {
            **{f.name: getattr(self, f.name) for f in fields(self)},
            "recipe": replace(self.recipe, script=replace(script, steps=())),
            "steps": [(s.filter.python_name, dict(s.values), s.line, s.tag, dict(s.settings)) for s in script.steps],
        }

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Settings:
        """The settings in a document; their values were checked when the recipe was read.

        Raises:
            UnknownNameError: a filter that this installation does not have.
        """
        given = dict(document)
        steps = tuple(Step(find_filter(name), *rest) for name, *rest in given.pop("steps"))
        recipe: Recipe = given.pop("recipe")
        return cls(replace(recipe, script=replace(recipe.script, steps=steps)), **given)
