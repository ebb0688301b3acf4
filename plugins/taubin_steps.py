"""The parameters of Taubin's pair of steps, which surfaces and curves share but for the words."""

from __future__ import annotations

from pymeshfair.declaration import Float


def taubin_step(help: str) -> Float:
    """The step lambda, which smooths."""
    return Float(label="Step (lambda)", minimum=0, maximum=1, help=help)


def taubin_mu(help: str) -> Float:
    """The step mu, which goes back."""
    return Float(label="Step back (mu)", minimum=-1.5, maximum=0, help=help)


def taubin_pass_band(help: str) -> Float:
    """The pass band, which gives mu for a lambda."""
    return Float(label="Pass band", minimum=0, maximum=2, help=help)
