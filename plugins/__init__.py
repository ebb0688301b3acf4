"""Declarations of pymeshfair's filters for MeshLab users, one module per family: names, parameters, help, units."""

if __name__ != "pymeshfair.plugins":
    raise ImportError("import pymeshfair.plugins, not the checkout folder 'plugins': a second copy would not share its types")
