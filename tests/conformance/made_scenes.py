"""VRML and X3D scenes that are right: each from one tree, in three notations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from .made_dae import CONCAVE
from .made_gltf import png
from .solids import (
    CONCAVE_FACES,
    CONCAVE_POINTS,
    ONE,
    POINTS,
    QUADS,
    TRIANGLES,
    Array,
    Made,
    boxes,
    facts,
    moved,
    scaled,
    turned,
    words,
)


@dataclass
class Node:
    """A node: its type, its fields (texts, numbers, truths, nodes or lists of nodes), its name, or the name that it uses."""

    type: str
    fields: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""
    use: str = ""


def node(kind: str, called: str = "", use: str = "", **fields: Any) -> Node:
    """A node of these fields."""
    return Node(kind, fields, called, use)


_LISTS = {
    "point",
    "vector",
    "color",
    "coordIndex",
    "index",
    "colorIndex",
    "normalIndex",
    "texCoordIndex",
    "crossSection",
    "spine",
}
_LISTS |= {"height", "stripCount", "fanCount", "vertexCount", "orientation", "rangeList", "choice", "range"}


def vrml(n: Node) -> str:
    """A node in the words of VRML."""
    if n.use:
        return f"USE {n.use}"
    text = f"{f'DEF {n.name} ' if n.name else ''}{n.type} {{\n"
    for key, value in n.fields.items():
        if isinstance(value, Node):
            shown = vrml(value)
        elif isinstance(value, list) and value and isinstance(value[0], Node):
            shown = "[\n" + "\n".join(map(vrml, value)) + "\n]"
        elif isinstance(value, bool):
            shown = str(value).upper()
        elif isinstance(value, str):
            shown = f'"{value}"'
        else:
            shown = words(value)
            listed = key in _LISTS or (key == "scale" and n.type == "Extrusion")
            shown = f"[ {shown} ]" if listed and not (key == "orientation" and n.type != "Extrusion") else shown
        text += f"{key} {shown}\n"
    return text + "}"


def x3d(n: Node, field_name: str = "") -> str:
    """A node as an element."""
    contained = f" containerField={quoteattr(field_name)}" if field_name and field_name != "children" else ""
    if n.use:
        return f"<{n.type} USE={quoteattr(n.use)}{contained}/>"
    head, inner = f"<{n.type}" + (f" DEF={quoteattr(n.name)}" if n.name else "") + contained, ""
    for key, value in n.fields.items():
        nodes = (
            [value]
            if isinstance(value, Node)
            else value
            if isinstance(value, list) and isinstance((value or [0])[0], Node)
            else []
        )
        if nodes:
            inner += "".join(x3d(v, key) for v in nodes)
            continue
        shown = str(value).lower() if isinstance(value, bool) else f'"{value}"' if isinstance(value, str) else words(value)
        head += f" {key}={quoteattr(shown)}"
    return f"{head}>{inner}</{n.type}>"


def written(name: str, *nodes: Node, only: str = "", routes: str = "", **known: Any) -> Iterator[Made]:
    """A scene in all notations, or in those of X3D."""
    body = "\n".join(map(vrml, nodes)) + routes
    if only != "x3d":
        yield Made(f"{name}.wrl", f"#VRML V2.0 utf8\n# remark [ {{\n{body}\n".encode(), **known)
    head = '#X3D V3.3 utf8\nPROFILE Immersive\nMETA "title" "a"\n'
    yield Made(f"{name}.x3dv", f"{head}{body}\n".encode(), **known)
    xml = "".join(map(x3d, nodes))
    yield Made(
        f"{name}.x3d",
        f'<?xml version="1.0" encoding="UTF-8"?><X3D profile="Immersive" version="3.3"><Scene>{xml}</Scene></X3D>'.encode(),
        **known,
    )


def shape(geometry: Node, appearance: Node | None = None, name: str = "") -> Node:
    """A shape."""
    look: dict[str, Any] = {"appearance": appearance} if appearance else {}
    return node("Shape", name, **look, geometry=geometry)


def coordinates(points: Array, name: str = "") -> Node:
    """The coordinates of a geometry."""
    return node("Coordinate", name, point=points)


def ifs(faces: Any = QUADS, points: Array = POINTS, *, last: bool = True, **more: Any) -> Node:
    """An indexed face set."""
    flat = [i for f in faces for i in (*f, -1)]
    return node("IndexedFaceSet", coord=coordinates(points), coordIndex=np.array(flat if last else flat[:-1]), **more)


def _axis(x: float, y: float, z: float, degrees: float) -> list[float]:
    return [*(np.array([x, y, z]) / np.linalg.norm([x, y, z])).tolist(), float(np.radians(degrees))]


def _placed() -> Iterator[Made]:
    box = shape(ifs())
    t, r, s = moved(3, -2, 5), turned(1, 2, 3, 40), scaled(2, 0.5, 3)
    fields: dict[str, Any] = {"translation": [3, -2, 5], "rotation": _axis(1, 2, 3, 40), "scale": [2, 0.5, 3]}
    for key, m in (("translation", t), ("rotation", r), ("scale", s)):
        yield from written(f"transform_{key}", node("Transform", **{key: fields[key]}, children=[box]), **boxes(m))
    yield from written("transform_all", node("Transform", **fields, children=[box]), **boxes(t @ r @ s))
    c, cc = moved(1, 2, 3), moved(-1, -2, -3)
    yield from written("center", node("Transform", **fields, center=[1, 2, 3], children=[box]), **boxes(t @ c @ r @ s @ cc))
    o, oo = turned(0, 1, 1, 30), turned(0, 1, 1, -30)
    whole = {**fields, "center": [1, 2, 3], "scaleOrientation": _axis(0, 1, 1, 30)}
    yield from written("scale_orientation", node("Transform", **whole, children=[box]), **boxes(t @ c @ r @ o @ s @ oo @ cc))
    nested = node(
        "Transform",
        translation=[3, -2, 5],
        children=[
            node("Transform", rotation=_axis(1, 2, 3, 40), children=[node("Transform", scale=[2, 0.5, 3], children=[box])])
        ],
    )
    yield from written("nested", nested, **boxes(t @ r @ s))
    yield from written("mirror", node("Transform", scale=[-1, 2, 1], children=[box]), **boxes(scaled(-1, 2, 1)))
    yield from written(
        "group", node("Group", children=[box, node("Transform", translation=[3, -2, 5], children=[box])]), **boxes(ONE, t)
    )
    yield from written("one_child", node("Group", children=box), **boxes(ONE))
    first = node("Transform", translation=[3, -2, 5], children=[shape(ifs(), name="S")])
    second = node("Transform", scale=[2, 0.5, 3], children=[node("Shape", use="S")])
    yield from written("use_of_a_shape", first, second, **boxes(t, s))
    defined = node("Transform", "T", translation=[3, -2, 5], children=[box])
    used = node("Transform", scale=[2, 0.5, 3], children=[node("Transform", use="T")])
    yield from written("use_of_a_transform", defined, used, **boxes(t, s @ t))
    shared = node("IndexedFaceSet", coord=coordinates(POINTS, "C"), coordIndex=np.array([i for f in QUADS[:3] for i in (*f, -1)]))
    again = node(
        "IndexedFaceSet", coord=node("Coordinate", use="C"), coordIndex=np.array([i for f in QUADS[3:] for i in (*f, -1)])
    )
    yield from written("use_of_coordinates", shape(shared), shape(again), **boxes(ONE))
    other = node("Transform", translation=[3, -2, 5], children=[box])
    for choice, matrices in ((0, (ONE,)), (1, (t,))):
        for key, only in (("choice", "wrl"), ("children", "x3d")):
            switch = Node("Switch", {"whichChoice": choice, key: [box, other]})
            for found in written(f"switch_{choice}", switch, **boxes(*matrices)):
                if found.name.endswith(".wrl") == (only == "wrl"):
                    yield found
    for key, only in (("level", "wrl"), ("children", "x3d")):
        for found in written("lod", Node("LOD", {"range": [10], key: [box, other]}), **boxes(ONE)):
            if found.name.endswith(".wrl") == (only == "wrl"):
                yield found
    off = node("Switch", whichChoice=-1, choice=[other])
    yield next(iter(written("switch_off", box, off, **boxes(ONE))))
    yield from written("collision", node("Collision", children=[box], proxy=other), **boxes(ONE))
    yield from written("anchor", node("Anchor", description="a [ # b", children=[box]), **boxes(ONE))
    harmless = (
        node("WorldInfo", title="x { y"),
        node("NavigationInfo", "N", headlight=True),
        node("Viewpoint", "V", position=[0, 0, 10]),
        node("TimeSensor", "TS", cycleInterval=2),
        node("DirectionalLight", direction=[0, 0, -1]),
        node("PositionInterpolator", "P", key=[0, 1], keyValue=[0, 0, 0, 1, 1, 1]),
    )
    routes = "\nROUTE TS.fraction_changed TO P.set_fraction\n"
    yield from written("other_nodes", *harmless, box, routes=routes, **boxes(ONE))


def _faces() -> Iterator[Made]:
    counted: dict[str, Any] = {"vertices": 8, "faces": 12}
    yield from written("quads", shape(ifs()), **boxes(ONE), more=counted)
    yield from written("triangles", shape(ifs(TRIANGLES.tolist())), **boxes(ONE), more=counted)
    yield from written("no_last_end", shape(ifs(last=False)), **boxes(ONE), more=counted)
    yield from written("clockwise", shape(ifs([f[::-1] for f in QUADS], ccw=False)), **boxes(ONE), more=counted)
    yield from written("crease", shape(ifs(creaseAngle=0.5, solid=False)), **boxes(ONE), more=counted)
    yield from written("concave", shape(ifs(CONCAVE_FACES, CONCAVE_POINTS, convex=False)), **CONCAVE)
    coord = coordinates(POINTS)
    yield from written(
        "triangle_set", shape(node("IndexedTriangleSet", coord=coord, index=TRIANGLES.ravel())), only="x3d", **boxes(ONE)
    )
    strips = np.array([i for a, b, c, d in QUADS for i in (a, b, d, c, -1)])
    yield from written("strip_set", shape(node("IndexedTriangleStripSet", coord=coord, index=strips)), only="x3d", **boxes(ONE))
    fans = np.array([i for f in QUADS for i in (*f, -1)])
    yield from written("fan_set", shape(node("IndexedTriangleFanSet", coord=coord, index=fans)), only="x3d", **boxes(ONE))
    yield from written(
        "quad_set", shape(node("IndexedQuadSet", coord=coord, index=np.ravel(QUADS))), only="x3d", **boxes(ONE), named=("Quad",)
    )
    flat = coordinates(POINTS[TRIANGLES.ravel()])
    yield from written("plain_triangles", shape(node("TriangleSet", coord=flat)), only="x3d", **boxes(ONE))
    strip = node("TriangleStripSet", coord=coordinates(POINTS[[i for i in strips if i >= 0]]), stripCount=np.full(6, 4))
    yield from written("plain_strips", shape(strip), only="x3d", **boxes(ONE), named=("Strip",))
    fan = node("TriangleFanSet", coord=coordinates(POINTS[np.ravel(QUADS)]), fanCount=np.full(6, 4))
    yield from written("plain_fans", shape(fan), only="x3d", **boxes(ONE), named=("Fan",))
    lines = node("IndexedLineSet", coord=coord, coordIndex=np.array([0, 1, 3, -1, 4, 5, -1]))
    yield from written("lines", shape(lines), area=0.0, more={"edges": 3}, named=("Line",))
    cloud = node("PointSet", coord=coord, color=node("Color", color=np.tile([0.2, 0.4, 0.8], (8, 1))))
    yield from written("cloud", shape(cloud), area=0.0, more={"vertices": 8})
    flags = "".join(f"{i}, " for f in QUADS for i in (*f, -1))
    text = (
        f"#VRML V2.0 utf8\nShape{{geometry IndexedFaceSet{{coord Coordinate{{point[{words(POINTS)}]}}coordIndex[{flags}]#x\n}}}}"
    )
    yield Made("tight.wrl", text.encode(), **boxes(ONE))
    yield Made("old_mac.wrl", text.replace("\n", "\r").encode(), **boxes(ONE))
    half = text.replace("coordIndex[", "coordIndex [ # first { \n")
    yield Made("remark_in_a_list.wrl", half.encode(), **boxes(ONE))


def _bodies() -> Iterator[Made]:
    yield from written("box", shape(node("Box")), area=24.0, volume=8.0, low=(-1,) * 3, high=(1,) * 3, named=("Box",))
    sized = shape(node("Box", size=[1, 2, 3]))
    yield from written("sized_box", sized, area=22.0, volume=6.0, low=(-0.5, -1, -1.5), high=(0.5, 1, 1.5), named=("Box",))
    with_box = (node("Transform", translation=[9, 0, 0], children=[sized]), shape(ifs()))
    both = facts([(POINTS, TRIANGLES), ((POINTS - POINTS.mean(axis=0)) + [9, 0, 0], TRIANGLES)])
    yield from written("faces_and_a_box", *with_box, **both, named=("Box",))
    about: dict[str, Any] = {"tolerance": 0.01}
    pi = float(np.pi)
    yield from written(
        "sphere", shape(node("Sphere")), area=4 * pi, volume=4 / 3 * pi, low=(-1,) * 3, high=(1,) * 3, **about, named=("Sphere",)
    )
    yield from written("radius", shape(node("Sphere", radius=3)), area=36 * pi, volume=36 * pi, **about, named=("Sphere",))
    slope = float(np.sqrt(5))
    cone: dict[str, Any] = {"area": pi * (1 + slope), "volume": 2 / 3 * pi, "low": (-1,) * 3, "high": (1,) * 3}
    yield from written("cone", shape(node("Cone")), **cone, **about, named=("Cone",))
    yield from written(
        "open_cone",
        shape(node("Cone", bottom=False, bottomRadius=2, height=3)),
        area=pi * 2 * float(np.sqrt(13)),
        low=(-2, -1.5, -2),
        high=(2, 1.5, 2),
        **about,
        named=("Cone",),
    )
    yield from written(
        "cylinder",
        shape(node("Cylinder")),
        area=6 * pi,
        volume=2 * pi,
        low=(-1,) * 3,
        high=(1,) * 3,
        **about,
        named=("Cylinder",),
    )
    yield from written(
        "tube",
        shape(node("Cylinder", top=False, bottom=False, radius=2, height=5)),
        area=20 * pi,
        low=(-2, -2.5, -2),
        high=(2, 2.5, 2),
        **about,
        named=("Cylinder",),
    )
    yield from written(
        "lid",
        shape(node("Cylinder", top=False, side=False)),
        area=pi,
        low=(-1, -1, -1),
        high=(1, -1, 1),
        **about,
        named=("Cylinder",),
    )
    heights = np.array([0, 1, 0, 2, 0, 1])
    places = np.array(
        [[x * 2.0, h, z * 3.0] for (z, x), h in zip(((z, x) for z in range(2) for x in range(3)), heights, strict=True)]
    )
    grid = node("ElevationGrid", xDimension=3, zDimension=2, xSpacing=2, zSpacing=3, height=heights)
    low, high = tuple(places.min(axis=0)), tuple(places.max(axis=0))
    yield from written("elevation", shape(grid), low=low, high=high, more={"vertices": 6, "faces": 4}, named=("Elevation",))
    flat = node("ElevationGrid", xDimension=5, zDimension=3, xSpacing=2, zSpacing=3, height=np.full(15, 4.0))
    yield from written(
        "flat_elevation", shape(flat), area=48.0, low=(0, 4, 0), high=(8, 4, 6), more={"normal": (0, 1, 0)}, named=("Elevation",)
    )
    yield from written(
        "extrusion", shape(node("Extrusion")), area=12.0, volume=4.0, low=(-1, 0, -1), high=(1, 1, 1), named=("Extrusion",)
    )
    bar = node(
        "Extrusion",
        spine=np.array([[0, 0, 0], [0, 0, 2], [0, 0, 5.0]]),
        crossSection=np.array([[1, 1], [1, -1], [-1, -1], [-1, 1], [1, 1]]),
    )
    yield from written("bar", shape(bar), area=48.0, volume=20.0, low=(-1, -1, 0), high=(1, 1, 5), named=("Extrusion",))
    tapered = node("Extrusion", spine=np.array([[0, 0, 0], [0, 3.0, 0]]), scale=np.array([[1, 1], [0.5, 0.5]]))
    yield from written("tapered", shape(tapered), volume=(4 + 1 + 2) * 1.0, low=(-1, 0, -1), high=(1, 3, 1), named=("Extrusion",))
    open_ended = node("Extrusion", beginCap=False, endCap=False)
    yield from written("open_extrusion", shape(open_ended), area=8.0, low=(-1, 0, -1), high=(1, 1, 1), named=("Extrusion",))
    turned_end = node("Extrusion", spine=np.array([[0, 0, 0], [0, 1.0, 0]]), orientation=np.array([[0, 1, 0, np.pi / 2]] * 2))
    yield from written(
        "turned_extrusion", shape(turned_end), area=12.0, volume=4.0, low=(-1, 0, -1), high=(1, 1, 1), named=("Extrusion",)
    )
    notched = np.array([[0, 0], [0, 3], [1, 1], [2, 3], [3, 1], [4, 3], [4, 0], [0, 0]], float)
    deep = node("Extrusion", crossSection=notched, convex=False)
    yield from written(
        "notched_extrusion", shape(deep), area=CONCAVE["area"], volume=8.0, low=(0, 0, 0), high=(4, 1, 3), named=("Extrusion",)
    )
    ring = np.array([[4 * np.cos(a), 0, 4 * np.sin(a)] for a in np.linspace(0, 2 * np.pi, 65)])
    ring[-1] = ring[0]
    circle = np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0, -2 * np.pi, 65)])
    circle[-1] = circle[0]
    torus = node("Extrusion", spine=ring, crossSection=circle, beginCap=False, endCap=False)
    yield from written(
        "torus",
        shape(torus),
        area=4 * pi**2 * 4,
        volume=2 * pi**2 * 4,
        low=(-5, -1, -5),
        high=(5, 1, 5),
        **about,
        named=("Extrusion",),
    )


def _attributes() -> Iterator[Made]:
    one = np.array([[0.2, 0.4, 0.8]])
    colour: dict[str, Any] = {"more": {"colour": (51, 102, 204)}}
    many = node("Color", color=np.repeat(one, 8, axis=0))
    yield from written("colours", shape(ifs(color=many)), **boxes(ONE), **colour)
    corner = np.array([i for f in QUADS for i in (*(0 for _ in f), -1)])
    yield from written("indexed_colours", shape(ifs(color=node("Color", color=one), colorIndex=corner)), **boxes(ONE), **colour)
    each = node("Color", color=np.repeat(one, 6, axis=0))
    yield from written("face_colours", shape(ifs(color=each, colorPerVertex=False)), **boxes(ONE), **colour)
    two = node("Color", color=np.array([[1, 1, 1], [0.2, 0.4, 0.8]]))
    chosen = np.ones(6, int)
    yield from written(
        "indexed_face_colours", shape(ifs(color=two, colorIndex=chosen, colorPerVertex=False)), **boxes(ONE), **colour
    )
    wide = node("ColorRGBA", color=np.tile([0.2, 0.4, 0.8, 1], (8, 1)))
    yield from written("colours_with_alpha", shape(ifs(color=wide)), only="x3d", **boxes(ONE), **colour)
    look = node("Appearance", material=node("Material", diffuseColor=[0.2, 0.4, 0.8]))
    yield from written("colour_of_material", shape(ifs(), look), **boxes(ONE), **colour)
    uv = np.array([[0.1, 0.2], [0.3, 0.6], [0.5, 0.4]])
    place = np.array([i for _ in TRIANGLES for i in (0, 1, 2, -1)])
    texture = node("Appearance", texture=node("ImageTexture", url="a b.png"))
    picture: dict[str, Any] = {"beside": {"a b.png": png()}, "more": {"uv": (0.3, 0.4), "image": True}}
    mapped = ifs(TRIANGLES.tolist(), texCoord=node("TextureCoordinate", point=uv), texCoordIndex=place)
    yield from written("texture", shape(mapped, texture), **boxes(ONE), **picture)
    of_vertices = ifs(texCoord=node("TextureCoordinate", point=np.tile([0.3, 0.4], (8, 1))))
    yield from written("texture_of_vertices", shape(of_vertices, texture), **boxes(ONE), **picture)
    up = node("Normal", vector=np.tile([0, 0.6, 0.8], (8, 1)))
    normal: dict[str, Any] = {"more": {"normal": (0, 0.6, 0.8)}}
    yield from written("normals", shape(ifs(normal=up)), **boxes(ONE), **normal)
    index = np.array([i for f in QUADS for i in (*(0 for _ in f), -1)])
    first = node("Normal", vector=np.array([[0, 0.6, 0.8]]))
    yield from written("indexed_normals", shape(ifs(normal=first, normalIndex=index)), **boxes(ONE), **normal)


def made() -> Iterator[Made]:
    """All of them."""
    yield from _placed()
    yield from _faces()
    yield from _bodies()
    yield from _attributes()
