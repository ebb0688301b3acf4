"""Contests of our operations with those of other libraries: what is timed, how, and what is written about it."""
