"""The noise of a scan as recipes name it: what even noise would be, details and edges apart."""

import numpy as np

from ..denoising.designed import is_designed
from ..denoising.noise_level import estimate_noise, smooth_normals
from ..evidence import Sample, far_from_border, noise_floor

# Even noise is so many times what `noise_floor` says of it: 1.2 to 1.5 on parts, figures and surfaces, see `denoising.automatic`.
_EVEN = 1.3


def surface_noise(sample: Sample) -> float:
    """The standard deviation of the noise along the normals in mean edges: the smaller of two estimates.

    `estimate_noise` takes fine details for noise everywhere; `noise_floor` sees noise alone where the surface is calm, and 1.3
    times that is even noise. So fur and hair do not count as noise where the face is smooth.

    Args:
        sample: of `sample_of`.

    Returns:
        0 of planes as they were designed, and of a mesh without inner vertices.
    """
    if not len(sample.faces) or is_designed(sample.points, sample.faces):
        return 0.0
    level = estimate_noise(sample.points, sample.faces).level
    scored = far_from_border(sample.faces, len(sample.points))
    if not np.any(scored):
        return level
    normals = smooth_normals(sample.points, sample.faces)
    return min(level, _EVEN * noise_floor(sample.points, sample.faces, normals=normals, scored=scored))
