"""Evidence for the choice among filters: how well each filter predicts held-out vertices."""

from . import tuned
from .cross_validation import Candidates, Choice, Scores, Trial, cross_validate, initial_positions, measured, scores_of
from .held_out import (
    BALL,
    far_from_border,
    held_out_vertices,
    lengths_around,
    local_means,
    means_of_others,
    middles_of_balls,
    random_signs,
    with_neighbours,
)
from .quadric_prediction import height_residuals, medians_around, predicted_heights, put_where_expected

__all__ = [
    "BALL",
    "Candidates",
    "Choice",
    "Scores",
    "Trial",
    "cross_validate",
    "far_from_border",
    "height_residuals",
    "held_out_vertices",
    "initial_positions",
    "lengths_around",
    "local_means",
    "means_of_others",
    "measured",
    "medians_around",
    "middles_of_balls",
    "predicted_heights",
    "put_where_expected",
    "random_signs",
    "scores_of",
    "tuned",
    "with_neighbours",
]
