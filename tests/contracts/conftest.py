"""What the contracts show to be wrong today; every line goes with the defect."""

from __future__ import annotations

import re

import pytest

#: patterns of test names, and what is wrong
DEFECTS: dict[str, str] = {
    r"stray_vertex.*tangential": "a mean over all vertices decides on the last bit",
    r"million_diagonals.*normal_filtering|million_diagonals.*normal_robust": "noise is measured far from the origin",
    r"scaled.*surface_spectrum": "the bisection for the stiffest vertices begins at an absolute number, so that sizes differ by a percent",
    r"rises.*bilaplacian|rises.*region_fairing|rises.*bridge": "progress ends before 1",
    r"rises.*spectral_filter-method=eigenvectors": "progress goes back",
    r"same_words\[bilaplacian_smoothing-weight": "a weight that is no number says nothing of itself",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Expect the tests of known defects to fail, strictly: one that passes is an error until its line has gone."""
    for item in items:
        for pattern, reason in DEFECTS.items():
            if re.search(pattern, item.name):
                item.add_marker(pytest.mark.xfail(reason=reason, strict=True))
