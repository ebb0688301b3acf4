"""``pymeshfair suggest SCAN``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import Json, Overwrite, Timeout
from .streams import STANDARD, check_text, print_document, print_lines, save_text, say

if TYPE_CHECKING:
    from ..mesh_data import MeshData
    from ..recipe import Recipe
    from ..running.suitability import Trial

#: the filter whose automatic parameters are made explicit
FILTER = "apply_coord_normal_filtering"

#: Less noise, in mean edges, is that of meshing: level sets without any other have up to 0.017. Recipes are then judged as on a
#: scan without noise, by how little they move.
_MESHING = 0.018
#: so many of the settings that were tried are shown
_SHOWN = 6
#: names of the smoothers that are compared, and the text of their amounts
_SMOOTHERS = {
    "nothing": ("nothing", ""),
    "normal_filtering": ("normal filtering as above", ""),
    "taubin": ("apply_coord_taubin_fairing", "iterations={:.0f}"),
    "implicit": ("apply_coord_implicit_fairing", "detail_size={:.3g} edges"),
    "bilaplacian": ("apply_coord_bilaplacian_smoothing", "detail_size={:.3g} edges"),
    "spectral": ("apply_coord_spectral_filter", "detail_size={:.3g} edges"),
}


def suggest(
    scan: Annotated[Path, typer.Argument(metavar="SCAN", help="The mesh file to look at; it is not changed.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="RECIPE.mlx",
            help="Write there a recipe that denoises it, every value said; - is standard output.",
        ),
    ] = None,
    timeout: Timeout = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Rank all recipes for a scan, with reasons, and find how it is denoised best.

    What is measured is compared with what each recipe says at its head under Fits. Those that smooth are tried on a sample of the
    scan: first comes what leaves the least error there, last what erases detail. Whether there is noise to remove, and how, is
    found by vertices that no filter has seen; with -o the settings that predict these best become a recipe, which does what
    denoise does on this scan, and can be changed and used for others of its kind. Low-pass smoothers are compared in the same
    way, each with the amount that suits the scan best.
    """
    from ..errors import PymeshfairError
    from ..running.read import read_mesh
    from ..running.suitability import documents, ranked
    from ..scripts.write import format_script
    from .display import fitting_lines

    if output is not None:
        check_text(output, ("mlx",), overwrite=overwrite, json=json)
    read = read_mesh(scan)
    traits = read.traits()
    values = _tried(scan, timeout) if traits["mesh"] else None
    recipe = None if values is None else _explicit(scan, values, traits["noise"])
    if output is not None:
        if recipe is None:
            raise PymeshfairError(f"{scan} has no noise to remove, so there is no recipe to write to {output}")
        save_text(format_script(recipe.script), output, overwrite=overwrite)
    traits_here = _by_evidence(traits, values)
    tried = {} if values is None else _trials(read.mesh, traits_here, values, recipe, timeout)
    recipes = ranked(traits_here, tried=tried)
    if json:
        text = None if recipe is None else format_script(recipe.script)
        ranking = documents(recipes)
        print_document({"scan": scan, "traits": traits, "recipes": ranking, "found": values, "recipe": text, "output": output})
        return
    print_lines(fitting_lines(recipes), err=output == STANDARD)
    if values is None:
        return
    print_lines((_words(scan, values, traits["noise"]), *_contest(values), *_families(values)), err=True)
    if output is not None and output != STANDARD:
        say(f"{output}: written; `pymeshfair run {output} {scan} -o RESULT` applies it", err=True)


def _by_evidence(traits: dict[str, float], values: dict[str, Any] | None) -> dict[str, float]:
    """The traits with the noise as the trials found it: its kind and its amount, as the trait alone is near 0 for impulses."""
    if values is None:
        return traits
    noise = traits["noise"] if traits.get("camera noise") else max(traits["noise"], values["drift"])
    is_clean = values["shape"] == "clean"
    return traits | {"camera noise": float(values["shape"] == "correlated"), "noise": 0.0 if is_clean else noise}


def _tried(scan: Path, timeout: float | None) -> dict[str, Any]:
    """The report of the automatic filter on the scan, run in a process of its own."""
    from ..running.read import reported_values
    from .display import progress

    with progress() as show:
        return reported_values(scan, FILTER, {"compare": True}, timeout=timeout, on_event=show)


def _trials(
    mesh: MeshData, traits: dict[str, float], values: dict[str, Any], recipe: Recipe | None, timeout: float | None
) -> dict[str, Trial]:
    """Trials of the recipes that smooth and fit."""
    from dataclasses import replace

    from ..recipe import load_recipe
    from ..registry import find_filter
    from ..running.suitability import ranked
    from ..running.trials import moving_script, trials

    is_correlated = values["shape"] == "correlated"
    errors = [trial["error"] for trial in values.get("tried", ())] if is_correlated else []
    if is_correlated and not errors:
        return {}
    fitting = [s.recipe for s in ranked(traits) if s.fits and s.task in ("denoise", "smooth", "clean")]
    chosen = None if recipe is None else recipe.script.steps[0]
    scripts = {}
    for name in fitting:
        candidate = load_recipe(name)
        script = None if candidate.info.behind in fitting else moving_script(candidate, chosen)
        if script is not None:
            scripts[name] = script
    clean = values["shape"] == "clean" or (traits["noise"] < _MESHING and values["outliers"] == "keep")
    results = trials(mesh.vertices, mesh.faces, scripts, clean=clean, timeout=timeout)
    if not is_correlated:
        return results
    # Held-out vertices are no evidence where neighbours share their noise: the filter that knows such noise was judged otherwise.
    # Nor is relief, as the waves of that noise pass for some.
    filtered = {name for name, script in scripts.items() if any(step.filter is find_filter(FILTER) for step in script.steps)}
    # Nothing at all leaves rounding in its steps, which is no merit.
    nothing = max(errors[0], traits["noise"])
    best = min(nothing, min(values["tried"], key=lambda trial: float(trial["excess"]))["error"])
    return {
        name: replace(
            trial, before=nothing, error=best if name in filtered else max(nothing, trial.error), relief=None, tied=False
        )
        for name, trial in results.items()
    }


def _explicit(scan: Path, values: dict[str, Any], noise: float) -> Recipe | None:
    """The filter with every value said; None if nothing is to be done."""
    from ..recipe import Recipe
    from ..registry import find_filter
    from ..scripts.script import Script, Step

    if values["shape"] == "clean":
        return None
    filter = find_filter(FILTER)
    step = Step(filter).with_values({p.name: values[p.name] for p in filter.parameters if p.name in values})
    name = scan.name.replace("--", "- ").strip("-")
    comment = f"Denoises scans such as {name}\n\nFor: {_kind(values)}, with noise of {noise:.2g} edges."
    return Recipe("suggestion", Script((step,), comment))


def _words(scan: Path, values: dict[str, Any], noise: float) -> str:
    if values["shape"] == "clean":
        surface = f"; what looks like {noise:.2g} mean edges of it is the surface" if noise > 0.0 else ""
        return f"{scan}: no noise to remove, so it needs no smoothing{surface}"
    return (
        f"{scan}: {_kind(values)}; the noise along the normals is {noise:.2g} mean edges; removing it moves the "
        f"vertices by {values['drift']:.2g} mean edges on average; the choice is {_sureness(values)}"
    )


def _sureness(values: dict[str, Any]) -> str:
    if values["sure"]:
        return "sure: the noise of neighbours is independent, and hardly another setting predicts as well"
    return "not sure: several settings predict as well, or details may look like noise; compare pictures"


def _kind(values: dict[str, Any]) -> str:
    own = values["shape"] == "noisy"
    return f"a shape with noise {'of its own at every vertex' if own else 'that neighbours share'}"


def _contest(values: dict[str, Any]) -> list[str]:
    """The settings that predict best and the first of all, nothing, with the error of held-out vertices."""
    tried = values.get("tried", [])
    if not tried:
        return []
    shown = sorted(tried, key=lambda trial: trial["excess"])[:_SHOWN]
    judge = "by what they make of the noise" if values["shape"] == "correlated" else "on held-out vertices"
    lines = [f"tried {judge}: {len(tried)} settings were not ruled out at once; error in mean edges of"]
    for trial in shown if tried[0] in shown else [*shown, tried[0]]:
        parameters = trial["parameters"]
        steps = {"keep": [], "replace": ["outliers replaced"], "only": ["outliers alone replaced"]}[trial["outliers"]]
        steps = ["rounding undone", *steps] if trial["rounding"] == "undo" else steps
        if trial["relaxation"]:
            steps.append(f"{trial['relaxation']} Taubin steps")
        if parameters is not None:
            steps.append(
                f"{parameters['outer_iterations']} rounds of {parameters['method']} {parameters['range_kernel']} "
                f"{parameters['range_sigma']:g} over {parameters['neighborhood']}"
            )
        lines.append(f"  {trial['error']:.4f}  {', then '.join(steps) or 'nothing'} ({_behind(trial)})")
    return lines


def _families(values: dict[str, Any]) -> list[str]:
    """The families of smoothers, that with the least error first, and what each is called with."""
    compared = values.get("smoothers", [])
    if not compared:
        return []
    lines = ["smoothers, each with the amount that suits this scan best; error in mean edges of"]
    for trial in sorted(compared, key=lambda trial: trial["error"]):
        name, amount = _SMOOTHERS[trial["smoother"]]
        words = f" {amount.format(trial['amount'])}" if amount else ""
        lines.append(f"  {trial['error']:.4f}  {name}{words} ({_behind(trial)}{', chosen' if trial['chosen'] else ''})")
    return lines


def _behind(trial: dict[str, Any]) -> str:
    if not trial["excess"]:
        return "best"
    # Settings for rounded coordinates have none.
    return f"{trial['excess'] / trial['uncertainty']:.1f} standard errors behind" if trial["uncertainty"] else "behind"
