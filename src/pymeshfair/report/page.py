"""One HTML file that needs no network: texts escaped, pictures and meshes inside, and only its own scripts allowed to run.

Parts of a page are macros in ``templates/parts.html``; `render` fills a template that takes them. Every text goes through the
template engine, which escapes it: the name of a scan stays a name, whatever it holds.
"""

from __future__ import annotations

import base64
import hashlib
import importlib.resources
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from PIL import Image

#: characters of a value that a list of parameters shows
_SHORT = 120


@dataclass(frozen=True)
class Figure:
    """A picture within a page.

    Attributes:
        source: the picture as a ``data:`` address.
        alternative: what it shows, for those who do not see it.
        caption: what stands below.
        width: in pixels.
        height: in pixels.
    """

    source: str
    alternative: str
    caption: str
    width: int
    height: int


def figure_of(picture: Image.Image, alternative: str, caption: str) -> Figure:
    """A picture that is kept within the page."""
    file = io.BytesIO()
    picture.quantize(128).save(file, format="PNG", optimize=True)
    source = f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode('ascii')}"
    return Figure(source, alternative, caption, picture.width, picture.height)


def render(
    template: str,
    /,
    *,
    scripts: Sequence[str] = ("viewer.js", "page.js"),
    sockets: bool = False,
    package: str = __package__,
    **values: Any,
) -> str:
    """Fill a template.

    Args:
        template: its file, such as ``"report.html"``. It extends ``page.html``, which takes ``title``.
        scripts: files in ``static/`` that the page holds, in this order.
        sockets: whether the page may talk with the server that it came from; else it reaches nothing.
        package: where templates and scripts are, besides this package.
        values: what the template names; missing ones are an error.
    """
    texts = tuple(Markup(_resource(name, package)) for name in scripts)
    style = Markup(_resource("page.css", package))
    allowed = " ".join(f"'sha256-{_digest(text)}'" for text in texts)
    policy = f"default-src 'none'; img-src data:; style-src 'sha256-{_digest(style)}'; script-src {allowed}"
    policy += "; base-uri 'none'; form-action 'none'" + ("; connect-src 'self'" if sockets else "")
    return _environment(package).get_template(template).render(scripts=texts, style=style, policy=policy, **values)


def _resource(name: str, package: str) -> str:
    """A script or style sheet of a package, else of this one."""
    places = (importlib.resources.files(place).joinpath("static", name) for place in (package, __package__))
    return next(place for place in places if place.is_file()).read_text("utf-8")


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")


@cache
def _environment(package: str) -> Environment:
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(place) for place in dict.fromkeys((package, __package__))]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"json_block": json_block, "short": short}
    return environment


def short(value: Any) -> str:
    """A value of a parameter in a few letters."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _SHORT else f"{text[:_SHORT]} ..."


def json_block(document: Mapping[str, Any]) -> Markup:
    """A document in terms of JSON for a ``<script type="application/json">``: nothing in it can end the element."""
    text = json.dumps(document, ensure_ascii=True, allow_nan=False)
    return Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))
