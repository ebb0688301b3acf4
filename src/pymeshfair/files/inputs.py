"""Checks an input before MeshLab opens it: whether it is safe to open, what it declares, and what MeshLab will drop."""

from __future__ import annotations

import json
import os
import stat
import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from . import obj, ply
from .errors import InputError
from .formats import READABLE, extension, listed
from .obj_polylines import PolylineError, Polylines, scan_polylines
from .ply_losses import not_kept

_CHUNK_LIMIT = 64 << 20
_NO_POLYLINES = Polylines(0, 0)


@dataclass(frozen=True)
class Announced:
    """What the input, and the files that it names, declare about the mesh.

    Attributes:
        vertices: how many are declared, or None if the format does not say.
        faces: how many polygons are declared, or None.
        count_triangles: how many triangles these polygons make, or None if that is not known; slow for large files.
        normals: whether it has vertex normals.
        vertex_texture: whether its vertices, not only the corners of its faces, have texture coordinates.
        not_kept: what it has and MeshLab does not keep, in words.
        side_files: the existing files that MeshLab will read with it.
        textures: the texture files that it names, as written there, and the existing file that each means, or None.
        polylines: those of an OBJ file.
    """

    vertices: int | None = None
    faces: int | None = None
    count_triangles: Callable[[], int | None] = lambda: None
    normals: bool = False
    vertex_texture: bool = False
    not_kept: tuple[str, ...] = ()
    side_files: tuple[Path, ...] = ()
    textures: tuple[tuple[str, Path | None], ...] = ()
    polylines: Polylines = _NO_POLYLINES


def check_input(path: Path) -> None:
    """Refuse what is no mesh file by its name and kind, without opening it.

    Raises:
        InputError: there is no such file; it is a folder, a pipe or a device, empty, unreadable or of an unknown format.
    """
    _check_regular(path, path)
    if path.stat().st_size == 0:
        raise InputError(path, "it is empty")
    if extension(path) not in READABLE:
        what = f"{path.suffix!r} is no format for meshes" if path.suffix else "it has no extension that says the format"
        raise InputError(path, f"{what}; a run reads {listed(READABLE)}")
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(path, "its name is not valid UTF-8, and MeshLab cannot open such a name; rename it") from None


def _check_regular(path: Path, input: Path) -> None:
    named = "" if path == input else f"{path}, which it names, "
    try:
        mode = path.stat().st_mode
    except OSError as error:
        reason = "there is no such file" if isinstance(error, FileNotFoundError) else (error.strerror or str(error)).lower()
        raise InputError(input, f"{named}{reason}") from error
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "a pipe" if stat.S_ISFIFO(mode) else "a device or a socket"
        raise InputError(input, f"{named or 'it '}is {kind} and no file")
    if not os.access(path, os.R_OK):
        raise InputError(input, f"{named or 'it '}cannot be read for want of permission")


def inspect_input(path: Path) -> Announced:
    """Read what the input declares, and check every file that it names.

    Raises:
        InputError: it declares what it cannot hold, or names a file that must not be opened.
    """
    inspect = {"ply": _inspect_ply, "obj": _inspect_obj, "off": _inspect_off, "stl": _inspect_stl}
    inspect |= dict.fromkeys(("glb", "gltf"), _inspect_gltf)
    try:
        return inspect.get(extension(path), lambda _: Announced())(path)
    except OSError as error:
        raise InputError(path, (error.strerror or str(error)).lower()) from error


def _inspect_ply(path: Path) -> Announced:
    try:
        header = ply.read_header(path)
    except ply.PlyError as error:
        raise InputError(path, str(error)) from error
    grid = header.element("tristrips").count or header.element("range_grid").count
    textures = _find_textures(path, header.textures)
    names = {p.name for p in header.element("vertex").properties}
    return Announced(
        vertices=header.element("vertex").count,
        faces=None if grid else header.element("face").count,
        count_triangles=lambda: ply.count_triangles(path, header),
        normals={"nx", "ny", "nz"} <= names,
        vertex_texture={"texture_u", "texture_v"} <= names or {"s", "t"} <= names,
        not_kept=tuple(not_kept(header)),
        side_files=tuple(file for _, file in textures if file),
        textures=textures,
    )


def _inspect_obj(path: Path) -> Announced:
    contents = obj.scan_obj(path)
    folder = path.resolve().parent
    lost = [f"{what} ({n:,})" for what in _OBJ_LOST if (n := contents.counts[what])]
    materials: list[Path] = []
    names: list[str] = []
    for file in obj.material_paths(path, contents):
        if not os.path.lexists(file):
            if contents.material_files:
                lost.append(f"the material file {file.name}, which does not exist")
            continue
        _check_regular(file, path)
        if not file.resolve().is_relative_to(folder):
            raise InputError(path, f"it names a material file outside its folder, {file}; put it beside the mesh")
        found = obj.read_materials(file)
        materials.append(file)
        names += found.textures
        if found.ignored:
            lost.append(f"{', '.join(found.ignored)} of the material file {file.name}")
    textures = _find_textures(path, dict.fromkeys(names))
    polylines = _NO_POLYLINES
    if contents.counts["polylines"]:
        try:
            polylines = scan_polylines(path, contents.counts["vertices"])
        except PolylineError as error:
            raise InputError(path, str(error)) from error
    if polylines.misread and materials:
        lost.append(f"the edges of {polylines.misread:,} polylines but for the first of each")
    return Announced(
        vertices=contents.counts["vertices"],
        faces=contents.counts["faces"],
        count_triangles=lambda: obj.count_triangles(path),
        normals=contents.counts["normals"] > 0,
        not_kept=tuple(lost),
        side_files=(*materials, *(file for _, file in textures if file)),
        textures=textures,
        polylines=polylines,
    )


_OBJ_LOST = ("groups", "objects", "smoothing groups", "point elements", "parameter space vertices", "curves", "surfaces")


def _find_textures(path: Path, names: Iterable[str]) -> tuple[tuple[str, Path | None], ...]:
    """For each name the file that MeshLab will read: as named from the mesh's folder, or its last part there."""
    found = []
    for name in names:
        last = name.replace("\\", "/").rpartition("/")[2]
        files = [f for f in (path.parent / name, path.parent / last) if name and last and os.path.lexists(f)]
        for file in files:
            _check_regular(file, path)
        found.append((name, files[0] if files else None))
    return tuple(found)


def _inspect_off(path: Path) -> Announced:
    with path.open("rb") as file:
        head = file.read(4096)
    lines = (line.partition(b"#")[0].split() for line in head.splitlines())
    words = [word for line in lines for word in line]
    numbers = [int(w) for w in words[1:4] if w.isdigit() and len(w) < 20]
    if not words or not words[0].endswith(b"OFF") or len(numbers) < 2:
        return Announced()
    needed, size = 6 * numbers[0] + 4 * numbers[1], path.stat().st_size
    if needed > size:
        raise InputError(
            path, f"it declares {numbers[0]:,} vertices and {numbers[1]:,} faces, which do not fit into its {size:,} bytes"
        )
    return Announced(vertices=numbers[0], faces=numbers[1], normals=b"N" in words[0])


def _inspect_stl(path: Path) -> Announced:
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(84)
    if len(head) < 84:
        return Announced()
    declared = int(struct.unpack_from("<I", head, 80)[0])
    if size == 84 + 50 * declared:
        return Announced(faces=declared, count_triangles=lambda: declared)
    if head.lstrip()[:5].lower() == b"solid":
        return Announced()
    raise InputError(path, f"it declares {declared:,} triangles, which take {84 + 50 * declared:,} bytes, but it has {size:,}")


def _inspect_gltf(path: Path) -> Announced:
    """Check the files that a glTF file names; everything else is left to MeshLab."""
    with path.open("rb") as file:
        data = file.read(12)
        if data[:4] == b"glTF":
            length = int.from_bytes(file.read(8)[:4], "little")
            data = file.read(min(length, _CHUNK_LIMIT))
        else:
            data += file.read(_CHUNK_LIMIT)
    try:
        document = json.loads(data)
        parts = [*document.get("buffers", ()), *document.get("images", ())]
        names = [str(part["uri"]) for part in parts if "uri" in part and not str(part["uri"]).startswith("data:")]
    except (ValueError, AttributeError, TypeError, RecursionError):
        raise InputError(path, "it holds no glTF document") from None
    named = [path.parent / name for name in names]
    for other in filter(os.path.lexists, named):
        _check_regular(other, path)
    return Announced(side_files=tuple(other for other in named if other.is_file()))
