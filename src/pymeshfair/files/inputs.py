"""Checks an input before MeshLab opens it: whether it is safe to open, what it declares, and what MeshLab will drop."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection
from pathlib import Path

from . import ply
from .announced import Announced, unended
from .collada import inspect_collada
from .errors import ContentsError, InputError
from .formats import BY_TILES, BY_TILES_ADVICE, READABLE, extension, listed
from .given import Given, find_textures
from .gltf import inspect_gltf
from .obj_input import inspect_obj
from .off import read_off
from .ply_body import read_body
from .ply_given import given_header, kept_name, must_be_altered
from .ply_losses import carried, not_kept
from .points import as_ply, read_points
from .ptx import read_ptx
from .references import References, check_regular
from .stl import read_stl
from .three_mf import inspect_3mf
from .vrml import inspect_vrml
from .x3d import inspect_x3d


def check_input(path: Path, formats: Collection[str] = READABLE) -> None:
    """Refuse what is no mesh file, of one of the formats, by its name and kind, without opening it.

    Raises:
        InputError: there is no such file; it is a folder, a pipe or a device, empty, unreadable or of an unknown format.
    """
    check_regular(path, path)
    if path.stat().st_size == 0:
        raise InputError(path, "it is empty")
    if extension(path) not in formats:
        if extension(path) in BY_TILES:
            raise InputError(path, BY_TILES_ADVICE)
        what = f"{path.suffix!r} is no format for meshes" if path.suffix else "it has no extension that says the format"
        raise InputError(path, f"{what}; a run reads {listed(tuple(formats))}")
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(path, "its name is not valid UTF-8, and MeshLab cannot open such a name; rename it") from None


def inspect_input(path: Path, folder: Path, *, allow_outside: bool = False, unchecked: bool = False) -> Announced:
    """Read what the input declares, and check every file that it names.

    Args:
        path: the input.
        folder: a new folder for what MeshLab is given in place of the input, if its reader would understand that otherwise.
        allow_outside: let the input name files outside its own folder.
        unchecked: let MeshLab read a format as it is that nothing here understands.

    Raises:
        InputError: it declares what it cannot hold, or names a file that must not be opened.
    """
    inspect = _INSPECT.get(extension(path))
    if inspect is None:
        if unchecked:
            return Announced()
        raise InputError(
            path,
            f"nothing but MeshLab's own reader understands .{extension(path)} files, and that believes whatever they say; "
            f"save it as .ply or .obj, or give --unchecked if you trust it",
        )
    try:
        check_magic(path)
        return inspect(path, References(path, allow_outside=allow_outside), Given(folder, path))
    except ContentsError as error:
        raise InputError(path, str(error)) from error
    except OSError as error:
        raise InputError(path, (error.strerror or str(error)).lower()) from error


def check_magic(path: Path) -> None:
    """Refuse a file that begins as none of its format does, before all of it is read.

    Raises:
        ContentsError: it does.
    """
    with path.open("rb") as file:
        head = file.read(4096)
    if extension(path) not in _ANY_ENCODING and _UTF_16.match(head):
        raise ContentsError("it is a text in UTF-16, of which MeshLab reads nothing; save it as UTF-8")
    expected, what = _MAGIC.get(extension(path), (None, ""))
    if expected is not None and not expected.match(head):
        raise ContentsError(f"it does not begin with {what}")


def _inspect_ply(path: Path, references: References, given: Given) -> Announced:
    header = ply.read_header(path)
    kept = carried(header)
    body = read_body(path, header, kept)
    if body.triangles != header.element("face").count:  # of split polygons nobody knows what is whose
        kept = frozenset(k for k in kept if k[0] == "vertex")
    kept &= body.columns.keys()
    attributes = {
        element: {
            kept_name(element, p): body.columns[element, p.name]
            for p in header.element(element).properties
            if (element, p.name) in kept
        }
        for element in ("vertex", "face")
    }
    renamed = [
        f"{e} property {name!r} under that name: it is kept as 'kept_{name}', as MeshLab takes it for something else"
        for e, values in attributes.items()
        for name in (n.removeprefix("kept_") for n in values)
        if (e, name) in kept and f"kept_{name}" in values
    ]
    single = header.format == "ascii" and any(p.type == "float" for p in header.element("vertex").properties if p.name in "xyz")
    grid = header.element("tristrips").count or header.element("range_grid").count
    textures = find_textures(header.textures, references)
    names = {p.name for p in header.element("vertex").properties}
    reading = None if textures else given.offer(".ply", body.binary)
    if reading is None and must_be_altered(header):
        with path.open("rb") as file:
            file.seek(header.size)
            reading = given.write(given_header(header, textures), *iter(lambda: file.read(1 << 20), b""))
        given.link(textures)
    return Announced(
        vertices=header.element("vertex").count,
        doubts=body.doubts,
        faces=None if grid else header.element("face").count,
        triangles=body.triangles,
        normals={"nx", "ny", "nz"} <= names,
        radii="radius" in names and "kept_radius" not in attributes["vertex"],
        vertex_texture={"texture_u", "texture_v"} <= names or {"s", "t"} <= names,
        not_kept=(*not_kept(header, kept), *renamed),
        side_files=tuple(t.file for t in textures if t.file),
        textures=textures,
        points=body.points,
        precision=2.0**-22 if single else 1e-14,
        vertex_attributes=attributes["vertex"],
        face_attributes=attributes["face"],
        reading=reading,
    )


def _inspect_off(path: Path, references: References, given: Given) -> Announced:
    data = path.read_bytes()
    contents = read_off(data)
    return Announced(
        vertices=len(contents.points),
        faces=contents.faces,
        triangles=contents.triangles,
        normals=contents.normals,
        not_kept=("comments",) if contents.comments else (),
        doubts=unended(data),
        points=contents.points,
        reading=_binary_or_text(given, ".ply", contents.binary, contents.text if contents.altered else None),
    )


def _binary_or_text(given: Given, suffix: str, binary: list[bytes] | None, text: bytes | None) -> Path | None:
    """Write what MeshLab reads soonest; None if that is the file itself."""
    return given.offer(suffix, binary) or (None if text is None else given.write(text))


def _inspect_stl(path: Path, references: References, given: Given) -> Announced:
    contents = read_stl(path.read_bytes())
    return Announced(
        faces=contents.faces,
        triangles=contents.faces,
        not_kept=(f"its head {contents.note[:60]!r}",) if contents.note else (),
        doubts=contents.doubts,
        reading=_binary_or_text(given, ".stl", contents.binary, contents.text),
    )


def _inspect_points(path: Path, references: References, given: Given) -> Announced:
    data = path.read_bytes()
    contents = read_points(data)
    as_it_is = contents.plain and extension(path) in ("xyz", "pts", "apts")
    return Announced(
        vertices=contents.count,
        faces=0,
        normals=contents.normals is not None,
        not_kept=(f"its titles {contents.note[:60]!r}",) if contents.note else (),
        doubts=() if contents.points is None else unended(data),
        points=contents.points,
        reading=None if as_it_is else given.write_beside(f"{path.stem}.ply", *as_ply(contents)),
    )


def _inspect_ptx(path: Path, references: References, given: Given) -> Announced:
    data = path.read_bytes()
    contents, missing = read_ptx(data)
    return Announced(
        vertices=contents.count,
        faces=0,
        not_kept=(f"{missing:,} places of its grids where nothing was measured",) if missing else (),
        doubts=unended(data),
        points=contents.points,
        reading=given.write_beside(f"{path.stem}.ply", *as_ply(contents)),
    )


#: how files begin, and what to call it
_XML = (re.compile(rb"(\xef\xbb\xbf)?\s*<|\xff\xfe|\xfe\xff"), "'<'")
#: how a text in UTF-16 begins that is one, and the formats that may be
_UTF_16, _ANY_ENCODING = re.compile(rb"\xff\xfe[\t-~]\0|\xfe\xff\0[\t-~]"), ("gltf", "dae", "x3d")
_MAGIC = {
    "ply": (re.compile(rb"ply\s"), "'ply'"),
    "glb": (re.compile(rb"glTF"), "'glTF'"),
    "3mf": (re.compile(rb"PK"), "'PK'"),
    "wrl": (re.compile(rb"#VRML"), "'#VRML'"),
    "dae": _XML,
    "x3d": _XML,
}

_INSPECT: dict[str, Callable[[Path, References, Given], Announced]] = {
    "ply": _inspect_ply,
    "obj": inspect_obj,
    "off": _inspect_off,
    "stl": _inspect_stl,
    "glb": inspect_gltf,
    "gltf": inspect_gltf,
    "dae": inspect_collada,
    "x3d": inspect_x3d,
    "wrl": inspect_vrml,
    "x3dv": inspect_vrml,
    "3mf": inspect_3mf,
    "ptx": _inspect_ptx,
    **dict.fromkeys(("xyz", "pts", "apts", "asc", "txt"), _inspect_points),
}
