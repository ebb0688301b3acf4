"""The result of a reader, and the checks that all readers share."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..filters.mesh import bounding_box
from ..mesh_data import MeshData
from .errors import InputError

#: of a text that ends within a line
NO_END = "its last line has no end: if the file was cut short, so was perhaps its last number"


@dataclass(frozen=True, eq=False)
class Reading:
    """A mesh file that was read."""

    mesh: MeshData  # the mesh in it
    doubts: tuple[str, ...] = ()  # sentences that the user should read about it
    side_files: tuple[Path, ...] = ()  # the files that belong to it; of a reader, without the images of textures


def unended(text: bytes) -> tuple[str, ...]:
    """The doubt about a text that ends within a line: its last number may be the beginning of a longer one."""
    return () if text.endswith((b"\n", b"\r", b"\x1a")) else (NO_END,)


@contextmanager
def unchanged(path: Path) -> Iterator[None]:
    """Refuse a file that another program writes to while the context lasts."""
    before = path.stat()
    yield
    after = path.stat()
    if (before.st_size, before.st_mtime_ns, before.st_ino) != (after.st_size, after.st_mtime_ns, after.st_ino):
        raise InputError(path, "it changed while it was read")


def completed(path: Path, reading: Reading) -> Reading:
    """The reading with a label and counts, and without vertices that are not finite, which nothing can compute with."""
    mesh = reading.mesh
    source = mesh.source
    assert source is not None
    n, m, e = len(mesh.vertices), len(mesh.faces), len(mesh.edges)
    source = replace(source, side_files=reading.side_files, vertices=n, faces=m, edges=e)
    mesh = replace(mesh, source=source, label=path.name)
    doubts = list(reading.doubts)
    if not np.isfinite(mesh.vertices).all():
        finite = np.all(np.isfinite(mesh.vertices), axis=1, out=np.empty(n, np.bool_))
        whole, mesh = mesh, mesh.part(finite)
        lost_vertices, lost_faces = len(whole.vertices) - len(mesh.vertices), len(whole.faces) - len(mesh.faces)
        doubts.append(
            f"left out: {_counted(lost_vertices, 'vertex', 'vertices')} with a coordinate that is not finite, and "
            f"{_counted(lost_faces, 'face', 'faces')} with such a vertex"
        )
    if not len(mesh.vertices):
        raise InputError(path, "no vertex could be read from it")
    low, high = bounding_box(mesh.vertices)
    if len(mesh.vertices) > 1 and (low == high).all():
        doubts.append(f"all its {len(mesh.vertices):,} vertices are at one place")
    return replace(reading, mesh=mesh, doubts=tuple(doubts))


def _counted(number: int, one: str, many: str) -> str:
    return f"{number:,} {one if number == 1 else many}"
