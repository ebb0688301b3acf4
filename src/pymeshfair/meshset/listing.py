"""Lists and finds filters of both kinds, by functions with the names of pymeshlab's."""

import re

import pymeshlab

from ..declaration import Filter
from ..errors import UnknownNameError
from ..meshlab.base import UnknownFilterError
from ..registry import all_filters, custom_filters, find_filter
from .methods import shown_default


def filter_list() -> list[str]:
    """The Python names of all filters, MeshLab's and the plugins', sorted."""
    return sorted({*pymeshlab.filter_list(), *(declared.python_name for declared in custom_filters())})


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
    declared = known_filter(filter_name)
    if declared is None:
        pymeshlab.print_filter_parameter_list(filter_name)
        return
    print(f"{declared.python_name} filter - list of parameter names:")
    for parameter in declared.parameters:
        default = "depends on the mesh" if parameter.default is None else repr(shown_default(parameter))
        print(f"\t{parameter.name} : {parameter.describe_allowed()} = {default}")
    if not declared.parameters:
        print("\tNone.")


def search(words: str) -> None:
    """Print the filters whose names or descriptions hold all of the words, those with more of them in the name first."""
    wanted = re.findall(r"[a-z0-9]+", words.lower())

    def text(declared: Filter) -> str:
        return f"{declared.python_name} {declared.name} {declared.info}".lower()

    matches = [declared for declared in all_filters() if wanted and all(word in text(declared) for word in wanted)]
    matches.sort(key=lambda declared: -sum(word in f"{declared.python_name} {declared.name}".lower() for word in wanted))
    for declared in matches:
        print(f"{declared.python_name} : {declared.summary or declared.name}")


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
