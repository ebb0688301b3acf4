"""3MF archives that lie."""

from __future__ import annotations

import io
import warnings
import zipfile
from collections.abc import Iterable

from ..documents import MODEL, three_mf

_NAMESPACE = 'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"'
_POINTS = "".join(f'<vertex x="{x}" y="{y}" z="0"/>' for x, y in ((0, 0), (1, 0), (0, 1)))


def _model(objects: str, built: int) -> bytes:
    resources = f'<resources>{objects}</resources><build><item objectid="{built}"/></build>'
    return three_mf(model=f'<model unit="millimeter" {_NAMESPACE}>{resources}</model>')


def _of_ten(number: int) -> str:
    """An object that places the one before it ten times."""
    parts = f'<component objectid="{number - 1}"/>' * 10
    return f'<object id="{number}" type="model"><components>{parts}</components></object>'


def _changed(old: str, new: str) -> bytes:
    return three_mf(model=MODEL.format(points=_POINTS, last=2).replace(old, new))


def _archive(parts: Iterable[tuple[str, str | bytes]]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about a name that is there twice
        for name, text in parts:
            archive.writestr(name, text)
    return stream.getvalue()


with zipfile.ZipFile(io.BytesIO(three_mf())) as _honest:
    _PARTS: list[tuple[str, str | bytes]] = [(name, _honest.read(name)) for name in _honest.namelist()]
_MESH = f'<object id="1" type="model"><mesh><vertices>{_POINTS}</vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles>'
_BOMB = _model(f"{_MESH}</mesh></object>" + "".join(map(_of_ten, range(2, 11))), 10)
_ITEM = '<item objectid="1"/>'

#: name, what it says, and what the refusal says or how many vertices and faces are read and what the warnings say
ROWS = (
    (
        "self.3mf",
        _model('<object id="1" type="model"><components><component objectid="1"/></components></object>', 1),
        "one of its parts contains itself",
    ),
    (
        "expbomb.3mf",
        _BOMB,
        "it places more than 100,000 parts",
    ),
    (
        "nan.3mf",
        _changed('"1"', '"nan"'),
        "number 4 of the coordinates of object 'nan' is not finite",
    ),
    (
        "word.3mf",
        _changed('"1"', '"abc"'),
        "'abc' among the coordinates of object 'abc' is no number; decimals are written with a point",
    ),
    (
        "comma.3mf",
        _changed('"1"', '"0,5"'),
        "'0,5' among the coordinates of object '0,5' is no number; decimals are written with a point",
    ),
    ("neg.3mf", three_mf(last=-1), "number 3 of the corners of object '1' is -1, which is no index into 3 values"),
    ("float.3mf", three_mf(last=1.5), "number 3 of the corners of object '1' is no whole number"),
    (
        "noobj.3mf",
        _changed('objectid="1"', 'objectid="9"'),
        "it places the object '9', which is not there",
    ),
    (
        "nobuild.3mf",
        _changed('<item objectid="1"/>', ""),
        "it builds no mesh",
    ),
    (
        "twice.3mf",
        _changed(_ITEM, _ITEM * 2),
        (6, 4),
    ),
    (
        "transform.3mf",
        _changed('<item objectid="1"/>', '<item objectid="1" transform="2 0 0 0 2 0 0 0 2 5 5 5"/>'),
        (3, 2),
    ),
    (
        "transbad.3mf",
        _changed('<item objectid="1"/>', '<item objectid="1" transform="2 0 0"/>'),
        "a transform of it has 3 numbers and not 12",
    ),
    ("inch.3mf", _changed("millimeter", "inch"), (3, 2)),
    ("unitx.3mf", _changed("millimeter", "cubit"), "its unit is 'cubit', which no 3MF file can have"),
    (
        "deg.3mf",
        three_mf(last=1),
        (3, 2),
    ),
    (
        "dupname.3mf",
        _archive(_PARTS + _PARTS[2:]),
        "its part '3D/3dmodel.model' is there twice, or its name is not allowed",
    ),
    ("abs.3mf", _archive([*_PARTS, ("/etc/x", "a")]), "its part '/etc/x' is there twice, or its name is not allowed"),
    ("back.3mf", _archive([*_PARTS, ("..\\x", "a")]), "its part '..\\\\x' is there twice, or its name is not allowed"),
    ("manyfiles.3mf", _archive(_PARTS + [(f"f{k}", "") for k in range(70000)]), "it holds 70,003 parts; 10,000 are the most"),
    (
        "enc.3mf",
        (lambda b: b.replace(b"PK\x01\x02\x14\x03\x14\x00\x00\x00", b"PK\x01\x02\x14\x03\x14\x00\x01\x00"))(three_mf()),
        "its archive cannot be read (File <ZipInfo filename='_rels/.rels' compress_type=deflate filemode='?rw-------')",
    ),
    ("notzip.3mf", b"PK\x03\x04" + bytes(100), "its archive cannot be read (File is not a zip file)"),
    ("nomodel.3mf", _archive(_PARTS[:2]), "it holds no part '/3D/3dmodel.model'"),
    (
        "norels.3mf",
        _archive([_PARTS[0], _PARTS[2]]),
        "it holds no part '_rels/.rels'",
    ),
    (
        "onlymodel.3mf",
        _archive(_PARTS[2:]),
        "it holds no part '_rels/.rels'",
    ),
    ("textmodel.3mf", _archive([*_PARTS[:2], ("3D/3dmodel.model", "hello")]), "its line 1 is no XML: syntax error"),
    (
        "textures.3mf",
        _archive([*_PARTS, ("3D/Textures/a.png", b"hello")]),
        (3, 2, "its part '3D/Textures/a.png'"),
    ),
)
