"""What the contracts show to be wrong today; every line goes with the defect."""

from __future__ import annotations

import re

import pytest

#: patterns of test names, and what is wrong
DEFECTS: dict[str, str] = {
    r"stray_vertex.*bilateral_(fleishman|jones).*-1e(16|9)": "recentred about the box of all vertices, those without a face too",
    r"stray_vertex.*coord_normal_filtering": "the reported drift is a mean over vertices without a face, too",
    r"stray_vertex.*tangential": "a mean over all vertices decides on the last bit",
    r"million_diagonals.*normal_filtering|million_diagonals.*normal_robust": "noise is measured far from the origin",
    r"scaled.*surface_spectrum": "the bisection for the stiffest vertices begins at an absolute number, so that sizes differ by a percent",
    r"rises.*bilaplacian|rises.*region_fairing|rises.*bridge": "progress ends before 1",
    r"rises.*spectral_filter-method=eigenvectors": "progress goes back",
    r"selection_of_nothing.*normal_robust": "a selection of no faces changes nothing without a word",
    r"same_words\[bilaplacian_smoothing-weight": "a weight that is no number says nothing of itself",
    r"same_words\[bilateral_.*-(range_kernel|space_kernel|iterations|neighbors)": "other words, or none",
    r"same_words\[(normal_filtering|filter_face_normals)-.*iterations": "2.0 iterations are an error of range, or none",
    r"same_words\[(improve_triangles|tangential_smoothing)-iterations": "2.0 iterations are an error of range",
    r"same_words\[(spectral_filter-order|one_harmonic-mode|close_holes-rounds)": "2.0 is taken for 2, and True for 1",
    r"same_words\[local_outlier": "other words",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Expect the tests of known defects to fail, strictly: one that passes is an error until its line has gone."""
    for item in items:
        for pattern, reason in DEFECTS.items():
            if re.search(pattern, item.name):
                item.add_marker(pytest.mark.xfail(reason=reason, strict=True))
