"""A run: one mesh file through one recipe, in a worker process of its own, with everything that it did written down."""
