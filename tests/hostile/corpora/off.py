"""OFF files whose counts, numbers or indices lie."""

from __future__ import annotations

OF = "0 0 0\n1 0 0\n0 1 0\n"

#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    ("utf_16.off", ("OFF\n3 1 0\n" + OF + "3 0 1 2\n").encode("utf-16"), "it is a text in UTF-16"),
    ("binary.off", "OFF BINARY\n" + "\x00" * 40, "it is binary; OFF files are read only as texts"),
    ("one_line_head.off", "OFF 3 1 0\n" + OF + "3 0 1 2\n", (3, 1)),
    ("no_edges.off", "OFF\n3 1\n" + OF + "3 0 1 2\n", (3, 1)),
    ("no_magic.off", "3 1 0\n" + OF + "3 0 1 2\n", "it begins with '3', and not with OFF, COFF, NOFF, STOFF or their like"),
    ("neg.off", "OFF\n-3 1 0\n" + OF + "3 0 1 2\n", "it does not say how many vertices and faces it has"),
    ("float.off", "OFF\n3.0 1 0\n" + OF + "3 0 1 2\n", "it does not say how many vertices and faces it has"),
    ("exp.off", "OFF\n3e0 1 0\n" + OF + "3 0 1 2\n", "it does not say how many vertices and faces it has"),
    (
        "face0.off",
        "OFF\n3 2 0\n" + OF + "3 0 1 2\n0\n",
        "its line 7, '0', is no face, which is a number n of vertices, at least 2, and n indices",
    ),
    (
        "face1.off",
        "OFF\n3 2 0\n" + OF + "3 0 1 2\n1 0\n",
        "its line 7, '1 0', is no face, which is a number n of vertices, at least 2, and n indices",
    ),
    ("face2.off", "OFF\n3 2 0\n" + OF + "3 0 1 2\n2 0 1\n", (3, 1)),
    ("negidx.off", "OFF\n3 1 0\n" + OF + "3 0 1 -2\n", "its line 6, '3 0 1 -2', names a vertex that is not among its 3"),
    ("eqidx.off", "OFF\n3 1 0\n" + OF + "3 0 1 3\n", "its line 6, '3 0 1 3', names a vertex that is not among its 3"),
    ("fracidx.off", "OFF\n3 1 0\n" + OF + "3 0 1 1.5\n", "its line 6, '3 0 1 1.5', names a vertex that is not among its 3"),
    ("rep.off", "OFF\n3 1 0\n" + OF + "3 0 1 1\n", (3, 1)),
    (
        "nan.off",
        "OFF\n3 1 0\nnan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        (
            2,
            0,
            "1 vertex with a coordinate that is not finite, and 1 face with such a vertex",
        ),
    ),
    (
        "inf.off",
        "OFF\n3 1 0\n1e999 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        (
            2,
            0,
            "1 vertex with a coordinate that is not finite, and 1 face with such a vertex",
        ),
    ),
    (
        "4off.off",
        "4OFF\n3 1 0\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n",
        "it begins with '4OFF', and not with OFF, COFF, NOFF, STOFF or their like",
    ),
    (
        "nof.off",
        "nOFF\n3\n3 1 0\n" + OF + "3 0 1 2\n",
        "it begins with 'nOFF', and not with OFF, COFF, NOFF, STOFF or their like",
    ),
    ("stoff.off", "STOFF\n3 1 0\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n", (3, 1)),
    (
        "cutidx.off",
        "OFF\n12 1 0\n" + OF * 4 + "3 0 1 1",
        (
            12,
            1,
            "its last line has no line end: the file, and its last number, may be cut short",
        ),
    ),
    ("empty_mesh.off", "OFF\n0 0 0\n", "no vertex could be read from it"),
    ("points.off", "OFF\n3 0 0\n" + OF, (3, 0)),
    (
        "face_short.off",
        "OFF\n3 1 0\n" + OF + "4 0 1 2\n",
        "its line 6, '4 0 1 2', is no face, which is a number n of vertices, at least 2, and n indices",
    ),
    (
        "face_long.off",
        "OFF\n3 1 0\n" + OF + "3 0 1 2 0\n",
        "its line 6, '3 0 1 2 0', has a colour by its number in a list, which is not there",
    ),
    ("col_alpha.off", "OFF\n3 1 0\n" + OF + "3 0 1 2 0.1 0.2 0.3 0.4\n", (3, 1)),
    (
        "col_neg.off",
        "OFF\n3 1 0\n" + OF + "3 0 1 2 -1 -2 -3\n",
        "its line 6, '3 0 1 2 -1 -2 -3', has a colour beyond 0 to 255, or 0.0 to 1.0",
    ),
    (
        "col_big.off",
        "OFF\n3 1 0\n" + OF + "3 0 1 2 300 2 3\n",
        "its line 6, '3 0 1 2 300 2 3', has a colour beyond 0 to 255, or 0.0 to 1.0",
    ),
    (
        "coff_nan.off",
        "COFF\n3 1 0\n0 0 0 nan 0 0 0\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n",
        "its line 3, '0 0 0 nan 0 0 0', has a colour that is no number",
    ),
    ("edges_wrong.off", "OFF\n3 1 999999\n" + OF + "3 0 1 2\n", (3, 1)),
    ("big.off", "OFF\n3 1 0\n1e300 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", (3, 1)),
    ("lower.off", "off\n3 1 0\n" + OF + "3 0 1 2\n", "it begins with 'off', and not with OFF, COFF, NOFF, STOFF or their like"),
    ("two_per_line.off", "OFF\n3 1 0\n0 0 0 1 0 0\n0 1 0\n3 0 1 2\n", "it declares 3 vertices and 1 faces, but 3 lines follow"),
)
