"""The constants of choosing that were tuned, each with the figure that it was found by. Lengths are in mean edges.

The table in docs/denoising.md says what the rules earn that they belong to.
"""

#: The median of the sizes of normally distributed values, over their standard deviation.
MEDIAN_OF_NORMAL = 0.6744897501960817

# Cross-validation.
#: Sets of held-out vertices: one in place of four costs 2 % of the mean angle; four and six leave 0.59 degrees of impulses on a
#: dodecahedron, eight 0.39.
MASKS = 8
#: Settings farther behind the best than so many standard errors are not tried further: three choose the same.
STAYS = 2.0
#: Deviations count up to so many medians: without it 1.18 to 1.23 with impulses on one vertex in twenty.
CLIP = 4.0
#: A larger share of flipped faces is too much where other settings predict as well and leave half of it: without it 1.73 and 2.17
#: on a bunny with sparse noise.
FLIPPED = 0.003

# No noise.
#: Noise that is weaker moves no vertex by a hundredth of an edge; surfaces without noise have less in the calmest part.
NO_NOISE = 0.01
#: Residuals of neighbours correlate by 0.115 and more on clean meshes, by less with noise of 0.1 edges on figures.
SURFACE = 0.1
#: Where neighbours correlate by less, and at most so many settings are within two standard errors, the choice is sure: within 5 %
#: of the best setting on nine of ten pairs; on three of four with any number, on half with 0.05 to 0.1.
SURE, RIVALS = 0.05, 2
#: In the calmest third by 0.173 and more on clean meshes, by up to 0.153 with weak noise that should go.
SURFACE_WHERE_CALM = 0.16
#: Two levels of noise that differ by more are two. Filters that take details err by 1.22 times the level of the noise and more,
#: others by up to 1.18. Beside what stands out of uneven noise vertices are 1.2 times as far off as elsewhere and more, beside
#: impulses up to 1.1 times: without it 8.3 in place of 1.3 on a gear with noise along one axis.
LARGER = 1.2
#: The calmest part, by which the noise is bounded from below.
CALMEST = 0.05
#: Even noise is so many times what the calmest part says: 1.2 to 1.5 on parts, figures and surfaces.
EVEN = 1.3
#: Details of clean surfaces have as much: deviations are not clipped below it, vertices are not far off, noise is not loud.
WEAK = 0.05

# Impulse noise.
#: More vertices stand out of impulse noise, half as many of uneven noise; of Gaussian noise up to 0.003, of clean meshes 0.007.
IMPULSIVE = 0.01
#: A vertex stands out if it is off by so many deviations of the mesh, and by as many times the median of its two rings.
STANDS_OUT = 3.0

# Correlated noise.
#: Maps of cameras: the mean of their normals is longer, 0.5 and more of noisy maps.
FACING = 0.4
#: So much of the squares of residuals is along one direction: maps of lenses of up to 45 degrees have 0.9 and more, others 0.6.
ON_LINES = 0.75
#: So many edges of a fused map are shorter than a quarter of the mean: 7 to 10 %, of other meshes up to 5.5 %.
CUT_OFF = 0.06
#: Vertices have so much noise of their own: depth maps 0.033, fused ones 0.02 and more, scanners' maps without noise up to 0.012,
#: fused scans that were smoothed 0.015.
OWN = 0.02
#: How much vertices are out of the steps of rounding counts on top of so many steps.
OUT_OF_STEP = 0.08
#: Rounding: so many of the faces lie within levels, 3 % with steps of a third of an edge, 80 % with steps of a whole one.
FLUSH = 0.01
#: Rounding leaves differences of fourth order of 1 / sqrt(12) steps, up to this factor: rounded surfaces have 0.9 to 1.9 times as
#: much, designed parts 0.4 and less, or 6.
ROUNDED = 2.0

# Clouds.
#: Clouds have so much noise at least in the calmest part, in spacings; exact surfaces and smoothed scans less than half.
CLOUD_NO_NOISE = 0.03
#: Neighbours correlate by -0.2 to -0.1 with independent noise; by up to 0.28 where it is strong.
CLOUD_INDEPENDENT = -0.085
#: Noise of more than half a spacing has so much in the calmest part: a quarter of the points then decides.
CLOUD_THICK = 0.33
