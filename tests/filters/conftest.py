"""Hypothesis for compiled code: examples may wait for the compiler, so none has a deadline; the same ones every time."""

from hypothesis import settings

settings.register_profile("compiled", deadline=None, derandomize=True)
settings.load_profile("compiled")
