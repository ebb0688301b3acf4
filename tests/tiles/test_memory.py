"""How much a tile may hold."""

from __future__ import annotations

import pytest

from pymeshfair.errors import ParameterError
from pymeshfair.tiles.plan import COMMAND, WORKER, budget, cloud_points, slice_rows, surface_vertices


@pytest.mark.parametrize("processors", [1, 2, 16])
@pytest.mark.parametrize("memory", [500_000_000, 10**9, 64 * 10**9])
def test_shares_add_up_to_no_more_than_there_is(memory: int, processors: int) -> None:
    """The command, the workers and a tile in each of them take at most the memory, on at most all processors."""
    share = budget(memory, processors)
    assert COMMAND + share.workers * (WORKER + share.tile) <= memory
    assert share.workers * share.threads <= processors
    assert share.tile > 0


def test_too_little_memory_is_refused_with_what_is_enough() -> None:
    """What the message asks for is enough for one worker."""
    with pytest.raises(ParameterError, match=r"499 MB are too little .* give 500MB"):
        budget(499_000_000, 4)
    assert budget(500_000_000, 4).workers == 1


@pytest.mark.parametrize("rings", [0, 1, 20, 300])
def test_a_tile_of_a_mesh_leaves_room_for_its_rings(rings: int) -> None:
    """V vertices and 4 sqrt(v) in each ring take what a tile may take, and never more."""
    tile, each = 10**8, 400
    found = surface_vertices(tile, each, rings)
    assert found + 4 * rings * found**0.5 == pytest.approx(tile / each, rel=0.01)
    assert found + 4 * rings * found**0.5 <= tile / each


def test_more_neighbours_and_longer_rows_leave_room_for_fewer_points() -> None:
    """Points of a tile fall with the neighbours, rows of a slice with their size; a tile has more points than neighbours."""
    assert cloud_points(10**8, 10) > cloud_points(10**8, 100)
    assert cloud_points(10**4, 500) > 500
    assert slice_rows(10**8, 12) > slice_rows(10**8, 120)
