"""Tuned constants of the choice, each with the measurement behind it. Lengths are in mean edges.

A figure after "without it" is a ratio of mean angles, without the rule over with it; docs/denoising.md has a table of all rules.
"""

#: The median absolute value of a normal distribution of standard deviation 1.
MEDIAN_OF_NORMAL = 0.6744897501960817

# Cross-validation.
#: Number of sets of held-out vertices. One set in place of four costs 2 % of the mean angle. On a dodecahedron with impulses four
#: or six sets lead to 0.59 degrees, eight to 0.39.
MASKS = 8
#: A setting is dropped if it is more than this many standard errors behind the best. Three lead to the same choices.
STAYS = 2.0
#: Deviations are clipped at this multiple of the median: without it 1.18 to 1.23 with impulses on one vertex in twenty.
CLIP = 4.0
#: The median is that of so many held-out vertices around each: over all of them, a house with noise of 0.05 and 0.3 edges on its
#: halves ends at 1.8 in place of 1.06 times the best angle; 40 to 90 choose alike.
NEAR = 60
#: A setting that flips a larger share of faces loses to a rival that flips half as many: without it 1.73 and 2.17 on a bunny with
#: sparse noise.
FLIPPED = 0.003

# No noise.
#: A lower level is no noise: it moves no vertex by a hundredth of an edge, and clean surfaces have less in the calmest part.
NO_NOISE = 0.01
#: Residuals of neighbours correlate by more on clean meshes, by 0.115 and above; by less on figures with noise of 0.1 edges.
SURFACE = 0.1
#: A choice is sure if neighbours correlate by less and at most this many settings are within two standard errors. It is then
#: within 5 % of the best setting on nine of ten pairs; on three of four with any number of settings, on half with 0.05 to 0.1.
SURE, RIVALS = 0.05, 2
#: The same as `SURFACE` in the calmest third: clean meshes have 0.173 and more, weak noise that should go has up to 0.153.
SURFACE_WHERE_CALM = 0.16
#: Two noise levels differ if their ratio is larger. Filters that remove details err by at least 1.22 times the noise level, other
#: filters by up to 1.18 times. Residuals beside outliers are at least 1.2 times as large as elsewhere in uneven noise, up to 1.1
#: times for impulses; without this rule a gear with noise along one axis has 8.3 in place of 1.3.
LARGER = 1.2
#: The share of the mesh that counts as its calmest part. The noise there is a lower bound of the noise.
CALMEST = 0.05
#: Even noise is this multiple of the noise in the calmest part: 1.2 to 1.5 on parts, figures and surfaces.
EVEN = 1.3
#: The size of details on clean surfaces. Smaller deviations are neither clipped nor outliers, and show no uneven noise.
WEAK = 0.05

# Impulse noise.
#: Share of outliers. Impulse noise has more, uneven noise more than half; Gaussian noise has up to 0.003, clean meshes 0.007.
IMPULSIVE = 0.01
#: The residual of an outlier exceeds this multiple of the deviation of the mesh, and of the median of its two rings.
STANDS_OUT = 3.0

# Correlated noise.
#: The mean face normal of a camera's map is longer; noisy maps have 0.5 and more.
FACING = 0.4
#: Depth maps have a larger share of squared residuals along one direction: 0.9 and more for lenses up to 45 degrees. Others: 0.6.
ON_LINES = 0.75
#: A fused map has a larger share of edges shorter than a quarter of the mean: 7 to 10 %; other meshes have up to 5.5 %.
CUT_OFF = 0.06
#: Least independent noise of noisy maps: depth maps have 0.033, fused maps 0.02 and more. Scanners' maps without noise have up to
#: 0.012, smoothed fused scans 0.015.
OWN = 0.02
#: Added to the distance of vertices from their rounding intervals, in steps, before it is multiplied by the roughness.
OUT_OF_STEP = 0.08
#: A rounded mesh has at least this share of faces within levels: 3 % with steps of a third of an edge, 80 % with a whole edge.
FLUSH = 0.01
#: Rounded surfaces have differences of fourth order of 1 / sqrt(12) steps within this factor: 0.9 to 1.9 times as much. Designed
#: parts have up to 0.4 times or 6 times as much.
ROUNDED = 2.0

# Clouds.
#: A cloud with less noise in its calmest part, in spacings, is clean. Exact surfaces and smoothed scans have less than half.
CLOUD_NO_NOISE = 0.03
#: Independent noise gives a smaller correlation of neighbours, -0.2 to -0.1; strong noise gives up to 0.28.
CLOUD_INDEPENDENT = -0.085
#: Noise of half a spacing gives this level in the calmest part. Above it a quarter of the points decides.
CLOUD_THICK = 0.33
