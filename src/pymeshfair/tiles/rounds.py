"""Rounds of normal filtering on a mesh by tiles: after each, all tiles see what the others have made of their vertices."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..filters.denoising import distances_of_part, needs_distance, rings_of_round, round_of_part
from ..filters.mesh import NormalisedMesh, Whole, check_healthy, normalised_mesh
from .division import Floats
from .halo import tile_with_rings
from .moves import Filtering
from .surface import Surface
from .workers import Tasks

_NO_FACES = np.empty((0, 3), np.int32)


@dataclass(frozen=True)
class Rounds:
    """The tasks of the rounds; each may be done twice.

    Attributes:
        surface: the mesh.
        filtering: what is done.
        whole: the box of the vertices that faces use.
    """

    surface: Surface
    filtering: Filtering
    whole: Whole

    def begin(self, first: int, last: int) -> None:
        """Write down the normalised coordinates of some cells."""
        start, mesh = self._normalised(first, last)
        self.surface.state.write(start, mesh.points)

    def measure(self, first: int, last: int) -> tuple[list[float], int]:
        """What some cells contribute to the mean distance of centres: each face counts with its first vertex."""
        tile = tile_with_rings(self.surface, first, last, 3, places=self.surface.state)
        return distances_of_part(tile.vertices, tile.faces, tile.own[tile.faces.min(axis=1)])

    def round(self, distance: float, first: int, last: int) -> None:
        """One round on the vertices of some cells."""
        filtering = self.filtering
        rings = rings_of_round(filtering.settings, filtering.vertex_iterations)
        tile = tile_with_rings(self.surface, first, last, rings, places=self.surface.state)
        moved = round_of_part(
            tile.vertices,
            tile.faces,
            filtering.settings,
            distance=distance,
            vertex_iterations=filtering.vertex_iterations,
            vertex_update=filtering.vertex_update,
            border=filtering.border,
        )
        start, end = (int(self.surface.cells.starts[cell]) for cell in (first, last))
        by_slot = np.empty((end - start, 3))
        by_slot[tile.slots[tile.own] - start] = moved[tile.own]
        self.surface.next_state.write(start, by_slot)

    def end(self, first: int, last: int) -> tuple[Floats, Floats]:
        """Give some cells their coordinates; the corners of the box that they are in then."""
        start, mesh = self._normalised(first, last)
        moved = mesh.restored(self.surface.state.read(start, start + len(mesh)))
        numbers = self.surface.cells.numbers.read(start, start + len(mesh))
        check_healthy(mesh.vertices, moved, self.whole.diagonal, numbers.astype(np.int32))
        self.surface.moved.write(start, moved)
        return moved.min(axis=0), moved.max(axis=0)

    def _normalised(self, first: int, last: int) -> tuple[int, NormalisedMesh]:
        start, end = (int(self.surface.cells.starts[cell]) for cell in (first, last))
        return start, normalised_mesh(self.surface.cells.points.read(start, end), _NO_FACES, whole=self.whole)

    def do(self, tiles: list[tuple[int, int]], tasks: Tasks, progress: Callable[[float], None]) -> list[tuple[Floats, Floats]]:
        """All rounds; the box of each tile after them."""
        surface, count = self.surface, self.filtering.outer_iterations
        for column in (surface.state, surface.moved):
            tasks.run(column.create, surface.cells.count)
        tasks.map(self.begin, tiles, lambda share: None)
        for done in range(count):
            distance = 0.0
            if needs_distance(self.filtering.settings):
                sums = tasks.map(self.measure, tiles, lambda share: None)
                number = sum(n for _, n in sums)
                distance = math.fsum(part for parts, _ in sums for part in parts) / number if number else 0.0
            tasks.run(surface.next_state.create, surface.cells.count)
            part = lambda share, done=done: progress((done + share) / count)  # noqa: E731
            tasks.map(self.round, [(distance, *tile) for tile in tiles], part)
            tasks.run(surface.turn, surface.next_state, surface.state)
        found: list[tuple[Floats, Floats]] = tasks.map(self.end, tiles, lambda share: None)
        return found
