"""Reads glTF documents whole, and gives MeshLab one of them that holds nothing else than what was understood.

MeshLab's reader believes lengths and offsets, and so reads memory behind a buffer that is too short; it follows a name anywhere.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from .announced import Announced
from .given import Given
from .gltf_document import GltfError, check_document, is_mirrored
from .gltf_given import counts_of, losses_of, pruned
from .instances import MIRRORED, check_placed
from .references import References, Texture, check_image

#: of how many parts a document may be: a million take a second to read
_PARTS = 1_000_000
_JSON, _BINARY = 0x4E4F534A, 0x004E4942


def inspect_gltf(path: Path, references: References, given: Given) -> Announced:
    """Read a glTF file, text or binary; what it declares.

    Raises:
        GltfError: it is none, or declares what its buffers do not hold.
        InputError: it names what must not be opened.
    """
    text, binary = _parts(path.read_bytes())
    if sum(text.count(mark) for mark in (b",", b"{", b"[")) > _PARTS:
        raise GltfError(f"its document has more than {_PARTS:,} parts")
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        raise GltfError("it holds no glTF document") from None
    files: list[Path] = []

    def content(uri: str) -> bytes:
        if uri.startswith("data:"):
            return _decoded(uri)
        file = references.find(unquote(uri))
        if file is None:
            raise GltfError(f"its buffer {unquote(uri)[:80]!r} does not exist")
        files.append(file)
        return file.read_bytes()

    meshes = check_document(document)
    buffers = [_buffer(k, part, binary, content) for k, part in enumerate(document.get("buffers", ()))]
    for mesh in meshes:
        mesh.check_indices(buffers)
    textures = _textures(document, buffers, references, given)
    reading = given.path.with_suffix(".glb")
    _write(given, reading.name, pruned(document, [t.given if t else None for t in textures]), buffers)
    found = tuple(t for t in textures if t is not None)
    vertices, faces = counts_of(document, meshes)
    check_placed(len(document.get("nodes", ())), max(faces or 0, vertices or 0))
    return Announced(
        vertices=vertices,
        faces=faces,
        triangles=faces,
        normals=any("NORMAL" in m.attributes for m in meshes),
        not_kept=losses_of(document),
        doubts=(MIRRORED,) if is_mirrored(document) else (),
        side_files=(*files, *(t.file for t in found if t.file and not t.file.is_relative_to(given.folder))),
        textures=found,
        reading=reading,
    )


def _parts(data: bytes) -> tuple[bytes, bytes | None]:
    """The document and, of a binary file, what comes with it."""
    if not data.startswith(b"glTF"):
        return data, None
    if len(data) < 20:
        raise GltfError("it is cut short")
    version, length, text_length, kind = struct.unpack_from("<IIII", data, 4)
    if kind == _JSON and version != 2:
        raise GltfError(f"it is glTF of version {version}, not 2")
    if kind != _JSON:
        raise GltfError("it does not begin with a glTF document")
    if length != len(data):
        raise GltfError(f"it declares {length:,} bytes, but has {len(data):,}")
    if text_length > length - 20:
        raise GltfError(f"its document declares {text_length:,} bytes, but only {length - 20:,} follow")
    text, position = data[20 : 20 + text_length], 20 + text_length
    while position + 8 <= length:
        chunk_length, kind = struct.unpack_from("<II", data, position)
        if chunk_length > length - position - 8:
            raise GltfError(f"a part of it declares {chunk_length:,} bytes, but only {length - position - 8:,} follow")
        if kind == _JSON:
            raise GltfError("it has two documents")
        if kind == _BINARY:
            return text, data[position + 8 : position + 8 + chunk_length]
        position += 8 + chunk_length
    return text, None


def _decoded(uri: str) -> bytes:
    head, comma, data = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise GltfError("data within it is not written in base64")
    try:
        return base64.b64decode(data, validate=True)
    except (binascii.Error, ValueError):
        raise GltfError("data within it is not written in base64") from None


def _buffer(k: int, part: Mapping[str, Any], binary: bytes | None, content: Callable[[str], bytes]) -> bytes:
    data = content(part["uri"]) if "uri" in part else binary if k == 0 else None
    if data is None or part["byteLength"] > len(data):
        raise GltfError(f"its buffer {k} declares {part['byteLength']:,} bytes, but has {len(data or b''):,}")
    return data[: part["byteLength"]]


def _textures(document: Mapping[str, Any], buffers: list[bytes], references: References, given: Given) -> list[Texture | None]:
    """The images as textures; None for those that are not there."""
    textures: list[Texture | None] = []
    for number, image in enumerate(document.get("images", ())):
        uri, name = image.get("uri"), f"texture-{number}"
        if uri is not None and not uri.startswith("data:"):
            named = unquote(uri)
            file = references.find_image(named)
            textures.append(Texture(named, file, f"{name}{_suffix(file) if file else '.png'}"))
            if file is not None:
                given.link([textures[-1]])  # type: ignore[list-item]
            continue
        if uri is not None:
            data = _decoded(uri)
        else:
            view = document["bufferViews"][image["bufferView"]]
            start = view.get("byteOffset", 0)
            data = buffers[view["buffer"]][start : start + view["byteLength"]]
        name += ".jpg" if data.startswith(b"\xff\xd8") else ".png"
        file = given.write_beside(name, data)
        check_image(file, references.mesh, name)
        textures.append(Texture(f"{given.path.stem}-{name}", file, name))
    return textures


def _suffix(file: Path) -> str:
    return file.suffix if file.suffix[1:].isalnum() and file.suffix.isascii() else ".png"


def _write(given: Given, name: str, document: dict[str, Any], buffers: list[bytes]) -> None:
    """Write a binary glTF file whose only buffer is all of them, one after the other."""
    starts, end = [], 0
    for data in buffers:
        starts.append(end)
        end += len(data) + -len(data) % 4
    for view in document.get("bufferViews", ()):
        view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
        view["buffer"] = 0
    document["buffers"] = [{"byteLength": end}] if end else []
    text = json.dumps(document).encode("ascii")
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + end, len(text), _JSON)
    padded = (part for data in buffers for part in (data, bytes(-len(data) % 4)))
    given.write_beside(name, head, text, struct.pack("<II", end, _BINARY), *padded)
