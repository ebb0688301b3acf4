"""Choosing among filters by evidence: vertices that a filter has not seen, and how well it predicts them."""

from .choose import Candidates, Choice, Trial, choose, trials_of
from .cloud_sample import CloudSample, cloud_patches, spacing_and_numbers
from .cross_validation import cross_validate, run_to_last, starts_of
from .equals import among_equals, roughness
from .first_guess import first_guess, guess_by_means
from .flattening import flattening
from .folds import facing, folded_share, folds_cost_more, upright
from .held_out import far_from_border, heights_of_means, held_out_vertices, means_of_others, random_numbers, random_signs, without
from .local_means import local_means
from .noise_field import NoiseField, noise_field
from .noise_floor import noise_floor
from .outlying import outlying_vertices, put_where_expected, sizes_beside, standing_out
from .patches import Sample, sample_of
from .quadric_prediction import predicted_heights
from .risk import choose_by_risk
from .slopes import SlopeError, slope_errors
from .verdict import Verdict, judge

__all__ = [
    "Candidates",
    "Choice",
    "CloudSample",
    "NoiseField",
    "Sample",
    "SlopeError",
    "Trial",
    "Verdict",
    "among_equals",
    "choose",
    "choose_by_risk",
    "cloud_patches",
    "cross_validate",
    "facing",
    "far_from_border",
    "first_guess",
    "flattening",
    "folded_share",
    "folds_cost_more",
    "guess_by_means",
    "heights_of_means",
    "held_out_vertices",
    "judge",
    "local_means",
    "means_of_others",
    "noise_field",
    "noise_floor",
    "outlying_vertices",
    "predicted_heights",
    "put_where_expected",
    "random_numbers",
    "random_signs",
    "roughness",
    "run_to_last",
    "sample_of",
    "sizes_beside",
    "slope_errors",
    "spacing_and_numbers",
    "standing_out",
    "starts_of",
    "trials_of",
    "upright",
    "without",
]
