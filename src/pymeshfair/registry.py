"""Finds filters: those of pymeshfair and third parties by entry points, those of MeshLab in the table of `meshlab.facts`."""

import functools
import importlib
import importlib.metadata
import sys
import traceback
from contextlib import suppress
from dataclasses import dataclass, replace
from keyword import iskeyword

from .declaration import Filter
from .errors import PymeshfairError, UnknownNameError, nearest
from .meshlab.facts import meshlab_filters

#: The entry-point group for plugins; each value names a `Filter`, or a module whose `Filter` objects are registered.
ENTRY_POINT_GROUP = "pymeshfair.plugins"


@dataclass(frozen=True)
class BrokenPlugin:
    """A plugin, or one of its filters, that cannot be used."""

    distribution: str  # the package of the plugin
    entry_point: str  # as in the metadata, e.g. ``scanlab = scanlab.filters``; ``entry_points.txt`` if that file is broken
    reason: str  # the end of a sentence, or the class and the message of an exception
    details: str = ""  # the traceback

    def __str__(self) -> str:
        return f"plugin {self.entry_point.partition('=')[0].strip()!r} of {self.distribution} cannot be used: {self.reason}"


@dataclass(frozen=True)
class _Registry:
    custom: tuple[Filter, ...]
    by_any_name: dict[str, Filter]  # each filter by its Python name and by its menu name
    broken: tuple[BrokenPlugin, ...]


def custom_filters() -> tuple[Filter, ...]:
    """The filters of all plugins, pymeshfair's first, in the order of their Python names."""
    return _load().custom


def all_filters() -> tuple[Filter, ...]:
    """All filters of MeshLab and the plugins, in the order of their Python names."""
    return tuple(sorted((*meshlab_filters(), *custom_filters()), key=lambda f: f.python_name))


def broken_plugins() -> tuple[BrokenPlugin, ...]:
    """The plugins that could not be loaded, and the filters that were refused."""
    return _load().broken


def is_known(name: str) -> bool:
    """Whether a filter has this Python name or menu name; unlike `find_filter` it does not search for similar names."""
    return name in _load().by_any_name


def find_filter(name: str) -> Filter:
    """Returns the filter with this Python name or menu name, or raises `UnknownNameError` with the nearest name."""
    registry = _load()
    if name in registry.by_any_name:
        return registry.by_any_name[name]
    near = nearest(name, registry.by_any_name)
    meant = f"did you mean {near!r}?" if near else "`pymeshfair list filters` shows all"
    cause = "; ".join(map(str, registry.broken)) or None
    also = f" ({cause})" if cause else ""
    raise UnknownNameError(f"there is no filter {name!r}; {meant}{also}", suggestion=near, cause=cause)


def reload_plugins() -> None:
    """Searches for plugins again, as after an installation from a running notebook."""
    importlib.invalidate_caches()
    _load.cache_clear()


@functools.cache
def _load() -> _Registry:
    if sys.flags.optimize > 1:
        raise PymeshfairError("filters need their docstrings, which -OO or PYTHONOPTIMIZE=2 removes; start Python without it")
    by_any_name = {name: declared for declared in meshlab_filters() for name in (declared.python_name, declared.name)}
    custom: list[Filter] = []
    broken: list[BrokenPlugin] = []
    for package, entry in _entry_points(broken):
        text = f"{entry.name} = {entry.value}"
        try:
            loaded = entry.load()
            filters = [f for f in ([loaded] if isinstance(loaded, Filter) else vars(loaded).values()) if isinstance(f, Filter)]
        except MemoryError:  # not the plugin's fault
            raise
        except (Exception, SystemExit) as error:
            broken.append(BrokenPlugin(package, text, f"{type(error).__name__}: {error}", traceback.format_exc()))
            continue
        if not filters:
            broken.append(BrokenPlugin(package, text, "declares no filter"))
        for declared in {id(f): f for f in filters}.values():  # once, even if its module gives it several names
            if declared.function is not None and any(declared.function is other.function for other in custom):
                continue  # imported from another plugin
            if reason := _why_unusable(declared, by_any_name):
                broken.append(BrokenPlugin(package, text, f"filter {declared.python_name!r} {reason}"))
                continue
            custom.append(replace(declared, origin=package))
            by_any_name |= dict.fromkeys((declared.python_name, declared.name), custom[-1])
    custom.sort(key=lambda f: (f.origin != "pymeshfair", f.python_name))
    return _Registry(tuple(custom), by_any_name, tuple(broken))


def _entry_points(broken: list[BrokenPlugin]) -> list[tuple[str, importlib.metadata.EntryPoint]]:
    """The plugins of all packages, each with its package; pymeshfair's come first, so that others cannot take their names."""
    by_name: dict[str, list[importlib.metadata.EntryPoint]] = {}
    for distribution in importlib.metadata.distributions():
        # One package at a time: `importlib.metadata.entry_points` fails completely on one broken package.
        place = str(getattr(distribution, "_path", "?"))
        try:
            if ENTRY_POINT_GROUP not in (distribution.read_text("entry_points.txt") or ""):
                continue
            with suppress(FileNotFoundError):  # raised by importlib_metadata, if another package has imported it
                metadata = distribution.metadata
                place = metadata["Name"] if "Name" in metadata else place  # noqa: SIM401 - no get() before Python 3.12
            if place not in by_name:  # else the same package occurs earlier on sys.path
                by_name[place] = sorted(distribution.entry_points.select(group=ENTRY_POINT_GROUP), key=lambda e: e.name)
        except MemoryError:  # not the package's fault
            raise
        except Exception as error:
            broken.append(BrokenPlugin(place, "entry_points.txt", f"{type(error).__name__}: {error}", traceback.format_exc()))
    return [(name, entry) for name in sorted(by_name, key=lambda n: (n != "pymeshfair", n)) for entry in by_name[name]]


def _why_unusable(declared: Filter, by_any_name: dict[str, Filter]) -> str | None:
    names = declared.python_name, declared.name
    if declared.function is None:
        return "has no function"
    if not names[0].isidentifier() or iskeyword(names[0]) or not names[1].strip():
        return f"needs a Python name and a menu name; they are {names[0]!r} and {names[1]!r}"
    for name in names:
        if other := by_any_name.get(name):
            return f"cannot be added: the name {name!r} is taken by {other.python_name!r} of {other.origin}"
    return None
