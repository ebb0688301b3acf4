"""LAS files as a surveyor has them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import laspy
import numpy as np


def scan(path: Path, *, form: int, count: int = 700) -> Any:
    """A hillside with some points above it, in the coordinates of a map, with all that a scanner says of a point."""
    random = np.random.default_rng(form)
    header = laspy.LasHeader(point_format=form, version="1.4" if form > 5 else "1.2")
    header.scales, header.offsets = [1e-3, 1e-3, 1e-4], [5e5, 5.4e6, 300.0]
    header.add_extra_dim(laspy.ExtraBytesParams("amplitude", "uint16"))
    header.vlrs.append(laspy.VLR("somebody", 7, "a note", b"kept"))
    cloud = laspy.LasData(header)
    cloud.x, cloud.y = 5e5 + random.uniform(0, 50, count), 5.4e6 + random.uniform(0, 50, count)
    cloud.z = 300 + 0.2 * (cloud.x - 5e5) + random.normal(scale=0.02, size=count) + 9.0 * (random.random(count) < 0.03)
    for name, most in (
        ("intensity", 60000),
        ("classification", 20),
        ("return_number", 5),
        ("user_data", 200),
        ("amplitude", 9999),
    ):
        cloud[name] = random.integers(0, most, count)
    cloud.gps_time = np.arange(count) / 7.0
    cloud.write(path)
    return cloud
