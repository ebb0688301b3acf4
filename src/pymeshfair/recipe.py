"""Recipes: the scripts that pymeshfair ships and those of users, with the words at their head."""

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
from .mlx_scripts import WITHDRAWN
from .scripts.changing import override
from .scripts.guards import Condition, parse_fits
from .scripts.read import parse_document, parse_script, read_bytes
from .scripts.script import KEYWORDS, Change, Script, Setting, paragraphs
from .scripts.upgrade import upgrade_script
from .scripts.write import format_script

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

#: the tasks of recipes, in the usual order of work
TASKS = ("clean", "denoise", "smooth", "repair", "prepare", "remesh", "change the shape", "curves", "look")


@dataclass(frozen=True)
class RecipeInfo:
    """The comment at the head of a recipe, taken apart: a title, and paragraphs that begin with one of `KEYWORDS`, if at all."""

    title: str = ""  # the first line
    purpose: str = ""  # for which scans the recipe is (``For:``)
    does: str = ""  # its effect on them (``Does:``)
    tune: str = ""  # the settings to change when the result is not right (``Tune:``)
    task: str = ""  # its task (``Task:``), one of `TASKS` for shipped recipes
    fits: str = ""  # for which scans the recipe is, in numbers (``Fits:``); `pymeshfair.scripts.guards.parse_fits` reads it
    judged: str = ""  # by what measure it is the best choice for these (``Judged:``)
    superseded: str = ""  # the better choice (``Superseded:``), of a recipe that is kept only because it was shipped once

    @property
    def measure(self) -> str:
        """The measure by which it is judged, the first word of `judged`; empty if it says none."""
        return re.match(r"\w*", self.judged)[0]  # type: ignore[index]

    @property
    def behind(self) -> str:
        """The recipe that is better by that measure, after which this one comes: ``Judged: normals, after denoise``; or empty."""
        match = re.search(r"\bafter (\w+)", self.judged)
        return match[1] if match else ""

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """For which scans the recipe is; none if it does not say, or says it in words that are no conditions."""
        try:
            return parse_fits(self.fits)
        except ParameterError:
            return ()  # a comment may say anything; `script_warnings` tells


@dataclass(frozen=True)
class Recipe:
    """A checked chain of filters with a name."""

    name: str  # a shipped recipe's name, or the path of a script without its folder and ``.mlx``
    script: Script  # the steps
    changes: tuple[Change, ...] = ()  # how the script that was read was upgraded; empty if it was not

    @cached_property
    def text(self) -> str:
        """The script as an .mlx file has it, every value said."""
        return format_script(self.script)

    @property
    def digest(self) -> str:
        """The SHA-256 digest of that, by which the provenance of a run names the recipe."""
        return hashlib.sha256(self.text.encode("utf-8")).hexdigest()

    @property
    def info(self) -> RecipeInfo:
        """The words at the head of the script, taken apart."""
        return head_info(self.script.comment)

    @property
    def title(self) -> str:
        """The first line of the head comment; the name if there is none."""
        return self.info.title or self.name

    @property
    def description(self) -> str:
        """The head comment without its title."""
        return self.script.comment.partition("\n")[2].strip()

    def override(self, overrides: Sequence[str]) -> Recipe:
        """The recipe with these values over its own, as `pymeshfair.scripts.changing.override` puts them."""
        return replace(self, script=override(self.script, overrides))


def shipped_recipes(*, superseded: bool = False) -> tuple[str, ...]:
    """The names of the recipes that pymeshfair ships, or of those that it ships because it once did, in alphabetical order."""
    return tuple(sorted(_scripts("superseded" if superseded else ".")))


@dataclass(frozen=True)
class RecipeHead:
    """The head of a shipped recipe, read without its filters."""

    name: str  # under which it is loaded
    info: RecipeInfo  # the words at its head
    settings: tuple[Setting, ...]  # the values that have a name
    steps: int  # how many filters it has


def shipped_heads() -> list[RecipeHead]:
    """The heads of all shipped recipes; reads no declaration, so no plugin and no compiled code is loaded."""
    documents = ((name, parse_document(file.read_bytes(), file.name)) for name, file in sorted(_scripts().items()))
    return [RecipeHead(name, head_info(read.comment), tuple(read.settings), len(read.filters)) for name, read in documents]


def load_recipe(name_or_path: str | os.PathLike[str], *, upgrade: bool = False) -> Recipe:
    """A shipped recipe by its name, or a script by its path; a path ends in ``.mlx`` or has a folder.

    With `upgrade` a script of an older MeshLab is brought up to date; the recipe's `changes` say how. Raises `UnknownNameError`
    where there is no such recipe or file, `ScriptError` with every problem of the script.
    """
    text = os.fspath(name_or_path)
    path = Path(text)
    shipped = _scripts()
    if isinstance(name_or_path, str) and (file := shipped.get(text) or _scripts("superseded").get(text)):
        return Recipe(text, parse_script(file.read_bytes(), file.name, path=Path(str(file))))
    if path.suffix.lower() == ".mlx" or path.name != text or path.is_file():
        return parse_recipe(read_bytes(text), text, upgrade=upgrade, path=path)
    if text in WITHDRAWN:
        raise UnknownNameError(f"the recipe {text!r} is shipped no more: {WITHDRAWN[text]}")
    near = nearest(text, shipped)
    meant = f"; did you mean {near!r}?" if near else ""
    listed = f"shipped: {', '.join(sorted(shipped))}; a script of your own is given by its path, with .mlx"
    raise UnknownNameError(f"there is no recipe {text!r}{meant} ({listed})", suggestion=near)


def parse_recipe(data: bytes, name: str, *, upgrade: bool = False, path: Path | None = None) -> Recipe:
    """The recipe in the bytes of an .mlx file; `name` stands for the file in messages, and `upgrade` is that of `load_recipe`."""
    if not upgrade:
        return Recipe(Path(name).stem, parse_script(data, name, path=path))
    upgraded = upgrade_script(data, name, path=path)
    return Recipe(Path(name).stem, upgraded.script, upgraded.changes)


def _scripts(folder: str = ".") -> dict[str, Traversable]:
    """The scripts in a folder of the shipped ones, by name."""
    files = (importlib.resources.files("pymeshfair.mlx_scripts") / folder).iterdir()
    return {file.name.removesuffix(".mlx"): file for file in files if file.name.endswith(".mlx")}


def head_info(comment: str) -> RecipeInfo:
    """The words of a head comment, taken apart."""
    title, _, rest = comment.partition("\n")
    words = paragraphs(rest)
    return RecipeInfo(title.strip(), **{"purpose" if word == "For" else word.lower(): words.get(word, "") for word in KEYWORDS})
