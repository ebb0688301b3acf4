"""Many scans through one recipe, each in a worker process of its own, on one machine or many; a journal to resume from."""
