"""PLY files whose headers, rows or lists lie."""

from __future__ import annotations

from ...running.runs import TETRAHEDRON, ply_bytes, xyz

H = "ply\nformat ascii 1.0\n"
V = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
F = "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
VR = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
FR = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"

#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    ("utf_16.ply", (H + V + F + VR + FR).encode("utf-16"), "it is a text in UTF-16"),
    (
        "nothing.ply",
        H + V + F.replace("element face", "element nothing 4000000000\nelement face") + VR + FR,
        "which have no properties",
    ),
    (
        "empty_list.ply",
        ply_bytes([*xyz(), ("list uchar int", "views", [[1], [], [2], [3]])], TETRAHEDRON[1].tolist()),
        (4, 4),
    ),
    (
        "empty_list_in_text.ply",
        H + V + "property list uchar int views\n" + F + "0 0 0 0\n1 0 0 1 5\n0 1 0 0\n0 0 1 0\n" + FR,
        (4, 4),
    ),
    (
        "empty_lists_in_text.ply",
        H + V + "property list uchar int views\n" + F + VR.replace("\n", " 0\n") + FR,
        (4, 4),
    ),
    (
        "more_faces_than_declared.ply",
        H + V + F.replace("face 4", "face 2") + VR + FR,
        "line 16, '3 1 2 3', is one more than its header declares",
    ),
    (
        "more_vertices_than_declared.ply",
        H + V.replace("4", "3") + F.replace("face 4", "face 1") + VR + "3 0 1 2\n",
        "line 13, '0 0 1', has more values than its header declares",
    ),
    (
        "cut_index.ply",
        H + V.replace("4", "12") + F.replace("face 4", "face 1") + VR * 3 + "3 0 2 1",
        (12, 1, "{}: its last line has no line end: the file, and its last number, may be cut short"),
    ),
    (
        "noend.ply",
        (H + V + F + VR + FR)[:-1],
        (4, 4, "{}: its last line has no line end: the file, and its last number, may be cut short"),
    ),
    ("float_idx.ply", H + V + F.replace("uchar int", "uchar float") + VR + FR, (4, 4)),
    (
        "frac_idx.ply",
        H + V + F + VR + FR.replace("3 1 2 3", "3 1 2.5 3"),
        "line 16, '3 1 2.5 3', has a 'vertex_indices' that is no int",
    ),
    ("neg_idx.ply", H + V + F + VR + FR.replace("3 1 2 3", "3 1 -2 3"), "a face of it names a vertex that is not among its 4"),
    ("oor_idx.ply", H + V + F + VR + FR.replace("3 1 2 3", "3 1 2 4"), "a face of it names a vertex that is not among its 4"),
    (
        "huge_idx.ply",
        H + V + F + VR + FR.replace("3 1 2 3", "3 1 2 4294967297"),
        "line 16, '3 1 2 4294967297', has a 'vertex_indices' that is no int",
    ),
    (
        "len_neg.ply",
        H + V + F.replace("uchar", "char") + VR + FR.replace("3 1 2 3", "-1 1 2 3"),
        "line 16, '-1 1 2 3', does not give its list 'vertex_indices' a length that fits the line",
    ),
    (
        "len_huge.ply",
        H + V + F + VR + FR.replace("3 1 2 3", "255 1 2 3"),
        "line 16, '255 1 2 3', does not give its list 'vertex_indices' a length that fits the line",
    ),
    (
        "len_frac.ply",
        H + V + F + VR + FR.replace("3 1 2 3", "3.5 1 2 3"),
        "line 16, '3.5 1 2 3', does not give its list 'vertex_indices' a length that fits the line",
    ),
    ("face0.ply", H + V + F + VR + FR.replace("3 1 2 3", "0"), "its face 3 has 0 vertices"),
    ("face1.ply", H + V + F + VR + FR.replace("3 1 2 3", "1 2"), "its face 3 has 1 vertices"),
    ("face2.ply", H + V + F + VR + FR.replace("3 1 2 3", "2 2 3"), "its face 3 has 2 vertices"),
    (
        "facerep.ply",
        H + V + F + VR + FR.replace("3 1 2 3", "3 1 1 3"),
        (4, 4),
    ),
    ("count_neg.ply", H + V.replace("4", "-4") + F + VR + FR, "line 3 of its header is 'element vertex -4'"),
    ("count_float.ply", H + V.replace("4", "4.0") + F + VR + FR, "line 3 of its header is 'element vertex 4.0'"),
    ("count_exp.ply", H + V.replace("4", "4e0") + F + VR + FR, "line 3 of its header is 'element vertex 4e0'"),
    ("count_hex.ply", H + V.replace("4", "0x4") + F + VR + FR, "line 3 of its header is 'element vertex 0x4'"),
    ("count_plus.ply", H + V.replace("4", "+4") + F + VR + FR, "line 3 of its header is 'element vertex +4'"),
    ("count_under.ply", H + V.replace("4", "0_4") + F + VR + FR, "line 3 of its header is 'element vertex 0_4'"),
    ("count_word.ply", H + V.replace("4", "four") + F + VR + FR, "line 3 of its header is 'element vertex four'"),
    ("count_none.ply", H + V.replace(" 4", "") + F + VR + FR, "line 3 of its header is 'element vertex'"),
    ("count_zero.ply", H + V.replace("4", "0") + F.replace("4", "0"), "no vertex could be read from it"),
    (
        "count_2_63.ply",
        H + V.replace("4", "9223372036854775808") + F + VR + FR,
        "its header declares 9,223,372,036,854,775,808 of 'vertex'",
    ),
    ("no_format.ply", "ply\n" + V + F + VR + FR, "its header names no format (ascii, binary_little_endian or binary_big_endian)"),
    (
        "two_formats.ply",
        H + "format binary_little_endian 1.0\n" + V + F + VR + FR,
        "line 3 of its header is 'format binary_little_endian 1.0'",
    ),
    ("version2.ply", H.replace("1.0", "2.0") + V + F + VR + FR, "line 2 of its header is 'format ascii 2.0'"),
    (
        "binary_decl.ply",
        H.replace("ascii", "binary_little_endian") + V + F + VR + FR,
        "its element 'face' is cut short, or a list in it has an impossible length",
    ),
    (
        "x_twice.ply",
        H + V.replace("property float y", "property float x") + F + VR + FR,
        "its element 'vertex' has a property twice",
    ),
    ("vertex_twice.ply", H + V + V + F + VR + VR + FR, "it declares an element twice"),
    (
        "no_x.ply",
        H + V.replace("property float x\n", "") + F + VR.replace("0 0 0", "0 0") + FR,
        "line 10, '1 0 0', has more values than its header declares",
    ),
    (
        "no_z.ply",
        H + V.replace("property float z\n", "") + F + "0 0\n1 0\n0 1\n1 1\n" + FR,
        "its vertices have no numbers x, y and z",
    ),
    (
        "x_list.ply",
        H + V.replace("float x", "list uchar float x") + F + VR + FR,
        "line 11, '1 0 0', ends before its 'z'",
    ),
    ("x_char.ply", H + V.replace("float", "char") + F + VR + FR, (4, 4)),
    ("x_unknown.ply", H + V.replace("float x", "float128 x") + F + VR + FR, "line 4 of its header is 'property float128 x'"),
    ("x_int64.ply", H + V.replace("float x", "int64 x") + F + VR + FR, "line 4 of its header is 'property int64 x'"),
    ("x_float64.ply", H + V.replace("float x", "float64 x") + F + VR + FR, (4, 4)),
    ("no_faces_element.ply", H + V + "end_header\n" + VR, (4, 0)),
    (
        "faces_first.ply",
        H + F.replace("end_header\n", "") + V + "end_header\n" + FR + VR,
        (4, 4),
    ),
    ("no_vertex.ply", H + F + FR, "it has no element 'vertex'"),
    (
        "nan_x.ply",
        H + V + F + VR.replace("1 0 0", "nan 0 0") + FR,
        (
            3,
            1,
            "1 vertex with a coordinate that is not finite, and 3 faces with such a vertex",
        ),
    ),
    (
        "inf_x.ply",
        H + V + F + VR.replace("1 0 0", "inf 0 0") + FR,
        (
            3,
            1,
            "1 vertex with a coordinate that is not finite, and 3 faces with such a vertex",
        ),
    ),
    ("all_nan.ply", H + V + F + "nan nan nan\n" * 4 + FR, "no vertex could be read from it"),
    (
        "big_x.ply",
        H + V + F + VR.replace("1 0 0", "1e39 0 0") + FR,
        "line 11, '1e39 0 0', has a 'x' that is no float",
    ),
    (
        "huge_x.ply",
        H + V + F + VR.replace("1 0 0", "1e400 0 0") + FR,
        (
            3,
            1,
            "1 vertex with a coordinate that is not finite, and 3 faces with such a vertex",
        ),
    ),
    ("tiny_x.ply", H + V + F + VR.replace("1 0 0", "1e-400 0 0") + FR, (4, 4)),
    (
        "words_x.ply",
        H + V + F + VR.replace("1 0 0", "a b c") + FR,
        "line 11, 'a b c', has a 'x' that is no float",
    ),
    (
        "comma_x.ply",
        H + V + F + VR.replace("1 0 0", "1,5 0 0") + FR,
        "line 11, '1,5 0 0', has a 'x' that is no float",
    ),
    (
        "hexfloat.ply",
        H + V + F + VR.replace("1 0 0", "0x1p0 0 0") + FR,
        "line 11, '0x1p0 0 0', has a 'x' that is no float",
    ),
    (
        "underscore.ply",
        H + V + F + VR.replace("1 0 0", "1_0 0 0") + FR,
        "line 11, '1_0 0 0', has a 'x' that is no float",
    ),
    (
        "fortran.ply",
        H + V + F + VR.replace("1 0 0", "1.0d0 0 0") + FR,
        "line 11, '1.0d0 0 0', has a 'x' that is no float",
    ),
    (
        "long_row.ply",
        H + V + F + VR.replace("1 0 0", "1 0 0 7") + FR,
        "line 11, '1 0 0 7', has more values than its header declares",
    ),
    ("short_row.ply", H + V + F + VR.replace("1 0 0", "1 0") + FR, "line 11, '1 0', ends before its 'z'"),
    ("one_line.ply", H + V + F + (VR + FR).replace("\n", " ") + "\n", "it declares 4 of 'vertex', but 1 lines follow"),
    ("blank_lines.ply", H + V + F + VR.replace("\n", "\n\n") + FR, (4, 4)),
    (
        "uchar_range.ply",
        H + V.replace("property float z", "property uchar z") + F + VR.replace("0 0 1", "0 0 300") + FR,
        "line 13, '0 0 300', has a 'z' that is no uchar",
    ),
    ("prop_before_element.ply", H + "property float x\n" + V + F + VR + FR, "line 3 of its header is 'property float x'"),
    ("unknown_keyword.ply", H + "elemnt x\n" + V + F + VR + FR, "line 3 of its header is 'elemnt x'"),
    (
        "unknown_element.ply",
        H + V + "element material 2\nproperty int a\nproperty list uchar float b\n" + F + VR + "1 2 3 4\n5 0\n" + FR,
        (4, 4),
    ),
    (
        "both_lists.ply",
        H + V + F.replace("end_header", "property list uchar int vertex_index\nend_header") + VR + FR.replace("\n", " 3 0 1 2\n"),
        "its faces have their corners twice, as 'vertex_indices' and as 'vertex_index'",
    ),
    (
        "extra_in_face.ply",
        H + V + F + VR + FR.replace("3 1 2 3", "3 1 2 3 9"),
        "line 16, '3 1 2 3 9', has more values than its header declares",
    ),
    (
        "strips.ply",
        H + V + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" + VR + "6 0 1 2 3 -1 0\n",
        (4, 2),
    ),
    (
        "strips_oor.ply",
        H + V + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" + VR + "4 0 1 2 99\n",
        "a strip of it names a vertex that is not among its 4",
    ),
    (
        "range_grid.ply",
        H
        + "obj_info num_cols 2\nobj_info num_rows 2\n"
        + V
        + "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n"
        + VR
        + "1 0\n1 1\n1 2\n1 3\n",
        (4, 2),
    ),
    (
        "range_grid_bad.ply",
        H
        + "obj_info num_cols 2000000\nobj_info num_rows 2000000\n"
        + V
        + "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n"
        + VR
        + "1 0\n1 1\n1 2\n1 3\n",
        "it has a grid of 4 places, which do not fit num_cols and num_rows",
    ),
    (
        "range_grid_oor.ply",
        H
        + "obj_info num_cols 2\nobj_info num_rows 2\n"
        + V
        + "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n"
        + VR
        + "1 0\n1 1\n1 2\n1 99\n",
        "a grid of it names a vertex that is not among its 4",
    ),
    (
        "texnumber_oor.ply",
        H
        + "comment TextureFile a.png\n"
        + V
        + F.replace("end_header", "property list uchar float texcoord\nproperty int texnumber\nend_header")
        + VR
        + FR.replace("\n", " 6 0 0 1 0 0 1 99\n"),
        "its face 1 has the texture 99, counted from 0; there are 1",
    ),
    (
        "texcoord_short.ply",
        H
        + "comment TextureFile a.png\n"
        + V
        + F.replace("end_header", "property list uchar float texcoord\nend_header")
        + VR
        + FR.replace("\n", " 2 0 0\n"),
        "the list 'texcoord' of its face 1 has 2 values for 3 corners",
    ),
    (
        "edges_oor.ply",
        H
        + V
        + F.replace("end_header", "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header")
        + VR
        + FR
        + "0 99\n",
        "its edge 1 ends at a vertex that is not among its 4",
    ),
    ("header_spaces.ply", (H + V + F).replace(" ", "   ").replace("property", "  property") + VR + FR, (4, 4)),
    ("header_tab.ply", (H + V + F).replace(" ", "\t") + VR + FR, (4, 4)),
    ("caps.ply", (H + V + F).upper() + VR + FR, "it does not begin with 'ply'"),
    (
        "color_range.ply",
        H
        + V.replace("z\n", "z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n")
        + F
        + VR.replace("\n", " 300 -1 2\n")
        + FR,
        "line 13, '0 0 0 300 -1 2', has a 'red' that is no uchar",
    ),
    (
        "color_one.ply",
        H + V.replace("z\n", "z\nproperty uchar red\n") + F + VR.replace("\n", " 3\n") + FR,
        (4, 4),
    ),
    (
        "color_float.ply",
        H
        + V.replace("z\n", "z\nproperty float red\nproperty float green\nproperty float blue\n")
        + F
        + VR.replace("\n", " 0.5 0.25 1\n")
        + FR,
        (4, 4),
    ),
)
