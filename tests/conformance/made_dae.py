"""COLLADA documents that are right."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .made_gltf import png
from .solids import (
    CONCAVE_AREA,
    CONCAVE_FACES,
    CONCAVE_POINTS,
    CONCAVE_VOLUME,
    ONE,
    POINTS,
    QUADS,
    TRIANGLES,
    Made,
    boxes,
    moved,
    scaled,
    turned,
    words,
)

_HEAD = '<?xml version="1.0" encoding="utf-8"?>\n<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
CONCAVE: dict[str, Any] = {
    "area": CONCAVE_AREA,
    "volume": CONCAVE_VOLUME,
    "low": (0, 0, 0),
    "high": (4, 3, 1),
}


def source(name: str, values: Any, params: str = "XYZ", *, stride: int = 0, offset: int = 0, count: int = 0) -> str:
    """A source of floats; a blank in `params` is a value without a name."""
    flat = np.asarray(values, float).ravel()
    stride = stride or len(params)
    count = count or (len(flat) - offset) // stride
    named = "".join(f'<param name="{p}" type="float"/>' if p != " " else '<param type="float"/>' for p in params)
    return (
        f'<source id="{name}"><float_array id="{name}-array" count="{len(flat)}">{words(flat)}</float_array><technique_common>'
        f'<accessor source="#{name}-array" count="{count}" stride="{stride}" offset="{offset}">{named}</accessor>'
        "</technique_common></source>"
    )


def mesh(primitives: str, sources: str = "", vertices: str = "", name: str = "g") -> str:
    """A geometry; its positions are the source p."""
    sources = sources or source("p", POINTS)
    inputs = f'<vertices id="v"><input semantic="POSITION" source="#p"/>{vertices}</vertices>'
    return f'<geometry id="{name}"><mesh>{sources}{inputs}{primitives}</mesh></geometry>'


def triangles(corners: Any = TRIANGLES, more: str = "", kind: str = "triangles", count: int = 0, material: str = "") -> str:
    """Triangles of a mesh."""
    flat = np.asarray(corners).ravel()
    material = f' material="{material}"' if material else ""
    head = f'<{kind} count="{count or len(flat) // 3}"{material}><input semantic="VERTEX" source="#v" offset="0"/>{more}'
    return f"{head}<p>{words(flat)}</p></{kind}>"


def polylist(faces: Sequence[Sequence[int]], kind: str = "polylist") -> str:
    """Faces of any number of corners."""
    head = f'<{kind} count="{len(faces)}"><input semantic="VERTEX" source="#v" offset="0"/>'
    if kind == "polygons":
        return head + "".join(f"<p>{words(f)}</p>" for f in faces) + "</polygons>"
    return f"{head}<vcount>{words([len(f) for f in faces])}</vcount><p>{words([i for f in faces for i in f])}</p></polylist>"


def document(
    geometries: str,
    nodes: str = '<node><instance_geometry url="#g"/></node>',
    *,
    more: str = "",
    asset: str = "",
    scenes: str = "",
) -> bytes:
    """A whole document."""
    scenes = scenes or f'<visual_scene id="s">{nodes}</visual_scene>'
    return (
        f"{_HEAD}<asset>{asset}</asset>{more}<library_geometries>{geometries}</library_geometries><library_visual_scenes>{scenes}"
        '</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    ).encode()


def _node(*transforms: str, inner: str = '<instance_geometry url="#g"/>') -> str:
    return f"<node>{''.join(transforms)}{inner}</node>"


_AXIS = words(np.array([1, 2, 3]) / 14**0.5)
_T, _R, _S = "<translate>3 -2 5</translate>", f"<rotate>{_AXIS} 40</rotate>", "<scale>2 0.5 3</scale>"
_MATRIX = {_T: moved(3, -2, 5), _R: turned(1, 2, 3, 40), _S: scaled(2, 0.5, 3)}


def _placed() -> Iterator[Made]:
    one = mesh(triangles())
    for order in itertools.permutations((_T, _R, _S)):
        name = "-".join(t[1] for t in order)
        yield Made(f"order_{name}.dae", document(one, _node(*order)), **boxes(np.linalg.multi_dot([_MATRIX[t] for t in order])))
    m = moved(1, 2, 3) @ turned(0, 1, 1, 30) @ scaled(1, 2, 3)
    text = f"<matrix>{words(m)}</matrix>"
    yield Made("matrix_times_2.dae", document(one, _node(f"<matrix>{words(2 * m)}</matrix>")), **boxes(m))
    yield Made("matrix_and_scale.dae", document(one, _node(_S, text, _T)), **boxes(_MATRIX[_S] @ m @ _MATRIX[_T]))
    turns = "<rotate>0 0 1 90</rotate><rotate>0 1 0 45</rotate><rotate>1 0 0 30</rotate>"
    yield Made(
        "three_turns.dae", document(one, _node(turns)), **boxes(turned(0, 0, 1, 90) @ turned(0, 1, 0, 45) @ turned(1, 0, 0, 30))
    )
    nested = _node(_T, inner=_node(_R, inner=_node(_S)))
    yield Made("nested.dae", document(one, nested), **boxes(_MATRIX[_T] @ _MATRIX[_R] @ _MATRIX[_S]))
    yield Made("mirror.dae", document(one, _node("<scale>-1 2 1</scale>")), **boxes(scaled(-1, 2, 1)))
    eye = np.array([1.0, 2, 3])
    back = (eye - [4, 4, 1]) / np.linalg.norm(eye - [4, 4, 1])
    side = np.cross([0, 0, 1], back)
    side /= np.linalg.norm(side)
    look = np.eye(4)
    look[:3] = np.column_stack([side, np.cross(back, side), back, eye])
    yield Made("lookat.dae", document(one, _node("<lookat>1 2 3 4 4 1 0 0 1</lookat>")), **boxes(look), named=("lookat",))
    skew = np.eye(4)
    skew[0, 1] = np.tan(np.radians(30))
    yield Made("skew.dae", document(one, _node("<skew>30 0 1 0 1 0 0</skew>")), **boxes(skew), named=("skew",))
    twice = _node(_T, inner='<instance_geometry url="#g"/>' * 2)
    yield Made("twice.dae", document(one, twice), **boxes(_MATRIX[_T], _MATRIX[_T]), more={"vertices": 16})
    yield Made("two_nodes.dae", document(one, _node(_T) + _node(_S)), **boxes(_MATRIX[_T], _MATRIX[_S]))
    library = f'<library_nodes><node id="n">{_S}<instance_geometry url="#g"/></node></library_nodes>'
    used = _node(_T, inner='<instance_node url="#n"/>') + _node(_R, inner='<instance_node url="#n"/>')
    yield Made(
        "instance_nodes.dae", document(one, used, more=library), **boxes(_MATRIX[_T] @ _MATRIX[_S], _MATRIX[_R] @ _MATRIX[_S])
    )
    yield Made("node_library_alone.dae", document(one, _node(_T), more=library), **boxes(_MATRIX[_T]))
    scenes = f'<visual_scene id="other">{_node(_S)}</visual_scene><visual_scene id="s">{_node(_T)}</visual_scene>'
    yield Made("second_scene.dae", document(one, scenes=scenes), **boxes(_MATRIX[_T]))
    yield Made(
        "geometry_not_placed.dae",
        document(one + mesh(triangles(TRIANGLES[:3]), source("q", POINTS * 9).replace("q", "p2"), name="h").replace("#p", "#p2")),
        **boxes(ONE),
    )
    for meter, unit in ((0.01, "cm"), (0.001, "mm"), (1, "m"), (0.0254, "in"), (0.3048, "ft")):
        asset = f'<unit meter="{meter}" name="x"/><up_axis>Z_UP</up_axis>'
        yield Made(f"unit_{unit}.dae", document(one, asset=asset), **boxes(ONE), more={"unit": unit})
    skin = (
        '<library_controllers><controller id="c"><skin source="#g"><bind_shape_matrix>'
        f'{words(_MATRIX[_T])}</bind_shape_matrix><source id="j"><Name_array id="ja" count="0"/></source></skin></controller>'
        "</library_controllers>"
    )
    yield Made(
        "controller.dae",
        document(one, _node(inner='<instance_controller url="#c"/>'), more=skin),
        **boxes(_MATRIX[_T]),
        named=("controller",),
    )
    bent = skin.replace("0 1</bind_shape_matrix>", "0.5 1</bind_shape_matrix>")
    yield Made(
        "bent_controller.dae",
        document(one, _node(inner='<instance_controller url="#c"/>'), more=bent),
        **boxes(ONE),
        named=("the last row",),
    )


def _primitives() -> Iterator[Made]:
    box = boxes(ONE)
    yield Made("triangles.dae", document(mesh(triangles())), **box, more={"vertices": 8, "faces": 12})
    yield Made("polylist.dae", document(mesh(polylist(QUADS))), **box, more={"vertices": 8, "faces": 12})
    yield Made("polygons.dae", document(mesh(polylist(QUADS, "polygons"))), **box, more={"vertices": 8, "faces": 12})
    yield Made("mixed_lists.dae", document(mesh(polylist(QUADS[:3]) + triangles(TRIANGLES[6:]))), **box, more={"vertices": 8})
    mixed = [QUADS[0], *map(tuple, TRIANGLES[2:6].tolist()), *QUADS[3:]]
    yield Made("mixed_polylist.dae", document(mesh(polylist(mixed))), **box, more={"faces": 12})
    concave = source("p", CONCAVE_POINTS)
    for kind in ("polylist", "polygons"):
        yield Made(f"concave_{kind}.dae", document(mesh(polylist(CONCAVE_FACES, kind), concave)), **CONCAVE)
        turned_over = [f[k:] + f[:k] for k, f in zip(range(9), CONCAVE_FACES, strict=True)]
        yield Made(f"concave_{kind}_from_another_corner.dae", document(mesh(polylist(turned_over, kind), concave)), **CONCAVE)
    for kind, order in (("tristrips", (0, 1, 3, 2)), ("trifans", (0, 1, 2, 3))):
        strips = "".join(f"<p>{words([q[k] for k in order])}</p>" for q in QUADS)
        text = f'<{kind} count="6"><input semantic="VERTEX" source="#v" offset="0"/>{strips}</{kind}>'
        yield Made(f"{kind}.dae", document(mesh(text)), **box, more={"faces": 12}, named=(kind,))
    outline = np.array([[0, 0, 0], [6, 0, 0], [6, 6, 0], [0, 6, 0], [2, 2, 0], [2, 4, 0], [4, 4, 0], [4, 2, 0]], float)
    hole = '<polygons count="1"><input semantic="VERTEX" source="#v" offset="0"/><ph><p>0 1 2 3</p><h>4 5 6 7</h></ph></polygons>'
    known: dict[str, Any] = {"area": 32.0, "low": (0, 0, 0), "high": (6, 6, 0)}
    yield Made("hole.dae", document(mesh(hole, source("p", outline))), **known, named=("hole",))
    lines = '<lines count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 3</p></lines>'
    yield Made("lines_too.dae", document(mesh(triangles() + lines)), **box, named=("lines",))
    for name, data in (("no_faces", triangles([], count=0)), ("empty_p", '<triangles count="0"><p/></triangles>')):
        yield Made(f"{name}.dae", document(mesh(triangles() + data)), **box)


def _inputs() -> Iterator[Made]:
    box = boxes(ONE)
    wide = np.column_stack([POINTS, np.full(8, 77.0)])
    before = np.concatenate([[9.0, 9, 9, 9], wide.ravel()])
    rest = np.concatenate([POINTS, np.full((4, 3), 50.0)])
    for name, text in (
        ("stride", source("p", wide, "XYZ", stride=4)),
        ("stride_with_four_params", source("p", wide, "XYZ ")),
        ("offset", source("p", before, "XYZ", stride=4, offset=4)),
        ("unnamed_param", source("p", np.column_stack([np.full(8, 55.0), POINTS]), " XYZ")),
        ("unnamed_in_the_middle", source("p", np.column_stack([POINTS[:, :1], np.full(8, 5.0), POINTS[:, 1:]]), "X YZ")),
        ("count_below_the_array", source("p", rest, count=8)),
        (
            "no_params",
            source("p", POINTS, "XYZ")
            .replace('<param name="X" type="float"/>', "")
            .replace('<param name="Y" type="float"/>', "")
            .replace('<param name="Z" type="float"/>', ""),
        ),
    ):
        yield Made(f"{name}.dae", document(mesh(triangles(), text)), **box, more={"vertices": 8}, named=("param",))
    uv = np.array([[0.1, 0.2], [0.3, 0.6], [0.5, 0.4]])
    corners = np.stack([np.tile([0, 1, 2], (12, 1)), TRIANGLES, np.zeros((12, 3), int)], axis=2)
    sources = source("p", POINTS) + source("t", uv, "ST") + source("n", [[0, 0.6, 0.8]])
    inputs = (
        '<input semantic="TEXCOORD" source="#t" offset="0" set="0"/><input semantic="VERTEX" source="#v" offset="1"/>'
        '<input semantic="NORMAL" source="#n" offset="2"/>'
    )
    text = f'<triangles count="12" material="m">{inputs}<p>{words(corners)}</p></triangles>'
    yield Made("three_inputs.dae", document(mesh(text, sources)), **box, more={"vertices": 8, "normal": (0, 0.6, 0.8)})
    for kind in ("profile", "direct"):
        image = '<library_images><image id="i"><init_from>a%20b.png</init_from></image></library_images>'
        params = (
            '<newparam sid="surface"><surface type="2D"><init_from>i</init_from></surface></newparam>'
            '<newparam sid="sampler"><sampler2D><source>surface</source></sampler2D></newparam>'
        )
        texture = '<texture texture="sampler" texcoord="uv"/>' if kind == "profile" else '<texture texture="i" texcoord="uv"/>'
        effect = (
            f'<library_effects><effect id="e"><profile_COMMON>{params if kind == "profile" else ""}<technique sid="c"><phong>'
            f"<diffuse>{texture}</diffuse></phong></technique></profile_COMMON></effect></library_effects>"
            '<library_materials><material id="mat"><instance_effect url="#e"/></material></library_materials>'
        )
        bound = (
            '<node><instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="m" target="#mat">'
            '<bind_vertex_input semantic="uv" input_semantic="TEXCOORD" input_set="0"/></instance_material></technique_common>'
            "</bind_material></instance_geometry></node>"
        )
        two = source("p", POINTS) + source("t", uv, "ST") + source("n", [[0, 0.6, 0.8]]) + source("t9", uv * 0, "ST")
        more = inputs + '<input semantic="TEXCOORD" source="#t9" offset="0" set="1"/>'
        text = f'<triangles count="12" material="m">{more}<p>{words(corners)}</p></triangles>'
        yield Made(
            f"texture_{kind}.dae",
            document(mesh(text, two), bound, more=image + effect),
            **box,
            beside={"a b.png": png()},
            more={"uv": (0.3, 0.4), "image": True},
        )
    plain = (
        '<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert><diffuse><color>0.2 0.4 0.8 1</color>'
        '</diffuse></lambert></technique></profile_COMMON></effect></library_effects><library_materials><material id="mat">'
        '<instance_effect url="#e"/></material></library_materials>'
    )
    bound = bound.replace('<bind_vertex_input semantic="uv" input_semantic="TEXCOORD" input_set="0"/>', "")
    yield Made(
        "colour_of_material.dae",
        document(mesh(triangles(material="m")), bound, more=plain),
        **box,
        more={"colour": (51, 102, 204)},
    )
    colours = source("p", POINTS) + source("c", np.tile([0.2, 0.4, 0.8], (8, 1)), "RGB")
    more = '<input semantic="COLOR" source="#c" offset="0"/>'
    yield Made("colours_of_corners.dae", document(mesh(triangles(more=more), colours)), **box, more={"colour": (51, 102, 204)})
    of_vertices = '<input semantic="COLOR" source="#c"/>'
    yield Made(
        "colours_of_vertices.dae",
        document(mesh(triangles(), colours, of_vertices)),
        **box,
        more={"colour": (51, 102, 204)},
    )
    prefixed = document(mesh(triangles())).decode().replace("xmlns=", "xmlns:c=").replace("</", "</c:")
    prefixed = prefixed.replace("<", "<c:").replace("<c:/c:", "</c:").replace("<c:?", "<?")
    yield Made("prefixed.dae", prefixed.encode(), **box)
    yield Made("utf16.dae", document(mesh(triangles())).decode().replace("utf-8", "utf-16").encode("utf-16"), **box)
    lines = document(mesh(triangles())).decode().replace(" ", "\n\t")
    yield Made("other_blanks.dae", lines.replace("<?xml\n\tversion", "<?xml version").encode(), **box)


def made() -> Iterator[Made]:
    """All of them."""
    yield from _placed()
    yield from _primitives()
    yield from _inputs()
