"""Mesh files damaged at random, from a seed: bytes flipped, numbers exchanged, pieces missing, doubled or from elsewhere."""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np

from pymeshfair.errors import RunError
from pymeshfair.files.inputs import read_file
from tests.meshes import grid, icosphere

from ..running.runs import ply_bytes, xyz
from .corpus import glb
from .documents import collada, three_mf, vrml, x3d

_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:e-?\d+)?")
#: what a number becomes
_NUMBERS = (
    *(b"0", b"-1", b"1", b"3", b"255", b"65536", b"2147483648", b"99999999999999999999", b"1e308", b"1e999", b"nan", b"0,5"),
    *(b"inf", b"-nan(ind)", b"abc", b"", b"1.7", b"1e-320", b"0x10", b"--1", b"+2", b"1 2", b"1_0"),
)
_PIECES = (b"\0", b"\n", b"\r", b" ", b"#", b"/", b"\\\n", b"\xff", b'"', b"[", b"}", b"<a>", b"&x;")
_WORDS = (b"\xff\xff\xff\xff", b"\0\0\0\x80", b"\0\0\0\0", b"\xff\xff\xff\x7f", b"\0\0\xc0\x7f")


def _row(values: Iterable[float]) -> str:
    return " ".join(f"{value:.6g}" for value in values)


def _ply_text() -> bytes:
    vertices, faces = icosphere(0)
    lines = ["ply", "format ascii 1.0", "comment made", f"element vertex {len(vertices)}"]
    lines += [*(f"property float {c}" for c in "xyz"), "property uchar red", "property uchar green", "property uchar blue"]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += [f"{_row(v)} 1 2 3" for v in vertices]
    lines += [f"3 {_row(f)}" for f in faces]
    return "\n".join([*lines, ""]).encode()


def _obj() -> bytes:
    vertices, faces = grid(2, 2)
    lines = [
        "mtllib a.mtl",
        "o thing",
        *(f"v {_row(v)}" for v in vertices),
        "vt 0 0",
        "vt 1 0.5",
        "vn 0 0 1",
        "usemtl a",
    ]
    return "\n".join([*lines, *(f"f {a}/1/1 {b}/2/1 {c}/1/1" for a, b, c in faces + 1), "l 1 2 3", ""]).encode()


def _off() -> bytes:
    vertices, faces = icosphere(0)
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0", *(_row(v) for v in vertices)]
    return "\n".join([*lines, *(f"3 {_row(f)}" for f in faces), ""]).encode()


def _stl_text() -> bytes:
    vertices, faces = grid(2, 2)
    facets = ["facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {_row(vertices[i])}\n" for i in f) for f in faces]
    return ("solid a\n" + "".join(f"{facet}endloop\nendfacet\n" for facet in facets) + "endsolid a\n").encode()


def _stl_binary() -> bytes:
    vertices, faces = icosphere(0)
    rows = np.zeros(len(faces), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    rows["v"] = vertices[faces]
    return b"made".ljust(80) + np.uint32(len(rows)).tobytes() + rows.tobytes()


def _ptx() -> bytes:
    head = "2\n3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    return (head + "".join(f"{k} {k + 1}.5 2 0.25 10 20 30\n" for k in range(6))).encode()


#: a good file of each format, by its name
SEEDS: Mapping[str, Callable[[], bytes]] = {
    "text.ply": _ply_text,
    "binary.ply": lambda: ply_bytes([*xyz(icosphere(0)[0]), ("float", "intensity", [0.5] * 12)], icosphere(0)[1].tolist()),
    "a.obj": _obj,
    "a.off": _off,
    "text.stl": _stl_text,
    "binary.stl": _stl_binary,
    "a.glb": lambda: glb({}, indices=True),
    "a.xyz": lambda: b"".join(b"%d.5 %d 0.25\n" % (k, k * k) for k in range(20)),
    "a.pts": lambda: b"20\n" + b"".join(b"%d.5 %d 0.25 0.5 10 20 30\n" % (k, k * k) for k in range(20)),
    "a.ptx": _ptx,
    "a.dae": lambda: collada().encode(),
    "a.wrl": lambda: vrml().encode(),
    "a.x3d": lambda: x3d().encode(),
    "a.3mf": three_mf,
}
MATERIALS = b"newmtl a\nKd 1 0.5 0\nmap_Kd gone.png\nillum 2\n"


def mutant(name: str, choose: random.Random) -> bytes:
    """A damaged file of the format."""
    data = SEEDS[name]()
    for _ in range(choose.choice((1, 1, 2, 4))):
        data = choose.choice(_DAMAGES)(data, choose) or data[:1]
    return data


def _flip(data: bytes, choose: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(choose.choice((1, 1, 3, 20))):
        changed[choose.randrange(len(changed))] ^= 1 << choose.randrange(8)
    return bytes(changed)


def _exchange_number(data: bytes, choose: random.Random) -> bytes:
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    match = choose.choice(found)
    return data[: match.start()] + choose.choice(_NUMBERS) + data[match.end() :]


def _cut_out(data: bytes, choose: random.Random) -> bytes:
    start = choose.randrange(len(data))
    return data[:start] + data[start + choose.choice((1, 2, 7, 50, len(data))) :]


def _double(data: bytes, choose: random.Random) -> bytes:
    start = choose.randrange(len(data))
    end = min(len(data), start + choose.choice((1, 4, 30, 200)))
    at = choose.randrange(len(data))
    return data[:at] + data[start:end] + data[at:]


def _insert(data: bytes, choose: random.Random) -> bytes:
    at = choose.randrange(len(data))
    return data[:at] + choose.choice(_PIECES) + data[at:]


def _swap_lines(data: bytes, choose: random.Random) -> bytes:
    lines = data.split(b"\n")
    a, b = choose.randrange(len(lines)), choose.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def _set_word(data: bytes, choose: random.Random) -> bytes:
    at = choose.randrange(len(data))
    return data[:at] + choose.choice(_WORDS) + data[at + 4 :]


_DAMAGES = (_flip, _exchange_number, _exchange_number, _cut_out, _double, _insert, _swap_lines, _set_word)


def check(path: Path) -> str:
    """What the check says of a file: "read", "refused", or what is wrong with the check."""
    try:
        reading = read_file(path)
    except RunError:
        return "refused"
    except Exception as error:
        return f"raises {type(error).__name__}: {str(error)[:100]}"
    declared = faces_declared(path)
    polygon = reading.mesh.face_attributes.get("polygon")
    faces = len(reading.mesh.faces) if polygon is None else int((polygon < 0).sum()) + len(np.unique(polygon[polygon >= 0]))
    extras = () if reading.mesh.source is None else reading.mesh.source.extras
    lost = "left out" in " ".join(reading.doubts) or "face property" in " ".join(extras)
    if declared is not None and declared != faces and not lost:
        return f"has {faces} faces of {declared}"
    return "read"


def faces_declared(path: Path) -> int | None:
    """How many faces the text of a file has, counted by another reader than ours; None where that is not known."""
    data = path.read_bytes()
    lines = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").replace(b"\r", b"\n").split(b"\n")
    words = Counter(line.split()[0] for line in lines if line.split())
    if path.suffix == ".obj":
        return words[b"f"]
    if path.suffix == ".stl" and len(data) > 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        return int.from_bytes(data[80:84], "little")
    if path.suffix == ".stl":
        return sum(n for word, n in words.items() if word.lower() == b"facet")
    if path.suffix == ".ply":
        head = data.partition(b"end_header")[0].replace(b"\r", b"\n").split(b"\n")
        counts = [line.split()[2] for line in head if line.split()[:2] == [b"element", b"face"] and len(line.split()) == 3]
        return int(counts[0]) if counts else 0
    return None
