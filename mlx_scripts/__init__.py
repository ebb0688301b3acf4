"""The recipes that pymeshfair ships, one .mlx script each; ``pymeshfair list recipes`` names them."""

#: What to take in place of recipes that are shipped no more, and why, by name.
WITHDRAWN = {
    "denoise_sharp": "take 'denoise', which has its settings among others and left less error on every shape with sharp edges "
    "that was tried; 'pymeshfair suggest SCAN -o RECIPE.mlx' writes what it finds, as a recipe that takes a tenth of the time",
    "denoise_smooth": "take 'denoise', which has its settings among others and left less error on every smooth shape that was "
    "tried; 'pymeshfair suggest SCAN -o RECIPE.mlx' writes what it finds, as a recipe that takes a tenth of the time",
    "smooth_keep_features": "take 'denoise', which finds its settings from the scan: it leaves 2 to 6 degrees of error where "
    "that left 9 to 26; its filter, apply_coord_bilaplacian_smoothing, is still there",
    "smooth_laplacian": "take 'denoise', or in plain MeshLab 'smooth_taubin', which does not shrink the shape and leaves fine "
    "details more as they are; its filter, apply_coord_laplacian_smoothing, is MeshLab's own",
}
