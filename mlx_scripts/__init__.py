"""The recipes that pymeshfair ships, one .mlx script each; ``pymeshfair list recipes`` names them."""

#: What to take in place of recipes that are shipped no more, and why, by name.
WITHDRAWN = {
    "smooth_keep_features": "take 'denoise', which finds its settings from the scan, or 'denoise_sharp' for machine parts: they "
    "leave 2 to 8 degrees of error where it left 9 to 26; its filter, apply_coord_bilaplacian_smoothing, is still there",
}
