"""Reads scenes in VRML 2.0, or X3D in the same words, and gives MeshLab one whose textures were found and checked."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from .announced import Announced
from .errors import ContentsError
from .given import Given, find_textures
from .instances import MIRRORED
from .references import References
from .scene import Scene, check_type

_SPECIAL = re.compile(r'"(?:[^"\\]|\\.)*"|#[^\n\r]*|[\[\]{}"]', re.DOTALL)
_HEADS = ("#VRML V2.0 utf8", "#X3D V3")
#: what stands for every text that names no texture
_NOTHING = "nothing"


def inspect_vrml(path: Path, references: References, given: Given) -> Announced:
    """Read a scene; what it declares.

    Raises:
        ContentsError: it is none, or names what is not there.
        InputError: it names a file that must not be opened.
    """
    text = path.read_bytes().decode("utf-8", "surrogateescape")
    head = re.split(r"[\r\n]", text, maxsplit=1)[0]
    if not head.startswith(_HEADS) or "\0" in text:
        raise ContentsError(f"it does not begin with {' or '.join(_HEADS)}; older ones are not known")
    scene, tokens = Scene(), list(_tokens(text))
    named = _follow(scene, tokens)
    textures = find_textures([unquote(tokens[k][1:-1]) for k in named if tokens[k][1:-1].strip()], references)
    known = {t.name: t.given for t in textures}
    for k, token in enumerate(tokens):
        if token.startswith('"'):  # MeshLab must not take any other text for the name of a file
            tokens[k] = f'"{known.get(unquote(token[1:-1]), _NOTHING) if k in named else _NOTHING}"'
    given.link(textures)
    return Announced(
        normals=scene.normals,
        doubts=(MIRRORED,) if scene.mirrored else (),
        side_files=tuple(t.file for t in textures if t.file),
        textures=textures,
        reading=given.write("\n".join([head, *tokens, ""]).encode("utf-8", "surrogateescape")),
    )


def _tokens(text: str) -> Iterator[str]:
    """The brackets and texts, and between them words with a blank between any two; without comments."""
    position = 0
    for match in _SPECIAL.finditer(text):
        if words := " ".join(text[position : match.start()].replace(",", " ").split()):
            yield words
        position = match.end()
        token = match[0]
        if token == '"':
            raise ContentsError("it is cut short within a text")
        if not token.startswith("#"):
            yield token
    if words := " ".join(text[position:].replace(",", " ").split()):
        yield words


def _follow(scene: Scene, tokens: list[str]) -> set[int]:
    """Tell the nodes to a scene; which tokens are the names of files."""
    named: set[int] = set()
    lists: list[str] = []
    words: list[str] = []
    for k, token in enumerate(tokens):
        if token == "{":
            if not words:
                raise ContentsError("a node of it has no type")
            scene.begin(words[-1], words[-2] if len(words) >= 3 and words[-3] == "DEF" else "")
            words = []
        elif token == "}":
            scene.end()
            words = []
        elif token == "[":
            lists.append(words[-1] if words else "")
            words = []
        elif token == "]":
            if not lists:
                raise ContentsError("a list of it ends that has not begun")
            lists.pop()
            words = []
        elif token.startswith('"'):
            if (words[-1] if words else lists[-1] if lists else "") == "url":
                named.add(k)
        elif lists and lists[-1] and k + 1 < len(tokens) and tokens[k + 1] == "]" and tokens[k - 1] == "[":
            scene.field(lists[-1], token)
        else:
            words = token.split()
            _look(scene, words)
    if lists:
        raise ContentsError("it is cut short within a list")
    scene.finish()
    return named


def _look(scene: Scene, words: list[str]) -> None:
    """What words say that stand outside of lists of values."""
    for k, word in enumerate(words):
        check_type(word)
        if word == "USE" and k + 1 < len(words):
            scene.use(words[k + 1])
        elif word == "scale" and k + 3 < len(words):
            scene.field(word, " ".join(words[k + 1 : k + 4]))
        elif word.endswith("PerVertex") and k + 1 < len(words):
            scene.field(word, words[k + 1])
