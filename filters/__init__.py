"""The mathematics of pymeshfair: pure functions of numpy arrays.

No module here imports pymeshlab or other packages of pymeshfair, prints, or exits. Operators have the sign of ``igl.cotmatrix``:
stiffness matrices are negative semidefinite. Citations are keys of ``docs/bibliography.bib``. Unless a function says otherwise,
``vertices`` and ``points`` are (n, 3) coordinates in mesh units, ``faces`` are (m, 3) vertex indices of triangles,
``faces_or_edges`` are faces or (e, 2) edges, and ``n_vertices`` is n.
"""

if __name__ != "pymeshfair.filters":
    raise ImportError("import pymeshfair.filters, not the checkout folder 'filters': a second copy would not share its types")
