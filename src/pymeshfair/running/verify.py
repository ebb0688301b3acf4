"""Repeats a run from its provenance, and compares the outputs."""

import hashlib
import os
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ..errors import ParameterError, PymeshfairError
from ..files.errors import VerifyError
from ..files.inputs import read_file
from ..files.provenance import provenance_path, read_provenance, recorded_digest, sha256_of
from ..filters.libraries import spatial
from ..mesh_data import MeshData
from ..meshlab.facts import table
from ..processes.environment import versions
from ..recipe import Recipe, load_recipe, shipped_recipes
from ..scripts.guards import Guards
from ..scripts.read import parse_script
from .job import Event, Job
from .supervise import run_job

Verdict: TypeAlias = Literal[
    "identical", "within tolerance", "output changed", "input changed", "recipe changed", "other versions", "not repeated"
]


@dataclass(frozen=True)
class Verification:
    """The result of `verify_output`."""

    verdict: Verdict
    findings: tuple[str, ...] = ()  # sentences on what differs, and where
    notes: tuple[str, ...] = ()  # further sentences, for example on changes that made no difference


def verify_output(
    output: Path,
    *,
    recorded: bool = False,
    allow_outside: bool = False,
    unchecked: bool = False,
    timeout: float | None = None,
    memory_limit: int | None = None,
    on_event: Callable[[Event], None] = lambda event: None,
    by_tiles: Callable[[Job, Callable[[Event], None]], object] = run_job,
) -> Verification:
    """Check an output against the provenance beside it, repeat the run, and compare the outputs.

    The provenance may come from a stranger. So the recipe in the provenance must equal the shipped recipe or the recipe's file,
    unless `recorded` is True. `allow_outside` and `unchecked`, which weaken the checks of a run, must be given again.
    """
    output = Path(output).absolute()
    record = read_provenance(output)
    if record is None:
        unknown = f"nothing is known of how it was made: no valid {provenance_path(output).name} is beside it"
        raise VerifyError(output, unknown if output.exists() else "there is no such file")
    with tempfile.TemporaryDirectory(prefix="pymeshfair-verify-") as folder:
        try:
            planned = _planned(output, record, Path(folder), recorded)
        except (KeyError, TypeError, AttributeError, ValueError, PymeshfairError) as error:
            raise VerifyError(provenance_path(output), f"it cannot be understood ({type(error).__name__}: {error})") from error
        if isinstance(planned, Verification):
            return planned
        allowed = {"allow_outside": allow_outside, "unchecked": unchecked}
        if missing := [f"--{name.replace('_', '-')}" for name, now in allowed.items() if getattr(planned.job, name) and not now]:
            raise ParameterError(f"the run was given {' and '.join(missing)}, which a provenance cannot allow: give it here, too")
        job = replace(planned.job, allow_outside=allow_outside, unchecked=unchecked, timeout=timeout, memory_limit=memory_limit)
        (by_tiles if "tiles" in record else run_job)(job, on_event)
        return _compared(output, record, planned)


class _Plan(NamedTuple):
    job: Job
    files: Sequence[str]  # the names of the output and its side files
    unrepeatable: Mapping[str, float]  # random filters, each with its tolerance in diagonals
    versions: Sequence[str]  # sentences on versions that have changed
    notes: Sequence[str]  # sentences on the recipe, a moved input and a new name of the output


def _planned(output: Path, record: Mapping[str, Any], folder: Path, recorded: bool) -> Verification | _Plan:
    """The changes since the run, or the plan to repeat it in `folder` with the old file names, which OBJ files contain."""
    entries = [record["output"], *record["output"].get("side_files", ())]
    names = [Path(entry["path"]).name for entry in entries]
    if not output.is_file():
        return Verification("output changed", (f"{output} is not there: it was removed, or its run was killed too early",))
    if changed := tuple(_changed([output, *(output.parent / name for name in names[1:])], entries)):
        return Verification("output changed", changed)
    read = [record["input"], *record["input"].get("others", ())]
    entries = [*read, *(side for entry in read for side in entry.get("side_files", ()))]
    paths, was, there = [Path(entry["path"]) for entry in entries], Path(record["output"]["path"]).parent, ""
    if not all(map(Path.is_file, paths)):
        together = [Path(os.path.normpath(output.parent / os.path.relpath(path, was))) for path in paths]
        if all(map(Path.is_file, together)):
            paths, there = together, f"the input is {together[0]}, which was moved or copied together with the output"
    if changed := tuple(_changed(paths, entries)):
        return Verification("input changed", changed)
    recipe, differs, source_of_recipe = _recipe(record["recipe"])
    if differs and not recorded:
        return Verification("recipe changed", (differs,))
    now, options = versions(), record.get("options", {})
    job = Job(
        recipe,
        paths[0],
        folder / names[0],
        others=tuple(paths[1 : len(read)]),
        guards=Guards.parse(record.get("guards", {}).get("limits", {})),
        keep_broken=True,
        **{name: options[name] for name in ("allow_outside", "unchecked", "own_texture_names", "unit") if name in options},
    )
    job = replace(job, measures=bool(job.all_guards) or "tiles" in record)  # the output does not depend on measures
    stem = job.output.stem
    # Makes files with the names that the first run found in use, so that textures are renamed in the same way.
    for name in names[1:]:
        if match := re.fullmatch(rf"{re.escape(stem)}-(?:(\d+)-)?(.+)", name):
            candidates = [match[2], f"{stem}-{match[2]}", *(f"{stem}-{k}-{match[2]}" for k in range(2, 100))]
            for occupied in candidates[: candidates.index(name) if name in candidates else None]:
                job.output.with_name(occupied).write_bytes(b"")
    tolerances, filters = table("unrepeatable")["apart"], [step.filter.python_name for step in recipe.script.steps]
    unrepeatable = {name: tolerances[name] for name in filters if name in tolerances}
    changes = [f"{name} was {old}, and is {now.get(name)}" for name, old in record["versions"].items() if old != now.get(name)]
    renamed = "" if output.name == names[0] else f"the run wrote it as {names[0]}"
    return _Plan(job, names, unrepeatable, changes, [text for text in (differs, source_of_recipe, there, renamed) if text])


def _compared(output: Path, record: Mapping[str, Any], plan: _Plan) -> Verification:
    path_of = {name: plan.job.output.with_name(name) for name in plan.files}
    different = [name for name, path in path_of.items() if not path.is_file() or sha256_of(path) != recorded_digest(record, path)]
    if not different:
        return Verification("identical", notes=(*plan.notes, *plan.versions))
    sentences = [f"{name} has other bytes" for name in different]
    if plan.unrepeatable:
        sentences.append(f"{', '.join(plan.unrepeatable)} gives another result each time")
        differences = list(_differences(read_file(output).mesh, read_file(plan.job.output).mesh, max(plan.unrepeatable.values())))
        if not differences:
            return Verification("within tolerance", notes=(*plan.notes, *plan.versions, *sentences))
        sentences += differences
    return Verification("other versions" if plan.versions else "not repeated", (*sentences, *plan.versions), tuple(plan.notes))


def _changed(paths: Iterable[Path], entries: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    for path, entry in zip(paths, entries, strict=True):
        if not path.is_file():
            yield f"{path} is not there any more"
        elif path.stat().st_size != entry["bytes"] or sha256_of(path) != entry["sha256"]:
            yield f"{path} is not what it was (its SHA-256 is different)"


def _recipe(entry: Mapping[str, Any]) -> tuple[Recipe, str, str]:
    """The recipe in a provenance; a sentence on how its file differs, or ""; a note with its file, or "" for a shipped recipe."""
    text, name = str(entry["text"]), str(entry["name"])
    recipe = Recipe(name, parse_script(text.encode("utf-8"), name))
    if hashlib.sha256(text.encode("utf-8")).hexdigest() != entry["sha256"]:
        return recipe, "the recipe in the provenance is not the one that was run: its SHA-256 is different", ""
    if entry["file"] is None:
        return recipe, "the recipe was not in a file: --recorded repeats the run with the one in the provenance", ""
    file = Path(entry["file"])
    shipped = load_recipe(name) if name in (*shipped_recipes(), *shipped_recipes(superseded=True)) else None
    # The file may be of an installation that is not on this computer.
    may_be_shipped = not file.is_file() and file.parent.name in ("mlx_scripts", "superseded")
    is_ours = shipped is not None and (file == shipped.script.path or may_be_shipped)
    if not is_ours and not file.is_file():
        return recipe, f"the recipe's file {file} is not there any more: --recorded takes the one in the provenance", ""

    def text_now(*, upgrade: bool) -> str:
        now = shipped if is_ours and shipped else load_recipe(file, upgrade=upgrade)
        return now.override(tuple(entry["overrides"])).text

    try:
        texts = [text_now(upgrade=True)]
    except PymeshfairError as error:
        return recipe, f"the recipe's file {file} cannot be read any more: {error}", ""
    with suppress(PymeshfairError):  # the run may have taken the script without an upgrade
        texts.append(text_now(upgrade=False))
    differs = "" if text in texts else f"the recipe's file {file} says something else than when it was run"
    return recipe, differs, "" if is_ours else f"the recipe is from {file}"


def _differences(one: MeshData, other: MeshData, tolerance: float) -> Iterator[str]:
    for kind, old, new in (("vertices", len(one.vertices), len(other.vertices)), ("faces", len(one.faces), len(other.faces))):
        if old != new:
            yield f"it had {old:,} {kind}, and has {new:,} now"
            return
    diagonal = float(np.linalg.norm(np.ptp(one.vertices, axis=0)))
    middles = [mesh.vertices[mesh.faces].mean(axis=1) for mesh in (one, other)]
    for kind, a, b in (("vertex", one.vertices, other.vertices), ("face", *middles)):
        far = max(float(spatial.cKDTree(q).query(p)[0].max()) for p, q in ((a, b), (b, a))) if len(a) else 0.0
        if far > tolerance * diagonal:
            words = f"a {kind} is {far / diagonal if diagonal else np.inf:.2g} diagonals from the nearest one of the other output"
            yield f"{words}; random differences are at most {tolerance:g}"
