"""Scenes and archives of one triangle, in the formats that are documents: COLLADA, VRML, X3D and 3MF."""

from __future__ import annotations

import io
import zipfile

COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_images><image id="i"><init_from>{image}</init_from></image></library_images>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{count}">{points}</float_array>
<technique_common><accessor source="#a" count="{accessor}" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>{corners}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="{url}"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
VRML = """#VRML V2.0 utf8
Shape {{ {more} appearance Appearance {{ texture ImageTexture {{ url {url} }} }}
geometry IndexedFaceSet {{ coord DEF C Coordinate {{ point [ {points} ] }} coordIndex [ {corners} ] }} }}
"""
X3D = """<X3D version="3.1"><Scene><Shape><Appearance><ImageTexture url='{url}'/></Appearance>{more}
<IndexedFaceSet coordIndex="{corners}"><Coordinate point="{points}"/></IndexedFaceSet></Shape></Scene></X3D>
"""
MODEL = """<?xml version="1.0"?>
<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">
<mesh><vertices>{points}</vertices><triangles><triangle v1="0" v2="1" v3="{last}"/><triangle v1="0" v2="2" v3="1"/></triangles>
</mesh></object></resources><build><item objectid="1"/></build></model>
"""
_HONEST: dict[str, dict[str, object]] = {
    "collada": {"image": "t.png", "count": 9, "points": "0 0 0 1 0 0 0 1 0", "accessor": 3, "corners": "0 1 2", "url": "#g"},
    "vrml": {"url": '"t.png"', "points": "0 0 0, 1 0 0, 0 1 0", "corners": "0 1 2 -1", "more": ""},
    "x3d": {"url": '"t.png"', "points": "0 0 0 1 0 0 0 1 0", "corners": "0 1 2 -1", "more": ""},
}


def collada(**changes: object) -> str:
    """A COLLADA document."""
    return COLLADA.format(**_HONEST["collada"] | changes)


def vrml(**changes: object) -> str:
    """A scene in VRML 2.0."""
    return VRML.format(**_HONEST["vrml"] | changes)


def x3d(**changes: object) -> str:
    """A scene in X3D."""
    return X3D.format(**_HONEST["x3d"] | changes)


def three_mf(*, last: float = 2, model: str = "", name: str = "3D/3dmodel.model", more: bytes = b"") -> bytes:
    """A 3MF archive of a model, and of more bytes beside it."""
    points = "".join(f'<vertex x="{x}" y="{y}" z="0"/>' for x, y in ((0, 0), (1, 0), (0, 1)))
    relations = "http://schemas.openxmlformats.org/package/2006/relationships"
    types = "http://schemas.openxmlformats.org/package/2006/content-types"
    kind = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
    parts = {
        "[Content_Types].xml": f'<Types xmlns="{types}"><Default Extension="model" ContentType="application/'
        'vnd.ms-package.3dmanufacturing-3dmodel+xml"/><Default Extension="rels" ContentType="application/'
        'vnd.openxmlformats-package.relationships+xml"/></Types>',
        "_rels/.rels": f'<Relationships xmlns="{relations}"><Relationship Type="{kind}" Target="/3D/3dmodel.model" Id="r"/>'
        "</Relationships>",
        name: model or MODEL.format(points=points, last=last),
    }
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for part, text in parts.items():
            archive.writestr(part, text)
        if more:
            archive.writestr("more.bin", more)
    return stream.getvalue()
