"""HTML pages that need no network: pictures, charts, sections and meshes are embedded, and only their own scripts may run.

Parts of a page are macros in ``templates/parts.html``. The template engine escapes every text, so that the name of a scan cannot
contain active HTML.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import importlib.resources
import io
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from PIL import Image

from ..declaration import Floats
from ..errors import ParameterError
from ..looking.picture import number, round_length
from ..mesh_data import MeshData
from ..places import point_text

VIEWER = ("viewer.js", "page.js")  # the scripts of a page with the viewer


@dataclass(frozen=True)
class Figure:
    """A picture in a page."""

    source: str  # the picture as a ``data:`` address
    alternative: str  # the ``alt`` text
    caption: str  # the text below
    width: int  # in pixels
    height: int


def figure_of(picture: Image.Image, alternative: str, caption: str) -> Figure:
    """Embeds a picture as a PNG file of 128 colours."""
    file = io.BytesIO()
    picture.quantize(128).save(file, format="PNG", optimize=True)
    source = f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode('ascii')}"
    return Figure(source, alternative, caption, picture.width, picture.height)


def render(template: str, /, *, scripts: Sequence[str] = VIEWER, sockets: bool = False, **values: Any) -> str:
    """Fill a template that extends ``page.html``; a missing variable is an error.

    The page contains these `scripts` of ``static/``. It may connect to no server; with `sockets`, to its own server only.
    """
    static = importlib.resources.files(__package__) / "static"
    style, *texts = (Markup((static / name).read_text("utf-8")) for name in ("page.css", *scripts))
    policy = f"default-src 'none'; img-src data:; style-src {_digest(style)}; script-src {' '.join(map(_digest, texts))}"
    policy += "; base-uri 'none'; form-action 'none'" + ("; connect-src 'self'" if sockets else "")
    return _environment().get_template(template).render(scripts=texts, style=style, policy=policy, **values)


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader(__package__), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.policies["json.dumps_kwargs"] = {"allow_nan": False}
    environment.filters["short"] = short
    return environment


def short(value: Any) -> str:
    """The value of a parameter as text, cut to 120 characters and an ellipsis."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 120 else f"{text[:120]} ..."


@dataclass(frozen=True)
class Plane:
    """A plane at right angles to an axis (0, 1 or 2 for x, y or z), at a coordinate in mesh units."""

    axis: int
    value: float

    @classmethod
    def parse(cls, text: str) -> Plane:
        name, _, number = text.partition("=")
        with contextlib.suppress(ValueError):
            if math.isfinite(value := float(number)):
                return cls(("x", "y", "z").index(name.strip()), value)
        raise ParameterError(f"{text!r} is no section: write an axis and a coordinate in mesh units, such as z=12.5")

    def __str__(self) -> str:
        return f"{'xyz'[self.axis]} = {point_text([self.value])}"


def outline(mesh: MeshData, plane: Plane) -> Floats:
    """(s, 2, 2) the segments where a plane cuts the faces of a mesh, in the coordinates of the other two axes.

    A vertex in the plane counts as above, so that a face has at most one segment. If no face is cut then, it counts as below.
    """
    heights = mesh.vertices[:, plane.axis] - plane.value
    for above in (heights >= 0.0, heights > 0.0):
        corners_above = above[mesh.faces].sum(axis=1)
        if len(cut := mesh.faces[(corners_above > 0) & (corners_above < 3)]):
            break
    up = above[cut]
    # The corner that is alone on its side comes first: the plane cuts its two edges.
    alone = np.where(up.sum(axis=1) == 1, up.argmax(axis=1), (~up).argmax(axis=1))
    first, *others = (cut[np.arange(len(cut)), (alone + k) % 3] for k in range(3))
    flat = np.delete(mesh.vertices, plane.axis, axis=1)
    ends = []
    for other in others:
        share = heights[first] / (heights[first] - heights[other])
        ends.append(flat[first] + share[:, None] * (flat[other] - flat[first]))
    return np.stack(ends, axis=1)


#: the sizes of a chart and of a section, in units that the page scales
_WIDTH, _HEIGHT, _SECTION_HEIGHT, _MARGIN = 460, 220, 320, 16
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 450, 22, 184
_BARS = 48  # of a histogram


@dataclass(frozen=True)
class Chart:
    """The data for the template of a chart."""

    title: str
    summary: str  # a sentence about the data, for screen readers
    across: str  # the quantity of the horizontal axis; the vertical axis shows percent
    lines: dict[str, str]  # the paths of the curves, under "before" and "after", which the style sheet distinguishes
    ticks_across: list[tuple[float, str]]  # the marks at the horizontal axis: place and text
    ticks_upwards: list[tuple[float, str]]
    headers: tuple[str, ...]  # of the table's columns
    rows: tuple[tuple[str, ...], ...]  # of the table

    width, height, left, right, top, bottom = _WIDTH, _HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM


def histogram(title: str, across: str, samples: Mapping[str, Floats], low: float, high: float) -> Chart | None:
    """A histogram in percent; end bars include values beyond the limits. None without finite values or finite `low` < `high`."""
    finite = {name: numbers for name, values in samples.items() if len(numbers := values[np.isfinite(values)])}
    if not (finite and math.isfinite(high - low) and high > low):
        return None
    edges = np.linspace(low, high, _BARS + 1)
    shares = {name: 100.0 * np.histogram(np.clip(values, low, high), edges)[0] / len(values) for name, values in finite.items()}
    most = max(float(share.max()) for share in shares.values())
    medians = ", ".join(f"{name} {np.median(values):.4g}" for name, values in finite.items())
    return Chart(
        title=title,
        summary=f"Medians: {medians} ({across}).",
        across=across,
        lines={name: _steps(edges, share, most) for name, share in shares.items()},
        ticks_across=[(_across(x, low, high), f"{x:.4g}") for x in round_numbers(low, high, 6)],
        ticks_upwards=[(_upwards(y, most), f"{y:.4g}") for y in round_numbers(0.0, most, 4)],
        headers=(across, *(f"{name}, %" for name in shares)),
        rows=tuple(
            (f"{a:.4g} to {b:.4g}", *(f"{share:.2f}" for share in bar))
            for a, b, *bar in zip(edges[:-1], edges[1:], *shares.values(), strict=True)
        ),
    )


def round_numbers(low: float, high: float, count: int) -> list[float]:
    """About `count` numbers from `low` to `high`: the multiples of 1, 2 or 5 times a power of ten."""
    rough = (high - low) / count
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= rough * (1.0 - 1e-12))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [k * step for k in range(first, last + 1)]


def _across(x: float, low: float, high: float) -> float:
    return round(_LEFT + (_RIGHT - _LEFT) * (x - low) / (high - low), 1)


def _upwards(y: float, most: float) -> float:
    return round(_BOTTOM - (_BOTTOM - _TOP) * y / most, 1)


def _steps(edges: Floats, values: Floats, most: float) -> str:
    low, *_, high = bounds = edges.tolist()
    places = [_across(x, low, high) for x in bounds]
    tops = zip(places[:-1], places[1:], values.tolist(), strict=True)
    path = "".join(f"L{left:g} {_upwards(y, most):g}H{right:g}" for left, right, y in tops)
    return f"M{places[0]:g} {_BOTTOM:g}{path}L{places[-1]:g} {_BOTTOM:g}"


@dataclass(frozen=True)
class SectionChart:
    """The data for the template of a section."""

    title: str  # the plane, and the directions of the other two axes
    before: str  # the path of the outline of the first mesh
    after: str  # of the second mesh
    bar: float  # the length of the scale bar in the picture
    bar_words: str  # its length on the scan, with the unit if there is one

    width, height = _WIDTH, _SECTION_HEIGHT


def section_chart(meshes: Iterable[MeshData], plane: Plane, unit: str | None) -> SectionChart | None:
    """The section of two meshes; None if the plane cuts neither, or only touches them at one point."""
    outlines = [outline(mesh, plane) for mesh in meshes]
    points = np.concatenate(outlines).reshape(-1, 2)
    if not len(np.unique(points, axis=0)) > 1:
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.array([_WIDTH - 2 * _MARGIN, _SECTION_HEIGHT - 3 * _MARGIN])
    scale = float((room / np.maximum(high - low, 1e-300)).min())
    right, up = [axis for k, axis in enumerate("xyz") if k != plane.axis]
    bar = round_length(0.25 * _WIDTH / scale)
    before_path, after_path = (_path(segments, low, scale) for segments in outlines)
    title = f"Section {plane}; {right} to the right, {up} upwards"
    return SectionChart(title, before_path, after_path, bar * scale, f"{number(bar)} {unit or ''}".strip())


def _path(segments: Floats, low: Floats, scale: float) -> str:
    places = (segments - low) * scale
    x, y = places[..., 0] + _MARGIN, _SECTION_HEIGHT - 2 * _MARGIN - places[..., 1]
    return "".join(f"M{a:.2f} {b:.2f}L{c:.2f} {d:.2f}" for (a, c), (b, d) in zip(x.tolist(), y.tolist(), strict=True))
