"""A run: applies one recipe to one mesh file in its own worker process, and records every step."""
