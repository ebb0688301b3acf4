"""STL files whose words, numbers or sizes lie."""

from __future__ import annotations

FC = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"

#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    ("utf_16.stl", ("solid a\n" + FC + "endsolid\n").encode("utf-16"), "it is a text in UTF-16"),
    (
        "nan.stl",
        "solid a\n" + FC.replace("1 0 0", "nan 0 0") + "endsolid\n",
        "its line 5, 'vertex nan 0 0', has something else than finite numbers; decimals are written with a point",
    ),
    (
        "inf.stl",
        "solid a\n" + FC.replace("1 0 0", "1e400 0 0") + "endsolid\n",
        "its line 5, 'vertex 1e400 0 0', has something else than finite numbers; decimals are written with a point",
    ),
    (
        "f32.stl",
        "solid a\n" + FC.replace("1 0 0", "1e39 0 0") + "endsolid\n",
        (3, 1, "its head 'a'"),
    ),
    (
        "four.stl",
        "solid a\n" + FC.replace("endloop", "vertex 1 1 0\nendloop") + "endsolid\n",
        "its line 7, 'vertex 1 1 0', is not what comes next in a facet",
    ),
    (
        "two.stl",
        "solid a\n" + FC.replace("vertex 1 0 0\n", "") + "endsolid\n",
        "its line 7, 'endfacet', is not what comes next in a facet",
    ),
    (
        "nonormal.stl",
        "solid a\n" + FC.replace(" normal 0 0 1", "") + "endsolid\n",
        "its line 2, 'facet', is not what comes next in a facet",
    ),
    (
        "shortnormal.stl",
        "solid a\n" + FC.replace("normal 0 0 1", "normal 0 0") + "endsolid\n",
        "its line 2, 'facet normal 0 0', is not what comes next in a facet",
    ),
    ("caps.stl", ("solid a\n" + FC + "endsolid\n").upper(), (3, 1, "its head 'A'")),
    ("nofacets.stl", "solid a\nendsolid\n", "no vertex could be read from it"),
    (
        "word.stl",
        "solid a\n" + FC.replace("1 0 0", "a 0 0") + "endsolid\n",
        "its line 5, 'vertex a 0 0', has something else than finite numbers; decimals are written with a point",
    ),
    (
        "comma.stl",
        "solid a\n" + FC.replace("1 0 0", "1,5 0 0") + "endsolid\n",
        "its line 5, 'vertex 1,5 0 0', has something else than finite numbers; decimals are written with a point",
    ),
    (
        "noendfacet.stl",
        "solid a\n" + FC.replace("endfacet\n", "") + FC + "endsolid\n",
        "its line 8, 'facet normal 0 0 1', is not what comes next in a facet",
    ),
    (
        "oneline.stl",
        ("solid a\n" + FC + "endsolid\n").replace("\n", " "),
        "it is cut short: 'solid' and 'endsolid' do not come in pairs",
    ),
    (
        "nested.stl",
        "solid a\nsolid b\n" + FC + "endsolid\nendsolid\n",
        "it is cut short: 'solid' and 'endsolid' do not come in pairs",
    ),
    (
        "binword.stl",
        "solid".ljust(80) + "\x01\x00\x00\x00" + "\x00" * 50,
        (1, 1, "its head 'solid'"),
    ),
    ("after.stl", "solid a\n" + FC + "endsolid a\nhello\n", "it has something before 'solid' or after 'endsolid'"),
    ("nosolid.stl", FC, "it is neither a text that begins with 'solid' nor a binary file of the size that it declares"),
    (
        "longname.stl",
        "solid " + "a" * 100000 + "\n" + FC + "endsolid\n",
        (3, 1, "its head 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa'"),
    ),
    (
        "deg.stl",
        "solid a\n" + FC.replace("1 0 0", "0 0 0") + "endsolid\n",
        (2, 1, "its head 'a'"),
    ),
    ("comment.stl", "solid a\n# x\n" + FC + "endsolid\n", (3, 1, "its head 'a'")),
    ("normal_wrong.stl", "solid a\n" + FC.replace("0 0 1", "0 0 -1") + "endsolid\n", (3, 1, "its head 'a'")),
)
