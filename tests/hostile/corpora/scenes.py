"""COLLADA, VRML and X3D documents that lie."""

from __future__ import annotations

from ..documents import collada, vrml, x3d

D = collada


def nodes(levels: int) -> str:
    """A document whose mesh is so many nodes deep."""
    inner = collada().replace('<node id="n">', "<node>" * levels + '<node id="n">')
    return inner.replace("</node>", "</node>" * (levels + 1))


#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    ("nan.dae", D(points="nan 0 0 1 0 0 0 1 0"), "number 1 of the array 'a' is not finite"),
    ("inf.dae", D(points="INF 0 0 1 0 0 0 1 0"), "number 1 of the array 'a' is not finite"),
    ("neg.dae", D(corners="0 1 -1"), "number 3 of the corners of its mesh 'g' is -1, which is no index into 3 values"),
    ("float.dae", D(corners="0 1 1.5"), "number 3 of the corners of its triangles is no whole number"),
    ("count_neg.dae", D(count=-9), "the count of a float_array of it is '-9', no whole number from 0 to 10^15 - 1"),
    ("count_less.dae", D(count=6), "its array 'a' declares 6 numbers, but has 9"),
    ("acc_less.dae", D(accessor=2), "number 3 of the corners of its mesh 'g' is 2, which is no index into 2 values"),
    (
        "rep.dae",
        D(corners="0 1 1"),
        (3, 1),
    ),
    ("empty.dae", D(corners=""), "it declares 1 triangles, but has 0"),
    ("extra.dae", D(corners="0 1 2 0"), "its 1 triangles take 3 indices, but 4 are there"),
    ("two.dae", D(corners="0 1 2 0 1 2"), "it declares 1 triangles, but has 2"),
    ("matrix.dae", D().replace('<node id="n">', '<node id="n"><matrix>2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1</matrix>'), (3, 1)),
    (
        "matrix15.dae",
        D().replace('<node id="n">', '<node id="n"><matrix>' + "1 " * 15 + "</matrix>"),
        "a matrix of a node of it has 15 numbers and not 16",
    ),
    (
        "matnan.dae",
        D().replace('<node id="n">', '<node id="n"><matrix>' + "nan " * 16 + "</matrix>"),
        "number 1 of a matrix of a node of it is not finite",
    ),
    (
        "mat0.dae",
        D().replace('<node id="n">', '<node id="n"><matrix>' + "0 " * 16 + "</matrix>"),
        "the last row of a matrix of it is not 0 0 0 1",
    ),
    (
        "unit.dae",
        D().replace("<library_images>", '<asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset><library_images>'),
        (3, 1, "its upright axis 'Z_UP'"),
    ),
    (
        "unit0.dae",
        D().replace("<library_images>", '<asset><unit meter="0"/></asset><library_images>'),
        (3, 1, "its unit of 0 m"),
    ),
    ("self.dae", D().replace('<instance_geometry url="#g"/>', '<instance_node url="#n"/>'), "one of its parts contains itself"),
    ("nogeom.dae", D().replace('<instance_geometry url="#g"/>', ""), "no vertex could be read from it"),
    ("dtd.dae", D().replace("?>", '?><!DOCTYPE COLLADA SYSTEM "http://x/y.dtd">', 1), (3, 1)),
    (
        "xxe.dae",
        D().replace("?>", '?><!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]>', 1).replace("0 1 2", "&x;"),
        "it declares entities or a document type of its own, which no mesh needs",
    ),
    ("pi.dae", D().replace("?>", "?>" + "<?a b?>" * 300000, 1), (3, 1)),
    ("attrs.dae", D().replace('<node id="n"', '<node id="n" ' + " ".join(f'a{k}="1"' for k in range(5000))), (3, 1)),
    (
        "polylist.dae",
        D().replace('<triangles count="1">', '<polylist count="1"><vcount>3</vcount>').replace("</triangles>", "</polylist>"),
        (3, 1),
    ),
    (
        "polylist_bad.dae",
        D().replace('<triangles count="1">', '<polylist count="1"><vcount>4</vcount>').replace("</triangles>", "</polylist>"),
        "its 1 polylist take 4 indices, but 3 are there",
    ),
    ("stride0.dae", D().replace('stride="3"', 'stride="0"'), "the stride of a accessor of it is '0'"),
    ("stride_huge.dae", D().replace('stride="3"', 'stride="999999"'), "needs more than its 9 numbers: 3 x 999,999"),
    ("nons.dae", D().replace('xmlns="http://www.collada.org/2005/11/COLLADASchema" ', ""), (3, 1)),
    ("two_inst.dae", D().replace('<instance_geometry url="#g"/>', '<instance_geometry url="#g"/>' * 2), (6, 2)),
    ("deepnodes.dae", nodes(60), (3, 1)),
    ("deep.dae", nodes(5000), "it has elements more than 200 levels deep"),
    (
        "latin.dae",
        D()
        .replace('<?xml version="1.0"?>', '<?xml version="1.0" encoding="iso-8859-1"?>')
        .replace('id="n"', 'id="é"')
        .encode("latin-1"),
        (3, 1),
    ),
    (
        "u7.dae",
        D().replace('<?xml version="1.0"?>', '<?xml version="1.0" encoding="utf-7"?>'),
        "it is written in an encoding that is not known; save it as UTF-8",
    ),
    ("cdata.dae", D(corners="<![CDATA[0 1 2]]>"), (3, 1)),
    ("comment.dae", D(corners="0 <!-- x --> 1 2"), (3, 1)),
    (
        "offset.dae",
        D().replace('offset="0"', 'offset="99"'),
        "the offset of an input of it is '99', no whole number from 0 to 31",
    ),
    (
        "stride_less.dae",
        D().replace('stride="3"/>', 'stride="2"><param name="X"/><param name="Y"/><param name="Z"/></accessor>'),
        "an accessor of its array 'a' selects value 3 of 2",
    ),
    (
        "vcount_neg.dae",
        D().replace("triangles", "polylist").replace("<p>", "<vcount>-3</vcount><p>"),
        "a number of corners of its polylist is below 0",
    ),
    (
        "noscene.dae",
        D().replace('<scene><instance_visual_scene url="#s"/></scene>', ""),
        "it has no scene, so nothing in it is placed",
    ),
    ("version9.dae", D().replace('version="1.4.1"', 'version="9"'), (3, 1)),
    ("lines.dae", D().replace("triangles", "lines").replace(">0 1 2<", ">0 1<"), (3, 0)),
    ("longtext.dae", D(points="0" * 2000000 + " 0 0 1 0 0 0 1 0"), (3, 1)),
    ("nan.wrl", vrml(points="nan 0 0 1 0 0 0 1 0"), "number 1 of the values of a Coordinate is not finite"),
    (
        "neg.wrl",
        vrml(corners="0 1 -2 -1"),
        "number 3 of the coordIndex of a 'IndexedFaceSet' is -2, which is no index into 3 values",
    ),
    ("noend.wrl", vrml(corners="0 1 2"), (3, 1)),
    (
        "two.wrl",
        vrml(corners="0 1 -1"),
        "the coordIndex of a 'IndexedFaceSet': face 1 has 2 corners",
    ),
    (
        "extra.wrl",
        vrml(corners="0 1 2 -1 -1"),
        "the coordIndex of a 'IndexedFaceSet': face 2 has 0 corners",
    ),
    (
        "rep.wrl",
        vrml(corners="0 1 1 -1"),
        (3, 1),
    ),
    ("float.wrl", vrml(corners="0 1 1.5 -1"), "number 3 of the coordIndex of a 'IndexedFaceSet' is no whole number"),
    (
        "deep.wrl",
        "#VRML V2.0 utf8\n" + "Group { children [ " * 3000 + vrml()[16:] + " ] }" * 3000,
        "its nodes are more than 200 levels deep",
    ),
    ("deep2.wrl", "#VRML V2.0 utf8\n" + "Group { children [ " * 50 + vrml()[16:] + " ] }" * 50, (3, 1)),
    ("use.wrl", vrml() + "Shape { geometry PointSet { coord USE C } }", (6, 1)),
    (
        "usegone.wrl",
        vrml().replace("DEF C Coordinate { point [ 0 0 0, 1 0 0, 0 1 0 ] }", "USE Z"),
        "it uses 'Z', which is not defined before",
    ),
    ("str.wrl", vrml(more='title "abc'), "it is cut short within a text"),
    (
        "script.wrl",
        vrml() + 'Script { url "javascript:x" }\n',
        "it has a node of the type Script, which is not supported; save it without such nodes",
    ),
    (
        "proto.wrl",
        "#VRML V2.0 utf8\nPROTO A [ ] { A {} }\n" + vrml()[16:],
        "it has a node of the type PROTO, which is not supported; save it without such nodes",
    ),
    ("trans.wrl", "#VRML V2.0 utf8\nTransform { scale 2 2 2 children [ " + vrml()[16:] + " ] }", (3, 1)),
    (
        "trans0.wrl",
        "#VRML V2.0 utf8\nTransform { scale 0 0 0 children [ " + vrml()[16:] + " ] }",
        (3, 1, "all its 3 vertices are at one place"),
    ),
    (
        "transnan.wrl",
        "#VRML V2.0 utf8\nTransform { scale nan 2 2 children [ " + vrml()[16:] + " ] }",
        "number 1 of the scale of a Transform is not finite",
    ),
    (
        "colidx.wrl",
        vrml().replace("coordIndex", "colorIndex [ 99 -1 ] color Color { color [ 1 0 0 ] } coordIndex"),
        "number 1 of the colorIndex of a 'IndexedFaceSet' is 99, which is no index into 1 values",
    ),
    (
        "texidx.wrl",
        vrml().replace("coordIndex", "texCoordIndex [ 0 1 99 -1 ] texCoord TextureCoordinate { point [ 0 0 ] } coordIndex"),
        "number 2 of the texCoordIndex of a 'IndexedFaceSet' is 1, which is no index into 1 values",
    ),
    (
        "colshort.wrl",
        vrml().replace("coordIndex", "colorPerVertex TRUE color Color { color [ 1 0 0 ] } coordIndex"),
        "a Color of it has 1 values, but its faces take 3",
    ),
    ("pointset.wrl", "#VRML V2.0 utf8\nShape { geometry PointSet { coord Coordinate { point [ 0 0 0 ] } } }", (1, 0)),
    ("box.wrl", "#VRML V2.0 utf8\nShape { geometry Box { } }", "it has no shape that is known here, but nodes Box"),
    ("empty.wrl", "#VRML V2.0 utf8\n", "no vertex could be read from it"),
    (
        "huge.wrl",
        vrml(points="1e39 0 0 1 0 0 0 1 0"),
        (3, 1),
    ),
    ("commas.wrl", vrml(points="0,5 0 0 1 0 0 0 1"), (3, 1)),
    (
        "longstr.wrl",
        vrml() + 'WorldInfo { title "' + "a" * 3000000 + '" }',
        (3, 1, "nodes WorldInfo (1)"),
    ),
    ("manynodes.wrl", "#VRML V2.0 utf8\n" + "Group { }\n" * 200000, "or more than 100,000"),
    ("nan.x3d", x3d(points="nan 0 0 1 0 0 0 1 0"), "number 1 of the values of a Coordinate is not finite"),
    ("short.x3d", x3d(points="0 0 0 1 0 0 0 1"), "the values of a Coordinate are 8 numbers, which is no multiple of 3"),
    ("noend.x3d", x3d(corners="0 1 2"), (3, 1)),
    (
        "rep.x3d",
        x3d(corners="0 1 1 -1"),
        (3, 1),
    ),
    ("comma.x3d", x3d(points="0, 0 0, 1 0 0, 0 1 0"), (3, 1)),
    (
        "script.x3d",
        x3d(more='<Script url="x.js"/>'),
        "it has a node of the type Script, which is not supported; save it without such nodes",
    ),
    (
        "use.x3d",
        x3d().replace("<Coordinate", '<Coordinate USE="zz"'),
        "it uses 'zz', which is not defined before",
    ),
    (
        "proto.x3d",
        x3d(more='<ExternProtoDeclare url="x" name="a"/>'),
        "it has a node of the type ExternProtoDeclare, which is not supported; save it without such nodes",
    ),
    ("tri.x3d", x3d().replace("IndexedFaceSet", "IndexedTriangleSet").replace('coordIndex="0 1 2 -1"', 'index="0 1 2"'), (3, 1)),
    (
        "trioor.x3d",
        x3d().replace("IndexedFaceSet", "IndexedTriangleSet").replace('coordIndex="0 1 2 -1"', 'index="0 1 9"'),
        "number 3 of the index of a 'IndexedTriangleSet' is 9, which is no index into 3 values",
    ),
    (
        "colidx.x3d",
        x3d().replace("coordIndex", 'colorIndex="99 -1" coordIndex'),
        (3, 1),
    ),
    ("box.x3d", "<X3D><Scene><Shape><Box/></Shape></Scene></X3D>", "it has no shape that is known here, but nodes Box"),
    (
        "deep.x3d",
        "<X3D><Scene>" + "<Group>" * 3000 + "</Group>" * 3000 + "</Scene></X3D>",
        "it has elements more than 200 levels deep",
    ),
    ("empty.x3d", "<X3D/>", "it holds no X3D document with a scene"),
)
