"""Renders HTML pages that need no network: pictures and meshes are embedded, and only the page's own scripts may run.

Parts of a page are macros in ``templates/parts.html``; `render` fills a template that imports them. The template engine escapes
every text, so that the name of a scan cannot contain active HTML.
"""

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

#: the scripts of a page with the viewer
VIEWER = ("viewer.js", "page.js")
#: the most characters of a value in a list of parameters
_SHORT = 120


@dataclass(frozen=True)
class Figure:
    """A picture within a page."""

    source: str  # the picture as a ``data:`` address
    alternative: str  # the alternative text (``alt``)
    caption: str  # the text below
    width: int  # in pixels
    height: int  # in pixels


def figure_of(picture: Image.Image, alternative: str, caption: str) -> Figure:
    """A picture, embedded as a PNG file of 128 colours."""
    file = io.BytesIO()
    picture.quantize(128).save(file, format="PNG", optimize=True)
    source = f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode('ascii')}"
    return Figure(source, alternative, caption, picture.width, picture.height)


def render(
    template: str, /, *, scripts: Sequence[str] = VIEWER, sockets: bool = False, package: str = __package__, **values: Any
) -> str:
    """Fill a template, which extends ``page.html``; a variable that is missing is an error.

    The page holds these files of ``static/``, and may connect to nothing, or with `sockets` to its own server. `package` has
    further templates and scripts.
    """
    texts = tuple(Markup(_resource(name, package)) for name in scripts)
    style = Markup(_resource("page.css", package))
    allowed = " ".join(_digest(text) for text in texts)
    policy = f"default-src 'none'; img-src data:; style-src {_digest(style)}; script-src {allowed}"
    policy += "; base-uri 'none'; form-action 'none'" + ("; connect-src 'self'" if sockets else "")
    return _environment(package).get_template(template).render(scripts=texts, style=style, policy=policy, **values)


def _resource(name: str, package: str) -> str:
    """A script or style sheet of a package, else of this one."""
    places = (importlib.resources.files(place).joinpath("static", name) for place in (package, __package__))
    return next(place for place in places if place.is_file()).read_text("utf-8")


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


@cache
def _environment(package: str) -> Environment:
    loader = ChoiceLoader([PackageLoader(place) for place in dict.fromkeys((package, __package__))])
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"json_block": json_block, "short": short}
    return environment


def short(value: Any) -> str:
    """The value of a parameter in at most 120 characters and an ellipsis."""
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= _SHORT else f"{text[:_SHORT]} ..."


def json_block(document: Mapping[str, Any]) -> Markup:
    """A document as JSON for a ``<script type="application/json">``, escaped so that it cannot end the element."""
    text = json.dumps(document, ensure_ascii=True, allow_nan=False)
    return Markup(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))
