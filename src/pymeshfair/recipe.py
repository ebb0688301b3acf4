"""Recipes: loads shipped and user scripts, and reads the comment at their head."""

from __future__ import annotations

import hashlib
import importlib.resources
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import ParameterError, UnknownNameError, nearest
from .mlx_scripts import WITHDRAWN as WITHDRAWN
from .scripts.changing import override
from .scripts.guards import Condition, parse_fits
from .scripts.read import parse_document, parse_script, read_bytes
from .scripts.script import KEYWORDS, Change, Script, Setting, paragraphs
from .scripts.upgrade import upgrade_script
from .scripts.warnings import traps
from .scripts.write import format_script

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

#: the tasks of recipes, in their usual order
TASKS = ("clean", "denoise", "smooth", "repair", "prepare", "remesh", "change the shape", "curves", "look")


@dataclass(frozen=True)
class RecipeInfo:
    """The comment at the head of a recipe: a title, and optional paragraphs that begin with one of `KEYWORDS`."""

    title: str = ""  # the first line
    purpose: str = ""  # ``For:``, the scans that the recipe is for
    does: str = ""  # ``Does:``, its effect
    tune: str = ""  # ``Tune:``, the values to change if the result is not right
    task: str = ""  # ``Task:``, one of `TASKS` for shipped recipes
    fits: str = ""  # ``Fits:``, the scans that the recipe is for, as conditions for `pymeshfair.scripts.guards.parse_fits`
    judged: str = ""  # ``Judged:``, the measure by which the recipe was compared with others, and a better recipe, if any
    superseded: str = ""  # ``Superseded:``, the better choice; only old recipes, which stay loadable, have it

    @property
    def measure(self) -> str:
        return re.match(r"\w*", self.judged)[0]  # type: ignore[index]

    @property
    def behind(self) -> str:
        """The recipe that is better by `measure`: ``denoise`` for ``Judged: normals, after denoise``; may be empty."""
        return match[1] if (match := re.search(r"\bafter (\w+)", self.judged)) else ""

    @property
    def conditions(self) -> tuple[Condition, ...]:
        try:
            return parse_fits(self.fits)
        except ParameterError:
            return ()  # comments may have any text; `script_warnings` reports the problem


@dataclass(frozen=True)
class Recipe:
    """A checked chain of filters with a name."""

    name: str  # the name of a shipped recipe, or the file name of a script without ``.mlx``
    script: Script
    changes: tuple[Change, ...] = ()  # how the script was upgraded; empty if it was not

    @cached_property
    def text(self) -> str:
        return format_script(self.script)

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.text.encode("utf-8")).hexdigest()

    @property
    def info(self) -> RecipeInfo:
        return head_info(self.script.comment)

    @property
    def title(self) -> str:
        """The first line of the head comment; the name if there is no comment."""
        return self.info.title or self.name

    @property
    def description(self) -> str:
        return self.script.comment.partition("\n")[2].strip()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings for every run: changes of meaning by the upgrade, and `traps`."""
        return (*(str(change) for change in self.changes if not change.same_meaning), *traps(self.script))

    def override(self, overrides: Sequence[str]) -> Recipe:
        return replace(self, script=override(self.script, overrides))


def shipped_recipes(*, superseded: bool = False) -> tuple[str, ...]:
    """The sorted names of the shipped recipes that are not superseded, or of the `superseded` recipes alone."""
    return tuple(sorted(_scripts("superseded" if superseded else ".")))


@dataclass(frozen=True)
class RecipeHead:
    """The head of a shipped recipe, read without loading plugins or compiled code."""

    name: str
    info: RecipeInfo
    settings: tuple[Setting, ...]
    steps: int  # number of filters


def shipped_heads() -> list[RecipeHead]:
    """Returns the heads of the shipped recipes that are not superseded."""
    documents = ((name, parse_document(file.read_bytes(), file.name)) for name, file in sorted(_scripts().items()))
    return [RecipeHead(name, head_info(read.comment), tuple(read.settings), len(read.filters)) for name, read in documents]


def load_recipe(name_or_path: str | os.PathLike[str], *, upgrade: bool = False) -> Recipe:
    """Loads a shipped recipe by its name, or a script by its path, which ends in ``.mlx``, has a folder or names a file.

    With `upgrade` it upgrades a script of an older MeshLab and lists the `changes` in the recipe. Raises `UnknownNameError` if
    there is no such recipe, and `ScriptError` with all problems of a script, such as a missing file.
    """
    text = os.fspath(name_or_path)
    path = Path(text)
    shipped = _scripts()
    if isinstance(name_or_path, str) and (file := shipped.get(text) or _scripts("superseded").get(text)):
        return Recipe(text, parse_script(file.read_bytes(), file.name, path=Path(str(file))))
    if path.suffix.lower() == ".mlx" or path.name != text or os.path.isfile(text):  # noqa: PTH113 - false if the name is too long
        return parse_recipe(read_bytes(text), text, upgrade=upgrade, path=path)
    if text in WITHDRAWN:
        raise UnknownNameError(f"the recipe {text!r} is no longer shipped: {WITHDRAWN[text]}")
    near = nearest(text, shipped)
    meant = f"; did you mean {near!r}?" if near else ""
    listed = f"shipped: {', '.join(sorted(shipped))}; a script of your own is given by its path, with .mlx"
    raise UnknownNameError(f"there is no recipe {text!r}{meant} ({listed})", suggestion=near)


def parse_recipe(data: bytes, name: str, *, upgrade: bool = False, path: Path | None = None) -> Recipe:
    """Parses the bytes of an .mlx file; `name` names the file in messages, `upgrade` is as for `load_recipe`."""
    if not upgrade:
        return Recipe(Path(name).stem, parse_script(data, name, path=path))
    upgraded = upgrade_script(data, name, path=path)
    return Recipe(Path(name).stem, upgraded.script, upgraded.changes)


def _scripts(folder: str = ".") -> dict[str, Traversable]:
    files = (importlib.resources.files("pymeshfair.mlx_scripts") / folder).iterdir()
    return {file.name.removesuffix(".mlx"): file for file in files if file.name.endswith(".mlx")}


def head_info(comment: str) -> RecipeInfo:
    """Parses a head comment."""
    title, words = comment.partition("\n")[0].strip(), paragraphs(comment)
    return RecipeInfo(title, **{"purpose" if word == "For" else word.lower(): words.get(word, "") for word in KEYWORDS})
