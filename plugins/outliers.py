"""Filters of this family."""
