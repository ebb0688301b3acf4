"""A median filter of vertex scalars, as a plugin of pymeshfair."""
