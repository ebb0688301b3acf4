"""Loads the plugins of all installed packages; one that fails is described, and stops no other."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import re
import traceback
from dataclasses import dataclass, field
from pathlib import Path

from .declaration import Filter

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
        names: of a filter that was refused, its Python name and its name in menus; empty if the whole plugin failed.
        source: the text of the module of a plugin that failed, as far as it can be read.
    """

    distribution: str
    entry_point: str
    reason: str
    details: str = ""
    names: tuple[str, ...] = ()
    source: str = field(default="", repr=False)

    def __str__(self) -> str:
        return f"plugin {self.entry_point.partition('=')[0].strip()!r} of {self.distribution} cannot be used: {self.reason}"

    def declares(self, name: str) -> bool:
        """Whether it declares a filter of that name, as far as its source shows."""
        if self.names:
            return name in self.names
        return re.search(rf"\bdef {re.escape(name)}\(|([\"']){re.escape(name)}\1", self.source) is not None


@dataclass(frozen=True)
class Plugin:
    """A plugin that has been loaded.

    Attributes:
        distribution: the package that names it.
        entry_point: as in `BrokenPlugin`.
        filters: what it declares, each once.
    """

    distribution: str
    entry_point: str
    filters: tuple[Filter, ...]

    def broken(self, reason: str, *, names: tuple[str, ...]) -> BrokenPlugin:
        """One of its filters that cannot be used."""
        return BrokenPlugin(self.distribution, self.entry_point, reason, names=names)


def load_plugins(broken: list[BrokenPlugin]) -> list[Plugin]:
    """The plugins by their packages' names, ours first so that no other package can take a name of ours.

    Args:
        broken: what could not be loaded is added here.
    """
    loaded = []
    for distribution, entry in _entry_points(broken):
        text = f"{entry.name} = {entry.value}"
        try:
            filters = _declared(entry.load())
        except (Exception, SystemExit) as error:
            reason, details = f"{type(error).__name__}: {error}", traceback.format_exc()
            broken.append(BrokenPlugin(distribution, text, reason, details, source=_source(entry.value.partition(":")[0])))
            continue
        if filters:
            loaded.append(Plugin(distribution, text, filters))
        else:
            broken.append(BrokenPlugin(distribution, text, "declares no filter"))
    return loaded


def _declared(loaded: object) -> tuple[Filter, ...]:
    declared = [loaded] if isinstance(loaded, Filter) else [f for f in vars(loaded).values() if isinstance(f, Filter)]
    return tuple({id(f): f for f in declared}.values())  # each once, whatever names it has in its module


def _source(module: str) -> str:
    """The text of a module that failed to load, without running it; empty if it cannot be had."""
    try:
        spec = importlib.util.find_spec(module)
        return "" if spec is None or spec.origin is None else Path(spec.origin).read_text("utf-8")
    except (Exception, SystemExit):
        return ""


def _name(distribution: importlib.metadata.Distribution) -> str | None:
    """The name of a package; None if it has no metadata or they name none."""
    try:
        metadata = distribution.metadata
    except FileNotFoundError:  # so says the library importlib_metadata, once something has imported it
        return None
    return metadata["Name"] if "Name" in metadata else None  # noqa: SIM401 - it promises no get() before 3.12


def _entry_points(broken: list[BrokenPlugin]) -> list[tuple[str, importlib.metadata.EntryPoint]]:
    by_name: dict[str, list[importlib.metadata.EntryPoint]] = {}
    for distribution in importlib.metadata.distributions():
        # Each package's metadata apart: importlib's own entry_points() fails as a whole on one broken package.
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
