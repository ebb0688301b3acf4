"""The head of a script, read without a look at what its filters are."""

from __future__ import annotations

import re
from dataclasses import dataclass
from xml.parsers import expat

from .script import clean_comment
from .settings import Setting, read_setting

#: the words with which a paragraph of a head comment may begin, each followed by a colon
KEYWORDS = ("Task", "For", "Fits", "Judged", "Does", "Tune", "Superseded")


@dataclass(frozen=True)
class Head:
    """What a script says of itself.

    Attributes:
        comment: the words at its head.
        settings: the values that have a name.
        steps: how many filters it has.
    """

    comment: str
    settings: tuple[Setting, ...]
    steps: int


def read_head(data: bytes) -> Head:
    """The head of a well-formed script; nothing is checked, and what is wrong is left out."""
    comments: list[str] = []
    settings: list[Setting] = []
    filters: list[str] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag == "filter":
            filters.append(tag)
        elif tag == "setting" and (found := read_setting(attributes, parser.CurrentLineNumber)[0]) is not None:
            settings.append(found)

    parser = expat.ParserCreate()
    parser.CommentHandler = lambda text: None if filters else comments.append(text)
    parser.StartElementHandler = start
    parser.Parse(data, True)
    return Head(clean_comment("\n\n".join(comments)), tuple(settings), len(filters))


def paragraphs(text: str) -> tuple[dict[str, str], tuple[str, ...]]:
    """The paragraphs of a head comment without its title: those of `KEYWORDS` by their words, each once, and the others."""
    said: dict[str, str] = {}
    more: list[str] = []
    for paragraph in re.split(r"\n[ \t]*\n", text.strip()):
        plain = " ".join(paragraph.split())
        keyword, colon, words = plain.partition(":")
        if colon and keyword in KEYWORDS and keyword not in said:
            said[keyword] = words.strip()
        elif plain:
            more.append(plain)
    return said, tuple(more)
