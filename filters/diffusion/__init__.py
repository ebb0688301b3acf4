"""Smoothing by diffusion: explicit, Taubin and implicit steps; diffusion and continuation of values; the loss of relief."""

from .anisotropic import EDGE_STOPS, EdgeStop, longest_step, perona_malik
from .explicit import (
    TaubinOperator,
    explicit_smoothing,
    meshlab_taubin_smooth,
    mu_of_pass_band,
    remove_spikes,
    taubin_fairing,
    transfer_function,
)
from .harmonic import harmonic_continuation, harmonic_values
from .implicit import Flow, ImplicitOperator, implicit_fairing, time_step_of_detail_size
from .relief import ReliefLoss, relief_lost
from .stencil import UPDATE_RULES, UpdateRule

__all__ = [
    "EDGE_STOPS",
    "UPDATE_RULES",
    "EdgeStop",
    "Flow",
    "ImplicitOperator",
    "ReliefLoss",
    "TaubinOperator",
    "UpdateRule",
    "explicit_smoothing",
    "harmonic_continuation",
    "harmonic_values",
    "implicit_fairing",
    "longest_step",
    "meshlab_taubin_smooth",
    "mu_of_pass_band",
    "perona_malik",
    "relief_lost",
    "remove_spikes",
    "taubin_fairing",
    "time_step_of_detail_size",
    "transfer_function",
]
