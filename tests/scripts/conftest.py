"""Makes the filter with a parameter of every kind known to the scripts, as if a plugin declared it."""

from __future__ import annotations

import pytest

from pymeshfair.declaration import Filter
from pymeshfair.registry import find_filter
from tests.scripts.texts import apply_coord_every_kind


@pytest.fixture(autouse=True)
def _every_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    def find(name: str) -> Filter:
        known = apply_coord_every_kind
        return known if name in (known.name, known.python_name) else find_filter(name)

    monkeypatch.setattr("pymeshfair.scripts.read.find_filter", find)
