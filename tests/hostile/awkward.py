"""Small meshes that no scanner should write and some do, made from a seed: the nth is the same in every run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tests.meshes import Mesh, book, bow_tie, grid, icosphere, moebius_strip, torus, tube, wheel

_BASES: tuple[Callable[[], Mesh], ...] = (
    lambda: icosphere(1),
    lambda: icosphere(2),
    lambda: grid(4, 5),
    lambda: tube(7, 3),
    lambda: torus(8, 5),
    lambda: book(5),
    lambda: wheel(9),
    bow_tie,
    moebius_strip,
)


def awkward_mesh(number: int) -> tuple[str, Mesh]:
    """The mesh of a number, and what was done to it."""
    rng = np.random.default_rng([11, number])
    if rng.random() < 0.15:
        return "soup", _soup(rng)
    vertices, faces = _BASES[rng.integers(len(_BASES))]()
    told = []
    for harm in rng.choice(len(_HARMS), size=rng.integers(1, 4), replace=False):
        vertices, faces = _HARMS[harm](vertices, faces.astype(np.int64), rng)
        told.append(_HARMS[harm].__name__.strip("_"))
    return ", ".join(told), (np.ascontiguousarray(vertices), np.ascontiguousarray(faces, dtype=np.int32))


def _soup(rng: np.random.Generator) -> Mesh:
    n = int(rng.integers(3, 30))
    faces = rng.integers(0, n, size=(int(rng.integers(1, 60)), 3))
    return rng.normal(size=(n, 3)), faces.astype(np.int32)


def _welded(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Vertices far apart become one: edges of three faces and more, fans, and faces that name a vertex twice."""
    place = np.arange(len(vertices))
    for _ in range(int(rng.integers(1, 5))):
        a, b = rng.integers(0, len(vertices), 2)
        place[place == a] = b
    return vertices, place[faces]


def _duplicated(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Faces are there twice, some the other way round."""
    more = faces[rng.integers(0, len(faces), size=int(rng.integers(1, 1 + len(faces))))]
    turned = rng.random(len(more)) < 0.5
    more[turned] = more[turned][:, ::-1]
    return vertices, np.concatenate([faces, more])


def _torn(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Faces are missing."""
    kept = rng.random(len(faces)) < rng.uniform(0.3, 0.98)
    return vertices, faces[kept] if kept.any() else faces[:1]


def _collapsed(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Edges are of no length, or nearly of none."""
    vertices = vertices.copy()
    for a, b, _ in faces[rng.integers(0, len(faces), size=int(rng.integers(1, 6)))]:
        vertices[a] = vertices[b] + rng.choice([0.0, 1e-300, 1e-16, 1e-12, 1e-6]) * rng.normal(size=3)
    return vertices, faces


def _flattened(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """One or two directions are thin, or gone."""
    return vertices * rng.choice([0.0, 1e-200, 1e-12, 1e-6, 1.0], size=3), faces


def _sized(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """In units that nobody uses, or far from the origin."""
    scale = float(rng.choice([1e-160, 1e-30, 1e-6, 1e6, 1e30, 1e150, 1e160]))
    shift = rng.choice([0.0, 1.0, 1e6]) * rng.normal(size=3)
    return (vertices + shift) * scale, faces


def _spiked(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Some vertices are far out, others where they should not be."""
    vertices = vertices.copy()
    chosen = rng.integers(0, len(vertices), size=int(rng.integers(1, 4)))
    vertices[chosen] *= rng.choice([-1.0, 1e3, 1e9, 1e-9])
    return vertices, faces


def _crossed(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """More faces between any vertices."""
    more = rng.integers(0, len(vertices), size=(int(rng.integers(1, 10)), 3))
    return vertices, np.concatenate([faces, more])


def _strewn(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Vertices that no face uses lie anywhere."""
    return np.concatenate([vertices, rng.normal(size=(5, 3)) * rng.choice([1.0, 1e12])]), faces


def _split(vertices: np.ndarray, faces: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Faces are split by a vertex on one of their edges, or next to it."""
    chosen = np.unique(rng.integers(0, len(faces), size=int(rng.integers(1, 9))))
    a, b, c = faces[chosen].T
    share = rng.choice([0.0, 1e-15, 1e-8, 1e-3])
    added = (vertices[a] + vertices[b]) / 2 * (1 - share) + share * vertices[c]
    new = np.arange(len(chosen)) + len(vertices)
    parts = [np.stack(t, axis=1) for t in ((a, b, new), (b, c, new), (c, a, new))]
    return np.concatenate([vertices, added]), np.concatenate([np.delete(faces, chosen, axis=0), *parts])


_HARMS = (_welded, _duplicated, _torn, _collapsed, _flattened, _sized, _spiked, _crossed, _strewn, _split)
