"""Scripts damaged at random: each is read or refused, soon, and an upgrade never accepts what reading its result refuses."""

from __future__ import annotations

import random
import time

from pymeshfair.scripts import ScriptError, format_script, parse_script, upgrade_script
from tests.scripts.texts import script

SEEDS = (
    script(
        '<filter name="Taubin Smooth">',
        '<Param type="RichFloat" name="lambda" value="0.25" description="d" tooltip="t"/>',
        '<Param type="RichInt" name="stepSmoothNum" value="3"/>',
        "</filter>",
        '<filter name="Remove Duplicated Vertex"/>',
    ),
    script(
        '<xmlfilter name="Screened Poisson Surface Reconstruction"><xmlparam name="depth" value="6"/></xmlfilter>',
        '<filter name="Delete Current Mesh"/>',
        '<filter name="Compute normals for point sets">',
        '<Param type="RichPoint3f" x="0" y="0" z="0" name="viewPos"/></filter>',
    ),
)
PIECES = (
    b"<",
    b">",
    b'"',
    b"&",
    b"/",
    b"\0",
    b"\xff",
    b"name",
    b"value",
    b"<filter",
    b"</filter>",
    b"<Param/>",
    b"nan",
    b"-1",
    b"]]>",
)
#: seconds; the whole test is bounded, so that a slow machine tries fewer scripts
BUDGET, MOST_SECONDS = 4.0, 1.0


def mutant(choose: random.Random) -> bytes:
    """A script with up to four places deleted, doubled, overwritten or filled in."""
    data = bytearray(choose.choice(SEEDS))
    for _ in range(choose.randint(1, 4)):
        start = choose.randrange(len(data) + 1)
        end = min(len(data), start + choose.choice((0, 1, 5, 40)))
        new = choose.choice((b"", bytes(data[start:end]) * 2, choose.choice(PIECES), bytes([choose.randrange(256)])))
        data[start:end] = new
    return bytes(data)


def test_damaged_scripts_are_read_or_refused_soon() -> None:
    """No script takes a second or raises anything but ScriptError; one that is accepted means the same when written again."""
    choose, began, tried, refused, read = random.Random(5), time.monotonic(), 0, 0, 0
    while tried < 10_000 and time.monotonic() - began < BUDGET:
        data, started = mutant(choose), time.process_time()
        tried += 1
        try:
            upgraded = upgrade_script(data, "mutant").script
        except ScriptError as error:
            refused += bool(error.problems)
        else:
            text = format_script(upgraded, known_mesh=False).encode()
            assert parse_script(text, "again") == upgraded.with_defaults(lengths=False)
            read += 1
        assert time.process_time() - started < MOST_SECONDS, data
    assert refused > 0
    assert read > 0
    assert refused + read == tried
