"""LAS and LAZ clouds by tiles: the probabilities of their coordinates, every dimension of what is kept as it was."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import laspy
import numpy as np
import pytest

from pymeshfair.files.errors import ContentsError
from pymeshfair.filters.outliers import local_outlier_probability
from pymeshfair.tiles.cloud import Cloud, do_selection, write_cloud
from pymeshfair.tiles.las import LasCloud
from pymeshfair.tiles.plan import Selection
from pymeshfair.tiles.sources import open_cloud
from pymeshfair.tiles.workers import Pool
from tests.files.surveys import scan
from tests.tiles.tiling import Here


@pytest.mark.parametrize(("form", "extension"), [(1, "las"), (3, "laz"), (6, "las"), (7, "laz")])
def test_every_dimension_is_kept(form: int, extension: str, tmp_path: Path) -> None:
    """What is kept is what LoOP keeps, each point with the bytes it had, and the probability as a dimension of its own."""
    source = scan(tmp_path / f"in.{extension}", form=form)
    points = np.stack([source.x, source.y, source.z], axis=1)
    expected = local_outlier_probability(points, neighbors=9, extent=2.0)
    cloud = Cloud(open_cloud(tmp_path / f"in.{extension}"), tmp_path)
    cloud, values, _ = do_selection(
        cloud,
        Selection(1, 9, 2.0, 0.7, deletes=True),
        cast("Pool", Here()),
        10**6,
        shape="boxes",
        progress=lambda _: None,
        most=100,
    )
    count = write_cloud(cloud, tmp_path / f"out.{extension}", 90)
    kept = expected <= 0.7
    assert count == np.count_nonzero(kept) == len(points) - values["selected_vertices"] < len(points)
    found = laspy.read(tmp_path / f"out.{extension}")
    for name in source.points.array.dtype.names:
        np.testing.assert_array_equal(found.points.array[name], source.points.array[name][kept])
    np.testing.assert_array_equal(found["outlier_probability"], expected[kept])
    np.testing.assert_array_equal(found.header.scales, source.header.scales)
    np.testing.assert_array_equal(found.header.offsets, source.header.offsets)
    assert found.header.version == source.header.version
    assert [v.record_data for v in found.header.vlrs if v.record_id == 7] == [b"kept"]
    np.testing.assert_array_equal(found.header.maxs, points[kept].max(axis=0))


def test_a_torn_file_is_refused(tmp_path: Path) -> None:
    """A file that ends before the points that its header declares is no cloud."""
    scan(tmp_path / "in.las", form=3)
    data = (tmp_path / "in.las").read_bytes()
    (tmp_path / "in.las").write_bytes(data[: len(data) // 2])
    with pytest.raises(ContentsError):
        list(LasCloud(tmp_path / "in.las").points(100))
