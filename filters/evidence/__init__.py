"""Choosing among filters by evidence: vertices that a filter has not seen, and how well it predicts them."""

from . import tuned
from .cross_validation import Candidates, Choice, Scores, Trial, cross_validate, initial_positions, measured, scores_of
from .held_out import (
    far_from_border,
    held_out_vertices,
    lengths_around,
    local_means,
    marked,
    means_of_others,
    random_signs,
)
from .outlying import flattening, outlying_vertices, put_where_expected, roughness, sizes_beside, standing_out
from .quadric_prediction import height_of_quadric, height_residuals, predicted_heights, tangents

__all__ = [
    "Candidates",
    "Choice",
    "Scores",
    "Trial",
    "cross_validate",
    "far_from_border",
    "flattening",
    "height_of_quadric",
    "height_residuals",
    "held_out_vertices",
    "initial_positions",
    "lengths_around",
    "local_means",
    "marked",
    "means_of_others",
    "measured",
    "outlying_vertices",
    "predicted_heights",
    "put_where_expected",
    "random_signs",
    "roughness",
    "scores_of",
    "sizes_beside",
    "standing_out",
    "tangents",
    "tuned",
]
