"""3MF archives that are right."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Mapping
from typing import Any

from .made_gltf import png
from .solids import ONE, POINTS, TRIANGLES, Array, Made, boxes, moved, scaled, turned, words

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_MATERIAL = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
_PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
_TYPES = (
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType='
    '"application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="png" ContentType="image/png"/><Default '
    'Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)


def _relations(target: str, kind: str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel") -> str:
    return (
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
        f'<Relationship Target="{target}" Id="r0" Type="{kind}"/></Relationships>'
    )


def archive(
    model: str | bytes,
    *,
    name: str = "3D/3dmodel.model",
    parts: Mapping[str, str | bytes] = {},
    method: int = zipfile.ZIP_DEFLATED,
) -> bytes:
    """An archive of a model and other parts."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as file:
        for part, data in {
            "[Content_Types].xml": _TYPES,
            "_rels/.rels": _relations(f"/{name}"),
            name: model,
            **(parts or {}),
        }.items():
            file.writestr(part, data)
    return stream.getvalue()


def model(objects: str, items: str = '<item objectid="1"/>', *, unit: str = "", more: str = "", resources: str = "") -> str:
    """A model."""
    spaces = f'xmlns="{_CORE}" xmlns:m="{_MATERIAL}" xmlns:p="{_PRODUCTION}"'
    unit = f' unit="{unit}"' if unit else ""
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><model{unit} xml:lang="en-US" {spaces}{more}><resources>{resources}{objects}'
        f"</resources><build>{items}</build></model>"
    )


def mesh(id: int = 1, attributes: str = "", of_triangles: Any = lambda k: "") -> str:
    """An object of the box."""
    points = "".join(f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>' for x, y, z in POINTS)
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"{of_triangles(k)}/>' for k, (a, b, c) in enumerate(TRIANGLES))
    return f'<object id="{id}"{attributes}><mesh><vertices>{points}</vertices><triangles>{faces}</triangles></mesh></object>'


def _transform(m: Array) -> str:
    return f' transform="{words(m[:3].T)}"'


def made() -> Iterator[Made]:
    """All of them."""
    t, r, s = moved(3, -2, 5), turned(1, 2, 3, 40), scaled(2, 0.5, 3)
    counted = {"vertices": 8, "faces": 12}
    yield Made("plain.3mf", archive(model(mesh())), **boxes(ONE), more={**counted, "unit": "mm"})
    yield Made("stored.3mf", archive(model(mesh()), method=zipfile.ZIP_STORED), **boxes(ONE), more=counted)
    units = {"micron": "um", "millimeter": "mm", "centimeter": "cm", "inch": "in", "foot": "ft", "meter": "m"}
    for unit, short in units.items():
        yield Made(f"unit_{unit}.3mf", archive(model(mesh(), unit=unit)), **boxes(ONE), more={"unit": short})
    for name, m in (("move", t), ("turn", r), ("scale", s), ("all", t @ r @ s), ("mirror", scaled(-1, 2, 1))):
        item = f'<item objectid="1"{_transform(m)}/>'
        yield Made(f"item_{name}.3mf", archive(model(mesh(), item)), **boxes(m))
    two = f'<item objectid="1"/><item objectid="1"{_transform(t)}/>'
    yield Made("two_items.3mf", archive(model(mesh(), two)), **boxes(ONE, t), more={"vertices": 16, "faces": 24})
    yield Made(
        "two_objects.3mf",
        archive(model(mesh() + mesh(2), f'<item objectid="1"/><item objectid="2"{_transform(s)}/>')),
        **boxes(ONE, s),
    )
    both = f'<component objectid="1"{_transform(s)}/><component objectid="1"{_transform(r)}/>'
    parts = f'<object id="2"><components>{both}</components></object>'
    item = f'<item objectid="2"{_transform(t)}/>'
    yield Made("components.3mf", archive(model(mesh() + parts, item)), **boxes(t @ s, t @ r))
    deeper = f'<object id="3"><components><component objectid="2"{_transform(r)}/></components></object>'
    item = f'<item objectid="3"{_transform(t)}/>'
    yield Made("nested_components.3mf", archive(model(mesh() + parts + deeper, item)), **boxes(t @ r @ s, t @ r @ r))
    yield Made("not_built.3mf", archive(model(mesh() + mesh(2), f'<item objectid="2"{_transform(t)}/>')), **boxes(t))
    yield Made("other_name.3mf", archive(model(mesh()), name="other/thing.model"), **boxes(ONE))
    stray: dict[str, str | bytes] = {"3D/stray.model": model(mesh(), f'<item objectid="1"{_transform(t)}/>')}
    yield Made("stray_model.3mf", archive(model(mesh()), parts=stray), **boxes(ONE), named=("stray",))
    far: dict[str, str | bytes] = {
        "3D/part.model": model(mesh(7), ""),
        "3D/_rels/3dmodel.model.rels": _relations("/3D/part.model"),
    }
    joined = f'<object id="2"><components><component objectid="7" p:path="/3D/part.model"{_transform(s)}/></components></object>'
    build = f'<item objectid="2"{_transform(t)}/>'
    for name, more in (("production", ""), ("production_required", ' requiredextensions="p"')):
        yield Made(f"{name}.3mf", archive(model(joined, build, more=more), parts=far), **boxes(t @ s), named=("production",))
    same: dict[str, str | bytes] = {"3D/part.model": model(mesh(1), "")}
    both = f'<item objectid="1"/><item objectid="1" p:path="/3D/part.model"{_transform(t)}/>'
    yield Made("same_number_in_two_models.3mf", archive(model(mesh(), both), parts=same), **boxes(ONE, t), named=("production",))
    yield Made("support.3mf", archive(model(mesh(1, ' type="support"'))), **boxes(ONE), named=("support",))
    colour: dict[str, Any] = {"colour": (51, 102, 204)}
    base = (
        '<basematerials id="5"><base name="a" displaycolor="#FFFFFF"/><base name="b" displaycolor="#3366CCFF"/></basematerials>'
    )
    yield Made("base_material.3mf", archive(model(mesh(1, ' pid="5" pindex="1"'), resources=base)), **boxes(ONE), more=colour)
    faces = mesh(1, ' pid="5" pindex="0"', lambda k: ' p1="1"')
    yield Made("base_materials_of_triangles.3mf", archive(model(faces, resources=base)), **boxes(ONE), more=colour)
    group = '<m:colorgroup id="5"><m:color color="#FFFFFFFF"/><m:color color="#3366CC"/></m:colorgroup>'
    for name, text in (("one", ' pid="5" p1="1"'), ("three", ' pid="5" p1="1" p2="1" p3="1"')):
        faces = mesh(1, "", lambda k, text=text: text)
        yield Made(f"colours_{name}.3mf", archive(model(faces, resources=group)), **boxes(ONE), more=colour)
    picture = (
        '<m:texture2d id="4" path="/3D/Textures/a.png" contenttype="image/png"/><m:texture2dgroup id="5" texid="4">'
        '<m:tex2coord u="0.1" v="0.2"/><m:tex2coord u="0.3" v="0.6"/><m:tex2coord u="0.5" v="0.4"/></m:texture2dgroup>'
    )
    faces = mesh(1, "", lambda k: ' pid="5" p1="0" p2="1" p3="2"')
    beside: dict[str, str | bytes] = {
        "3D/Textures/a.png": png(),
        "3D/_rels/3dmodel.model.rels": _relations("/3D/Textures/a.png", f"{_CORE}/3dtexture"),
    }
    known: dict[str, Any] = {"uv": (0.3, 0.4), "image": True}
    yield Made("texture.3mf", archive(model(faces, resources=picture), parts=beside), **boxes(ONE), more=known)
    needs = model(
        mesh(), more=' xmlns:b="http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02" requiredextensions="b"'
    )
    yield Made("beams.3mf", archive(needs), **boxes(ONE), named=("beamlattice",))
    utf16 = model(mesh()).replace("UTF-8", "UTF-16").encode("utf-16")
    yield Made("utf16.3mf", archive(utf16), **boxes(ONE))
    prefixed = model(mesh()).replace("xmlns=", "xmlns:c=").replace("</", "</c:")
    for tag in ("model", "resources", "object", "mesh", "vertices", "vertex", "triangles", "triangle", "build", "item"):
        prefixed = prefixed.replace(f"<{tag} ", f"<c:{tag} ").replace(f"<{tag}>", f"<c:{tag}>")
    yield Made("prefixed.3mf", archive(prefixed), **boxes(ONE))
    titled = model(mesh()).replace("<resources>", '<metadata name="Title">a</metadata><resources>')
    yield Made("title.3mf", archive(titled), **boxes(ONE))
