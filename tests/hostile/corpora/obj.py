"""OBJ files whose numbers, indices or keywords lie."""

from __future__ import annotations

O = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"  # noqa: E741

#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    ("utf_16.obj", (O + "f 1 2 3\n").encode("utf-16"), "it is a text in UTF-16"),
    ("continued_a_million_times.obj", O + "f 1 2 3 " + "\\\n" * 1_000_000 + "\n", (3, 1)),
    (
        "levels.obj",
        "v 0 0 0 0 0 0\nv 1 0 0 255 0 0\nv 0 1 0 0 128 0\nf 1 2 3\n",
        (3, 1, "they are read as levels up to 255"),
    ),
    (
        "levels_with_materials.obj",
        "mtllib a.mtl\nv 0 0 0 0 0 0\nv 1 0 0 255 0 0\nv 0 1 0 0 128 0\nf 1 2 3\n",
        (3, 1, "they are read as levels up to 255", "the texture 'gone.png' does not exist; the output still refers to it"),
    ),
    (
        "nan.obj",
        O.replace("1 0 0", "nan 0 0") + "f 1 2 3\n",
        (
            2,
            0,
            "1 vertex with a coordinate that is not finite, and 1 face with such a vertex",
        ),
    ),
    (
        "inf.obj",
        O.replace("1 0 0", "inf 0 0") + "f 1 2 3\n",
        (
            2,
            0,
            "1 vertex with a coordinate that is not finite, and 1 face with such a vertex",
        ),
    ),
    (
        "over.obj",
        O.replace("1 0 0", "1e400 0 0") + "f 1 2 3\n",
        (
            2,
            0,
            "1 vertex with a coordinate that is not finite, and 1 face with such a vertex",
        ),
    ),
    ("f32.obj", O.replace("1 0 0", "1e39 0 0") + "f 1 2 3\n", (3, 1)),
    (
        "qnan.obj",
        O.replace("1 0 0", "1.#QNAN 0 0") + "f 1 2 3\n",
        "its line 2, 'v 1.#QNAN 0 0', has something else than numbers; decimals are written with a point",
    ),
    (
        "fortran.obj",
        O.replace("1 0 0", "1d0 0 0") + "f 1 2 3\n",
        "its line 2, 'v 1d0 0 0', has something else than numbers; decimals are written with a point",
    ),
    (
        "hexf.obj",
        O.replace("1 0 0", "0x1 0 0") + "f 1 2 3\n",
        "its line 2, 'v 0x1 0 0', has something else than numbers; decimals are written with a point",
    ),
    (
        "arab.obj",
        O.replace("1 0 0", "١ 0 0") + "f 1 2 3\n",
        "its line 2, 'v ١ 0 0', has something else than numbers; decimals are written with a point",
    ),
    ("rep.obj", O + "f 1 1 2\n", (3, 1)),
    ("comma.obj", O + "f 1, 2, 3\n", "its line 4, 'f 1, 2, 3', has something else than whole numbers, joined by slashes"),
    ("empties.obj", O + "vt 0 0\nf 1// 2// 3//\n", (3, 1, "texture coordinates that no face names (1)")),
    ("empty_ends.obj", O + "vt 0 0\nf 1/1/ 2/1/ 3/1/\n", (3, 1)),
    ("empty_vertex.obj", O + "vt 0 0\nf /1 2/1 3/1\n", "has something else than whole numbers, joined by slashes"),
    (
        "four.obj",
        O + "f 1/1/1/1 2/1/1/1 3/1/1/1\n",
        "its line 4, 'f 1/1/1/1 2/1/1/1 3/1/1/1', has something else than whole numbers, joined by slashes",
    ),
    (
        "vtoor.obj",
        O + "vt 0 0\nf 1/1 2/2 3/1\n",
        "its line 5, 'f 1/1 2/2 3/1', names a texture coordinate that is not among those before it",
    ),
    (
        "vnoor.obj",
        O + "vn 0 0 1\nf 1//1 2//2 3//1\n",
        "its line 5, 'f 1//1 2//2 3//1', names a normal that is not among those before it",
    ),
    (
        "mixed.obj",
        O + "vt 0 0\nvn 0 0 1\nf 1/1 2//1 3\n",
        (3, 1, "faces with texture coordinates only at some corners (1)"),
    ),
    (
        "mixed2.obj",
        O + "vt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3//1\n",
        (3, 1, "faces with texture coordinates only at some corners (1)"),
    ),
    ("call.obj", O + "call /etc/passwd\nf 1 2 3\n", (3, 1, "display attributes (1)")),
    ("csh.obj", O + "csh rm -rf x\nf 1 2 3\n", (3, 1, "display attributes (1)")),
    ("face_first.obj", "f 1 2 3\n" + O, "its line 1, 'f 1 2 3', names a vertex that is not among those before it"),
    ("fo.obj", O + "fo 1 2 3\n", "its line 4, 'fo 1 2 3', begins with no keyword of the format"),
    ("caps.obj", O.upper() + "F 1 2 3\n", "its line 4, 'F 1 2 3', begins with no keyword of the format"),
    ("v5.obj", O.replace("\n", " 1 1\n") + "f 1 2 3\n", "its line 1, 'v 0 0 0 1 1', has 5 values and not 3 or 4 or 6 or 7"),
    ("v2.obj", "v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n", "its line 1, 'v 0 0', has 2 values and not 3 or 4 or 6 or 7"),
    ("plus.obj", O + "f +1 +2 +3\n", (3, 1)),
    (
        "intmin.obj",
        O + "f -2147483649 1 2\n",
        "its line 4, 'f -2147483649 1 2', names a vertex that is not among those before it",
    ),
    ("i2_32.obj", O + "f 4294967297 2 3\n", "its line 4, 'f 4294967297 2 3', names a vertex that is not among those before it"),
    ("only_v.obj", O, (3, 0)),
    ("only_f.obj", "f 1 2 3\n", "its line 1, 'f 1 2 3', names a vertex that is not among those before it"),
    ("comment_only.obj", "# nothing\n", "no vertex could be read from it"),
    ("mtl_only.obj", "mtllib a.mtl\n", "no vertex could be read from it"),
    ("vn_short.obj", O + "vn 0 0\nf 1//1 2//1 3//1\n", "its line 4, 'vn 0 0', has 2 values and not 3"),
    ("vt1.obj", O + "vt 0.5\nf 1/1 2/1 3/1\n", "its line 4, 'vt 0.5', has 1 values and not 2 or 3"),
    ("vt_nan.obj", O + "vt nan 0\nf 1/1 2/1 3/1\n", (3, 1)),
    ("vn_nan.obj", O + "vn nan 0 0\nf 1//1 2//1 3//1\n", (3, 1, "normals of corners")),
    ("vn_zero.obj", O + "vn 0 0 0\nf 1//1 2//1 3//1\n", (3, 1, "normals of corners")),
    ("vn_each.obj", O + "vn 0 0 0\nvn 0 0 1\nvn nan 0 1\nf 1//1 2//3 3//2\n", (3, 1)),
    (
        "col_range.obj",
        "v 0 0 0 300 0 0\nv 1 0 0 300 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n",
        "the colour of its vertex 1 is not from 0.0 to 1.0",
    ),
    (
        "col_neg.obj",
        "v 0 0 0 -1 0 0\nv 1 0 0 0 0 0\nv 0 1 0 1 1 1\nf 1 2 3\n",
        "the colour of its vertex 1 is not from 0.0 to 1.0",
    ),
    ("w0.obj", "v 0 0 0 0\nv 1 0 0 0\nv 0 1 0 0\nf 1 2 3\n", (3, 1, "weights of vertices")),
    ("poly_rep.obj", O + "v 1 1 0\nf 1 2 4 2\n", (4, 2, "polygons that are not whole are written as triangles (1)")),
    ("conc.obj", O + "v 1 1 0\nv .2 .2 0\nf 1 2 4 3 5\n", (5, 3)),
    ("contin_eof.obj", O + "f 1 2 3 \\", "its line 4, 'f 1 2 3 \\\\', has something else than whole numbers, joined by slashes"),
    ("contin_blank.obj", O + "f 1 2 \\ \n3\n", "its line 5, '3', begins with no keyword of the format"),
    ("point.obj", O + "p 1\n", (3, 0, "point elements (1)")),
    ("point_oor.obj", O + "p 99\n", (3, 0, "point elements (1)")),
    ("l_only.obj", O + "l 1 2\n", (3, 0)),
    ("l1.obj", O + "l 1\n", "its line 4, 'l 1', is a polyline of fewer than 2 vertices"),
    ("s.obj", O + "s off\nf 1 2 3\n", (3, 1, "smoothing groups (1)")),
    ("g.obj", "g a b c\n" + O + "f 1 2 3\n", (3, 1, "groups (1)")),
    ("mtl_dir.obj", "mtllib .\n" + O + "f 1 2 3\n", "which it names, is a folder and no file"),
    ("mtl_slash.obj", "mtllib sub/a.mtl\n" + O + "f 1 2 3\n", (3, 1, "the material file a.mtl, which does not exist")),
    (
        "mtl_many.obj",
        "mtllib a.mtl a.mtl b.mtl\n" + O + "f 1 2 3\n",
        (3, 1, "the material file a.mtl a.mtl b.mtl, which does not exist"),
    ),
    ("html_tail.obj", O + "f 1 2 3\n<html>\n", "its line 5, '<html>', begins with no keyword of the format"),
    (
        "long_name.obj",
        O + "usemtl " + "a" * 100000 + "\nf 1 2 3\n",
        (3, 1, "uses of materials (1), as there is no material file"),
    ),
    (
        "usemtl_none.obj",
        "mtllib a.mtl\n" + O + "usemtl nothere\nf 1 2 3\n",
        (
            3,
            1,
            "uses of the material 'nothere', which its material files do not have",
            "the texture 'gone.png' does not exist; the output still refers to it",
        ),
    ),
    (
        "v_trailing_word.obj",
        O.replace("1 0 0", "1 0 0 abc") + "f 1 2 3\n",
        "its line 2, 'v 1 0 0 abc', has 4 values, while the vertices before it have 3",
    ),
    ("surf.obj", O + "curv 0 1 1 2 3\nf 1 2 3\n", (3, 1, "curves (1)")),
)
