"""Feature-preserving denoising by robust statistics of normals and neighbours."""

from .automatic import AutomaticChoice, automatic_choice, denoise_automatically
from .bilateral import JonesBorder, bilateral_fleishman, bilateral_jones
from .candidates import FIXED, REPERTOIRE, AutomaticParameters, Repertoire, Setting, SettingsTried
from .clouds import (
    CloudKernels,
    bilateral_projection,
    estimated_range_sigma,
    normals_of,
    projections,
    smoothed_directions,
    unit_normals,
)
from .completion import (
    NOTHING_TO_REMOVE,
    PREPARATION,
    Chooser,
    findings_of_choice,
    notes_of_choice,
    parameters_for_mesh,
    parameters_without_mesh,
    reported,
)
from .correlated_noise import shared_noise
from .face_neighbourhoods import Neighborhood
from .impulses import Outliers, replace_outlying
from .noise_level import NoiseEstimate, estimate_noise, noise_floor
from .normal_filter import SPACE_KERNELS, NormalFilter, NormalFilterMethod, RangeMeasure, SpaceKernel
from .normal_filtering import (
    distances_of_part,
    filter_face_normals,
    needs_distance,
    normal_filtering,
    rings_of_round,
    round_of_part,
)
from .preparation import (
    HALF_WAY,
    RINGS_OF_UNFOLDING,
    RelaxationDirection,
    causes_of_folds,
    denoised,
    direction_for,
    going_back,
    notes_on_folds,
    relaxed_part,
    rings_of_relaxation,
    share_along,
    unfolded,
)
from .rounding import RoundingPolicy
from .scan import Scan
from .vertex_update import VertexUpdate

__all__ = [
    "FIXED",
    "HALF_WAY",
    "NOTHING_TO_REMOVE",
    "PREPARATION",
    "REPERTOIRE",
    "RINGS_OF_UNFOLDING",
    "SPACE_KERNELS",
    "AutomaticChoice",
    "AutomaticParameters",
    "Chooser",
    "CloudKernels",
    "JonesBorder",
    "Neighborhood",
    "NoiseEstimate",
    "NormalFilter",
    "NormalFilterMethod",
    "Outliers",
    "RangeMeasure",
    "RelaxationDirection",
    "Repertoire",
    "RoundingPolicy",
    "Scan",
    "Setting",
    "SettingsTried",
    "SpaceKernel",
    "VertexUpdate",
    "automatic_choice",
    "bilateral_fleishman",
    "bilateral_jones",
    "bilateral_projection",
    "causes_of_folds",
    "denoise_automatically",
    "denoised",
    "direction_for",
    "distances_of_part",
    "estimate_noise",
    "estimated_range_sigma",
    "filter_face_normals",
    "findings_of_choice",
    "going_back",
    "needs_distance",
    "noise_floor",
    "normal_filtering",
    "normals_of",
    "notes_of_choice",
    "notes_on_folds",
    "parameters_for_mesh",
    "parameters_without_mesh",
    "projections",
    "relaxed_part",
    "replace_outlying",
    "reported",
    "rings_of_relaxation",
    "rings_of_round",
    "round_of_part",
    "share_along",
    "shared_noise",
    "smoothed_directions",
    "unfolded",
    "unit_normals",
]
