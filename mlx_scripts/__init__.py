"""The recipes that pymeshfair ships, one .mlx script each; ``pymeshfair list recipes`` names them."""
