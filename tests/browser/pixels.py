"""What a canvas shows."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

#: so often a canvas is looked at that does not come to rest
MOST_LOOKS = 30


def canvas_pixels(page: Any) -> NDArray[np.int64]:
    """(h, w, 3) the pixels of the canvas, once everything is drawn that was asked for: three looks in a row see the same."""
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    looks: list[NDArray[np.int64]] = []
    for _ in range(MOST_LOOKS):
        picture = Image.open(io.BytesIO(page.locator("canvas").screenshot()))
        looks.append(np.asarray(picture.convert("RGB"), dtype=np.int64))
        if len(looks) >= 3 and all(np.array_equal(looks[-1], look) for look in looks[-3:-1]):
            break
        page.wait_for_timeout(100)
    return looks[-1]


def halves(pixels: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The views beside each other, without names, rings and the scale bar at their borders."""
    height, middle = pixels.shape[0], pixels.shape[1] // 2
    rows = slice(40, height - 60)
    return pixels[rows, 20 : middle - 20], pixels[rows, middle + 20 : 2 * middle - 20]


def share_changed(one: NDArray[np.int64], other: NDArray[np.int64]) -> float:
    """Which share of the pixels differ clearly."""
    return float((np.abs(one - other).max(axis=2) > 24).mean())


def soon(page: Any, is_so: Callable[[], bool]) -> bool:
    """Whether something comes true within ten seconds: a page shows what was done to it at its next frame."""
    for _ in range(100):
        if is_so():
            return True
        page.wait_for_timeout(100)
    return False
