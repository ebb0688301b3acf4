"""The directions of imports, the names of modules and the completeness of declarations, read from the sources."""

from __future__ import annotations

import ast
import builtins
import functools
import importlib
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from pymeshfair.errors import PymeshfairError
from pymeshfair.registry import broken_plugins, custom_filters

ROOT = Path(__file__).parent.parent
#: the folders of the packages and the names under which they are imported
FOLDERS = {
    "src/pymeshfair": "pymeshfair",
    "filters": "pymeshfair.filters",
    "plugins": "pymeshfair.plugins",
    "mlx_scripts": "pymeshfair.mlx_scripts",
}
#: from the ground up: a part of the host imports parts of a lower floor or of its own part
FLOORS = [
    {"errors", "garbage", "operating_system", "places"},
    {"declaration", "processes"},
    {"mesh_data", "meshlab"},
    {"calling", "files", "registry", "write_back"},
    {"scripts"},
    {"door", "recipe"},
    {"meshset"},
    {"running"},
    {"authoring", "looking"},
    {"report"},
    {"tiles", "tuning"},
    {"batch"},
    {"commands"},
    {"__main__"},
]
#: as many lines in a row stand in one place only
SAME_LINES = 8
#: the parts that may import pymeshlab, all others leave it to them; '' is the package itself, which does so when asked for a name
TOUCH_PYMESHLAB = {"", "door", "meshlab", "meshset", "write_back"}
#: what plugins may know of the host
PLUGINS_MAY_IMPORT = {"declaration", "errors", "filters", "plugins"}


def sources() -> Iterator[tuple[str, Path]]:
    """Every module of the product: its dotted name and its file."""
    for folder, package in FOLDERS.items():
        for parent, folders, names in os.walk(ROOT / folder):  # does not follow the links in src/pymeshfair
            folders[:] = sorted(f for f in folders if f != "__pycache__")
            for name in sorted(n for n in names if n.endswith(".py")):
                inside = (Path(parent) / name).relative_to(ROOT / folder).with_suffix("")
                parts = [p for p in inside.parts if p != "__init__"]
                yield ".".join([package, *parts]), Path(parent) / name


MODULES = dict(sources())


@functools.cache
def imports(module: str) -> set[str]:
    """The absolute names of everything that a module imports, at its top or within a function."""
    path = MODULES[module]
    package = module.split(".") if path.name == "__init__.py" else module.split(".")[:-1]
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) + 1 - node.level] if node.level else []
            start = ".".join([*base, *(node.module or "").split(".")]).strip(".")
            # `from . import declaration` names a module, `from .declaration import Filter` a thing within one
            found |= {f"{start}.{alias.name}" if f"{start}.{alias.name}" in MODULES else start for alias in node.names}
    return found


def part(name: str) -> str:
    """The part of the host that a dotted name belongs to: ``pymeshfair.running.job`` to ``running``, the package itself to ''."""
    return f"{name}.".split(".")[1]


def ours(module: str) -> set[str]:
    """What a module imports of pymeshfair."""
    return {name for name in imports(module) if name.split(".")[0] == "pymeshfair"}


HOST = [m for m in MODULES if part(m) not in {"filters", "plugins", "mlx_scripts", ""}]
FILTERS = [m for m in MODULES if part(m) == "filters"]
PLUGINS = [m for m in MODULES if part(m) == "plugins"]


def test_every_part_of_the_host_has_a_floor() -> None:
    """A new part of the host is placed before it is used, and no floor names a part that is gone."""
    assert {part(m) for m in HOST} == set().union(*FLOORS)


def test_host_imports_downwards() -> None:
    """A module of the host imports its own part, lower floors and the mathematics, and never a plugin."""
    floor = {name: level for level, names in enumerate(FLOORS) for name in names}
    everywhere = {"", "filters", "mlx_scripts"}
    assert not [
        f"{module} imports {name}"
        for module in HOST
        for name in ours(module)
        if part(name) not in {part(module), *everywhere} and floor.get(part(name), len(FLOORS)) >= floor[part(module)]
    ]


def test_filters_know_nothing_of_ours_outside() -> None:
    """The mathematics imports neither the host, nor a plugin, nor pymeshlab."""
    assert not [(m, name) for m in FILTERS for name in ours(m) if part(name) != "filters"]
    assert not [m for m in FILTERS if "pymeshlab" in {name.split(".")[0] for name in imports(m)}]


def test_plugins_know_the_vocabulary_and_the_mathematics() -> None:
    """A plugin imports declarations, errors and filters, as a third party's would."""
    assert not [(m, name) for m in PLUGINS for name in ours(m) if part(name) not in PLUGINS_MAY_IMPORT]


def test_only_the_parts_next_to_meshlab_import_pymeshlab() -> None:
    """Whoever wants a mesh asks the layer or the mesh set."""
    found = {part(m) for m in MODULES if "pymeshlab" in {name.split(".")[0] for name in imports(m)}}
    assert found == TOUCH_PYMESHLAB


def test_nothing_but_a_worker_loads_meshlab() -> None:
    """What a command loads before its worker starts has no MeshLab in it: a crash there would take the command along."""
    program = (
        "import sys, pymeshfair, pymeshfair.commands.app, pymeshfair.running.supervise\n"
        "from pymeshfair import recipe, registry\n"
        "registry.all_filters(), [recipe.load_recipe(name) for name in recipe.shipped_recipes()]\n"
        "sys.exit('pymeshlab' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], timeout=60).returncode == 0


def test_host_never_names_a_plugin() -> None:
    """The host finds plugins through entry points: no text of its own holds the name of one, imports included."""
    names = "|".join(m.removeprefix("pymeshfair.plugins.") for m in PLUGINS if m != "pymeshfair.plugins")
    assert not [m for m in HOST if re.search(rf"\bplugins[./]({names})\b", MODULES[m].read_text("utf-8"))]


#: the parts of the host that leave files for users, and none for themselves
WRITING = {"authoring", "commands", "looking", "meshset", "recipe", "report", "scripts"}


def test_files_are_written_by_one_module() -> None:
    """What a command leaves is written by `files.writing`, which says what may be replaced; no command opens a file to write."""
    writes = r"""write_text\(|write_bytes\(|open\([^)]*["'][wxa]|shutil\.copy|NamedTemporaryFile|mkstemp"""
    modules = [m for m in HOST if part(m) in WRITING and not m.endswith(".streams")]
    assert not [m for m in modules if re.search(writes, MODULES[m].read_text("utf-8"))]


def test_contributing_lists_the_floors() -> None:
    """CONTRIBUTING.md tells the order of imports in the host as it is held here, from the top down."""
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    (row,) = [line for line in text.splitlines() if line.startswith("| `src/pymeshfair/` |")]
    told = row.split("|")[3].partition("downwards only: ")[2].strip()
    assert told == ", ".join(" and ".join(f"`{name}`" for name in sorted(floor)) for floor in reversed(FLOORS[:-1]))


#: families whose lines are not compared yet
NOT_COMPARED = {"choosing", "compilation", "denoising", "evidence", "inspection", "traits"}


def test_no_run_of_lines_stands_twice() -> None:
    """What two places need is written once: no eight lines in a row but blank ones and imports are the same."""
    seen: dict[tuple[str, ...], str] = {}
    filters = [m for m in FILTERS if m.removeprefix("pymeshfair.filters.").split(".")[0] not in NOT_COMPARED]
    for module in (*HOST, *PLUGINS, *filters):
        text = MODULES[module].read_text("utf-8")
        imports = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import | ast.ImportFrom)]
        of_imports = {n for node in imports for n in range(node.lineno, (node.end_lineno or 0) + 1)}
        lines = [(n, line.strip()) for n, line in enumerate(text.splitlines(), 1) if line.strip() and n not in of_imports]
        for start in range(len(lines) - SAME_LINES + 1):
            run = tuple(line for _, line in lines[start : start + SAME_LINES])
            place = f"{module}:{lines[start][0]}"
            assert run not in seen, f"{place} repeats {seen[run]}"
            seen[run] = place


def test_every_error_of_ours_is_a_pymeshfair_error() -> None:
    """Whoever catches `PymeshfairError` catches every exception that is not private to its module."""
    kinds = []
    for module in (*HOST, *FILTERS):
        for node in ast.parse(MODULES[module].read_text("utf-8")).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                kind = getattr(importlib.import_module(module), node.name, None) if node.bases else None
                if isinstance(kind, type) and issubclass(kind, Exception):
                    kinds.append(kind)
    assert len(kinds) > 15
    assert not [kind for kind in kinds if not issubclass(kind, PymeshfairError)]


def test_the_host_raises_errors_of_its_own() -> None:
    """No error leaves the host as a bare exception of Python's, but for the one that Python asks of attributes."""
    raised = {
        (module, node.exc.func.id)
        for module in HOST
        for node in ast.walk(ast.parse(MODULES[module].read_text("utf-8")))
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and isinstance(node.exc.func, ast.Name)
    }
    assert not [(m, name) for m, name in raised if name in set(dir(builtins)) - {"AttributeError"}]


def test_no_module_is_a_drawer() -> None:
    """A module is named after what it does."""
    drawers = {"utils", "util", "helpers", "helper", "common", "misc"}
    assert not [m for m in MODULES if drawers & {name.strip("_") for name in m.split(".")}]


def test_every_module_says_what_it_is() -> None:
    """A module that holds anything begins with a docstring."""
    trees = {m: ast.parse(path.read_text("utf-8")) for m, path in MODULES.items()}
    assert not [m for m, tree in trees.items() if tree.body and not ast.get_docstring(tree)]


def test_every_plugin_loads() -> None:
    """Each of our entry points names a module that loads, and each of its filters was taken."""
    assert broken_plugins() == ()


def test_every_filter_explains_itself() -> None:
    """A filter has a summary, and every parameter a label and a help text that is a sentence."""
    assert not [declared.python_name for declared in custom_filters() if not declared.summary.endswith(".")]
    parameters = [(declared.python_name, p) for declared in custom_filters() for p in declared.parameters]
    assert not [(name, p.name) for name, p in parameters if not p.label or not p.help.endswith(".")]


def test_every_reference_is_in_the_bibliography() -> None:
    """Each key that a declaration or a docstring cites stands in the one bibliography."""
    known = set(re.findall(r"^@\w+\{([^,\s]+),", (ROOT / "docs/bibliography.bib").read_text("utf-8"), re.MULTILINE))
    cited = {key for declared in custom_filters() for key in declared.references}
    for path in MODULES.values():
        cited |= set(re.findall(r"\[([a-z]+[12]\d{3}[a-z]?)\]", path.read_text("utf-8")))
    assert cited
    assert cited <= known, f"not in docs/bibliography.bib: {sorted(cited - known)}"
