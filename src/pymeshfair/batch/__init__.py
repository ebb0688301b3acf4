"""Runs one recipe on many scans, each in its own worker process, on one machine or several; a journal lets a batch resume."""
