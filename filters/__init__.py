"""The mathematics of pymeshfair: pure functions of numpy arrays, one family a folder, one idea a module.

Nothing in this package imports the rest of pymeshfair or pymeshlab, prints, or exits. The sign of every operator is that of
``igl.cotmatrix``: stiffness matrices are negative semidefinite. Sources are cited by the keys of ``docs/bibliography.bib``.
"""

if __name__ != "pymeshfair.filters":
    raise ImportError("import pymeshfair.filters, not the checkout folder 'filters': a second copy would not share its types")
