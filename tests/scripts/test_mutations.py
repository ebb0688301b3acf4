"""Scripts damaged at random: each is read or refused, soon, and what is read is what another parser finds there."""

from __future__ import annotations

import random
from collections import Counter

import pytest
from hostile_scripts import MOST_SECONDS, OLD, mutant, verdict, wrong_reading

from pymeshfair.scripts import parse_script


def test_damaged_scripts_are_read_or_refused_soon() -> None:
    """Of 300 scripts none takes a second or raises anything but ScriptError, and none with a broken structure is read."""
    choose, count = random.Random(5), Counter[str]()
    for _ in range(300):
        word, seconds = verdict(mutant(choose, OLD))
        count[word] += 1
        assert seconds < MOST_SECONDS
    assert count.keys() == {"read", "upgraded", "refused"}


GOOD = OLD[0].replace(b"Remove Duplicated Vertex", b"Remove Duplicate Vertices")


@pytest.mark.parametrize(
    ("data", "wrong"),
    [
        (GOOD.replace(b"</FilterScript>", b""), "is not XML"),
        (GOOD.replace(b'<filter name="Remove Duplicate Vertices"/>', b'<filter name="Close Holes"/>'), "has other filters"),
        (GOOD.replace(b'value="3"', b'value="4"'), "another stepSmoothNum of Taubin Smooth"),
        (GOOD.replace(b'<filter name="Remove', b'words <filter name="Remove'), "has text"),
        (GOOD.replace(b'name="lambda"', b'name="mu"'), "other parameters of Taubin Smooth"),
        (GOOD.replace(b"</filter>", b"<Param><Param/></Param></filter>"), "other elements within a filter"),
    ],
)
def test_the_other_parser_sees_what_is_wrong(data: bytes, wrong: str) -> None:
    """The count would find a script that was read as another one."""
    read = parse_script(GOOD, "read")
    found = wrong_reading(data, read)
    assert found is not None
    assert wrong in found
