"""Results are the same to the bit for any number of threads."""

from __future__ import annotations

import sys

import pytest

from pymeshfair.filters.compilation import allowed_threads, set_threads
from tests.contracts.scenes import apply, scene_for
from tests.contracts.variants import Variant, each_variant, outcome_of


@pytest.mark.skipif(allowed_threads() < 2, reason="one thread is all there is")
@each_variant
def test_two_threads_give_the_same_bits(variant: Variant, monkeypatch: pytest.MonkeyPatch) -> None:
    """As one thread does, on which so small a mesh is usually filtered."""
    expected = outcome_of(variant)
    monkeypatch.setattr("pymeshfair.filters.execution.SERIAL_BELOW", 0)
    for name, module in list(sys.modules.items()):
        if name.startswith("pymeshfair.filters.") and hasattr(module, "FITS_IN_CACHE"):
            monkeypatch.setattr(module, "FITS_IN_CACHE", 0)
    before = allowed_threads()
    set_threads(2)
    try:
        found = apply(variant.declared, scene_for(variant.declared), variant.values)
    finally:
        set_threads(before)
    assert found.differences(expected) == []
