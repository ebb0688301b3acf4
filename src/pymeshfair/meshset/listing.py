"""Lists and finds filters of both kinds, by functions with the names of pymeshlab's."""

from __future__ import annotations

import re

import pymeshlab

from ..declaration import Filter
from ..errors import UnknownNameError
from ..meshlab.errors import UnknownFilterError
from ..registry import all_filters, custom_filters, find_filter
from .methods import shown_default


def filter_list() -> list[str]:
    """The Python names of all filters, MeshLab's and the plugins', sorted."""
    return sorted({*pymeshlab.filter_list(), *(known.python_name for known in custom_filters())})


def print_filter_list() -> None:
    """Print the Python names of all filters."""
    print("MeshSet class - list of filter names:")
    for name in filter_list():
        print(f"\t{name}")


def print_filter_parameter_list(filter_name: str) -> None:
    """Print a filter's parameters with what they take and their defaults.

    Raises:
        UnknownFilterError: there is no filter of that name; the message gives the nearest one.
    """
    known = known_filter(filter_name)
    if known is None:
        pymeshlab.print_filter_parameter_list(filter_name)
        return
    print(f"{known.python_name} filter - list of parameter names:")
    for parameter in known.parameters:
        default = "depends on the mesh" if parameter.default is None else repr(shown_default(parameter))
        print(f"\t{parameter.name} : {parameter.describe_allowed()} = {default}")
    if not known.parameters:
        print("\tNone.")


def search(words: str) -> None:
    """Print the filters whose names or descriptions hold all of the words, those with more of them in the name first."""
    wanted = re.findall(r"[a-z0-9]+", words.lower())

    def text(known: Filter) -> str:
        return f"{known.python_name} {known.name} {known.info}".lower()

    found = [known for known in all_filters() if wanted and all(word in text(known) for word in wanted)]
    found.sort(key=lambda known: -sum(word in f"{known.python_name} {known.name}".lower() for word in wanted))
    for known in found:
        print(f"{known.python_name} : {known.summary or known.name}")


def known_filter(name: str) -> Filter | None:
    """The filter of that Python or GUI name; None if MeshLab has one that no table knows, from a plugin loaded by hand.

    Raises:
        UnknownFilterError: there is none; the message gives the nearest one.
    """
    try:
        return find_filter(name)
    except UnknownNameError as error:
        if name in pymeshlab.filter_list():
            return None
        raise UnknownFilterError(str(error), suggestion=error.suggestion, cause=error.cause) from None
