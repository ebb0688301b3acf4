"""`Recipe`: a chain of filters as an object of Python; and a run in one call."""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import ParameterError
from .filters.libraries import ImportedWhenUsed
from .meshset.filter_methods import FilterMethods

if TYPE_CHECKING:
    from . import recipe as named
    from . import registry, scripts
    from .meshset import MeshSet
    from .running.job import Event, RunResult
    from .scripts import Change, Step, changing, guards, warnings
else:  # importing them takes longer than importing pymeshlab, and a program may only ask for this class
    named, registry, scripts = (ImportedWhenUsed(f"pymeshfair.{name}") for name in ("recipe", "registry", "scripts"))
    changing, guards, warnings = (ImportedWhenUsed(f"pymeshfair.scripts.{name}") for name in ("changing", "guards", "warnings"))


class Recipe(FilterMethods):
    """A chain of filters that is built step by step, or loaded, and then checked, run and saved.

    Every filter is a method, as of `pymeshfair.MeshSet`; here it becomes the next step instead of being applied::

        recipe = pymeshfair.Recipe("clean")
        size = recipe.setting("size", "6edge", unit="length", description="Smaller details vanish.")
        recipe.meshing_remove_duplicate_vertices()
        recipe.apply_coord_implicit_fairing(detail_size=size)
        recipe.save("clean.mlx")
        recipe.run("scan.ply", "clean.ply")

    Two recipes are equal if their scripts are: steps, values, settings, tags, comment and limits.
    """

    __hash__ = None  # type: ignore[assignment]  # it changes

    def __init__(self, name: str = "recipe", comment: str = "") -> None:
        """An empty recipe; the first line of the comment, the words at the head of its script, is the title."""
        self.name = name  # for messages and the records of runs
        self.script = scripts.Script((), comment)  # the steps with their values, the settings, the comment and the limits
        self.changes: tuple[Change, ...] = ()  # those by which the loaded script was upgraded

    @classmethod
    def load(cls, name_or_path: str | os.PathLike[str], *, upgrade: bool = False) -> Recipe:
        """A shipped recipe by its name, or a script by its path, as by `pymeshfair.recipe.load_recipe`."""
        loaded = named.load_recipe(name_or_path, upgrade=upgrade)
        recipe = cls(loaded.name)
        recipe.script, recipe.changes = loaded.script, loaded.changes
        return recipe

    def apply_filter(self, filter_name: str, **kwargs: Any) -> dict[str, Any]:
        """Make a filter the next step, by its Python name or its name in MeshLab's menus; filters report when the recipe runs.

        Parameters, by Python name, are values or what `setting` gives. Lengths are ``"1%"`` of the diagonal, ``"0.5edge"`` or
        ``"0.3"`` in mesh units. Raises `UnknownNameError` for a wrong name, `ParameterError` for a value.
        """
        self.script = changing.with_step(self.script, registry.find_filter(filter_name), kwargs)
        return {}

    def setting(self, name: str, default: str, *, unit: str = "", description: str = "") -> Any:
        """A value with a name for parameters of any type, such as ``"6edge"``; `set` changes it in all of them at once."""
        return scripts.Setting(name, str(default), unit, description)

    def tag(self, name: str, step: int = -1) -> None:
        """Give a step, counted from 0, a tag, by which ``TAG.PARAM=VALUE`` finds it; several steps may have the same."""
        steps = list(self.script.steps)
        if not -len(steps) <= step < len(steps):
            raise ParameterError(f"there is no step {step}; the recipe has {len(steps)}")
        steps[step] = replace(steps[step], tag=scripts.checked_name(name, "tag"))
        self.script = self.script.with_steps(steps)

    def set(self, *texts: str, **settings: object) -> None:
        """Put other values over those of the recipe: settings by name, or texts ``STEP.PARAM=VALUE`` as of the command line."""
        self.script = changing.override(self.script, [*texts, *(f"{name}={value}" for name, value in settings.items())])

    def limit(self, **limits: str) -> None:
        """Set what a result of `run` must not do, as of the command line: ``limit(max_displacement="5%")``."""
        self.script = replace(self.script, guards=self.script.guards.overridden(guards.Guards.parse(limits)))

    def __iter__(self) -> Iterator[Step]:
        return iter(self.script.steps)

    def __len__(self) -> int:
        return len(self.script.steps)

    def __getitem__(self, index: int) -> Step:
        return self.script.steps[index]

    def __eq__(self, other: object) -> bool:
        return self.script == other.script if isinstance(other, Recipe) else NotImplemented

    def __repr__(self) -> str:
        return f"<Recipe {self.name!r}: {', '.join(step.filter.python_name for step in self) or 'no steps'}>"

    def check(self, mesh: MeshSet | str | os.PathLike[str] | None = None, *, layers: int = 1) -> list[str]:
        """Warnings about the recipe, which begins with so many layers; lengths are compared with a mesh, if one is given."""
        diagonal = None
        if isinstance(mesh, str | os.PathLike):
            from .running.read import read_mesh

            diagonal = read_mesh(Path(mesh)).measured.diagonal
        elif mesh is not None:
            diagonal = float(mesh.current_mesh().bounding_box().diagonal())
        return warnings.script_warnings(self.script, layers=layers, diagonal=diagonal)

    def apply(self, meshes: MeshSet) -> list[dict[str, Any]]:
        """Apply all steps to the current mesh of a mesh set, without its limits; what each step reports.

        The steps are added to its filter script. If one fails the mesh is as the last complete step left it.
        """
        return meshes.apply_script(self.script)

    def run(self, input: str | os.PathLike[str], output: str | os.PathLike[str], **options: Any) -> RunResult:
        """Clean a mesh file; options, result and errors are those of `pymeshfair.run`."""
        return run(self, input, output, **options)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the recipe as an .mlx script, in place of one that is there; the file appears whole or not at all."""
        scripts.write_script(self.script, Path(path), overwrite=True)


def run(
    recipe: str | os.PathLike[str] | Recipe,
    input: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    settings: Mapping[str, object] | None = None,
    set: Sequence[str] = (),
    others: Sequence[str | os.PathLike[str]] = (),
    overwrite: bool = False,
    timeout: float | None = None,
    measures: bool = True,
    unit: str | None = None,
    on_event: Callable[[Event], None] = lambda event: None,
) -> RunResult:
    """Clean a mesh file with a recipe, as ``pymeshfair run`` does, in a process of its own::

        result = pymeshfair.run("clean_range_map", "scan.ply", "clean.ply", settings={"detail_size": "4edge"})
        print(result.after["volume"], result.warnings, result.record["versions"])

    Args:
        recipe: a shipped name, the path of an .mlx script, or a `Recipe`, which stays as it is.
        input: the mesh file.
        output: the file to write; its extension is the format. Beside it ``OUTPUT.provenance.json`` is the record of the run.
        settings: values over the recipe's own, by the names of its settings.
        set: the same as texts ``NAME=VALUE`` or ``STEP.PARAM=VALUE``, as of the command line.
        others: mesh files for the layers 1, 2 ... that the recipe names.
        overwrite: replace `output`, whatever it is, and not only what a former run wrote there from the same input.
        timeout: seconds, or None.
        measures: measure the mesh before and after; without, the run keeps no limits.
        unit: the unit of the scan, mm, cm, m or in; a limit such as ``0.05mm`` needs it.
        on_event: called with each event of the run.

    Returns:
        What the run did: measures before and after, warnings, the paths of what was written, and its `record`.

    Raises:
        PymeshfairError: the run failed; see `pymeshfair.running.supervise.run_job` for the kinds.
    """
    from .running import job, supervise

    chosen = recipe if isinstance(recipe, Recipe) else Recipe.load(recipe)
    if settings or set:
        chosen = copy.copy(chosen)
        chosen.set(*set, **(settings or {}))
    meaning = (str(change) for change in chosen.changes if not change.same_meaning)
    order = job.Job(
        named.Recipe(chosen.name, chosen.script, chosen.changes),
        Path(input),
        Path(output),
        others=tuple(map(Path, others)),
        overwrite=overwrite,
        timeout=timeout,
        measures=measures,
        unit=unit,
        warnings=(*meaning, *warnings.script_warnings(chosen.script, layers=1 + len(others))),
    )
    return supervise.run_job(order, on_event)
