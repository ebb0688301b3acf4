"""A run: one mesh file through one recipe, in a worker process of its own, with a record of everything that it did."""
