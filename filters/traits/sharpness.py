"""How much of the bending of a surface lies at sharp edges, noise aside."""

import numpy as np

from ..denoising import filter_face_normals
from ..diffusion import taubin_fairing
from ..evidence import Sample
from ..geometry import edge_lengths
from ..topology import face_adjacency

# Noise from so many edges is taken off by as many pairs of Taubin's steps, less noise by fewer; then normals are averaged over
# two rings with those that differ by less than 0.7, some 40 degrees, so that edges stay and the rest becomes even. More steps, or
# a wider kernel, round the edges of a dodecahedron, of 63 degrees.
_STRONG, _STEPS = 0.1, 5
_PASSES, _CUT_OFF, _REACH = 6, 0.7, 2.0
#: radians between two normals from which on their edge is sharp
_SHARP = np.radians(30.0)


def sharpness(sample: Sample, noise: float) -> float:
    """The share of sum t l that lies at edges of t >= 30 degrees.

    t is the angle between the filtered normals of the two faces of an edge, l the length of the edge.

    Args:
        sample: of `sample_of`.
        noise: of `surface_noise`; what is to be taken off first.

    Returns:
        1 of a cube, 0 of a finely meshed sphere, pi r / (pi r + h) of a finely meshed cylinder. Machine parts have 0.7 to 0.95
        under noise of up to 0.5 edges, figures, bodies and land up to 0.66. 0 of a plane.
    """
    points, faces = sample.points, sample.faces
    pairs, shared = face_adjacency(faces)
    if not len(pairs):
        return 0.0
    steps = round(_STEPS * min(1.0, noise / _STRONG))
    smoothed = taubin_fairing(points, faces, iterations=steps, border="along") if steps else points
    normals = filter_face_normals(
        smoothed,
        faces,
        method="bilateral",
        range_kernel="tukey",
        range_sigma=_CUT_OFF,
        space_sigma=_REACH,
        neighborhood="two_ring",
        normal_iterations=_PASSES,
    )
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    angles = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), np.einsum("ij,ij->i", first, second))
    bending = angles * edge_lengths(points, shared)
    total = float(bending.sum())
    # What planes bend is the rounding of a file.
    return float(bending[angles >= _SHARP].sum()) / total if total > 1e-6 * len(bending) else 0.0
