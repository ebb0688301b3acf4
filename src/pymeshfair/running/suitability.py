"""The recipes that suit a scan: its traits, compared with the conditions in the heads of recipes."""

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

#: the traits that are measured on the surface, each in some tenths of a second at most; the others are known anyway
MEASURED = ("noise", "sharpness", "facing", "camera noise", "longest edge")

#: the attributes of a mesh with a texture
_TEXTURED = ("textures", "wedge texture coordinates", "vertex texture coordinates")
#: tasks that may replace each other, and all whose recipes may replace another one of the same task
_ALIKE = ("denoise", "smooth")
_REPLACEABLE = (*_ALIKE, "clean")


#: the reason why a recipe has nothing to do, by the trait that shows it
_NO_NEED = {"border edges": "there is nothing to close", "triangle quality": "the triangles are good as they are"}

#: the order of recipes
_Key: TypeAlias = tuple[bool, int, bool, bool, float, bool, int, int]
#: tasks that replace or change what was scanned, or do not clean it; and those that close openings, with surface that was not
#: measured
_ASIDE, _CLOSING = ("remesh", "change the shape", "curves", "look"), ("repair", "prepare")
#: relief that may go: more is detail that is erased
ERASED = 0.1


@dataclass(frozen=True)
class Trial:
    """A trial of a recipe on a sample of a scan, lengths in mean edges."""

    error: float  # at vertices that were held out, along the normals; on a scan without noise how far the others were moved
    before: float  # the same of the scan as it is
    relief: float | None  # the share of the relief that went; None where there is none that stands out from the noise
    relief_from: float = 0.0  # the shortest waves that count there; 0 for all
    tied: bool = False  # whether held-out vertices cannot tell it from the best

    @property
    def erases(self) -> bool:
        """Whether detail is lost that is no noise."""
        return self.relief is not None and self.relief > ERASED

    @property
    def words(self) -> str:
        """The trial in words."""
        if self.error == self.before == 0.0:
            return "it would move nothing, as there is no noise"
        unseen = ", and the relief is too low beside the noise to be measured: look at the result" if self.before else ""
        hidden = f" from {self.relief_from:g} edges on, shorter relief being hidden by the noise" if self.relief_from else ""
        kept = unseen if self.relief is None else f", and would take {self.relief:.0%} of the relief{hidden}"
        if self.before == 0.0:
            return f"there is hardly any noise: it would move vertices by {self.error:.2g} edges{kept}"
        return f"tried here, it misses vertices by {self.error:.3f} edges, the scan as it is by {self.before:.3f}{kept}"


@dataclass(frozen=True)
class Suitability:
    """The conditions of a recipe that a scan meets or not."""

    recipe: str  # its name
    task: str  # that of the recipe
    title: str  # its title
    measure: str  # by which it is judged, empty if it does not say
    met: tuple[tuple[str, str], ...]  # the conditions that the scan meets, each with what was found
    unmet: tuple[tuple[str, str], ...]  # those that it does not
    trial: Trial | None = None  # the result on a sample of the scan, if it was tried

    @property
    def made_for(self) -> int:
        """The number of met conditions without "no"."""
        return sum(not text.startswith("no ") for text, _ in self.met)

    @property
    def fits(self) -> bool:
        """Whether the recipe is for the scan."""
        return bool(self.met) and not self.unmet


def traits_of(scan: MeasuredMesh, wanted: Collection[str] = MEASURED) -> dict[str, float]:
    """The traits of a scan by name, as `pymeshfair.scripts.guards` means them; those of `MEASURED` only if they are wanted."""
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
    """All shipped recipes, those first that fit, and of these first the ones that are made for most of what the scan is.

    Where recipes were tried those come first that leave the least error, or cannot be told from it, one that was not tried
    counting as one that moves nothing, and behind all others those that erase detail. Among equals those come last that repair or
    prepare a scan with openings: whether these are to be closed, the scan does not say. Then a recipe is the better known to fit
    the more conditions it sets, those of what a scan must not be aside; then the order is that of the tasks.
    One that says that it is judged after another comes after that, if it fits too. Recipes that do not fit come by how little is
    in the way.
    """
    heads = shipped_heads() if heads is None else heads
    behind = {head.name: head.info.behind for head in heads}
    verdicts = {head.name: replace(judged(head.name, head.info, traits), trial=tried.get(head.name)) for head in heads}
    least = min((trial.error for trial in tried.values()), default=0.0)
    of_nothing = max((trial.before for trial in tried.values()), default=0.0)
    is_open = traits.get("border edges", 0.0) > 0.0

    def key(suited: Suitability) -> _Key:
        erases = suited.trial is not None and suited.trial.erases
        error = of_nothing if suited.trial is None else least if suited.trial.tied else suited.trial.error
        aside, closes = suited.task in _ASIDE, is_open and suited.task in _CLOSING
        return not suited.fits, len(suited.unmet), aside, erases, error, closes, -suited.made_for, _place(suited.task)

    def place(suited: Suitability) -> tuple[_Key, bool, int, str]:
        better = verdicts.get(behind[suited.recipe])
        after = better is not None and better.fits and suited.fits
        # What is made for more of the scan lifts the better one, too.
        lifted = [
            key(verdicts[name]) for name in verdicts if behind[name] == suited.recipe and verdicts[name].fits and suited.fits
        ]
        leader = better if after and better is not None else suited
        group = min([key(leader), *lifted, *([key(suited)] if after else [])])
        return group, after, -suited.made_for, suited.recipe

    return sorted(verdicts.values(), key=place)


def unsuitable(name: str, info: RecipeInfo, traits: Mapping[str, float], others: Iterable[Suitability]) -> str | None:
    """The warning for a scan that a recipe is not for, with the recipe to take; None if it suits, or does not say.

    It takes all traits of the scan, and the `others` as `ranked` gives them.
    """
    verdict = judged(name, info, traits)
    if not verdict.unmet:
        return None
    reasons = [c for c in verdict.unmet if c[0] in _kind(0, 0)] or [c for c in verdict.unmet if not c[1].endswith(UNKNOWN)]
    reasons = reasons or list(verdict.unmet)
    wrong = "; ".join(f"{name} is for {_asked(text)}, and here {value}" for text, value in reasons[:2])
    fitting = [other for other in others if other.fits and other.recipe != name]
    alike = _ALIKE if info.task in _ALIKE else (info.task,)
    first = next((other for other in fitting if other.task == "denoise"), None)
    unmet = [condition.trait for condition in info.conditions if not condition.is_met(traits)]
    nothing = {_NO_NEED.get(trait) for trait in unmet if trait != "noise"}
    if info.task not in _ALIKE and first is not None and "noise" in unmet and None not in nothing:
        return f"{wrong}: run {first.recipe} first"
    if info.task in _ALIKE and first is None and "noise" in traits:
        return f"{wrong}: it needs no smoothing"
    if nothing and None not in nothing:
        return f"{wrong}: {' and '.join(sorted(filter(None, nothing)))}"
    # What takes away waves of a given size is no substitute for what takes away noise.
    judged_alike = [other for other in fitting if not info.measure or other.measure == info.measure]
    same = [other for other in judged_alike if other.task in alike and len(other.met) > 1]
    if same and info.task in _REPLACEABLE:
        return f"{wrong}: take {same[0].recipe}"
    named = f", such as {fitting[0].recipe}" if fitting else ""
    return f"{wrong}: no other recipe of its kind fits; `pymeshfair suggest` names those that do{named}"


def traits_asked_for(recipe: Recipe, scan: MeasuredMesh, *, as_shipped: bool) -> tuple[dict[str, float], str | None]:
    """The traits of a mesh that a recipe asks for, and a warning if it is not for such scans.

    Args:
        recipe: the recipe.
        scan: the mesh; if it was not measured, there are no warnings.
        as_shipped: whether nothing of the recipe was set. Who sets what smooths asks for what goes.

    Raises:
        RunError: it is of another kind: a cloud where a recipe is for meshes, or the other way round.
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
            alone = f"there is noise of {traits['noise']:.2g} edges: where that alone is to go"
            return traits, f"{alone}, {better} mostly keeps more of the shape; `pymeshfair suggest` ranks both here"
        traits |= traits_of(scan, set(MEASURED) - asked)
    warning = unsuitable(recipe.name, info, traits, ranked(traits))
    if is_other:
        raise RunError(warning or "")
    return traits, warning


def instead(recipe: Recipe, scan: MeasuredMesh) -> str:
    """The recipe to take where one that takes away noise has changed the shape of a scan too much; empty if that is the first."""
    if scan.measures is None or recipe.info.task not in _REPLACEABLE:
        return ""
    suited = ranked(traits_of(scan))
    alike = [s.recipe for s in suited if s.fits and s.task in _ALIKE]
    return "" if recipe.name in alike[:1] else next(iter(alike), "")


def needed(conditions: Iterable[Condition]) -> set[str]:
    """The traits that must be measured on the surface to judge these conditions."""
    return {condition.trait for condition in conditions} & set(MEASURED)


def documents(recipes: Iterable[Suitability]) -> list[dict[str, Any]]:
    """The result of `ranked` in terms of JSON."""
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
    """The traits without which a recipe cannot work at all."""
    return {"mesh": float(faces > 0), "cloud": float(not faces and not edges), "curves": float(not faces and edges > 0)}


def _place(task: str) -> int:
    return TASKS.index(task) if task in TASKS else len(TASKS)


def _asked(text: str) -> str:
    nouns = {"mesh": "meshes", "cloud": "clouds of points", "curves": "curves", "range map": "range maps", "texture": "textures"}
    adjectives = ("closed", "open", "sharp", "smooth")
    plain = text.removeprefix("no ")
    if plain.startswith(ARTICLE):
        return f"a {plain}"
    noun = nouns.get(plain, f"{plain} shapes" if plain in adjectives else plain)
    if plain != text:
        return f"shapes without {noun}" if plain not in adjectives else f"shapes that are not {plain}"
    return noun
