"""What `--json` prints is JSON for any value that a command may hold."""

from __future__ import annotations

import enum
import json
import math
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from pymeshfair.commands.streams import plain, print_document


class Colours(enum.IntFlag):
    """Bits, like those of MeshLab."""

    RED = 1
    BLUE = 4


@dataclass(frozen=True)
class Point:
    """A record with a path in it."""

    x: float
    file: Path


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (None, None),
        (True, True),
        (3, 3),
        (0.1, 0.1),
        (math.nan, None),
        (-math.inf, None),
        (np.float32(0.5), 0.5),
        (np.float64("nan"), None),
        (np.bool_(True), True),
        (np.arange(4).reshape(2, 2), [[0, 1], [2, 3]]),
        (Path("a") / "b.ply", str(Path("a") / "b.ply")),
        (MappingProxyType({1: (2.0, math.inf)}), {"1": [2.0, None]}),
        (Colours.RED | Colours.BLUE, ["RED", "BLUE"]),
        (Colours(0), []),
        (Point(1.5, Path("c")), {"x": 1.5, "file": "c"}),
        (3 + 4j, "(3+4j)"),
    ],
    ids=repr,
)
def test_every_value_becomes_json(value: Any, expected: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """Numbers that JSON lacks are null, records are objects, the unknown is text; what is printed reads back the same."""
    assert plain(value) == expected
    print_document({"value": value})
    assert json.loads(capsys.readouterr().out, parse_constant=pytest.fail) == {"value": expected}


def test_bool_is_no_number() -> None:
    """True stays true: a reader of the document may rely on the kind."""
    assert plain(True) is True
    assert plain(np.bool_(False)) is False
