"""Tuned constants of the automatic choice of filters, each with the measurement behind it. Lengths are in mean edges.

A number after "without it" is the factor by which the mean angle, the mean error of face normals, is larger without the rule.
"""

#: The median absolute value of a normal distribution of standard deviation 1.
MEDIAN_OF_NORMAL = 0.6744897501960817
#: A setting is dropped if it is more than this many standard errors worse than the best. Not tuned: 3 gives the same choices.
STAYS = 2.0

# Cross-validation.
#: Number of sets of held-out vertices. The mean angle is 2 % larger with 1 set than with 4; a few meshes gain from 8 sets.
SETS = 8
#: Deviations are clipped at this multiple of their median: without it 1.18 to 1.23 with impulses on one vertex in twenty.
CLIP = 4.0
#: Number of held-out vertices near a vertex that give the median for `CLIP`. On a house with noise of 0.05 and 0.3 edges on its
#: halves the mean angle is 1.03 times that of the best setting, 1.7 with one median of all. Not tuned: 40 and 90 do as well.
NEAR = 60
#: A flipped face counts as a deviation of this size. Without it up to 2.8 with sparse noise; 0.2 to 0.5 choose alike.
FLIPPED = 0.3

# No noise.
#: A noise level below this counts as no noise. Clean surfaces have a level below this in their calm parts.
NO_NOISE = 0.01
#: Residuals of neighbours correlate by more than this on clean meshes (0.115 and up), by less on statues with noise of 0.1 edges.
SURFACE = 0.1
#: A choice is sure if no outlier is replaced, residuals correlate by less than `SURE`, and at most `RIVALS` settings, including
#: the best, are within two standard errors of it. 5 of 9 such choices are within 5 % of the least mean angle, 8 within 10 %.
SURE, RIVALS = 0.05, 2
#: As `SURFACE`, in the calmest third of a mesh: correlations are 0.173 and more on clean meshes, up to 0.153 with weak noise.
SURFACE_WHERE_CALM = 0.16
#: Two levels differ if their ratio is larger than this. The prediction error of filters that remove details is at least 1.22
#: times the noise level, that of others up to 1.18. In uneven noise, residuals beside outliers are over 1.2 times the others.
LARGER = 1.2
#: The share of the mesh that counts as its calmest part. The noise there is a lower bound of the noise of the mesh.
CALMEST = 0.05
#: Where noise is equally strong everywhere, its level is this multiple of the level in the calmest part (measured: 1.2 to 1.5).
EVEN = 1.3
#: The size of details on clean surfaces. Smaller deviations are not clipped, not far in `far_from`, and no sign of uneven noise.
WEAK = 0.05

# Impulse noise.
#: The least share of outliers in impulse noise; in uneven noise it is half of this. Gaussian noise has a share of 0.003.
IMPULSIVE = 0.01
#: The residual of an outlier exceeds this multiple of two values: the standard deviation, and the median in its two rings.
STANDS_OUT = 3.0

# Correlated noise.
#: The area-weighted mean of the face normals of a depth map is longer than this: 0.5 and more for noisy maps.
FACING = 0.4
#: Depth maps have over this share of squared residuals in one direction: 0.9 or more (lens angle up to 45 degrees); others 0.6.
ON_LINES = 0.75
#: A map fused from depth maps has over this share of edges shorter than 1/4 of the mean edge: 7 to 10 %; others up to 5.5 %.
CUT_OFF = 0.06
#: Noisy maps have at least this much independent noise (0.02 and more); maps without noise and smoothed fused maps up to 0.015.
INDEPENDENT = 0.02
#: On solids it is doubtful whether there is correlated noise if `fall_of_growth` is between this and 1. Clean scans have up to
#: 0.94, one of 139 has 0.97; noise that is averaged once over a vertex and its neighbours has 0.92 and more.
IN_DOUBT = 0.95
#: Rounding makes at least this share of faces perpendicular to its axis: 3 % with steps of 1/3 edge, 80 % with steps of 1 edge.
FLUSH = 0.01
#: Rounded if fourth-order differences are 1/3 to 3 times step / sqrt(12): scans 0.9 to 2.1, designed parts up to 0.1 or above 8.
ROUNDED = 3.0

# Clouds.
#: A cloud is clean if its calmest part has less noise than this, in spacings; exact surfaces and smoothed scans have up to 0.015.
CLOUD_NO_NOISE = 0.03
#: Residuals of neighbours correlate by less than this (-0.2 to -0.1) with independent noise, but by up to 0.28 with strong noise.
CLOUD_INDEPENDENT = -0.085
#: The noise in the calmest part if noise is half a spacing. Above it, if residuals correlate, filters are tried on fewer points.
CLOUD_THICK = 0.33
