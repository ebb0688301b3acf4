"""Words and bars on a picture: titles, the scale bar, and the colour bar."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ..declaration import Floats
from ..filters.inspection import Limits

INK = (40, 44, 52)
#: heights in pixels of the strip for titles and of that for the colour bar
TITLE_STRIP, BAR_STRIP = 34, 58
_TITLE_SIZE, _SMALL = 17, 14
#: words are made smaller down to this, and then shortened
_SMALLEST = 10


def write_title(picture: Image.Image, text: str, left: int, top: int, width: int) -> None:
    """Write a title in the middle of a strip, smaller or shortened until it fits."""
    draw = ImageDraw.Draw(picture)
    font, text = _fitting(draw, text, width - 12)
    draw.text((left + width / 2, top + TITLE_STRIP / 2), text, fill=INK, font=font, anchor="mm")


def draw_scale_bar(picture: Image.Image, left: int, bottom: int, pixels_per_unit: float, most: float, unit: str = "") -> None:
    """Draw a bar of 1, 2 or 5 times a power of ten mesh units, at most `most` pixels long, with its length over it."""
    length = round_length(most / pixels_per_unit)
    end = left + length * pixels_per_unit
    draw = ImageDraw.Draw(picture)
    # White round them, as a close-up may be dark there.
    draw.rectangle((left - 2, bottom - 6, end + 2, bottom + 2), fill="white")
    draw.rectangle((left, bottom - 4, end, bottom), fill=INK)
    words = f"{number(length)} {unit}".strip()
    draw.text((left, bottom - 9), words, fill=INK, font=_font(_SMALL), anchor="ls", stroke_width=2, stroke_fill="white")


def draw_color_bar(
    picture: Image.Image, top: int, limits: Limits, colors: Callable[[Floats, Limits], Floats], label: str
) -> None:
    """Draw a colour bar over half of the width, with its ends and its label."""
    width = picture.width // 2
    left = (picture.width - width) // 2
    low, high = limits
    shown = colors(np.linspace(low, high, width), limits) if high > low else colors(np.full(width, low), limits)
    row = np.asarray(np.rint(255.0 * shown), dtype=np.uint8)
    picture.paste(Image.fromarray(np.broadcast_to(row, (14, width, 3)).copy()), (left, top + 4))
    draw = ImageDraw.Draw(picture)
    draw.rectangle((left - 1, top + 3, left + width, top + 18), outline=INK)
    font = _font(_SMALL)
    draw.text((left - 8, top + 11), number(low), fill=INK, font=font, anchor="rm")
    draw.text((left + width + 8, top + 11), number(high), fill=INK, font=font, anchor="lm")
    font, label = _fitting(draw, label, picture.width - 12, _SMALL)
    draw.text((picture.width / 2, top + 24), label, fill=INK, font=font, anchor="ma")


def round_length(most: float) -> float:
    """The largest of 1, 2 and 5 times powers of ten that is at most this, which is above 0."""
    power = 10.0 ** math.floor(math.log10(most))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= most * (1.0 + 1e-12))


def number(value: float) -> str:
    """A number in three digits, as it is written beside a bar."""
    return f"{value + 0.0:.3g}"


def _fitting(draw: ImageDraw.ImageDraw, text: str, width: int, size: int = _TITLE_SIZE) -> tuple[Any, str]:
    """A font in which the text is at most `width` wide, and the text, its middle left out if the smallest is too large."""
    for pixels in range(size, _SMALLEST - 1, -1):
        font = _font(pixels)
        if draw.textlength(text, font) <= width:
            return font, text
    kept = len(text)
    short = text
    while kept > 2 and draw.textlength(short, font) > width:
        kept -= 1
        short = f"{text[: (kept + 1) // 2]}...{text[len(text) - kept // 2 :]}"
    return font, short


def _font(pixels: int) -> Any:
    return ImageFont.load_default(pixels)
