"""Two-step denoising: filtered normals, and vertices fitted to them."""
