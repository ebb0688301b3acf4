"""Worker processes, and the channel to them, for runs, batches, tiles and the tuning page."""
