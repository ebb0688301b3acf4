"""The tuning page: a local server, and a worker that runs a recipe again after each change of a parameter."""
