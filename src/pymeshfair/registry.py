"""Finds filters: pymeshfair's own and third parties' by the same entry points, MeshLab's from the table of facts about them."""

from __future__ import annotations

import functools
import importlib
import importlib.metadata
import keyword
import traceback
from collections.abc import Iterable, Set
from dataclasses import dataclass, replace

from .declaration import Filter, nearest
from .errors import UnknownNameError
from .meshlab.facts import meshlab_filters

#: Packages add filters under this entry-point group; the value names a module whose `Filter` objects are taken.
ENTRY_POINT_GROUP = "pymeshfair.plugins"


@dataclass(frozen=True)
class BrokenPlugin:
    """A plugin, or one filter of it, that could not be used.

    Attributes:
        distribution: the package that names the plugin.
        entry_point: as written in its metadata, e.g. ``scanlab = scanlab.filters``.
        reason: one sentence.
        details: the traceback, or an empty string.
    """

    distribution: str
    entry_point: str
    reason: str
    details: str = ""


@dataclass(frozen=True)
class _Registry:
    custom: dict[str, Filter]
    broken: tuple[BrokenPlugin, ...]

    @functools.cached_property
    def by_any_name(self) -> dict[str, Filter]:
        """Every filter under its Python name and under its GUI name."""
        found: dict[str, Filter] = {}
        for known in (*meshlab_filters(), *self.custom.values()):
            found[known.python_name] = known
            found[known.name] = known
        return found


def custom_filters() -> tuple[Filter, ...]:
    """The filters that plugins declare, ours first, in the order of their names."""
    return tuple(_load().custom.values())


def all_filters() -> tuple[Filter, ...]:
    """Every filter, MeshLab's and the plugins', in the order of their Python names."""
    return tuple(sorted((*meshlab_filters(), *custom_filters()), key=lambda f: f.python_name))


def broken_plugins() -> tuple[BrokenPlugin, ...]:
    """Plugins that could not be loaded and filters that were refused; they stop nothing else."""
    return _load().broken


def find_filter(name: str) -> Filter:
    """The filter of that Python name or GUI name.

    Raises:
        UnknownNameError: there is none; the message and the attribute `suggestion` give the nearest name of the same kind.
    """
    known = _load().by_any_name
    try:
        return known[name]
    except KeyError:
        near = _nearest(name, known)
        hint = f"; did you mean {near!r}?" if near else "; `pymeshfair list filters` names them all"
        raise UnknownNameError(f"there is no filter {name!r}{hint}", suggestion=near) from None


def reload_plugins() -> None:
    """Forget what was found, so that the next call looks again; needed after a package was installed into a running Python."""
    importlib.invalidate_caches()
    _load.cache_clear()


def _nearest(name: str, known: Iterable[str]) -> str | None:
    """The nearest Python name to what looks like one, else the nearest GUI name; if there is none, the other way round."""
    kinds: dict[bool, list[str]] = {True: [], False: []}
    for each in known:
        kinds[_looks_like_python(each)].append(each)
    kind = _looks_like_python(name)
    return nearest(name, kinds[kind]) or nearest(name, kinds[not kind])


def _looks_like_python(name: str) -> bool:
    return name.isidentifier() and "_" in name


@functools.cache
def _load() -> _Registry:
    taken = {name for known in meshlab_filters() for name in (known.python_name, known.name)}
    custom: list[Filter] = []
    broken: list[BrokenPlugin] = []
    for plugin in _plugins(broken):
        try:
            declared = plugin.filters()
        except (Exception, SystemExit) as error:
            broken.append(plugin.broken(f"{type(error).__name__}: {error}", traceback.format_exc()))
            continue
        if not declared:
            broken.append(plugin.broken("declares no filter"))
        for found in declared:
            if any(found.function is other.function for other in custom):
                continue  # imported from another plugin
            reason = _why_unusable(found, taken)
            if reason is not None:
                broken.append(plugin.broken(f"filter {found.python_name!r} {reason}"))
                continue
            taken |= {found.python_name, found.name}
            custom.append(replace(found, origin=plugin.distribution))
    custom.sort(key=lambda f: (f.origin != "pymeshfair", f.python_name))
    return _Registry({f.python_name: f for f in custom}, tuple(broken))


@dataclass(frozen=True)
class _Plugin:
    distribution: str
    entry: importlib.metadata.EntryPoint

    def filters(self) -> list[Filter]:
        loaded = self.entry.load()
        declared = [loaded] if isinstance(loaded, Filter) else [f for f in vars(loaded).values() if isinstance(f, Filter)]
        return list({id(f): f for f in declared}.values())  # each once, whatever names it has in its module

    def broken(self, reason: str, details: str = "") -> BrokenPlugin:
        return BrokenPlugin(self.distribution, f"{self.entry.name} = {self.entry.value}", reason, details)


def _why_unusable(found: Filter, taken: Set[str]) -> str | None:
    if found.function is None:
        return "has no function"
    if not found.python_name.isidentifier() or keyword.iskeyword(found.python_name) or not found.name.strip():
        return f"needs a Python name and a name for menus; they are {found.python_name!r} and {found.name!r}"
    clash = {found.python_name, found.name} & taken
    return f"cannot be added: the name {min(clash)!r} is taken by another filter" if clash else None


def _plugins(broken: list[BrokenPlugin]) -> list[_Plugin]:
    """The plugins by their packages' names, ours first so that no other package can take a name of ours."""
    found: dict[str, list[_Plugin]] = {}
    for distribution in importlib.metadata.distributions():
        # Each package's metadata apart: importlib's own entry_points() fails as a whole on one broken package.
        place = str(getattr(distribution, "_path", "?"))
        try:
            text = distribution.read_text("entry_points.txt")
            if not text or ENTRY_POINT_GROUP not in text:
                continue
            metadata = distribution.metadata
            name = metadata["Name"] if "Name" in metadata else place  # noqa: SIM401 - it promises no get() before 3.12
            if name in found:
                continue  # the same package further down sys.path
            entries = distribution.entry_points.select(group=ENTRY_POINT_GROUP)
            found[name] = [_Plugin(name, entry) for entry in sorted(entries, key=lambda e: e.name)]
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
            broken.append(BrokenPlugin(place, "entry_points.txt", reason, traceback.format_exc()))
    return [plugin for name in sorted(found, key=lambda n: (n != "pymeshfair", n)) for plugin in found[name]]
