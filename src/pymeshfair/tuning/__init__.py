"""The page to tune on: a small server on this machine, and a worker that runs a recipe again whenever a parameter changes."""
