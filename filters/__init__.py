"""The mathematics of pymeshfair: pure functions of numpy arrays, one family a folder, one idea a module.

Nothing in this package imports the rest of pymeshfair or pymeshlab, prints, or exits. The sign of every operator is that of
``igl.cotmatrix``: stiffness matrices are negative semidefinite. Sources are cited by the keys of ``docs/bibliography.bib``.
Where a function does not say otherwise, ``vertices`` and ``points`` are (n, 3) coordinates in mesh units, ``faces`` (m, 3) vertex
numbers of triangles, ``faces_or_edges`` these or (e, 2) edges, and ``n_vertices`` is n.
"""

if __name__ != "pymeshfair.filters":
    raise ImportError("import pymeshfair.filters, not the checkout folder 'filters': a second copy would not share its types")
