"""Scenes and archives of one triangle, in the formats that are documents: COLLADA, VRML, X3D and 3MF."""

from __future__ import annotations

import io
import zipfile

#: the image of a material, which the triangle has
IMAGE = """<library_images><image id="i"><init_from>{}</init_from></image></library_images><library_effects><effect id="e">
<profile_COMMON><technique sid="c"><phong><diffuse><texture texture="i" texcoord="u"/></diffuse></phong></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="w"><instance_effect url="#e"/></material></library_materials>"""
BOUND = '<bind_material><technique_common><instance_material symbol="m" target="#w"/></technique_common></bind_material>'
COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
{image}
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="{count}">{points}</float_array>
<technique_common><accessor source="#a" count="{accessor}" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"{material}><input semantic="VERTEX" source="#v" offset="0"/><p>{corners}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">
<node id="n"><instance_geometry url="{url}">{bound}</instance_geometry></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
VRML = """#VRML V2.0 utf8
Shape {{ {more} appearance Appearance {{ texture ImageTexture {{ url {url} }} }}
geometry IndexedFaceSet {{ coord DEF C Coordinate {{ point [ {points} ] }} coordIndex [ {corners} ]{mapped} }} }}
"""
X3D = """<X3D version="3.1"><Scene><Shape><Appearance><ImageTexture url='{url}'/></Appearance>{more}
<IndexedFaceSet coordIndex="{corners}"><Coordinate point="{points}"/>{mapped}</IndexedFaceSet></Shape></Scene></X3D>
"""
MODEL = """<?xml version="1.0"?>
<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">
<mesh><vertices>{points}</vertices><triangles><triangle v1="0" v2="1" v3="{last}"/><triangle v1="0" v2="2" v3="1"/></triangles>
</mesh></object></resources><build><item objectid="1"/></build></model>
"""
_HONEST: dict[str, dict[str, object]] = {
    "collada": {"count": 9, "points": "0 0 0 1 0 0 0 1 0", "accessor": 3, "corners": "0 1 2", "url": "#g"},
    "vrml": {"url": '""', "points": "0 0 0, 1 0 0, 0 1 0", "corners": "0 1 2 -1", "more": ""},
    "x3d": {"url": "", "points": "0 0 0 1 0 0 0 1 0", "corners": "0 1 2 -1", "more": ""},
}


def collada(image: str = "", **changes: object) -> str:
    """A COLLADA document; with an image it is the texture of the triangle."""
    text = COLLADA if image else COLLADA.replace(">{bound}</instance_geometry>", "/>")
    bound = {"image": IMAGE.format(image), "material": ' material="m"', "bound": BOUND}
    empty = {"image": "<library_images></library_images>", "material": "", "bound": ""}
    return text.format(**(bound if image else empty), **_HONEST["collada"] | changes)


def vrml(**changes: object) -> str:
    """A scene in VRML 2.0; with a name of an image it is the texture of the triangle."""
    mapped = " texCoord TextureCoordinate { point [ 0 0, 1 0, 0 1 ] }" if "url" in changes else ""
    return VRML.format(**_HONEST["vrml"] | changes, mapped=mapped)


def x3d(**changes: object) -> str:
    """A scene in X3D; with a name of an image it is the texture of the triangle."""
    mapped = '<TextureCoordinate point="0 0 1 0 0 1"/>' if "url" in changes else ""
    return X3D.format(**_HONEST["x3d"] | changes, mapped=mapped)


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
