"""Choosing among filters by evidence: vertices that a filter has not seen, and how well it predicts them."""

from . import tuned
from .cross_validation import (
    Candidates,
    Choice,
    Scores,
    Trial,
    choose,
    cross_validate,
    initial_positions,
    run_to_last,
    scores_of,
    starts_of,
    trials_of,
)
from .held_out import (
    far_from_border,
    heights_of_means,
    held_out_vertices,
    local_means,
    means_of_others,
    random_numbers,
    random_signs,
    without,
)
from .outlying import flattening, outlying_vertices, put_where_expected, sizes_beside, standing_out
from .patches import Sample, sample_of
from .quadric_prediction import height_of_quadric, predicted_heights, tangents
from .risk import choose_by_risk, roughness

__all__ = [
    "Candidates",
    "Choice",
    "Sample",
    "Scores",
    "Trial",
    "choose",
    "choose_by_risk",
    "cross_validate",
    "far_from_border",
    "flattening",
    "height_of_quadric",
    "heights_of_means",
    "held_out_vertices",
    "initial_positions",
    "local_means",
    "means_of_others",
    "outlying_vertices",
    "predicted_heights",
    "put_where_expected",
    "random_numbers",
    "random_signs",
    "roughness",
    "run_to_last",
    "sample_of",
    "scores_of",
    "sizes_beside",
    "standing_out",
    "starts_of",
    "tangents",
    "trials_of",
    "tuned",
    "without",
]
