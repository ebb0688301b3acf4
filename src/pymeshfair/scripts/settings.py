"""Settings: values of a recipe that have a name, which one place sets for all the steps that use them.

A ``<setting name="detail_size" default="6edge" unit="length" description="..."/>`` stands under ``<FilterScript>``, and each
``<Param ... setting="detail_size">`` that takes its value says so. MeshLab looks at neither: it runs the values of the steps,
which are those of the defaults.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from ..declaration import nearest
from .problems import shortened

#: the attributes of a ``<setting>``, in the order in which they are written
ATTRIBUTES = ("name", "default", "unit", "description")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,79}")


@dataclass(frozen=True)
class Setting:
    """A value of a recipe that has a name."""

    name: str  # by which it is set, ``--set NAME=VALUE``
    default: str  # the value as a command line would give it, such as ``6edge``
    unit: str = ""  # in which it is, or what kind of value it is, for readers; may be empty
    description: str = ""  # its effect; may be empty
    #: where it stands in its file, counted from 1; None if it came from no file. It does not count in a comparison.
    line: int | None = field(default=None, compare=False)


def is_name(text: str) -> bool:
    """Whether the text can name a setting or tag a step: letters, digits and underscores, a letter first."""
    return _NAME.fullmatch(text) is not None


def read_setting(attributes: Mapping[str, str], line: int) -> tuple[Setting | None, str | None, str | None]:
    """The setting that the attributes of a ``<setting>`` say, or what is wrong with them and what to write instead."""
    for missing in (name for name in ATTRIBUTES[:2] if name not in attributes):
        return None, f"<setting> has no {missing}; it takes {', '.join(ATTRIBUTES)}", None
    for unknown in (name for name in attributes if name not in ATTRIBUTES):
        message = f"<setting> has no attribute {shortened(unknown)!r}; it takes {', '.join(ATTRIBUTES)}"
        return None, message, nearest(unknown, ATTRIBUTES)
    if not is_name(attributes["name"]):
        return None, f"<setting> has the name {shortened(attributes['name'])!r}; it takes letters, digits and underscores", None
    return Setting(**attributes, line=line), None, None
