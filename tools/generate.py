"""Writes the files that follow from the declarations, the recipes and MeshLab.

``python tools/generate.py [stubs|pages|public-names|kernels|meshlab-table|all] [--check]``. Without a name it writes all but the
list of kernels and the table, which take minutes; the table changes only with pymeshlab. ``--check`` writes nothing and fails
if a file is not current.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import kernel_list
import meshlab_table
import pages
import public_names
import pymeshlab_stubs
import stubs

from pymeshfair.errors import PymeshfairError
from pymeshfair.registry import broken_plugins

#: by target, the files with the text that each should have
TARGETS: Mapping[str, Callable[[], dict[Path, str]]] = {
    "stubs": lambda: {stubs.STUB: stubs.format_stub(), pymeshlab_stubs.STUB: pymeshlab_stubs.format_stub()},
    "pages": lambda: {pages.DOCS / name: page() for name, page in pages.PAGES.items()},
    "public-names": lambda: {public_names.LIST: public_names.list_text()},
    "kernels": lambda: {kernel_list.LIST: kernel_list.list_text()},
    "meshlab-table": lambda: {meshlab_table.TABLE: meshlab_table.table_text()},
}
DEFAULT = ("stubs", "pages", "public-names")


def main(arguments: list[str] | None = None) -> int:
    """Write or check the files; the exit status."""
    parser = argparse.ArgumentParser(prog="generate.py", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("targets", nargs="*", choices=[*TARGETS, "all", []], metavar="|".join([*TARGETS, "all"]))
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is not current")
    options = parser.parse_args(arguments)
    if broken := [plugin for plugin in broken_plugins() if plugin.distribution == "pymeshfair"]:
        print("\n".join(["nothing is written, because filters would be missing:", *map(str, broken)]), file=sys.stderr)
        return 1
    targets = TARGETS if "all" in options.targets else options.targets or DEFAULT
    try:
        wanted = {path: text for target in targets for path, text in TARGETS[target]().items()}
    except PymeshfairError as error:
        print(f"nothing is written: {error}", file=sys.stderr)
        return 1
    stale = [path for path, text in wanted.items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    for path in stale:
        if not options.check:
            path.write_text(wanted[path], encoding="utf-8")
        print(f"{path}: {'not current' if options.check else 'written'}", file=sys.stderr)
    return int(options.check and bool(stale))


if __name__ == "__main__":
    sys.exit(main())
