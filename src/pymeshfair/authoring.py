"""`Recipe`, a chain of filters as a Python object, and `run`, which cleans a file in one call."""

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
    from .meshlab import builtin_filters
    from .meshset import MeshSet
    from .running.job import Event, RunResult
    from .scripts import Change, Step, changing, guards, warnings
else:  # importing these takes about as long as importing pymeshlab
    named, registry, scripts = (ImportedWhenUsed(f"pymeshfair.{name}") for name in ("recipe", "registry", "scripts"))
    changing, guards, warnings = (ImportedWhenUsed(f"pymeshfair.scripts.{name}") for name in ("changing", "guards", "warnings"))
    builtin_filters = ImportedWhenUsed("pymeshfair.meshlab.builtin_filters")  # imports pymeshlab


class Recipe(FilterMethods):
    """A chain of filters, built step by step or loaded, to check, run and save.

    Every filter is a method, as in `pymeshfair.MeshSet`; here a call appends a step instead of applying the filter::

        recipe = pymeshfair.Recipe("clean")
        size = recipe.setting("size", "6edge", unit="length", description="Smaller details vanish.")
        recipe.meshing_remove_duplicate_vertices()
        recipe.apply_coord_implicit_fairing(detail_size=size)
        recipe.save("clean.mlx")
        recipe.run("scan.ply", "clean.ply")

    Two recipes are equal if their scripts are equal; a value that is left out counts as the default.
    """

    __hash__ = None  # type: ignore[assignment]  # a recipe is mutable

    def __init__(self, name: str = "recipe", comment: str = "") -> None:
        """Makes an empty recipe. `comment` is the head comment of its script, with the title as first line."""
        self.name = name  # for messages and the records of runs
        self.script = scripts.Script((), scripts.clean_comment(comment))
        self.changes: tuple[Change, ...] = ()  # how the loaded script was upgraded
        self.overrides: tuple[str, ...] = ()  # the texts that changed values since the script was loaded or saved

    @classmethod
    def load(cls, name_or_path: str | os.PathLike[str], *, upgrade: bool = False) -> Recipe:
        """Loads a shipped recipe by its name, or a script by its path, like `pymeshfair.recipe.load_recipe`."""
        loaded = named.load_recipe(name_or_path, upgrade=upgrade)
        recipe = cls(loaded.name)
        recipe.script, recipe.changes = loaded.script, loaded.changes
        return recipe

    def apply_filter(self, filter_name: str, **kwargs: Any) -> dict[str, Any]:
        """Appends a filter, by its Python name or its name in MeshLab's menus, as a step; returns {}, since nothing runs yet.

        Keywords are the Python names of parameters; values may be results of `setting`. Lengths are ``"1%"`` (of the diagonal),
        ``"0.5edge"`` (mean edges), ``"0.3"`` (mesh units) or pymeshlab's ``PureValue``; filters that are not MeshLab's also take
        ``PercentageValue``.
        Raises `UnknownNameError` for a wrong name, `ParameterError` for a wrong value.
        """
        declared = registry.find_filter(filter_name)
        # without a mesh, MeshLab's filters do not say which length is 100 %
        kinds = ("PureValue",) if declared.is_builtin else ("PureValue", "PercentageValue")
        values = {n: builtin_filters.as_length(v) if type(v).__name__ in kinds else v for n, v in kwargs.items()}
        self.script = changing.with_step(self.script, declared, values)
        return {}

    def setting(self, name: str, default: str, *, unit: str = "", description: str = "") -> Any:
        """Returns a named value, such as ``"6edge"``, to give to parameters of any type; `set` changes it for all of them."""
        return scripts.Setting(name, str(default), unit, description)

    def tag(self, name: str, step: int = -1) -> None:
        """Tags a step, counted from 0 (-1: the last), so that `set` accepts ``TAG.PARAM=VALUE``; steps may have the same tag."""
        steps = list(self.script.steps)
        if not -len(steps) <= step < len(steps):
            raise ParameterError(f"there is no step {step}; the recipe has {len(steps)}, counted from 0")
        steps[step] = replace(steps[step], tag=scripts.checked_name(name, "tag"))
        self.script = replace(self.script.with_steps(steps), path=None)

    def set(self, *texts: str, **settings: object) -> None:
        """Overrides values of the recipe: settings by name, or texts ``STEP.PARAM=VALUE`` as on the command line."""
        texts += tuple(f"{name}={value}" for name, value in settings.items())
        self.script, self.overrides = changing.override(self.script, texts), self.overrides + texts

    def limit(self, **limits: str) -> None:
        """Sets limits that a result of `run` must keep, as on the command line: ``limit(max_displacement="5%")``."""
        self.script = replace(self.script, path=None, guards=self.script.guards.overridden(guards.Guards.parse(limits)))

    def __iter__(self) -> Iterator[Step]:
        return iter(self.script.steps)

    def __len__(self) -> int:
        return len(self.script.steps)

    def __getitem__(self, index: int) -> Step:
        return self.script.steps[index]

    def __eq__(self, other: object) -> bool:
        return self.script.with_defaults() == other.script.with_defaults() if isinstance(other, Recipe) else NotImplemented

    def __repr__(self) -> str:
        return f"<Recipe {self.name!r}: {', '.join(step.filter.python_name for step in self) or 'no steps'}>"

    def check(self, mesh: MeshSet | str | os.PathLike[str] | None = None, *, layers: int = 1) -> list[str]:
        """Returns warnings about the recipe for this number of input layers; compares lengths with a mesh, if one is given."""
        diagonal = None
        if isinstance(mesh, str | os.PathLike):
            from .running.read import read_mesh

            diagonal = read_mesh(Path(mesh)).measured.diagonal
        elif mesh is not None:
            diagonal = float(mesh.current_mesh().bounding_box().diagonal())
        return warnings.script_warnings(self.script, layers=layers, diagonal=diagonal)

    def apply(self, meshes: MeshSet) -> list[dict[str, Any]]:
        """Applies all steps to the current mesh of a mesh set; limits are not checked."""
        return meshes.apply_script(self.script)

    def run(self, input: str | os.PathLike[str], output: str | os.PathLike[str], **options: Any) -> RunResult:
        """Cleans a mesh file; options, result and errors as for `pymeshfair.run`."""
        return run(self, input, output, **options)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the recipe as an .mlx script, atomically; replaces an existing file. The script then has this path."""
        scripts.write_script(self.script, Path(path), overwrite=True)
        self.script, self.overrides = replace(self.script, path=Path(path).absolute()), ()


def run(
    recipe: str | os.PathLike[str] | Recipe,
    input: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    settings: Mapping[str, object] | None = None,
    set: str | Sequence[str] = (),
    others: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
    overwrite: bool = False,
    timeout: float | None = None,
    measures: bool = True,
    unit: str | None = None,
    on_event: Callable[[Event], None] = lambda event: None,
) -> RunResult:
    """Cleans a mesh file with a recipe, like ``pymeshfair run``, in a separate process::

        result = pymeshfair.run("clean_range_map", "scan.ply", "clean.ply", settings={"detail_size": "4edge"})
        print(result.after["volume"], result.warnings, result.record["versions"])

    Args:
        recipe: a shipped name, the path of an .mlx script, or a `Recipe`, which is not changed.
        input: the mesh file.
        output: the file to write; its extension is the format. ``OUTPUT.provenance.json`` beside it is the record of the run.
        settings: values that override settings of the recipe, by name.
        set: texts ``NAME=VALUE`` or ``STEP.PARAM=VALUE`` that override values, as on the command line; or one text.
        others: mesh files for the layers 1, 2 ... that the recipe names; or one file.
        overwrite: replace any `output`. False replaces only an unchanged output of a run with the same inputs and recipe.
        timeout: the seconds after which the run is stopped, or None.
        measures: measure the mesh before and after; without measures the run cannot check limits.
        unit: the unit of the scan, mm, cm, m, in, ft or um; None: that of the file or recipe. A limit of ``0.05mm`` needs one.
        on_event: called with each event of the run.

    Returns:
        Measures before and after, warnings, paths of written files, and the `record`. A failed run raises a `PymeshfairError`.
    """
    from .running import job, supervise

    chosen = copy.copy(recipe) if isinstance(recipe, Recipe) else Recipe.load(recipe)
    chosen.set(*([set] if isinstance(set, str) else set), **(settings or {}))
    further = tuple(map(Path, [others] if isinstance(others, str | os.PathLike) else others))
    given = named.Recipe(chosen.name, chosen.script, chosen.changes), Path(input), Path(output), further, overwrite, timeout
    return supervise.run_job(job.Job(*given, overrides=chosen.overrides, measures=measures, unit=unit), on_event)
