"""Applies filters of both kinds to a mesh set: their values, their methods, and what is remembered of them."""
