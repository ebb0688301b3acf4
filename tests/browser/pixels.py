"""What a canvas shows."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image


def canvas_pixels(page: Any) -> NDArray[np.int64]:
    """(h, w, 3) the pixels of the canvas, once everything is drawn that was asked for."""
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    picture = Image.open(io.BytesIO(page.locator("canvas").screenshot()))
    return np.asarray(picture.convert("RGB"), dtype=np.int64)


def halves(pixels: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The views beside each other, without names, rings and the scale bar at their borders."""
    height, middle = pixels.shape[0], pixels.shape[1] // 2
    rows = slice(40, height - 60)
    return pixels[rows, 20 : middle - 20], pixels[rows, middle + 20 : 2 * middle - 20]


def share_changed(one: NDArray[np.int64], other: NDArray[np.int64]) -> float:
    """Which share of the pixels differ clearly."""
    return float((np.abs(one - other).max(axis=2) > 24).mean())
