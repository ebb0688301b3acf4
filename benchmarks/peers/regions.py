"""Contests of fairing a region and of filtering normals."""

from __future__ import annotations

from typing import Any

import fairing
import igl
import numpy as np

from pymeshfair.filters.denoising import normal_filtering
from pymeshfair.filters.fairing import fair_region
from pymeshfair.filters.fairing.region import ENERGIES, Energy

from .contest import Contest, Floats, Peer, Preparation, Subject, Work
from .explicit import meshlab, vertices_of


def ours(energy: Energy) -> Preparation:
    """Our fairing, on the patch alone as the others."""

    def prepare(subject: Subject) -> Work:
        vertices, faces, free = fairing.cropped(subject.vertices, subject.faces, subject.free)
        return lambda: fair_region(vertices, faces, free, energy=energy).vertices[free]

    return prepare


def libigl(order: int) -> Preparation:
    """Libigl's, on the patch alone."""

    def prepare(subject: Subject) -> Work:
        vertices, faces, free = fairing.cropped(subject.vertices, subject.faces, subject.free)
        fixed = np.flatnonzero(~free).astype(np.int64)
        return lambda: igl.harmonic(vertices, faces.astype(np.int64), fixed, vertices[fixed], order)[free]

    return prepare


def cgal(subject: Subject) -> Work:
    """CGAL's thin plate, on the patch alone."""
    processing, polyhedron, chosen = fairing.polyhedron_of(*fairing.cropped(subject.vertices, subject.faces, subject.free))

    def work() -> Any:
        processing.fair(polyhedron, chosen, 1)
        return np.array([(p.point().x(), p.point().y(), p.point().z()) for p in chosen])

    return work


def our_normals(subject: Subject) -> Work:
    """Twenty passes over the normals of faces that share a vertex, twenty steps of the vertices."""
    mesh = subject.vertices, subject.faces
    return lambda: normal_filtering(*mesh, neighborhood="vertex", normal_iterations=20, vertex_iterations=20)


def as_floats(result: Any) -> Floats:
    """The places of the free vertices."""
    return np.asarray(result, dtype=np.float64)


#: shares of processor time, 10,000 free vertices
BOUNDS: dict[Energy, str] = {
    "membrane": "No single part. Of 19 ms of processor time the order takes 2.4, the pattern of the factors 0.7, the factors "
    "4, two solves 2.3, a residual in twice the precision 1, the operator 3, finding and checking the region 2; libigl takes "
    "22 to 25, 8 of them for the operator. The factors wait for memory: without arithmetic they take 2.7 ms.",
    "thin_plate": "Order and factors by fronts, 0.4; two solves and two residuals in twice the precision, a quarter.",
    "minimum_variation": "Order and factors by fronts, 0.45; two solves and two residuals in twice the precision, a quarter.",
}

CONTESTS = (
    *(
        Contest(
            f"fairing, {energy.replace('_', ' ')}",
            ours(energy),
            BOUNDS[energy],
            {
                "libigl": Peer(libigl(order), "igl", agrees=agrees, goal=goal),
                **({"CGAL": Peer(cgal, "CGAL", goal=4.0)} if order == 2 else {}),
            },
            subject="sheet",
            sizes=(1_000, 10_000),
            orders=("scan",),
            result=as_floats,
            tiny=100,
        )
        for order, (energy, goal, agrees) in enumerate(zip(ENERGIES, (1.2, 1.5, 1.5), (1e-8, 1e-6, 1e-3), strict=True), start=1)
    ),
    Contest(
        "two-step normals, 20 + 20",
        lambda s: (
            lambda: normal_filtering(s.vertices, s.faces, neighborhood="vertex", normal_iterations=20, vertex_iterations=20)
        ),
        "The passes over the normals: twelve faces around each, whose rows are gathered one number at a time, and a kernel for "
        "each pair. In the order of subdivision they wait for memory: sorted by place a pass over a million faces takes 0.54 of "
        "the time, a step of the vertices 0.3.",
        {
            "pymeshlab": Peer(
                meshlab("apply_coord_two_steps_smoothing", stepsmoothnum=1, stepnormalnum=20, stepfitnum=20),
                "pymeshlab",
                goal=3.0,
            )
        },
        sizes=(10_000, 100_000, 500_000),
        orders=("scan",),
        result=vertices_of,
    ),
)
