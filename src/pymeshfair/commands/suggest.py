"""``pymeshfair suggest SCAN``: ranks recipes for a scan, and finds the best settings to denoise it."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .options import Json, Overwrite, Timeout
from .streams import STANDARD, check_text, print_document, print_lines, printable, save_text, say

if TYPE_CHECKING:
    from ..mesh_data import MeshData
    from ..recipe import Recipe
    from ..running.suitability import Trial

FILTER = "apply_coord_normal_filtering"  # the filter whose automatic parameters are made explicit

#: trials treat a scan without outliers as clean if its noise is below this, in mean edges: clean isosurfaces have up to 0.017
_MESHING = 0.018
_SHOWN = 6  # how many of the best settings are shown, besides the chosen one and the unfiltered scan
#: the smoothers that are compared: the name and the amount as shown
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
            help="Write a recipe that denoises SCAN, with explicit values; - is standard output.",
        ),
    ] = None,
    timeout: Timeout = None,
    overwrite: Overwrite = False,
    json: Json = False,
) -> None:
    """Rank all recipes for a scan, with reasons, and find the best settings to denoise it.

    The traits of the scan are compared with the conditions (Fits) in each recipe's head. Smoothing recipes are tried on a sample
    of the scan: those with the least error come first, those that erase detail last. The error at held-out vertices, which no
    filter sees, shows whether there is noise, and which settings remove it best. With -o, the best settings become a recipe.
    On this scan the new recipe has the same result as the recipe denoise. Low-pass smoothers are compared in the same way, each
    with its best amount for the scan.
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
            raise PymeshfairError(f"{scan} has no {'noise to remove' if values else 'faces'}: no recipe is written to {output}")
        save_text(format_script(recipe.script), output, overwrite=overwrite)
    traits_here = _by_evidence(traits, values)
    recipes = ranked(traits_here, tried={} if values is None else _trials(read.mesh, traits_here, values, recipe, timeout))
    if json:
        text = None if recipe is None else format_script(recipe.script)
        ranking = documents(recipes)
        print_document({"scan": scan, "traits": traits, "recipes": ranking, "found": values, "recipe": text, "output": output})
        return
    print_lines(fitting_lines(recipes), err=output == STANDARD)
    if values is None:
        return
    summary = _summary(scan, values, traits["noise"], traits_here["noise"])
    print_lines((summary, *_setting_lines(values), *_smoother_lines(values)), err=True)
    if output is not None and output != STANDARD:
        recipe_and_scan = shlex.join(f"./{path}" if str(path).startswith("-") else str(path) for path in (output, scan))
        say(f"{output}: written; `pymeshfair run {recipe_and_scan} -o RESULT` applies it", err=True)


def _by_evidence(traits: dict[str, float], values: dict[str, Any] | None) -> dict[str, float]:
    if values is None:
        return traits
    # ``drift`` is the mean displacement by `FILTER`. If impulses make it far larger than the trait noise, it replaces that trait.
    uneven = not traits.get("camera noise") and values["drift"] > 2.0 * traits["noise"]
    noise = 0.0 if values["shape"] == "clean" else values["drift"] if uneven else traits["noise"]
    return traits | {"camera noise": float(values["shape"] == "correlated"), "noise": noise}


def _tried(scan: Path, timeout: float | None) -> dict[str, Any]:
    from ..running.read import reported_values
    from .display import progress

    with progress() as show:
        return reported_values(scan, FILTER, {"compare": True}, timeout=timeout, on_event=show)


def _trials(
    mesh: MeshData, traits: dict[str, float], values: dict[str, Any], recipe: Recipe | None, timeout: float | None
) -> dict[str, Trial]:
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
    candidates = {name: load_recipe(name) for name in fitting}
    tried = {name: moving_script(c, chosen) for name, c in candidates.items() if c.info.behind not in fitting}
    scripts = {name: script for name, script in tried.items() if script is not None}
    clean = values["shape"] == "clean" or (traits["noise"] < _MESHING and values["outliers"] == "keep")
    results = trials(mesh.vertices, mesh.faces, scripts, clean=clean, timeout=timeout)
    if not is_correlated:
        return results
    # If neighbours share their noise, held-out vertices are no evidence, and waves of noise look like relief. So recipes with
    # `FILTER` get the error that `FILTER` reports for its best setting, and all other recipes at least the unfiltered error.
    filtered = {name for name, script in scripts.items() if any(step.filter is find_filter(FILTER) for step in script.steps)}
    # Rounded coordinates may make the error of the unfiltered scan too small; the noise is a lower bound.
    unfiltered = max(errors[0], traits["noise"])
    best = min(unfiltered, min(values["tried"], key=lambda trial: float(trial["excess"]))["error"])
    return {
        name: replace(
            trial, before=unfiltered, error=best if name in filtered else max(unfiltered, trial.error), relief=None, tied=False
        )
        for name, trial in results.items()
    }


def _explicit(scan: Path, values: dict[str, Any], noise: float) -> Recipe | None:
    from ..recipe import Recipe
    from ..registry import find_filter
    from ..scripts.script import Script, Step

    if values["shape"] == "clean":
        return None
    filter = find_filter(FILTER)
    step = Step(filter).with_values({p.name: values[p.name] for p in filter.parameters if p.name in values})
    name = printable(scan.name).replace("--", "- ").strip("-")
    comment = f"Denoises scans such as {name}\n\nFor: {_kind(values)}, with noise of {noise:.2g} edges."
    return Recipe("suggestion", Script((step,), comment))


def _summary(scan: Path, values: dict[str, Any], noise: float, ranked: float) -> str:
    if values["shape"] == "clean":
        surface = f"; what looks like noise of {noise:.2g} mean edges is the surface itself" if noise > 0.0 else ""
        return f"{scan}: no noise to remove, so it needs no smoothing{surface}"
    sure = "sure: the noise of neighbours is independent, and hardly any other setting is as good"
    unsure = "not sure: several settings are equally good, or details may look like noise; compare pictures"
    uneven = "" if ranked == noise else ", which counts as the noise in the ranking, since most noise is at few vertices"
    return (
        f"{scan}: {_kind(values)}; the noise along the normals is {noise:.2g} mean edges; removing it moves the "
        f"vertices by {values['drift']:.2g} mean edges on average{uneven}; the choice is {sure if values['sure'] else unsure}"
    )


def _kind(values: dict[str, Any]) -> str:
    is_independent = values["shape"] == "noisy"
    return f"a shape with noise {'that is independent at every vertex' if is_independent else 'that neighbours share'}"


def _setting_lines(values: dict[str, Any]) -> list[str]:
    tried = values.get("tried", [])
    if not tried:
        return []
    best = sorted(tried, key=lambda trial: trial["excess"])
    shown = [trial for k, trial in enumerate(best) if k < _SHOWN or trial["chosen"] or trial is tried[0]]
    criterion = "by their effect on the noise" if values["shape"] == "correlated" else "on held-out vertices"
    lines = [f"{len(tried)} settings that were not ruled out early were compared {criterion}; the errors in mean edges are:"]
    for trial in shown:
        parameters = trial["parameters"]
        steps = {"keep": [], "replace": ["outliers replaced"], "only": ["outliers alone replaced"]}[trial["outliers"]]
        steps = ["rounding undone", *steps] if trial["rounding"] == "undo" else steps
        if trial["relaxation"]:
            steps.append(f"{trial['relaxation']} pairs of Taubin steps")
        if parameters is not None:
            steps.append(
                f"{parameters['outer_iterations']} rounds of {parameters['method']} {parameters['range_kernel']} "
                f"{parameters['range_sigma']:g} over {parameters['neighborhood']}"
            )
        lines.append(f"  {trial['error']:.4f}  {', then '.join(steps) or 'nothing'} ({_behind(trial)})")
    return lines


def _smoother_lines(values: dict[str, Any]) -> list[str]:
    compared = values.get("smoothers", [])
    if not compared:
        return []
    lines = ["smoothers, each with the amount that suits this scan best; the errors in mean edges are:"]
    for trial in sorted(compared, key=lambda trial: trial["error"]):
        name, amount = _SMOOTHERS[trial["smoother"]]
        words = f" {amount.format(trial['amount'])}" if amount else ""
        lines.append(f"  {trial['error']:.4f}  {name}{words} ({_behind(trial)})")
    return lines


def _behind(trial: dict[str, Any]) -> str:
    behind = f"{trial['excess'] / trial['uncertainty']:.1f} standard errors behind" if trial["uncertainty"] else "behind"
    return (behind if trial["excess"] else "best") + (", chosen" if trial["chosen"] else "")
