"""Runs one recipe on many scans in worker processes, on one machine or several; a journal lets a batch resume."""
