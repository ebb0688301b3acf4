"""The recipes that pymeshfair ships, one .mlx script each; ``pymeshfair list recipes`` names them."""

#: What to take in place of recipes that are shipped no more, and why, by name.
WITHDRAWN = {
    "smooth_keep_features": "take 'denoise', which finds its settings from the scan: it leaves 2 to 6 degrees of error where "
    "that left 9 to 26; its filter, apply_coord_bilaplacian_smoothing, is still there",
}
