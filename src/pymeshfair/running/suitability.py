"""Ranks recipes by how well they suit a scan: compares the scan's traits with the conditions in the heads of recipes."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from types import MappingProxyType
from typing import Any, TypeAlias

from ..errors import RunError
from ..files.formats import attributes_of
from ..recipe import TASKS, Recipe, RecipeHead, RecipeInfo, shipped_heads
from ..scripts.guards import ARTICLE, UNKNOWN, Condition
from .measuring import MeasuredMesh

#: the traits that must be measured on the surface, up to some tenths of a second each; `MeasuredMesh` gives the others
MEASURED = ("noise", "sharpness", "facing", "camera noise", "longest edge")

_TEXTURED = ("textures", "wedge texture coordinates", "vertex texture coordinates")
#: the tasks whose recipes may replace each other; and all tasks whose recipes may be replaced
_ALIKE = ("denoise", "smooth")
_REPLACEABLE = (*_ALIKE, "clean")
#: why a recipe has nothing to do, by the trait that shows it
_NO_NEED = {"border edges": "there is nothing to close", "triangle quality": "the triangles are good as they are"}

#: the sort key of a recipe, see `ranked`
_Key: TypeAlias = tuple[bool, int, bool, bool, float, bool, int, int]
#: tasks that come last in a tie; and tasks that close openings with surface that was not measured
_ASIDE, _CLOSING = ("remesh", "change the shape", "curves", "look"), ("repair", "prepare")
ERASED = 0.1  # a recipe that removes more than this share of the relief (the detail of the surface) erases detail


@dataclass(frozen=True)
class Trial:
    """A trial of a recipe on a sample of a scan, lengths in mean edges."""

    error: float  # the prediction error at held-out vertices, along the normals; on a scan without noise the displacement
    before: float  # the same error of the scan as it is
    relief: float | None  # the share of the relief that is lost; None if the noise hides all relief or has impulses
    relief_from: float = 0.0  # the shortest wavelength that the noise does not hide; 0 if it hides none, or all
    tied: bool = False  # whether the error is statistically equal to the least error of all trials

    @property
    def erases(self) -> bool:
        return self.relief is not None and self.relief > ERASED

    @property
    def words(self) -> str:
        if self.error == self.before == 0.0:
            return "it would move nothing, as there is no noise"
        unseen = "; the noise hides the relief: look whether the result keeps it" if self.before else ""
        hidden = f" with waves from {self.relief_from:g} edges; the noise hides shorter ones" if self.relief_from else ""
        relief = unseen if self.relief is None else f", and would take {self.relief:.0%} of the relief{hidden}"
        if self.before == 0.0:
            return f"there is hardly any noise: it would move vertices by {self.error:.2g} edges{relief}"
        return f"tried here, it has an error of {self.error:.3f} edges (the scan as it is: {self.before:.3f}){relief}"


@dataclass(frozen=True)
class Suitability:
    """The suitability of a recipe for a scan."""

    recipe: str  # its name
    task: str
    title: str
    measure: str  # the measure by which the recipe is judged; empty if its head names none
    met: tuple[tuple[str, str], ...]  # the conditions that the scan meets, each with `Condition.found`
    unmet: tuple[tuple[str, str], ...]
    trial: Trial | None = None  # the result on a sample of the scan, if the recipe was tried

    @property
    def made_for(self) -> int:
        """The number of met conditions that do not begin with the word "no"."""
        return sum(not text.startswith("no ") for text, _ in self.met)

    @property
    def fits(self) -> bool:
        return bool(self.met) and not self.unmet


def traits_of(scan: MeasuredMesh, wanted: Collection[str] = MEASURED) -> dict[str, float]:
    """The traits of a scan by name, see `pymeshfair.scripts.guards`; of `MEASURED` only the wanted ones."""
    mesh, measures = scan.mesh, scan.measures
    assert measures is not None
    traits_of_mesh = _kind(measures.faces, measures.edges) | {
        "vertices": measures.vertices,
        "faces": measures.faces,
        "pieces": measures.components,
        "border edges": measures.border_edges,
        "closed": float(measures.closed),
        "texture": float(not attributes_of(mesh).isdisjoint(_TEXTURED)),
    }
    if measures.triangle_quality is not None:
        traits_of_mesh["triangle quality"] = measures.triangle_quality
    if measures.faces and (names := set(MEASURED).intersection(wanted)):
        from ..filters.traits import measured_traits

        traits_of_mesh |= measured_traits(mesh.vertices, mesh.faces, names, mean_edge=measures.mean_edge)
    return traits_of_mesh


def judged(name: str, info: RecipeInfo, traits: Mapping[str, float]) -> Suitability:
    """The suitability of a recipe for a scan."""
    met = [(c.text, c.found(traits)) for c in info.conditions if c.is_met(traits)]
    unmet = [(c.text, c.found(traits)) for c in info.conditions if not c.is_met(traits)]
    return Suitability(name, info.task, info.title, info.measure, tuple(met), tuple(unmet))


def ranked(
    traits: Mapping[str, float], heads: Sequence[RecipeHead] | None = None, tried: Mapping[str, Trial] = MappingProxyType({})
) -> list[Suitability]:
    """All shipped recipes, the most suitable first.

    Recipes that fit come first; the others follow by their number of unmet conditions. Ties are broken in this order:
    1. Tasks in `_ASIDE` come last. 2. Recipes that erase detail in their trial come last. 3. The smaller error in the
    trial wins; an error tied with the least counts as the least. Without a trial the error of the scan itself counts. 4. On
    an open scan tasks that close openings come last. 5. More met conditions without "no" win. 6. The order of the tasks
    decides. A recipe with "after ANOTHER" in its head comes right after ANOTHER if both fit.
    """
    heads = shipped_heads() if heads is None else heads
    behind = {head.name: head.info.behind for head in heads}
    verdicts = {head.name: replace(judged(head.name, head.info, traits), trial=tried.get(head.name)) for head in heads}
    least = min((trial.error for trial in tried.values()), default=0.0)
    unmoved = max((trial.before for trial in tried.values()), default=0.0)
    is_open = traits.get("border edges", 0.0) > 0.0

    def key(suited: Suitability) -> _Key:
        erases = suited.trial is not None and suited.trial.erases
        error = unmoved if suited.trial is None else least if suited.trial.tied else suited.trial.error
        aside, closes = suited.task in _ASIDE, is_open and suited.task in _CLOSING
        listed = TASKS.index(suited.task) if suited.task in TASKS else len(TASKS)
        return not suited.fits, len(suited.unmet), aside, erases, error, closes, -suited.made_for, listed

    def place(suited: Suitability) -> tuple[_Key, bool, int, str]:
        leader = verdicts.get(behind[suited.recipe])
        # A follower (a recipe "after" another one) with a better key brings its leader forward.
        bound = [v for v in verdicts.values() if v.fits and suited.fits and (v is leader or behind[v.recipe] == suited.recipe)]
        return min(map(key, [suited, *bound])), leader in bound, -suited.made_for, suited.recipe

    return sorted(verdicts.values(), key=place)


def unsuitable(name: str, info: RecipeInfo, traits: Mapping[str, float], others: Iterable[Suitability]) -> str | None:
    """The warning, with advice, if a scan does not meet the conditions of a recipe; `others` is the result of `ranked`."""
    verdict = judged(name, info, traits)
    if not verdict.unmet:
        return None
    reasons = [c for c in verdict.unmet if c[0] in _kind(0, 0)] or [c for c in verdict.unmet if not c[1].endswith(UNKNOWN)]
    mismatch = "; ".join(f"{name} is for {_in_words(text)}, and here {value}" for text, value in (reasons or verdict.unmet)[:2])
    fitting = [other for other in others if other.fits and other.recipe != name]
    tasks = _ALIKE if info.task in _ALIKE else (info.task,)
    denoiser = next((other for other in fitting if other.task == "denoise"), None)
    unmet = [condition.trait for condition in info.conditions if not condition.is_met(traits)]
    no_need = {_NO_NEED.get(trait) for trait in unmet if trait != "noise"}
    if info.task not in _ALIKE and denoiser is not None and "noise" in unmet and None not in no_need:
        return f"{mismatch}: run {denoiser.recipe} first"
    if info.task in _ALIKE and denoiser is None and "noise" in traits:
        return f"{mismatch}: it needs no smoothing"
    if no_need and None not in no_need:
        return f"{mismatch}: {' and '.join(sorted(filter(None, no_need)))}"
    # Recipes judged by different measures do not replace each other: one may remove noise, the other waves below a given size.
    same_measure = [other for other in fitting if not info.measure or other.measure == info.measure]
    substitutes = [other for other in same_measure if other.task in tasks and len(other.met) > 1]
    if substitutes and info.task in _REPLACEABLE:
        return f"{mismatch}: take {substitutes[0].recipe}"
    example = f", such as {fitting[0].recipe}" if fitting else ""
    return f"{mismatch}: no other recipe replaces it; `pymeshfair suggest` names recipes that fit{example}"


def traits_asked_for(recipe: Recipe, scan: MeasuredMesh, *, as_shipped: bool) -> tuple[dict[str, float], str | None]:
    """The traits that a recipe asks for, all if it does not fit the scan; a warning if so, or if a denoising recipe is better.

    A scan without measures gives no warnings. A recipe is compared with denoisers if its head says "after ANOTHER", or if its
    task is "smooth" and it is `as_shipped`: the user has set no value. `RunError`: the recipe is for another kind of data.
    """
    info = recipe.info
    traits = _kind(len(scan.mesh.faces), len(scan.mesh.edges))
    is_other = any(not condition.is_met(traits) for condition in info.conditions if condition.text in traits)
    if not info.conditions or (scan.measures is None and not is_other):
        return {}, None
    if scan.measures is not None:
        for_noise = bool(info.behind) or (info.task == "smooth" and as_shipped)
        asked = needed(info.conditions) | ({"noise"} if for_noise else set())
        traits |= traits_of(scan, asked)
        if not judged(recipe.name, info, traits).unmet:
            better = next((s.recipe for s in ranked(traits) if s.fits and s.task == "denoise"), "") if for_noise else ""
            if better in ("", recipe.name):
                return traits, None
            noise = f"there is noise of {traits['noise']:.2g} edges: to remove only that"
            return traits, f"{noise}, {better} mostly keeps more of the shape; `pymeshfair suggest` ranks both here"
        traits |= traits_of(scan, set(MEASURED) - asked)
    warning = unsuitable(recipe.name, info, traits, ranked(traits))
    if is_other:
        raise RunError(warning or "")
    return traits, warning


def instead(recipe: Recipe, scan: MeasuredMesh) -> str:
    """The recipe to take in place of one that has changed a scan's shape too much; empty if none is known to be better."""
    if scan.measures is None or recipe.info.task not in _REPLACEABLE:
        return ""
    smoothing = [s.recipe for s in ranked(traits_of(scan)) if s.fits and s.task in _ALIKE]
    return "" if recipe.name in smoothing[:1] else next(iter(smoothing), "")


def needed(conditions: Iterable[Condition]) -> set[str]:
    """The traits of `MEASURED` in these conditions."""
    return {condition.trait for condition in conditions} & set(MEASURED)


def documents(recipes: Iterable[Suitability]) -> list[dict[str, Any]]:
    """The result of `ranked`, as dictionaries that JSON can hold."""
    return [
        {
            "recipe": s.recipe,
            "title": s.title,
            "task": s.task,
            "fits": s.fits,
            "met": [{"condition": text, "found": value} for text, value in s.met],
            "unmet": [{"condition": text, "found": value} for text, value in s.unmet],
            "trial": None if s.trial is None else asdict(s.trial),
        }
        for s in recipes
    ]


def _kind(faces: int, edges: int) -> dict[str, float]:
    """The kind of a scan, as traits; a recipe for another kind cannot run."""
    return {"mesh": float(faces > 0), "cloud": float(not faces and not edges), "curves": float(not faces and edges > 0)}


def _in_words(text: str) -> str:
    kinds = {"mesh": "meshes", "cloud": "clouds of points", "curves": "curves", "range map": "range maps"}
    word = text.removeprefix("no ")
    if word.startswith(ARTICLE):
        return f"a {word}"
    if word in kinds:
        return kinds[word] if word == text else f"scans that are no {kinds[word]}"
    if word in ("closed", "open", "sharp", "smooth"):
        return f"{word} shapes" if word == text else f"shapes that are not {word}"
    if word == text:
        return "shapes with texture" if word == "texture" else word
    return f"shapes without {word}"
