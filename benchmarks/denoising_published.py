"""What others reach on the pairs that papers use, in degrees of MAD, tuned per mesh against the truth unless said."""

from __future__ import annotations

#: who computed a value, and from what
SOURCES = {
    "Sun 2007": "fast and effective feature-preserving mesh denoising; the C++ code of Zhang et al. 2015",
    "Zheng 2011": "bilateral normal filtering; the C++ code of Zhang et al. 2015",
    "Zhang 2015": "guided mesh normal filtering; the authors' C++ code",
    "He & Schaefer 2013": "mesh denoising via L0 minimisation; an open C++ code",
    "NLLR": "Li et al. 2018, non-local low-rank normal filtering; the authors' mesh, not tuned here",
    "GCN-Denoiser": "Shen et al. 2022; the authors' mesh, not tuned here",
    "MeshTGV": "Liu et al. 2021, total generalised variation; the authors' mesh, not tuned here",
    "MeshLib": "MeshLib 3.1, meshDenoiseViaNormals, the best of five settings",
    "MeshLab Taubin": "MeshLab's filter, the number of steps tuned",
    "prototype": "a first version of our own normal filtering, tuned: what ours must reach when tuned",
}

MAD: dict[str, dict[str, float]] = {
    "fandisk_n3": {
        "Sun 2007": 3.62,
        "Zheng 2011": 3.38,
        "Zhang 2015": 2.56,
        "He & Schaefer 2013": 2.71,
        "MeshLib": 6.21,
        "MeshLab Taubin": 9.34,
        "prototype": 1.92,
    },
    "block_n4": {
        "Sun 2007": 5.78,
        "Zheng 2011": 5.48,
        "Zhang 2015": 3.65,
        "MeshLib": 9.73,
        "MeshLab Taubin": 10.56,
        "prototype": 2.88,
    },
    "sharpsphere_n3": {
        "Sun 2007": 7.05,
        "Zheng 2011": 6.59,
        "Zhang 2015": 7.70,
        "MeshLib": 13.61,
        "MeshLab Taubin": 10.18,
        "prototype": 5.23,
    },
    "twelve_i5": {
        "Sun 2007": 6.72,
        "Zheng 2011": 6.92,
        "Zhang 2015": 3.25,
        "MeshLib": 8.09,
        "MeshLab Taubin": 8.41,
        "prototype": 1.96,
    },
    "fandisk_n7": {"MeshLib": 24.76, "MeshLab Taubin": 12.13, "prototype": 5.00},
    "bunny_n2": {"MeshLab Taubin": 5.80, "prototype": 5.08},
    "julius_n2": {"NLLR": 6.10, "MeshLab Taubin": 5.76, "prototype": 5.60},
    "nicolo_n2": {"MeshLib": 7.53, "MeshLab Taubin": 6.15, "prototype": 5.61},
    "fertility_n3": {"GCN-Denoiser": 4.01, "MeshLib": 8.61, "MeshLab Taubin": 4.34, "prototype": 3.77},
    "child_n3": {"NLLR": 6.70, "MeshLab Taubin": 6.56, "prototype": 6.31},
    "kinect_cone": {"MeshTGV": 7.23, "MeshLab Taubin": 10.06, "prototype": 7.72},
}

#: denoisers of papers: what counts as published, before smoothers and packages
PAPERS = ("Sun 2007", "Zheng 2011", "Zhang 2015", "He & Schaefer 2013", "NLLR", "GCN-Denoiser", "MeshTGV")


def best_published(pair: str) -> tuple[float, str] | None:
    """The least MAD of a paper's method, or of MeshLab's tuned Taubin filter where there is none, and whose it is."""
    known = MAD.get(pair, {})
    for names in (PAPERS, ("MeshLab Taubin",)):
        values = [(known[name], name) for name in names if name in known]
        if values:
            return min(values)
    return None
