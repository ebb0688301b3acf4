"""Reads the head of a script (comment, settings, number of steps) without finding its filters."""

import re
from dataclasses import dataclass
from xml.parsers import expat

from .script import clean_comment
from .settings import Setting, read_setting

#: the words with which a paragraph of a head comment may begin, each followed by a colon
KEYWORDS = ("Task", "For", "Fits", "Judged", "Does", "Tune", "Superseded")


@dataclass(frozen=True)
class Head:
    """The head of a script."""

    comment: str  # the comments before its first filter
    settings: tuple[Setting, ...]  # its named settings
    steps: int  # the number of its filters


def read_head(data: bytes) -> Head:
    """The head of a well-formed script, without checks; invalid settings are left out."""
    comments: list[str] = []
    settings: list[Setting] = []
    filters: list[str] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag == "filter":
            filters.append(tag)
        elif tag == "setting" and (setting := read_setting(attributes, parser.CurrentLineNumber)[0]) is not None:
            settings.append(setting)

    parser = expat.ParserCreate()
    parser.CommentHandler = lambda text: None if filters else comments.append(text)
    parser.StartElementHandler = start
    parser.Parse(data, True)
    return Head(clean_comment("\n\n".join(comments)), tuple(settings), len(filters))


def paragraphs(text: str) -> tuple[dict[str, str], tuple[str, ...]]:
    """The paragraphs of a head comment without its title: the first for each of `KEYWORDS`, by keyword, and all others."""
    by_keyword: dict[str, str] = {}
    others: list[str] = []
    for paragraph in re.split(r"\n[ \t]*\n", text.strip()):
        plain = " ".join(paragraph.split())
        keyword, colon, words = plain.partition(":")
        if colon and keyword in KEYWORDS and keyword not in by_keyword:
            by_keyword[keyword] = words.strip()
        elif plain:
            others.append(plain)
    return by_keyword, tuple(others)
