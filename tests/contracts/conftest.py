"""What the contracts show to be wrong today; every line goes with the defect."""

from __future__ import annotations

import re

import pytest

#: patterns of test names, and what is wrong
DEFECTS: dict[str, str] = {
    r"same_words\[bilaplacian_smoothing-weight": "an infinite weight is no error: it returns the input",
    r"scaled.*surface_spectrum": "the search for the stiffest vertices begins at an absolute number: sizes differ by a percent",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Expect the tests of known defects to fail, strictly: one that passes is an error until its line has gone."""
    for item in items:
        for pattern, reason in DEFECTS.items():
            if re.search(pattern, item.name):
                item.add_marker(pytest.mark.xfail(reason=reason, strict=True))
