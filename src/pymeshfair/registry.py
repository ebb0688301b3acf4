"""Finds filters: pymeshfair's and third parties' by entry points, MeshLab's in the table of facts.

A plugin that cannot be loaded is recorded; all others still work.
"""

import functools
import importlib
import importlib.metadata
import logging
import traceback
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from keyword import iskeyword

from .declaration import Filter, nearest
from .errors import UnknownNameError
from .meshlab.facts import meshlab_filters

#: Packages add filters under this entry-point group; the value names a module whose `Filter` objects are taken.
ENTRY_POINT_GROUP = "pymeshfair.plugins"
_LOG = logging.getLogger("pymeshfair")


@dataclass(frozen=True)
class BrokenPlugin:
    """A plugin, or one filter of it, that could not be used."""

    distribution: str  # the package that names the plugin
    entry_point: str  # as written in its metadata, e.g. ``scanlab = scanlab.filters``.
    reason: str  # one sentence
    details: str = ""  # the traceback, or an empty string
    #: of a filter that was refused, its Python name and its name in menus; empty if the whole plugin failed
    names: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"plugin {self.entry_point.partition('=')[0].strip()!r} of {self.distribution} cannot be used: {self.reason}"


def _plugins(broken: list[BrokenPlugin]) -> Iterator[tuple[str, str, tuple[Filter, ...]]]:
    """Of each plugin its package, its entry point as in `BrokenPlugin` and its filters; those that fail are added to `broken`.

    pymeshfair's come first, so that no other package can take their names.
    """
    for distribution, entry in _entry_points(broken):
        text = f"{entry.name} = {entry.value}"
        try:
            filters = _declared(entry.load())
        except (Exception, SystemExit) as error:
            reason, details = f"{type(error).__name__}: {error}", traceback.format_exc()
            broken.append(BrokenPlugin(distribution, text, reason, details))
            continue
        if filters:
            yield distribution, text, filters
        else:
            broken.append(BrokenPlugin(distribution, text, "declares no filter"))


def _declared(loaded: object) -> tuple[Filter, ...]:
    declared = [loaded] if isinstance(loaded, Filter) else [f for f in vars(loaded).values() if isinstance(f, Filter)]
    return tuple({id(f): f for f in declared}.values())  # each once, even if its module binds it to several names


def _name(distribution: importlib.metadata.Distribution) -> str | None:
    """The name of a package; None if it has no metadata or no name there."""
    try:
        metadata = distribution.metadata
    except FileNotFoundError:  # raised by the library importlib_metadata, once something has imported it
        return None
    return metadata["Name"] if "Name" in metadata else None  # noqa: SIM401 - it promises no get() before 3.12


def _entry_points(broken: list[BrokenPlugin]) -> list[tuple[str, importlib.metadata.EntryPoint]]:
    by_name: dict[str, list[importlib.metadata.EntryPoint]] = {}
    for distribution in importlib.metadata.distributions():
        # Package by package: importlib's own entry_points() fails completely on one broken package.
        place = str(getattr(distribution, "_path", "?"))
        try:
            text = distribution.read_text("entry_points.txt")
            if not text or ENTRY_POINT_GROUP not in text:
                continue
            name = _name(distribution) or place
            if name in by_name:
                continue  # the same package further down sys.path
            entries = distribution.entry_points.select(group=ENTRY_POINT_GROUP)
            by_name[name] = sorted(entries, key=lambda e: e.name)
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
            broken.append(BrokenPlugin(place, "entry_points.txt", reason, traceback.format_exc()))
    return [(name, entry) for name in sorted(by_name, key=lambda n: (n != "pymeshfair", n)) for entry in by_name[name]]


@dataclass(frozen=True)
class _Registry:
    custom: dict[str, Filter]
    broken: tuple[BrokenPlugin, ...]

    @functools.cached_property
    def by_any_name(self) -> dict[str, Filter]:
        """Every filter under its Python name and under its GUI name."""
        return _by_any_name((*meshlab_filters(), *self.custom.values()))


def custom_filters() -> tuple[Filter, ...]:
    """The filters that plugins declare, ours first, in the order of their names."""
    return tuple(_load().custom.values())


def all_filters() -> tuple[Filter, ...]:
    """Every filter, MeshLab's and the plugins', in the order of their Python names."""
    return tuple(sorted((*meshlab_filters(), *custom_filters()), key=lambda f: f.python_name))


def broken_plugins() -> tuple[BrokenPlugin, ...]:
    """Plugins that could not be loaded and filters that were refused; they stop nothing else."""
    return _load().broken


def is_known(name: str) -> bool:
    """Whether there is a filter of that Python name or GUI name; unlike `find_filter` it looks for no similar names."""
    return name in _load().by_any_name


def find_filter(name: str) -> Filter:
    """The filter of that Python name or GUI name.

    If another filter of that name was refused, a warning is logged once.

    Raises:
        UnknownNameError: there is none. Attribute `suggestion` is the nearest name of the same kind, `cause` names the plugins
            that cannot be used and their errors; the message has both.
    """
    registry = _load()
    try:
        declared = registry.by_any_name[name]
    except KeyError:
        raise _unknown(name, registry) from None
    for broken in registry.broken:
        if name in broken.names:
            _warn_once(f"filter {name!r} is that of {declared.origin}; {broken}")
    return declared


def reload_plugins() -> None:
    """Look for plugins again; needed after a package was installed into a running Python, such as a notebook's."""
    importlib.invalidate_caches()
    _load.cache_clear()
    _warn_once.cache_clear()


def _unknown(name: str, registry: _Registry) -> UnknownNameError:
    """The error for a name without a filter."""
    if why := "; ".join(str(broken) for broken in registry.broken if name in broken.names):
        return UnknownNameError(f"filter {name!r} is not available: {why}", cause=why)
    near = _nearest(name, registry.by_any_name)
    hint = f"; did you mean {near!r}?" if near else "; `pymeshfair list filters` shows all"
    cause = "; ".join(str(broken) for broken in registry.broken if broken.details) or None
    also = f" ({cause})" if cause else ""
    return UnknownNameError(f"there is no filter {name!r}{hint}{also}", suggestion=near, cause=cause)


@functools.cache
def _warn_once(text: str) -> None:
    _LOG.warning("%s", text)


def _nearest(name: str, names: Collection[str]) -> str | None:
    """The nearest name of the same kind, Python name or GUI name; without one, the nearest of all."""
    alike = [each for each in names if _looks_like_python(each) == _looks_like_python(name)]
    return nearest(name, alike) or nearest(name, names)


def _looks_like_python(name: str) -> bool:
    return name.isidentifier() and "_" in name


def _by_any_name(filters: Iterable[Filter]) -> dict[str, Filter]:
    return {name: declared for declared in filters for name in (declared.python_name, declared.name)}


@functools.cache
def _load() -> _Registry:
    taken = _by_any_name(meshlab_filters())
    custom: list[Filter] = []
    broken: list[BrokenPlugin] = []
    for distribution, entry_point, filters in _plugins(broken):
        for declared in filters:
            if any(declared.function is other.function for other in custom):
                continue  # imported from another plugin
            reason = _why_unusable(declared, taken)
            if reason is not None:
                names, why = (declared.python_name, declared.name), f"filter {declared.python_name!r} {reason}"
                broken.append(BrokenPlugin(distribution, entry_point, why, names=names))
                continue
            custom.append(replace(declared, origin=distribution))
            taken |= _by_any_name(custom[-1:])
    custom.sort(key=lambda f: (f.origin != "pymeshfair", f.python_name))
    return _Registry({f.python_name: f for f in custom}, tuple(broken))


def _why_unusable(declared: Filter, taken: dict[str, Filter]) -> str | None:
    if declared.function is None:
        return "has no function"
    if not declared.python_name.isidentifier() or iskeyword(declared.python_name) or not declared.name.strip():
        return f"needs a Python name and a name for menus; they are {declared.python_name!r} and {declared.name!r}"
    for name in (declared.python_name, declared.name):
        if name in taken:
            other = taken[name]
            return f"cannot be added: the name {name!r} is taken by {other.python_name!r} of {other.origin}"
    return None
