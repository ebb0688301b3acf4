"""What the elements of a script mean: a ``<filter>`` becomes a step, a ``<Param>`` one of its values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..declaration import Filter, nearest
from ..errors import UnknownNameError
from ..meshlab.renamed import renamed_filter
from ..registry import find_filter
from .parameters import read_value
from .script import Step


class StepBuilder:
    """Collects steps with checked values.

    Attributes:
        steps: those whose filter is known.
        filters: how many filters have begun, known or not.
        filter_name: as the script calls the filter that is open, or None.
    """

    def __init__(self, complain: Callable[..., None]) -> None:
        """See the class; `complain(message, parameter=..., suggestion=...)` takes note of what is wrong."""
        self.steps: list[Step] = []
        self.filters = 0
        self.filter_name: str | None = None
        self._complain = complain
        self._filter: Filter | None = None
        self._line = 0
        self._values: dict[str, Any] = {}

    def start_filter(self, tag: str, name: str | None, line: int) -> None:
        """A ``<filter>`` or ``<xmlfilter>`` begins in that line of the file."""
        self.filters += 1
        self.filter_name, self._line = name, line
        if tag == "xmlfilter":
            self._complain(f"<xmlfilter> is of MeshLab 2016, which alone can run it{_today(name)}", suggestion="filter")
        elif name is None:
            self._complain("<filter> has no name; MeshLab would fail there")
        else:
            self._filter = self._known_filter(name)

    def end_filter(self) -> None:
        """The filter that is open ends, with all its values read."""
        if self._filter is not None:
            self.steps.append(Step(self._filter, self._filter.in_order(self._values), self._line))
        self._filter, self.filter_name, self._values = None, None, {}

    def add_param(self, attributes: dict[str, str]) -> None:
        """The value of a ``<Param>`` within the filter that is open."""
        known = self._filter
        if known is None:
            return
        name = attributes.get("name")
        if name is None:
            self._complain("<Param> has no name; MeshLab would drop it")
            return
        parameter = next((p for p in known.parameters if p.xml_name == name), None)
        if parameter is None:
            in_python = next((p.xml_name for p in known.parameters if p.name == name), None)
            names = [p.xml_name for p in known.parameters]
            allowed = f"it has {', '.join(names)}" if names else "it has none"
            near = in_python or nearest(name, names)
            self._complain(f"the filter has no such parameter; {allowed}", parameter=name, suggestion=near)
            return
        if parameter.name in self._values:
            self._complain("is given twice; MeshLab would take the last", parameter=name)
            return
        value, complaints = read_value(parameter, attributes, filter_name=known.python_name)
        self._values[parameter.name] = value
        for message, suggestion in complaints:
            self._complain(message, parameter=name, suggestion=suggestion)

    def _known_filter(self, name: str) -> Filter | None:
        try:
            found = find_filter(name)
        except UnknownNameError as error:
            renamed = renamed_filter(name)
            if renamed is not None:
                self._complain(f"MeshLab has renamed this filter to {renamed.name!r}{renamed.note}", suggestion=renamed.name)
            else:
                near = error.suggestion
                why = f": {error.cause}" if error.cause else ""
                self._complain(f"there is no filter of that name{why}", suggestion=find_filter(near).name if near else None)
            return None
        if found.name != name:
            self._complain("that is the filter's name in Python; scripts use the one in MeshLab's menus", suggestion=found.name)
            return None
        return found


def _today(name: str | None) -> str:
    """What the filter of an ``<xmlfilter>`` is called today, as the end of a sentence."""
    renamed = renamed_filter(name or "")
    return "" if renamed is None else f"; the filter is called {renamed.name!r} now"
