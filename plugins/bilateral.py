"""Bilateral filters of positions, and anisotropic diffusion of what a mesh carries."""
