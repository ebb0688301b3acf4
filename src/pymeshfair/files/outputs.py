"""Checks of the files that a run writes: the output, the files beside it, and maps. A repeated run may replace its own files."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .errors import OutputError
from .formats import MISSING_LASPY, WRITABLE, extension
from .provenance import provenance_path, read_provenance, recorded_digest, sha256_of
from .writing import OVERWRITE, check_kind, check_place


@dataclass(frozen=True)
class MadeFrom:
    """The sources of an output. Runs with equal sources may replace the files of each other."""

    input: Path
    recipe: str  # the SHA-256 digest of the recipe
    others: tuple[Path, ...] = ()  # the files of further layers

    def differs(self, record: Mapping[str, Any] | None) -> str | None:
        """The reason why a provenance record does not belong to a run with these sources; None if it does."""
        if record is None:
            return "no provenance says that a run wrote it"
        source = Path(str(record["input"].get("path")))
        if not _same_file(source, self.input):
            return f"was made from another input, {source}"
        others = [Path(str(other.get("path"))) for other in record["input"].get("others", ())]
        if len(others) != len(self.others) or not all(map(_same_file, others, self.others)):
            return "was made with other layers"
        recipe = record.get("recipe")
        if not isinstance(recipe, dict) or recipe.get("sha256") != self.recipe:
            return "was made by another recipe, or with other settings"
        return None


def check_output(output: Path, made_from: MadeFrom, *, overwrite: bool, formats: Collection[str] = tuple(WRITABLE)) -> None:
    """Raise if the output of a run cannot or must not be written, before any work is done.

    Without `overwrite` an existing file is replaced only if a run with the same sources wrote it: its provenance names the same
    input and recipe, and its digest is the recorded one. So a command can be repeated, and no other file is lost.
    """
    check_kind(output, formats)
    if output.name.lower().endswith(".copc.laz"):
        raise OutputError(output, "COPC files are read and not written; name the output .laz")
    if extension(output) in ("las", "laz") and find_spec("laspy") is None:
        raise OutputError(output, MISSING_LASPY)
    files = [output, provenance_path(output), *([material_path(output)] if extension(output) == "obj" else [])]
    existing = [path for path in files if check_place(path)]
    if overwrite:
        return
    if output in existing and output.samefile(made_from.input):
        raise OutputError(output, f"it is the input; {OVERWRITE}")
    _check_former(existing, read_provenance(output), made_from)


def check_maps(maps: Sequence[Path], output: Path, made_from: MadeFrom, *, overwrite: bool) -> None:
    """Refuse intervention maps that cannot or must not be written, by the rules of `check_output`."""
    for path in maps:
        check_kind(path, ("ply",))
        if path == output or _same_file(path, made_from.input):
            raise OutputError(path, "it is the input or the output of the run; name another file for the map")
    existing = [path for path in maps if check_place(path)]
    if not overwrite:
        _check_former(existing, read_provenance(output), made_from)


def _check_former(existing: Sequence[Path], record: Mapping[str, Any] | None, made_from: MadeFrom) -> None:
    """Refuse to replace files that are not, byte for byte, those of a run with the same sources."""
    for path in existing:
        reason = made_from.differs(record)
        if reason is None and not path.name.endswith(".provenance.json") and sha256_of(path) != recorded_digest(record, path):
            reason = "has been changed since a run wrote it"
        if reason:
            raise OutputError(path, f"it exists and {reason}; {OVERWRITE}")


def _same_file(one: Path, other: Path) -> bool:
    return one == other or (one.exists() and other.exists() and one.samefile(other))


def material_path(output: Path) -> Path:
    """The material file that MeshLab writes beside an OBJ file."""
    return output.with_name(f"{output.name}.mtl")
