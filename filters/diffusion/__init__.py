"""Smoothing as diffusion: explicit steps, Taubin's two-sided steps, implicit steps."""
