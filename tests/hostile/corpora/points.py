"""Files of points whose rows or counts lie."""

from __future__ import annotations

#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    ("utf_16.xyz", b"\xfe\xff" + "1 2 3\n".encode("utf-16-be"), "it is a text in UTF-16"),
    ("csv.xyz", "1,2,3\n4,5,6\n7,8,9\n", (3, 0)),
    ("semi.xyz", "1;2;3\n4;5;6\n", (2, 0)),
    ("csvsp.xyz", "1, 2, 3\n4, 5, 6\n", (2, 0)),
    ("hash.xyz", "# c\n1 2 3\n4 5 6\n7 8 9\n", (3, 0, "out.ply does not hold these contents of {}: comments")),
    ("slash.xyz", "// c\n1 2 3\n4 5 6\n", (2, 0, "its titles '// c'")),
    ("two.xyz", "1 2\n3 4\n", "its rows have 2 numbers; a point has at least 3"),
    ("five.xyz", "1 2 3 4 5\n1 2 4 4 6\n", (2, 0)),
    ("four.xyz", "1 2 3 4\n1 2 3 5\n", (2, 0, "all its 2 vertices are at one place")),
    ("six.xyz", "1 2 3 0 0 1\n1 2 4 0 0 1\n", (2, 0)),
    ("sixc.xyz", "1 2 3 255 0 0\n1 2 4 255 0 0\n", (2, 0)),
    ("sixnan.xyz", "1 2 3 nan 0 0\n1 2 4 1 0 0\n", (2, 0)),
    ("nine.xyz", "1 2 3 4 5 6 0 0 1\n" * 2, (2, 0, "all its 2 vertices are at one place")),
    ("named.xyz", "//X Y Z R G B Scan_angle\n1 2 3 4 5 6 0.5\n1 2 4 4 5 6 7\n", (2, 0)),
    ("named_in_a_remark.xyz", "# x y z intensity\n1 2 3 4\n1 2 4 4\n", (2, 0)),
    (
        "nan.xyz",
        "1 2 nan\n3 4 5\n6 7 8\n",
        (
            2,
            0,
            "1 vertex with a coordinate that is not finite, and 0 faces with such a vertex",
        ),
    ),
    ("allnan.xyz", "nan nan nan\n" * 3, "no vertex could be read from it"),
    (
        "inf.xyz",
        "1 2 inf\n3 4 5\n",
        (
            1,
            0,
            "1 vertex with a coordinate that is not finite, and 0 faces with such a vertex",
        ),
    ),
    (
        "over.xyz",
        "1 2 1e400\n3 4 5\n",
        (
            1,
            0,
            "1 vertex with a coordinate that is not finite, and 0 faces with such a vertex",
        ),
    ),
    ("count.xyz", "2\n1 2 3\n4 5 6\n", (2, 0)),
    ("count_wrong.xyz", "5\n1 2 3\n4 5 6\n", "it declares 5 points, but has 2"),
    ("word_mid.xyz", "1 2 3\nabc\n4 5 6\n", "its line 2, 'abc', has 1 numbers, but the rows before it have 3"),
    ("tab.xyz", "1\t2\t3\n4\t5\t6\n", (2, 0)),
    ("one.xyz", "1 2 3\n", (1, 0)),
    ("big.xyz", "1e300 0 0\n0 1e300 0\n", (2, 0)),
    ("f32.xyz", "1e39 0 0\n0 1 0\n", (2, 0)),
    ("mol.xyz", "3\nwater\nO 0 0 0\nH 1 0 0\nH 0 1 0\n", "it declares 3 points, but has 4"),
    (
        "quoted.xyz",
        '"1" "2" "3"\n',
        'its line 1, \'"1" "2" "3"\', has something else than numbers; decimals are written with a point',
    ),
    ("blankmid.xyz", "1 2 3\n\n\n4 5 6\n", (2, 0)),
    ("dup.xyz", "1 2 3\n" * 5, (5, 0, "all its 5 vertices are at one place")),
    ("seven.xyz", "1 2 3 0.5 10 20 30\n" * 3, (3, 0, "all its 3 vertices are at one place")),
    ("zero.pts", "0\n", "its rows have 0 numbers; a point has at least 3"),
    ("none.pts", "1 2 3\n4 5 6\n", (2, 0)),
    (
        "float.pts",
        "2.0\n1 2 3\n4 5 6\n",
        "its rows have 1 numbers; a point has at least 3",
    ),
    ("neg.pts", "-2\n1 2 3\n4 5 6\n", "it declares -2 points, but has 2"),
    ("less.pts", "1\n1 2 3\n4 5 6\n", "it declares 1 points, but has 2"),
    (
        "col_range.pts",
        "2\n1 2 3 0.5 300 -1 0\n1 2 4 0.5 1 1 1\n",
        "the last three numbers of its rows are no colours from 0 to 255",
    ),
    ("int.pts", "2\n1 2 3 -1200 1 1 1\n1 2 4 300 1 1 1\n", (2, 0)),
    ("two_clouds.pts", "1\n1 2 3\n1\n4 5 6\n", "it declares 1 points, but has 3"),
)
