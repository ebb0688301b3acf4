"""Processes that do work for this one, and the channel to them: of runs, batches, tiles and the tuning page."""
