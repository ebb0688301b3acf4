"""Points that do not belong to the surface, told by the distances to their neighbours."""
